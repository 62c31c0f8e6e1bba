//! What `shot` draws, by name: the window, or a panel with some settings.

/// A picture that has a name.
#[derive(Debug)]
pub(crate) struct View {
    /// Its name on the command line.
    pub(crate) name: &'static str,
    /// The panel that is drawn; all of the window if `None`.
    pub(crate) panel: Option<&'static str>,
    /// How it differs from what the panel shows at first, as `shot --set` takes it.
    pub(crate) settings: &'static [&'static str],
}

impl View {
    const fn of(name: &'static str, panel: &'static str, settings: &'static [&'static str]) -> Self {
        Self { name, panel: Some(panel), settings }
    }

    /// The view of this name.
    pub(crate) fn of_name(name: &str) -> Option<&'static Self> {
        VIEWS.iter().find(|view| view.name == name)
    }

    /// The view that shows a panel as it is, or all of the `window`.
    pub(crate) fn of_panel(panel: &str) -> Option<&'static Self> {
        VIEWS.iter().find(|view| view.panel.unwrap_or(view.name) == panel)
    }
}

/// All views.
pub(crate) static VIEWS: [View; 15] = [
    View { name: "window", panel: None, settings: &[] },
    View::of("curve", "scene", &["capsule_choice=spread"]),
    View::of("rays", "scene", &["capsule_choice=spread", "curve=false", "rays=true", "ends=true"]),
    // Capsules are larger than rooms, so they are looked at from outside.
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
    View::of("compare", "compare", &["capsule_choice=spread"]),
    View::of("table", "table", &[]),
    View::of("order", "order", &[]),
    View::of("coherence", "coherence", &[]),
    View::of("what-if", "what-if", &[]),
    View::of("timings", "timings", &[]),
    View::of("rays-table", "rays", &[]),
    View::of("ray", "ray", &[]),
    View::of("navigator", "navigator", &[]),
    View::of("problems", "problems", &[]),
];
