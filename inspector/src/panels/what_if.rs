//! What if the recorded rays were sorted by another method, other key bits or another layout: made at once.
//! Other panels show it like a recorded order; here is which of its bits do the work.

use egui::{DragValue, RichText};
use egui_plot::{AxisHints, Bar, BarChart, HLine, LineStyle};
use formats::key::layout::Field;
use formats::key::method::BUILTIN;
use formats::key::{Bit, Coordinate, Extent, KEY_BITS_MIN, LAYOUT_BITS, Layout, LayoutError};

use super::filter_box::typed;
use super::notes::{choose, found, legend, name_at, still};
use crate::analysis::key_bits::{KeyBit, KeyBits};
use crate::model::Context;
use crate::model::what_if::{Estimate, Settings, WHAT_IF};
use crate::output::counted;
use crate::panels::data::Data;
use crate::panels::panel::Panel;
use crate::theme::{HOLLOW, Theme};

/// Height of the chart, points.
const HEIGHT: f32 = 200.0;
/// What the name of a bit below it takes, points.
const NAME_WIDTH: f32 = 20.0;

#[derive(Default)]
pub(super) struct WhatIfPanel;

impl Panel for WhatIfPanel {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        if found(ui, context.queue()).is_none() {
            return;
        }
        let Some(extent) = context.recording().map(|open| open.dump.manifest().header.extent()) else {
            return;
        };
        let Some(mut settings) = context.what_if.clone().or_else(|| first(context)) else { return };
        egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| start_from(ui, context, &mut settings));
            let layout = edit(ui, &mut settings, extent);
            let key_bits = settings.key_bits;
            if context.selection.method == WHAT_IF && context.what_if.as_ref() != Some(&settings) {
                // Its number is that of another group in the order that will be made.
                context.selection.group = None;
            }
            context.what_if = Some(settings);
            if let Ok(layout) = layout {
                bits(ui, context, &layout, key_bits);
                ui.weak("It is a row of the table of methods: a click there makes it B, with shift A.");
            }
        });
    }

    fn data(&mut self, context: &mut Context) -> Result<Data, String> {
        let extent = context.recording().ok_or("no recording is open")?.dump.manifest().header.extent();
        let settings = context.what_if.clone().ok_or("no what-if order was made")?;
        let layout = settings.layout(extent).map_err(|error| error.message)?;
        let found = context.what_if_bits()?;
        let names = names(&layout, found.bits.len());
        let rows = found.bits.iter().zip(names).enumerate().map(|(at, (bit, name))| {
            vec![(at + 1).to_string(), name, bit.ones.to_string(), bit.mean_capsule_area.to_string()]
        });
        let rows: Vec<Vec<String>> = rows.collect();
        Ok(Data::new(&["bit", "from", "keys_with_it", "mean_capsule_area_up_to_it"], rows.into_iter()))
    }
}

/// What the panel begins with: the selected order, or else a method that is built in.
fn first(context: &Context) -> Option<Settings> {
    let recording = context.recording()?;
    let selected = recording.method(&context.selection.method).filter(|record| record.has_layout());
    let selected = selected.map(Settings::of);
    selected.or_else(|| Settings::builtin("two-point", &recording.dump.manifest().header))
}

/// Methods whose settings one may begin with: recorded ones, then those that are built in.
fn start_from(ui: &mut egui::Ui, context: &Context, settings: &mut Settings) {
    let Some(recording) = context.recording() else { return };
    let header = &recording.dump.manifest().header;
    let recorded = recording.dump.manifest().methods.iter().filter(|record| record.has_layout());
    let recorded = recorded.map(|record| (record.name.clone(), Settings::of(record)));
    let is_recorded = |name: &str| recording.method(name).is_some();
    let builtin = BUILTIN.iter().map(|(name, ..)| *name).filter(|name| !is_recorded(name));
    let builtin = builtin.filter_map(|name| Some((name.to_owned(), Settings::builtin(name, header)?)));
    let known: Vec<(String, Settings)> = recorded.chain(builtin).collect();
    let name = known.iter().find(|(_, known)| known == settings);
    let name = name.map_or("one's own".to_owned(), |(name, _)| name.clone());
    ui.label("Keys of")
        .on_hover_text("A method whose layout, bits and estimate are taken, to be changed below");
    let choices = known.into_iter().map(|(name, known)| {
        let about = known.text.clone();
        (known, name, Some(about))
    });
    choose(ui, ("keys of", &name), settings, choices);
    let range = KEY_BITS_MIN..=LAYOUT_BITS;
    ui.add(DragValue::new(&mut settings.key_bits).range(range).suffix(" bits"))
        .on_hover_text("Bits of a key, 8 to 64: as many of the layout's, from its start");
}

