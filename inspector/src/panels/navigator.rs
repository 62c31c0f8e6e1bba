//! Which recording, pass, bounce, kind and order is selected.

use std::collections::BTreeSet;

use formats::manifest::QueueId;
use formats::ray::Kind;

use super::notes::group_widths;
use crate::model::Context;
use crate::model::what_if::WHAT_IF;
use crate::output::{count, counted};
use crate::panels::panel::Panel;
use crate::shown;

pub(super) struct Navigator;

impl Panel for Navigator {
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context) {
        egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            recordings(ui, context);
            if context.recording().is_none() {
                return;
            }
            facts(ui, context);
            ui.separator();
            queue(ui, context);
            ui.separator();
            orders(ui, context);
            ui.separator();
            ui.horizontal_wrapped(|ui| group_widths(ui, "Group", context));
        });
    }
}

fn recordings(ui: &mut egui::Ui, context: &mut Context) {
    if context.recordings.is_empty() {
        ui.label("Drop a folder NAME.raydump here, or open one with File > Open.");
        return;
    }
    let mut chosen = context.selection.recording;
    for (at, recording) in context.recordings.iter().enumerate() {
        ui.selectable_value(&mut chosen, at, &recording.label)
            .on_hover_text(recording.dump.root().display().to_string());
    }
    if chosen != context.selection.recording {
        context.select_recording(chosen);
    }
}

fn facts(ui: &mut egui::Ui, context: &Context) {
    let Some(recording) = context.recording() else { return };
    let header = &recording.shown;
    let options = &header.options;
    let size = match recording.is_imported() {
        true => "imported rays".to_owned(),
        false => format!("{} x {}", options.width, options.height),
    };
    let size = format!("{size}, {}-bit keys", options.key_bits);
    let triangles = format!("{} triangles, {}", count(header.scene.triangles), options.trace_kernel);
    for fact in [size, triangles, header.adapter.name.clone()] {
        ui.add(egui::Label::new(egui::RichText::new(fact).small().weak()).truncate());
    }
}

fn queue(ui: &mut egui::Ui, context: &mut Context) {
    let Some(recording) = context.recording() else { return };
    let ids = || recording.queues().iter().map(|record| record.id);
    let now = context.selection.queue;
    let passes: BTreeSet<u32> = ids().map(|id| id.pass).collect();
    let bounces: BTreeSet<u32> = ids().map(|id| id.bounce).collect();
    let mut next = now;
    let mut row = |name: &str, choices: Vec<(String, QueueId)>| {
        ui.horizontal_wrapped(|ui| {
            ui.label(name);
            for (text, choice) in choices {
                let button = egui::Button::selectable(choice == now, text);
                if ui.add_enabled(recording.queue(choice).is_some(), button).clicked() {
                    next = choice;
                }
            }
        });
    };
    row("Pass", passes.into_iter().map(|pass| (pass.to_string(), QueueId { pass, ..now })).collect());
    row(
        "Bounce",
        bounces.into_iter().map(|bounce| (bounce.to_string(), QueueId { bounce, ..now })).collect(),
    );
    row(
        "Kind",
        Kind::ALL.into_iter().map(|kind| (kind.name().to_owned(), QueueId { kind, ..now })).collect(),
    );
    ui.label(counted(recording.queue(now).map_or(0, |record| record.rays), "ray", "rays"));
    if next != now {
        context.go_to(next);
    }
}

fn orders(ui: &mut egui::Ui, context: &mut Context) {
    ui.label(egui::RichText::new("Order").strong())
        .on_hover_text("A method makes a key of each ray; rays are sorted by it, ties in pixel order");
    let Some(recording) = context.recording() else { return };
    let is_measured = !recording.methods(context.selection.queue).is_empty();
    let methods = context.methods();
    if !is_measured {
        ui.label("No method was measured on these rays.");
    }
    for method in &methods {
        let layout = context.recording().and_then(|recording| recording.method(method));
        let made =
            context.what_if.as_ref().filter(|_| method == WHAT_IF).map(|settings| settings.text.clone());
        let about = layout.map(|record| shown::name(&record.text)).or(made);
        let about = about.unwrap_or_else(|| "canonical order: by pixel".to_owned());
        let is_now = context.selection.method == *method;
        if ui.selectable_label(is_now, method).on_hover_text(about).clicked() {
            context.order_by(method);
        }
    }
}
