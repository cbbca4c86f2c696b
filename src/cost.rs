//! What a scene holds, and what a picture of it costs in memory.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use serde::Serialize;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::memory::Available;
use crate::picture::{Format, PictureOptions};
use crate::prepare::{Hierarchy, Prepared, record_bytes};
use crate::rays::{Pixels, Rays};
use crate::render::plan;
use crate::scene::{Cloud, Samples, Scene};
use crate::trace::Kernel;
use crate::words::count;

/// What a scene holds and costs.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// The objects.
    pub objects: ObjectCounts,
    /// What lights the objects; `None` where they have their colours as they are.
    pub light: Option<LightOf>,
    /// Samples across and down a pixel.
    pub samples: u32,
    /// Files of spheres, in the order of their ids.
    pub clouds: Vec<CloudFile>,
    /// Bytes of the objects in memory, without what a kernel makes of them.
    pub bytes_scene: u64,
    /// Bytes of the objects on the device, by kernel.
    pub bytes_device: BTreeMap<&'static str, u64>,
    /// The hierarchy over many spheres; `None` where they are few.
    pub hierarchy: Option<Built>,
    /// The cost of a picture; `None` without a camera.
    pub picture: Option<PictureCost>,
}

/// The objects of a scene.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ObjectCounts {
    spheres: usize,
    planes: usize,
}

impl ObjectCounts {
    /// Counts the objects of `scene`.
    pub fn of(scene: &Scene) -> ObjectCounts {
        ObjectCounts { spheres: scene.spheres.len(), planes: scene.planes.len() }
    }
}

/// `3 spheres, 1 plane`
impl Display for ObjectCounts {
    fn fmt(&self, to: &mut Formatter) -> fmt::Result {
        write!(to, "{}, {}", count(self.spheres, "sphere"), count(self.planes, "plane"))
    }
}

/// What lights the objects.
#[derive(Clone, Debug, Serialize)]
pub struct LightOf {
    /// Lights.
    pub lights: usize,
    /// Suns of the sky; 0 without a sky.
    pub sky_directions: u32,
    /// Whether there is light from nowhere.
    pub ambient: bool,
}

impl LightOf {
    fn of(scene: &Scene) -> Option<LightOf> {
        scene.is_lit().then(|| LightOf {
            lights: scene.lights.len(),
            sky_directions: scene.sky.map_or(0, |sky| sky.directions),
            ambient: scene.ambient.is_some(),
        })
    }
}

/// The hierarchy over many spheres.
#[derive(Clone, Debug, Serialize)]
pub struct Built {
    /// Spheres that it doesn't hold: those close to the eye or out of range.
    pub spheres_outside: usize,
    /// Size of the hierarchy in memory, bytes.
    pub bytes: u64,
    /// Milliseconds that it took to build.
    pub ms_build: f64,
}

/// A file of spheres.
#[derive(Clone, Debug, Serialize)]
pub struct CloudFile {
    /// Path of the file.
    pub file: String,
    /// How many spheres it gave.
    pub spheres: usize,
    /// Id of the first.
    pub first_id: u32,
    /// Names of the columns that are not used.
    pub unused_columns: Vec<String>,
}

/// What a picture costs.
#[derive(Clone, Debug, Serialize)]
pub struct PictureCost {
    /// Columns and rows.
    pub size: [u32; 2],
    /// Centre rays.
    pub rays: u64,
    /// Memory for hits and writing, by format.
    pub bytes_memory: BTreeMap<&'static str, u64>,
    /// Memory beside that: the objects, and the hierarchy over many spheres with what the picture and its samples see of it.
    pub bytes_held: u64,
}

impl Cost {
    /// Finds what a scene costs, and what these pixels do where there is a camera. The hierarchy is built for it.
    ///
    /// # Errors
    /// Those of [`Prepared::renewed`].
    pub fn new(scene: &Arc<Scene>, pixels: Option<&Pixels>, control: &Control) -> Result<Cost> {
        let rays = pixels.map_or(Rays::List(Vec::new()), |pixels| Rays::Pixels(*pixels));
        // All but one have a record an object, and need not be made to be counted.
        let listed = Kernel::ALL.map(|kernel| (kernel.name(), record_bytes(kernel, scene)));
        let mut bytes_device = BTreeMap::from(listed);
        let prepared =
            Prepared::renewed(None, Arc::clone(scene), Kernel::Certified, &rays, control)?;
        let hierarchy = prepared.hierarchy.as_ref().map(|hierarchy| Built {
            spheres_outside: hierarchy.leaves.rest.len(),
            bytes: hierarchy.bytes(),
            ms_build: hierarchy.build_time.as_secs_f64() * 1e3,
        });
        let samples = scene.samples.unwrap_or_default();
        let held = held_bytes(scene, prepared.hierarchy.as_ref(), samples);
        bytes_device.insert(Kernel::Certified.name(), prepared.bytes());
        drop(prepared);
        let file = |cloud: &Cloud| CloudFile {
            file: cloud.path.display().to_string(),
            spheres: cloud.n_spheres,
            first_id: cloud.first_id,
            unused_columns: cloud.unused_columns.clone(),
        };
        Ok(Cost {
            objects: ObjectCounts::of(scene),
            light: LightOf::of(scene),
            samples: samples.across(),
            clouds: scene.clouds.iter().map(file).collect(),
            bytes_scene: scene.bytes(),
            bytes_device,
            hierarchy,
            picture: pixels
                .map(|pixels| PictureCost::new(scene, pixels, samples, held))
                .transpose()?,
        })
    }
}

impl PictureCost {
    fn new(scene: &Scene, pixels: &Pixels, samples: Samples, held: u64) -> Result<PictureCost> {
        let (options, available) = (PictureOptions::default(), Available::now());
        let mut bytes_memory = BTreeMap::new();
        for format in Format::ALL {
            match plan(format, options, samples, pixels, scene.n_objects(), available) {
                Ok(plan) => drop(bytes_memory.insert(format.name(), plan.bytes)),
                // A format that can't hold the picture is left out.
                Err(Error::TooLarge(_)) => {}
                Err(error) => return Err(error),
            }
        }
        let size = [pixels.width, pixels.height];
        Ok(PictureCost { size, rays: pixels.len() as u64, bytes_memory, bytes_held: held })
    }
}

/// [`PictureCost::bytes_held`]
fn held_bytes(scene: &Scene, hierarchy: Option<&Hierarchy>, samples: Samples) -> u64 {
    let of_hierarchy = |hierarchy: &Hierarchy| {
        let views = if samples > Samples::ONE { 2 } else { 1 };
        hierarchy.bvh.bytes() + views * hierarchy.leaves.bytes()
    };
    scene.bytes() + hierarchy.map_or(0, of_hierarchy)
}
