//! Embree 3 and 4, opened where they are installed: high build quality, one ray a call.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use formats::ray::{Hit, Ray};
use recorder::stages::trace::hits::Hits;
use scenes::Scene;

use crate::tracing::{Trace, for_each_ray};

/// Names by which the system's loader knows it.
const INSTALLED: [&str; 2] = ["libembree3.so.3", "libembree4.so.4"];

type Device = *mut c_void;
type SceneHandle = *mut c_void;
type Geometry = *mut c_void;

// Of `rtcore_common.h`, `rtcore_scene.h`, `rtcore_buffer.h`, `rtcore_device.h`; the same in 3 and 4.
const BUILD_QUALITY_HIGH: c_int = 2;
const SCENE_FLAG_ROBUST: c_int = 1 << 2;
const GEOMETRY_TRIANGLE: c_int = 0;
const BUFFER_INDEX: c_int = 0;
const BUFFER_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;
const PROPERTY_VERSION_MAJOR: c_int = 1;
const PROPERTY_VERSION_MINOR: c_int = 2;
const INVALID: c_uint = c_uint::MAX;

/// `RTCRayHit`. The last words are one of 3 and two of 4; both lie within the 16-byte units of the struct.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
    normal: [f32; 3],
    u: f32,
    v: f32,
    triangle: c_uint,
    geometry: c_uint,
    instance: [c_uint; 2],
}

/// `RTCIntersectContext` of Embree 3 as Debian builds it: one level of instances, no widths of curves.
#[repr(C)]
struct Context3 {
    flags: c_int,
    filter: *const c_void,
    instance: c_uint,
}

impl Context3 {
    /// As `rtcInitIntersectContext` leaves it: incoherent rays.
    const INCOHERENT: Self = Self { flags: 0, filter: std::ptr::null(), instance: INVALID };
}

// Handles and structs that these functions get are Embree's own or of its layout: that is argued where they are
// looked up, and nobody else can call them.

