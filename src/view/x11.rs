//! X11: a window's XCB handles, and the end of the connection.

use std::ffi::c_int;
use std::num::NonZeroU32;
use std::ptr::NonNull;
use std::sync::{Arc, Mutex, PoisonError};

use winit::raw_window_handle::{
    DisplayHandle, HandleError, HasDisplayHandle, HasWindowHandle, RawDisplayHandle,
    RawWindowHandle, WindowHandle, XcbDisplayHandle, XcbWindowHandle,
};
use winit::window::Window;
use x11_dl::xlib::{Display, Xlib};
use x11_dl::xlib_xcb::Xlib_xcb;

/// A window that a surface is made for. On X11 its handles are XCB's, which every Vulkan driver takes;
/// not every one takes Xlib's. Elsewhere they are winit's own.
pub struct Target(pub Arc<Window>);

impl HasWindowHandle for Target {
    #[allow(unsafe_code)]
    fn window_handle(&self) -> Result<WindowHandle<'_>, HandleError> {
        let handle = self.0.window_handle()?;
        let RawWindowHandle::Xlib(xlib) = handle.as_raw() else { return Ok(handle) };
        // An X11 name has 32 bits; Xlib keeps it in a C long.
        let id = |name| u32::try_from(name).ok().and_then(NonZeroU32::new);
        let mut xcb = XcbWindowHandle::new(id(xlib.window).ok_or(HandleError::Unavailable)?);
        xcb.visual_id = id(xlib.visual_id);
        // SAFETY: the name is that of `self.0`, which lives as long as the handle.
        Ok(unsafe { WindowHandle::borrow_raw(RawWindowHandle::Xcb(xcb)) })
    }
}

impl HasDisplayHandle for Target {
    #[allow(unsafe_code)]
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        let handle = self.0.display_handle()?;
        let RawDisplayHandle::Xlib(xlib) = handle.as_raw() else { return Ok(handle) };
        let display = xlib.display.ok_or(HandleError::Unavailable)?;
        let library = Xlib_xcb::open().map_err(|_| HandleError::Unavailable)?;
        // SAFETY: winit keeps the display open as long as `self.0` lives.
        let connection = unsafe { (library.XGetXCBConnection)(display.as_ptr().cast()) };
        let xcb = XcbDisplayHandle::new(NonNull::new(connection), xlib.screen);
        // SAFETY: the connection is the display's own and ends with it.
        Ok(unsafe { DisplayHandle::borrow_raw(RawDisplayHandle::Xcb(xcb)) })
    }
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
