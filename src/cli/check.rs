//! `kugelblitz check`

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::memory::Available;
use kugelblitz::picture::{Format, PictureOptions};
use kugelblitz::prepare::{Prepared, record_bytes};
use kugelblitz::render::plan;
use kugelblitz::scene::{Cloud, Scene};
use kugelblitz::trace::{Kernel, Ray, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::head::{Objects, print_summary};
use super::output::{bytes, count, ms, objects, print_text};
use super::{CheckArgs, Run, scene};

#[derive(Serialize)]
struct Summary {
    objects: Objects,
    /// What lights them; `null` where they have their colours as they are.
    light: Option<Light>,
    /// Samples across and down a pixel.
    samples: u32,
    /// Files of spheres, in the order of their ids.
    clouds: Vec<CloudFile>,
    /// Bytes of the objects in memory, without what a kernel makes of them.
    bytes_scene: u64,
    /// Bytes of the objects on the device, by kernel.
    bytes_device: BTreeMap<&'static str, u64>,
    /// The hierarchy over many spheres; `null` where they are few.
    hierarchy: Option<Built>,
    /// The cost of a picture; `null` without a camera.
    picture: Option<Picture>,
}

#[derive(Serialize)]
struct Light {
    lights: usize,
    /// Suns of the sky; 0 without a sky.
    sky_directions: u32,
    ambient: bool,
}

impl Light {
    fn of(scene: &Scene) -> Option<Light> {
        scene.is_lit().then(|| Light {
            lights: scene.lights.len(),
            sky_directions: scene.sky.map_or(0, |sky| sky.directions),
            ambient: scene.ambient.is_some(),
        })
    }

    fn in_words(&self) -> String {
        let mut parts = Vec::new();
        if self.lights > 0 {
            parts.push(count(self.lights, "light"));
        }
        if self.sky_directions > 0 {
            let directions = count(self.sky_directions as usize, "direction");
            parts.push(format!("a sky of {directions}"));
        }
        if self.ambient {
            parts.push("ambient light".into());
        }
        parts.join(", ")
    }
}

#[derive(Serialize)]
struct Built {
    /// Spheres that it doesn't hold: those close to the eye or out of range.
    spheres_outside: usize,
    bytes: u64,
    ms_build: f64,
}

#[derive(Serialize)]
struct CloudFile {
    file: String,
    spheres: usize,
    first_id: u32,
}

#[derive(Serialize)]
struct Picture {
    size: [u32; 2],
    rays: u64,
    /// Memory for hits and writing, by format.
    bytes_memory: BTreeMap<&'static str, u64>,
}

/// Reads a scene and says what it costs.
pub fn run(args: &CheckArgs, run: &Run) -> Result<()> {
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let pixels = match scene.camera {
        Some(_) => Some(args.size.pixels(&scene, &args.scene)?),
        None => None,
    };
    let anywhere = Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
    let rays = pixels.map_or_else(|| Rays::List(vec![anywhere]), Rays::Pixels);
    // All but one have a record an object, and need not be made to be counted.
    let listed = Kernel::ALL.map(|kernel| {
        (kernel.name(), record_bytes(kernel, scene.spheres.len(), scene.planes.len()))
    });
    let mut bytes_device = BTreeMap::from(listed);
    let progress = scene::preparing(&scene, Kernel::Certified, &args.talk);
    let prepared = Prepared::new_with(Arc::clone(&scene), Kernel::Certified, &rays, &run.control)?;
    drop(progress);
    let hierarchy = prepared.hierarchy.as_ref().map(|hierarchy| Built {
        spheres_outside: hierarchy.rest.len(),
        bytes: hierarchy.bytes(),
        ms_build: ms(hierarchy.build_time),
    });
    let tracer = CpuTracer::new(Arc::new(prepared), Wants::default());
    bytes_device.insert(Kernel::Certified.name(), tracer.bytes_device());
    drop(tracer);
    let available = Available::now();
    let (light, samples) = (Light::of(&scene), scene.samples.unwrap_or(1));
    let mut picture = None;
    if let Some(pixels) = pixels {
        let mut bytes_memory = BTreeMap::new();
        for format in Format::ALL {
            let options = PictureOptions::default();
            match plan(
                format,
                options,
                scene.samples.unwrap_or(1),
                &pixels,
                scene.n_objects(),
                available,
            ) {
                Ok(plan) => drop(bytes_memory.insert(format.name(), plan.bytes)),
                // A format that can't hold the picture is left out.
                Err(Error::TooLarge(_)) => {}
                Err(error) => return Err(error),
            }
        }
        let size = [pixels.width, pixels.height];
        picture = Some(Picture { size, rays: pixels.len() as u64, bytes_memory });
    }
    if args.talk.json {
        let file = |cloud: &Cloud| CloudFile {
            file: cloud.path.display().to_string(),
            spheres: cloud.n_spheres,
            first_id: cloud.first_id,
        };
        let summary = Summary {
            objects: Objects::from(&*scene),
            light,
            samples,
            clouds: scene.clouds.iter().map(file).collect(),
            bytes_scene: scene.bytes(),
            bytes_device,
            hierarchy,
            picture,
        };
        return print_summary("check", &summary);
    }

    let mut text = format!("{}: {}\n", args.scene.display(), objects(&scene));
    for cloud in &scene.clouds {
        let spheres = count(cloud.n_spheres, "sphere");
        let _ = writeln!(text, "{}: {spheres}, from id {}", cloud.path.display(), cloud.first_id);
    }
    if let Some(light) = light {
        let _ = writeln!(text, "lit by {}", light.in_words());
    }
    if samples > 1 {
        let _ = writeln!(text, "samples: {samples} × {samples} a pixel");
    }
    let _ = writeln!(text, "in memory: {}", bytes(scene.bytes()));
    for (kernel, n) in bytes_device {
        let _ = writeln!(text, "on the device, {kernel}: {}", bytes(n));
    }
    if let Some(Built { spheres_outside, bytes: n, ms_build }) = hierarchy {
        let outside = match spheres_outside {
            0 => String::new(),
            n => format!(", without {}", count(n, "sphere")),
        };
        let _ = writeln!(text, "hierarchy: {}, built in {ms_build:.0} ms{outside}", bytes(n));
    }
    match picture {
        Some(Picture { size: [width, height], rays, bytes_memory }) => {
            let _ = writeln!(text, "picture: {width}×{height}, {rays} rays");
            for (format, n) in bytes_memory {
                let _ = writeln!(text, "memory to write {format}: {}", bytes(n));
            }
        }
        None => text += "no camera: `trace` can use this scene, `render` can't\n",
    }
    print_text(&text)
}
