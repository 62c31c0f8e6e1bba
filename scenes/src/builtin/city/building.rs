//! Towers with setbacks and blocks of flats.

use glam::{DAffine3, DVec2, DVec3, dvec2, dvec3};

use super::super::mesh::Canvas;
use super::super::shapes::{band, block, place, revolve, tube};
use super::{HALF_LOT, KERB, Paint, Plot};

/// A stretch of façade of one footprint, from some height upwards.
struct Tier {
    /// Half the footprint.
    half: DVec2,
    /// Height of its foot.
    foot: f64,
    floors: u32,
    floor_height: f64,
}

impl Tier {
    fn top(&self) -> f64 {
        self.foot + f64::from(self.floors) * self.floor_height
    }

    fn rectangle(&self) -> [DVec2; 2] {
        [-self.half, self.half]
    }
}

/// One large tower on a podium, or four smaller ones.
pub(super) fn tower_block(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot) {
    let is_single = plot.dice.chance(0.4);
    if is_single {
        let podium = Tier { half: DVec2::splat(HALF_LOT - 1.0), foot: KERB, floors: 3, floor_height: 4.5 };
        let frame = plot.frame;
        let half = dvec2(plot.dice.between(13.0, 18.0), plot.dice.between(12.0, 17.0));
        if !plot.is_vacant(0, 4) {
            glass_tier(canvas, paint, plot, &frame, &podium, paint.sandstone);
            roof(canvas, paint, plot, &frame, &podium);
        }
        if !plot.is_vacant(1, 4) {
            tower(canvas, paint, plot, &frame, half, podium.top());
        }
    } else {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        for (lot, (x, z)) in (0..).zip(corners) {
            if plot.is_vacant(lot, 4) {
                break;
            }
            let frame = plot.frame * place(0.52 * HALF_LOT * x, 0.0, 0.52 * HALF_LOT * z, 0.0);
            let half = dvec2(plot.dice.between(8.0, 11.0), plot.dice.between(8.0, 11.0));
            if plot.dice.chance(0.6) {
                tower(canvas, paint, plot, &frame, half, KERB);
            } else {
                flats(canvas, paint, plot, &frame, half, 12);
            }
        }
    }
}

/// Four blocks of flats around a yard with trees.
pub(super) fn flats_block(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot) {
    for side in 0..4 {
        if plot.is_vacant(side, 4) {
            break;
        }
        let out = HALF_LOT - 7.5;
        let frame = plot.frame * place(0.0, 0.0, 0.0, 0.25 * f64::from(side));
        let frame = frame * place(-7.0, 0.0, out, 0.0);
        let half = dvec2(plot.dice.between(13.0, 16.0), 6.5);
        let floors = 4 + plot.dice.below(5) as u32;
        flats(canvas, paint, plot, &frame, half, floors);
    }
    for _ in 0..3 {
        let frame = plot.frame
            * place(plot.dice.between(-6.0, 6.0), KERB, plot.dice.between(-6.0, 6.0), plot.dice.unit());
        let height = plot.dice.between(5.0, 8.0);
        super::tree(canvas, paint, plot, &frame, height);
    }
}

/// A tower that steps back as it rises.
fn tower(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot, frame: &DAffine3, half: DVec2, foot: f64) {
    let plot = &mut plot.part();
    let tiers = 1 + plot.dice.below(4) as u32;
    let nearness = (1.0 - plot.distance() / 4.0).max(0.2);
    let floors = 8 + (plot.dice.between(0.2, 1.0) * 38.0 * nearness * plot.built_up) as u32;
    let ribs = [paint.concrete, paint.steel, paint.sandstone, paint.white][plot.dice.below(4)];
    let mut tier = Tier { half, foot, floors: 0, floor_height: 3.5 };
    for index in 0..tiers {
        tier.foot = tier.top();
        tier.floors = (floors / tiers).max(3);
        if index > 0 {
            tier.half *= plot.dice.between(0.7, 0.88);
        }
        glass_tier(canvas, paint, plot, frame, &tier, ribs);
        roof(canvas, paint, plot, frame, &tier);
    }
    let spire = plot.dice.chance(0.5);
    if spire {
        let top = tier.top();
        let height = 0.25 * (top - foot);
        let path = [0.0, 0.5, 1.0].map(|t| frame.transform_point3(dvec3(0.0, top + height * t, 0.0)));
        tube(canvas, paint.steel, &path, |t| 0.45 - 0.4 * t, 6);
    }
}

