//! The whole frame in a screen: a row a method, its times summed over bounces round by round, and what they mean.
//!
//! What `recorder demo`, `record`, `replay` and `inspector info` end in.

use std::collections::BTreeSet;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::noise::Noise;
use super::samples::Samples;
use super::speedup::{Speedup, Verdict, median};
use crate::key::Termination;
use crate::key::method::{AUTO, CONTROL, SHUFFLED, UNSORTED};
use crate::manifest::{LEFT_ALONE, Manifest, QueueId};
use crate::ray::Kind;
use crate::text::{counted, one_line, wrapped};

/// Columns of a terminal.
pub const COLUMNS: usize = 80;
/// Most methods that are shown.
const MOST_ROWS: usize = 12;
/// Characters of the longest name.
const NAME: usize = 19;
/// Characters of the longest name in a sentence.
const LONG_NAME: usize = 60;

/// One method over all bounces. Camera rays, which lie as the picture does, do not count.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameRow {
    /// Its name.
    pub method: String,
    /// Unsorted trace over trace in its order, closest rays of bounces ≥ 1; `None` if it orders none of them.
    pub secondary: Option<Speedup>,
    /// The same of shadow rays.
    pub shadow: Option<Speedup>,
    /// Unsorted trace over all stages, closest rays of bounces ≥ 1; `None` if it orders none of them, or not all
    /// stages are known.
    pub net_secondary: Option<Speedup>,
    /// The same of shadow rays.
    pub net_shadow: Option<Speedup>,
    /// The same of both kinds together, those that it does not order left unsorted.
    pub net: Option<Speedup>,
    /// In a word or three.
    pub verdict: &'static str,
}

/// The methods of a recording over all bounces.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Frame {
    /// Million unsorted rays a second: secondary, shadow.
    #[serde(rename = "unsorted_mrays_per_second")]
    pub unsorted: [Option<f64>; 2],
    /// How far the control is from a speedup of 1, secondary and shadow rays; 0 without a control. What is said of both
    /// together must exceed the larger.
    pub instrument_errors: [f64; 2],
    /// What disturbed the times.
    pub noise: Noise,
    /// The methods, the best net speedup first; then those without one.
    pub rows: Vec<FrameRow>,
}

/// Times of a method on one kind of rays, those of all bounces summed, nanoseconds, one number a round. Camera rays
/// do not count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameTimes {
    /// The kind; closest rays are those of bounces ≥ 1.
    pub kind: Kind,
    /// The method.
    pub method: String,
    /// Unsorted trace of the queues that the method orders.
    pub unsorted_ns: Vec<u64>,
    /// Trace in its order.
    pub traced_ns: Vec<u64>,
    /// All stages; empty if what the order costs is not known, as of a control.
    pub total_ns: Vec<u64>,
}

fn counts(queue: QueueId) -> bool {
    queue.kind == Kind::Shadow || queue.bounce > 0
}

impl FrameTimes {
    /// Every method but unsorted, those that the recording names first, each with both kinds together.
    pub fn all(manifest: &Manifest) -> Vec<Self> {
        let samples = Samples::of(manifest);
        let orders = || samples.orders().filter(|(queue, _)| counts(*queue));
        let mut methods: Vec<&str> = manifest.methods.iter().map(|record| record.name.as_str()).collect();
        for (_, method) in orders() {
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        methods.retain(|method| *method != UNSORTED);
        let costs = Costs::of(manifest);
        let kinds = methods.into_iter().flat_map(|method| Kind::ALL.map(|kind| (method, kind)));
        kinds.filter_map(|(method, kind)| Self::of(&costs, &samples, kind, method)).collect()
    }

    fn of<'a>(costs: &Costs<'_>, samples: &Samples<'a>, kind: Kind, method: &'a str) -> Option<Self> {
        let queues: Vec<QueueId> = samples
            .orders()
            .filter(|(queue, order)| counts(*queue) && queue.kind == kind && *order == method)
            .map(|(queue, _)| queue)
            .collect();
        let unsorted: Option<Vec<&[u64]>> =
            queues.iter().map(|queue| Some(samples.get(*queue, UNSORTED)?.traced())).collect();
        let own = queues.iter().filter_map(|queue| Some((*queue, samples.get(*queue, method)?)));
        let is_known = costs.remark(method).is_none();
        let totals: Vec<Vec<u64>> = own
            .clone()
            .filter(|_| is_known)
            .map(|(queue, own)| own.totals(samples.way(queue, method)))
            .collect();
        (!queues.is_empty()).then_some(Self {
            kind,
            method: method.to_owned(),
            unsorted_ns: summed(unsorted?),
            traced_ns: summed(own.map(|(_, own)| own.traced())),
            total_ns: summed(totals.iter().map(Vec::as_slice)),
        })
    }

