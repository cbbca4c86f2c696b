//! The display that a window opens on: where there is none, and its end.

use std::env;
use std::ffi::c_int;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use winit::error::EventLoopError;
use x11_dl::xlib::{Display, Xlib};

use crate::error::Error;

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
        scene.display()
    ))
}

static TELL: Mutex<Option<fn()>> = Mutex::new(None);

/// Xlib ends the process when this returns.
extern "C" fn lost(_: *mut Display) -> c_int {
    let tell = *TELL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(tell) = tell {
        tell();
    }
    0
}

/// Has `tell` called when the connection to the X server is lost. Xlib then ends the process with
/// exit code 1: no call into it could return. `tell` must not panic. Nothing happens where there is
/// no Xlib.
#[allow(unsafe_code)]
pub fn on_loss(tell: fn()) {
    *TELL.lock().unwrap_or_else(PoisonError::into_inner) = Some(tell);
    if let Ok(xlib) = Xlib::open() {
        // SAFETY: the function has the type that Xlib asks for and is there as long as the process.
        unsafe { (xlib.XSetIOErrorHandler)(Some(lost)) };
    }
}