/// A glass core with a ledge on every floor and ribs up the façade.
fn glass_tier(canvas: &mut Canvas, paint: &Paint, plot: &Plot, frame: &DAffine3, tier: &Tier, ribs: u32) {
    let Tier { half, foot, floors, floor_height } = *tier;
    let (low, high) = (dvec3(-half.x, foot, -half.y), dvec3(half.x, tier.top(), half.y));
    block(canvas, paint.glass, frame, low, high);
    let ledges = plot.steps(canvas, f64::from(floors), 1).min(floors);
    for ledge in 0..ledges {
        let y = foot + (tier.top() - foot) * f64::from(ledge) / f64::from(ledges);
        let thickness = 0.28 * floor_height;
        let profile = [[0.0, y], [0.22, y], [0.22, y + thickness], [0.0, y + thickness]];
        band(canvas, ribs, frame, tier.rectangle(), &profile);
    }
    for side in 0..4 {
        let (facade, width) = facade(frame, half, side);
        let bays = plot.steps(canvas, width / 1.5, 1);
        for rib in 0..=bays {
            let x = width * (2.0 * f64::from(rib) / f64::from(bays) - 1.0);
            let (low, high) = (dvec3(x - 0.16, foot, -0.1), dvec3(x + 0.16, tier.top(), 0.34));
            block(canvas, ribs, &facade, low, high);
        }
    }
}

/// The frame of one side of a footprint, x along it and z outwards, and half its width.
fn facade(frame: &DAffine3, half: DVec2, side: u32) -> (DAffine3, f64) {
    let (out, width) = if side.is_multiple_of(2) { (half.y, half.x) } else { (half.x, half.y) };
    let turned = *frame * place(0.0, 0.0, 0.0, 0.25 * f64::from(side));
    (turned * place(0.0, 0.0, out, 0.0), width)
}

/// Brick or plaster flats: walls between the windows, sills, balconies, a parapet.
fn flats(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot, frame: &DAffine3, half: DVec2, floors: u32) {
    let plot = &mut plot.part();
    let wall = [paint.brick, paint.sandstone, paint.white, paint.concrete][plot.dice.below(4)];
    let tier = Tier { half, foot: KERB, floors, floor_height: 3.1 };
    let top = tier.top();
    let (low, high) = (dvec3(-half.x, KERB, -half.y), dvec3(half.x, top, half.y));
    block(canvas, paint.glass, frame, low, high);
    for floor in 0..floors {
        let y = KERB + tier.floor_height * f64::from(floor);
        let foot = if floor == 0 { y } else { y - 0.55 };
        let profile = [[0.0, foot], [0.25, foot], [0.25, y + 0.9], [0.0, y + 0.9]];
        band(canvas, wall, frame, tier.rectangle(), &profile);
    }
    let profile = [[0.0, top - 0.6], [0.25, top - 0.6], [0.45, top - 0.2], [0.45, top], [0.0, top]];
    band(canvas, wall, frame, tier.rectangle(), &profile);
    for side in 0..4 {
        let (facade, width) = facade(frame, half, side);
        windows(canvas, plot, &facade, &tier, width, wall);
    }
    roof(canvas, paint, plot, frame, &tier);
}