    /// Unsorted trace over trace in this order; `None` without a round.
    pub fn trace(&self) -> Option<Speedup> {
        Speedup::of(&self.unsorted_ns, &self.traced_ns)
    }
}

/// Methods of which nobody knows what they cost, by name.
pub(super) struct Costs<'a> {
    /// Those that sort by lengths which only a trace gives.
    bounds: BTreeSet<&'a str>,
    /// Those of another tracer.
    foreign: BTreeSet<&'a str>,
}

impl<'a> Costs<'a> {
    pub(super) fn of(manifest: &'a Manifest) -> Self {
        let bounds = manifest.methods.iter().filter(|record| record.termination == Termination::Real);
        Self {
            bounds: bounds.map(|record| record.name.as_str()).collect(),
            foreign: manifest.foreign_orders().map(|record| record.name.as_str()).collect(),
        }
    }

    /// Why a method has no net speedup, if it has none.
    pub(super) fn remark(&self, method: &str) -> Option<&'static str> {
        if self.bounds.contains(method) {
            return Some("bound");
        }
        match method {
            CONTROL => return Some("1 is right"),
            // No key is made for it and nothing is sorted.
            SHUFFLED => return Some("random"),
            _ => {}
        }
        self.foreign.contains(method).then_some("no key time")
    }
}

/// Whether a method is `auto` and left all rays alone that count, so that its times are those of no order.
pub fn leaves_all_alone(manifest: &Manifest, method: &str) -> bool {
    Kind::ALL.iter().all(|kind| leaves_alone(manifest, method, *kind))
}

/// Whether `auto` left all rays of this kind alone that count.
fn leaves_alone(manifest: &Manifest, method: &str, kind: Kind) -> bool {
    let mut decisions = manifest.decisions.iter();
    let is_chosen = decisions.any(|one| one.queue.kind == kind && counts(one.queue) && one.choice.is_some());
    method == AUTO && !is_chosen
}

/// Unsorted trace over all stages of a method, of all rays of some kinds that count: a queue that it does not order
/// stays unsorted.
fn net(manifest: &Manifest, samples: &Samples<'_>, method: &str, kinds: &[Kind]) -> Option<Speedup> {
    let queues = manifest.queues.iter().map(|queue| queue.id);
    let queues = queues.filter(|queue| counts(*queue) && kinds.contains(&queue.kind));
    let timed = queues.filter_map(|queue| Some((queue, samples.get(queue, UNSORTED)?.traced())));
    let totals = timed.clone().map(|(queue, unsorted)| match samples.get(queue, method) {
        Some(own) => own.totals(samples.way(queue, method)),
        None => unsorted.to_vec(),
    });
    let totals: Vec<Vec<u64>> = totals.collect();
    Speedup::of(&summed(timed.map(|(_, unsorted)| unsorted)), &summed(totals.iter().map(Vec::as_slice)))
}

/// Times of several queues added up round by round, as many rounds as all of them have, nanoseconds.
pub fn summed<'t>(times: impl IntoIterator<Item = &'t [u64]>) -> Vec<u64> {
    let add =
        |sums: Vec<u64>, time: &[u64]| sums.iter().zip(time).map(|(a, b)| a.saturating_add(*b)).collect();
    let mut times = times.into_iter();
    let first = times.next().unwrap_or(&[]).to_vec();
    times.fold(first, add)
}

