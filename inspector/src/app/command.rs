//! The `inspector shot` command that draws what is seen, to be repeated and put into a paper's notes.

use std::path::Path;

use super::App;
use crate::inputs::quoted;
use crate::panels::views::View;

impl App {
    /// Saves what the window shows as a session, and gives the command that draws a panel of it, or all of the
    /// `window`, as large, light or dark as it is.
    ///
    /// # Errors
    /// If that file cannot be written.
    pub fn command(&self, panel: &str, file: &Path, window: &egui::Context) -> anyhow::Result<String> {
        self.session(window).write(file)?;
        let (scale, size) = (window.pixels_per_point(), window.content_rect().size());
        let size = self.places.get(panel).map_or(size, egui::Rect::size);
        let [width, height] = [size.x, size.y].map(|side| (side * scale).round() as u32);
        let theme = if window.theme() == egui::Theme::Light { "light" } else { "dark" };
        let mut words = vec!["inspector shot".to_owned()];
        words.extend(self.context.recordings.iter().map(|open| quoted(open.dump.root())));
        words.push(format!("--session {}", quoted(file)));
        words.extend(View::of_panel(panel).map(|view| format!("--view {}", view.name)));
        words.push(format!("--size {width}x{height} --scale {scale} --theme {theme} --out {panel}.png"));
        Ok(words.join(" "))
    }
}
