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

/// Views that are not a panel of their name as it is at first.
const NAMED: [View; 7] = [
    View { name: "window", panel: None, settings: &[] },
    View::of("curve", "scene", &["capsule_choice=spread"]),
    View::of("rays", "scene", &["capsule_choice=spread", "curve=false", "rays=true", "ends=true"]),
    // Capsules are larger than rooms, so they are seen from outside.
    View::of(
        "capsules",
        "scene",
        &["capsule_choice=spread", "curve=false", "capsules=true", "mesh=ghost", "stand_point=overview"],
    ),
    View::of(
        "cell",
        "scene",
        &["capsule_choice=spread", "curve=false", "mesh=ghost", "stand_point=overview"],
    ),
    View::of("compare", "scene", &["capsule_choice=spread", "side_by_side=true"]),
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
        NAMED.into_iter().chain(others.map(|entry| Self::of(entry.name, entry.name, &[])))
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
