//! The facade: a scene, a device and a kernel, ready to trace rays and to draw pictures.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::device::{Device, Made};
use crate::digest::{Digest, scene_hash};
use crate::error::{Hint, Result, Setting};
use crate::lighting::{Encoding, Framebuffer, Palette, Pixel, RenderStats, Shading, Style};
use crate::output::{self, OutputFile};
use crate::picture::{Format, Metadata, PictureOptions, PictureWriter, Sink};
use crate::prepare::{LengthUnit, Prepared};
use crate::query::{Hits, Kernel, Outputs, Rays, Timing};
use crate::rays::{Pixels, View};
use crate::render::{Plan, band_bytes, plan, render, sampled_band_rows};
use crate::scene::{Camera, Samples, Scene};
use crate::support::control::Control;
use crate::support::memory::{self, Available};
use crate::tracer::Tracer;

/// Traces one scene with one kernel on one device. What depends on the scene or on the camera is
/// made when it is first needed, and made again only when that changes.
///
/// ```no_run
/// use kugelblitz::{Session, device::Device, scene::read_scene, query::Kernel};
///
/// let scene = read_scene("scenes/figure1.toml".as_ref())?;
/// let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
/// session.render_to_file("figure1.png", 1280, 720)?;
/// # Ok::<(), kugelblitz::Error>(())
/// ```
pub struct Session {
    scene: Arc<Scene>,
    camera: Option<Camera>,
    device: Device,
    kernel: Kernel,
    ready: Option<Tracer>,
    /// For the samples of pixels, where there are several.
    of_samples: Option<Tracer>,
    /// The hash of the last scene that was drawn into a file.
    hashed: Option<(Arc<Scene>, String)>,
    /// The colours of the scene's objects, as the last picture without light had them.
    palette: Option<Palette>,
    /// See [`Session::force_light_on_device`].
    is_light_forced: bool,
    /// See [`Session::keep_world_units`].
    keeps_world_units: bool,
    /// The last traced scene, its unit, and the scene in this unit if that is not the world's.
    in_unit: Option<(Arc<Scene>, LengthUnit, Option<Arc<Scene>>)>,
}

/// Time that it took to make a session ready for rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetupTimes {
    /// The kernel's numbers, without the hierarchy.
    pub prepare: Duration,
    /// The hierarchy over many spheres.
    pub build: Duration,
    /// The shader.
    pub compile: Duration,
    /// Handing the scene to the device.
    pub upload: Duration,
}

/// A picture in memory, row by row from the top.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The hit of each pixel's centre ray, with `t` and normal.
    pub hits: Hits,
    /// sRGB, 8 bits a channel.
    pub srgb8: Vec<[u8; 3]>,
}

impl Session {
    /// A session that has made nothing yet. The scene's camera is its camera.
    pub fn new(scene: impl Into<Arc<Scene>>, device: Device, kernel: Kernel) -> Session {
        let scene = scene.into();
        Session {
            camera: scene.camera.clone(),
            scene,
            device,
            kernel,
            ready: None,
            of_samples: None,
            hashed: None,
            palette: None,
            is_light_forced: false,
            keeps_world_units: false,
            in_unit: None,
        }
    }

    /// Prepares scenes in world units, whatever their size, so that [`Session::prepared`] is in world units. Scenes that are very
    /// large or very small then take longer.
    pub fn keep_world_units(&mut self) {
        self.keeps_world_units = true;
    }

