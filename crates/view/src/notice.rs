//! The window's messages to the program that opened it.

use std::path::Path;

use serde::Serialize;

/// Something happened.
#[derive(Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Notice<'a> {
    /// The window's devices were opened: what was printed up to here is the drivers' word.
    Opened {
        /// The device's name.
        adapter: &'a str,
        /// True where it is a program on the CPU.
        software: bool,
    },
    /// A frame is in the window.
    Shown {
        /// Frames so far.
        frame: u64,
        /// Number of the picture in it, 0 for none.
        picture: u64,
        /// Left, top, width and height of the picture in the window, px.
        area: [u32; 4],
        /// True when each pixel is decided, and painted where the mode paints.
        settled: bool,
        /// The kernels from left to right.
        kernels: &'a [&'static str],
        /// The mode of showing.
        show: &'static str,
        /// True where colours are those that the scene's light gives.
        lit: bool,
        /// Samples across and down a pixel.
        samples: u32,
        /// Number of the newest picture asked for.
        asked: u64,
        /// Milliseconds since the last frame.
        ms: f64,
    },
    /// The pointer's pixel was looked up.
    Hover {
        /// The text of the status line.
        text: &'a str,
    },
    /// A pixel was explained.
    Explained {
        /// Column and row.
        pixel: [u32; 2],
        /// The text of `explain`.
        text: &'a str,
    },
    /// The camera as the user wants it: TOML.
    Camera {
        /// The table `[camera]`.
        toml: &'a str,
    },
    /// A picture was saved.
    Saved {
        /// The picture's file.
        path: &'a Path,
        /// Columns and rows.
        size: [u32; 2],
    },
    /// Another scene was opened.
    SceneOpened {
        /// The scene's file.
        path: &'a Path,
    },
    /// The scene file changed and is good.
    Reloaded,
    /// The scene file changed and is wrong, or another one that was to be opened.
    SceneWrong {
        /// The error with file, line and column.
        error: &'a str,
    },
    /// Something else went wrong, and the window lives on.
    Trouble {
        /// The trouble, in words.
        message: &'a str,
    },
}
