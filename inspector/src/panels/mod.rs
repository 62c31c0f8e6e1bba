//! What the window is made of: one file each behind one trait, registered in one list.
//!
//! Panels know the [`Context`](crate::model::Context) and nothing of each other.

mod brush;
mod coherence;
mod colour_bar;
pub mod data;
mod differences;
mod estimate_plot;
mod filter_box;
mod methods;
pub(crate) mod notes;
mod panel;
mod picture;
mod pixels;
mod problems;
mod ray;
mod rays;
mod scene;
pub mod space;
mod table;
mod table_fill;
mod timings;
pub(crate) mod views;
mod what_if;
mod worst;

use self::space::ViewSetup;

pub(crate) use self::notes::Lacking;
pub use self::panel::Panel;

/// A panel in the list of all.
pub struct PanelKind {
    /// Name in layouts and on the command line.
    pub name: &'static str,
    /// Name in the window.
    pub title: &'static str,
    /// What it shows, in a sentence without its full stop.
    pub about: &'static str,
    /// Figures of the catalogue that show the same on paper.
    pub figures: &'static [&'static str],
    /// Makes it for a window.
    pub make: fn(&ViewSetup) -> Box<dyn Panel>,
}

/// All panels.
pub const PANELS: &[PanelKind] = &[
    PanelKind {
        name: "scene",
        title: "Scene",
        about: "rays, the curve of their order, capsules and table cells in space; A and B side by side",
        figures: &["headline"],
        make: |setup| Box::new(scene::Scene::new(setup)),
    },
    PanelKind {
        name: "methods",
        title: "Methods",
        about: "all orders, the one that gains most first: net, trace, capsule area, SIMD utilisation",
        figures: &["net-speedup", "trace-speedup", "break-even"],
        make: |_| Box::new(methods::MethodsPanel),
    },
    PanelKind {
        name: "pixels",
        title: "Pixels",
        about: "the image plane coloured by each ray's place in the order, or its work, lanes, length, area",
        figures: &["pixel-cost"],
        make: |_| Box::<pixels::PixelsPanel>::default(),
    },
    PanelKind {
        name: "length-table",
        title: "Length table",
        about: "the length table as a picture: fill, count and mean length of its cells",
        figures: &["table-fill", "estimator-error"],
        make: |_| Box::<table::TablePanel>::default(),
    },
    PanelKind {
        name: "coherence",
        title: "Coherence",
        about: "capsule areas of each order's groups, the worst of them, and the triangles that cost most",
        figures: &["capsule-area-distribution", "capsule-area"],
        make: |_| Box::<coherence::CoherencePanel>::default(),
    },
    PanelKind {
        name: "what-if",
        title: "What if",
        about: "the recorded rays in another order: another method, key bits or layout",
        figures: &[],
        make: |_| Box::<what_if::WhatIfPanel>::default(),
    },
    PanelKind {
        name: "timings",
        title: "Timings",
        about: "the stages of each method against tracing unsorted rays",
        figures: &["overhead", "rays-per-second", "bandwidth"],
        make: |_| Box::new(timings::TimingsPanel),
    },
    PanelKind {
        name: "rays",
        title: "Rays",
        about: "all rays of the queue in the chosen order",
        figures: &[],
        make: |_| Box::<rays::RaysPanel>::default(),
    },
    PanelKind {
        name: "ray",
        title: "Ray",
        about: "one ray: its key field by field, its group, its path",
        figures: &[],
        make: |_| Box::<ray::RayPanel>::default(),
    },
    PanelKind {
        name: "problems",
        title: "Problems",
        about: "what went wrong, and what to do",
        figures: &[],
        make: |_| Box::new(problems::ProblemsPanel),
    },
];

/// The panel of a name; `None` if there is none.
pub(crate) fn of_name(name: &str) -> Option<&'static PanelKind> {
    PANELS.iter().find(|panel| panel.name == name)
}
