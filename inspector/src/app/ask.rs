//! Asking for files: by the system's dialog, or by typing a path where there is none.

use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What a path is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Asking {
    OpenRecording,
    OpenSession,
    SaveSession,
    /// The session that the command for a panel, or for the `window`, draws.
    SaveCommand(&'static str),
    /// A picture of a panel, or of the window.
    SavePicture(Option<&'static str>),
    /// The data of a panel.
    SaveData(&'static str),
    /// The folder for the files of a figure of the catalogue.
    ExportFigure(&'static str),
}

/// What came of it.
pub(super) enum Asked {
    Chosen(PathBuf),
    Cancelled,
    /// The system has no dialog.
    Unavailable,
}

/// No one closes a dialog so soon: it did not open.
const SOONEST: Duration = Duration::from_millis(250);

const UNAVAILABLE: &str = "The system shows no file dialog (on Linux it takes xdg-desktop-portal with a backend, \
    or zenity). Type the path:";

impl Asking {
    /// The title of the question, and the name of the file that is proposed.
    fn words(&self) -> (&'static str, String) {
        match self {
            Self::OpenRecording => ("Open NAME.raydump", String::new()),
            Self::OpenSession => ("Open session", String::new()),
            Self::SaveSession => ("Save session", "session.json".to_owned()),
            Self::SaveCommand(panel) => ("Save the session that the command draws", format!("{panel}.json")),
            Self::SavePicture(panel) => ("Save picture", format!("{}.png", panel.unwrap_or("window"))),
            Self::SaveData(panel) => ("Save data", format!("{panel}.csv")),
            Self::ExportFigure(_) => ("Folder for the figure's files", "figures".to_owned()),
        }
    }

    /// Asks by the system's dialog.
    pub(super) fn by_dialog(&self) -> Asked {
        let (title, file_name) = self.words();
        let dialog = rfd::FileDialog::new().set_title(title);
        let start = Instant::now();
        let chosen = match self {
            Self::OpenRecording | Self::ExportFigure(_) => dialog.pick_folder(),
            Self::OpenSession => dialog.add_filter("session", &["json"]).pick_file(),
            Self::SaveSession | Self::SaveCommand(_) | Self::SavePicture(_) | Self::SaveData(_) => {
                dialog.set_file_name(file_name).save_file()
            }
        };
        match chosen {
            Some(path) => Asked::Chosen(path),
            None if start.elapsed() < SOONEST => Asked::Unavailable,
            None => Asked::Cancelled,
        }
    }
}

/// A path that is typed.
pub(super) struct Prompt {
    pub(super) asking: Asking,
    path: String,
    /// Whether it was shown: then the line of the path has the keyboard already.
    is_shown: bool,
}

impl Prompt {
    pub(super) fn new(asking: Asking) -> Self {
        let folder = std::env::current_dir().unwrap_or_default();
        let path = folder.join(asking.words().1).display().to_string();
        Self { asking, path, is_shown: false }
    }

    /// The path once it is typed; the prompt is over then, and when it is closed.
    pub(super) fn show(&mut self, ui: &egui::Ui) -> Option<Asked> {
        let (mut is_open, mut asked) = (true, None);
        egui::Window::new(self.asking.words().0)
            .open(&mut is_open)
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
            .show(ui.ctx(), |ui| {
                ui.set_max_width(460.0);
                ui.label(UNAVAILABLE);
                let line = ui.add(egui::TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY));
                if !std::mem::replace(&mut self.is_shown, true) {
                    line.request_focus();
                }
                let is_entered = line.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
                ui.horizontal(|ui| {
                    if ui.button("OK").clicked() || is_entered {
                        asked = Some(Asked::Chosen(PathBuf::from(self.path.trim())));
                    }
                    if ui.button("Cancel").clicked() {
                        asked = Some(Asked::Cancelled);
                    }
                });
            });
        if is_open { asked } else { Some(Asked::Cancelled) }
    }
}
