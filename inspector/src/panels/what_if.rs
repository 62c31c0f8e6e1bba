//! What if the recorded rays were sorted by another method, other key bits or another layout: made at once,
//! and as coherent as the table says. Other panels show it like a recorded order.

use egui::{ComboBox, DragValue, RichText};
use formats::key::layout::Field;
use formats::key::method::UNSORTED;
use formats::key::{Coordinate, KEY_BITS_MIN, LAYOUT_BITS, Layout, LayoutError};

use super::filter_box::typed;
use super::notes::{legend, missing};
use crate::analysis::{GroupWidth, Metric};
use crate::model::Context;
use crate::model::coherences::OrderCoherence;
use crate::model::what_if::{Estimate, Settings, WHAT_IF};
use crate::panels::panel::Panel;
use crate::theme::Theme;

/// The panel.
#[derive(Default)]
pub(super) struct WhatIfPanel;

impl Panel for WhatIfPanel {
    fn title(&self) -> &'static str {
        "What if"
    }

    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        let queue = match context.queue() {
            Ok(queue) => queue,
            Err(reason) => return missing(ui, &reason),
        };
        let Some(lights) = context.recording().map(|open| open.dump.manifest().header.lights.len()) else {
            return;
        };
        let Some(mut settings) = context.what_if.clone().or_else(|| first(context)) else { return };
        egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| start_from(ui, context, &mut settings));
            let layout = edit(ui, &mut settings, lights);
            if let Ok(layout) = &layout {
                bits(ui, layout, settings.key_bits);
            }
            ui.horizontal_wrapped(|ui| widths(ui, context));
            if context.selection.method == WHAT_IF && context.what_if.as_ref() != Some(&settings) {
                // Its number is that of another group in the order that will be made.
                context.selection.group = None;
            }
            context.what_if = Some(settings);
            if layout.is_ok() {
                ui.separator();
                outcome(ui, context, queue.id);
            }
        });
    }
}

/// What the panel begins with: the order that is looked at, or else a method that is built in.
fn first(context: &Context) -> Option<Settings> {
    let recording = context.recording()?;
    let selected = recording.method(&context.selection.method).map(Settings::of);
    selected.or_else(|| Settings::builtin("two-point", &recording.dump.manifest().header))
}

/// Methods whose settings one may begin with: recorded ones, then those that are built in.
fn start_from(ui: &mut egui::Ui, context: &Context, settings: &mut Settings) {
    let Some(recording) = context.recording() else { return };
    let header = &recording.dump.manifest().header;
    let recorded =
        recording.dump.manifest().methods.iter().map(|record| (record.name.clone(), Settings::of(record)));
    let is_recorded = |name: &str| recording.method(name).is_some();
    let builtin = Settings::builtin_names().filter(|name| !is_recorded(name));
    let builtin = builtin.filter_map(|name| Some((name.to_owned(), Settings::builtin(name, header)?)));
    let known: Vec<(String, Settings)> = recorded.chain(builtin).collect();
    let name = known.iter().find(|(_, known)| known == settings).map_or("one's own", |(name, _)| name);
    ui.label("Keys of")
        .on_hover_text("A method whose layout, bits and estimate are taken, to be changed below");
    ComboBox::from_id_salt("keys of").selected_text(name).show_ui(ui, |ui| {
        for (name, known) in &known {
            if ui.selectable_label(known == settings, name).on_hover_text(&known.text).clicked() {
                *settings = known.clone();
            }
        }
    });
    let range = KEY_BITS_MIN..=LAYOUT_BITS;
    ui.add(DragValue::new(&mut settings.key_bits).range(range).suffix(" bits"))
        .on_hover_text("Bits of a key, 8 to 64: as many of the layout's, from its start");
}

/// The layout as text, with what is wrong with it; and the estimate if the layout needs one.
fn edit(ui: &mut egui::Ui, settings: &mut Settings, lights: usize) -> Result<Layout, LayoutError> {
    let fault = settings.layout(lights).err().map(|error| (error.start, error.length));
    let width = (ui.available_width() - 8.0).clamp(120.0, 560.0);
    typed(ui, ("layout", "(ox oy oz ex ey ez)*10"), &mut settings.text, fault, width).on_hover_text(
        "Where each bit comes from, the first one counts most: o origin, e estimated end, d direction, u v \
         octahedral direction, theta phi spherical direction; (…)*4 repeats",
    );
    let layout = settings.layout(lights);
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
    ui.label("Length from").on_hover_text("Where the length is taken from that e is estimated with");
    for (estimate, name, about) in Estimate::ALL {
        ui.selectable_value(&mut settings.estimate, estimate, name).on_hover_text(about);
    }
    if settings.estimate == Estimate::Fixed {
        ui.add(DragValue::new(&mut settings.length).range(0.0..=1.75).speed(0.005))
            .on_hover_text("The length of all rays; the scene's largest side is 1");
    }
}

