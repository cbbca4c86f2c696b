//! A frame: input in, orders out, and the drawing.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::App;
use crate::error::{Error, Result};
use crate::gpu::{Layer, Present, Words};
use crate::view::look::palette;
use crate::view::notice::Notice;
use crate::view::painter::Painting;
use crate::view::panels;
use crate::view::screen::{Drawn, Shown};
use crate::view::state::{Command, State};
use crate::view::tracing::Order;

/// While a picture is on its way, the old one is not drawn again within this time.
const WAIT_FOR_PICTURE: Duration = Duration::from_millis(100);

/// Shortest time between two frames that nothing but time asks for.
const FRAME_TIME: Duration = Duration::from_millis(8);

/// Frames farther apart than this do not belong to a movement.
const MOVEMENT: Duration = Duration::from_millis(300);

impl<N: FnMut(&Notice)> App<N> {
    /// Takes the input, gives orders, and draws a frame if there is something new to see.
    pub(super) fn redraw(&mut self, event_loop: &ActiveEventLoop) -> Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let size = open.screen.follow_window();
        let raw = take_input(&mut open.input, &open.window, size, self.start);
        let mut commands = Vec::new();
        let state = &mut self.state;
        let output = self.context.run_ui(raw, |ui| commands.extend(panels::layout(ui, state)));
        let pixels_per_point = output.pixels_per_point;
        open.input.handle_platform_output(&open.window, output.platform_output);
        open.panels.textures.append(output.textures_delta);
        open.panels.pixels_per_point = pixels_per_point;
        open.panels.jobs = self.context.tessellate(output.shapes, pixels_per_point);
        let delay = output.viewport_output.get(&ViewportId::ROOT).map(|out| out.repaint_delay);

