//! What f64 decides, what is left out of equal objects, and surfaces side by side.

use super::surfaces::{LONGEST_SCALED, MISS, Surfaces, TAndNormal, exact_surface};
use super::*;
use crate::exact::{DoubleDoubleRay, nearest, visible_hit};
use crate::kernel::Kernel;
use crate::num::UNDECIDED;
use crate::prepare::ScaledInteger;
use crate::query::{Hits, Outputs, Timing};
use crate::rays::{Lens, Pixels, View};
use crate::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use crate::support::random::SplitMix;
use std::sync::Arc;

/// Spheres that differ in the last bits and lie in no order: f64 leaves all of them open.
fn nearly_equal(n: usize) -> Vec<Sphere> {
    let sphere = |i: usize| {
        let shift = (i * 7919 % n) as f64 * f64::EPSILON;
        let center = DVec3::new(shift, 0.0, -5.0 - shift);
        Sphere { center, radius: 1.0 }
    };
    (0..n).map(sphere).collect()
}

fn pixels(width: u32, height: u32) -> Pixels {
    let (position, look_at) = (DVec3::ZERO, DVec3::NEG_Z);
    let projection = Projection::Perspective { fov_degrees: 10.0 };
    let camera = Camera { position, look_at, up: DVec3::Y, projection };
    Pixels::whole(View::new(&camera), width, height)
}

fn decide(stage: &Resolver, n_rays: usize) -> Decided {
    let rays: Vec<u32> = (0..n_rays as u32).collect();
    stage.decide(&rays, &Control::default(), &mut Timing::default()).unwrap()
}

/// However many planes and spheres coincide, one of them needs no exact arithmetic.
#[test]
fn of_equal_objects_the_first_is_the_only_candidate() {
    let plane = Plane {
        name: None,
        point: DVec3::new(0.0, 0.0, -7.0),
        normal: DVec3::Z,
        color: Color::BLACK,
    };
    let sphere = nearly_equal(1).remove(0);
    for (n_spheres, n_planes) in [(500, 1), (0, 500)] {
        let scene = Scene {
            spheres: vec![sphere; n_spheres].into(),
            planes: vec![plane.clone(); n_planes],
            ..Scene::default()
        };
        let rays = Rays::Pixels(pixels(8, 6));
        let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
        let all = decide(&Resolver::new(&prepared, &rays), 48);
        assert!(all.ids.iter().all(|&id| id == 1) && all.exactly.is_empty());
    }
}

/// Spheres and planes of all sizes and distances, a quarter of them around the origin, with rays that
/// hit each of them in the middle, at the silhouette or just beside it.
struct Hitting {
    rng: SplitMix,
    scale: f64,
}

