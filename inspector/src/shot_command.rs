//! The `inspector shot` command that draws what is seen, to be repeated and put into a paper's notes.

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

/// The command for a panel, or for the `window`; none if no recording is open, or for an order that only a
/// session can keep. `states` are those of the
/// panels that are drawn.
pub(crate) fn of(context: &Context, panel: &str, states: &[(&str, Value)], look: &Look) -> Option<String> {
    context.recording()?;
    let view =
        VIEWS.into_iter().find(|(view, name)| *name == panel || *view == panel).map(|(view, _)| view)?;
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
        add("what-if", what_if(settings, context)?);
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

/// The layout or method that `--what-if` takes; none for settings that no option of `shot` gives.
fn what_if<'a>(settings: &'a Settings, context: &Context) -> Option<&'a str> {
    let header = &context.recording()?.dump.manifest().header;
    let name =
        Settings::builtin_names().find(|name| Settings::builtin(name, header).as_ref() == Some(settings));
    name.or((Settings::named(&settings.text, header) == *settings).then_some(settings.text.as_str()))
}

/// The state of a panel as `shot` makes it for a view.
fn usual_state(panel: &str, view: &str) -> Value {
    let Some(entry) = PANELS.iter().find(|entry| entry.name == panel) else { return Value::Null };
    // Nothing is drawn by it, so that any format will do.
    let mut made = (entry.make)(wgpu::TextureFormat::Rgba8Unorm);
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