    /// Has the device light every picture that it can light, even if the CPU would be faster. The colors of `certified` are
    /// the same; a comparison of devices then also checks the device's lighting.
    pub fn force_light_on_device(&mut self) {
        self.is_light_forced = true;
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Where rays are traced.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The kernel.
    pub fn kernel(&self) -> Kernel {
        self.kernel
    }

    /// Replaces the scene, and the camera by the scene's where it has one.
    pub fn set_scene(&mut self, scene: impl Into<Arc<Scene>>) {
        self.scene = scene.into();
        self.palette = None;
        if self.scene.camera.is_some() {
            self.camera.clone_from(&self.scene.camera);
        }
    }

    /// Traces with another kernel.
    pub fn set_kernel(&mut self, kernel: Kernel) {
        self.kernel = kernel;
    }

    /// Looks from another place.
    pub fn set_camera(&mut self, camera: Camera) {
        self.camera = Some(camera);
    }

    /// All pixels of a picture that the camera takes.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] where there is no camera.
    pub fn pixels(&self, width: u32, height: u32) -> Result<Pixels> {
        let camera = match &self.camera {
            Some(camera) => camera,
            None => self.scene.require_camera(Path::new("the scene"))?,
        };
        Ok(Pixels::whole(View::new(camera), width, height))
    }

    /// Makes what tracing `rays` needs, and says what it took. Nothing is made where the last rays
    /// needed the same.
    ///
    /// # Errors
    /// Those of [`Prepared::renewed`] and [`Device::tracer`].
    pub fn make_ready(
        &mut self,
        rays: &Rays,
        wants: Outputs,
        control: &Control,
    ) -> Result<SetupTimes> {
        self.ready(rays, wants, control).map(|(.., making)| making)
    }

    /// Returns the scene and rays to trace for given rays, and their unit. The kernel `certified` uses the unit of the scene,
    /// unless a number would not stay exact, or there is too little memory for the scene in this unit.
    fn in_unit<'r>(&mut self, rays: &'r Rays) -> (Arc<Scene>, Cow<'r, Rays>, LengthUnit) {
        if self.kernel == Kernel::Certified && !self.keeps_world_units {
            let scene = &self.scene;
            let kept = self.in_unit.take_if(|(of, ..)| Arc::ptr_eq(of, scene));
            let (_, unit, scaled) = self.in_unit.insert(kept.unwrap_or_else(|| {
                let unit = LengthUnit::of(scene);
                let has_room = || Available::now().bytes > 2 * scene.bytes();
                let is_scaled = unit != LengthUnit::WORLD && has_room();
                let scaled = is_scaled.then(|| unit.scene(scene)).flatten();
                (Arc::clone(scene), unit, scaled)
            }));
            if let Some(scaled) = scaled
                && let Some(rays) = unit.rays(rays)
            {
                return (Arc::clone(scaled), Cow::Owned(rays), *unit);
            }
        }
        (Arc::clone(&self.scene), Cow::Borrowed(rays), LengthUnit::WORLD)
    }

