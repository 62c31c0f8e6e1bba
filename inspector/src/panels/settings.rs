//! What a panel shows besides the selection, as names and values: for sessions and `shot --set`.

use std::collections::BTreeMap;

use serde_json::Value;

use super::panel::Panel;

/// Under which name the options of a view into space are kept in the state of its panel.
pub(super) const OPTIONS: &str = "options";
/// Under which name its camera is kept.
pub(crate) const CAMERA: &str = "camera";

/// The settings in a panel's state by their names, but the camera.
pub(crate) fn settings(state: &Value) -> BTreeMap<String, Value> {
    let mut found = BTreeMap::new();
    for (name, value) in state.as_object().into_iter().flatten() {
        match value {
            Value::Object(options) if name == OPTIONS => found.extend(options.clone()),
            _ if name == CAMERA => {}
            value => drop(found.insert(name.clone(), value.clone())),
        }
    }
    found
}

/// Changes one setting of a panel. `text` is JSON, or else a string.
pub(crate) fn set(panel: &mut dyn Panel, name: &str, text: &str) -> Result<(), String> {
    let mut state = panel.state();
    let known = settings(&state);
    if !known.contains_key(name) {
        let known: Vec<String> = known.into_keys().collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        return Err(format!("{} has no setting {name}; there are: {known}", panel.title()));
    }
    let value = serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()));
    let is_option = state.get(OPTIONS).is_some_and(|options| options.get(name).is_some());
    let of = if is_option { state.get_mut(OPTIONS) } else { Some(&mut state) };
    if let Some(found) = of.and_then(|of| of.get_mut(name)) {
        *found = value;
    }
    panel.set_state(state).map_err(|error| format!("{name}={text}: {error}"))
}
