//! What `shaders/certified.wgsl` and `shaders/tree.wgsl` do: each ray alone, in f32.

use kugelblitz::bvh::{FlatBox, IS_LEAF, MOST_BOXES, MOST_BOXES_TO_LIGHT};
use kugelblitz::gpu::slabs::{LEAST_SLACK, Slabs, is_near};
use kugelblitz::num::fields::{FieldSource, Fields};
use kugelblitz::num::{Real, UNDECIDED, V3};
use kugelblitz::prepare::{DeviceBvh, ObjectRecords, Prepared};
use kugelblitz::rays::{Frame, List, Rays};
use kugelblitz::scene::Object;
use kugelblitz::shape::{
    Contact, Nearest, Occluder, Occlusion, PlaneRecord, Ray, ShadowRay, ShapeRecord as _,
    SphereRecord,
};
use rayon::prelude::*;

/// The proposals of the kernel `certified` where each ray is looked at alone, by the formulas of a device: the
/// twin that a device's proposals are compared with. The CPU may leave other rays open, but never sees another object. `None`
/// where a device finds no way through a scene.
pub fn propose_alone(prepared: &Prepared, rays: &Rays) -> Option<Vec<u32>> {
    let twin = Twin::new(prepared)?;
    let all = (0..rays.len()).into_par_iter();
    Some(all.map(|index| twin.decide::<f32>(&twin.ray(rays, index))).collect())
}

/// A prepared scene as a device has it, for any number like an f32.
pub struct Twin<'a> {
    prepared: &'a Prepared,
    in_space: Option<DeviceBvh>,
    most_boxes: u32,
}

