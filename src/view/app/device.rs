//! The window and its device.

use std::sync::Arc;
use std::time::Instant;

use egui::ViewportId;
use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::{App, Event, Said};
use crate::device::Device;
use crate::error::{Error, Result};
use crate::gpu::{Pick, Pool, Words};
use crate::show::Show;
use crate::view::ask::{self, Question};
use crate::view::bar::Widths;
use crate::view::look::Look;
use crate::view::notice::Notice;
use crate::view::painter::{self, Painting};
use crate::view::panels::LINES;
use crate::view::screen::{Panels, Screen};
use crate::view::tracing::{self, Backend, Order};
use crate::view::worker::Worker;

/// Size of the picture where neither the options nor the scene file has one.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// Part of the screen that the window takes at most.
const SCREEN_PART: f64 = 0.92;

/// All that is there while a device is open.
pub(super) struct Open {
    pub(super) window: Arc<Window>,
    pub(super) input: egui_winit::State,
    pub(super) screen: Screen,
    pub(super) backend: Backend,
    pub(super) trace: Worker<Order>,
    pub(super) paint: Worker<Painting>,
    pub(super) hover: Worker<Question>,
    pub(super) explain: Worker<Question>,
    pub(super) panels: Panels,
    /// Colours by id, with the picture and the mode that they are for.
    pub(super) palette: Option<((u64, Show), Arc<Words>)>,
    pub(super) palettes: Pool,
    pub(super) ordered: Option<Order>,
    pub(super) painting: Option<(u64, Look)>,
    /// The last pixel that was asked for.
    pub(super) hovered: Option<Question>,
    /// The time of the last frame, and the picture in it.
    pub(super) drawn: Option<(Instant, u64)>,
}

impl<N: FnMut(&Notice)> App<N> {
    pub(super) fn window(&self, event_loop: &ActiveEventLoop) -> Result<Arc<Window>> {
        let [width, height] = self.full_size().unwrap_or(DEFAULT_SIZE);
        let monitor = event_loop
            .primary_monitor()
            .or_else(|| event_loop.available_monitors().next())
            .filter(|monitor| monitor.size().width > 0);
        let scale = monitor.as_ref().map_or(1.0, |monitor| monitor.scale_factor());
        let bar = Widths::default().height(false, width as f32 / scale as f32);
        let bars = (f64::from(bar + LINES) * scale).round() as u32;
        let fits = |wanted: u32, there: u32| wanted.min((f64::from(there) * SCREEN_PART) as u32);
        let size = match monitor.map(|monitor| monitor.size()) {
            Some(there) => {
                PhysicalSize::new(fits(width, there.width), fits(height + bars, there.height))
            }
            None => PhysicalSize::new(width, height + bars),
        };
        let attributes =
            Window::default_attributes().with_title(self.title()).with_inner_size(size);
        event_loop.create_window(attributes).map(Arc::new).map_err(|error| {
            Error::NoAdapter(format!(
                "the window can't be opened: {error}; use `kugelblitz render`"
            ))
        })
    }

    /// Opens a device for the window, and the threads that work with it.
    pub(super) fn open(&mut self, window: Arc<Window>) -> Result<()> {
        (self.notify)(&Notice::Opening);
        let pick = self.options.device.as_ref();
        let screen = Screen::open(pick.unwrap_or(&Pick::Best), &window)?;
        let gpu = Device::Gpu(Arc::clone(&screen.gpu));
        let (device, name) = match pick {
            Some(_) => (gpu.clone(), gpu.label()),
            None => (Device::Cpu, format!("the CPU, shown by {}", gpu.label())),
        };
        self.state.device = name;
        self.state.offered = device.kernels();
        let backend = Backend { screen: Arc::clone(&screen.gpu), device };
        let closing = Arc::clone(&self.closing);
        let trace = tracing::start(backend.clone(), closing, self.say(Said::Traced))?;
        let paint = painter::start(backend.clone(), self.say(Said::Painted))?;
        let hover = ask::start_hover(backend.device.clone(), self.say(Said::Hover))?;
        let explain = ask::start_explain(backend.device.clone(), self.say(Said::Explained))?;
        let input = egui_winit::State::new(
            self.context.clone(),
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(screen.max_texture_side()),
        );
        let facts = &screen.gpu.facts;
        (self.notify)(&Notice::Opened { adapter: &facts.name, software: facts.is_software() });
        window.request_redraw();
        self.open = Some(Open {
            window,
            input,
            screen,
            backend,
            trace,
            paint,
            hover,
            explain,
            panels: Panels::default(),
            palette: None,
            palettes: Pool::default(),
            ordered: None,
            painting: None,
            hovered: None,
            drawn: None,
        });
        Ok(())
    }

    /// Passes messages of a thread that works with the device to the window.
    fn say<T: 'static>(&self, said: fn(T) -> Said) -> impl Fn(Result<T>) + Send + 'static {
        let proxy = self.proxy.clone();
        // The event loop is gone only when nobody is interested any more.
        move |message| drop(proxy.send_event(Event::Said(message.map(said))))
    }

    /// Tells what went wrong; without a device the window ends.
    pub(super) fn trouble(&mut self, error: Error) {
        if matches!(error, Error::Device(_)) {
            if !self.is_lost {
                self.is_lost = true;
                // Not at once: what was lost may be the window, and that is heard before.
                let _ = self.proxy.send_event(Event::Lost(error));
            }
            return;
        }
        let message = error.to_string();
        (self.notify)(&Notice::Trouble { message: &message });
        self.state.tell(message);
    }
}
