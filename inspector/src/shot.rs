//! `inspector shot`: a picture of the window or of one view, without a screen. The same code draws it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use egui_kittest::Harness;
use egui_wgpu::RenderState;
use formats::manifest::QueueId;
use formats::ray::Kind;
use serde::Serialize;

use crate::analysis::GroupWidth;
use crate::app::App;
use crate::model::Context;
use crate::model::background::Waker;
use crate::model::value::ColourBy;
use crate::model::what_if::{Estimate, Settings, WHAT_IF};
use crate::output::{print, print_json};
use crate::panels::settings::set;
use crate::panels::space::SpaceView;
use crate::panels::space::options::{CapsuleChoice, MeshMode, Options, StandPoint};
use crate::panels::{Lacking, PANELS, Panel};
use crate::png_file;
use crate::render::camera::Camera;
use crate::render::gpu::errors::Errors;
use crate::render::gpu::{self, DrawCounts};
use crate::session::{Session, ThemeChoice};
use crate::theme;

/// Views by name, with the panel that each is a view of.
pub(crate) const VIEWS: [(&str, &str); 15] = [
    ("window", ""),
    ("curve", "scene"),
    ("rays", "scene"),
    ("capsules", "scene"),
    ("cell", "scene"),
    ("compare", "compare"),
    ("table", "table"),
    ("order", "order"),
    ("coherence", "coherence"),
    ("what-if", "what-if"),
    ("timings", "timings"),
    ("rays-table", "rays"),
    ("ray", "ray"),
    ("navigator", "navigator"),
    ("problems", "problems"),
];

/// Frames until everything has its place: the first has no size yet, and tables measure in the second.
const SETTLING_FRAMES: usize = 4;

/// How long a software GPU may take for a picture of all rays.
const PATIENCE: Duration = Duration::from_secs(900);

/// What is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    pub(crate) view: String,
    pub(crate) session: Option<PathBuf>,
    /// Which of the recordings, from 0; the last if `None`.
    pub(crate) recording: Option<usize>,
    pub(crate) pass: Option<u32>,
    pub(crate) bounce: Option<u32>,
    pub(crate) kind: Option<Kind>,
    pub(crate) method: Option<String>,
    pub(crate) group_width: Option<GroupWidth>,
    pub(crate) group: Option<usize>,
    pub(crate) ray: Option<usize>,
    pub(crate) cell: Option<u32>,
    pub(crate) filter: Option<String>,
    pub(crate) what_if: Option<WhatIf>,
    pub(crate) scene: SceneChoice,
    /// `NAME=VALUE`, of the panel that is drawn; `PANEL.NAME=VALUE` of a window's.
    pub(crate) settings: Vec<String>,
    pub(crate) size: [u32; 2],
    pub(crate) scale: f32,
    pub(crate) is_light: bool,
    pub(crate) frames: usize,
}

/// Another order, by a layout or a method's name, and how it differs from what that means by itself.
#[derive(Clone, Debug)]
pub(crate) struct WhatIf {
    pub(crate) order: String,
    pub(crate) key_bits: Option<u32>,
    pub(crate) estimate: Option<Estimate>,
    pub(crate) length: Option<f32>,
}

/// How the scene view differs from what it shows by itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneChoice {
    pub(crate) colour_by: Option<ColourBy>,
    pub(crate) stand_point: Option<StandPoint>,
    pub(crate) camera: Option<Camera>,
    pub(crate) detail: Option<usize>,
    pub(crate) capsules: Option<usize>,
    pub(crate) mesh: Option<MeshMode>,
    pub(crate) until: Option<f32>,
    pub(crate) part: Option<f32>,
    pub(crate) cut: Option<f32>,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    file: PathBuf,
    /// From the start of the program until all that is drawn was read and made, on the CPU.
    ready_ms: f64,
    /// Drawing the picture on the GPU and reading it back; uploads included.
    picture_ms: f64,
    /// The longest frame until then, of the CPU alone.
    worst_frame_until_ready_ms: f64,
    frames: usize,
    /// While the slider goes along the order, of the CPU alone: layout and what is handed to the GPU.
    median_frame_ms: f64,
    worst_frame_ms: f64,
    /// Lines in space in the last frame, and how many there are.
    rays_shown: Option<(usize, usize)>,
    /// What views in space drew and uploaded for the picture.
    draws: DrawCounts,
    memory: Memory,
}

/// Memory of this process; 0 where the system does not say.
#[derive(Default, Serialize)]
struct Memory {
    /// Mapped files included, as far as they were read.
    resident_bytes: u64,
    /// Without them: what no one else could have.
    anonymous_bytes: u64,
}

