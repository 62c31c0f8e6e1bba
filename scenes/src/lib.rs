//! From a file or a built-in name to a scene that can be traced. CPU only.
//!
//! [`load`] turns a `.gltf`, `.glb` or `builtin:NAME` into a [`Scene`]: world-space triangles
//! (instances flattened), materials, lights and cameras. [`features::Features`] says what of all
//! that the scene uses, [`bvh`] builds and caches the hierarchies that tracers walk.

mod automatic;
pub mod base_colour;
pub mod bounds;
mod brightness;
pub mod builtin;
pub mod bvh;
pub mod camera;
pub mod features;
mod files;
pub mod gltf;
pub mod hash;
pub mod light;
pub mod load;
pub mod material;
pub mod memory;
pub mod scene;
mod shown;
pub mod sidecar;
pub mod views;

pub use camera::Camera;
pub use light::{Environment, Light};
pub use load::{LoadError, load};
pub use material::{Material, Texture};
pub use scene::Scene;
