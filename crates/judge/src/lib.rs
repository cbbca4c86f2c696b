//! Results of Kugelblitz and of other renderers, held against exact arithmetic and explained.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`compare`] | two pictures, and other renderers' results against exact arithmetic |
//! | [`verify`] | a result against exact arithmetic, and what each kernel promises |
//! | [`explain`] | a pixel's or a ray's numbers in every kernel's arithmetic, and exactly |
//! | [`show`] | depth, normals, errors and other numbers of a picture, as colours |
//! | [`figure`] | the lecture's figures 2 to 5 as drawings with axes, and legends of colours |
//! | [`markup`] | SVG and HTML, written so that every parser takes them |
//! | [`cost`] | number of objects of a scene, and memory for a picture |
//! | [`export`] | scenes in the languages of POV-Ray and Tachyon |
//!
//! Errors are those of [`kugelblitz`], with its exit codes.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod compare;
pub mod cost;
pub mod explain;
pub mod export;
pub mod figure;
pub mod markup;
pub mod show;
pub mod verify;

pub(crate) use kugelblitz::error::wrong_usage;
