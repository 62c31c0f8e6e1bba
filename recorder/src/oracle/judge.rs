//! What a tracer in single precision answered, held against the truth.
//!
//! A ray that passes an edge at less than the rounding of its own coordinates may be told to have passed on
//! either side. So an answer counts as right within rounding if it is the exact one *of some parallel ray
//! nearby*: nearer than [`REACH`] of the largest coordinate of a corner as seen from the origin. At the
//! outline of an object one of those rays misses it; at an inner edge of a closed surface none does, so a
//! ray that leaks there is caught.
//!
//! Distances are compared with a tolerance per ray and triangle: moving the corners of the triangle by the
//! same reach moves the point that is hit by up to three times the reach over the triangle's height, in
//! parts of the triangle's extent in depth, but never beyond that extent. A triangle that is thinner than
//! the reach has no plane in single precision: anywhere along its longest edge will do.

use formats::ray::{Hit, Ray};

use super::line::Line;
use super::projected::{Projected, REACH, axes, size, tolerance};
use super::{ExactHit, Oracle};

/// Directions in which a parallel ray is looked for, at the full reach and at half of it.
const DIRECTIONS: u32 = 32;

/// How an answer compares with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Verdict {
    /// The oracle's own answer.
    Right,
    /// The exact answer of a ray within rounding of this one, or a triangle at the same distance within
    /// rounding, or a hit within rounding of an end of the ray.
    Tied,
    /// A triangle was hit, but not the first one.
    WrongTriangle,
    /// A triangle lies in the ray's way that was not found.
    Missed,
    /// Nothing lies in the ray's way where a hit was reported.
    FalseHit,
}

impl Verdict {
    /// Whether nothing is wrong.
    pub fn is_right(self) -> bool {
        matches!(self, Self::Right | Self::Tied)
    }
}

/// The outcome of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// How the answer compares.
    pub verdict: Verdict,
    /// How far the distance is off, if the verdict is right and there is a distance.
    pub t: Option<Deviation>,
}

/// How far a distance is off, in units in the last place of the coordinate scale: the largest coordinate of
/// the ray's origin and the triangle's corners, as an f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Size of the difference, ≥ 0.
    pub ulps: f64,
    /// How large it may be: see [`mod@super::projected`].
    pub tolerance_ulps: f64,
}

impl Oracle {
    /// Compares the nearest hit that a tracer found.
    ///
    /// # Panics
    /// If the hit names a triangle that the scene does not have.
    pub fn judge(&self, ray: &Ray, hit: &Hit) -> Judgement {
        let line = Line::new(ray);
        let exact = self.closest_on(&line);
        if !hit.is_hit() {
            return self.judge_free(&line, exact);
        }
        if let Some(exact) = exact.filter(|exact| exact.triangle == hit.triangle) {
            return self.judgement(&line, Verdict::Right, &exact, f64::from(hit.t));
        }
        match self.explain(&line, exact, hit.triangle) {
            Some(hit_nearby) => self.judgement(&line, Verdict::Tied, &hit_nearby, f64::from(hit.t)),
            None if exact.is_some() => Judgement { verdict: Verdict::WrongTriangle, t: None },
            None => Judgement { verdict: Verdict::FalseHit, t: None },
        }
    }

    /// Compares the distance at which a tracer says that a ray is blocked, `+inf` for a ray that is not. Any
    /// triangle in the ray's way will do.
    pub fn judge_occlusion(&self, ray: &Ray, distance: f32) -> Judgement {
        let line = Line::new(ray);
        if distance == f32::INFINITY {
            return self.judge_free(&line, self.closest_on(&line));
        }
        match self.blocker(&line, f64::from(distance)) {
            Some((verdict, hit)) => self.judgement(&line, verdict, &hit, f64::from(distance)),
            None => Judgement { verdict: Verdict::FalseHit, t: None },
        }
    }

    fn judge_free(&self, line: &Line, exact: Option<ExactHit>) -> Judgement {
        let verdict = match exact {
            None => Verdict::Right,
            Some(_) if self.is_free(line) => Verdict::Tied,
            Some(exact) => {
                let is_free_nearby = self.nearby(line, &[exact.triangle]).any(|nearby| self.is_free(&nearby));
                if is_free_nearby { Verdict::Tied } else { Verdict::Missed }
            }
        };
        Judgement { verdict, t: None }
    }

    fn judgement(&self, line: &Line, verdict: Verdict, exact: &ExactHit, t: f64) -> Judgement {
        let corners = &self.corners[exact.triangle as usize];
        let scale = corners.iter().flatten().fold(0.0f64, |most, x| most.max(f64::from(x.abs())));
        let scale = line.origin.iter().fold(scale, |most, x| most.max(x.abs()));
        let ulp = f64::from(scale as f32).log2().floor().exp2() * f64::from(f32::EPSILON);
        let ulps = |t: f64| t.abs() * line.speed() / ulp;
        let deviation = Deviation { ulps: ulps(t - exact.t), tolerance_ulps: ulps(tolerance(line, corners)) };
        Judgement { verdict, t: Some(deviation) }
    }

    /// A triangle's hit within rounding of a line, if nothing certainly comes before it on that line, or on one
    /// nearby.
    fn explain(&self, line: &Line, exact: Option<ExactHit>, triangle: u32) -> Option<ExactHit> {
        if let Some(hit) = self.if_first(line, self.touch(line, triangle)?) {
            return Some(hit);
        }
        let involved: Vec<u32> = [triangle].into_iter().chain(exact.map(|hit| hit.triangle)).collect();
        self.nearby(line, &involved).find_map(|nearby| self.if_first(&nearby, self.hit(&nearby, triangle)?))
    }

