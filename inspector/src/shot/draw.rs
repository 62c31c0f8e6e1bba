//! Draws what a shot shows into a file, by the code that draws the window.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use anyhow::{Context as _, bail};
use egui_kittest::Harness;
use egui_wgpu::RenderState;
use serde::Serialize;

use super::{Film, Shot};
use crate::app::App;
use crate::model::background::Waker;
use crate::output::{print, print_json};
use crate::panels::Lacking;
use crate::panels::space::SpaceView;
use crate::png_file;
use crate::render::gpu::errors::Errors;
use crate::render::gpu::{self, DrawCounts};
use crate::session::ThemeChoice;
use crate::theme;

/// Frames whose times `--json` gives.
const TIMED_FRAMES: usize = 60;

/// Frames until everything has its place: the first has no size yet, and tables measure in the second.
const SETTLING_FRAMES: usize = 4;

/// How long a software GPU may take for a picture of all rays.
const PATIENCE: Duration = Duration::from_secs(900);

/// What `--json` prints.
#[derive(Serialize)]
struct Measured {
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

impl Shot {
    pub(crate) fn run(&self) -> anyhow::Result<()> {
        let (measured, lacking) = self.draw()?;
        if self.json {
            print_json(&measured)?;
        } else if self.film.is_some() {
            print(&format!("{} pictures beside {}", self.frames, self.out.display()))?;
        } else if self.out.is_file() {
            // The picture itself may have gone to standard output.
            print(&self.out.display().to_string())?;
        }
        if !lacking.is_empty() {
            let reasons: Vec<String> = lacking.into_iter().collect();
            bail!("{} says why it does not show all: {}", self.out.display(), reasons.join("; "));
        }
        Ok(())
    }

    /// Gives the times, and what the picture lacks: why, in sentences.
    fn draw(&self) -> anyhow::Result<(Measured, BTreeSet<String>)> {
        let state = render_state()?;
        let errors = Errors::of(&state.device, &Waker::default());
        let (app, theme) = self.open(state.target_format)?;
        let [width, height] = self.size.map(|side| side as f32 / self.scale);
        let mode = if theme == ThemeChoice::Light { egui::Theme::Light } else { egui::Theme::Dark };
        let mut harness = Harness::builder()
            .with_size([width, height])
            .with_pixels_per_point(self.scale)
            .with_theme(mode)
            .with_context_setup(theme::set_up)
            .with_render_cursor(false)
            .with_accessibility_check(false)
            .allow_missing_glyphs()
            .renderer(egui_kittest::wgpu::WgpuTestRenderer::from_render_state(state.clone()))
            .build_ui_state(show_all_over, Drawn { app, panel: self.view.panel });
        let worst_frame_until_ready_ms = settle(&mut harness);
        let ready_ms = milliseconds(*STARTED);
        let mut times = scrub(&mut harness, if self.json { TIMED_FRAMES } else { 1 });
        settle(&mut harness);
        // What was said before is of what was still being read.
        Lacking::take(&harness.ctx);
        harness.step();
        let lacking = Lacking::take(&harness.ctx);
        let start = Instant::now();
        let (size, rgba) = patiently(&mut harness, &state)?;
        let picture_ms = milliseconds(start);
        if let Some(error) = errors.take().first() {
            bail!("the GPU cannot draw the picture: {error}");
        }
        match self.film {
            None => png_file::write(&self.out, size, &rgba)?,
            Some(film) => self.draw_film(film, &mut harness, &state)?,
        }
        times.sort_by(f64::total_cmp);
        let measured = Measured {
            file: self.out.clone(),
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
        Ok((measured, lacking))
    }
}

impl Shot {
    /// Writes the pictures of a film.
    fn draw_film(
        &self,
        film: Film,
        harness: &mut Harness<'_, Drawn>,
        state: &RenderState,
    ) -> anyhow::Result<()> {
        let name = self.out.file_stem().unwrap_or_default().to_string_lossy();
        for frame in 0..self.frames {
            let space = harness.state_mut().space().context("a film is of the scene; --view order is one")?;
            match (film, space.camera) {
                (Film::Scrub, _) => space.options.until = (frame + 1) as f32 / self.frames as f32,
                (Film::Orbit, Some(mut camera)) if frame > 0 => {
                    camera.orbit(std::f32::consts::TAU / self.frames as f32, 0.0);
                    space.look_from(Some(camera));
                }
                (Film::Orbit, _) => {}
            }
            settle(harness);
            let (size, rgba) = patiently(harness, state)?;
            png_file::write(&self.out.with_file_name(format!("{name}-{frame:04}.png")), size, &rgba)?;
        }
        Ok(())
    }
}

/// What is drawn: a window, or one of its panels alone.
struct Drawn {
    app: App,
    panel: Option<&'static str>,
}

impl Drawn {
    /// The view into space that it has; a window's is that of its scene.
    fn space(&mut self) -> Option<&mut SpaceView> {
        self.app.panel(self.panel.unwrap_or("scene"))?.space()
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        match self.panel {
            None => self.app.show(ui),
            Some(panel) => {
                let frame = egui::Frame::central_panel(ui.style()).inner_margin(6.0);
                let show = |ui: &mut egui::Ui| self.app.show_panel(panel, ui);
                egui::CentralPanel::default().frame(frame).show(ui, show);
            }
        }
    }
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
        state.device.poll(wait).context("the GPU takes too long; `--set detail=1000` for fewer rays")?;
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
        still = if harness.state_mut().app.context.finish() { 0 } else { still + 1 };
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

fn memory() -> Memory {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let of = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        let kilobytes = line.and_then(|line| line.split_whitespace().next());
        kilobytes.and_then(|kilobytes| kilobytes.parse::<u64>().ok()).unwrap_or(0) * 1024
    };
    Memory { resident_bytes: of("VmRSS"), anonymous_bytes: of("RssAnon") }
}
