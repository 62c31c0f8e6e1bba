//! `inspector shot`: a picture of the window or of one view, without a screen.
//!
//! What is drawn is a session, read from a file or made of a recording, with the changes that were asked for.
//! `draw` draws it.

pub(crate) mod draw;

use std::path::PathBuf;

use anyhow::{Context as _, Error, bail};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use formats::key::method::UNSORTED;
use formats::ray::Kind;

use crate::app::App;
use crate::arguments;
use crate::filter::Expression;
use crate::model::Context;
use crate::model::what_if::{Settings, WHAT_IF};
use crate::panels::views::View;
use crate::render::camera::Camera;
use crate::session::{Session, ThemeChoice};

/// A picture of the window.
#[derive(Debug, Args)]
pub(crate) struct Shot {
    /// The recordings: folders NAME.raydump, or NAME.raydump.partial. They take the place of a session's.
    #[arg(value_name = "X.raydump", required_unless_present = "session")]
    dumps: Vec<PathBuf>,
    /// Shows what a session of the window says (File > Save session); other options change it.
    #[arg(long, value_name = "FILE")]
    session: Option<PathBuf>,
    /// Which of several recordings is looked at, counted from 0 [default: the last].
    #[arg(long, value_name = "N")]
    recording: Option<usize>,
    /// The file, a PNG.
    #[arg(long, value_name = "P.png")]
    out: PathBuf,
    /// What is drawn.
    #[arg(long, default_value = "window", value_parser = parse_view())]
    view: View,
    /// The pass [default: the last that was kept].
    #[arg(long)]
    pass: Option<u32>,
    /// The bounce; 0 is the camera rays [default: 1].
    #[arg(long)]
    bounce: Option<u32>,
    /// The kind of rays [default: closest].
    #[arg(long, value_parser = arguments::kind())]
    kind: Option<Kind>,
    /// The order: a method, or unsorted [default: the method that gains most net on the whole frame, of the
    /// recording that is looked at].
    #[arg(long)]
    method: Option<String>,
    /// Selects a ray by its canonical index.
    #[arg(long)]
    ray: Option<usize>,
    /// Shows only the rays that meet a condition, such as 'hit && length < 0.1'.
    #[arg(long, value_name = "EXPR")]
    filter: Option<String>,
    /// Sorts the rays by another layout, such as '(ox oy oz)*4 (u v)*10', or by the method of this name, and
    /// looks at that order.
    #[arg(long, value_name = "LAYOUT")]
    what_if: Option<String>,
    /// Where the camera stands: recorded, overview, or its numbers as Copy in the scene's Properties gives them: target x, y,
    /// z, yaw, pitch, distance and, if wanted, the field of view (unit space, radians).
    #[arg(long, value_parser = parse_camera, allow_hyphen_values = true)]
    camera: Option<String>,
    /// Changes one setting by its name in session files: mesh=wire of the panel that is drawn (the scene in a
    /// window), group=3, scene.detail=5000, rays.sorted_by=length. A name that does not exist says which do.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Pixels across and down.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Pixels to a point: 2 for screens of high resolution.
    #[arg(long, default_value_t = 1.0, value_parser = parse_scale)]
    scale: f32,
    /// Dark on light, or light on dark [default: that of the session, or dark].
    #[arg(long, value_enum)]
    theme: Option<ThemeChoice>,
    /// Draws the buttons of a panel, too.
    #[arg(long)]
    chrome: bool,
    /// Draws a film: P-0000.png, P-0001.png and so on, for ffmpeg and its like.
    #[arg(long, value_enum)]
    film: Option<Film>,
    /// Pictures of the film.
    #[arg(long, value_name = "N", default_value_t = 120, requires = "film", value_parser = clap::value_parser!(u32).range(2..=9999))]
    frames: u32,
    /// Print one JSON object with times, of frames while the slider goes along the order too, and memory.
    #[arg(long)]
    json: bool,
}

/// What moves in a film.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Film {
    /// The playhead, along the order.
    Scrub,
    /// The camera, once around what it looks at.
    Orbit,
}

