//! A panel and a window without a screen, and what space shows of a selection, each waited for.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../on_disk/mod.rs"]
mod on_disk;

use std::path::PathBuf;
use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use egui_kittest::wgpu::WgpuTestRenderer;
use formats::manifest::QueueId;
use inspector::app::App;
use inspector::filter::Passing;
use inspector::model::derived::Filtered;
use inspector::model::what_if::Settings;
use inspector::model::{Absent, Context, Order};
use inspector::panels::space::layers::Layers;
use inspector::panels::space::options::SpaceOptions;
use inspector::panels::{PANELS, Panel};
use inspector::render::picture::Layer;
use inspector::theme::Theme;
use serde_json::Value;
use tempfile::TempDir;

pub(crate) use on_disk::{sample, written};
use sample::QUEUE;

/// Frames in which nothing is made any more: what is seen now stays.
const STILL_FRAMES: usize = 4;

pub(crate) struct State {
    pub(crate) panel: Box<dyn Panel>,
    pub(crate) context: Context,
}

/// A recording without problems, at this queue.
pub(crate) fn opened(dump: PathBuf, queue: QueueId) -> Context {
    let mut context = Context::open(&[dump]);
    assert!(context.problems.is_empty(), "{:?}", context.problems);
    context.go_to(queue);
    context
}

/// The same, and in this order.
pub(crate) fn ordered(dump: PathBuf, queue: QueueId, method: &str) -> Context {
    let mut context = opened(dump, queue);
    context.selection.order_by(method);
    context
}

/// The sample, in this order.
pub(crate) fn sampled(method: &str) -> (TempDir, Context) {
    let (folder, dump) = written();
    (folder, ordered(dump, QUEUE, method))
}

/// A panel of the sample in this order.
pub(crate) fn sampled_panel(name: &str, method: &str) -> (TempDir, Harness<'static, State>) {
    let (folder, context) = sampled(method);
    (folder, panel(name, context))
}

/// What another thread makes, once it is made.
pub(crate) fn awaited<T>(
    context: &mut Context,
    ask: impl Fn(&mut Context) -> Result<T, Absent>,
) -> Result<T, Absent> {
    loop {
        match ask(context) {
            Err(Absent::Awaited) => context.finish(),
            found => return found,
        };
    }
}

/// What-if settings of a method that is built in.
pub(crate) fn builtin(context: &Context, method: &str) -> Settings {
    Settings::builtin(method, &context.recording().unwrap().dump.manifest().header).unwrap()
}

/// The places of an order that pass the filter there is.
pub(crate) fn passing(context: &mut Context, order: &Arc<Order>) -> Arc<Passing> {
    let found = awaited(context, |context| match context.filtered(order) {
        Filtered::Unknown => Err(Absent::Awaited),
        filtered => Ok(filtered),
    });
    found.unwrap().passing().expect("there is a filter")
}

/// A renderer and the format that it draws in.
pub(crate) fn renderer() -> (WgpuTestRenderer, wgpu::TextureFormat) {
    let setup = egui_kittest::wgpu::default_wgpu_setup();
    let state = egui_kittest::wgpu::create_render_state(setup, egui_wgpu::RendererOptions::PREDICTABLE);
    let format = state.target_format;
    (WgpuTestRenderer::from_render_state(state), format)
}

/// A panel of 900 by 640 points.
pub(crate) fn panel(name: &str, context: Context) -> Harness<'static, State> {
    panel_made(name, [900.0, 640.0], context, Value::Null)
}

/// A panel of this size, with this of its state changed.
pub(crate) fn panel_made(
    name: &str,
    size: [f32; 2],
    context: Context,
    changed: Value,
) -> Harness<'static, State> {
    let (renderer, format) = renderer();
    let entry = PANELS.iter().find(|entry| entry.name == name).unwrap();
    let mut panel = (entry.make)(&format.into());
    if let Value::Object(changed) = changed {
        let mut state = panel.state();
        for (name, value) in changed {
            state[name] = value;
        }
        panel.set_state(state).unwrap();
    }
    let mut harness =
        Harness::builder().with_size(size).with_accessibility_check(false).renderer(renderer).build_ui_state(
            |ui, state: &mut State| state.panel.show(ui, &mut state.context),
            State { panel, context },
        );
    settle(&mut harness);
    harness
}

/// A window of 1280 by 720 points.
pub(crate) fn window(app: impl FnOnce(wgpu::TextureFormat) -> App) -> Harness<'static, App> {
    let (renderer, format) = renderer();
    let app = app(format);
    let mut harness = Harness::builder()
        .with_size([1280.0, 720.0])
        .with_accessibility_check(false)
        .renderer(renderer)
        .build_ui_state(|ui, app: &mut App| app.show(ui), app);
    settle(&mut harness);
    harness
}

/// What is drawn, with what it is drawn of.
pub(crate) trait Drawn {
    fn context(&mut self) -> &mut Context;
}

impl Drawn for State {
    fn context(&mut self) -> &mut Context {
        &mut self.context
    }
}

impl Drawn for App {
    fn context(&mut self) -> &mut Context {
        &mut self.context
    }
}

/// Whether this is on the screen.
pub(crate) fn reads<S>(harness: &Harness<'_, S>, text: &str) -> bool {
    harness.query_all_by_label(text).next().is_some()
}

/// Whether something with this in it is on the screen.
pub(crate) fn reads_in_part<S>(harness: &Harness<'_, S>, text: &str) -> bool {
    harness.query_all_by_label_contains(text).next().is_some()
}

/// Draws until nothing is being read or made.
pub(crate) fn settle(harness: &mut Harness<'_, impl Drawn>) {
    let mut still = 0;
    while still < STILL_FRAMES {
        harness.step();
        still = if harness.state_mut().context().finish() { 0 } else { still + 1 };
    }
}

/// Clicks a point, and waits for what comes of it.
pub(crate) fn click(harness: &mut Harness<'_, impl Drawn>, at: egui::Pos2) {
    harness.hover_at(at);
    harness.step();
    harness.drag_at(at);
    harness.step();
    harness.drop_at(at);
    settle(harness);
}

/// What space shows of the selection.
pub(crate) fn layers(context: &mut Context, options: &SpaceOptions) -> Vec<Layer> {
    shown_by(&mut Layers::default(), context, options)
}

/// What these layers show of the selection.
pub(crate) fn shown_by(layers: &mut Layers, context: &mut Context, options: &SpaceOptions) -> Vec<Layer> {
    let window = egui::Context::default();
    loop {
        let shown = layers.show(Theme::of(&window), options, context);
        if !context.finish() && layers.problem != Some(Absent::Awaited) {
            return shown;
        }
    }
}
