//! Number of objects of a scene, and memory for them and for a picture.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use kugelblitz::Control;
use kugelblitz::picture::{Format, PictureOptions};
use kugelblitz::prepare::{Hierarchy, Prepared, record_bytes};
use kugelblitz::query::Kernel;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::render::plan;
use kugelblitz::scene::{Cloud, Samples, Scene};
use kugelblitz::support::memory::Available;
use kugelblitz::words::count;
use kugelblitz::{Error, Result};
use serde::Serialize;

/// Size and memory of a scene or of data.
#[derive(Clone, Debug, Serialize)]
pub struct Cost {
    /// Objects of the scene.
    pub objects: ObjectCounts,
    /// Light of the scene; `null` for a scene without light.
    pub light: Option<LightOf>,
    /// Number of samples across a pixel, and down it.
    pub samples: u32,
    /// Files of spheres, in the order of their ids.
    pub clouds: Vec<CloudFacts>,
    /// Memory of the objects without the records of a kernel, bytes.
    pub bytes_scene: u64,
    /// Memory of the objects on the device without light, bytes, by the name of the kernel.
    pub bytes_device: BTreeMap<&'static str, u64>,
    /// Hierarchy over many spheres; `null` if there are few. Unstable in JSON.
    pub hierarchy: Option<Built>,
    /// Memory for a picture; `null` without a camera.
    pub picture: Option<PictureCost>,
}

/// Number of objects of a scene.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ObjectCounts {
    /// Number of spheres, including spheres of data files.
    spheres: usize,
    /// Number of planes.
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

/// The light of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct LightOf {
    /// Number of `[[light]]` tables.
    pub lights: usize,
    /// Number of directions of the sky; 0 without a sky.
    pub sky_directions: u32,
    /// Whether there is ambient light.
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
    /// Number of spheres that are not in the hierarchy: close to the eye, or out of range.
    pub spheres_outside: usize,
    /// Size of the hierarchy in memory, bytes.
    pub bytes: u64,
    /// Time to build the hierarchy, milliseconds.
    pub ms_build: f64,
}

/// A file of spheres.
#[derive(Clone, Debug, Serialize)]
pub struct CloudFacts {
    /// Path of the file.
    pub file: String,
    /// Number of its spheres.
    pub spheres: usize,
    /// Id of its first sphere.
    pub first_id: u32,
    /// Names of the columns that are not used.
    pub unused_columns: Vec<String>,
}

/// Memory for a picture.
#[derive(Clone, Debug, Serialize)]
pub struct PictureCost {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Number of pixels.
    pub rays: u64,
    /// Memory for hits and for writing, bytes, by format, without formats that cannot store the picture.
    pub bytes_memory: BTreeMap<&'static str, u64>,
    /// Other memory, bytes: the objects, and the hierarchy over many spheres with the nodes that the picture and its samples
    /// see.
    pub bytes_held: u64,
}

impl Cost {
    /// Builds the hierarchy of a scene, and returns the memory of the scene, and of these pixels if there are any.
    ///
    /// # Errors
    /// Returns the errors of [`Prepared::renewed`] and of [`plan`].
    pub fn new(scene: &Arc<Scene>, pixels: Option<&Pixels>, control: &Control) -> Result<Cost> {
        let rays = pixels.map_or(Rays::List(Vec::new()), |pixels| Rays::Pixels(*pixels));
        // All kernels but `certified` have a record for each object, which need not be made to be counted.
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
        let file = |cloud: &Cloud| CloudFacts {
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
                // Leaves out a format that cannot store the picture.
                Err(Error::TooLarge(_)) => {}
                Err(error) => return Err(error),
            }
        }
        let size = [pixels.width, pixels.height];
        Ok(PictureCost { size, rays: pixels.len() as u64, bytes_memory, bytes_held: held })
    }
}

/// Returns [`PictureCost::bytes_held`].
fn held_bytes(scene: &Scene, hierarchy: Option<&Hierarchy>, samples: Samples) -> u64 {
    let of_hierarchy = |hierarchy: &Hierarchy| {
        let views = if samples > Samples::ONE { 2 } else { 1 };
        hierarchy.bvh.bytes() + views * hierarchy.leaves.bytes()
    };
    scene.bytes() + hierarchy.map_or(0, of_hierarchy)
}
