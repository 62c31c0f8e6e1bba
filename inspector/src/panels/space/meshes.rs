//! The surfaces of recordings: read once for all views, by another thread.

use std::sync::{Arc, Mutex, PoisonError};

use formats::manifest::{Place, SceneArray};
use formats::reader::{Dump, Loaded};
use formats::unit_space::UnitSpace;
use rayon::prelude::*;

use crate::model::background::{Background, Waker};
use crate::model::{Absent, Recording};
use crate::render::geometry::{Geometry, Shape};
use crate::render::surfaces::Surfaces;

/// What of a scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeshForm {
    Surfaces,
    /// Of the triangles, each once.
    Edges,
}

/// Opening of a recording, and form.
type Wanted = (u64, MeshForm);

/// What is kept: more than the three views of a window look at at once, so that none waits for what another
/// one lets go.
const KEPT: usize = 4;

/// The latest meshes of all views that share this.
#[derive(Clone, Debug, Default)]
pub struct Meshes(Arc<Mutex<Background<Wanted, Result<Geometry, String>, KEPT>>>);

impl Meshes {
    /// The mesh of a recording.
    ///
    /// # Errors
    /// Why there is none, or none yet.
    pub(super) fn of(
        &self,
        recording: &Recording,
        form: MeshForm,
        waker: &Waker,
    ) -> Result<Geometry, Absent> {
        let (dump, unit) = (recording.dump.clone(), recording.unit());
        // What was kept is whole even if something happened to the thread that held it.
        let mut meshes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = meshes.of((recording.opening, form), waker, move || read(&dump, &unit, form));
        found?.clone().map_err(Absent::from)
    }
}

fn read(dump: &Dump, unit: &UnitSpace, form: MeshForm) -> Result<Geometry, String> {
    let text = |error: formats::reader::ReadError| error.to_string();
    let positions: Loaded<[f32; 3]> = dump.array(&Place::Scene(SceneArray::Positions)).map_err(text)?;
    let triangles: Loaded<[u32; 3]> = dump.array(&Place::Scene(SceneArray::Triangles)).map_err(text)?;
    check(&positions, &triangles)?;
    // Recordings before version 8 have none.
    let colours = Place::Scene(SceneArray::Colours);
    let colours = dump.has(&colours).then(|| dump.array::<[u8; 3]>(&colours).map_err(text)).transpose()?;
    let surfaces = Surfaces::new(unit, &positions, &triangles, colours.as_deref().unwrap_or_default());
    Ok(match form {
        MeshForm::Surfaces => Shape::Mesh(surfaces).into(),
        MeshForm::Edges => Shape::edges(&surfaces).into(),
    })
}

/// That every vertex can be drawn and every corner is one: a mesh that lacks some would look like another.
fn check(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<(), String> {
    let is_finite = |point: &[f32; 3]| point.iter().all(|along| along.is_finite());
    if let Some(at) = positions.par_iter().position_first(|point| !is_finite(point)) {
        return Err(format!(
            "scene/positions.npy: vertex {at} is {:?}; `inspector verify` says more",
            positions[at]
        ));
    }
    let is_there = |corners: &[u32; 3]| corners.iter().all(|&corner| (corner as usize) < positions.len());
    if let Some(at) = triangles.par_iter().position_first(|corners| !is_there(corners)) {
        return Err(format!(
            "scene/triangles.npy: triangle {at} has corners {:?} of {} vertices; `inspector verify` says more",
            triangles[at],
            positions.len()
        ));
    }
    Ok(())
}
