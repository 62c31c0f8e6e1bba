//! From numbers to places on an axis, and which of them are written beside it.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::model::Scale;

/// A place on an axis that is marked.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    /// The number.
    pub(crate) value: f64,
    /// What is written there; empty for a mark alone.
    pub(crate) label: String,
}

/// An axis with a range and ticks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mapping {
    /// Number at the start and at the end.
    pub(crate) range: (f64, f64),
    /// Marks, ascending.
    pub(crate) ticks: Vec<Tick>,
    is_logarithmic: bool,
}

/// Room that is left beside the outermost numbers of an axis that does not start at 0, in ranges.
const PADDING: f64 = 0.04;

impl Mapping {
    /// An axis on which all `values` have a place, with at most `room` labels. Values that the scale
    /// has no place for, such as infinities and logarithms of 0, do not count.
    pub(crate) fn new(scale: &Scale, values: impl IntoIterator<Item = f64>, room: usize) -> Self {
        let room = room.max(2);
        let is_logarithmic = matches!(scale, Scale::Logarithmic { .. } | Scale::Ratio);
        let mut are_whole = true;
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite() && (!is_logarithmic || *value > 0.0))
            .inspect(|value| are_whole &= value.fract() == 0.0)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        // There is no bounce 1.5.
        let least_step = if are_whole && low <= high { 1.0 } else { 0.0 };
        match scale {
            Scale::Linear { from_zero } => linear(low, high, *from_zero, room, least_step),
            Scale::Logarithmic { base: 10 } if low <= high && high / low < 20.0 => {
                decade(low, high).cut(low, high)
            }
            Scale::Logarithmic { base } => powers(low, high, f64::from((*base).max(2)), room).cut(low, high),
            Scale::Ratio => ratios(low, high, room),
            Scale::Marked(marks) => marked(marks, low, high, room),
            Scale::Categories(names) => categories(names),
        }
    }

    /// An axis of exactly this range.
    pub(crate) fn exact(low: f64, high: f64, room: usize) -> Self {
        let high = if high > low { high } else { low + 1.0 };
        let step = nice_step((high - low) / room.max(2) as f64);
        let first = (low / step - 1e-9).ceil();
        let last = (high / step + 1e-9).floor();
        Self { range: (low, high), ticks: steps(first, last, step), is_logarithmic: false }
    }

    /// Where a number is: 0 at the start of the axis, 1 at its end; nowhere if it has no place.
    pub(crate) fn place(&self, value: f64) -> Option<f64> {
        let (low, high) = self.range;
        if self.is_logarithmic {
            (value.is_finite() && value > 0.0).then(|| (value / low).ln() / (high / low).ln())
        } else {
            value.is_finite().then(|| (value - low) / (high - low))
        }
    }

    /// A logarithmic axis that ends beside the outermost numbers; itself if that would leave fewer than two labels.
    fn cut(self, low: f64, high: f64) -> Self {
        let padding = (high / low).powf(PADDING);
        self.inside((low / padding, high * padding))
    }

    /// What is inside of a smaller range; itself if that has fewer than two labels.
    fn inside(self, range: (f64, f64)) -> Self {
        let is_inside = |tick: &&Tick| (range.0..=range.1).contains(&tick.value);
        if self.labelled().filter(is_inside).count() < 2 {
            return self;
        }
        Self { range, ticks: self.ticks.iter().filter(is_inside).cloned().collect(), ..self }
    }

    /// The same axis from its end to its start: pictures count their rows from the top.
    pub(crate) fn reversed(self) -> Self {
        Self { range: (self.range.1, self.range.0), ..self }
    }

    /// The ticks that are labelled.
    pub(crate) fn labelled(&self) -> impl Iterator<Item = &Tick> {
        self.ticks.iter().filter(|tick| !tick.label.is_empty())
    }

    /// Where bars start: at 0, or at the lower end where there is none.
    pub(crate) fn base(&self) -> f64 {
        if self.is_logarithmic { self.range.0 } else { 0.0f64.clamp(self.range.0, self.range.1) }
    }
}