/// The coordinate of each bit that the key has.
fn bits(ui: &mut egui::Ui, layout: &Layout, key_bits: u32) {
    let theme = Theme::of(ui.ctx());
    let fields = layout.fields(key_bits);
    let number = |coordinate: Coordinate| fields.iter().position(|field| field.coordinate == coordinate);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for &coordinate in layout.bits().iter().take(key_bits as usize) {
            let text = RichText::new(coordinate.name()).monospace().small();
            ui.label(text.color(theme.series_text(number(coordinate).unwrap_or(0))));
        }
    })
    .response
    .on_hover_text("The coordinate of each bit, most significant bit first");
    let share = |field: &Field| format!("{} of {}", field.positions.len(), field.coordinate.name());
    let shares: Vec<String> = fields.iter().map(share).collect();
    let unused = (key_bits as usize).saturating_sub(layout.bits().len());
    let unused = if unused > 0 { format!(", {unused} always 0") } else { String::new() };
    ui.weak(format!("bits: {}{unused}", shares.join(", ")));
}

fn widths(ui: &mut egui::Ui, context: &mut Context) {
    ui.label("Groups of").on_hover_text("Consecutive rays of the order that a GPU traces together");
    for width in [GroupWidth::Rays32, GroupWidth::Rays64, GroupWidth::Rays128] {
        let is_now = context.selection.group_width == width;
        if ui.selectable_label(is_now, width.rays().to_string()).clicked() && !is_now {
            context.selection.group_width = width;
            context.select_ray(context.selection.ray);
        }
    }
    let is_shown = context.selection.method == WHAT_IF;
    let show = ui.selectable_label(is_shown, "show this order");
    if show.on_hover_text("Looks at this order in all panels, like at a recorded one").clicked() {
        context.selection.order_by(if is_shown { UNSORTED } else { WHAT_IF });
        context.select_ray(context.selection.ray);
    }
}

/// How coherent the order is, beside the recorded ones.
fn outcome(ui: &mut egui::Ui, context: &mut Context, queue: formats::manifest::QueueId) {
    let made = match context.what_if_coherence() {
        Ok(made) => made.cloned(),
        Err(reason) => return missing(ui, &reason),
    };
    let (at, width) = (context.selection.recording, context.selection.group_width);
    let Ok(rays) = context.queue() else { return };
    let Some(recording) = context.recordings.get(at) else { return };
    let (methods, waker) = (recording.methods(queue), context.waker().clone());
    let frame = ui.ctx().cumulative_frame_nr();
    let recorded = context.coherences.of(at, &recording.dump, (&rays, methods), width, (&waker, frame));
    table(ui, made.as_ref(), recorded, methods.len());
}

const COLUMNS: [(&str, &str); 7] = [
    ("order", "How the rays are sorted"),
    ("mean area", "Of the capsules of the groups, weighted by rays, in unit space"),
    ("of unsorted", "Mean area over that of unsorted rays"),
    ("spread", "1 - |sum of directions| / n of a group: 0 if all rays are parallel"),
    ("lanes 8", "Share of their time in which 8 lanes work that wait for each other. A model"),
    ("lanes 32", "The same for 32 lanes"),
    ("lanes 64", "The same for 64 lanes"),
];

fn table(ui: &mut egui::Ui, made: Option<&OrderCoherence>, recorded: &[OrderCoherence], all: usize) {
    let theme = Theme::of(ui.ctx());
    let unsorted = recorded.iter().find(|order| order.method == UNSORTED);
    let unsorted = unsorted.and_then(|order| order.coherence.known()).map(|known| known.mean_capsule_area);
    egui::Grid::new("what-if").striped(true).num_columns(COLUMNS.len()).spacing([16.0, 2.0]).show(ui, |ui| {
        for (name, about) in COLUMNS {
            ui.strong(name).on_hover_text(about);
        }
        ui.end_row();
        match made {
            Some(order) => {
                legend(ui, theme.selected_mark(), WHAT_IF);
                numbers(ui, order, unsorted);
            }
            None => {
                ui.spinner();
            }
        }
        ui.end_row();
        for (number, order) in recorded.iter().enumerate() {
            legend(ui, theme.series(number), &order.method);
            numbers(ui, order, unsorted);
            ui.end_row();
        }
    });
    if recorded.len() < all {
        ui.weak(format!("{} of {all} recorded orders so far", recorded.len()));
    }
}

fn numbers(ui: &mut egui::Ui, order: &OrderCoherence, unsorted: Option<f64>) {
    let OrderCoherence { coherence, lanes, .. } = order;
    let known = |of: &dyn Fn(&crate::analysis::coherence::Coherence) -> String| match coherence {
        Metric::Known(coherence) => (of(coherence), None),
        Metric::Missing { missing } => ("-".to_owned(), Some(missing.clone())),
    };
    let area = known(&|known| format!("{:.4}", known.mean_capsule_area));
    let part = known(&|known| {
        unsorted.map_or("-".to_owned(), |unsorted| format!("{:.3}", known.mean_capsule_area / unsorted))
    });
    let spread = known(&|known| format!("{:.3}", known.mean_direction_spread));
    let of_width = |width: usize| {
        let found = lanes.known().and_then(|lanes| lanes.iter().find(|lanes| lanes.width == width));
        let reason = lanes.reason().unwrap_or("no ray did any work").to_owned();
        found.map_or(("-".to_owned(), Some(reason)), |lanes| (format!("{:.3}", lanes.utilisation), None))
    };
    for (text, reason) in [area, part, spread, of_width(8), of_width(32), of_width(64)] {
        let label = ui.label(text);
        if let Some(reason) = reason {
            label.on_hover_text(reason);
        }
    }
}
