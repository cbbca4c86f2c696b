//! Draws the window's pictures, on a thread of its own.

use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, StageCounts};
use kugelblitz::rays::Pixels;
use kugelblitz::render::sampled_band_rows;
use kugelblitz::scene::{Samples, Scene};
use kugelblitz_judge::show::{self, Entry, Show, ShownPicture};

use super::present::WindowImage;
use super::worker::{Turn, Worker};

/// How long the camera must rest before what takes long is drawn: else numbers and colours would flicker.
const REST: Duration = Duration::from_millis(60);

/// Time between two looks at what is drawn so far.
const BETWEEN_LOOKS: Duration = Duration::from_millis(250);

/// Rows of the first band of what takes long.
const FIRST_ROWS: u32 = 8;

/// A band of what takes long takes about this long, unless a single row takes longer.
const BAND_TIME: Duration = Duration::from_millis(100);

/// A picture that is wanted.
#[derive(Clone)]
pub struct Order {
    /// The picture's number; newer ones have higher numbers.
    pub serial: u64,
    /// The scene, with the light that colours have.
    pub scene: Arc<Scene>,
    /// Camera and size.
    pub pixels: Pixels,
    /// One kernel, or two to be shown side by side.
    pub kernels: Vec<Kernel>,
    /// The quantity.
    pub show: Show,
    /// Samples across and down a pixel, of colours.
    pub n_samples: Samples,
}

impl Order {
    /// True where `other` asks for the same, but for the number of samples.
    fn is_like(&self, other: &Order) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && (self.pixels, &self.kernels, self.show) == (other.pixels, &other.kernels, other.show)
    }

    /// True where `other` asks for the same.
    pub fn is(&self, other: &Order) -> bool {
        self.is_like(other) && self.n_samples == other.n_samples
    }

    /// True where its colours are those that the scene's light gives.
    pub fn is_lit(&self) -> bool {
        self.show == Show::Color && self.scene.is_lit()
    }

    /// True where a colour for each id is not all of it.
    pub fn takes_long(&self) -> bool {
        match self.show {
            Show::Color => self.is_lit() || self.n_samples > Samples::ONE,
            show => !show.is_of_objects(),
        }
    }
}

/// A picture as far as it is drawn.
#[derive(Clone)]
pub struct DrawnFrame {
    /// What was wanted.
    pub order: Order,
    /// The colours, of each kernel.
    pub images: Vec<Arc<WindowImage>>,
    /// Time that tracing the ids took, without making ready.
    pub time: Duration,
    /// How many of them each stage decided.
    pub counts: StageCounts,
    /// Part that is drawn, 0 to 1; before that there are colours of ids.
    pub share: f32,
    /// The smallest and the largest `t` of all kernels' pictures, for the depth.
    pub range: Option<[f32; 2]>,
    /// The legends with the pixels of each meaning, of each kernel, once all are drawn.
    pub legends: Vec<Vec<Entry>>,
}

/// Starts the thread.
///
/// # Errors
/// Those of [`Worker::start`].
pub fn start(
    device: Device,
    say: impl Fn(Result<DrawnFrame>) + Send + 'static,
) -> Result<Worker<Order>> {
    let mut artist = Artist { device, sessions: Vec::new(), hits: Hits::default(), whole: None };
    Worker::start("drawing", say, move |order, turn, say| artist.work(order, turn, say))
}

struct Artist {
    device: Device,
    /// One for each kernel.
    sessions: Vec<Session>,
    hits: Hits,
    /// The last picture that was drawn to its end.
    whole: Option<DrawnFrame>,
}