/// Labelled ticks are plotters' bold points, those between them the light ones.
impl Ranged for Mapping {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        // What has no place, such as the lower end of a spread that reaches 0, is at the start.
        let place = self.place(*value).unwrap_or(0.0);
        start + (place * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let is_light = hint.weight().allow_light_points();
        self.ticks.iter().filter(|tick| tick.label.is_empty() == is_light).map(|tick| tick.value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.0..self.range.1
    }
}

impl ValueFormatter<f64> for Mapping {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|tick| tick.value == *value).map_or(String::new(), |tick| tick.label.clone())
    }
}

fn categories(names: &[String]) -> Mapping {
    let ticks = names
        .iter()
        .enumerate()
        .map(|(at, name)| Tick { value: at as f64, label: name.clone() })
        .collect::<Vec<_>>();
    Mapping { range: (-0.5, names.len().max(1) as f64 - 0.5), ticks, is_logarithmic: false }
}

/// Steps between the marks of an axis of ratios, from the finest.
const RATIO_STEPS: [&[f64]; 5] = [
    &[1.0, 1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.35, 1.4, 1.45, 1.5, 1.6, 1.7, 1.8, 1.9],
    &[1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9],
    &[1.0, 1.2, 1.4, 1.6, 1.8],
    &[1.0, 1.5],
    &[1.0],
];

/// Marks of an axis of ratios for each label that there is room for.
const MARKS_PER_LABEL: usize = 6;

/// Steps of an axis of ratios between a half and twice, from the finest.
const EVEN_STEPS: [f64; 5] = [0.05, 0.1, 0.2, 0.25, 0.5];

/// An axis around all ratios and 1, with marks at plain ones: evenly between a half and twice, else those above 1, and
/// below 1 the same of a half, a quarter and so on. As many are labelled as there is room for, and those between them
/// marked.
fn ratios(low: f64, high: f64, room: usize) -> Mapping {
    // So that some marks beside 1 are seen, too.
    let (low, high) = (low.min(0.94), high.max(1.06));
    let padding = (high / low).powf(PADDING);
    let range = (low / padding, high * padding);
    let (first, last) = (range.0.log2().floor() as i32, range.1.log2().floor() as i32);
    let shown = |values: &mut dyn Iterator<Item = f64>| -> Vec<Tick> {
        let values = values.filter(|value| (range.0..=range.1).contains(value));
        values.map(|value| Tick { value, label: ratio_label(value) }).collect()
    };
    let of_steps = |steps: &&[f64], stride: i32| {
        let octaves = (first..=last).filter(|octave| octave.rem_euclid(stride) == 0);
        shown(&mut octaves.flat_map(|octave| steps.iter().map(move |step| step * 2f64.powi(octave))))
    };
    let even = |step: f64| {
        let reach = (1.0 / step).round() as i32;
        shown(&mut (-reach..=reach).map(|at| ((1.0 + f64::from(at) * step) * 1e6).round() / 1e6))
    };
    let is_near = range.0 >= 0.5 && range.1 <= 2.0;
    let near = EVEN_STEPS.into_iter().filter(|_| is_near).map(even);
    let fine = near.chain(RATIO_STEPS.iter().map(|steps| of_steps(steps, 1)));
    let coarse = (1..=10).map(|power| of_steps(&RATIO_STEPS[4], 1 << power));
    let labelled = fine.clone().chain(coarse).find(|ticks| ticks.len() <= room).unwrap_or_default();
    let is_between = |marks: &Vec<Tick>| {
        marks.len() <= MARKS_PER_LABEL * room && labelled.iter().all(|tick| marks.contains(tick))
    };
    let mut ticks = fine.into_iter().find(is_between).unwrap_or_else(|| labelled.clone());
    for tick in ticks.iter_mut().filter(|tick| !labelled.contains(tick)) {
        tick.label.clear();
    }
    Mapping { range, ticks, is_logarithmic: true }
}

