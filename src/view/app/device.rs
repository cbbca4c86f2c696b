//! The window and its device: opened, lost and opened anew.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::{App, Event, Said, style};
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

/// Devices that may be lost one soon after the other before the window gives up.
const MOST_LOSSES: usize = 4;

/// Losses within this time count as one soon after the other.
const SOON: Duration = Duration::from_secs(20);

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
        let (proxy, epoch) = (self.proxy.clone(), self.epoch);
        // The event loop is gone only when nobody is interested any more.
        move |message| drop(proxy.send_event(Event::Said(epoch, message.map(said))))
    }

    /// Gives up the device. What its threads have said is not heard any more.
    pub(super) fn close(&mut self) {
        self.open = None;
        self.epoch += 1;
        self.state.explained.take_if(|explained| explained.text.is_none());
    }

    /// Tells what went wrong, and has a device opened anew after one was lost.
    pub(super) fn recover(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        if !matches!(error, Error::Device(_)) {
            let message = error.to_string();
            (self.notify)(&Notice::Trouble { message: &message });
            self.state.tell(message);
            return;
        }
        self.losses.retain(|at| at.elapsed() < SOON);
        self.losses.push(Instant::now());
        let Some(window) = self.open.as_ref().map(|open| Arc::clone(&open.window)) else { return };
        // The old surface must be gone before the window can have another.
        self.close();
        self.state.picture = None;
        self.state.painted = [None, None];
        if self.losses.len() > MOST_LOSSES {
            return self.fail(event_loop, error);
        }
        self.lost = Some((window, error));
        // Not at once: what was lost may be the window, and that is heard before.
        let _ = self.proxy.send_event(Event::Reopen);
    }

    pub(super) fn reopen(&mut self, event_loop: &ActiveEventLoop) {
        let Some((window, error)) = self.lost.take() else { return };
        // Textures of the panels are gone with the device.
        self.context = self.fresh_context();
        let message = format!("The device was opened anew: {error}");
        (self.notify)(&Notice::Trouble { message: &message });
        self.state.tell(message);
        if let Err(error) = self.open(window) {
            self.fail(event_loop, error);
        }
    }

    /// A context without textures, with the old one's theme.
    fn fresh_context(&self) -> egui::Context {
        let context = egui::Context::default();
        style(&context);
        context.set_theme(self.context.options(|options| options.theme_preference));
        context
    }
}
