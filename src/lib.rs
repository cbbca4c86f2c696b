//! Kugelblitz: a ray tracer for spheres and planes that proves which object every ray sees, and every byte
//! of the picture.
//!
//! A [`Scene`](scene::Scene), a [`Device`](device::Device) and a [`Kernel`](query::Kernel) make a
//! [`Session`]; rays and cameras go in, [`Hits`](query::Hits) and pictures come out. With
//! [`Kernel::Certified`](query::Kernel::Certified) the object of every hit is the one that exact
//! arithmetic sees.
//!
//! ```
//! use kugelblitz::Session;
//! use kugelblitz::device::Device;
//! use kugelblitz::scene::parse_scene;
//! use kugelblitz::query::Kernel;
//!
//! fn main() -> kugelblitz::Result<()> {
//!     let text = r##"
//!         camera = { position = [0, 0, 5], look_at = [0, 0, 0] }
//!         sphere = [{ center = [0, 0, 0], radius = 1, color = "#d62728" }]
//!     "##;
//!     let scene = parse_scene(text, "ball.toml".as_ref())?; // the path is for messages
//!     let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
//!     let picture = session.render(161, 121)?;
//!     assert_eq!(picture.hits.id[60 * 161 + 80], 1); // the centre pixel sees object 1, the sphere
//!     assert_eq!(picture.hits.t[60 * 161 + 80], 4.0);
//!     assert_eq!(picture.srgb8[0], [0, 0, 0]); // the corner sees the background
//!     Ok(())
//! }
//! ```
//!
//! [`Device::best`](device::Device::best) is a Vulkan device where there is one. The folder
//! `examples/` has more: a picture of a scene from memory, a million spheres and rays from arrays.
//! [`scene::Spheres`] takes rows of numbers as they are, 32 bytes each; vectors are types of `glam`, and
//! arrays go `into()` them.
//!
//! # Conventions
//! - **Numbers.** A scene's numbers are f64. What a scene means is exact real arithmetic on them;
//!   every kernel is an approximation of that meaning and is judged by it.
//! - **World.** Right-handed; any unit of length, the same everywhere.
//! - **Ray.** `p(t) = o + t·d`, where `d` is not zero and not normalised. So `t` is a length only
//!   where `d` is a unit vector.
//! - **Camera.** `forward = normalize(look_at − position)`, `right = normalize(forward × up)`,
//!   `true_up = right × forward`; perspective: `h = tan(fov/2)` with the vertical field of view;
//!   orthographic: `h = height/2`. They are computed once in f64, and those f64 numbers then are the
//!   camera: [`rays::View`].
//! - **Pixel.** Column `x` from the left, row `y` from the top, both from 0. Its ray goes through
//!   its centre. With `across = (2(x+½)/W − 1)·h·(W/H)·right + (1 − 2(y+½)/H)·h·true_up`, a
//!   perspective camera has `o = position`, `d = forward + across`, an orthographic one
//!   `o = position + across`, `d = forward`. As `d·forward = 1`, `t` is the depth along the view axis.
//! - **Sphere.** `‖p − c‖ = r` with `r > 0`. The roots of `a·t² + b·t + k = 0` with `a = d·d`,
//!   `b = 2·d·(o − c)`, `k = (o − c)·(o − c) − r²`. The discriminant is `D = b² − 4ak`; `D = 0`, a
//!   tangent ray, is a hit.
//! - **Plane.** Point `a`, normal `n` of any length but zero: `t = ((a − o)·n) / (d·n)`. A ray in
//!   or along the plane, `d·n = 0`, is no hit.
//! - **Visible.** The smallest `t > 0` over all objects. What is at `t ≤ 0` is behind the origin or
//!   at it. From inside a sphere its far wall is seen. A `t` that rounds beyond the largest f32 is
//!   no hit.
//! - **Id.** Spheres in file order, then those of clouds, then planes, counted from 1; 0 is the
//!   background. Of equal `t`,
//!   the lower id wins.
//! - **Normal.** Unit length, turned to face the ray.
//! - **Colour.** Linear inside, sRGB in scene files, PNG and PPM. A number of a picture is the one whose
//!   range holds the exact colour, see [`scene::QuantizationTable`]; a float is the nearest one.
//! - **Light.** A light counts where `n·ω > 0` and no object has a root `s` of `p + s·w`, `0 < s < 1`,
//!   towards a point light, or `0 < s` towards a sun; touching is in the way. Without any light, sky or
//!   ambient light, objects have their colours as they are.
//! - **Samples.** `n` × `n` of them in a pixel are the centre rays of a picture `n` times as large.
//!
//! # Architecture
//! `docs/architecture.md` describes the modules and the stages from a scene to a picture; `CONTRIBUTING.md` lists the files that a
//! change touches. [`Session`] is the entry point of all front ends. The crates next to this one use its results:
//! `kugelblitz-judge` compares them, and those of other renderers, with exact arithmetic and explains them, `kugelblitz-report`
//! measures speed against error, `kugelblitz-cli` is the command line, and `kugelblitz-view` the window.
//!
//! # What is not promised
//! The kernels `lecture`, `stable` and `double` promise no object. A number that is not finite has no
//! meaning: the scene reader refuses it, and scenes made otherwise must not have one. Before
//! version 1.0, the interface may change with each minor version.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod bounds;
pub mod bvh;
pub mod cpu;
pub mod device;
pub mod digest;
pub mod error;
pub mod exact;
pub mod frames;
pub mod generate;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod input;
pub mod kernel;
pub mod lighting;
mod npy;
pub mod num;
pub mod output;
pub mod picture;
pub mod plain;
pub mod prepare;
pub mod query;
pub mod rays;
pub mod render;
pub mod scene;
mod session;
pub mod shape;
pub mod support;
mod surface;
pub mod tracer;
pub mod visibility;
pub mod words;

/// The vectors of the interface are its.
pub use glam;

pub use error::{Error, Result};
pub use session::{Picture, Session, SetupTimes};
pub use support::control::Control;

/// The examples of the guide.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide/src/library.md")]
struct Guide;
