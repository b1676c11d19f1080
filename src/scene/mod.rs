//! What is shaded: a triangle mesh, a camera, and the light (thesis section 3.1). Host side only, no GPU.
//!
//! A Wavefront OBJ file becomes a [`Mesh`] that every later stage can trust: triangles with area, finite positions,
//! unit normals, windings that agree with the normals. What had to be dropped or repaired on the way is told as
//! [`MeshWarning`]s, and a file of which nothing is left is an error. A [`Moment`] completes the scene: [`Camera`],
//! [`Lights`] and the objects' [`Pose`]s. The guide pass draws it into shade, object ID and depth, and [`GuideOracle`]
//! is its plain CPU twin.
//!
//! ```text
//!   bytes -> obj_lines -> tobj -> obj (polygon) -> clean (normals) -> Mesh --+
//!                                                                           +--> GuidePass | GuideOracle
//!                              Camera, Lights, Poses -> Moment -------------+
//! ```
//!
//! World space is right-handed, and y is up for a camera that frames the model by itself. Vectors and matrices are
//! those of `glam`, whose types are passed on here.
//!
//! ```
//! use impasto::scene::{Camera, Framing, GuideOracle, Lights, Mesh, MeshOptions, Moment};
//!
//! let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
//! let mesh = Mesh::parse(&obj[..], "triangle.obj", &MeshOptions::default())?.mesh;
//! let camera = Camera::framing(&mesh, &Framing::default(), 4.0 / 3.0)?;
//! let guide = GuideOracle::render(&mesh, &Moment::at_rest(camera, Lights::default()), 64, 48)?;
//! assert!(guide.id.iter().any(|&id| id == 1));
//! # Ok::<(), impasto::Error>(())
//! ```

mod camera;
mod clean;
mod edges;
mod framing;
mod geometry;
mod guide;
mod guide_oracle;
mod host_motion;
mod last_guides;
mod light;
mod mesh;
mod mesh_pass;
mod moment;
mod motion;
mod normals;
mod obj;
mod obj_lines;
mod object_rows;
mod polygon;
mod solid;
mod warning;

pub(crate) use camera::{check_aspect, perspective_depth};
pub use camera::{Camera, DEFAULT_FOV_Y_DEG};
pub use framing::Framing;
pub(crate) use geometry::upload_geometry;
use geometry::upload_ordered;
pub use glam::{Mat4, Vec3};
pub(crate) use guide::GUIDE;
pub use guide::{GuideImages, GuidePass};
pub use guide_oracle::{Guide, GuideOracle, MAX_GUIDE_SIDE_PX};
pub(crate) use host_motion::HOST_MOTION;
pub use host_motion::{HostMotion, HostMotionParams};
pub use light::{DirectionalLight, Lights, MAX_LIGHTS};
pub use mesh::{BoundingSphere, Loaded, Mesh, MeshOptions, Object, MAX_OBJECTS};
pub(crate) use mesh_pass::{MeshDesc, MeshPass, Run};
pub(crate) use moment::Spheres;
pub use moment::{Moment, Pose};
pub use motion::MotionPass;
pub(crate) use motion::MOTION;
pub use obj::{MAX_FILE_BYTES, MAX_TRIANGLES, MAX_VERTICES};
pub(crate) use object_rows::ObjectRows;
pub(crate) use solid::{places, Solid};
pub use warning::MeshWarning;
