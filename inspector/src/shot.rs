//! `inspector shot`: a picture of the window or of one view, without a screen. The same code draws it.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, bail};
use egui_kittest::Harness;
use formats::manifest::QueueId;
use formats::ray::Kind;
use serde::Serialize;

use crate::analysis::GroupWidth;
use crate::app::{App, only_own_backends};
use crate::model::Context;
use crate::model::value::ColourBy;
use crate::output::{print, print_json};
use crate::panels::space::options::{CapsuleChoice, MeshMode, Options, StandPoint};
use crate::panels::{PANELS, Panel};
use crate::theme;

/// Views by name, with the panel that each is a view of.
pub(crate) const VIEWS: [(&str, &str); 13] = [
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
];

/// Frames until everything has its place: the first has no size yet, and tables measure in the second.
const SETTLING_FRAMES: usize = 4;

/// What is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    pub(crate) view: String,
    pub(crate) pass: Option<u32>,
    pub(crate) bounce: Option<u32>,
    pub(crate) kind: Option<Kind>,
    pub(crate) method: Option<String>,
    pub(crate) group_width: GroupWidth,
    pub(crate) group: Option<usize>,
    pub(crate) ray: Option<usize>,
    pub(crate) cell: Option<u32>,
    pub(crate) filter: Option<String>,
    pub(crate) scene: SceneChoice,
    pub(crate) size: [u32; 2],
    pub(crate) scale: f32,
    pub(crate) is_light: bool,
    pub(crate) frames: usize,
}

/// How the scene view differs from what it shows by itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct SceneChoice {
    pub(crate) colour_by: Option<ColourBy>,
    pub(crate) stand_point: Option<StandPoint>,
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
    frames: usize,
    /// Of the CPU alone: layout and what is handed to the GPU.
    median_frame_ms: f64,
    worst_frame_ms: f64,
    /// Lines in space in the last frame, and how many there are.
    rays_shown: Option<(usize, usize)>,
    /// Of this process, mapped files included.
    resident_bytes: u64,
}