/// A ratio as an axis has it: `½×`, `4×`.
pub(crate) fn ratio_label(value: f64) -> String {
    match 1.0 / value {
        2.0 => "½×".to_owned(),
        4.0 => "¼×".to_owned(),
        part if part > 4.0 && part < 1e6 && part.fract() == 0.0 => format!("1/{}×", number(part)),
        _ => format!("{}×", number(value)),
    }
}

/// An axis around all values, with ticks at these alone, as many of them labelled as there is room for.
fn marked(marks: &[f64], low: f64, high: f64, room: usize) -> Mapping {
    let (low, high) = marks.iter().fold((low, high), |(low, high), mark| (low.min(*mark), high.max(*mark)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    let padding = if high > low { PADDING * (high - low) } else { 0.5 };
    // Evenly, so that it is seen which are left out.
    let stride = marks.len().div_ceil(room.max(1)).max(1);
    let label = |at: usize, value| if at.is_multiple_of(stride) { number(value) } else { String::new() };
    let ticks =
        marks.iter().enumerate().map(|(at, &value)| Tick { value, label: label(at, value) }).collect();
    Mapping { range: (low - padding, high + padding), ticks, is_logarithmic: false }
}

fn linear(low: f64, high: f64, from_zero: bool, room: usize, least_step: f64) -> Mapping {
    let (mut low, mut high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    if from_zero {
        (low, high) = (low.min(0.0), high.max(0.0));
    } else if least_step > 0.0
        && high > low
        && let Some(mapping) = whole(low, high, room)
    {
        return mapping;
    }
    // Differences below the accuracy of the numbers are none.
    if high - low <= 1e-12 * low.abs().max(high.abs()) {
        let half = if low == 0.0 { 0.5 } else { 0.1 * low.abs() };
        (low, high) = (low - half, high + half);
    } else if !from_zero {
        let padding = PADDING * (high - low);
        // Padding does not lead past 0, where times and rates end.
        let stays = |padded: f64, value: f64| if padded * value < 0.0 { 0.0 } else { padded };
        (low, high) = (stays(low - padding, low), stays(high + padding, high));
    }
    let mut step = nice_step((high - low) / room as f64).max(least_step);
    if least_step > 0.0 && step.fract() != 0.0 {
        step *= 2.0;
    }
    let (first, last) = ((low / step + 1e-9).floor(), (high / step - 1e-9).ceil());
    let rounded = Mapping {
        range: (first * step, last * step),
        ticks: steps(first, last, step),
        is_logarithmic: false,
    };
    if !from_zero {
        return rounded;
    }
    // Beyond the outermost numbers there is nothing to see.
    let padding = PADDING * (high - low);
    let range = (rounded.range.0.max(low - padding), rounded.range.1.min(high + padding));
    rounded.inside(range)
}

/// An axis of whole numbers that ends beside the last one; none if fewer than two would be labelled.
fn whole(low: f64, high: f64, room: usize) -> Option<Mapping> {
    let least = nice_step((high - low) / room as f64).max(1.0);
    let step = if least.fract() == 0.0 { least } else { 2.0 * least };
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    let padding = PADDING * (high - low);
    let range = (low - padding, high + padding);
    (last > first).then(|| Mapping { range, ticks: steps(first, last, step), is_logarithmic: false })
}

/// The smallest of 1, 2, 2.5 and 5 times a power of ten that is not below `least`.
fn nice_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let fits = |factor: &f64| factor * power >= least * (1.0 - 1e-9);
    [1.0, 2.0, 2.5, 5.0].into_iter().find(fits).unwrap_or(10.0) * power
}

fn steps(first: f64, last: f64, step: f64) -> Vec<Tick> {
    let largest = first.abs().max(last.abs()) * step;
    // A few dozen at most: the room is counted before.
    let values = (0..=(last - first) as usize).map(|at| (first + at as f64) * step);
    values.map(|value| Tick { value, label: label(value, step, largest) }).collect()
}

/// A number beside an axis with this distance between labels: no digit more than tells them apart.
fn label(value: f64, step: f64, largest: f64) -> String {
    if value.abs() < step * 1e-6 {
        return "0".to_owned();
    }
    if (1e-4..1e6).contains(&largest) {
        return grouped(value, decimals(step));
    }
    let exponent = largest.log10().floor();
    let unit = 10f64.powi(exponent as i32);
    let exponent = format!("{exponent}").replace('-', "−");
    format!("{}e{exponent}", grouped(value / unit, decimals(step / unit)))
}

/// Digits after the point of a step and its multiples.
fn decimals(step: f64) -> usize {
    let is_whole = |digits: &usize| {
        let scaled = step * 10f64.powi(*digits as i32);
        (scaled - scaled.round()).abs() < 1e-6 * scaled
    };
    (0..=12).find(is_whole).unwrap_or(12)
}

/// A number with a real minus sign and its thousands apart.
fn grouped(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let (whole, fraction) = digits.split_once('.').map_or((digits.as_str(), ""), |parts| parts);
    let mut text = if value < 0.0 { "−".to_owned() } else { String::new() };
    for (at, digit) in whole.chars().enumerate() {
        if at > 0 && (whole.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if !fraction.is_empty() {
        text.push('.');
        text.push_str(fraction);
    }
    text
}

/// A number on its own, as it is written at a tick of a logarithmic axis, in a tooltip or a legend:
/// four digits.
pub(crate) fn number(value: f64) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    if value != 0.0 && !(1e-3..=1e6).contains(&value.abs()) {
        let text = format!("{value:.3e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        return format!("{mantissa}e{exponent}").replace('-', "−");
    }
    let whole_digits = value.abs().max(1.0).log10().floor() as usize + 1;
    let text = grouped(value, 4usize.saturating_sub(whole_digits).max(usize::from(whole_digits < 4)));
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

/// Less than about a decade: 1, 2, 5, 10, 20, …
fn decade(low: f64, high: f64) -> Mapping {
    let value_at =
        |place: i32| [1.0, 2.0, 5.0][place.rem_euclid(3) as usize] * 10f64.powi(place.div_euclid(3));
    let near = 3 * low.log10().floor() as i32;
    let first = (near..near + 4).rev().find(|&place| value_at(place) <= low * 1.0001).unwrap_or(near);
    let mut last = (first..).find(|&place| value_at(place) >= high * 0.9999).unwrap_or(first);
    last = last.max(first + 1);
    let range = (value_at(first), value_at(last));
    let ticks = if last == first + 1 {
        // Two numbers alone say too little: even steps between them.
        Mapping::exact(range.0, range.1, 5).ticks
    } else {
        let tick = |place| Tick { value: value_at(place), label: number(value_at(place)) };
        (first..=last).map(tick).collect()
    };
    Mapping { range, ticks, is_logarithmic: true }
}

fn powers(low: f64, high: f64, base: f64, room: usize) -> Mapping {
    let (low, high) = if low <= high { (low, high) } else { (1.0, base) };
    let power_of = |value: f64| value.ln() / base.ln();
    let mut first = (power_of(low) + 1e-9).floor() as i32;
    let mut last = (power_of(high) - 1e-9).ceil() as i32;
    if last <= first {
        // One number alone, a power itself: it stands in the middle.
        (first, last) = (first - 1, first + 1);
    }
    let stride = ((last - first) as usize).div_ceil(room).max(1) as i32;
    let mut ticks = Vec::new();
    for power in first..=last {
        let value = base.powi(power);
        let is_labelled = power.rem_euclid(stride) == 0;
        ticks.push(Tick {
            value,
            label: if is_labelled { power_label(base, power, (first, last)) } else { String::new() },
        });
        // Marks at 2 to 9 show that the axis is not an even one.
        if base == 10.0 && stride == 1 && power < last {
            ticks.extend(
                (2..10).map(|factor| Tick { value: f64::from(factor) * value, label: String::new() }),
            );
        }
    }
    Mapping { range: (base.powi(first), base.powi(last)), ticks, is_logarithmic: true }
}

/// A power, plainly if those at both ends of the axis can be written so.
fn power_label(base: f64, power: i32, (first, last): (i32, i32)) -> String {
    let is_plain = base.powi(first) >= 1e-3 && base.powi(last) <= 1e6;
    match base {
        10.0 if !is_plain => format!("1e{power}").replace('-', "−"),
        2.0 if !is_plain => format!("2^{power}").replace('-', "−"),
        _ => number(base.powi(power)),
    }
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::{BoldPoints, LightPoints};

    use super::*;

    fn labels(mapping: &Mapping) -> Vec<&str> {
        mapping.ticks.iter().map(|tick| tick.label.as_str()).filter(|label| !label.is_empty()).collect()
    }

    const EVEN: Scale = Scale::Linear { from_zero: false };
    const FROM_ZERO: Scale = Scale::Linear { from_zero: true };

    #[test]
    fn even_axes_have_round_labels() {
        assert_eq!(labels(&Mapping::new(&FROM_ZERO, [1.7], 5)), ["0", "0.5", "1.0", "1.5"]);
        assert_eq!(labels(&Mapping::new(&FROM_ZERO, [3914.0], 4)), ["0", "1,000", "2,000", "3,000", "4,000"]);
        assert_eq!(labels(&Mapping::new(&FROM_ZERO, [-0.9, 0.9], 4)), ["−0.5", "0", "0.5"]);
        assert_eq!(labels(&Mapping::new(&FROM_ZERO, [2.4e9], 3)), ["0", "1e9", "2e9"]);
        assert_eq!(labels(&Mapping::new(&FROM_ZERO, [2.4e-7], 3)), ["0", "1e−7", "2e−7"]);
        assert_eq!(labels(&Mapping::exact(0.0, 1024.0, 4)), ["0", "500", "1,000"]);
        // A share is never more than all.
        for (room, share) in (2..12).flat_map(|room| [60.0, 99.9, 100.0].map(|share| (room, share))) {
            assert!(Mapping::new(&FROM_ZERO, [share], room).range.1 <= 100.0, "{share} in {room}");
        }
    }

    #[test]
    fn marks_are_where_numbers_were_measured() {
        let marked = |room| Mapping::new(&Scale::Marked(vec![8.0, 16.0, 64.0]), [8.0, 16.0, 64.0], room);
        let mapping = marked(3);
        assert_eq!(labels(&mapping), ["8", "16", "64"]);
        assert_eq!(marked(2).ticks.len(), 3);
        assert_eq!(labels(&marked(2)), ["8", "64"]);
        assert!(mapping.range.0 < 8.0 && mapping.range.1 > 64.0);
    }

    #[test]
    fn logarithmic_axes_have_powers_and_short_ones_steps_between() {
        let ten = Scale::Logarithmic { base: 10 };
        assert_eq!(labels(&Mapping::new(&ten, [0.3, 400.0], 8)), ["1", "10", "100"]);
        assert_eq!(labels(&Mapping::new(&ten, [3.0, 3.9], 8)), ["2", "3", "4", "5"]);
        assert_eq!(labels(&Mapping::new(&ten, [1e-9, 1e9], 3)), ["1e−6", "1e0", "1e6"]);
        let two = Scale::Logarithmic { base: 2 };
        assert_eq!(labels(&Mapping::new(&two, [8.0, 60.0], 8)), ["8", "16", "32", "64"]);
        assert_eq!(labels(&Mapping::new(&two, [1048576.0, 4194304.0], 8)), ["2^20", "2^21", "2^22"]);
    }

    #[test]
    fn plotters_is_given_our_ticks_and_places() {
        let axis = Mapping::new(&Scale::Logarithmic { base: 10 }, [0.3, 40.0], 8);
        assert_eq!(axis.key_points(BoldPoints(1)), [1.0, 10.0]);
        let light = axis.key_points(LightPoints::new(1, 1));
        assert_eq!(light.len(), 7 + 8 + 3, "0.3 to 0.9, 2 to 9, 20 to 40: {light:?}");
        assert_eq!(axis.format_ext(&10.0), "10");
        let [low, one, ten, high] = [0.3, 1.0, 10.0, 40.0].map(|value| axis.map(&value, (900, 0)));
        assert!(low > 850 && high < 50, "the axis ends beside its numbers");
        assert!((low - high - ((one - ten) as f64 * (40.0f64 / 0.3).log10()) as i32).abs() <= 2);
        assert_eq!(axis.map(&0.0, (900, 0)), 900, "what has no place is at the start");
        assert_eq!(axis.clone().reversed().map(&1.0, (0, 900)), one);
    }

    #[test]
    fn ratios_are_marked_around_1() {
        let shown = |values: &[f64], room| {
            let mapping = Mapping::new(&Scale::Ratio, values.iter().copied(), room);
            labels(&mapping).join(" ")
        };
        assert_eq!(shown(&[1.0], 6), "0.95× 1× 1.05×");
        assert_eq!(shown(&[0.9, 1.32], 6), "0.9× 1× 1.1× 1.2× 1.3×");
        let few = Mapping::new(&Scale::Ratio, [0.45, 1.7], 3);
        assert_eq!(labels(&few), ["½×", "1×"]);
        let marks: Vec<f64> = few.ticks.iter().map(|tick| tick.value).collect();
        assert_eq!(marks, [0.45, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6]);
        let mapping = Mapping::new(&Scale::Ratio, [0.5, 2.0], 6);
        let [half, one, two] = [0.5, 1.0, 2.0].map(|value| mapping.place(value).unwrap());
        assert!((half + two - 2.0 * one).abs() < 1e-12, "a half is as far from 1 as twice");
    }

    #[test]
    fn every_value_is_inside_whatever_the_values() {
        let hard: [&[f64]; 9] = [
            &[],
            &[0.0],
            &[5.0],
            &[5.0, 5.0, 5.0],
            &[1e-300, 2e-300],
            &[1e12, 1e12 + 1.0],
            &[-3.0, -2.0],
            &[f64::NAN, 1.0, f64::INFINITY],
            &[1e-9, 1e9],
        ];
        let logarithmic = [2, 10].map(|base| Scale::Logarithmic { base });
        let scales = logarithmic.into_iter().chain([EVEN, FROM_ZERO, Scale::Ratio]).collect::<Vec<_>>();
        for (values, scale) in hard.iter().flat_map(|values| scales.iter().map(move |scale| (values, scale)))
        {
            let mapping = Mapping::new(scale, values.iter().copied(), 5);
            assert!(mapping.range.0 < mapping.range.1, "{values:?} {scale:?} {mapping:?}");
            let shown = labels(&mapping);
            assert!(shown.len() >= 2 && shown.len() <= 8, "{values:?} {scale:?} {shown:?}");
            for pair in shown.windows(2) {
                assert_ne!(pair[0], pair[1], "{values:?} {scale:?}");
            }
            for place in values.iter().filter_map(|&value| mapping.place(value)) {
                assert!((-1e-6..=1.0 + 1e-6).contains(&place), "{values:?} {scale:?} {mapping:?}");
            }
        }
    }

    #[test]
    fn numbers_have_four_digits() {
        let written = [0.0, 1.0, 1.63, 2.5e-7, 1234.5, 123456.0, 2e6, -0.5].map(number);
        assert_eq!(written, ["0", "1", "1.63", "2.5e−7", "1,234", "123,456", "2e6", "−0.5"]);
    }
}
