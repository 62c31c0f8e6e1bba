//! One setting of a session, changed by where it stands in the file: `shot --set`.

use anyhow::{anyhow, bail};
use formats::text::nearest;
use serde_json::{Map, Value};

use super::Session;

/// What of the file can be set; what is left of it says which recordings are open and where panels are.
const SETTABLE: [&str; 3] = ["selection", "what_if", "panels"];

impl Session {
    /// Changes one setting, `PATH=VALUE`. The path is where it stands in the file, as in
    /// `panels.scene.options.mesh`; words before the last one may be left out, as in `scene.mesh`, and in
    /// `mesh` where that of the panel `of` is meant. The value is JSON, or else text.
    ///
    /// # Errors
    /// If there is no such setting, or more than one. Values of panels are checked when they are shown.
    pub fn set(&mut self, setting: &str, of: &str) -> anyhow::Result<()> {
        let mut file = serde_json::to_value(&*self)?;
        let found = change(&mut file, setting, of)?;
        *self = serde_json::from_value(file).map_err(|cause| anyhow!("{found}: {cause}"))?;
        Ok(())
    }
}

/// The state of the panel `of` with these settings, named likewise.
///
/// # Errors
/// If there is no such setting, or more than one.
pub fn change_state(state: Value, settings: &[&str], of: &str) -> anyhow::Result<Value> {
    let mut file = serde_json::json!({ "panels": { of: state } });
    settings.iter().try_for_each(|setting| change(&mut file, setting, of).map(drop))?;
    Ok(file["panels"][of].take())
}

/// Changes one setting of a session's file; gives its path.
fn change(file: &mut Value, setting: &str, of: &str) -> anyhow::Result<String> {
    let Some((path, text)) = setting.split_once('=') else {
        bail!("found '{setting}', expected PATH=VALUE, such as mesh=wire or rays.descending=true");
    };
    let known: Vec<String> = settings(file);
    let mut meant: Vec<&str> = known.iter().map(String::as_str).filter(|known| names(path, known)).collect();
    if meant.len() > 1 {
        let own = format!("panels.{of}.");
        let of_panel = meant.iter().copied().filter(|known| known.starts_with(&own) || *known == path);
        meant = Some(of_panel.collect()).filter(|own: &Vec<&str>| own.len() == 1).unwrap_or(meant);
    }
    let found = match meant[..] {
        [found] => found,
        [] => bail!("there is no setting '{path}'; {}", hint(path, &known, of)),
        _ => bail!("'{path}' may be {}; name more of it", meant.join(" or ")),
    };
    if let Some(place) = file.pointer_mut(&format!("/{}", found.replace('.', "/"))) {
        let value = serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned()));
        let is_text = place.is_string() && !value.is_null();
        *place = if is_text { Value::String(text.to_owned()) } else { value };
    }
    Ok(found.to_owned())
}

/// The paths of all that can be set.
fn settings(file: &Value) -> Vec<String> {
    let all = SETTABLE.iter().filter_map(|name| Some((name, file.get(name)?)));
    all.flat_map(|(name, value)| leaves(name, value)).filter(|path| path != "selection.recording").collect()
}

fn leaves(path: &str, value: &Value) -> Vec<String> {
    match value {
        Value::Object(parts) if !Map::is_empty(parts) => {
            parts.iter().flat_map(|(name, part)| leaves(&format!("{path}.{name}"), part)).collect()
        }
        _ => vec![path.to_owned()],
    }
}

/// Whether a path, some of whose words may be left out, is this one.
fn names(path: &str, known: &str) -> bool {
    let mut known = known.rsplit('.');
    let mut words = path.rsplit('.');
    words.next() == known.next() && words.all(|word| known.any(|known| known == word))
}

/// Which setting was meant, or which there are.
fn hint(path: &str, known: &[String], of: &str) -> String {
    let last = |path: &'_ str| path.rsplit('.').next().map(str::to_owned).unwrap_or_default();
    let names: Vec<String> = known.iter().map(|known| last(known)).collect();
    if let Some(meant) = nearest(&last(path), &names.iter().map(String::as_str).collect::<Vec<_>>()) {
        return format!("did you mean '{meant}'?");
    }
    let own = format!("panels.{of}.");
    let is_near = |known: &&String| known.starts_with(&own) || !known.starts_with("panels.");
    let near: Vec<String> = known.iter().filter(is_near).map(|known| last(known)).collect();
    format!("there are {}", near.join(", "))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn session() -> Session {
        let space = json!({ "options": { "mesh": "solid", "detail": 1200 }, "camera": null });
        serde_json::from_value(json!({
            "version": 1, "recordings": ["a.raydump"], "theme": "dark", "layout": null, "what_if": null,
            "selection": {
                "recording": 0, "pass": 1, "bounce": 1, "kind": "closest", "method": "unsorted",
                "group_width": "64", "ray": null, "group": null, "cell": null, "filter": ""
            },
            "panels": { "scene": space, "other": space, "table": { "view": "mean" } }
        }))
        .unwrap()
    }

    #[test]
    fn settings_are_found_by_the_end_of_their_path() {
        let mut session = session();
        for setting in
            ["mesh=wire", "panels.other.options.detail=7", "table.view=count", "group_width=32", "group=3"]
        {
            session.set(setting, "scene").unwrap();
        }
        assert_eq!(session.panels["scene"]["options"], json!({ "mesh": "wire", "detail": 1200 }));
        assert_eq!(session.panels["other"]["options"], json!({ "mesh": "solid", "detail": 7 }));
        assert_eq!(session.panels["table"]["view"], "count");
        assert_eq!((session.selection.group_width.as_str(), session.selection.group), ("32", Some(3)));
        session.set("group=null", "scene").unwrap();
        assert_eq!(session.selection.group, None);
    }

    #[test]
    fn what_is_no_setting_is_refused_with_the_nearest() {
        for (setting, expected) in [
            ("meshes=wire", "no setting 'meshes'; did you mean 'mesh'?"),
            ("zzz=1", "there are ray, group, cell, filter"),
            ("scenery.mesh=wire", "did you mean 'mesh'?"),
            ("recordings=[]", "no setting 'recordings'"),
            ("recording=1", "no setting 'recording'"),
            ("mesh", "expected PATH=VALUE"),
            ("group=red", "selection.group: invalid type"),
        ] {
            let error = session().set(setting, "scene").unwrap_err().to_string();
            let found = error.contains(expected) || setting == "zzz=1" && error.contains("mesh");
            assert!(found, "{setting}: {error}");
        }
        let error = session().set("mesh=wire", "table").unwrap_err().to_string();
        assert_eq!(
            error,
            "'mesh' may be panels.other.options.mesh or panels.scene.options.mesh; name more of it"
        );
    }
}
