//! A scene as its file says, read by the contract alone: the camera's frame, the sky's suns and linear
//! colours are made here again, in the steps that the contract and the guide name.

use toml::{Table, Value};

pub type V = [f64; 3];

/// All that a picture depends on.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    pub background: V,
    pub ambient: Option<V>,
    pub camera: Option<Camera>,
    pub lights: Vec<Light>,
    pub sky: Option<Sky>,
    pub spheres: Vec<Sphere>,
    pub planes: Vec<Plane>,
}

/// The camera's f64 numbers.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    pub position: V,
    pub forward: V,
    pub right: V,
    pub true_up: V,
    /// `tan(fov/2)`, or half the height of an orthographic picture.
    pub h: f64,
    pub is_orthographic: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub center: V,
    pub radius: f64,
    pub color: V,
}

#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub point: V,
    pub normal: V,
    pub color: V,
}

#[derive(Clone, Copy, Debug)]
pub enum Source {
    Point(V),
    /// The way that its light travels.
    Sun(V),
    Eye,
}

#[derive(Clone, Copy, Debug)]
pub struct Light {
    pub source: Source,
    pub color: V,
    pub intensity: f64,
    pub shadows: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Sky {
    pub intensity: f64,
    pub directions: u32,
}

impl Scene {
    pub fn is_lit(&self) -> bool {
        !self.lights.is_empty() || self.sky.is_some() || self.ambient.is_some()
    }

    /// The colour of the object with this id, from 1.
    pub fn color(&self, id: u32) -> V {
        let index = id as usize - 1;
        match self.spheres.get(index) {
            Some(sphere) => sphere.color,
            None => self.planes[index - self.spheres.len()].color,
        }
    }
}

// ---------------------------------------------------------------------------------------------
// What the contract has computed in f64

/// IEC 61966-2-1, encoded to linear.
pub fn linear(encoded: f64) -> f64 {
    match encoded <= 0.04045 {
        true => encoded / 12.92,
        false => libm::pow((encoded + 0.055) / 1.055, 2.4),
    }
}

fn cross(u: V, v: V) -> V {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// `v` divided by the power of two just not above its largest component.
fn about_one(v: V) -> V {
    let largest = v.iter().fold(0f64, |largest, x| largest.max(x.abs()));
    let power = match largest < f64::MIN_POSITIVE {
        true => f64::MIN_POSITIVE,
        // The exponent without the fraction.
        false => f64::from_bits(largest.to_bits() >> 52 << 52),
    };
    v.map(|x| x / power)
}

fn unit(v: V) -> V {
    let [x, y, z] = about_one(v);
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

/// How a camera says what it sees of the world.
pub enum Projection {
    Fov(f64),
    Height(f64),
}

impl Camera {
    pub fn new(position: V, look_at: V, up: V, projection: Projection) -> Camera {
        let forward = unit(std::array::from_fn(|i| look_at[i] - position[i]));
        let right = unit(cross(forward, about_one(up)));
        let (h, is_orthographic) = match projection {
            Projection::Fov(degrees) => (libm::tan(degrees.to_radians() / 2.0), false),
            Projection::Height(height) => (height / 2.0, true),
        };
        Camera { position, forward, right, true_up: cross(right, forward), h, is_orthographic }
    }

    /// Whose picture of one pixel is this ray.
    pub fn along(origin: V, direction: V) -> Camera {
        let (right, true_up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let position = origin;
        Camera { position, forward: direction, right, true_up, h: 1.0, is_orthographic: false }
    }
}

impl Sky {
    /// The ways that the suns' light travels, from the lattice that the README states.
    pub fn suns(&self) -> Vec<V> {
        // Cosine and sine of π(3 − √5) to 2⁻⁵², the numbers that the guide states.
        let turn = [-0.737_368_878_078_319_9, 0.675_490_294_261_523_8];
        let [mut cos, mut sin] = [1.0, 0.0];
        let mut suns = Vec::new();
        for i in 0..self.directions {
            let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(self.directions);
            let around = (1.0 - y * y).sqrt();
            suns.push([-(around * cos), -y, -(around * sin)]);
            [cos, sin] = [cos * turn[0] - sin * turn[1], cos * turn[1] + sin * turn[0]];
        }
        suns
    }
}

// ---------------------------------------------------------------------------------------------
// The text

/// Reads a scene file's text. It is for scenes that are known to be right, so what it can't read is a
/// panic.
pub fn read(text: &str) -> Scene {
    let table: Table = text.parse().unwrap_or_else(|error| panic!("{error}\n{text}"));
    let mut scene = Scene::default();
    for (key, value) in &table {
        match key.as_str() {
            "background" => scene.background = color(value),
            "ambient" => scene.ambient = Some(color_or_number(value)),
            "camera" => scene.camera = Some(camera(value)),
            "light" => scene.lights = tables(value).map(light).collect(),
            "sky" => scene.sky = Some(sky(value)),
            "sphere" => scene.spheres = tables(value).map(sphere).collect(),
            "plane" => scene.planes = tables(value).map(plane).collect(),
            // How large a picture is, and of how many samples, its reader is told.
            "image" | "samples" => {}
            other => panic!("the oracle does not read `{other}`"),
        }
    }
    scene
}

fn tables(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().expect("tables").iter()
}

fn number(value: &Value) -> f64 {
    match value {
        Value::Integer(number) => *number as f64,
        other => other.as_float().unwrap_or_else(|| panic!("a number: {other}")),
    }
}

fn vector(value: &Value) -> V {
    let numbers: Vec<f64> = tables(value).map(number).collect();
    numbers.try_into().expect("three numbers")
}

fn color(value: &Value) -> V {
    let Some(text) = value.as_str() else {
        return vector(value);
    };
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6).expect("#rrggbb");
    std::array::from_fn(|i| {
        let byte = u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).expect("two digits");
        linear(f64::from(byte) / 255.0)
    })
}

fn color_or_number(value: &Value) -> V {
    match value {
        Value::Integer(_) | Value::Float(_) => [number(value); 3],
        other => color(other),
    }
}

fn camera(value: &Value) -> Camera {
    let up = value.get("up").map_or([0.0, 1.0, 0.0], vector);
    let projection = match value.get("height") {
        Some(height) => Projection::Height(number(height)),
        None => Projection::Fov(value.get("fov").map_or(45.0, number)),
    };
    Camera::new(vector(&value["position"]), vector(&value["look_at"]), up, projection)
}

fn light(value: &Value) -> Light {
    let source = match (value.get("position"), value.get("direction")) {
        (Some(Value::String(_)), _) => Source::Eye,
        (Some(position), _) => Source::Point(vector(position)),
        (None, direction) => Source::Sun(vector(direction.expect("a direction"))),
    };
    Light {
        source,
        color: value.get("color").map_or([1.0; 3], color),
        intensity: value.get("intensity").map_or(1.0, number),
        shadows: value.get("shadows").is_none_or(|shadows| shadows.as_bool().expect("a flag")),
    }
}

fn sky(value: &Value) -> Sky {
    let directions = value.get("directions").map_or(64, |n| n.as_integer().expect("a number"));
    Sky { intensity: number(&value["intensity"]), directions: directions as u32 }
}

fn sphere(value: &Value) -> Sphere {
    let (center, radius) = (vector(&value["center"]), number(&value["radius"]));
    Sphere { center, radius, color: color(&value["color"]) }
}

fn plane(value: &Value) -> Plane {
    let (point, normal) = (vector(&value["point"]), vector(&value["normal"]));
    Plane { point, normal, color: color(&value["color"]) }
}