impl Hitting {
    fn number(&mut self) -> f64 {
        2.0 * self.rng.unit() - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    /// A number of any magnitude up to some decades around the scene's scale.
    fn size(&mut self) -> f64 {
        self.scale * 10f64.powf(4.0 * self.number())
    }

    fn sphere(&mut self) -> Sphere {
        let center = self.vector().normalize() * self.size();
        let radius = match self.rng.bits() % 4 {
            0 => center.length() * (1.0 + 10f64.powf(-8.0 * self.rng.unit())),
            _ => center.length() * 10f64.powf(-4.0 * self.rng.unit()),
        };
        Sphere { center, radius }
    }

    fn plane(&mut self) -> Plane {
        let (point, normal) = (self.vector() * self.size(), self.vector() * self.size());
        Plane { name: None, point, normal, color: Color::BLACK }
    }

    /// A ray at `target`, `away` from it.
    fn ray(&mut self, origin: DVec3, target: &Sphere) -> WorldRay {
        let to_center = target.center - origin;
        let aside = to_center.cross(self.vector()).normalize();
        let off = match self.rng.bits() % 3 {
            0 => self.rng.unit(),
            1 => 1.0 - 2f64.powf(-50.0 * self.rng.unit()),
            _ => 1.0,
        };
        let length = 2f64.powi((self.rng.bits() % 80) as i32 - 40);
        WorldRay { origin, direction: (to_center + aside * (off * target.radius)) * length }
    }
}

/// A scene, and rays of a camera with this lens, or of a list.
fn case(seed: u64, lens: Option<Lens>) -> (Scene, Rays) {
    case_of([1, 5, 40][seed as usize % 3], seed, lens)
}

fn case_of(n_spheres: usize, seed: u64, lens: Option<Lens>) -> (Scene, Rays) {
    let mut random = Hitting { rng: SplitMix::new(seed), scale: 1.0 };
    random.scale = 10f64.powf(8.0 * random.number());
    let spheres: Vec<Sphere> = (0..n_spheres).map(|_| random.sphere()).collect();
    let planes = (0..seed % 3).map(|_| random.plane()).collect();
    let target = spheres[0];
    let rays = match lens {
        None => {
            let ray = |i: usize| {
                let origin = random.vector() * random.size();
                random.ray(origin, &spheres[i % spheres.len()])
            };
            Rays::List((0..300).map(ray).collect())
        }
        Some(lens) => {
            let position = random.vector() * random.size();
            let projection = match lens {
                Lens::Perspective => {
                    Projection::Perspective { fov_degrees: 5.0 + 100.0 * random.rng.unit() }
                }
                Lens::Orthographic => Projection::Orthographic { height: 2.5 * target.radius },
            };
            let camera =
                Camera { position, look_at: target.center, up: random.vector(), projection };
            let [width, height] = [1 + random.rng.bits() % 90, 1 + random.rng.bits() % 20];
            Rays::Pixels(Pixels::whole(View::new(&camera), width as u32, height as u32))
        }
    };
    (Scene { spheres: spheres.into(), planes, ..Scene::default() }, rays)
}

/// The object of each ray, and room for `t` and normals.
fn decided(stage: &Resolver, n_rays: usize) -> Hits {
    let mut hits = Hits::default();
    hits.make_room(n_rays, Outputs { surface: true, level: false }).unwrap();
    hits.id = decide(stage, n_rays).ids;
    hits
}

/// How many hits are not what one ray by itself gives, bit by bit.
fn n_different(stage: &Resolver, hits: &Hits) -> usize {
    let differs = |&ray: &usize| {
        let alone = match hits.id[ray] {
            0 => MISS,
            id => stage.surface(ray, id).unwrap(),
        };
        let bits = |(t, [x, y, z]): TAndNormal| [t, x, y, z].map(f32::to_bits);
        bits(alone) != bits((hits.t[ray], hits.normal[ray]))
    };
    (0..hits.id.len()).filter(differs).count()
}

#[test]
fn no_direction_of_a_list_is_longer() {
    let longest = ScaledInteger::new(DVec3::splat(2f64.next_down())).rounded().length();
    assert!(longest < LONGEST_SCALED && longest > 0.99 * LONGEST_SCALED, "{longest}");
}

#[test]
fn surfaces_side_by_side_are_those_of_one_ray() {
    let (mut n_hits, mut n_open) = ([0; 3], [0; 3]);
    for (kind, lens) in
        [Some(Lens::Perspective), Some(Lens::Orthographic), None].into_iter().enumerate()
    {
        for seed in 0..90 {
            let (scene, rays) = case(seed, lens);
            let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
            let stage = Resolver::new(&prepared, &rays);
            let mut hits = decided(&stage, rays.len());
            let (surfaces, control) = (Surfaces::to_be_rounded(&stage), Control::default());
            let Hits { id, t, normal, .. } = &mut hits;
            stage.complete(&surfaces, (0, id), (t, normal), &control, &mut Vec::new()).unwrap();
            assert_eq!(n_different(&stage, &hits), 0, "{lens:?}, seed {seed}");
            let hit = hits.id.iter().position(|&id| id != 0);
            if let Some(ray) = hit {
                hits.normal[ray][1] = hits.normal[ray][1].next_up();
                assert_eq!(n_different(&stage, &hits), 1, "{lens:?}, seed {seed}");
            }

            let (mut t, mut normal) = (hits.t.clone(), hits.normal.clone());
            surfaces.round(0, &hits.id, &mut Vec::new(), &mut t, &mut normal);
            let open: Vec<usize> = (0..t.len()).filter(|&ray| t[ray] == 0.0).collect();
            n_hits[kind] += hits.n_hits();
            n_open[kind] += open.len();
        }
    }
    println!("{n_hits:?} hits, of which f64 leaves {n_open:?} open");
    assert!(n_hits.iter().all(|&n| n > 5000) && n_open.iter().all(|&n| n > 0));
}

/// With 100 bits nearly all is known, and it is what exact arithmetic says, bit by bit.
#[test]
fn surfaces_in_balls_are_exact() {
    for lens in [Some(Lens::Perspective), Some(Lens::Orthographic), None] {
        let (mut n_known, mut n_open) = (0, 0);
        for seed in 400..490 {
            let (scene, rays) = case(seed, lens);
            let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
            let stage = Resolver::new(&prepared, &rays);
            let hits = decided(&stage, rays.len());
            for (index, &id) in hits.id.iter().enumerate() {
                let Some(object) = stage.prepared.scene.object(id) else { continue };
                let Some(found) = DoubleDoubleRay::new(stage.rays, index).surface(object, 1.0)
                else {
                    n_open += 1;
                    continue;
                };
                n_known += 1;
                let ray = stage.exact.ray(index);
                let exact =
                    exact_surface(&ray, &visible_hit(&ray, id, object).unwrap(), LengthUnit::WORLD);
                let bits = |(t, normal): TAndNormal| (t.to_bits(), normal.map(f32::to_bits));
                assert_eq!(bits(found), bits(exact), "{lens:?}, seed {seed}, ray {index}");
            }
        }
        println!("{lens:?}: {n_known} known in balls, {n_open} left open");
        assert!(n_known > 50 * n_open && n_known > 3000, "{n_open} open, {n_known} known");
    }
}

#[test]
fn what_f64_decides_is_what_is_seen() {
    for (n_spheres, lens) in [
        (0, Some(Lens::Perspective)),
        (5, Some(Lens::Perspective)),
        (40, Some(Lens::Perspective)),
        (5, Some(Lens::Orthographic)),
        (40, Some(Lens::Orthographic)),
        (300, Some(Lens::Perspective)),
        (300, Some(Lens::Orthographic)),
        (40, None),
        (300, None),
    ] {
        let [mut n_rays, mut n_hits, mut n_open] = [0; 3];
        for seed in 200..260 {
            let (scene, rays) = case_of(n_spheres.max(1), seed, lens);
            let scene = match n_spheres {
                0 => Scene { spheres: Vec::new().into(), ..scene },
                _ => scene,
            };
            let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
            let stage = Resolver::new(&prepared, &rays);
            let all: Vec<u32> = (0..rays.len() as u32).collect();
            let mut ids = vec![7; all.len()];
            stage.find.decide(&all, &Control::default(), &mut ids).unwrap();
            for (ray, id) in ids.into_iter().enumerate() {
                n_rays += 1;
                n_hits += usize::from(id != 0 && id != UNDECIDED);
                n_open += usize::from(id == UNDECIDED);
                if id != UNDECIDED {
                    let seen = nearest(&stage.exact.ray(ray), stage.prepared.scene.objects())
                        .map_or(0, |hit| hit.id);
                    assert_eq!(id, seen, "{lens:?} of {n_spheres}, seed {seed}, ray {ray}");
                }
            }
        }
        println!("{lens:?} of {n_spheres}: {n_rays} rays, {n_hits} hits, {n_open} open");
        assert!(n_rays > 5000 && n_open < n_rays / 4, "{n_open} of {n_rays}");
        assert!(n_hits > n_rays / 10 || n_spheres == 0, "{n_hits} of {n_rays}");
    }
}
