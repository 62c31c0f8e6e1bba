//! What if the recorded rays were sorted by another method, other key bits or another layout: made at once.
//! Other panels show it like a recorded order.

use egui::{DragValue, RichText};
use formats::key::layout::Field;
use formats::key::{Bit, Coordinate, Extent, KEY_BITS_MIN, LAYOUT_BITS, Layout, LayoutError};

use super::filter_box::typed;
use super::notes::{choose, found};
use crate::model::Context;
use crate::model::what_if::{Estimate, Settings, WHAT_IF};
use crate::panels::panel::Panel;
use crate::theme::Theme;

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
            if let Ok(layout) = &layout {
                bits(ui, layout, settings.key_bits);
            }
            if context.selection.method == WHAT_IF && context.what_if.as_ref() != Some(&settings) {
                // Its number is that of another group in the order that will be made.
                context.selection.group = None;
            }
            context.what_if = Some(settings);
            if layout.is_ok() {
                ui.weak("It is a row of the table of methods: a click there makes it B, with shift A.");
            }
        });
    }
}

/// What the panel begins with: the selected order, or else a method that is built in.
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

/// What each bit that the key has comes from.
fn bits(ui: &mut egui::Ui, layout: &Layout, key_bits: u32) {
    let theme = Theme::of(ui.ctx());
    let fields = layout.fields(key_bits);
    let number = |bit: &Bit| fields.iter().position(|field| field.bit == *bit);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for bit in layout.bits().iter().take(key_bits as usize) {
            let text = RichText::new(bit.to_string()).monospace().small();
            ui.label(text.color(theme.series_text(number(bit).unwrap_or(0))));
        }
    })
    .response
    .on_hover_text("What each bit comes from, most significant bit first");
    let share = |field: &Field| format!("{} of {}", field.positions.len(), field.bit);
    let shares: Vec<String> = fields.iter().map(share).collect();
    let unused = (key_bits as usize).saturating_sub(layout.bits().len());
    let unused = if unused > 0 { format!(", {unused} always 0") } else { String::new() };
    ui.weak(format!("bits: {}{unused}", shares.join(", ")));
}
