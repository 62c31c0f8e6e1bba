//! What the window is made of: one file each behind one trait, registered in one list.
//!
//! Panels know the [`Context`] and nothing of each other.

mod coherence;
mod compare;
pub mod data;
mod filter_box;
mod navigator;
mod order;
mod picture;
mod problems;
mod ray;
mod rays;
mod scene;
pub(crate) mod settings;
pub mod space;
mod table;
mod table_plots;
mod timings;
mod what_if;
mod worst;

use std::collections::BTreeSet;

use self::data::Data;
use self::space::{Canvas, SpaceView};
use crate::model::{Absent, Context};

/// A part of the window.
pub trait Panel {
    /// What it is called.
    fn title(&self) -> &'static str;

    /// Draws it and takes what is done to it.
    fn show(&mut self, ui: &mut egui::Ui, context: &mut Context);

    /// The numbers behind it.
    ///
    /// # Errors
    /// Why there are none.
    fn data(&mut self, _context: &mut Context) -> Result<Data, String> {
        Err("it shows no numbers of its own".to_owned())
    }

    /// What it shows besides the selection, as sessions keep it; null if there is nothing to keep.
    fn state(&self) -> serde_json::Value {
        serde_json::Value::Null
    }

    /// Takes what [`Panel::state`] gave.
    ///
    /// # Errors
    /// If that is no state of this panel.
    fn set_state(&mut self, _state: serde_json::Value) -> Result<(), serde_json::Error> {
        Ok(())
    }

    /// The view into space that it has, if it has one.
    fn space(&mut self) -> Option<&mut SpaceView> {
        None
    }
}

/// A panel in the list of all.
pub struct Entry {
    /// Name in layouts and on the command line.
    pub name: &'static str,
    /// What it shows, in a sentence without its full stop.
    pub about: &'static str,
    /// Makes it for a window.
    pub make: fn(&Canvas) -> Box<dyn Panel>,
}

/// All panels.
pub const PANELS: &[Entry] = &[
    Entry {
        name: "navigator",
        about: "which recording, pass, bounce, kind and order is looked at",
        make: |_| Box::new(navigator::Navigator),
    },
    Entry {
        name: "scene",
        about: "the scene with rays, the curve of their order, capsules and table cells",
        make: |canvas| Box::new(scene::Scene::new(canvas)),
    },
    Entry {
        name: "compare",
        about: "two orders of the same rays side by side, seen from one place",
        make: |canvas| Box::new(compare::Compare::new(canvas)),
    },
    Entry {
        name: "order",
        about: "the image plane coloured by each ray's place in the order",
        make: |_| Box::<order::OrderPanel>::default(),
    },
    Entry {
        name: "table",
        about: "the length table as a picture: fill, count and mean length of its cells",
        make: |_| Box::<table::TablePanel>::default(),
    },
    Entry {
        name: "coherence",
        about: "capsule areas of each order's groups",
        make: |_| Box::<coherence::CoherencePanel>::default(),
    },
    Entry {
        name: "what-if",
        about: "the recorded rays in another order: another method, key bits or layout",
        make: |_| Box::<what_if::WhatIfPanel>::default(),
    },
    Entry {
        name: "timings",
        about: "the stages of each method against tracing unsorted rays",
        make: |_| Box::new(timings::TimingsPanel),
    },
    Entry {
        name: "rays",
        about: "all rays of the queue in the chosen order",
        make: |_| Box::<rays::RaysPanel>::default(),
    },
    Entry {
        name: "ray",
        about: "one ray: its key field by field, its group, its path",
        make: |_| Box::<ray::RayPanel>::default(),
    },
    Entry {
        name: "problems",
        about: "what went wrong, and what to do",
        make: |_| Box::new(problems::ProblemsPanel),
    },
];

/// A name with the colour of its series before it.
fn legend(ui: &mut egui::Ui, colour: egui::Color32, name: &str) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        let (rect, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), egui::Sense::hover());
        ui.painter().rect_filled(rect, 2.0, colour);
        ui.label(name);
    });
}

/// The number of a logarithm, where it is a power of ten.
fn power_of_ten(exponent: f64) -> String {
    if (exponent - exponent.round()).abs() > 1e-6 {
        return String::new();
    }
    match exponent.round() as i32 {
        exponent @ -3..=3 => format!("{}", 10f64.powi(exponent)),
        exponent => format!("1e{exponent}"),
    }
}

/// Why something is not shown of a recording, for whoever draws without a screen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lacking(BTreeSet<String>);

impl Lacking {
    /// What was said since it was last asked for.
    pub(crate) fn take(window: &egui::Context) -> BTreeSet<String> {
        window.data_mut(|data| data.remove_temp::<Self>(egui::Id::NULL)).unwrap_or_default().0
    }

    fn note(window: &egui::Context, reason: &str) {
        window.data_mut(|data| {
            data.get_temp_mut_or_default::<Self>(egui::Id::NULL).0.insert(reason.to_owned());
        });
    }
}

/// Says why something is not shown, where it would have been.
fn missing(ui: &mut egui::Ui, absent: impl Into<Absent>) {
    match absent.into() {
        Absent::Awaited => {
            ui.add_space(8.0);
            ui.vertical_centered(|ui| {
                ui.spinner();
                ui.label("reading the recording");
            });
        }
        Absent::Impossible(reason) => {
            Lacking::note(ui.ctx(), &reason);
            hint(ui, &reason);
        }
    }
}

/// Says what to do to have something shown.
fn hint(ui: &mut egui::Ui, text: &str) {
    ui.add_space(8.0);
    ui.vertical_centered(|ui| {
        ui.label(egui::RichText::new("Nothing to show here").strong());
        ui.label(text);
    });
}
