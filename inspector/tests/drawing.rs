//! Pictures of space: what is drawn where, and what a GPU has no room for. Without an adapter these tests fail.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::f32::consts::TAU;
use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_wgpu::RenderState;
use formats::unit_space::UnitSpace;
use glam::Vec3;
use inspector::model::background::Waker;
use inspector::render::camera::Camera;
use inspector::render::geometry::{CapsuleInstance, Shape, Vertex};
use inspector::render::gpu::PictureCallback;
use inspector::render::gpu::errors::{Errors, Refusal};
use inspector::render::picture::{Cut, Layer, Paint, SpacePicture, Stage};
use inspector::render::surfaces::Surfaces;
use inspector::theme::Theme;

mod headless;

use headless::renderer;

const WHITE: Paint = Paint::Plain([1.0; 4]);

/// Pixels by column and row of a picture of these surfaces.
fn picture(surfaces: Surfaces, camera: Camera, pixels: [u32; 2]) -> impl Fn(u32, u32) -> [u8; 3] {
    let refusal = Refusal::default();
    let shape = Shape::Mesh(surfaces);
    let pixel = drawn(renderer(), (shape, Stage::Solid, WHITE), (camera, pixels, None), &refusal);
    assert_eq!(refusal.reason(), None);
    pixel
}

/// The same by this renderer, which may refuse.
fn drawn(
    (renderer, format): (WgpuTestRenderer, wgpu::TextureFormat),
    (shape, stage, paint): (Shape, Stage, Paint),
    (camera, pixels, room): (Camera, [u32; 2], Option<[f32; 3]>),
    refusal: &Refusal,
) -> impl Fn(u32, u32) -> [u8; 3] + use<> {
    let theme = Theme::of(&egui::Context::default());
    let layers = vec![Layer { width: 1.0, ..Layer::of(&shape.into(), stage, paint, 1.0) }];
    let picture = Arc::new(SpacePicture {
        camera,
        pixels,
        background: theme.background(),
        cut: Cut::NONE,
        room,
        layers,
    });
    let size = egui::Vec2::from(pixels.map(|side| side as f32));
    let refusal = (refusal.clone(), Waker::default());
    let harness = Harness::builder().with_size(size).with_pixels_per_point(1.0).renderer(renderer);
    let mut harness = harness.build_ui(move |ui| {
        let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
        let (picture, refusal) = (picture.clone(), refusal.clone());
        let callback = PictureCallback { view: 0, format, picture, refusal };
        ui.painter().with_clip_rect(rect).add(callback.shape(rect));
    });
    let image = harness.render().unwrap();
    assert_eq!([image.width(), image.height()], pixels);
    move |column, row| {
        let [red, green, blue, _] = image.get_pixel(column, row).0;
        [red, green, blue]
    }
}

/// A ball of so many triangles around.
fn ball(around: u32) -> (Surfaces, usize) {
    let point = |column: u32, row: u32| {
        let yaw = TAU * column as f32 / around as f32;
        let pitch = TAU * row as f32 / around as f32;
        [
            0.5 + RADIUS * pitch.sin() * yaw.cos(),
            0.5 + RADIUS * pitch.cos(),
            0.5 + RADIUS * pitch.sin() * yaw.sin(),
        ]
    };
    let at = |column: u32, row: u32| row * around + column % around;
    let each = |rows: u32| (0..rows).flat_map(move |row| (0..around).map(move |column| (column, row)));
    let positions: Vec<_> = each(around / 2 + 1).map(|(column, row)| point(column, row)).collect();
    let triangles: Vec<_> = each(around / 2)
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
    (Surfaces::new(&unit, &positions, &triangles, &[]), triangles.len())
}

const RADIUS: f32 = 0.3;

/// From where a ball is looked at.
fn camera() -> Camera {
    Camera { target: Vec3::splat(0.5), yaw: 0.7, pitch: -0.4, distance: 4.0, yfov_radians: 0.6 }
}

