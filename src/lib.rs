//! Kugelblitz: a ray tracer for spheres and planes that proves which object every ray sees, and every byte
//! of the picture.
//!
//! A [`Scene`](scene::Scene), a [`Device`](device::Device) and a [`Kernel`](trace::Kernel) make a
//! [`Session`]; rays and cameras go in, [`Hits`](trace::Hits) and pictures come out. With
//! [`Kernel::Certified`](trace::Kernel::Certified) the object of every hit is the one that exact
//! arithmetic sees.
//!
//! ```
//! use kugelblitz::Session;
//! use kugelblitz::device::Device;
//! use kugelblitz::scene::parse_scene;
//! use kugelblitz::trace::Kernel;
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
//!   range holds the exact colour, see [`scene::Edges`]; a float is the nearest one.
//! - **Light.** A light counts where `n·ω > 0` and no object has a root `s` of `p + s·w`, `0 < s < 1`,
//!   towards a point light, or `0 < s` towards a sun; touching is in the way. Without any light, sky or
//!   ambient light, objects have their colours as they are.
//! - **Samples.** `n` × `n` of them in a pixel are the centre rays of a picture `n` times as large.
//!
//! # Modules, along the way of the data
//! | module | what it holds |
//! | --- | --- |
//! | [`scene`] | what the user wrote, in f64, checked; the reader of TOML and clouds, its errors |
//! | [`generate`] | clouds of spheres made up from a seed |
//! | [`rays`] | bundles of rays: a camera's pixels, and lists |
//! | [`trace`] | what a tracer takes and gives |
//! | [`tracer`] | [`tracer::Tracer`] of a prepared scene, and [`tracer::Backend`], what a device does for it |
//! | [`prepare`] | scene → the plain numbers that are traced |
//! | [`bvh`] | the tree over many spheres, and one walk through it |
//! | [`guard`] | the error bounds of the certified kernel, with their derivation |
//! | [`host`] | what the proofs ask of this processor, and a check |
//! | [`kernel`] | the intersection kernels, and how those without a proof go through the objects |
//! | [`num`] | numbers that a formula is written in: one by one or in lanes, with masks and no order |
//! | [`seen`] | objects as rays see them: their numbers and formulas, a file a shape |
//! | [`engine`] | what rays see of few objects, in squares, pixels and samples |
//! | [`gpu`] | Vulkan devices: the [`tracer::Backend`] |
//! | [`cpu`] | what the CPU finds of a kernel's stage |
//! | [`Session`] | the facade that all others call |
//! | [`device`] | a Vulkan device or the CPU, and a tracer for it |
//! | [`exact`] | exact arithmetic, a file a shape, and the visible object |
//! | [`input`] | whole files of others, within one limit |
//! | [`memory`] | what fits, and refusing what does not |
//! | [`render`] | pictures band by band, in bounded memory |
//! | [`shade`] | hits → colours: lights, what is in their way, the mean of samples, and its bytes |
//! | [`control`] | cancelling and progress |
//! | [`output`] | files that appear whole or not at all |
//! | `system` | what kinds of systems do differently |
//! | [`parallel`] | work in parts, on all threads |
//! | [`picture`] | PNG, EXR, PPM and NPY, written and read; what a picture says of itself; files of rays and of what they hit |
//! | [`frames`] | cameras and file names of a turntable film |
//! | [`digest`] | one hash of a picture, the same on every device |
//! | [`plain`] | text of others, made fit to be shown |
//! | [`random`] | seeded random numbers |
//! | [`words`] | numbers and counts as words, and names that are nearly right |
//! | [`error`] | what can go wrong, with the program's exit code for it |
//!
//! Crates beside it hold what is made of its results: `kugelblitz-judge` holds them, and those of other renderers, against
//! exact arithmetic and explains them, `kugelblitz-report` measures speed against error, `kugelblitz-cli` is the program, and
//! `kugelblitz-view` the window.
//!
//! # The way of a pixel, from `crates/cli/src/render.rs` to the file
//! 1. [`scene::compose_scene`] reads the [`scene::Scene`], or makes one of data; `SizeArgs::pixels` makes [`rays::Pixels`] of its camera.
//! 2. [`Session::make_ready`] prepares: [`prepare::Prepared`] has the kernel's numbers of each object
//!    and, over many spheres, the tree of [`bvh`]. [`device::Device::tracer`] makes a
//!    [`tracer::Tracer`] of it; on a device, `gpu/compile.rs` puts the shader together.
//! 3. [`Session::draw`] calls [`render::render`], which goes through the picture band by band.
//! 4. [`tracer::Tracer::trace`] takes strips of 16 rows through all stages (`cpu/mod.rs`), side by side. f32 finds an id or
//!    "undecided": on a device beforehand, `render` in `shaders/render.wgsl`; on the CPU [`engine::Search`] looks at squares of
//!    pixels, large ones first, with the formulas of [`seen`] in lanes, or through the tree, and `cpu/plain.rs` goes through the
//!    objects of kernels without a proof.
//! 5. f64 decides what was left open, by the same formulas ([`engine::Find64`]), and exact arithmetic ([`exact::nearest`]) the
//!    rest; `certify/surfaces.rs` fills in `t` and normals; what f64 cannot round goes through numbers of 100 bits
//!    (`exact/sight.rs`) before exact ones.
//! 6. [`shade::Painter::paint`] makes colours of the hits: flat ones by a table, means of unlit samples by
//!    `shade/unlit.rs`, which [`tracer::Tracer::trace_samples`] finds, on the CPU after the engine has proven which
//!    pixels show one object alone. Lit ones come of `shade/lit.rs`: `shade/pass.rs` finds bounds of their colours, of bytes
//!    first in f32, in f64 what that leaves open and all others, both with the points of `certify/surfaces.rs` and the shadow
//!    rays of [`seen::shadow`]; the rest is decided exactly (`shade/decide.rs`, `exact/light.rs`, `shade/mean.rs`). A card gives
//!    bytes of f32 before: `gpu/light.rs` runs `shaders/lit.wgsl`. Kernels without a
//!    proof shade plainly: `shade/plain.rs`, on a device its twin `shaders/plain_light.wgsl`, which `gpu/plain_light.rs`
//!    runs.
//! 7. [`picture::PictureWriter`] encodes them into an [`output::OutputFile`].
//! 8. [`output::commit`] puts the file in its place, last of all.
//!
//! `CONTRIBUTING.md` says which files a change touches.
//!
//! # What is not promised
//! The kernels `lecture`, `stable` and `double` promise no object. A number that is not finite has no
//! meaning: the scene reader refuses it, and scenes made otherwise must not have one. Before
//! version 1.0, the interface may change with each minor version.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod bvh;
mod certify;
pub mod control;
pub mod cpu;
pub mod device;
pub mod digest;
pub mod engine;
pub mod error;
pub mod exact;
pub mod frames;
pub mod generate;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod guard;
pub mod host;
pub mod input;
pub mod kernel;
pub mod memory;
mod npy;
pub mod num;
pub mod output;
pub mod parallel;
pub mod picture;
pub mod plain;
pub mod prepare;
pub mod random;
pub mod rays;
pub mod render;
pub mod scene;
pub mod seen;
mod session;
pub mod shade;
mod system;
pub mod trace;
pub mod tracer;
pub mod words;

/// The vectors of the interface are its.
pub use glam;

pub use error::{Error, Result};
pub use session::{Making, Picture, Session};

/// The examples of the guide.
#[cfg(doctest)]
#[doc = include_str!("../docs/guide/src/library.md")]
struct Guide;