    fn ready<'r>(
        &mut self,
        rays: &'r Rays,
        wants: Outputs,
        control: &Control,
    ) -> Result<(&mut Tracer, Cow<'r, Rays>, SetupTimes)> {
        let (scene, rays, unit) = self.in_unit(rays);
        let source = (&scene, unit, &self.device, self.kernel);
        let (tracer, making) = renewed(&mut self.ready, None, source, &rays, wants, control)?;
        Ok((tracer, rays, making))
    }

    /// A painter that has what pixels and their samples need, and the pixels in the unit that it paints them in.
    fn painter(
        &mut self,
        pixels: &Pixels,
        style: Style,
        wants: Outputs,
        control: &Control,
    ) -> Result<(Shading<'_>, Pixels)> {
        let of_pixels = Rays::Pixels(*pixels);
        let (scene, rays, unit) = self.in_unit(&of_pixels);
        let pixels = *rays.pixels().unwrap_or(pixels);
        let source = (&scene, unit, &self.device, self.kernel);
        let palette = &mut self.palette;
        let (tracer, _) = renewed(&mut self.ready, None, source, &rays, wants, control)?;
        let force_light = |tracer: &mut Tracer| {
            if let Some(backend) = tracer.backend().filter(|_| self.is_light_forced) {
                backend.force_light();
            }
        };
        force_light(tracer);
        if style.n_samples == Samples::ONE {
            return Ok((Shading::new(style, &pixels, palette, tracer, None), pixels));
        }
        let rays = Rays::Pixels(pixels.samples(style.n_samples.across()));
        // The tree is there already.
        let (slot, tree) = (&mut self.of_samples, Some(&**tracer.prepared()));
        let (of_samples, _) = renewed(slot, tree, source, &rays, Outputs::default(), control)?;
        force_light(of_samples);
        Ok((Shading::new(style, &pixels, palette, tracer, Some(of_samples)), pixels))
    }

    /// Draws pixels into any sink, band by band.
    ///
    /// # Errors
    /// Those of [`Session::make_ready`] and [`render()`].
    pub fn render_into(
        &mut self,
        pixels: &Pixels,
        style: Style,
        wants: Outputs,
        n_band_rows: u32,
        sink: &mut impl Sink,
        control: &Control,
    ) -> Result<RenderStats> {
        let (mut painter, pixels) = self.painter(pixels, style, wants, control)?;
        render(&mut painter, &pixels, n_band_rows, sink, control)
    }

    /// Traces any rays, or pixels of a picture.
    ///
    /// # Errors
    /// Returns [`TooLarge`](crate::Error::TooLarge) if the hits do not fit the memory, and the errors of [`Session::make_ready`]
    /// and [`Tracer::trace`].
    pub fn trace(
        &mut self,
        rays: &Rays,
        wants: Outputs,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<Timing> {
        let (tracer, rays, _) = self.ready(rays, wants, control)?;
        tracer.trace(&rays, control, hits)
    }

    /// Draws a picture into memory, as its scene asks for.
    ///
    /// # Errors
    /// Those of [`Session::pixels`] and [`Session::keep`].
    pub fn render(&mut self, width: u32, height: u32) -> Result<Picture> {
        let pixels = self.pixels(width, height)?;
        let n_samples = self.scene.samples.unwrap_or_default();
        let style = Style { n_samples, ..Style::new(Encoding::Srgb8) };
        let wants = Outputs { surface: true, level: true };
        let (kept, _) = self.keep(&pixels, style, wants, &Control::default())?;
        Ok(Picture { width, height, hits: kept.hits, srgb8: Pixel::all(kept.colors)? })
    }

    /// Draws pixels into memory, band by band, so that their samples need little of it.
    ///
    /// # Errors
    /// [`TooLarge`](crate::Error::TooLarge) where the picture does not fit the memory; those of [`Session::make_ready`] and [`render()`].
    pub fn keep(
        &mut self,
        pixels: &Pixels,
        style: Style,
        wants: Outputs,
        control: &Control,
    ) -> Result<(Framebuffer, RenderStats)> {
        let n_band_rows = sampled_band_rows(pixels, style.n_samples, wants);
        let n_objects = self.scene.n_objects();
        let band = pixels.rows(0, n_band_rows.min(pixels.height));
        let whole = Style { n_samples: Samples::ONE, ..style };
        let bytes = band_bytes(pixels, &whole, wants, n_objects)
            .saturating_add(band_bytes(&band, &style, wants, n_objects));
        memory::require("a picture in memory", bytes, "draw it into a file, or a smaller one")?;
        let mut kept = Framebuffer::new(style.encoding);
        let rendered = self.render_into(pixels, style, wants, n_band_rows, &mut kept, control)?;
        Ok((kept, rendered))
    }

    /// Returns the hits of the rays through the centres of pixels.
    ///
    /// # Errors
    /// Returns the errors of [`Session::trace`].
    pub fn hits(&mut self, pixels: &Pixels, wants: Outputs, control: &Control) -> Result<Hits> {
        let mut hits = Hits::default();
        self.trace(&Rays::Pixels(*pixels), wants, control, &mut hits)?;
        Ok(hits)
    }

    /// The colours of `pixels` with `n_samples` × `n_samples` samples each, in the numbers of `P`, as
    /// [`Session::draw`] writes them: `[u8; 3]` is sRGB with 8 bits a channel. All samples are in memory at
    /// once, so that a picture is best made in [`crate::render::bands`]; what they need is made for the first
    /// one alone.
    ///
    /// # Errors
    /// [`TooLarge`](crate::Error::TooLarge) where they do not fit the memory; those of [`Session::trace`] and [`Shading::paint`].
    pub fn colors<P: Pixel>(
        &mut self,
        pixels: &Pixels,
        n_samples: Samples,
        control: &Control,
    ) -> Result<Vec<P>> {
        let (wants, mut rows) = (Outputs::default(), Framebuffer::new(P::ENCODING));
        // Of several samples the painter finds the hits.
        if n_samples == Samples::ONE {
            self.trace(&Rays::Pixels(*pixels), wants, control, &mut rows.hits)?;
        }
        let style = Style { n_samples, ..Style::new(P::ENCODING) };
        let (mut painter, pixels) = self.painter(pixels, style, wants, control)?;
        painter.paint(&pixels, &mut rows, control, &mut RenderStats::default())?;
        P::all(rows.colors)
    }

    /// Returns the linear colors of `pixels` before any encoding, with the hits of their centre rays: for kernels without a
    /// proof, whose light does not depend on the encoding. Returns `None` for `certified`, and for a scene without light. Only the
    /// pixels with the indices `lit` are lit; the others have the background's color. All samples are in memory at once, so
    /// `pixels` should be one of [`crate::render::bands`].
    ///
    /// # Errors
    /// Returns the errors of [`Session::make_ready`], [`Tracer::trace`] and [`Shading::paint`].
    pub fn baseline_means(
        &mut self,
        pixels: &Pixels,
        (n_samples, wants): (Samples, Outputs),
        lit: &[usize],
        control: &Control,
    ) -> Result<Option<(Hits, Vec<[f64; 3]>)>> {
        if self.kernel == Kernel::Certified || !self.scene.is_lit() {
            return Ok(None);
        }
        let style = Style { n_samples, ..Style::new(Encoding::Linear) };
        let (mut painter, pixels) = self.painter(pixels, style, wants, control)?;
        let mut hits = Hits::default();
        painter.tracer().trace(&Rays::Pixels(pixels), control, &mut hits)?;
        let means = painter.baseline_means(&pixels, &hits, lit, control)?;
        Ok(means.map(|means| (hits, means)))
    }

    /// Draws a picture into a file; the name's ending tells the format.
    ///
    /// # Errors
    /// Those of [`Format::from_path`], [`plan`], [`OutputFile::create`], [`Session::draw`] and
    /// [`output::commit`].
    pub fn render_to_file(
        &mut self,
        path: impl AsRef<Path>,
        width: u32,
        height: u32,
    ) -> Result<RenderStats> {
        let path = path.as_ref();
        let (format, control) = (Format::from_path(path)?, Control::default());
        let pixels = self.pixels(width, height)?;
        let options = PictureOptions::default();
        let n_samples = self.scene.samples.unwrap_or_default();
        let n_objects = self.scene.n_objects();
        let plan = plan(format, options, n_samples, &pixels, n_objects, Available::now())?;
        let file = OutputFile::create(path, format.needs_seek())?;
        let (rendered, file) = self.draw(&pixels, &plan, file, &control)?;
        output::commit([file], &control)?;
        Ok(rendered)
    }

    /// Draws `pixels` into `file` as planned, band by band. The file is then whole, but not in its
    /// place: that takes [`output::commit`].
    ///
    /// # Errors
    /// Those of [`Session::make_ready`] and [`render()`].
    pub fn draw(
        &mut self,
        pixels: &Pixels,
        plan: &Plan,
        file: OutputFile,
        control: &Control,
    ) -> Result<(RenderStats, OutputFile)> {
        let Plan { format, options, n_band_rows, .. } = *plan;
        let metadata = self.metadata(pixels, plan);
        let (mut painter, in_unit) = self.painter(pixels, plan.style, plan.wants, control)?;
        let path = file.path().to_owned();
        let start = Instant::now();
        let mut writer = PictureWriter::create(format, options, pixels, &metadata, file, path)?;
        let begin = start.elapsed();
        let mut rendered = render(&mut painter, &in_unit, n_band_rows, &mut writer, control)?;
        let start = Instant::now();
        let file = writer.finish()?;
        rendered.write += begin + start.elapsed();
        Ok((rendered, file))
    }

    /// What a picture says of how it was made.
    pub fn metadata(&mut self, pixels: &Pixels, plan: &Plan) -> Metadata {
        if !plan.format.has_metadata() {
            return Metadata::default();
        }
        let hashed = self.hashed.take_if(|(scene, _)| Arc::ptr_eq(scene, &self.scene));
        let new = || (Arc::clone(&self.scene), scene_hash(&self.scene));
        let (_, scene) = self.hashed.insert(hashed.unwrap_or_else(new));
        Metadata::new(scene, self.camera.as_ref(), pixels, self.kernel, &plan.style)
    }

    /// The [`Digest`] of a picture with `n_samples` × `n_samples` samples a pixel, made band by band. It is the
    /// same on every device with [`Kernel::Certified`]; of other kernels it is of the light that the device makes.
    ///
    /// # Errors
    /// Those of [`Session::trace`] and [`Shading::paint`]; [`TooLarge`](crate::Error::TooLarge) where a band does not fit the
    /// memory.
    pub fn digest(
        &mut self,
        pixels: &Pixels,
        n_samples: Samples,
        control: &Control,
    ) -> Result<String> {
        let wants = Outputs { surface: true, level: false };
        let n_band_rows = sampled_band_rows(pixels, n_samples, wants);
        let style = Style { n_samples, ..Style::new(Encoding::Srgb8) };
        let band = pixels.rows(0, n_band_rows);
        let bytes = band_bytes(&band, &style, wants, self.scene.n_objects());
        let hint = Hint::new("take a narrower part with {}", [Setting::named("crop")]);
        memory::require("rows of the picture", bytes, hint)?;
        let mut digest = Digest::new(pixels, n_samples);
        self.render_into(pixels, style, wants, n_band_rows, &mut digest, control)?;
        Ok(digest.finish())
    }

    /// What the last rays were prepared as.
    pub fn prepared(&self) -> Option<&Prepared> {
        self.ready.as_ref().map(|tracer| &**tracer.prepared())
    }

    /// Bytes held on the device for the scene; 0 before anything was made.
    pub fn bytes_device(&self) -> u64 {
        self.ready.as_ref().map_or(0, Tracer::bytes_device)
    }
}

