//! The hard cases of `tests/data/hardcases.json`: one ray and one object each, in f32 numbers
//! (so in f64 as well), with exact signs and the correctly rounded `t`.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Ray, Rays};
use serde_json::Value;

use crate::{plane, scene, sphere, text_of};

/// One ray, one object, and what is true of them.
#[derive(Clone, Debug)]
pub struct HardCase {
    pub name: String,
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    pub shape: HardShape,
    /// The correctly rounded `t`; `None` for a miss.
    pub t: Option<f32>,
}

/// The object of a hard case.
#[derive(Clone, Debug)]
pub enum HardShape {
    Sphere {
        center: [f32; 3],
        radius: f32,
        /// Sign of the discriminant.
        sign_discriminant: Option<i32>,
        /// Sign of `k = (o − c)·(o − c) − r²`.
        sign_k: Option<i32>,
        /// Sign of `d·(c − o)`.
        sign_toward: Option<i32>,
    },
    Plane {
        point: [f32; 3],
        normal: [f32; 3],
        /// Sign of `d·n`.
        sign_denominator: Option<i32>,
        /// Sign of `(a − o)·n`.
        sign_numerator: Option<i32>,
    },
}

fn f32_of(bits: &Value) -> f32 {
    let text = bits.as_str().expect("a bit pattern in a string");
    f32::from_bits(u32::from_str_radix(text.trim_start_matches("0x"), 16).expect("hexadecimal"))
}

fn vector(value: &Value) -> [f32; 3] {
    std::array::from_fn(|i| f32_of(&value[i]))
}

/// `None` where the file gives no sign.
fn sign(value: &Value) -> Option<i32> {
    value.as_i64().map(|sign| sign as i32)
}

/// All hard cases.
pub fn hard_cases() -> Vec<HardCase> {
    let values: Vec<Value> =
        serde_json::from_str(&text_of("tests/data/hardcases.json")).expect("JSON");
    let cases: Vec<HardCase> = values
        .iter()
        .map(|case| HardCase {
            name: case["name"].as_str().expect("a name").to_owned(),
            origin: vector(&case["o"]),
            direction: vector(&case["d"]),
            shape: match case["kind"].as_str() {
                Some("sphere") => HardShape::Sphere {
                    center: vector(&case["c"]),
                    radius: f32_of(&case["r"]),
                    sign_discriminant: sign(&case["sign_D"]),
                    sign_k: sign(&case["sign_C"]),
                    sign_toward: sign(&case["sign_b"]),
                },
                Some("plane") => HardShape::Plane {
                    point: vector(&case["a"]),
                    normal: vector(&case["n"]),
                    sign_denominator: sign(&case["sign_dn"]),
                    sign_numerator: sign(&case["sign_num"]),
                },
                other => panic!("unknown kind {other:?}"),
            },
            t: case["hit"].as_bool().expect("hit or miss").then(|| f32_of(&case["t_bits"])),
        })
        .collect();
    assert_eq!(cases.len(), 54);
    cases
}

/// A case as a scene and its ray.
pub fn hard_scene(case: &HardCase) -> (Arc<Scene>, Rays) {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let (spheres, planes) = match case.shape {
        HardShape::Sphere { center, radius, .. } => {
            (vec![sphere(vector(center), radius.into())], vec![])
        }
        HardShape::Plane { point, normal, .. } => {
            (vec![], vec![plane(vector(point), vector(normal))])
        }
    };
    let ray = Ray { origin: vector(case.origin), direction: vector(case.direction) };
    (Arc::new(scene(spheres, planes)), Rays::List(vec![ray]))
}
