//! `kugelblitz check`

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::picture::{Format, PictureOptions};
use kugelblitz::prepare::Prepared;
use kugelblitz::render::{available_memory, plan};
use kugelblitz::scene::read_scene;
use kugelblitz::trace::{Kernel, Ray, Rays, Tracer, Wants};
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::CheckArgs;
use super::head::{Head, Objects};
use super::output::{bytes, objects, print, print_json};

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    head: Head,
    objects: Objects,
    /// Bytes of the objects on the device, by kernel.
    bytes_device: BTreeMap<&'static str, u64>,
    /// What a picture takes; `null` without a camera.
    picture: Option<Picture>,
}

#[derive(Serialize)]
struct Picture {
    size: [u32; 2],
    rays: u64,
    /// Memory for hits and writing, by format.
    bytes_memory: BTreeMap<&'static str, u64>,
}

/// Reads a scene and says what it costs.
pub fn run(args: &CheckArgs) -> Result<()> {
    let scene = Arc::new(read_scene(&args.scene)?);
    let pixels = match scene.camera {
        Some(_) => Some(args.size.pixels(&scene, &args.scene)?),
        None => None,
    };
    let anywhere = Ray { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
    let rays = pixels.map_or_else(|| Rays::List(vec![anywhere]), Rays::Pixels);
    let mut bytes_device = BTreeMap::new();
    for kernel in Kernel::ALL {
        let prepared = Arc::new(Prepared::new(scene.clone(), kernel, &rays)?);
        let tracer = CpuTracer::new(prepared, Wants::default());
        bytes_device.insert(kernel.name(), tracer.bytes_device());
    }
    let available = available_memory();
    let mut picture = None;
    if let Some(pixels) = pixels {
        let mut bytes_memory = BTreeMap::new();
        for format in Format::ALL {
            let options = PictureOptions::default();
            match plan(format, options, &pixels, scene.n_objects(), available) {
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
        let objects = Objects::from(&*scene);
        return print_json(&Summary { head: Head::new("check"), objects, bytes_device, picture });
    }

    let mut text = format!("{}: {}\n", args.scene.display(), objects(&scene));
    for (kernel, n) in bytes_device {
        let _ = writeln!(text, "on the device, {kernel}: {}", bytes(n));
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
    print(text.as_bytes())
}