/// Draws a picture into a file.
pub(crate) fn run(dumps: &[PathBuf], shot: &Shot, out: &Path, json: bool) -> anyhow::Result<()> {
    let (report, lacking) = draw(dumps, shot, out)?;
    if json {
        print_json(&report)?;
    } else if out.is_file() {
        // The picture itself may have gone to standard output.
        print(&out.display().to_string())?;
    }
    if !lacking.is_empty() {
        let reasons: Vec<String> = lacking.into_iter().collect();
        bail!("{} says why it does not show all: {}", out.display(), reasons.join("; "));
    }
    Ok(())
}

/// What is drawn: the window, or one of its panels alone.
enum Drawn {
    Window(Box<App>),
    Panel(Box<dyn Panel>, Box<Context>),
}

impl Drawn {
    fn context(&mut self) -> &mut Context {
        match self {
            Self::Window(app) => &mut app.context,
            Self::Panel(_, context) => context,
        }
    }

    /// The view into space that it has; a window's is that of its scene.
    fn space(&mut self) -> Option<&mut SpaceView> {
        match self {
            Self::Window(app) => app.panel("scene")?.space(),
            Self::Panel(panel, _) => panel.space(),
        }
    }

    /// Changes settings, and puts the camera where it was asked for.
    fn set(&mut self, shot: &Shot) -> anyhow::Result<()> {
        for setting in &shot.settings {
            let (name, value) = setting.split_once('=').context("expected NAME=VALUE")?;
            let (name, panel) = match self {
                Self::Panel(panel, _) => (name, panel),
                Self::Window(app) => {
                    let (panel, name) = name.split_once('.').unwrap_or(("scene", name));
                    (name, app.panel(panel).with_context(|| format!("there is no panel {panel}"))?)
                }
            };
            set(panel.as_mut(), name, value).map_err(anyhow::Error::msg)?;
        }
        if let Some((camera, space)) = shot.scene.camera.zip(self.space()) {
            space.place(camera);
        }
        Ok(())
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        match self {
            Self::Window(app) => app.show(ui),
            Self::Panel(panel, context) => {
                let frame = egui::Frame::central_panel(ui.style()).inner_margin(6.0);
                egui::CentralPanel::default().frame(frame).show(ui, |ui| panel.show(ui, context));
            }
        }
    }
}

/// Gives the times, and what the picture lacks: why, in sentences.
fn draw(dumps: &[PathBuf], shot: &Shot, out: &Path) -> anyhow::Result<(Report, BTreeSet<String>)> {
    let state = render_state()?;
    let errors = Errors::of(&state.device, &Waker::default());
    let session = shot.session.as_deref().map(Session::read).transpose()?;
    let mut drawn = open(dumps, shot, session.as_ref(), state.target_format)?;
    select(drawn.context(), shot)?;
    let [width, height] = shot.size.map(|side| side as f32 / shot.scale);
    let is_light = shot.is_light || session.is_some_and(|session| session.theme == ThemeChoice::Light);
    let mode = if is_light { egui::Theme::Light } else { egui::Theme::Dark };
    let mut harness = Harness::builder()
        .with_size([width, height])
        .with_pixels_per_point(shot.scale)
        .with_theme(mode)
        .with_context_setup(theme::set_up)
        .with_render_cursor(false)
        .with_accessibility_check(false)
        .allow_missing_glyphs()
        .renderer(egui_kittest::wgpu::WgpuTestRenderer::from_render_state(state.clone()))
        .build_ui_state(show_all_over, drawn);
    let worst_frame_until_ready_ms = settle(&mut harness);
    let ready_ms = milliseconds(*STARTED);
    // What was said before is of what was still being read.
    Lacking::take(&harness.ctx);
    let mut times = scrub(&mut harness, shot.frames.max(1));
    let lacking = Lacking::take(&harness.ctx);
    let start = Instant::now();
    let (size, rgba) = patiently(&mut harness, &state)?;
    let picture_ms = milliseconds(start);
    if let Some(error) = errors.take().first() {
        bail!("the GPU cannot draw the picture: {error}");
    }
    png_file::write(out, size, &rgba)?;
    times.sort_by(f64::total_cmp);
    let report = Report {
        file: out.to_owned(),
        ready_ms,
        worst_frame_until_ready_ms,
        frames: times.len(),
        median_frame_ms: times[times.len() / 2],
        worst_frame_ms: times.last().copied().unwrap_or(0.0),
        picture_ms,
        rays_shown: harness.state_mut().space().and_then(|space| space.counts()),
        draws: DrawCounts::of(&state.renderer.read().callback_resources),
        memory: memory(),
    };
    Ok((report, lacking))
}

fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// The picture, however long the GPU takes: the harness gives up after ten seconds, but what it had asked for
/// is drawn all the same, and drawn only once.
fn patiently(harness: &mut Harness<'_, Drawn>, state: &RenderState) -> anyhow::Result<([u32; 2], Vec<u8>)> {
    let mut drawn = harness.render();
    if drawn.is_err() {
        let wait = wgpu::PollType::Wait { submission_index: None, timeout: Some(PATIENCE) };
        state.device.poll(wait).context("the GPU takes too long; `--detail` for fewer rays")?;
        drawn = harness.render();
    }
    let image = drawn.map_err(anyhow::Error::msg).context("the picture cannot be drawn")?;
    Ok(([image.width(), image.height()], image.into_raw()))
}

/// When the program was started.
pub(crate) static STARTED: LazyLock<Instant> = LazyLock::new(Instant::now);

/// The times of frames in which the slider of the scene goes along the order, and stands in the end where it
/// stood.
fn scrub(harness: &mut Harness<'_, Drawn>, frames: usize) -> Vec<f64> {
    let until = harness.state_mut().space().map(|space| space.options.until);
    let time = |frame: usize| {
        if let Some(space) = harness.state_mut().space()
            && frame + 1 < frames
        {
            space.options.until = (frame + 1) as f32 / frames as f32;
        } else if let Some((space, until)) = harness.state_mut().space().zip(until) {
            space.options.until = until;
        }
        let start = Instant::now();
        harness.step();
        milliseconds(start)
    };
    (0..frames).map(time).collect()
}

/// Draws until nothing is being read or made for what is drawn; the longest frame, milliseconds.
fn settle(harness: &mut Harness<'_, Drawn>) -> f64 {
    let (mut still, mut worst) = (0, 0.0f64);
    while still < SETTLING_FRAMES {
        let start = Instant::now();
        harness.step();
        worst = worst.max(milliseconds(start));
        still = if harness.state_mut().context().finish() { 0 } else { still + 1 };
    }
    worst
}

/// Draws over all of the picture, as in a window: the harness leaves a margin.
fn show_all_over(ui: &mut egui::Ui, drawn: &mut Drawn) {
    let all = ui.ctx().content_rect();
    let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(all));
    ui.set_clip_rect(all);
    drawn.show(&mut ui);
}

/// A GPU, or why there is none.
fn render_state() -> anyhow::Result<RenderState> {
    let mut setup = egui_kittest::wgpu::default_wgpu_setup();
    gpu::set_up(&mut setup);
    let instance = pollster::block_on(setup.new_instance());
    let configuration = egui_wgpu::WgpuConfiguration { wgpu_setup: setup, ..Default::default() };
    let options = egui_wgpu::RendererOptions::PREDICTABLE;
    let state = pollster::block_on(RenderState::create(&configuration, &instance, None, options));
    state.context("there is no GPU to draw with; on Linux, mesa-vulkan-drivers has a software one")
}

fn open(
    dumps: &[PathBuf],
    shot: &Shot,
    session: Option<&Session>,
    format: wgpu::TextureFormat,
) -> anyhow::Result<Drawn> {
    let Some((view, name)) = VIEWS.into_iter().find(|(view, _)| *view == shot.view) else {
        let known: Vec<&str> = VIEWS.iter().map(|(view, _)| *view).collect();
        bail!("there is no view {}; there are: {}", shot.view, known.join(", "));
    };
    let mut drawn = match name {
        "" => {
            let mut app = App::new(&[], format);
            if let Some(session) = session {
                app.restore(session);
            }
            dumps.iter().for_each(|dump| app.open(dump));
            Drawn::Window(Box::new(app))
        }
        name => {
            let entry = PANELS.iter().find(|entry| entry.name == name);
            let entry = entry.with_context(|| format!("there is no panel {name}"))?;
            let mut panel = (entry.make)(&format.into());
            let state = session.and_then(|session| session.panels.get(name));
            match (state, panel.space()) {
                (Some(state), _) => panel.set_state(state.clone())?,
                (None, Some(space)) => space.options = preset(view),
                (None, None) => {}
            }
            if let Some(space) = panel.space() {
                adjust(&mut space.options, shot);
            }
            let mut context = session.map_or_else(Context::default, Session::open);
            dumps.iter().for_each(|dump| context.add(dump));
            Drawn::Panel(panel, Box::new(context))
        }
    };
    if let Some(problem) = drawn.context().problems.first() {
        bail!("{}: {}", problem.what, problem.why);
    }
    drawn.set(shot)?;
    Ok(drawn)
}

/// What the scene view of a view shows by itself.
pub(crate) fn preset(view: &str) -> Options {
    let default = Options::default();
    // Capsules are larger than rooms, so they are looked at from outside.
    let (mesh, stand_point) = match view {
        "capsules" | "cell" => (MeshMode::Ghost, StandPoint::Overview),
        _ => (default.mesh, default.stand_point),
    };
    Options {
        curve: matches!(view, "curve" | "compare"),
        rays: view == "rays",
        ends: view == "rays",
        capsules: view == "capsules",
        capsule_choice: CapsuleChoice::Spread,
        mesh,
        stand_point,
        ..default
    }
}