impl Artist {
    fn work(
        &mut self,
        order: Order,
        turn: &mut Turn<Order>,
        say: &dyn Fn(DrawnFrame),
    ) -> Result<()> {
        let new = || Session::new(Arc::clone(&order.scene), self.device.clone(), Kernel::Certified);
        self.sessions.resize_with(order.kernels.len(), new);
        for (session, &kernel) in self.sessions.iter_mut().zip(&order.kernels) {
            session.set_scene(Arc::clone(&order.scene));
            session.set_kernel(kernel);
        }
        let goes_on = |whole: &DrawnFrame| whole.order.is_like(&order) && order.takes_long();
        let whole = self.whole.take().filter(goes_on);
        let has_colors = whole.is_some();
        let mut frame = match whole {
            Some(whole) => DrawnFrame { order, share: 0.0, ..whole },
            // A newer order does not stop it, or nothing would be seen while the camera moves.
            None => self.flat(order, turn.closing)?,
        };
        say(frame.clone());
        if frame.share < 1.0 {
            if !turn.rest(REST) {
                return Ok(());
            }
            self.fill(&mut frame, has_colors, &turn.control, say)?;
        }
        self.whole = Some(frame);
        Ok(())
    }

    /// The colours of the ids.
    fn flat(&mut self, order: Order, control: &Control) -> Result<DrawnFrame> {
        let Order { scene, pixels, show, .. } = &order;
        let palette = show::palette(*show, scene);
        let (mut images, mut counts, mut time) =
            (Vec::new(), StageCounts::default(), Duration::ZERO);
        for session in &mut self.sessions {
            let (rays, hits) = (Rays::Pixels(*pixels), &mut self.hits);
            session.make_ready(&rays, Outputs::default(), control)?;
            let start = Instant::now();
            session.trace(&rays, Outputs::default(), control, hits)?;
            time += start.elapsed();
            counts.add(hits.counts);
            let colors = hits.id.iter().map(|&id| palette[id as usize]);
            images.push(WindowImage::new([pixels.width, pixels.height], colors));
        }
        let (share, legends) = (if order.takes_long() { 0.0 } else { 1.0 }, Vec::new());
        Ok(DrawnFrame { order, images, time, counts, share, range: None, legends })
    }

