//! Platforms without X11: the same names, with nothing behind them.

use std::sync::Arc;

use winit::raw_window_handle::{
    DisplayHandle, HandleError, HasDisplayHandle, HasWindowHandle, WindowHandle,
};
use winit::window::Window;

/// A window that a surface is made for.
pub struct Target(pub Arc<Window>);

impl HasWindowHandle for Target {
    fn window_handle(&self) -> Result<WindowHandle<'_>, HandleError> {
        self.0.window_handle()
    }
}

impl HasDisplayHandle for Target {
    fn display_handle(&self) -> Result<DisplayHandle<'_>, HandleError> {
        self.0.display_handle()
    }
}

/// There is no X server to lose.
pub fn on_loss(_: fn()) {}
