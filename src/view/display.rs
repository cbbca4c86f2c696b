//! The display that a window opens on, where there is none.

use std::env;
use std::path::Path;

use winit::error::EventLoopError;

use crate::error::Error;
use crate::plain::Shown;

/// There is no display. Names the one that was looked for.
pub fn no_display(error: &EventLoopError, scene: &Path) -> Error {
    // winit's words begin with the place in its source: `os error at FILE:LINE: why`.
    let words = error.to_string();
    let why = words.strip_prefix("os error at ").and_then(|rest| rest.splitn(3, ':').nth(2));
    let why = why.unwrap_or(&words).trim().trim_end_matches('.');
    // In the order in which winit looks.
    let asked = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"].into_iter().find_map(|name| {
        let value = env::var(name).ok().filter(|value| !value.is_empty())?;
        Some(format!(" ({name}={value})"))
    });
    Error::NoAdapter(format!(
        "there is no display to open a window on: {why}{}; use `kugelblitz render {} -o picture.png`",
        asked.unwrap_or_default(),
        scene.shown()
    ))
}

/// The event loop ended by itself, as it does when the connection is gone.
pub fn display_lost(error: EventLoopError) -> Error {
    let why = match error {
        // All that winit says of Wayland.
        EventLoopError::ExitFailure(_) => "the connection was lost".into(),
        other => other.to_string(),
    };
    Error::Io { path: "the display".into(), source: std::io::Error::other(why) }
}