impl Twin<'_> {
    /// `None` where a device finds no way through the scene.
    pub fn new(prepared: &Prepared) -> Option<Twin<'_>> {
        let in_space = prepared.in_space().expect("memory for the boxes of a tree");
        let has_way = in_space.is_some() || prepared.hierarchy.is_none();
        has_way.then_some(Twin { prepared, in_space, most_boxes: MOST_BOXES })
    }

    /// The scene as a device lights it.
    pub fn lit(self) -> Self {
        Twin { most_boxes: MOST_BOXES_TO_LIGHT, ..self }
    }

    /// One of these rays.
    pub fn ray<R: Real<One = f32>>(&self, rays: &Rays, index: usize) -> Ray<R> {
        match rays {
            Rays::Pixels(pixels) => {
                let (x, y) = pixels.xy(index);
                let (i, j) = pixels.offset2(x, y);
                Frame::of_pixels(pixels).ray(R::splat(i as f32), R::splat(j as f32))
            }
            Rays::List(rays) => {
                let (origin, direction) = List::new(rays, self.prepared.origins()).ray(index);
                let [origin, direction] = [origin, direction].map(V3::<f32>::lit);
                Ray::new(V3::splat(origin), V3::splat(direction))
            }
        }
    }

    /// The id that a ray sees, or [`UNDECIDED`].
    pub fn decide<R: Real<One = f32, Id = u32>>(&self, ray: &Ray<R>) -> u32 {
        let mut nearest = self.nearest_listed(ray);
        match self.look_in_tree(ray, &mut nearest) {
            Some(_) => nearest.decide().0,
            None => UNDECIDED,
        }
    }

    /// Number of boxes that a ray visits.
    pub fn n_boxes(&self, ray: &Ray<f32>) -> u32 {
        let n_boxes = self.look_in_tree(ray, &mut self.nearest_listed(ray));
        n_boxes.unwrap_or(self.most_boxes)
    }

    /// What a ray sees of the records that a device has in its buffers.
    fn nearest_listed<R: Real<One = f32, Id = u32>>(&self, ray: &Ray<R>) -> Nearest<R> {
        let ObjectRecords::Certified { lists, any_close } = &self.prepared.objects else {
            panic!("a kernel without a proof")
        };
        let rest = self.prepared.hierarchy.as_ref().map(|hierarchy| &hierarchy.leaves.rest[..]);
        let id_at = |place: usize| match rest {
            Some(rest) => rest.get(place).copied().unwrap_or(0),
            None => place as u32 + 1,
        };
        let mut nearest = Nearest::none();
        for (place, words) in lists.spheres.iter().enumerate() {
            let sphere: SphereRecord<R> = record(words);
            let far = SphereRecord::bounds(&sphere, ray);
            let close = any_close.then(|| SphereRecord::bounds_close(&sphere, ray)).flatten();
            let is_close = record::<f32, SphereRecord<f32>>(words).is_close > 0.0;
            if let Some(next) = if is_close { close } else { far } {
                nearest = nearest.with(next, id_at(place));
            }
        }
        let n_spheres = self.prepared.scene.spheres.len();
        for (index, words) in lists.planes.iter().enumerate() {
            if let Some(next) = PlaneRecord::bounds(&record(words), ray) {
                nearest = nearest.with(next, (n_spheres + index) as u32 + 1);
            }
        }
        nearest
    }

    /// Returns the number of boxes visited, or `None` if there are too many.
    fn look_in_tree<R: Real<One = f32, Id = u32>>(
        &self,
        ray: &Ray<R>,
        nearest: &mut Nearest<R>,
    ) -> Option<u32> {
        let (Some(DeviceBvh { boxes, beside }), Some(hierarchy)) =
            (&self.in_space, &self.prepared.hierarchy)
        else {
            return Some(0);
        };
        let slabs = Slabs::new(ray, R::splat(LEAST_SLACK + beside));
        // Lanes without a leaf look at the first one; where no sphere has a box there is none.
        if !boxes.is_empty() {
            hierarchy.leaves.add(0, ray, &mut Nearest::none());
        }
        let mut at = 0;
        for n_boxes in 0..=self.most_boxes {
            let Some(node) = boxes.get(at) else { return Some(n_boxes) };
            let (is_met, next) = step(node, &slabs, nearest.high());
            at += next;
            if is_met && node.link & IS_LEAF != 0 {
                hierarchy.leaves.add(node.link & !IS_LEAF, ray, nearest);
            }
        }
        None
    }

    /// What is in the way of a shadow ray that starts on the object `own`: `listed`, and the spheres of the tree.
    pub fn shadow(
        &self,
        listed: Occlusion<f32>,
        ray: &ShadowRay<f32>,
        contacts: &[Contact],
        own: u32,
    ) -> Occlusion<f32> {
        let Some(DeviceBvh { boxes, .. }) = &self.in_space else { return listed };
        let slabs = Slabs::to_light(ray);
        let most = if is_near(ray) { self.most_boxes } else { 0 };
        let (mut at, mut verdict) = (0, listed);
        for _ in 0..most {
            let Some(node) = boxes.get(at) else { break };
            let (is_met, next) = step(node, &slabs, ray.last);
            at += next;
            if is_met && node.link & IS_LEAF != 0 && node.id != own {
                let sphere = &self.prepared.scene.spheres[node.id as usize - 1];
                let met = Occluder::new(Object::Sphere(sphere), self.prepared.reference);
                verdict = verdict.with(met.occlude(ray, Contact::side_at(contacts, node.id)));
            }
        }
        let is_ended = at == boxes.len();
        Occlusion { clear: if is_ended { verdict.clear } else { -1.0 }, ..verdict }
    }
}

/// Whether a ray meets a box, and how many boxes further a walk goes on.
fn step<R: Real<One = f32, Id = u32>>(node: &FlatBox, slabs: &Slabs<R>, t_max: R) -> (bool, usize) {
    let [low, high] = [node.low, node.high].map(|side| V3::splat(V3(side)));
    let is_met = slabs.between(low, high).is_within(t_max);
    let is_met = R::select_id(is_met, 1, 0) == 1;
    (is_met, if is_met || node.link & IS_LEAF != 0 { 1 } else { node.link as usize })
}

/// A struct from the words of a device's buffer.
fn record<R: Real<One = f32, Id = u32>, T: Fields<R>>(words: &[f32]) -> T {
    struct Words<'a>(&'a [f32], usize);

    impl<R: Real<One = f32, Id = u32>> FieldSource<R> for Words<'_> {
        fn num(&mut self, _: &'static str) -> R {
            self.1 += 1;
            R::splat(self.0[self.1 - 1])
        }
        fn vec(&mut self, name: &'static str) -> V3<R> {
            self.1 = self.1.next_multiple_of(4);
            V3([(); 3].map(|()| self.num(name)))
        }
        fn id(&mut self, _: &'static str) -> u32 {
            self.1 += 1;
            self.0[self.1 - 1].to_bits()
        }
    }

    T::read(&mut Words(words, 0))
}
