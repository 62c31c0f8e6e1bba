//! Text that is typed and may be wrong, with its fault marked; the filter that all panels share.

use std::sync::Arc;

use egui::text::{LayoutJob, TextFormat};
use egui::{Stroke, TextEdit};
use formats::metrics::quantity::Quantity;

use crate::filter::{FilterError, WORDS};
use crate::model::Context;
use crate::model::derived::Filtered;
use crate::theme::Theme;

/// Characters at fault: the first one, and how many.
pub(super) type Fault = (usize, usize);

/// A line to type in, of this width. What is at fault is underlined.
pub(super) fn typed(
    ui: &mut egui::Ui,
    (name, hint): (&str, &str),
    text: &mut String,
    fault: Option<Fault>,
    width: f32,
) -> egui::Response {
    let problem = Theme::of(ui.ctx()).problem();
    let mut layouter = |ui: &egui::Ui, text: &dyn egui::TextBuffer, _: f32| -> Arc<egui::Galley> {
        let font = egui::TextStyle::Monospace.resolve(ui.style());
        let plain = TextFormat::simple(font, ui.visuals().text_color());
        let wrong = TextFormat { color: problem, underline: Stroke::new(1.5, problem), ..plain.clone() };
        let (start, length) = fault.unwrap_or((usize::MAX, 0));
        let mut job = LayoutJob::default();
        for (at, character) in text.as_str().chars().enumerate() {
            let is_wrong = at >= start && at - start < length;
            let format = if is_wrong { &wrong } else { &plain };
            job.append(character.encode_utf8(&mut [0; 4]), 0.0, format.clone());
        }
        ui.fonts_mut(|fonts| fonts.layout_job(job))
    };
    let edit = TextEdit::singleline(text).id_salt(name).hint_text(hint).desired_width(width);
    ui.add(edit.layouter(&mut layouter))
}

/// What is wrong with the filter, also where it only is for the selected order.
pub(super) fn problem(context: &mut Context) -> Option<FilterError> {
    if let Some(error) = context.selection.filter.error() {
        return Some(error.clone());
    }
    let order = context.order().ok()?;
    match context.filtered(&order) {
        Filtered::Refused(error) => Some(error),
        _ => None,
    }
}

/// The filter, to be typed into a line of this width.
pub(super) fn filter_box(ui: &mut egui::Ui, context: &mut Context, width: f32) {
    let error = problem(context);
    let mut text = context.selection.filter.text().to_owned();
    let fault = error.as_ref().map(|error| (error.start, error.length));
    let response = typed(ui, ("filter", "filter, such as length < 0.1"), &mut text, fault, width);
    let response = match &error {
        Some(error) => response.on_hover_text(error.to_string()),
        None => response.on_hover_text("Which rays are looked at, here and in the other panels"),
    };
    if response.changed() {
        context.selection.filter.set(&text);
    }
    if !text.is_empty() && ui.button("all").on_hover_text("All rays: without the filter").clicked() {
        context.selection.filter.set("");
    }
    ui.menu_button("Filter help", words).response.on_hover_text("What a filter may contain");
}

fn words(ui: &mut egui::Ui) {
    let height = (ui.ctx().content_rect().height() - 80.0).max(120.0);
    egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
        egui::Grid::new("words").num_columns(2).spacing([14.0, 2.0]).show(ui, |ui| {
            let quantities = Quantity::ALL.iter().map(|quantity| (quantity.name(), quantity.about()));
            for (word, about) in WORDS.into_iter().chain(quantities) {
                ui.monospace(word);
                ui.label(about);
                ui.end_row();
            }
        });
    });
}

/// What is wrong with the filter, if anything is, and what goes meanwhile.
pub(super) fn said(context: &mut Context) -> Option<String> {
    let error = problem(context)?.to_string();
    let filter = &context.selection.filter;
    let last = filter.in_force().filter(|_| filter.error().is_some());
    let meanwhile = last.map_or("all rays", |last| last.text());
    let stop = if error.ends_with('?') { "" } else { ";" };
    Some(format!("{error}{stop} until then: {meanwhile}"))
}

/// Says it.
pub(super) fn filter_problem(ui: &mut egui::Ui, context: &mut Context) {
    if let Some(said) = said(context) {
        let colour = Theme::of(ui.ctx()).problem();
        ui.label(egui::RichText::new(said).color(colour));
    }
}
