//! What a picture is wanted to show, beside what its scene or its data say.

use glam::DVec3;

use super::schema::{CameraKeys, CloudKeys, LightKeys, SkyKeys};
use super::{Color, DataFormat, Projection, Samples};

/// What options ask for. What is `None` is as the scene says it, or as is usual.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneOverrides {
    /// The side that everything is seen from. It asks for a camera that frames everything.
    pub view: Option<Viewpoint>,
    /// Part of the picture's shorter side that is free at each edge, up to
    /// [`super::Framing::MAX_MARGIN`]. It asks for such a camera as well.
    pub margin: Option<f64>,
    /// True for an orthographic camera whose picture is as high as everything needs.
    pub is_height_chosen: bool,
    /// Directions around `up` that the camera is turned to, all of which are to see everything; 0 and 1
    /// are one picture.
    pub n_turns: u32,
    /// True where a scene without a camera gets one that frames everything, though nothing else is asked for.
    pub needs_camera: bool,
    /// Keys of the camera.
    pub camera: CameraKeys,
    /// Columns and rows.
    pub size: Option<[u32; 2]>,
    /// Samples across and down a pixel.
    pub samples: Option<Samples>,
    /// Colour where no object is.
    pub background: Option<Color>,
    /// All lights.
    pub lights: Option<Vec<LightKeys>>,
    /// The sky, or none.
    pub sky: Option<Option<SkyKeys>>,
    /// Light from nowhere, or none.
    pub ambient: Option<Option<Color>>,
    /// Keys of the data, or of a scene's only cloud.
    pub cloud: CloudKeys,
    /// Format of the file, if it is not recognized by its content.
    pub input_format: Option<InputFormat>,
}

/// A format that a scene can be made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFormat {
    /// A scene file.
    Scene,
    /// Data.
    Data(DataFormat),
}

impl InputFormat {
    /// All formats, with their names on the command line.
    pub const ALL: [(&'static str, InputFormat); 5] = [
        ("toml", InputFormat::Scene),
        ("npy", InputFormat::Data(DataFormat::Npy)),
        ("csv", InputFormat::Data(DataFormat::Table)),
        ("xyz", InputFormat::Data(DataFormat::Xyz)),
        ("lammps", InputFormat::Data(DataFormat::Lammps)),
    ];
}

/// A side that everything can be seen from: its name, and the way from what is seen to the camera where y is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint(&'static str, DVec3);

impl Viewpoint {
    /// From the front, a little from the right and from above: the side where none is said.
    pub const QUARTER: Viewpoint = Viewpoint("quarter", DVec3::new(1.0, 1.0, 2.0));

    /// All of them: [`Viewpoint::QUARTER`], the corner between right, above and front, with equal angles with all axes,
    /// and both ends of each axis.
    pub const ALL: [Viewpoint; 8] = [
        Viewpoint::QUARTER,
        Viewpoint("iso", DVec3::ONE),
        Viewpoint("x", DVec3::X),
        Viewpoint("-x", DVec3::NEG_X),
        Viewpoint("y", DVec3::Y),
        Viewpoint("-y", DVec3::NEG_Y),
        Viewpoint("z", DVec3::Z),
        Viewpoint("-z", DVec3::NEG_Z),
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        self.0
    }

    /// The way from what is seen to the camera. `up` says what is above for the two that are a little
    /// from above; then the axis that it is nearest to counts.
    pub fn direction(self, up: DVec3) -> DVec3 {
        let Viewpoint(_, direction) = self;
        if direction.min_element() > 0.0 { with_up(direction, up) } else { direction }
    }
}

/// A direction that is given for y as up, turned to where `up` is. Where z is up, the front is −y, as in
/// drawings.
fn with_up(DVec3 { x, y, z }: DVec3, up: DVec3) -> DVec3 {
    let size = up.abs();
    let largest = size.max_element();
    if size.y == largest {
        DVec3::new(x, y.copysign(up.y), z)
    } else if size.z == largest {
        DVec3::new(x, -z, y.copysign(up.z))
    } else {
        DVec3::new(y.copysign(up.x), z, x)
    }
}

/// Returns the direction that appears upward: `usual`, or one across it if the camera looks along `usual`.
pub(super) fn usual_up(from: DVec3, usual: DVec3) -> DVec3 {
    let is_along = |up: DVec3| from.cross(up).length() <= 1e-9 * from.length() * up.length();
    if !is_along(usual) {
        return usual;
    }
    // Looked at from above, what is in front is below.
    let front = if usual.y != 0.0 { DVec3::Z } else { DVec3::NEG_Y };
    // The sum leaves no zero with a sign.
    let up = if from.dot(usual) > 0.0 { DVec3::ZERO - front } else { front };
    if is_along(up) { DVec3::X } else { up }
}

impl SceneOverrides {
    /// True where the file's own text is what is wanted, but for size and samples and perhaps a camera.
    pub(super) fn leave_the_text(&self) -> bool {
        let SceneOverrides { size, samples, n_turns, needs_camera, input_format, .. } = *self;
        let rest = SceneOverrides::default();
        *self == SceneOverrides { size, samples, n_turns, needs_camera, input_format, ..rest }
    }

    /// True where the camera's place is chosen so that everything is in the picture.
    pub(super) fn frame(&self) -> bool {
        self.view.is_some() || self.margin.is_some() || self.is_height_chosen
    }

    /// The projection that is asked for, or that of the scene, or the usual one of 30°; of no height in particular where
    /// that is chosen.
    pub(super) fn projection(&self, of_scene: Option<Projection>) -> Projection {
        match (self.camera.fov, self.camera.height) {
            (Some(fov_degrees), _) => Projection::Perspective { fov_degrees },
            (_, Some(height)) => Projection::Orthographic { height },
            _ if self.is_height_chosen => Projection::Orthographic { height: 1.0 },
            _ => of_scene.unwrap_or(Projection::Perspective { fov_degrees: 30.0 }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_above_is_seen_from_above() {
        for up in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            for view in &Viewpoint::ALL[..2] {
                assert_eq!(view.direction(up).dot(up), 1.0, "{up} {view:?}");
            }
        }
        let [_, iso, ..] = Viewpoint::ALL;
        assert_eq!(iso.direction(DVec3::Z), DVec3::new(1.0, -1.0, 1.0));
    }

    #[test]
    fn up_is_never_along_the_view() {
        for usual in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)] {
            for view in Viewpoint::ALL {
                let from = view.direction(usual);
                let up = usual_up(from, usual);
                assert!(from.cross(up).length() > 0.1, "{usual} {view:?} {up}");
            }
        }
        // A plan has its front below, as a map has its south.
        assert_eq!(usual_up(DVec3::Y, DVec3::Y), DVec3::NEG_Z);
        assert_eq!(usual_up(DVec3::NEG_Y, DVec3::Y), DVec3::Z);
        assert_eq!(usual_up(DVec3::Z, DVec3::Z), DVec3::Y);
    }
}