/// A ball whose triangles are much smaller than pixels: most are not drawn, and no pixel lacks them.
#[test]
fn surfaces_have_no_holes_where_triangles_are_not_drawn() {
    let (ball, triangles) = ball(1200);
    let (camera, pixels) = (camera(), [320, 240]);
    let drawn: usize = ball.in_sight(&camera, pixels).map(|(triangles, _)| triangles.len()).sum();
    assert!(drawn > 0 && drawn < triangles / 5, "{drawn} of {triangles} triangles are drawn");
    let pixel = picture(ball, camera, pixels);
    // The outline of a ball is where lines of sight touch it.
    let outline = RADIUS / (4.0f32.powi(2) - RADIUS.powi(2)).sqrt() / 0.3f32.tan() * 120.0;
    let background = pixel(0, 0);
    for (column, row) in (0..pixels[0]).flat_map(|column| (0..pixels[1]).map(move |row| (column, row))) {
        let from_centre = (column as f32 + 0.5 - 160.0).hypot(row as f32 + 0.5 - 120.0);
        let colour = pixel(column, row);
        if from_centre < outline - 2.0 {
            // Brightest where it faces the eye: 0.42 of white everywhere, 0.9 and more in the middle.
            let lowest = if from_centre < 0.3 * outline { 200 } else { 100 };
            assert!(colour[0] > lowest, "{colour:?} at {column}, {row}, {from_centre} from the centre");
        } else if from_centre > outline + 2.0 {
            assert_eq!(colour, background, "at {column}, {row}, {from_centre} from the centre");
        }
    }
}

/// Three squares side by side that face the eye: red, white, and one without a colour of its own.
#[test]
fn surfaces_have_their_colours_fainter_than_data() {
    let camera = Camera { target: Vec3::splat(0.5), yaw: 0.0, pitch: 0.0, distance: 4.0, yfov_radians: 0.3 };
    let corner = |along: f32, up: f32| {
        (camera.target + (along - 0.5) * camera.right() + (up - 0.5) * camera.up()).to_array()
    };
    let square = |at: usize| [(at, 0), (at + 1, 0), (at, 1), (at + 1, 1)];
    let corners = (0..3).flat_map(square).map(|(along, up)| corner(along as f32 / 3.0, up as f32));
    let corners: Vec<[f32; 3]> = corners.collect();
    let triangles: Vec<[u32; 3]> =
        (0..3).flat_map(|at| [[0, 1, 2], [2, 1, 3]].map(|t| t.map(|c| c + 4 * at))).collect();
    let colours = [[255, 0, 0], [255, 0, 0], [255; 3], [255; 3]];
    let unit = UnitSpace::from_bounds([0.0; 3], [1.0; 3]);
    let shown = |paint| {
        let shape = Shape::Mesh(Surfaces::new(&unit, &corners, &triangles, &colours));
        let refusal = Refusal::default();
        let pixel = drawn(renderer(), (shape, Stage::Solid, paint), (camera, [300, 100], None), &refusal);
        [110, 150, 190].map(|column| pixel(column, 50))
    };
    let context = egui::Context::default();
    for mode in [egui::Theme::Dark, egui::Theme::Light] {
        context.set_theme(mode);
        let theme = Theme::of(&context);
        let [red, white, none] = shown(Paint::Base { plain: theme.mesh(), faded: theme.faded() });
        assert!(red[0] > red[1] + 40 && red[1].abs_diff(red[2]) < 6, "{mode:?}: {red:?}");
        let is_grey = |[red, green, blue]: [u8; 3]| red.abs_diff(green) < 6 && green.abs_diff(blue) < 12;
        assert!(is_grey(white) && is_grey(none), "{mode:?}: {white:?}, {none:?}");
        // No surface reaches the last third of what is as far from the page as can be.
        let of_page = |colour: u8| if mode == egui::Theme::Dark { colour } else { 255 - colour };
        assert!(
            [red, white].as_flattened().iter().all(|&part| of_page(part) < 170),
            "{mode:?}: {red:?}, {white:?}"
        );
        // With data on them all are alike, but for the angle at which each is seen.
        let plain = shown(Paint::Plain(theme.mesh()));
        let is_like = |pixel: [u8; 3]| (0..3).all(|part| pixel[part].abs_diff(none[part]) <= 2);
        assert!(plain.into_iter().all(is_like), "{mode:?}: {plain:?}, {none:?}");
    }
}