/// Draws a picture into a file.
pub(crate) fn run(dumps: &[PathBuf], shot: &Shot, out: &Path, json: bool) -> anyhow::Result<()> {
    let (image, report) = draw(dumps, shot, out)?;
    write(&image, out)?;
    if json { print_json(&report) } else { print(&out.display().to_string()) }
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

fn draw(dumps: &[PathBuf], shot: &Shot, out: &Path) -> anyhow::Result<(Image, Report)> {
    let state = render_state()?;
    let mut drawn = open(dumps, shot, state.target_format)?;
    select(drawn.context(), shot)?;
    let [width, height] = shot.size.map(|side| side as f32 / shot.scale);
    let mode = if shot.is_light { egui::Theme::Light } else { egui::Theme::Dark };
    let mut harness = Harness::builder()
        .with_size([width, height])
        .with_pixels_per_point(shot.scale)
        .with_theme(mode)
        .with_context_setup(theme::set_up)
        .with_render_cursor(false)
        .with_accessibility_check(false)
        .allow_missing_glyphs()
        .renderer(egui_kittest::wgpu::WgpuTestRenderer::from_render_state(state))
        .build_ui_state(show_all_over, drawn);
    let mut times = Vec::new();
    settle(&mut harness);
    for _ in 0..shot.frames.max(1) {
        let start = Instant::now();
        harness.step();
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    let image = harness.render().map_err(anyhow::Error::msg).context("the picture cannot be drawn; a software GPU may take too long for so many rays (`--detail` for fewer)")?;
    let (width, height) = (image.width(), image.height());
    times.sort_by(f64::total_cmp);
    let report = Report {
        file: out.to_owned(),
        frames: times.len(),
        median_frame_ms: times[times.len() / 2],
        worst_frame_ms: times.last().copied().unwrap_or(0.0),
        rays_shown: match harness.state_mut() {
            Drawn::Panel(panel, _) => panel.space().and_then(|space| space.counts()),
            Drawn::Window(_) => None,
        },
        resident_bytes: resident_bytes(),
    };
    Ok((Image { width, height, rgba: image.into_raw() }, report))
}

/// Draws until nothing is being read or made for what is drawn.
fn settle(harness: &mut Harness<'_, Drawn>) {
    let mut still = 0;
    while still < SETTLING_FRAMES {
        harness.step();
        still = if harness.state_mut().context().finish() { 0 } else { still + 1 };
    }
}

/// Draws over all of the picture, as in a window: the harness leaves a margin.
fn show_all_over(ui: &mut egui::Ui, drawn: &mut Drawn) {
    let all = ui.ctx().content_rect();
    let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(all));
    ui.set_clip_rect(all);
    drawn.show(&mut ui);
}

/// A GPU, or why there is none.
fn render_state() -> anyhow::Result<egui_wgpu::RenderState> {
    let mut setup = egui_kittest::wgpu::default_wgpu_setup();
    only_own_backends(&mut setup);
    let instance = pollster::block_on(setup.new_instance());
    let configuration = egui_wgpu::WgpuConfiguration { wgpu_setup: setup, ..Default::default() };
    let options = egui_wgpu::RendererOptions::PREDICTABLE;
    let state = pollster::block_on(egui_wgpu::RenderState::create(&configuration, &instance, None, options));
    state.context("there is no GPU to draw with; on Linux, mesa-vulkan-drivers has a software one")
}

fn open(dumps: &[PathBuf], shot: &Shot, format: wgpu::TextureFormat) -> anyhow::Result<Drawn> {
    let Some((view, name)) = VIEWS.into_iter().find(|(view, _)| *view == shot.view) else {
        let known: Vec<&str> = VIEWS.iter().map(|(view, _)| *view).collect();
        bail!("there is no view {}; there are: {}", shot.view, known.join(", "));
    };
    let mut drawn = match name {
        "" => Drawn::Window(Box::new(App::new(dumps, format))),
        name => {
            let entry = PANELS.iter().find(|entry| entry.name == name);
            let entry = entry.with_context(|| format!("there is no panel {name}"))?;
            let mut panel = (entry.make)(format);
            if let Some(space) = panel.space() {
                space.options = options(view, shot);
            }
            Drawn::Panel(panel, Box::new(Context::open(dumps)))
        }
    };
    if let Some(problem) = drawn.context().problems.first() {
        bail!("{}: {}", problem.what, problem.why);
    }
    Ok(drawn)
}

fn options(view: &str, shot: &Shot) -> Options {
    let default = Options::default();
    let choice = &shot.scene;
    let capsules = if shot.group.is_some() { CapsuleChoice::Selected } else { CapsuleChoice::Spread };
    // Capsules are larger than rooms, so they are looked at from outside.
    let (mesh, stand_point) = match view {
        "compare" if choice.capsules.is_some() => (MeshMode::Ghost, StandPoint::Overview),
        "capsules" | "cell" => (MeshMode::Ghost, StandPoint::Overview),
        _ => (default.mesh, default.stand_point),
    };
    Options {
        curve: view == "curve" || view == "compare" && choice.capsules.is_none(),
        rays: view == "rays",
        ends: view == "rays",
        capsules: view == "capsules" || view == "compare" && choice.capsules.is_some(),
        capsule_choice: capsules,
        mesh: choice.mesh.unwrap_or(mesh),
        capsule_count: choice.capsules.unwrap_or(default.capsule_count),
        colour_by: choice.colour_by.unwrap_or(default.colour_by),
        stand_point: choice.stand_point.unwrap_or(stand_point),
        detail: choice.detail.unwrap_or(default.detail),
        until: choice.until.unwrap_or(default.until),
        window: choice.part.unwrap_or(default.window),
        cut: choice.cut.unwrap_or(default.cut),
        ..default
    }
}

/// Selects what was asked for; an error if the recording does not have it.
fn select(context: &mut Context, shot: &Shot) -> anyhow::Result<()> {
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
    context.selection.group_width = shot.group_width;
    if let Some(method) = &shot.method {
        let methods = context.recording().map_or(&[][..], |recording| recording.methods(wanted));
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
    context.selection.cell = shot.cell;
    if let Some(filter) = &shot.filter {
        context.selection.filter.set(filter);
        if let Some(error) = context.selection.filter.error() {
            bail!("--filter: {error}\n  {filter}\n  {}{}", " ".repeat(error.start), "^".repeat(error.length));
        }
    }
    Ok(())
}

/// Pixels, four bytes each.
struct Image {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

fn write(image: &Image, out: &Path) -> anyhow::Result<()> {
    let file = std::fs::File::create(out).with_context(|| format!("cannot write {}", out.display()))?;
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Best);
    encoder.set_adaptive_filter(png::AdaptiveFilterType::Adaptive);
    let rgb: Vec<u8> = image.rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&rgb));
    written.with_context(|| format!("cannot write {}", out.display()))
}

/// Memory of this process; 0 where the system does not say.
fn resident_bytes() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let resident = pages.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok());
    resident.unwrap_or(0) * 4096
}
