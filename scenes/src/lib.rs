//! From a file or a built-in name to a scene that can be traced. CPU only.
pub mod camera;
pub mod light;
pub mod material;
pub mod scene;
pub use camera::Camera;
pub use light::{Environment, Light};
pub use material::{Material, Texture};
pub use scene::Scene;
