//! The `inspector shot` command that draws what is seen, to be repeated and put into a paper's notes.

use clap::ValueEnum;
use serde_json::Value;

use crate::inputs::{quoted, quoted_text};
use crate::model::what_if::{Settings, WHAT_IF};
use crate::model::{Context, Selection};
use crate::panels::PANELS;
use crate::panels::settings::{CAMERA, settings};
use crate::shot::{VIEWS, preset};

/// How large, and how dark.
pub(crate) struct Look {
    /// Pixels across and down.
    pub(crate) size: [u32; 2],
    /// Pixels to a point.
    pub(crate) scale: f32,
    pub(crate) is_light: bool,
}

/// The command for a panel, or for the `window` with its panels where they are at first; none if no recording
/// is open. `states` are those of the panels that are drawn.
pub(crate) fn of(context: &Context, panel: &str, states: &[(&str, Value)], look: &Look) -> Option<String> {
    context.recording()?;
    // The panel of rays is called like a view of the scene.
    let of_panel = VIEWS.into_iter().find(|(_, name)| *name == panel);
    let (view, _) = of_panel.or_else(|| VIEWS.into_iter().find(|(view, _)| *view == panel))?;
    let mut words = vec!["inspector shot".to_owned()];
    words.extend(context.recordings.iter().map(|open| quoted(open.dump.root())));
    let mut add = |name: &str, value: &str| words.push(format!("--{name} {}", quoted_text(value)));
    add("view", view);
    let Selection { recording, queue, method, group_width, ray, group, cell, filter } = &context.selection;
    if context.recordings.len() > 1 {
        add("recording", &recording.to_string());
    }
    add("pass", &queue.pass.to_string());
    add("bounce", &queue.bounce.to_string());
    add("kind", &queue.kind.to_string());
    if method == WHAT_IF {
        let settings = context.what_if.as_ref()?;
        for (name, value) in what_if(settings, context)? {
            add(name, &value);
        }
    } else {
        add("method", method);
    }
    add("group-width", &group_width.rays().to_string());
    for (name, value) in [("ray", *ray), ("group", *group), ("cell", cell.map(|cell| cell as usize))] {
        if let Some(value) = value {
            add(name, &value.to_string());
        }
    }
    if let Some(filter) = filter.in_force() {
        add("filter", filter.text());
    }
    let mut camera = None;
    for (name, state) in states {
        let prefix = if view == "window" { format!("{name}.") } else { String::new() };
        let usual = settings(&usual_state(name, view));
        for (setting, value) in settings(state) {
            if usual.get(&setting) != Some(&value) {
                add("set", &format!("{prefix}{setting}={}", setting_text(&value)));
            }
        }
        camera = camera.or(state.get(CAMERA).and_then(Value::as_str).map(str::to_owned));
    }
    if let Some(camera) = camera {
        add("camera", &camera);
    }
    let [width, height] = look.size;
    add("size", &format!("{width}x{height}"));
    add("scale", &look.scale.to_string());
    if look.is_light {
        words.push("--light".to_owned());
    }
    words.push(format!("--out {panel}.png"));
    Some(words.join(" "))
}

/// The options of `shot` that give a what-if order.
fn what_if(settings: &Settings, context: &Context) -> Option<Vec<(&'static str, String)>> {
    let header = &context.recording()?.dump.manifest().header;
    let is_named = |name: &&str| {
        Settings::builtin(name, header)
            .is_some_and(|named| (&named.text, named.estimate) == (&settings.text, settings.estimate))
    };
    let order = Settings::builtin_names().find(is_named).unwrap_or(&settings.text);
    let named = Settings::named(order, header);
    let mut options = vec![("what-if", order.to_owned())];
    if named.key_bits != settings.key_bits {
        options.push(("what-if-bits", settings.key_bits.to_string()));
    }
    if named.estimate != settings.estimate {
        options.push(("what-if-estimate", settings.estimate.to_possible_value()?.get_name().to_owned()));
    }
    if named.length != settings.length {
        options.push(("what-if-length", settings.length.to_string()));
    }
    Some(options)
}

/// The state of a panel as `shot` makes it for a view.
fn usual_state(panel: &str, view: &str) -> Value {
    let Some(entry) = PANELS.iter().find(|entry| entry.name == panel) else { return Value::Null };
    // Nothing is drawn by it, so that any format will do.
    let mut made = (entry.make)(&wgpu::TextureFormat::Rgba8Unorm.into());
    if let Some(space) = made.space().filter(|_| view != "window") {
        space.options = preset(view);
    }
    made.state()
}

fn setting_text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}