/// The layout as text, with what is wrong with it; and the estimate if the layout needs one.
fn edit(ui: &mut egui::Ui, settings: &mut Settings, extent: Extent) -> Result<Layout, LayoutError> {
    let fault = settings.layout(extent).err().map(|error| (error.start, error.length));
    let width = (ui.available_width() - 8.0).clamp(120.0, 560.0);
    typed(ui, ("layout", "(ox oy oz ex ey ez)*10"), &mut settings.text, fault, width).on_hover_text(
        "Where each bit comes from, the first one counts most: o origin, e estimated end, d direction, u v \
         octahedral direction, pu pv paraboloid direction, theta phi spherical direction; (…)*4 repeats, \
         hilbert(ox oy oz)*10 goes along a curve, ^ is exclusive or, @adaptive at the end says where the length is from",
    );
    let layout = settings.layout(extent);
    match &layout {
        Err(error) => {
            let text = format!("character {}: {}", error.start + 1, error.message);
            ui.add(egui::Label::new(RichText::new(text).color(Theme::of(ui.ctx()).problem())).wrap());
        }
        Ok(layout) if layout.uses(Coordinate::needs_length) => {
            ui.horizontal_wrapped(|ui| estimate(ui, settings));
        }
        Ok(_) => {}
    }
    layout
}

fn estimate(ui: &mut egui::Ui, settings: &mut Settings) {
    ui.label("Estimated length").on_hover_text("Where the length is taken from that e is estimated with");
    let said = settings.said_estimate();
    if let Some(said) = said {
        ui.label(said.name()).on_hover_text("The layout ends with it");
    } else {
        for (estimate, name, about) in Estimate::ALL {
            ui.selectable_value(&mut settings.estimate, estimate, name).on_hover_text(about);
        }
    }
    if said.unwrap_or(settings.estimate) == Estimate::Fixed {
        ui.add(DragValue::new(&mut settings.length).range(0.0..=1.75).speed(0.005))
            .on_hover_text("The length of all rays; the scene's largest side is 1");
    }
}

/// How many bits of the key come from where, each with the colour of its bars.
fn shares(ui: &mut egui::Ui, fields: &[Field]) {
    let theme = Theme::of(ui.ctx());
    ui.horizontal_wrapped(|ui| {
        for (number, field) in fields.iter().enumerate() {
            legend(ui, theme.series(number), &format!("{} of {}", field.positions.len(), field.bit));
        }
    });
}

/// What the bits are worth, in words.
fn worth(found: &KeyBits, names: &[String]) -> String {
    let all = counted(found.bits.len() as u64, "bit", "bits");
    let enough = match found.enough() {
        Some(enough) => {
            format!("{enough} of {all} give nine tenths of what all of them take from the mean capsule area")
        }
        None => format!("The {all} do not make the mean capsule area smaller"),
    };
    let bits = found.bits.iter().zip(names);
    let idle: Vec<&str> = bits.filter(|(bit, _)| found.is_idle(bit)).map(|(_, name)| name.as_str()).collect();
    match idle.len() {
        0 => format!("{enough}; each of them differs between keys."),
        n => {
            let are = if n == 1 { "is" } else { "are" };
            format!("{enough}; {n} {are} the same in all keys (hollow): {}.", idle.join(", "))
        }
    }
}

/// Which bits of the key do the work: the mean capsule area of the order by each bit and those before it.
fn bits(ui: &mut egui::Ui, context: &mut Context, layout: &Layout, key_bits: u32) {
    let fields = layout.fields(key_bits);
    shares(ui, &fields);
    let Some(found) = found(ui, context.what_if_bits()) else { return };
    let names = names(layout, found.bits.len());
    ui.label(worth(&found, &names));
    let theme = Theme::of(ui.ctx());
    let number = |at: usize| fields.iter().position(|field| layout.bits().get(at) == Some(&field.bit));
    let bar = |(at, bit): (usize, &KeyBit)| {
        let colour = number(at).map_or(theme.left_out(), |number| theme.series(number));
        let fill = if found.is_idle(bit) { HOLLOW } else { colour };
        let set = 100.0 * bit.ones as f64 / found.rays as f64;
        Bar::new(at as f64, bit.mean_capsule_area / found.unsorted_area.max(f64::MIN_POSITIVE))
            .width(0.8)
            .fill(fill)
            .stroke(egui::Stroke::new(1.0, colour))
            .name(format!("bit {}: {}, set in {set:.1} % of the keys", at + 1, names[at]))
    };
    let bars = BarChart::new("bits", found.bits.iter().enumerate().map(bar).collect());
    let below = AxisHints::new_x().label_spacing(12.0..=18.0);
    // As many names as have room.
    let step = (NAME_WIDTH * found.bits.len() as f32 / ui.available_width()).ceil().max(1.0) as f64;
    still("bits", HEIGHT)
        .include_y(0.0)
        .show_grid([false, true])
        .custom_y_axes(vec![AxisHints::new_y().label("area, unsorted = 1").label_spacing(8.0..=16.0)])
        .custom_x_axes(vec![
            below
                .formatter(move |mark, _| name_at(&names, mark.value))
                .label("keys end after this bit, the most significant first"),
        ])
        .x_grid_spacer(egui_plot::uniform_grid_spacer(move |_| [step; 3]))
        .show(ui, |plot| {
            plot.bar_chart(bars);
            plot.hline(HLine::new("unsorted", 1.0).color(theme.reference()).style(LineStyle::dashed_dense()));
        });
}

/// Where each bit comes from, in words.
fn names(layout: &Layout, bits: usize) -> Vec<String> {
    layout.bits().iter().take(bits).map(Bit::to_string).collect()
}