    /// What takes long: in bands from the top, and colours first with one sample a pixel where there are none yet.
    fn fill(
        &mut self,
        frame: &mut DrawnFrame,
        has_colors: bool,
        control: &Control,
        say: &dyn Fn(DrawnFrame),
    ) -> Result<()> {
        let Order { pixels, show, n_samples, .. } = frame.order;
        // One scale for all, so that they can be compared.
        frame.range = None;
        for session in &mut self.sessions {
            frame.range = show::range_of_t(frame.range, session, show, &pixels, control)?;
        }
        let first = (!has_colors && n_samples > Samples::ONE).then_some(Samples::ONE);
        let n_kernels = self.sessions.len();
        let parts = first.into_iter().chain([n_samples]);
        let parts: Vec<_> = parts.flat_map(|n| (0..n_kernels).map(move |k| (n, k))).collect();
        let work_of = |n: Samples, n_rows: u32| n.of_pixel() as f32 * n_rows as f32;
        let work: f32 = parts.iter().map(|&(n, _)| work_of(n, pixels.height)).sum();
        let (mut done, mut last_look) = (0.0, Instant::now());
        let mut shown = vec![ShownPicture::new(show, frame.range); n_kernels];
        for (n, kernel) in parts {
            let most_rows = sampled_band_rows(&pixels, n, show.wants());
            let mut n_rows = match show {
                Show::Color | Show::Error => (FIRST_ROWS / n.across()).clamp(1, most_rows),
                _ => most_rows,
            };
            let mut y = 0;
            while y < pixels.height {
                let start = Instant::now();
                let band = pixels.rows(y, n_rows.min(pixels.height - y));
                let session = &mut self.sessions[kernel];
                let colors = match show {
                    Show::Color => session.colors(&band, n, control)?,
                    _ => shown[kernel].paint(session, &band, control)?,
                };
                WindowImage::change(&mut frame.images[kernel], (y * pixels.width) as usize, colors);
                y += band.height;
                done += work_of(n, band.height);
                if start.elapsed() < BAND_TIME / 2 {
                    n_rows = (band.height * 2).min(most_rows);
                } else if start.elapsed() > BAND_TIME * 2 {
                    n_rows = (band.height / 2).max(1);
                }
                if last_look.elapsed() > BETWEEN_LOOKS {
                    frame.share = (done / work).min(0.99);
                    say(frame.clone());
                    last_look = Instant::now();
                }
            }
        }
        frame.share = 1.0;
        frame.legends = shown.into_iter().map(|shown| shown.legend).collect();
        say(frame.clone());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use kugelblitz::scene::parse_scene;

    use super::*;

    const SIZE: [u32; 2] = [160, 100];

    fn order(serial: u64, text: &str, show: Show, n: u32) -> Order {
        let scene = Arc::new(parse_scene(text, "scene.toml".as_ref()).unwrap());
        let session = Session::new(Arc::clone(&scene), Device::Cpu, Kernel::Certified);
        let pixels = session.pixels(SIZE[0], SIZE[1]).unwrap();
        let kernels = vec![Kernel::Lecture, Kernel::Certified];
        Order { serial, scene, pixels, kernels, show, n_samples: Samples::nearest(n) }
    }

    #[test]
    fn the_last_picture_is_what_the_session_draws() {
        let (send, frames) = channel();
        let mut artist =
            start(Device::Cpu, move |frame| send.send(frame.unwrap()).unwrap()).unwrap();
        let [unlit, lit] = [
            include_str!("../../../scenes/figure2.toml"),
            include_str!("../../../scenes/lit/figure1.toml"),
        ];
        for (serial, (text, show, n)) in [
            (unlit, Show::Color, 1),
            (unlit, Show::Color, 2),
            (lit, Show::Color, 2),
            (unlit, Show::Depth, 1),
            (unlit, Show::Error, 1),
        ]
        .into_iter()
        .enumerate()
        {
            let order = order(serial as u64, text, show, n);
            artist.ask(order.clone());
            let frame = frames.iter().find(|frame| frame.share >= 1.0).unwrap();
            assert_eq!(frame.order.serial, serial as u64);
            for ((kernel, image), split) in
                order.kernels.iter().zip(&frame.images).zip([SIZE[0], 0])
            {
                let mut session = Session::new(Arc::clone(&order.scene), Device::Cpu, *kernel);
                let kernels = ([Kernel::Lecture, Kernel::Certified], split);
                let (pixels, control) = (&order.pixels, Control::default());
                let expected = show::side_by_side(
                    &mut session,
                    show,
                    pixels,
                    kernels,
                    order.n_samples,
                    &control,
                );
                assert!(**image == expected.unwrap()[..], "{show} {} {n}", kernel.name());
            }
            let is_counted = frame.legends.iter().flatten().any(|entry| entry.pixels.is_some());
            assert_eq!(is_counted, show == Show::Error);
        }
    }

    /// A newer order stops what takes long, but not the colours of the ids.
    #[test]
    fn a_newer_order_goes_first() {
        let (send, frames) = channel();
        let mut artist =
            start(Device::Cpu, move |frame| send.send(frame.unwrap()).unwrap()).unwrap();
        let lit = include_str!("../../../scenes/lit/figure1.toml");
        artist.ask(Order { kernels: vec![Kernel::Certified], ..order(1, lit, Show::Color, 16) });
        assert_eq!(frames.recv().map(|frame| (frame.order.serial, frame.share)), Ok((1, 0.0)));
        artist.ask(order(2, include_str!("../../../scenes/figure2.toml"), Show::Id, 1));
        let rest: Vec<DrawnFrame> = std::iter::from_fn(|| frames.recv().ok())
            .take_while(|frame| frame.order.serial == 1)
            .collect();
        assert!(rest.iter().all(|frame| frame.share < 1.0));
    }
}