/// A renderer whose device has less to offer.
fn limited(limit: impl Fn(&mut wgpu::Limits) + Send + Sync + 'static) -> (RenderState, WgpuTestRenderer) {
    let mut setup = default_wgpu_setup();
    let egui_wgpu::WgpuSetup::CreateNew(new) = &mut setup else { panic!("not a new device") };
    let by_itself = new.device_descriptor.clone();
    new.device_descriptor = Arc::new(move |adapter| {
        let mut device = by_itself(adapter);
        limit(&mut device.required_limits);
        device
    });
    let state = create_render_state(setup, egui_wgpu::RendererOptions::PREDICTABLE);
    let renderer = WgpuTestRenderer::from_render_state(state.clone());
    (state, renderer)
}

/// As a GPU is for a very large scene.
#[test]
fn what_a_gpu_has_no_room_for_is_said_and_not_drawn() {
    let refusal = Refusal::default();
    for (around, is_drawn) in [(1200, false), (100, true)] {
        let (state, renderer) = limited(|limits| limits.max_buffer_size = 1 << 20);
        let errors = Errors::of(&state.device, &Waker::default());
        let shape = (Shape::Mesh(ball(around).0), Stage::Solid, WHITE);
        let pixel = drawn((renderer, state.target_format), shape, (camera(), [64, 48], None), &refusal);
        assert_eq!(pixel(32, 24)[0] > 100, is_drawn, "a ball of {around} around");
        let reason = refusal.reason().unwrap_or_default();
        assert_eq!(reason.contains("1 MiB"), !is_drawn, "{reason}");
        assert_eq!(errors.take(), Vec::<String>::new());
    }
}

/// Lines that are too many for a binding are drawn all the same: along rows, as a strip and by themselves.
#[test]
fn lines_are_drawn_in_as_many_runs_as_it_takes() {
    const ROWS: usize = 100;
    const STEPS: usize = 10;
    let camera = Camera { target: Vec3::splat(0.5), yaw: 0.0, pitch: 0.0, distance: 4.0, yfov_radians: 0.2 };
    let [right, up] = [camera.right(), camera.up()];
    let point = |row: usize, step: usize| {
        let along = [step as f32 / STEPS as f32 - 0.5, row as f32 / ROWS as f32 - 0.5];
        let position = camera.target + along[0] * 0.5 * right + along[1] * 0.5 * up;
        Vertex { position: position.into(), value: 0.0 }
    };
    // To and fro, so that the strip has no lines across.
    let of_row = |row: usize| {
        (0..=STEPS).map(move |step| if row.is_multiple_of(2) { (row, step) } else { (row, STEPS - step) })
    };
    let strip: Vec<Vertex> = (0..ROWS).flat_map(of_row).map(|(row, step)| point(row, step)).collect();
    let pairs: Vec<[Vertex; 2]> = strip.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    let pixels = [320, 240];
    let mut pictures = Vec::new();
    for shape in [Shape::Strip(strip), Shape::Segments(pairs)] {
        for binding in [128 << 20, 4096] {
            let (state, renderer) = limited(move |limits| limits.max_storage_buffer_binding_size = binding);
            let errors = Errors::of(&state.device, &Waker::default());
            let shape = (shape.clone(), Stage::Lines, WHITE);
            let pixel =
                drawn((renderer, state.target_format), shape, (camera, pixels, None), &Refusal::default());
            assert_eq!(errors.take(), Vec::<String>::new());
            let rows = 0..pixels[1];
            pictures.push(
                rows.flat_map(|row| (0..pixels[0]).map(move |column| (column, row)))
                    .map(|(column, row)| pixel(column, row))
                    .collect::<Vec<_>>(),
            );
        }
    }
    let lit = pictures[0].iter().filter(|colour| colour[0] > 100).count();
    let all = pictures[0].len();
    assert!(lit > all / 10 && lit < all / 2, "{lit} of {all} pixels");
    for picture in &pictures[1..] {
        assert!(*picture == pictures[0], "runs or pairs of points are drawn otherwise");
    }
}

