//! The window on a screen.

use std::path::PathBuf;

use super::App;
use super::kept::Kept;
use crate::model::Context;
use crate::model::context::Problem;
use crate::output::say;
use crate::render::gpu::{self, errors::Errors};
use crate::session::Session;
use crate::theme;

/// What the system knows windows of this program by.
const APP_ID: &str = "rayscope-inspector";

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn save(&mut self, _storage: &mut dyn eframe::Storage) {
        let kept = Kept { tiles: self.tree.clone(), recent: self.recent.clone() };
        if let Some(path) = Kept::path(APP_ID)
            && let Err(error) = kept.write(&path)
        {
            say(&format!("where panels are is not kept: cannot write {}: {error}", path.display()));
        }
    }
}

/// Opens the window on a session, if there is one, and recordings, and stays until it is closed.
///
/// # Errors
/// If none of the recordings can be opened, if there is no screen, or nothing that can draw on it.
pub fn run(paths: &[PathBuf], session: Option<Session>) -> anyhow::Result<()> {
    let mut context = session.as_ref().map_or_else(Context::default, Session::open);
    for path in paths {
        context.add(path);
    }
    if let Some(Problem { what, why }) = context.problems.first().filter(|_| context.recordings.is_empty()) {
        anyhow::bail!("{what}: {why}");
    }
    // What is shown first is read while the window is made.
    context.read_ahead();
    let viewport = egui::ViewportBuilder::default()
        .with_title("Rayscope inspector")
        .with_app_id(APP_ID)
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([640.0, 480.0])
        .with_drag_and_drop(true);
    let mut options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    gpu::set_up(&mut options.wgpu_options.wgpu_setup);
    let kept = Kept::path(APP_ID).and_then(|path| Kept::read(&path));
    let (tiles, older) = kept.map_or_else(Default::default, |kept| (Some(kept.tiles), kept.recent));
    let make = move |creation: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        let state = creation.wgpu_render_state.as_ref().ok_or("the window has no GPU to draw with")?;
        theme::set_up(&creation.egui_ctx);
        let mut app = App::showing(context, state.target_format.into());
        app.gpu_errors = Errors::of(&state.device, app.context.waker());
        if let Some(session) = &session {
            creation.egui_ctx.set_theme(egui::ThemePreference::from(session.theme));
            app.arrange_as(session);
        } else {
            app.arrange(tiles);
        }
        app.recent.add_older(older);
        Ok(Box::new(app))
    };
    eframe::run_native("Rayscope inspector", options, Box::new(make)).map_err(|error| {
        anyhow::anyhow!(
            "cannot open the window: {}; it needs a screen and a driver for Vulkan, Metal or DX12, and \
             `inspector shot` draws into a file without a screen",
            without_place(&error.to_string())
        )
    })
}

/// What a library says went wrong, without the line of its source that says so.
fn without_place(error: &str) -> &str {
    // winit: `os error at FILE:LINE: REASON`, after the names of those who pass it on.
    let reason = error.split_once("os error at ").and_then(|(_, place)| place.split_once(": "));
    reason.map_or(error, |(_, reason)| reason).trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_say_nothing_of_the_build() {
        let error = "winit EventLoopError: os error at /home/me/winit-1/src/mod.rs:764: there is no screen.";
        assert_eq!(without_place(error), "there is no screen");
        assert_eq!(without_place("no GPU: none was found"), "no GPU: none was found");
    }
}