/// `rtcIntersect1` or `rtcOccluded1` of 3: scene, context, ray.
type Call3 = extern "C" fn(SceneHandle, &mut Context3, &mut RayHit);
/// The same of 4: scene, ray, arguments, which may be left out.
type Call4 = extern "C" fn(SceneHandle, &mut RayHit, *mut c_void);
type NewDevice = extern "C" fn(*const c_char) -> Device;
type Property = extern "C" fn(Device, c_int) -> isize;
type NewGeometry = extern "C" fn(Device, c_int) -> Geometry;
type NewBuffer = extern "C" fn(Geometry, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
type OfHandle = extern "C" fn(*mut c_void);
type Set = extern "C" fn(*mut c_void, c_int);
type NewScene = extern "C" fn(Device) -> SceneHandle;
type Attach = extern "C" fn(SceneHandle, Geometry) -> c_uint;
type LastError = extern "C" fn(Device) -> c_int;

/// Functions that the two versions call differently.
#[derive(Clone, Copy)]
enum Calls {
    Three { intersect: Call3, occluded: Call3 },
    Four { intersect: Call4, occluded: Call4 },
}

/// An opened library with a device. Both stay until the program ends: Embree's own threads outlast whatever is
/// built with it.
pub struct Library {
    library: &'static libloading::Library,
    device: Device,
    calls: Calls,
    /// As in `3.13`.
    version: String,
}

impl Library {
    /// Those that the system has, and those at these paths.
    ///
    /// # Errors
    /// If there is none or one at a path cannot be used.
    pub fn open_all(paths: &[PathBuf]) -> Result<Vec<Self>> {
        let mut libraries = Vec::new();
        for name in INSTALLED {
            // SAFETY: what an installed library does when it is loaded is the user's to trust.
            if let Ok(library) = unsafe { libloading::Library::new(name) } {
                libraries.push(Self::of(library, Path::new(name))?);
            }
        }
        for path in paths {
            // SAFETY: as above, of a library that the user names.
            let library = unsafe { libloading::Library::new(path) };
            let library = library.with_context(|| format!("cannot open {} as Embree", path.display()))?;
            libraries.push(Self::of(library, path)?);
        }
        ensure!(
            !libraries.is_empty(),
            "no Embree found; apt-get install libembree-dev, or name one by --embree"
        );
        Ok(libraries)
    }

    fn of(library: libloading::Library, path: &Path) -> Result<Self> {
        let library: &'static libloading::Library = Box::leak(Box::new(library));
        let shown = path.display();
        // SAFETY: the types are those of `rtcore_device.h`, the same in 3 and 4; no configuration is asked for.
        let (new_device, property) = unsafe {
            (library.get::<NewDevice>(b"rtcNewDevice")?, library.get::<Property>(b"rtcGetDeviceProperty")?)
        };
        let device = new_device(std::ptr::null());
        ensure!(!device.is_null(), "{shown} makes no device");
        let major = property(device, PROPERTY_VERSION_MAJOR);
        let version = format!("{major}.{}", property(device, PROPERTY_VERSION_MINOR));
        // SAFETY: the types are those of `rtcore_scene.h` of the version that the library says it is.
        let calls = unsafe {
            match major {
                3 => Calls::Three {
                    intersect: *library.get(b"rtcIntersect1")?,
                    occluded: *library.get(b"rtcOccluded1")?,
                },
                4 => Calls::Four {
                    intersect: *library.get(b"rtcIntersect1")?,
                    occluded: *library.get(b"rtcOccluded1")?,
                },
                _ => bail!("{shown} is Embree {version}, expected 3 or 4"),
            }
        };
        Ok(Self { library, device, calls, version })
    }

    /// Sets one of a geometry's or a scene's options.
    fn set(&self, function: &[u8], handle: *mut c_void, value: c_int) -> Result<()> {
        // SAFETY: the type of every function that is asked for here in the headers of 3 and 4.
        let set = unsafe { self.library.get::<Set>(function)? };
        set(handle, value);
        Ok(())
    }

    /// Says that a geometry or a scene is complete.
    fn commit(&self, function: &[u8], handle: *mut c_void) -> Result<()> {
        // SAFETY: as above.
        let commit = unsafe { self.library.get::<OfHandle>(function)? };
        commit(handle);
        Ok(())
    }

    /// A geometry of these triangles.
    fn geometry(&self, scene: &Scene) -> Result<Geometry> {
        // SAFETY: the type in `rtcore_geometry.h` of 3 and 4.
        let new = unsafe { self.library.get::<NewGeometry>(b"rtcNewGeometry")? };
        let geometry = new(self.device, GEOMETRY_TRIANGLE);
        self.set(b"rtcSetGeometryBuildQuality", geometry, BUILD_QUALITY_HIGH)?;
        self.fill(geometry, BUFFER_VERTEX, FORMAT_FLOAT3, &scene.positions)?;
        self.fill(geometry, BUFFER_INDEX, FORMAT_UINT3, &scene.triangles)?;
        self.commit(b"rtcCommitGeometry", geometry)?;
        Ok(geometry)
    }

    /// Gives a geometry a copy of these items, which are in that format.
    fn fill<T: bytemuck::Pod>(
        &self,
        geometry: Geometry,
        buffer: c_int,
        format: c_int,
        items: &[[T; 3]],
    ) -> Result<()> {
        // SAFETY: the type in `rtcore_geometry.h` of 3 and 4.
        let new = unsafe { self.library.get::<NewBuffer>(b"rtcSetNewGeometryBuffer")? };
        let room = new(geometry, buffer, 0, format, size_of::<[T; 3]>(), items.len());
        ensure!(!room.is_null(), "Embree has no room for {} items", items.len());
        // SAFETY: what Embree gives has room for as many items of this size as it was asked for.
        unsafe { std::ptr::copy_nonoverlapping(items.as_ptr(), room.cast(), items.len()) };
        Ok(())
    }
}

/// A scene of Embree's, which stays until the program ends.
pub struct Embree {
    scene: SceneHandle,
    calls: Calls,
    name: String,
}

// SAFETY: a committed scene is only read, and Embree lets any number of threads trace through it.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

impl Embree {
    /// Builds the scene, with the flag `ROBUST` or none.
    ///
    /// # Errors
    /// If the library lacks a function or reports an error.
    pub fn new(library: &Library, scene: &Scene, is_robust: bool) -> Result<Self> {
        let geometry = library.geometry(scene)?;
        // SAFETY: the types in `rtcore_scene.h` and `rtcore_device.h` of 3 and 4.
        let (new_scene, attach, last_error) = unsafe {
            (
                library.library.get::<NewScene>(b"rtcNewScene")?,
                library.library.get::<Attach>(b"rtcAttachGeometry")?,
                library.library.get::<LastError>(b"rtcGetDeviceError")?,
            )
        };
        let handle = new_scene(library.device);
        attach(handle, geometry);
        library.set(b"rtcSetSceneFlags", handle, if is_robust { SCENE_FLAG_ROBUST } else { 0 })?;
        library.set(b"rtcSetSceneBuildQuality", handle, BUILD_QUALITY_HIGH)?;
        library.commit(b"rtcCommitScene", handle)?;
        let error = last_error(library.device);
        ensure!(error == 0, "Embree {} reports error {error} while building", library.version);
        let flavour = if is_robust { "ROBUST" } else { "fast" };
        let name = format!("Embree {} {flavour}", library.version);
        Ok(Self { scene: handle, calls: library.calls, name })
    }

    /// Its name and how it traces.
    pub fn into_tracer(self) -> (String, Trace) {
        let name = self.name.clone();
        (name, Box::new(move |rays, hits| self.trace(rays, hits)))
    }

    fn trace(&self, rays: &[Ray], hits: &Hits) {
        match self.calls {
            Calls::Three { intersect, occluded } => {
                let call = |function: Call3, ray: &Ray| {
                    let (mut ray, mut context) = (RayHit::of(ray), Context3::INCOHERENT);
                    function(self.handle(), &mut context, &mut ray);
                    ray
                };
                let nearest = |ray: &Ray| call(intersect, ray).hit();
                for_each_ray(rays, hits, nearest, |ray| call(occluded, ray).is_blocked());
            }
            Calls::Four { intersect, occluded } => {
                let call = |function: Call4, ray: &Ray| {
                    let mut ray = RayHit::of(ray);
                    function(self.handle(), &mut ray, std::ptr::null_mut());
                    ray
                };
                let nearest = |ray: &Ray| call(intersect, ray).hit();
                for_each_ray(rays, hits, nearest, |ray| call(occluded, ray).is_blocked());
            }
        }
    }

    /// Of the whole, so that threads share what may be shared.
    fn handle(&self) -> SceneHandle {
        self.scene
    }
}

impl RayHit {
    #[inline]
    fn of(ray: &Ray) -> Self {
        Self {
            origin: ray.origin,
            near: ray.t_min,
            direction: ray.direction,
            time: 0.0,
            far: ray.t_max,
            mask: c_uint::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            triangle: INVALID,
            geometry: INVALID,
            instance: [INVALID; 2],
        }
    }

    #[inline]
    fn hit(&self) -> Hit {
        if self.geometry == INVALID {
            return Hit::MISS;
        }
        Hit { t: self.far, triangle: self.triangle, u: self.u, v: self.v }
    }

    /// An occluded ray ends at -inf.
    #[inline]
    fn is_blocked(&self) -> bool {
        self.far < 0.0
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    /// Offsets in `rtcore_ray.h` of 3 and 4.
    #[test]
    fn rays_are_laid_out_as_embree_reads_them() {
        assert_eq!((size_of::<RayHit>(), align_of::<RayHit>()), (96, 16));
        assert_eq!(
            (offset_of!(RayHit, near), offset_of!(RayHit, time), offset_of!(RayHit, far)),
            (12, 28, 32)
        );
        assert_eq!(
            (offset_of!(RayHit, normal), offset_of!(RayHit, u), offset_of!(RayHit, triangle)),
            (48, 60, 68)
        );
        assert_eq!((offset_of!(RayHit, geometry), offset_of!(RayHit, instance)), (72, 76));
        assert_eq!(size_of::<Context3>(), 24);
    }
}
