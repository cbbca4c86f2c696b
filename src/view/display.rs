//! The end of the display.

use std::ffi::c_int;
use std::sync::{Mutex, PoisonError};

use x11_dl::xlib::{Display, Xlib};

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