impl Frame {
    /// Of a recording; without rows if nothing but unsorted rays was measured.
    pub fn of(manifest: &Manifest) -> Self {
        let samples = Samples::of(manifest);
        let unsorted = Kind::ALL.map(|kind| {
            let own = manifest.queues.iter().filter(|queue| queue.id.kind == kind && counts(queue.id));
            let timed: Vec<(u64, &[u64])> = own
                .filter_map(|queue| Some((queue.rays, samples.get(queue.id, UNSORTED)?.traced())))
                .collect();
            let rays = timed.iter().fold(0u64, |sum, (rays, _)| sum.saturating_add(*rays));
            let ns = median(&summed(timed.iter().map(|(_, traced)| *traced)))?;
            (rays > 0).then(|| rays as f64 / ns.max(1.0) * 1e3)
        });
        let times = FrameTimes::all(manifest);
        let costs = Costs::of(manifest);
        let errors = Kind::ALL.map(|kind| error_of(&times, kind));
        let error = larger(errors);
        let methods = times.chunk_by(|a, b| a.method == b.method);
        let row = |both: &[FrameTimes]| {
            let method = both[0].method.as_str();
            let ordered = both.iter().filter(|times| !leaves_alone(manifest, method, times.kind));
            let ordered: Vec<&FrameTimes> = ordered.collect();
            let of = |kind: Kind| ordered.iter().find(|times| times.kind == kind);
            let trace = |kind: Kind| of(kind).and_then(|times| times.trace());
            let remark = costs.remark(method);
            let net = |kinds: &[Kind]| match remark {
                Some(_) => None,
                None => net(manifest, &samples, method, kinds),
            };
            let net_of = |kind: Kind| of(kind).and_then(|_| net(&[kind]));
            let net = if ordered.is_empty() { None } else { net(&Kind::ALL) };
            let verdict = net.map_or("", |net| net.verdict(error).on_sorting());
            let verdict = if ordered.is_empty() { LEFT_ALONE } else { verdict };
            FrameRow {
                method: method.to_owned(),
                secondary: trace(Kind::Closest),
                shadow: trace(Kind::Shadow),
                net_secondary: net_of(Kind::Closest),
                net_shadow: net_of(Kind::Shadow),
                net,
                verdict: remark.unwrap_or(verdict),
            }
        };
        let mut rows: Vec<FrameRow> = methods.map(row).collect();
        let net = |row: &FrameRow| row.net.map_or(f64::NEG_INFINITY, |net| net.ratio);
        rows.sort_by(|a, b| net(b).total_cmp(&net(a)));
        Self { unsorted, instrument_errors: errors, noise: Noise::of(manifest), rows }
    }

    /// The table and what it means, at most [`COLUMNS`] wide and 20 lines high.
    pub fn text(&self) -> String {
        if self.rows.is_empty() {
            return "No method was measured on secondary or shadow rays, which are all that counts here."
                .to_owned();
        }
        let noise = self.noise.sentences().map(|sentence| wrapped(&sentence, COLUMNS, 0) + "\n\n");
        let mut text: String = noise.collect();
        text.push_str(
            "Whole frame: all bounces, summed per round; – left unsorted, * beyond chance.\n\
             \x20                   trace alone         net, with what sorting costs\n\
             method             secondary    shadow second. shadow    both  95 %\n",
        );
        let rate = |rate: Option<f64>| match rate {
            None => "–".to_owned(),
            Some(rate) if rate < 100.0 => format!("{rate:.2} M/s"),
            Some(rate) => format!("{rate:.0} M/s"),
        };
        let [secondary, shadow] = self.unsorted.map(rate);
        let _ = writeln!(text, "{UNSORTED:<NAME$}{secondary:>9}{shadow:>10}");
        // A control and a bound have their place however many methods there are.
        let (with_net, without): (Vec<_>, Vec<_>) = self.rows.iter().partition(|row| row.net.is_some());
        let most = MOST_ROWS.saturating_sub(without.len()).max(1);
        for row in with_net.iter().take(most).chain(&without) {
            let _ = writeln!(text, "{}", row.text(self.instrument_errors));
        }
        if with_net.len() > most {
            let _ =
                writeln!(text, "… and {} more, none of them better net (--details)", with_net.len() - most);
        }
        text.push_str(&wrapped(&self.meaning(), COLUMNS, 0));
        text
    }

