//! The overlay of keys and words, and the command that is shown on request.

use egui::{Align2, ScrollArea, Vec2};

use super::{App, Shown};

const KEYS: [(&str, &str); 25] = [
    ("click, Shift-click a method", "makes it order B, order A"),
    ("up, down", "makes the next better, the next worse method B"),
    ("left, right", "the bounce before, the next bounce"),
    ("escape", "closes what is on top; else nothing is selected any more"),
    ("Ctrl+Z, Alt+left", "the selection before"),
    ("Ctrl+Shift+Z, Alt+right", "the selection after"),
    ("Ctrl+O, Ctrl+S", "open a recording, save the session"),
    ("F5", "read the recording again, as when it is still being written"),
    ("?", "this"),
    ("", ""),
    ("click", "choose the ray, row, pixel or cell under the pointer"),
    ("Ctrl-click", "adds a ray to those that are selected, or takes it away"),
    ("drag", "orbit, or look around in fly mode; with shift or the middle button, move"),
    ("drag right", "look around"),
    (
        "wheel",
        "nearer, farther; enlarges pixels and the table, which dragging moves and a double click shows whole",
    ),
    ("W A S D Q E", "fly, over the scene; with shift, four times as fast"),
    ("G", "fly mode: dragging turns the head"),
    ("F", "frame what is selected, or the scene"),
    ("C, R", "the recording's camera, an overview"),
    ("space", "moves the playhead along the order"),
    ("", ""),
    ("drag along a chart", "rays in that range alone pass the filter; a click: all of them again"),
    ("drag the colour bar's ends", "the range of values that colours tell apart"),
    ("double click it", "back to percentiles"),
    ("... in a panel's corner", "its picture, its data, its command, its figures for a paper"),
];

/// Words that panels use, a sentence each.
const WORDS: [(&str, &str); 15] = [
    ("A, B", "The two orders that are held against each other; panels show B."),
    ("queue", "The rays of one pass, bounce and kind: what is sorted and traced together."),
    ("canonical order", "The order of pixels, in which rays are before they are sorted."),
    ("key", "The bits by which rays are sorted: coordinates of the ray, interleaved."),
    ("place", "Where a ray stands in an order, from 0."),
    ("group", "32, 64 or 128 rays that follow each other in an order: what a GPU traces together."),
    ("capsule", "The hull of a sphere around a group's origins and one around its ends."),
    ("direction spread", "1 - |sum of directions| / n of a group: 0 if all rays are parallel."),
    ("SIMD utilisation", "The share of a warp's 32 lanes that work while the slowest of them does. A model."),
    ("hit point", "Where a ray ended: at a surface, or where it left the scene."),
    ("playhead", "The place of the order up to which rays are shown."),
    ("length table", "Mean traced lengths of the rays of each cell: a new ray's estimated length."),
    ("trace speedup", "The time to trace unsorted rays over the time to trace sorted ones."),
    ("net speedup", "The same with the time that sorting itself takes."),
    ("unit space", "The scene moved and scaled so that its largest side is 1."),
];

impl App {
    pub(super) fn help(&mut self, ui: &egui::Ui) {
        let height = (ui.ctx().content_rect().height() - 120.0).max(120.0);
        egui::Window::new("Keys and words").open(&mut self.is_help_open).resizable(false).show(
            ui.ctx(),
            |ui| {
                ScrollArea::vertical().max_height(height).show(ui, |ui| {
                    ui.set_max_width(620.0);
                    for (name, lines) in [("keys", &KEYS[..]), ("words", &WORDS[..])] {
                        egui::Grid::new(name).num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
                            for (what, about) in lines {
                                ui.monospace(*what);
                                ui.label(*about);
                                ui.end_row();
                            }
                        });
                        ui.separator();
                    }
                });
            },
        );
    }

    pub(super) fn command_window(&mut self, ui: &egui::Ui) {
        let Some(Shown { said, command }) = &self.shown else { return };
        let mut is_open = true;
        egui::Window::new("The same without a window")
            .open(&mut is_open)
            .resizable(false)
            .anchor(Align2::CENTER_CENTER, Vec2::ZERO)
            .show(ui.ctx(), |ui| {
                ui.set_max_width(560.0);
                ui.weak(said);
                ui.label(egui::RichText::new(command).monospace());
                if ui.button("Copy").clicked() {
                    ui.ctx().copy_text(command.clone());
                }
            });
        if !is_open {
            self.shown = None;
        }
    }
}