    /// Where a line hits a triangle, exactly or within rounding.
    fn touch(&self, line: &Line, triangle: u32) -> Option<ExactHit> {
        if let Some(hit) = self.hit(line, triangle) {
            return Some(hit);
        }
        let projected = Projected::new(line, &self.corners[triangle as usize]);
        if size(projected.nearest()) > projected.reach() {
            return None;
        }
        let nearby = self.nearby(line, &[triangle]).find_map(|nearby| self.hit(&nearby, triangle));
        nearby.or_else(|| self.edge_hit(line, triangle))
    }

    /// Where a line passes a triangle that is thinner than rounding, as none of its corners are where single
    /// precision has them: without area for all that a tracer knows, or with some.
    fn edge_hit(&self, line: &Line, triangle: u32) -> Option<ExactHit> {
        let projected = Projected::new(line, &self.corners[triangle as usize]);
        let t = projected.nearest_on_edges()[2] / line.speed();
        let is_thin = projected.height() <= projected.reach();
        is_thin.then_some(ExactHit { t, error: 0.0, triangle, u: 0.0, v: 0.0 })
    }

    /// The hit, if none comes before it on this line.
    fn if_first(&self, line: &Line, hit: ExactHit) -> Option<ExactHit> {
        let reach = hit.t - self.tolerance_on(line, hit.triangle);
        let before = self.first_that_counts(line, reach, |other| {
            other.t + self.tolerance_on(line, other.triangle) < reach
        });
        (before.is_none() && self.is_possible(line, &hit)).then_some(hit)
    }

    /// What may have blocked a ray at a distance, if not on the line itself then within rounding of it.
    fn blocker(&self, line: &Line, t: f64) -> Option<(Verdict, ExactHit)> {
        let mut found: Option<(Verdict, ExactHit)> = None;
        let endless = Line { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..*line };
        self.tree.walk_near(&endless, REACH, |triangle| {
            let exact = self.hit(line, triangle);
            let verdict = if exact.is_some() { Verdict::Right } else { Verdict::Tied };
            let apart = |hit: &ExactHit| (hit.t - t).abs();
            if let Some(hit) = exact.or_else(|| self.touch(line, triangle))
                && apart(&hit) <= self.tolerance_on(line, triangle)
                && self.is_possible(line, &hit)
                && found.is_none_or(|found| (verdict, apart(&hit)) < (found.0, apart(&found.1)))
            {
                found = Some((verdict, hit));
            }
            f64::INFINITY
        });
        found
    }

    /// Whether nothing lies in the line's way but what is within rounding of its ends.
    fn is_free(&self, line: &Line) -> bool {
        self.first_that_counts(line, line.t_max, |_| true).is_none()
    }

    /// A hit before `limit` that is certainly between the line's ends and fulfils a condition.
    fn first_that_counts(
        &self,
        line: &Line,
        limit: f64,
        condition: impl Fn(&ExactHit) -> bool,
    ) -> Option<ExactHit> {
        let limit = limit.min(line.t_max);
        let mut found = None;
        self.tree.walk(&Line { t_max: limit, ..*line }, |triangle| {
            if let Some(hit) = self.hit(line, triangle) {
                let tolerance = self.tolerance_on(line, triangle);
                let is_between = line.t_min.max(0.0) + tolerance < hit.t && hit.t + tolerance < line.t_max;
                if is_between && condition(&hit) {
                    found = Some(hit);
                }
            }
            if found.is_some() { f64::NEG_INFINITY } else { limit }
        });
        found
    }

    /// Whether a hit may be between the line's ends.
    fn is_possible(&self, line: &Line, hit: &ExactHit) -> bool {
        let tolerance = self.tolerance_on(line, hit.triangle);
        line.t_min - tolerance <= hit.t && hit.t - tolerance <= line.t_max
    }

    fn tolerance_on(&self, line: &Line, triangle: u32) -> f64 {
        tolerance(line, &self.corners[triangle as usize])
    }

    /// Parallel lines within rounding of a line, by the coordinates of some triangles: first those through the
    /// triangles' nearest points, then some all around.
    fn nearby(&self, line: &Line, triangles: &[u32]) -> impl Iterator<Item = Line> + use<> {
        let projected: Vec<Projected> = triangles
            .iter()
            .map(|&triangle| Projected::new(line, &self.corners[triangle as usize]))
            .collect();
        let reach = projected.iter().map(Projected::reach).fold(0.0, f64::max);
        let through = projected.iter().map(|projected| projected.just_inside(reach)).collect::<Vec<_>>();
        let around = (0..2 * DIRECTIONS).map(move |number| {
            let angle = std::f64::consts::TAU * f64::from(number / 2) / f64::from(DIRECTIONS);
            let radius = if number % 2 == 0 { reach } else { 0.5 * reach };
            [radius * angle.cos(), radius * angle.sin()]
        });
        let line = *line;
        let [_, across, up] = axes(&line);
        through.into_iter().filter(move |offset| size(*offset) <= reach).chain(around).map(move |[x, y]| {
            let origin = [0, 1, 2].map(|axis| line.origin[axis] + x * across[axis] + y * up[axis]);
            Line { origin, ..line }
        })
    }
}