    /// What the numbers mean, in a sentence: whether sorting pays, with which method, and how surely.
    pub fn meaning(&self) -> String {
        let known = || self.rows.iter().filter_map(|row| Some((row, row.net?)));
        // One that surely pays goes before one that gains more, perhaps by chance.
        let pays = known().find(|(row, _)| row.verdict == PAYS);
        let Some((best, net)) = pays.or_else(|| known().next()) else {
            let is_alone = self.rows.iter().any(|row| row.verdict == LEFT_ALONE);
            return if is_alone {
                "By its calibration sorting does not pay here: auto left all of these rays alone."
            } else {
                "Nothing says what sorting costs here: no method with a net speedup was measured."
            }
            .to_owned();
        };
        let name = one_line(&best.method, LONG_NAME);
        let ratio = net.ratio;
        let error = match larger(self.instrument_errors) {
            small if small < 0.005 => String::new(),
            error => {
                let rays = if error == self.instrument_errors[0] { "secondary" } else { "shadow" };
                format!("; over all bounces the control of {rays} rays is off by {:.1} %", 100.0 * error)
            }
        };
        let Some((low, high)) = net.interval else {
            let so =
                if ratio > 1.0 { "which may be chance" } else { "but nothing was faster than unsorted rays" };
            return format!(
                "The best net speedup is that of {name}, {ratio:.2}×, {so} (fewer than 6 repeats have no interval){error}."
            );
        };
        let with = |verdict: &str| known().filter(|(row, _)| row.verdict == verdict).count();
        let all = known().count();
        let error = match error.as_str() {
            "" => error,
            error => format!("{error}, which an interval must exceed"),
        };
        if best.verdict == PAYS {
            let others = match (with(PAYS) - 1, counted(all as u64 - 1, "other", "others")) {
                _ if all == 1 => String::new(),
                (0, _) => format!("; no other method is shown to pay; {}", costly(with(COSTS))),
                (too, others) => format!("; so it does with {too} of {others}; {}", costly(with(COSTS))),
            };
            let of_all = if all == 1 { String::new() } else { format!(", one of {all} methods,") };
            format!(
                "Sorting pays: with {name}{of_all} these rays are done {ratio:.2} times as fast, key, sort and all included{others}{error}."
            )
        } else if best.verdict == COSTS {
            format!("Sorting does not pay: even {name} takes longer than it saves ({ratio:.2}×).")
        } else {
            let others = match all {
                1 => name.clone(),
                _ => format!("the best of {all} methods, {name},"),
            };
            format!(
                "Sorting is not shown to pay: {others} cannot be told from unsorted rays ({ratio:.2}×, {low:.2} to {high:.2}){error}; {}.{}",
                costly(with(COSTS)),
                self.of_one_kind()
            )
        }
    }

    /// Where sorting does not pay over the frame: the kind of rays of which alone it does, if there is one.
    fn of_one_kind(&self) -> String {
        let [of_secondary, of_shadow] = self.instrument_errors;
        let best = |name: &str, error: f64, net: fn(&FrameRow) -> Option<Speedup>| {
            let nets = self.rows.iter().filter_map(|row| Some((row, net(row)?)));
            let sure = nets.filter(|(_, net)| net.verdict(error) == Verdict::Faster);
            let (row, Speedup { ratio, interval }) =
                sure.max_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio))?;
            let (low, high) = interval?;
            let method = one_line(&row.method, LONG_NAME);
            Some(format!(" Of {name} rays alone it pays: {ratio:.2}× by {method}, {low:.2} to {high:.2}."))
        };
        let kinds = [
            best("secondary", of_secondary, |row| row.net_secondary),
            best("shadow", of_shadow, |row| row.net_shadow),
        ];
        kinds.into_iter().flatten().collect()
    }
}