/// Walls between the windows of one façade, sills below them, and columns of balconies.
fn windows(canvas: &mut Canvas, plot: &mut Plot, facade: &DAffine3, tier: &Tier, width: f64, wall: u32) {
    let bays = plot.steps(canvas, width / 1.4, 1).max(2);
    let bay = 2.0 * width / f64::from(bays);
    for pier in 0..=bays {
        let x = -width + bay * f64::from(pier);
        let (low, high) = (dvec3(x - 0.45, KERB, -0.1), dvec3(x + 0.45, tier.top(), 0.25));
        block(canvas, wall, facade, low, high);
    }
    for column in 0..bays {
        let x = -width + bay * (f64::from(column) + 0.5);
        let balconies = plot.dice.chance(0.2) && plot.keeps(canvas);
        for floor in 1..tier.floors {
            let y = KERB + tier.floor_height * f64::from(floor);
            let bare = !plot.dice.chance(0.45 * plot.richness);
            if balconies {
                balcony(canvas, facade, x, y, 0.42 * bay, wall);
            } else if !bare {
                let reach = 0.5 * bay - 0.38;
                let (low, high) = (dvec3(x - reach, y + 0.9, 0.0), dvec3(x + reach, y + 0.97, 0.42));
                block(canvas, wall, facade, low, high);
            }
        }
    }
}

/// A slab with a parapet on three sides.
fn balcony(canvas: &mut Canvas, facade: &DAffine3, x: f64, y: f64, half: f64, material: u32) {
    let mut part = |low: [f64; 3], high: [f64; 3]| {
        let offset = dvec3(x, y, 0.25);
        block(canvas, material, facade, offset + DVec3::from(low), offset + DVec3::from(high));
    };
    part([-half, -0.12, 0.0], [half, 0.0, 1.2]);
    part([-half, 0.0, 1.12], [half, 1.0, 1.2]);
    part([-half, 0.0, 0.0], [-half + 0.08, 1.0, 1.12]);
    part([half - 0.08, 0.0, 0.0], [half, 1.0, 1.12]);
}

/// A flat roof: felt, parapet, stair head, vents and sometimes a water tank.
fn roof(canvas: &mut Canvas, paint: &Paint, plot: &mut Plot, frame: &DAffine3, tier: &Tier) {
    let (half, top) = (tier.half, tier.top());
    let (low, high) = (dvec3(-half.x, top, -half.y), dvec3(half.x, top + 0.1, half.y));
    block(canvas, paint.roof, frame, low, high);
    let profile = [[0.0, top], [0.3, top], [0.3, top + 0.9], [0.0, top + 0.9], [0.0, top + 0.1]];
    band(canvas, paint.concrete, frame, tier.rectangle(), &profile);
    let mut somewhere = |share: f64| {
        let x = plot.dice.between(-share, share) * half.x;
        place(x, top + 0.1, plot.dice.between(-share, share) * half.y, 0.0)
    };
    let stair = *frame * somewhere(0.4);
    let vents: Vec<DAffine3> = (0..4).map(|_| *frame * somewhere(0.8)).collect();
    let tank = *frame * somewhere(0.6);
    block(canvas, paint.concrete, &stair, dvec3(-1.6, 0.0, -2.0), dvec3(1.6, 2.6, 2.0));
    for vent in &vents {
        block(canvas, paint.steel, vent, dvec3(-0.6, 0.0, -0.5), dvec3(0.6, 0.9, 0.5));
    }
    if plot.dice.chance(0.4) {
        let around = plot.steps(canvas, 14.0, 6);
        let profile = [[1.3, 1.6], [1.3, 4.2], [0.0, 5.2]];
        let floor = [[0.0, 1.6], [1.3, 1.6]];
        revolve(canvas, paint.bark, &tank, &[&floor, &profile[..2], &profile[1..]], [around, 1]);
        for (x, z) in [(-0.8, -0.8), (0.8, -0.8), (0.8, 0.8), (-0.8, 0.8)] {
            let (low, high) = (dvec3(x - 0.08, 0.0, z - 0.08), dvec3(x + 0.08, 1.6, z + 0.08));
            block(canvas, paint.steel, &tank, low, high);
        }
    }
}