/// Changes what was asked for.
fn adjust(options: &mut Options, shot: &Shot) {
    let choice = &shot.scene;
    if shot.view == "compare" && choice.capsules.is_some() {
        (options.curve, options.capsules) = (false, true);
        (options.mesh, options.stand_point) = (MeshMode::Ghost, StandPoint::Overview);
    }
    if shot.group.is_some() {
        options.capsule_choice = CapsuleChoice::Selected;
    }
    let change = |to: &mut f32, from: Option<f32>| *to = from.unwrap_or(*to);
    change(&mut options.until, choice.until);
    change(&mut options.window, choice.part);
    change(&mut options.clip_at, choice.cut);
    options.mesh = choice.mesh.unwrap_or(options.mesh);
    options.capsule_count = choice.capsules.unwrap_or(options.capsule_count);
    options.colour_by = choice.colour_by.unwrap_or(options.colour_by);
    options.stand_point = choice.stand_point.unwrap_or(options.stand_point);
    options.detail = choice.detail.unwrap_or(options.detail);
}

/// Selects what was asked for; an error if the recording does not have it.
fn select(context: &mut Context, shot: &Shot) -> anyhow::Result<()> {
    if let Some(recording) = shot.recording {
        if recording >= context.recordings.len() {
            bail!("there is no recording {recording}; there are {}", context.recordings.len());
        }
        context.select_recording(recording);
    }
    let now = context.selection.queue;
    let wanted = QueueId {
        pass: shot.pass.unwrap_or(now.pass),
        bounce: shot.bounce.unwrap_or(now.bounce),
        kind: shot.kind.unwrap_or(now.kind),
    };
    let recording = context.recording().context("no recording was named")?;
    if !recording.queues().iter().any(|record| record.id == wanted) {
        let known: Vec<String> = recording.queues().iter().map(|record| record.id.to_string()).collect();
        bail!("the recording has no {wanted}; it has: {}", known.join(", "));
    }
    context.go_to(wanted);
    if let Some(width) = shot.group_width {
        context.selection.group_width = width;
    }
    if let Some(what_if) = &shot.what_if {
        make_order(context, what_if)?;
    }
    if let Some(method) = &shot.method {
        let methods = context.methods();
        if !methods.contains(method) {
            bail!("{wanted} was not ordered by {method}; there are: {}", methods.join(", "));
        }
        context.selection.order_by(method);
    }
    if shot.ray.is_some() {
        context.awaited_order().map_err(anyhow::Error::msg)?;
        context.select_ray(shot.ray);
        if context.selection.ray != shot.ray {
            bail!("{wanted} has no ray {}", shot.ray.unwrap_or(0));
        }
    }
    if shot.group.is_some() {
        context.select_group(shot.group);
        if context.selection.group != shot.group {
            bail!("{wanted} has no group {}", shot.group.unwrap_or(0));
        }
    }
    context.selection.cell = shot.cell.or(context.selection.cell);
    if let Some(filter) = &shot.filter {
        context.selection.filter.set(filter);
        if let Some(error) = context.selection.filter.error() {
            bail!("--filter: {error}\n  {filter}\n  {}{}", " ".repeat(error.start), "^".repeat(error.length));
        }
    }
    Ok(())
}

fn memory() -> Memory {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let of = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        let kilobytes = line.and_then(|line| line.split_whitespace().next());
        kilobytes.and_then(|kilobytes| kilobytes.parse::<u64>().ok()).unwrap_or(0) * 1024
    };
    Memory { resident_bytes: of("VmRSS"), anonymous_bytes: of("RssAnon") }
}

/// Makes the what-if order and selects it.
fn make_order(context: &mut Context, what_if: &WhatIf) -> anyhow::Result<()> {
    let recording = context.recording().context("no recording was named")?;
    let header = &recording.dump.manifest().header;
    let named = Settings::named(&what_if.order, header);
    let settings = Settings {
        key_bits: what_if.key_bits.unwrap_or(named.key_bits),
        estimate: what_if.estimate.unwrap_or(named.estimate),
        length: what_if.length.unwrap_or(named.length),
        ..named
    };
    if let Err(error) = settings.layout(header.lights.len()) {
        bail!("--what-if: {error}");
    }
    context.what_if = Some(settings);
    while context.what_if_order().map_err(anyhow::Error::msg).context("--what-if")?.is_none() {
        context.finish();
    }
    context.selection.order_by(WHAT_IF);
    Ok(())
}