/// A capsule is its outline: clear where it faces the eye, and not there at all for an eye inside of it.
#[test]
fn capsules_are_silhouettes() {
    let capsule = CapsuleInstance {
        origins: [0.5, 0.5, 0.3, RADIUS],
        ends: [0.5, 0.5, 0.7, RADIUS],
        value: 0.0,
        padding: [0.0; 3],
    };
    let pixels = [160, 120];
    let seen = |distance: f32| {
        let shape = (Shape::Capsules(vec![capsule]), Stage::Capsules, WHITE);
        drawn(renderer(), shape, (Camera { distance, ..camera() }, pixels, None), &Refusal::default())
    };
    let outside = seen(4.0);
    let (background, middle) = (outside(0, 0)[0], outside(80, 60)[0]);
    let brightest = (0..pixels[0]).map(|column| outside(column, 60)[0]).max().unwrap();
    assert!(middle > background && middle - background < 50, "{middle} before {background}");
    assert!(brightest - background > 100, "{brightest} before {background}");
    let inside = seen(0.05);
    for (column, row) in (0..pixels[0]).flat_map(|column| (0..pixels[1]).map(move |row| (column, row))) {
        assert_eq!(inside(column, row)[0], background, "fog at {column}, {row}");
    }
}

/// Of a room that is seen from outside, the walls before its middle are left out: which is which does not depend on
/// how their corners run. Its floor stays, and what stands in it.
#[test]
fn a_room_is_looked_into_from_outside() {
    let sides = [1.0, 0.5, 1.0];
    let camera = Camera::overview(sides);
    let (unit, pixels) = (UnitSpace::from_bounds([0.0; 3], [1.0; 3]), [160, 120]);
    // A square across an axis.
    let is_seen = |axis: usize, at: f32, room: Option<[f32; 3]>| {
        [[0, 1, 2, 3], [3, 2, 1, 0]].map(|corners| {
            let corner = |corner: usize| {
                let mut position = [0.4, 0.2, 0.4];
                position[(axis + 1) % 3] += 0.2 * (corner & 1) as f32;
                position[(axis + 2) % 3] += 0.2 * (corner >> 1) as f32;
                position[axis] = at;
                position
            };
            let triangles = [[0, 1, 2], [1, 3, 2]];
            let surfaces = Surfaces::new(&unit, &corners.map(corner), &triangles, &[]);
            let shape = (Shape::Mesh(surfaces), Stage::Solid, WHITE);
            let pixel = drawn(renderer(), shape, (camera, pixels, room), &Refusal::default());
            let all = (0..pixels[0]).flat_map(|column| (0..pixels[1]).map(move |row| (column, row)));
            all.map(|(column, row)| pixel(column, row)[0]).max() > Some(100)
        })
    };
    let eye = camera.eye();
    for axis in 0..3 {
        let (near, far) = if eye[axis] > sides[axis] { (sides[axis], 0.0) } else { (0.0, sides[axis]) };
        assert_eq!(is_seen(axis, near, None), [true; 2], "the whole of axis {axis}");
        assert_eq!(is_seen(axis, near, Some(sides)), [false; 2], "the near wall of axis {axis}");
        assert_eq!(is_seen(axis, far, Some(sides)), [true; 2], "the far wall of axis {axis}");
        let inner = 0.5 * sides[axis] + 0.1 * (near - far);
        assert_eq!(
            is_seen(axis, inner, Some(sides)),
            [true; 2],
            "what stands before the middle of axis {axis}"
        );
    }
}

/// Without the handler, wgpu would end the program.
#[test]
fn errors_of_a_device_are_told_once() {
    let state = create_render_state(default_wgpu_setup(), egui_wgpu::RendererOptions::PREDICTABLE);
    let errors = Errors::of(&state.device, &Waker::default());
    for _ in 0..2 {
        let size = state.device.limits().max_buffer_size + 4;
        let usage = wgpu::BufferUsages::VERTEX;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        drop(state.device.create_buffer(&descriptor));
    }
    let told = errors.take();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("buffer"), "{told:?}");
    assert!(errors.take().is_empty());
}