/// A name as the table has room for, its end in any case: variants of a sweep differ there.
pub(super) fn shortened(name: &str) -> String {
    let name = one_line(name, 2 * COLUMNS);
    let (most, characters) = (NAME - 1, name.chars().count());
    if characters <= most {
        return name;
    }
    let (head, tail) = (most / 2, most - 1 - most / 2);
    let first = name.chars().take(head);
    first.chain(['…']).chain(name.chars().skip(characters - tail)).collect()
}

/// How many methods cost more than they save.
fn costly(count: usize) -> String {
    match count {
        0 => "none surely costs more".to_owned(),
        1 => "one surely costs more".to_owned(),
        _ => format!("{count} surely cost more"),
    }
}

const PAYS: &str = Verdict::Faster.on_sorting();
const COSTS: &str = Verdict::Slower.on_sorting();

/// How far canonical order through the same stages is from a speedup of 1, on rays of this kind.
fn error_of(times: &[FrameTimes], kind: Kind) -> f64 {
    let control = times.iter().find(|times| times.method == CONTROL && times.kind == kind);
    control.and_then(FrameTimes::trace).map_or(0.0, |line| (line.ratio - 1.0).abs())
}

fn larger([a, b]: [f64; 2]) -> f64 {
    a.max(b)
}

impl FrameRow {
    /// A line; speedups are marked where they are beyond chance and the error of the instrument.
    fn text(&self, errors: [f64; 2]) -> String {
        let [of_secondary, of_shadow] = errors;
        let times = |speedup: Option<Speedup>, error: f64| {
            let Some(speedup) = speedup else { return "– ".to_owned() };
            let is_sure = matches!(speedup.verdict(error), Verdict::Faster | Verdict::Slower);
            format!("{:.2}×{}", speedup.ratio, if is_sure { "*" } else { " " })
        };
        let interval = self.net.and_then(|net| net.interval);
        let interval = interval.map_or(String::new(), |(low, high)| format!("{low:.2}–{high:.2}  "));
        format!(
            "{:<NAME$}{:>9}{:>10}{:>9}{:>7}{:>8} {interval}{}",
            shortened(&self.method),
            times(self.secondary, of_secondary),
            times(self.shadow, of_shadow),
            times(self.net_secondary, of_secondary),
            times(self.net_shadow, of_shadow),
            times(self.net, larger(errors)),
            self.verdict
        )
        .trim_end()
        .to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speedup(ratio: f64, low: f64, high: f64) -> Option<Speedup> {
        Some(Speedup { ratio, interval: Some((low, high)) })
    }

    fn frame(rows: Vec<FrameRow>) -> Frame {
        Frame { unsorted: [Some(123.456), None], instrument_errors: [0.0; 2], noise: Noise::default(), rows }
    }

    fn row(method: &str, net: Option<Speedup>, verdict: &'static str) -> FrameRow {
        let trace = speedup(1.5, 1.4, 1.6);
        FrameRow {
            method: method.into(),
            secondary: trace,
            shadow: None,
            net_secondary: net,
            net_shadow: None,
            net,
            verdict,
        }
    }

    #[test]
    fn rounds_are_summed_as_far_as_all_have_them() {
        assert_eq!(summed([&[100u64, 120, 100][..], &[10, 20]]), [110, 140]);
        assert_eq!(summed([]), [0u64; 0]);
        assert_eq!(summed([&[u64::MAX][..], &[1]]), [u64::MAX]);
    }

    #[test]
    fn a_frame_fits_a_terminal_whatever_the_names() {
        let long = "a-name-that-no-terminal-has-room-for".repeat(3);
        let mut rows: Vec<FrameRow> =
            (0..40).map(|_| row(&long, speedup(12.25, 10.75, 14.5), PAYS)).collect();
        rows.push(row(CONTROL, None, "1 is right"));
        let text = frame(rows).text();
        assert!(text.lines().count() <= 20, "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{text}");
        assert!(text.contains("… and 29 more") && text.contains("1 is right"), "{text}");
        assert!(text.contains("123 M/s"), "{text}");
    }

    #[test]
    fn what_a_control_misses_counts_by_kind_of_rays() {
        let times = |method: &str, kind, traced_ns: u64| FrameTimes {
            kind,
            method: method.into(),
            unsorted_ns: vec![100; 7],
            traced_ns: vec![traced_ns; 7],
            total_ns: Vec::new(),
        };
        let all = [
            times("aila", Kind::Closest, 50),
            times(CONTROL, Kind::Closest, 100),
            times(CONTROL, Kind::Shadow, 125),
        ];
        assert_eq!(Kind::ALL.map(|kind| error_of(&all, kind)), [0.0, 1.0 - 100.0 / 125.0]);
        assert_eq!(Kind::ALL.map(|kind| error_of(&all[..1], kind)), [0.0; 2]);
    }

    #[test]
    fn variants_of_a_sweep_are_told_apart() {
        let names = ["two-point-length-0-05", "two-point-length-0-25", "octahedron-split-12-20", "aila"];
        assert_eq!(
            names.map(shortened),
            ["two-point…gth-0-05", "two-point…gth-0-25", "octahedro…it-12-20", "aila"]
        );
    }

    #[test]
    fn the_sentence_says_what_the_best_interval_does() {
        let meaning = |net: Option<Speedup>, verdict| {
            let costly = row("costly", speedup(0.8, 0.7, 0.9), COSTS);
            frame(vec![row("aila", net, verdict), costly]).meaning()
        };
        let pays = meaning(speedup(1.25, 1.125, 1.5), PAYS);
        assert!(
            pays.starts_with("Sorting pays: with aila, one of 2 methods,") && pays.contains("1.25 times"),
            "{pays}"
        );
        assert!(pays.contains("no other method is shown to pay; one surely costs more"), "{pays}");
        let sure = row("sure", speedup(1.1, 1.05, 1.15), PAYS);
        let rows = vec![row("lucky", speedup(1.2, 0.7, 1.7), "level"), sure];
        let said = frame(rows).meaning();
        assert!(said.starts_with("Sorting pays: with sure"), "{said}");
        assert!(meaning(speedup(1.25, 0.9, 1.5), "level").starts_with("Sorting is not shown to pay"));
        assert!(meaning(speedup(0.9, 0.85, 0.95), COSTS).starts_with("Sorting does not pay"));
        let shy = Frame {
            instrument_errors: [0.016, 0.0],
            ..frame(vec![row("aila", speedup(1.02, 1.0, 1.04), "level")])
        };
        assert!(shy.meaning().contains("the control of secondary rays is off by 1.6 %"), "{}", shy.meaning());
        let few = |ratio| meaning(Some(Speedup { ratio, interval: None }), "");
        assert!(few(2.0).contains("fewer than 6 repeats") && few(2.0).contains("chance"));
        assert!(few(0.9).contains("nothing was faster"));
        // What the window shows of it ends at a semicolon.
        assert!(!few(2.0).contains(';'), "{}", few(2.0));
        let rough = row("aila", Some(Speedup { ratio: 1.1, interval: None }), "");
        let rough = Frame { instrument_errors: [0.0, 0.58], ..frame(vec![rough]) };
        assert!(
            rough
                .meaning()
                .ends_with("no interval); over all bounces the control of shadow rays is off by 58.0 %.")
        );
        let alone = FrameRow { secondary: None, ..row("auto", None, LEFT_ALONE) };
        assert!(frame(vec![alone]).meaning().contains("auto left all of these rays alone"));
    }

    #[test]
    fn what_pays_on_one_kind_of_rays_alone_is_said_and_marked() {
        let mut auto = row("auto", speedup(1.04, 0.99, 1.11), "level");
        auto.net_shadow = speedup(1.12, 1.06, 1.13);
        let with = |instrument_errors| Frame { instrument_errors, ..frame(vec![auto.clone()]) };
        // What the control of the other kind is off by takes nothing away.
        let [sure, unsure] = [[0.08, 0.0], [0.0, 0.08]].map(with);
        let said = " Of shadow rays alone it pays: 1.12× by auto, 1.06 to 1.13.";
        assert_eq!([&sure, &unsure].map(|frame| frame.meaning().ends_with(said)), [true, false]);
        assert_eq!([&sure, &unsure].map(|frame| frame.text().contains("1.12×*")), [true, false]);
        assert!(!sure.text().contains("1.04×*"), "{}", sure.text());
    }
}
