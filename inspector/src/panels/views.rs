//! What `shot` draws, by name: the window, a panel as it is at first, or the scene with some settings.

use super::PANELS;

/// A picture that has a name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    /// The panel that is drawn; all of the window if `None`.
    pub(crate) panel: Option<&'static str>,
    /// How it differs from what the panel shows at first, as `shot --set` takes it.
    pub(crate) settings: &'static [&'static str],
}

/// A picture of the scene that answers a question: a button above it, and a view of its name.
pub(crate) struct Preset {
    /// Its name.
    pub(crate) name: &'static str,
    /// What is written on the button.
    pub(crate) title: &'static str,
    /// The question.
    pub(crate) about: &'static str,
    /// How it differs from what the scene shows at first.
    pub(crate) settings: &'static [&'static str],
}

/// The pictures of the scene. Capsules and cells are larger than rooms, so they are seen from outside.
pub(crate) const PRESETS: [Preset; 5] = [
    Preset {
        name: "order",
        title: "Order",
        about: "How does each order go through the scene, and where does it jump?",
        settings: &["side_by_side=true"],
    },
    Preset {
        name: "capsules",
        title: "Capsules",
        about: "How much space do the rays take that are traced together?",
        settings: &[
            "side_by_side=true",
            "curve=false",
            "capsules=true",
            "capsule_choice=spread",
            "mesh=ghost",
            "stand_point=overview",
        ],
    },
    Preset {
        name: "cost",
        title: "Cost",
        about: "Which rays and surfaces cost most?",
        settings: &["curve=false", "ends=true", "detail=200000", "colour_by=nodes", "near_mean=true"],
    },
    Preset {
        name: "table",
        title: "Table",
        about: "Which lengths does the table expect, and where?",
        settings: &["curve=false", "cells=true", "mesh=ghost", "stand_point=overview"],
    },
    Preset {
        name: "paths",
        title: "Paths",
        about: "Where does a path go, through all bounces and to the lights?",
        settings: &["curve=false", "path=true", "mesh=ghost", "stand_point=path"],
    },
];

/// Views that are neither a preset nor a panel of their name as it is at first.
const NAMED: [View; 5] = [
    View { name: "window", panel: None, settings: &[] },
    View::of("rays", "scene", &["curve=false", "rays=true", "ends=true"]),
    View::of(
        "boxes",
        "scene",
        &["side_by_side=true", "curve=false", "visits=group", "mesh=ghost", "stand_point=overview"],
    ),
    View::of(
        "group-paths",
        "scene",
        &["curve=false", "path=true", "path_group=true", "mesh=ghost", "stand_point=path"],
    ),
    View::of("rays-table", "rays", &[]),
];

impl View {
    const fn of(name: &'static str, panel: &'static str, settings: &'static [&'static str]) -> Self {
        Self { name, panel: Some(panel), settings }
    }

    /// All views: every panel has one.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let is_named = |panel: &str| NAMED.iter().any(|view| view.panel == Some(panel));
        let others = PANELS.iter().filter(move |entry| !is_named(entry.name));
        let presets = PRESETS.iter().map(|preset| Self::of(preset.name, "scene", preset.settings));
        let [window, named @ ..] = NAMED;
        std::iter::once(window)
            .chain(presets)
            .chain(named)
            .chain(others.map(|entry| Self::of(entry.name, entry.name, &[])))
    }

    /// The view that shows a panel as it is, or all of the `window`.
    pub(crate) fn of_panel(panel: &str) -> Option<Self> {
        Self::all().find(|view| view.panel.unwrap_or(view.name) == panel)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_panel_has_a_view_and_every_view_a_name_of_its_own() {
        let names: BTreeSet<&str> = View::all().map(|view| view.name).collect();
        assert_eq!(names.len(), View::all().count());
        for entry in PANELS {
            assert!(View::of_panel(entry.name).is_some(), "{}", entry.name);
        }
        assert_eq!(View::of_panel("window").map(|view| view.name), Some("window"));
    }
}