impl Shot {
    /// The window with what is drawn, and whether it is light or dark.
    fn open(&self, format: wgpu::TextureFormat) -> anyhow::Result<(App, ThemeChoice)> {
        let file = self.session.as_deref().map(Session::read).transpose()?;
        let mut app = App::new(&[], format);
        match file.clone() {
            Some(file) => app.restore(&file.of_recordings(&self.dumps)),
            None => self.dumps.iter().for_each(|dump| app.open(dump)),
        }
        refuse_problems(&app)?;
        if let Some(at) = self.recording {
            let count = app.context.recordings.len();
            if at >= count {
                bail!("there is no recording {at}; there are {count}, counted from 0");
            }
            app.context.select_recording(at);
        }
        let mut session = app.session(&egui::Context::default());
        let is_saved = file
            .as_ref()
            .is_some_and(|file| self.view.panel.is_some_and(|panel| file.panels.contains_key(panel)));
        let preset = if is_saved { &[] } else { self.view.settings };
        self.change(&mut session, &app.context, preset)?;
        app.show_session(&session).map_err(Error::msg)?;
        refuse_problems(&app)?;
        if self.what_if.is_some() {
            app.context.awaited_order().map_err(Error::msg).context("--what-if")?;
        }
        app.context.is_bare = self.view.panel.is_some() && !self.chrome;
        let theme = self.theme.or(file.map(|file| file.theme));
        Ok((app, theme.unwrap_or_default()))
    }

    /// Changes a session as it was asked for.
    fn change(&self, session: &mut Session, context: &Context, preset: &[&str]) -> anyhow::Result<()> {
        let recording = context.recording().context("no recording is open")?;
        let selection = &mut session.selection;
        let before = selection.queue();
        selection.pass = self.pass.unwrap_or(before.pass);
        selection.bounce = self.bounce.unwrap_or(before.bounce);
        selection.kind = self.kind.unwrap_or(before.kind);
        if selection.queue() != before {
            // Rays of another queue, which may have other methods.
            (selection.ray, selection.group) = (None, None);
            selection.others.clear();
            let (queue, known) = (selection.queue(), recording.methods(selection.queue()));
            let best = recording.best_method(queue);
            // What a session chose stays, if this queue has it.
            for (method, usual, is_chosen) in [
                (&mut selection.method, best, context.is_b_chosen),
                (&mut selection.baseline, UNSORTED, true),
            ] {
                if !(is_chosen && known.contains(method)) && *method != WHAT_IF {
                    usual.clone_into(method);
                }
            }
        }
        if let Some(order) = &self.what_if {
            session.what_if = Some(Settings::named(order, &recording.dump.manifest().header));
        }
        let made = self.what_if.as_ref().map(|_| WHAT_IF.to_owned());
        if let Some(method) = self.method.clone().or(made).filter(|method| *method != selection.method) {
            // Its groups are others.
            (selection.method, selection.group) = (method, None);
        }
        if self.ray.is_some() {
            (selection.ray, selection.group) = (self.ray, None);
            selection.others.clear();
        }
        if let Some(filter) = &self.filter {
            Expression::parse(filter)
                .map_err(|error| Error::msg(format!("--filter: {}", error.shown(filter))))?;
            selection.filter.clone_from(filter);
        }
        let panel = self.view.panel.unwrap_or("scene");
        for setting in preset {
            session.set(setting, panel)?;
        }
        match self.camera.as_deref() {
            None => {}
            Some(point @ ("recorded" | "overview")) => {
                session.set(&format!("stand_point={point}"), panel).context("--camera")?;
                session.set("camera=null", panel).context("--camera")?;
            }
            Some(numbers) => session.set(&format!("camera={numbers}"), panel).context("--camera")?,
        }
        self.settings.iter().try_for_each(|setting| session.set(setting, panel).context("--set"))
    }
}

fn refuse_problems(app: &App) -> anyhow::Result<()> {
    match app.context.problems.first() {
        Some(problem) => bail!("{}: {}", problem.what, problem.why),
        None => Ok(()),
    }
}

fn parse_view() -> impl TypedValueParser<Value = View> {
    let names = PossibleValuesParser::new(View::all().map(|view| view.name));
    names.try_map(|name| View::all().find(|view| view.name == name).ok_or("expected the name of a view"))
}

fn parse_camera(text: &str) -> Result<String, String> {
    if !matches!(text, "recorded" | "overview") {
        text.parse::<Camera>().map_err(|error| format!("recorded, overview, or {error}"))?;
    }
    Ok(text.to_owned())
}

/// The largest side of a picture that every adapter can draw.
const LARGEST_SIDE: u32 = 8192;

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    match sides {
        Some(sides) if sides.iter().all(|side| (64..=LARGEST_SIDE).contains(side)) => Ok(sides),
        _ => Err(format!("expected WIDTHxHEIGHT, 64 to {LARGEST_SIDE} each, such as 1280x720")),
    }
}

fn parse_scale(text: &str) -> Result<f32, String> {
    let scale = text.parse().ok().filter(|scale| (0.5..=4.0).contains(scale));
    scale.ok_or_else(|| "expected 0.5 to 4".to_owned())
}
