//! Pointer and keys: orbit, look, fly, zoom, frame what is selected, choose a ray.

use egui::{Key, PointerButton, Response, Ui};
use glam::Vec3;

use super::options::{Navigation, StandPoint};
use super::view::{SpaceView, bounds, stand};
use crate::model::{Context, Order};
use crate::panels::notes::{about_ray, select};
use crate::render::camera::Camera;

/// Radians for each point that the pointer is dragged.
const TURN: f32 = 0.006;
/// Farthest that the pointer may be from a ray that it chooses, points.
const REACH: f32 = 8.0;
/// Unit lengths flown in a second for each unit of distance to the target.
const FLIGHT: f32 = 1.2;
/// How many times as much with shift.
const HASTE: f32 = 4.0;

/// Takes what was done to the picture.
pub(super) fn take(ui: &Ui, response: &Response, view: &mut SpaceView, context: &mut Context) {
    let Some(recording) = context.recording() else { return };
    let at = context.selection.recording;
    let mut camera = view.camera_in(at, recording);
    let before = camera;
    drag(ui, response, view.options.navigation, &mut camera);
    if response.hovered() {
        let scroll = ui.input(|input| input.smooth_scroll_delta.y);
        camera.zoom((scroll * 0.003).exp());
    }
    // Keys belong to what has the focus, such as a number that is typed.
    if response.hovered() && !ui.ctx().egui_wants_keyboard_input() {
        keys(ui, &mut camera, view, context);
    }
    if camera != before {
        view.place(at, camera);
    }
    if let Some(pointer) = response.hover_pos().or(response.interact_pointer_pos())
        && !response.dragged()
        && let Ok(order) = context.order()
    {
        let ray = nearest(view, &order, &camera, response, pointer);
        if response.clicked() {
            select(ui, context, ray);
        }
        if let Some(ray) = ray {
            response.clone().on_hover_text_at_pointer(about_ray(&order, ray));
        }
    }
}

fn drag(ui: &Ui, response: &Response, navigation: Navigation, camera: &mut Camera) {
    let by = response.drag_delta();
    let shift = ui.input(|input| input.modifiers.shift);
    let is_primary = response.dragged_by(PointerButton::Primary) && !shift;
    if is_primary && navigation == Navigation::Orbit {
        camera.orbit(-by.x * TURN, -by.y * TURN);
    } else if is_primary || response.dragged_by(PointerButton::Secondary) {
        camera.look(-by.x * TURN, -by.y * TURN);
    } else if response.dragged() {
        let height = response.rect.height().max(1.0);
        let step = 2.0 * camera.distance * (0.5 * camera.yfov_radians).tan() / height;
        camera.fly(-by.x * step, by.y * step, 0.0);
    }
}

fn keys(ui: &Ui, camera: &mut Camera, view: &mut SpaceView, context: &mut Context) {
    let (seconds, down) = ui.input(|input| (input.stable_dt.min(0.1), input.keys_down.clone()));
    let haste = if ui.input(|input| input.modifiers.shift) { HASTE } else { 1.0 };
    let step = haste * FLIGHT * camera.distance * seconds;
    let mut is_flying = false;
    for (key, right, up, forward) in [
        (Key::W, 0.0, 0.0, 1.0),
        (Key::S, 0.0, 0.0, -1.0),
        (Key::A, -1.0, 0.0, 0.0),
        (Key::D, 1.0, 0.0, 0.0),
        (Key::Q, 0.0, -1.0, 0.0),
        (Key::E, 0.0, 1.0, 0.0),
    ] {
        if down.contains(&key) {
            camera.fly(right * step, up * step, forward * step);
            is_flying = true;
        }
    }
    if is_flying {
        ui.ctx().request_repaint();
    }
    let pressed = |key: Key| ui.input(|input| input.key_pressed(key));
    if let Some(recording) = context.recording() {
        if pressed(Key::C) {
            *camera = stand(StandPoint::Recorded, recording);
        }
        if pressed(Key::R) {
            *camera = stand(StandPoint::Overview, recording);
        }
    }
    if pressed(Key::Space) {
        view.options.is_playing = !view.options.is_playing;
    }
    if pressed(Key::G) {
        view.options.navigation = match view.options.navigation {
            Navigation::Orbit => Navigation::Fly,
            Navigation::Fly => Navigation::Orbit,
        };
    }
    if pressed(Key::F) {
        let scene = context.recording().map(|open| (Vec3::ZERO, Vec3::from(open.unit().sides)));
        let path = view.layers.paths().and_then(|path| bounds(path.iter().map(|ray| ray.segment)));
        if let Some((low, high)) = path.or_else(|| selected_box(context)).or(scene) {
            camera.frame(low, high);
        }
    }
}

/// The box around the selected group, or else the selected ray.
fn selected_box(context: &mut Context) -> Option<(Vec3, Vec3)> {
    let order = context.order().ok()?;
    let rays: Vec<usize> = match (context.selection.group, context.selection.ray) {
        (Some(group), _) => {
            let places = order.places_of_group(group, context.selection.group_width);
            places.map(|place| order.places.ray(place)).collect()
        }
        (None, Some(ray)) => vec![ray],
        (None, None) => return None,
    };
    bounds(rays.into_iter().map(|ray| order.queue.segment(ray)))
}

/// The ray shown whose origin or hit point, or whose line if rays are drawn, is nearest to the pointer.
fn nearest(
    view: &SpaceView,
    order: &Order,
    camera: &Camera,
    response: &Response,
    pointer: egui::Pos2,
) -> Option<usize> {
    let rect = response.rect;
    let clip = camera.clip_from_unit(rect.width() / rect.height().max(1.0));
    let on_screen = |point: [f64; 3]| {
        let clip = clip * Vec3::from(point.map(|along| along as f32)).extend(1.0);
        (clip.w > 1e-4).then(|| {
            let part = egui::vec2(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
            rect.min + part * rect.size()
        })
    };
    let away = |ray: usize| {
        let (segment, options) = (order.queue.segment(ray), &view.options);
        let (from, to) = match options.rays {
            true => (segment.origin, segment.end),
            // Where hit points are all that is shown, they are what is pointed at.
            false if options.ends && !options.curve => (segment.end, segment.end),
            false => (segment.origin, segment.origin),
        };
        let (from, to) = (on_screen(from)?, on_screen(to)?);
        let (along, offset) = (to - from, pointer - from);
        let part = (along.dot(offset) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
        Some((offset - part * along).length())
    };
    let rays = view.layers.places().map(|place| order.places.ray(place));
    let found = rays.filter_map(|ray| Some((away(ray)?, ray))).min_by(|a, b| a.0.total_cmp(&b.0))?;
    (found.0 <= REACH).then_some(found.1)
}