        if !commands.iter().any(|command| matches!(command, Command::Hover(_))) {
            // The pointer is elsewhere; what it finds when it comes back must be looked up again.
            open.hovered = None;
        }
        for command in commands {
            self.carry_out(event_loop, command);
        }
        self.order();
        self.paint();
        self.wake = delay
            .filter(|delay| *delay < Duration::from_secs(3600))
            .map(|delay| Instant::now() + delay.max(FRAME_TIME));
        self.draw()
    }

    /// Orders a picture if the one that was ordered last is not what is wanted now.
    fn order(&mut self) {
        let Some(open) = &mut self.open else { return };
        let (area, state) = (self.state.area, &mut self.state);
        if area.width == 0 || area.height == 0 {
            return;
        }
        let (pixels, kernels) = (state.pixels(), state.shown_kernels());
        let is_the_same = |order: &Order| {
            Arc::ptr_eq(&order.scene, &state.scene)
                && order.pixels == pixels
                && order.kernels == kernels
        };
        if open.ordered.as_ref().is_some_and(is_the_same) {
            return;
        }
        state.asked += 1;
        let order = Order { serial: state.asked, scene: Arc::clone(&state.scene), pixels, kernels };
        open.ordered = Some(order.clone());
        open.paint.stop();
        open.trace.ask(order);
    }

    /// Has the newest picture painted; the thread knows what needs no paint.
    fn paint(&mut self) {
        let (Some(open), Some(picture)) = (&mut self.open, &self.state.picture) else { return };
        let look = self.state.look();
        let wanted = (picture.order.serial, look);
        if self.state.is_waiting() {
            if open.painting.take().is_some() {
                open.paint.stop();
            }
        } else if open.painting != Some(wanted) {
            open.painting = Some(wanted);
            let scene = Arc::clone(self.state.colored_scene());
            open.paint.ask(Painting { picture: Arc::clone(picture), scene, look });
        }
    }

    fn draw(&mut self) -> Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let serial = self.state.picture.as_ref().map_or(0, |picture| picture.order.serial);
        // The picture that comes soon is worth more than this frame, which would delay it.
        if let Some((at, picture)) = open.drawn
            && self.state.is_waiting()
            && picture == serial
            && at.elapsed() < WAIT_FOR_PICTURE
        {
            self.wake = Some(at + WAIT_FOR_PICTURE);
            return Ok(());
        }
        let wanted = (serial, self.state.show);
        if let Some(picture) = &self.state.picture
            && open.palette.as_ref().is_none_or(|(of, _)| *of != wanted)
        {
            let order = &picture.order;
            let colors = palette(self.state.show, &order.scene, &order.pixels);
            // The old one's words may be taken again.
            open.palette = None;
            let words = open.palettes.take(&open.screen.gpu, colors.len());
            words.write(0, &colors);
            open.palette = Some((wanted, words));
        }
        let shown = shown(&self.state, open.palette.as_ref().map(|(_, words)| &**words));
        let drawn = open.screen.draw(shown, &mut open.panels)?;
        match drawn {
            Drawn::Yes => self.count_frame(serial),
            Drawn::Again => open.window.request_redraw(),
            Drawn::Hidden => self.wake = Some(Instant::now() + WAIT_FOR_PICTURE),
            Drawn::Lost => return Err(Error::Device("the window's surface was lost".into())),
        }
        if self.options.lose_device_after == Some(self.frame) {
            self.options.lose_device_after = None;
            return Err(Error::Device("it was given up, as asked for".into()));
        }
        Ok(())
    }

    fn count_frame(&mut self, picture: u64) {
        let Some(open) = &mut self.open else { return };
        let now = Instant::now();
        let since = open.drawn.replace((now, picture)).map(|(at, _)| now - at);
        let ms = since.map_or(0.0, |since| since.as_secs_f64() * 1e3);
        self.state.frame_ms = match since {
            // Smoothed, or nobody could read it.
            Some(since) if since < MOVEMENT => {
                Some(self.state.frame_ms.map_or(ms, |known| 0.8 * known + 0.2 * ms))
            }
            _ => None,
        };
        self.frame += 1;
        let area = self.state.area;
        let kernels: Vec<_> = self.state.shown_kernels().iter().map(|k| k.name()).collect();
        let look = self.state.look();
        (self.notify)(&Notice::Shown {
            frame: self.frame,
            picture,
            area: [area.left, area.top, area.width, area.height],
            settled: self.state.is_settled(),
            kernels: &kernels,
            show: look.show.name(),
            lit: look.is_lit,
            samples: look.n_samples.across(),
            asked: self.state.asked,
            ms,
        });
    }
}

/// Takes the input since the last frame of a window of `size` px. The library's own way asks the
/// window for its size each time.
fn take_input(
    input: &mut egui_winit::State,
    window: &Window,
    size: [u32; 2],
    start: Instant,
) -> egui::RawInput {
    let points = egui_winit::pixels_per_point(input.egui_ctx(), window);
    let raw = input.egui_input_mut();
    raw.time = Some(start.elapsed().as_secs_f64());
    let size = egui::Vec2::from(size.map(|px| px as f32)) / points;
    raw.screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size));
    let viewport = raw.viewports.entry(ViewportId::ROOT).or_default();
    viewport.native_pixels_per_point = Some(window.scale_factor() as f32);
    raw.take()
}

/// The picture with what is needed to draw it.
fn shown<'a>(state: &State, palette: Option<&'a Words>) -> Option<Shown<'a>> {
    let (picture, palette) = (state.picture.as_ref()?, palette?);
    let (area, pixels) = (state.area, &picture.order.pixels);
    let layer = |(place, ids): (usize, &Arc<Words>)| Layer {
        ids: Arc::clone(ids),
        paint: state.paint(place).map(|paint| Arc::clone(&paint.words)),
    };
    let present = Present {
        left: area.left,
        top: area.top,
        shown_width: area.width,
        shown_height: area.height,
        width: pixels.width,
        height: pixels.height,
        divider: area.left + if state.compares { state.divider_px() } else { 0 },
        painted: 0,
    };
    let layers = picture.ids.iter().enumerate().map(layer).collect();
    (area.width > 0 && area.height > 0).then_some(Shown { present, palette, layers })
}