/// What there is where it suits, else another tracer: with the tree of `tree` or of the old one where these are of the same
/// scene.
fn renewed<'a>(
    old: &'a mut Option<Tracer>,
    tree: Option<&Prepared>,
    (scene, unit, device, kernel): (&Arc<Scene>, LengthUnit, &Device, Kernel),
    rays: &Rays,
    wants: Outputs,
    control: &Control,
) -> Result<(&'a mut Tracer, SetupTimes)> {
    let suits = |tracer: &mut Tracer| {
        let prepared = tracer.prepared();
        tracer.wants() == wants
            && prepared.kernel == kernel
            && Arc::ptr_eq(&prepared.scene, scene)
            && prepared.is_for(rays)
    };
    if let Some(tracer) = old.take_if(suits) {
        return Ok((old.insert(tracer), SetupTimes::default()));
    }
    let start = Instant::now();
    let tree = tree.or(old.as_ref().map(|old| &**old.prepared()));
    let prepared = Prepared::renewed(tree, Arc::clone(scene), kernel, rays, control)?;
    let prepared = prepared.in_unit(unit);
    let (prepared, prepare) = (Arc::new(prepared), start.elapsed());
    control.check()?;
    let build = prepared.build_time();
    let making =
        SetupTimes { prepare: prepare.saturating_sub(build), build, ..SetupTimes::default() };
    if let Some(mut tracer) = old.take_if(|old| old.wants() == wants) {
        let start = Instant::now();
        tracer.retarget(prepared)?;
        return Ok((old.insert(tracer), SetupTimes { upload: start.elapsed(), ..making }));
    }
    let Made { tracer, compile, upload } = device.tracer(&prepared, wants)?;
    Ok((old.insert(tracer), SetupTimes { compile, upload, ..making }))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::error::Error;
    use crate::lighting::{Background, Colors};
    use crate::query::WorldRay;
    use crate::render::bands;
    use crate::scene::{Color, Sphere, parse_scene};

    fn ball() -> Scene {
        let camera = Camera::new(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO);
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let spheres = [(sphere, Color([1.0, 0.0, 0.0]))].into_iter().collect();
        Scene { camera: Some(camera), spheres, ..Scene::default() }
    }

    fn session() -> Session {
        Session::new(ball(), Device::Cpu, Kernel::Certified)
    }

    #[test]
    fn a_session_can_move_to_another_thread() {
        fn is_send<T: Send>(_: &T) {}
        is_send(&session());
    }

    #[test]
    fn what_did_not_change_is_not_made_again() {
        let mut session = session();
        let (wants, control) = (Outputs::default(), Control::default());
        let rays = Rays::Pixels(session.pixels(64, 48).unwrap());
        assert_ne!(session.make_ready(&rays, wants, &control).unwrap(), SetupTimes::default());
        assert_eq!(session.make_ready(&rays, wants, &control).unwrap(), SetupTimes::default());
        session.set_scene(ball());
        assert_ne!(session.make_ready(&rays, wants, &control).unwrap(), SetupTimes::default());
        let other = Rays::Pixels(session.pixels(64, 47).unwrap());
        assert_ne!(session.make_ready(&other, wants, &control).unwrap(), SetupTimes::default());
    }

    #[test]
    fn a_list_gets_the_numbers_of_its_own() {
        let list = |x: f64| {
            let ray = |x| WorldRay { origin: DVec3::new(x, 0.0, 3.0), direction: DVec3::NEG_Z };
            Rays::List(vec![ray(0.0), ray(x)])
        };
        let trace = |session: &mut Session, rays: &Rays| {
            let (mut hits, wants) = (Hits::default(), Outputs { surface: true, level: true });
            session.trace(rays, wants, &Control::default(), &mut hits).unwrap();
            hits
        };
        let mut stable = Session::new(ball(), Device::Cpu, Kernel::Stable);
        let alone = trace(&mut stable, &list(0.3));
        trace(&mut stable, &list(1e9));
        assert_eq!(trace(&mut stable, &list(0.3)), alone);
    }

    #[test]
    fn a_ray_that_is_not_finite_is_refused() {
        let mut session = session();
        let (wants, control, mut hits) = (Outputs::default(), Control::default(), Hits::default());
        let good = WorldRay { origin: DVec3::Z * 3.0, direction: DVec3::NEG_Z };
        for number in [f64::NAN, f64::INFINITY] {
            for bad in [
                WorldRay { origin: DVec3::new(0.0, number, 0.0), ..good },
                WorldRay { direction: DVec3::new(number, 1.0, 0.0), ..good },
            ] {
                let rays = Rays::List(vec![good, bad]);
                let refused = session.trace(&rays, wants, &control, &mut hits).unwrap_err();
                assert!(refused.to_string().contains("ray 1 "), "{refused}");
            }
        }
    }

    #[test]
    fn what_is_refused_leaves_the_session_as_it_was() {
        let mut session = session();
        let (wants, control) = (Outputs::default(), Control::default());
        let rays = Rays::Pixels(session.pixels(64, 48).unwrap());
        session.make_ready(&rays, wants, &control).unwrap();
        let cancelled = Control::default();
        cancelled.cancel();
        let other = Rays::Pixels(session.pixels(32, 24).unwrap());
        assert!(session.make_ready(&other, wants, &cancelled).is_err());
        assert_eq!(session.make_ready(&rays, wants, &control).unwrap(), SetupTimes::default());
        assert_eq!(session.render(1 << 20, 1 << 20).unwrap_err().exit_code(), 7);
    }

    #[test]
    fn pictures_follow_the_camera_and_the_scene() {
        let mut session = session();
        let center = |session: &mut Session| {
            let picture = session.render(33, 25).unwrap();
            (picture.hits.id[12 * 33 + 16], picture.srgb8[12 * 33 + 16])
        };
        assert_eq!(center(&mut session), (1, [255, 0, 0]));
        let camera = session.camera.clone().unwrap();
        session.set_camera(Camera { look_at: DVec3::new(0.0, 0.0, 9.0), ..camera.clone() });
        assert_eq!(center(&mut session), (0, [0, 0, 0]));
        session.set_camera(camera);
        assert_eq!(center(&mut session), (1, [255, 0, 0]));
        session.set_scene(Scene { background: Color([0.0, 0.0, 1.0]), ..Scene::default() });
        assert_eq!(center(&mut session), (0, [0, 0, 255]));
        let (pixels, control) = (session.pixels(3, 3).unwrap(), Control::default());
        let style = Style { background: Background::Black, ..Style::new(Encoding::Srgb8) };
        let (kept, _) = session.keep(&pixels, style, Outputs::default(), &control).unwrap();
        assert_eq!(kept.colors, Colors::Srgb8(vec![[0; 3]; 9]));
    }

    #[test]
    fn bands_have_the_colours_of_the_picture() {
        let text = include_str!("../scenes/lit/figure1.toml");
        let scene = parse_scene(text, "figure1.toml".as_ref()).unwrap();
        let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
        let (whole, control) = (session.pixels(64, 36).unwrap(), Control::default());
        let picture = session.render(64, 36).unwrap().srgb8;
        let mut colors = |n_samples, n_rows| -> Vec<[u8; 3]> {
            let bands = bands(&whole, n_rows);
            let samples = Samples::nearest(n_samples);
            bands.flat_map(|band| session.colors(&band, samples, &control).unwrap()).collect()
        };
        assert_eq!(colors(3, 7), picture);
        assert_ne!(colors(1, 36), picture);
        assert_eq!(colors(1, 36), colors(1, 5));
        control.cancel();
        for n_samples in [1, 3] {
            let samples = Samples::nearest(n_samples);
            let stopped = session.colors::<[u8; 3]>(&whole, samples, &control).unwrap_err();
            assert!(matches!(stopped, Error::Interrupted), "{stopped}");
        }
    }

    /// A picture comes in each kind of numbers; one of another kind is an error and not empty.
    #[test]
    fn colours_come_in_the_numbers_that_are_asked_for() {
        let mut session = session();
        let (pixels, control) = (session.pixels(9, 7).unwrap(), Control::default());
        let bytes: Vec<[u8; 3]> = session.colors(&pixels, Samples::ONE, &control).unwrap();
        let shorts: Vec<[u16; 3]> = session.colors(&pixels, Samples::ONE, &control).unwrap();
        let floats: Vec<[f32; 3]> = session.colors(&pixels, Samples::ONE, &control).unwrap();
        assert_eq!((bytes.len(), bytes[31]), (63, [255, 0, 0]));
        assert_eq!((shorts.len(), shorts[31]), (63, [u16::MAX, 0, 0]));
        assert_eq!((floats.len(), floats[31]), (63, [1.0, 0.0, 0.0]));
        let wrong = <[u8; 3]>::all(Colors::Linear(floats)).unwrap_err();
        assert!(wrong.to_string().contains("Linear, not Srgb8"), "{wrong}");
    }

    #[test]
    fn hits_are_those_of_the_kept_picture() {
        let mut session = session();
        let (pixels, control) = (session.pixels(64, 48).unwrap(), Control::default());
        let wants = Outputs { surface: true, level: true };
        let style = Style::new(Encoding::Srgb8);
        let (kept, _) = session.keep(&pixels, style, wants, &control).unwrap();
        assert!(session.hits(&pixels, wants, &control).unwrap() == kept.hits);
        let huge = session.pixels(1 << 20, 1 << 20).unwrap();
        let refused = session.hits(&huge, wants, &control).unwrap_err();
        assert!(matches!(refused, Error::TooLarge(_)), "{refused}");
    }

    /// A scene times a power of two has the same picture, and `t` times that power; and so have the rays of a list. The numbers
    /// of rays that need exact arithmetic stay the same, and f32 decides as many.
    #[test]
    fn scenes_of_all_sizes_have_one_picture() {
        let text = include_str!("../scenes/lit/figure1.toml");
        let few = parse_scene(text, "figure1.toml".as_ref()).unwrap();
        let ball = |k: i32| Sphere {
            center: DVec3::new(f64::from(k % 9), f64::from(k / 9 % 7), f64::from(k / 63)) - 4.0,
            radius: 0.3,
        };
        let spheres: Vec<Sphere> = (0..500).map(ball).collect();
        let lights = vec![few.lights[0]];
        let many = Scene { spheres: spheres.into(), lights, ..few.clone() };
        let wants = Outputs { surface: true, level: true };
        let control = Control::default();
        for scene in [few, many] {
            let camera = Camera { look_at: DVec3::ZERO, ..scene.camera.clone().unwrap() };
            let pixels = Pixels::whole(View::new(&camera), 48, 27);
            let aimed = |k: i32| WorldRay {
                origin: DVec3::new(f64::from(k % 7), 9.0, f64::from(k % 5)),
                direction: DVec3::new(f64::from(k % 3) - 1.0, -4.0, f64::from(k % 11) - 5.0),
            };
            let list = Rays::List((0..200).map(aimed).collect());
            let seen = |exponent: i32| {
                let unit = LengthUnit::of_exponent(-exponent);
                let scene = unit.scene(&scene).unwrap();
                let pixels = unit.pixels(&pixels).unwrap();
                let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
                let style = Style::new(Encoding::Srgb8);
                let (kept, drawn) = session.keep(&pixels, style, wants, &control).unwrap();
                let mut hits = Hits::default();
                let list = unit.rays(&list).unwrap();
                session.trace(&list, wants, &control, &mut hits).unwrap();
                (kept, drawn.shadow_rays, hits)
            };
            let (picture, shadow_rays, hits) = seen(0);
            assert!(picture.hits.n_hits() > 100 && hits.n_hits() > 50);
            for exponent in [-240, -100, -70, -33, 45, 60, 70, 80] {
                let (other, other_rays, other_hits) = seen(exponent);
                assert_eq!(other.colors, picture.colors, "2^{exponent}");
                assert_eq!(other_rays, shadow_rays, "2^{exponent}");
                for (here, there) in [(&picture.hits, &other.hits), (&hits, &other_hits)] {
                    assert_eq!(here.id, there.id, "2^{exponent}");
                    assert_eq!(here.normal, there.normal, "2^{exponent}");
                    assert_eq!(here.counts, there.counts, "2^{exponent}");
                    let power = crate::prepare::power_of_two(exponent);
                    for (&here, &there) in here.t.iter().zip(&there.t) {
                        let expected = (f64::from(here) * power) as f32;
                        let least = f32::MIN_POSITIVE;
                        assert!(there == expected || there.max(expected) < least, "2^{exponent}");
                        assert!(there > 0.0, "2^{exponent}");
                    }
                }
            }
        }
    }

    #[test]
    fn lists_and_pictures_take_turns() {
        let mut session = session();
        let list = Rays::List(vec![WorldRay { origin: DVec3::Z * 3.0, direction: DVec3::NEG_Z }]);
        for _ in 0..2 {
            let (mut hits, wants) = (Hits::default(), Outputs { surface: true, level: false });
            session.trace(&list, wants, &Control::default(), &mut hits).unwrap();
            assert_eq!((hits.id[0], hits.t[0]), (1, 2.0));
            assert_eq!(session.render(3, 3).unwrap().hits.id[4], 1);
        }
    }

    #[test]
    fn a_scene_without_a_camera_has_no_picture() {
        let mut session = Session::new(Scene::default(), Device::Cpu, Kernel::Certified);
        assert_eq!(session.render(3, 3).unwrap_err().exit_code(), 3);
    }
}
