//! The window on a screen.

use std::path::PathBuf;

use super::App;
use crate::model::Context;
use crate::render::gpu::{self, errors::Errors};
use crate::session::Session;
use crate::theme;

/// Under which names the layout and the recent recordings are kept between runs.
const LAYOUT_KEY: &str = "tiles";
const RECENT_KEY: &str = "recent";

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, LAYOUT_KEY, &self.tree);
        eframe::set_value(storage, RECENT_KEY, &self.recent);
    }
}

/// Opens the window on a session, if there is one, and recordings, and stays until it is closed.
///
/// # Errors
/// If there is no screen, or nothing that can draw on it.
pub fn run(paths: &[PathBuf], session: Option<Session>) -> anyhow::Result<()> {
    let mut context = session.as_ref().map_or_else(Context::default, Session::open);
    paths.iter().for_each(|path| context.add(path));
    // What is shown first is read while the window is made.
    context.read_ahead();
    let viewport = egui::ViewportBuilder::default()
        .with_title("Rayscope inspector")
        .with_app_id("rayscope-inspector")
        .with_inner_size([1440.0, 900.0])
        .with_drag_and_drop(true);
    let mut options = eframe::NativeOptions { viewport, ..eframe::NativeOptions::default() };
    gpu::set_up(&mut options.wgpu_options.wgpu_setup);
    let make = move |creation: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, _> {
        let state = creation.wgpu_render_state.as_ref().ok_or("the window has no GPU to draw with")?;
        theme::set_up(&creation.egui_ctx);
        let mut app = App::showing(context, state.target_format.into());
        app.gpu_errors = Errors::of(&state.device, app.context.waker());
        if let Some(session) = &session {
            creation.egui_ctx.set_theme(egui::ThemePreference::from(session.theme));
            app.arrange_as(session);
        } else {
            app.arrange(creation.storage.and_then(|storage| eframe::get_value(storage, LAYOUT_KEY)));
        }
        let older = creation.storage.and_then(|storage| eframe::get_value(storage, RECENT_KEY));
        app.recent.add_older(older.unwrap_or_default());
        Ok(Box::new(app))
    };
    eframe::run_native("Rayscope inspector", options, Box::new(make)).map_err(|error| {
        anyhow::anyhow!(
            "cannot open the window: {error}; it needs a screen and a driver for Vulkan, Metal or DX12, and \
             `inspector shot` draws into a file without a screen"
        )
    })
}
