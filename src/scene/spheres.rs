//! The spheres of a scene: 32 bytes each, with colours and names only where they differ.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::{Color, ColorMap, Coloring};
use crate::error::{Error, Result, wrong_usage};

/// The set of points at distance `radius` from `center`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// Centre, world units.
    pub center: DVec3,
    /// Radius, world units, positive; a sphere of radius 0 is not hit.
    pub radius: f64,
}

impl Sphere {
    /// Returns the bits of centre and radius, which are equal for equal spheres: −0 counts as 0.
    pub(crate) fn bits(&self) -> [u64; 4] {
        let [x, y, z] = self.center.to_array();
        [x, y, z, self.radius].map(|number| (number + 0.0).to_bits())
    }
}

/// The spheres of a scene, millions of them: a slice of [`Sphere`]s, with one colour for all or one
/// for each, and names for some. A clone shares the spheres and their colours.
///
/// [`Spheres::from_rows`] takes numbers from anywhere and checks them. What is made from a vector of
/// [`Sphere`]s, or changed through the slice, is taken as it is.
#[derive(Clone, Debug)]
pub struct Spheres {
    spheres: Arc<Vec<Sphere>>,
    /// The colour of all, unless there is a list.
    color: Color,
    /// As many as there are spheres, or none.
    colors: Arc<Vec<Color>>,
    names: BTreeMap<u32, Box<str>>,
}

impl Spheres {
    /// The colour of spheres that were given none: white.
    pub const COLOR: Color = Color([1.0; 3]);

    /// Spheres from rows of x, y, z and radius, in world units. A vector's memory is kept, a slice
    /// is copied once. All are white until [`Spheres::with_color`] or [`Spheres::with_colors`].
    ///
    /// # Errors
    /// [`Error::Usage`] names the first row that is no sphere: all numbers must be finite, and the
    /// radius greater than 0.
    pub fn from_rows(rows: impl Into<Vec<[f64; 4]>>) -> Result<Spheres> {
        let spheres: Vec<Sphere> = bytemuck::cast_vec(rows.into());
        check_rows(&spheres, |sphere| problem_of(sphere, DVec3::ZERO))?;
        Ok(spheres.into())
    }

    /// Returns these spheres with every colour set to `color`.
    ///
    /// # Errors
    /// [`Error::Usage`] for components that are not from 0 to 1.
    pub fn with_color(self, color: impl Into<Color>) -> Result<Spheres> {
        let color = color.into();
        match color_problem(color) {
            Some((found, help)) => wrong_usage(format!("{found}; {help}")),
            None => Ok(Spheres { color, colors: Arc::default(), ..self }),
        }
    }

    /// Returns these spheres with a colour for each, in their order.
    ///
    /// # Errors
    /// [`Error::Usage`] for more or fewer colours than spheres, and names the first row with
    /// components that are not from 0 to 1.
    pub fn with_colors<C: Into<Color>>(
        self,
        colors: impl IntoIterator<Item = C>,
    ) -> Result<Spheres> {
        let colors: Vec<Color> = colors.into_iter().map(Into::into).collect();
        let (n_colors, n_spheres) = (colors.len(), self.len());
        if n_colors != n_spheres {
            return wrong_usage(format!(
                "{n_colors} colours for {n_spheres} spheres; give one for each, or one for all"
            ));
        }
        check_rows(&colors, |color| color_problem(*color))?;
        Ok(Spheres { colors: Arc::new(colors), ..self })
    }

    /// Returns these spheres with a colour for each that a map makes of its number; `column` is what the legend calls
    /// them. The map goes over `range`, or over all numbers that are finite; NaN is no number.
    ///
    /// # Errors
    /// [`Error::Usage`] for more or fewer numbers than spheres, for a range that does not rise, and without
    /// one, where no number is finite.
    pub fn with_numbers(
        self,
        column: &str,
        numbers: &[f64],
        map: ColorMap,
        range: Option<[f64; 2]>,
        missing_color: Color,
    ) -> Result<(Spheres, Coloring)> {
        let (n_numbers, n_spheres) = (numbers.len(), self.len());
        if n_numbers != n_spheres {
            return wrong_usage(format!(
                "{n_numbers} numbers for {n_spheres} spheres; give one for each"
            ));
        }
        if let Some([low, high]) = range
            && !(low < high && low.is_finite() && high.is_finite())
        {
            return wrong_usage(format!(
                "the range goes from {low:?} to {high:?}; its first number is the lesser one"
            ));
        }
        let mut colors: Vec<Color> = numbers.iter().map(|&number| Color([number; 3])).collect();
        let coloring = Coloring::paint(column.to_owned(), map, range, missing_color, &mut colors);
        let coloring = coloring.ok_or_else(|| {
            Error::Usage("no number is finite; give the range that they would have".into())
        })?;
        Ok((Spheres { colors: Arc::new(colors), ..self }, coloring))
    }

    /// Adds a sphere behind the others.
    pub fn push(&mut self, sphere: Sphere, color: Color) {
        if self.takes(color) {
            self.color = color;
        } else {
            self.list_colors().push(color);
        }
        Arc::make_mut(&mut self.spheres).push(sphere);
    }

    /// Adds spheres behind the others: of one colour, or each of its own where there are `colors`.
    pub(super) fn append(
        &mut self,
        mut spheres: Vec<Sphere>,
        mut color: Color,
        mut colors: Vec<Color>,
    ) {
        if let [first, others @ ..] = &colors[..]
            && others.iter().all(|other| other == first)
        {
            // As atoms of one element have it.
            (color, colors) = (*first, Vec::new());
        }
        if self.is_empty() {
            (self.spheres, self.color, self.colors) = (spheres.into(), color, colors.into());
            return;
        }
        if !(colors.is_empty() && self.takes(color)) {
            colors.resize(spheres.len(), color);
            self.list_colors().append(&mut colors);
        }
        Arc::make_mut(&mut self.spheres).append(&mut spheres);
    }

    /// Rows of x, y, z and radius.
    pub fn rows(&self) -> &[[f64; 4]] {
        bytemuck::cast_slice(self)
    }

    /// The colour of the sphere with this index.
    pub fn color(&self, index: usize) -> Option<Color> {
        (index < self.len()).then(|| self.colors.get(index).copied().unwrap_or(self.color))
    }

    /// The colours, in the order of the spheres.
    pub fn colors(&self) -> impl Iterator<Item = Color> {
        (0..self.len()).filter_map(|index| self.color(index))
    }

    /// The name of the sphere with this index, where it has one.
    pub fn name(&self, index: usize) -> Option<&str> {
        self.names.get(&u32::try_from(index).ok()?).map(|name| &**name)
    }

    /// True where a sphere has a name.
    pub fn has_names(&self) -> bool {
        !self.names.is_empty()
    }

    /// The index of the last sphere with a name.
    pub(super) fn last_name(&self) -> Option<u32> {
        self.names.last_key_value().map(|(&index, _)| index)
    }

    /// Names the sphere with this index.
    pub fn set_name(&mut self, index: u32, name: impl Into<Box<str>>) {
        self.names.insert(index, name.into());
    }

    /// Bytes of memory that the spheres and their colours take, without names.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self[..]) + size_of_val(&self.colors[..])) as u64
    }

    /// True where all spheres have one colour, and still do with more of this one.
    fn takes(&self, color: Color) -> bool {
        self.colors.is_empty() && (self.is_empty() || color == self.color)
    }

    /// The list of the colours of all spheres.
    fn list_colors(&mut self) -> &mut Vec<Color> {
        let colors = Arc::make_mut(&mut self.colors);
        if colors.is_empty() {
            colors.resize(self.spheres.len(), self.color);
        }
        colors
    }
}

impl Default for Spheres {
    fn default() -> Spheres {
        Vec::new().into()
    }
}

impl Deref for Spheres {
    type Target = [Sphere];

    fn deref(&self) -> &[Sphere] {
        &self.spheres
    }
}

impl DerefMut for Spheres {
    fn deref_mut(&mut self) -> &mut [Sphere] {
        Arc::make_mut(&mut self.spheres).as_mut_slice()
    }
}

impl PartialEq for Spheres {
    fn eq(&self, other: &Spheres) -> bool {
        self[..] == other[..] && self.names == other.names && self.colors().eq(other.colors())
    }
}

impl From<Vec<Sphere>> for Spheres {
    fn from(spheres: Vec<Sphere>) -> Spheres {
        Spheres {
            spheres: Arc::new(spheres),
            color: Spheres::COLOR,
            colors: Arc::default(),
            names: BTreeMap::new(),
        }
    }
}

impl FromIterator<(Sphere, Color)> for Spheres {
    fn from_iter<I: IntoIterator<Item = (Sphere, Color)>>(spheres: I) -> Spheres {
        let mut all = Spheres::default();
        spheres.into_iter().for_each(|(sphere, color)| all.push(sphere, color));
        all
    }
}

/// A finding, and advice.
pub(super) type Problem = (String, &'static str);

/// Why this is no sphere of a scene seen from `eye`.
pub(super) fn problem_of(sphere: &Sphere, eye: DVec3) -> Option<Problem> {
    let &Sphere { center, radius } = sphere;
    let reach = center.abs() + DVec3::splat(radius);
    if reach.is_finite() && (center - eye).is_finite() && radius > 0.0 {
        return None;
    }
    Some(if !center.is_finite() || !radius.is_finite() {
        let [x, y, z] = center.to_array();
        (
            format!("not all numbers are finite: centre ({x:?}, {y:?}, {z:?}), radius {radius:?}"),
            "coordinates and radii are finite numbers (up to 1.8e308)",
        )
    } else if radius <= 0.0 {
        (format!("the radius is {radius:?}"), "a radius is greater than 0")
    } else {
        (
            "the sphere reaches too far from the eye or the origin".into(),
            "sums and differences of coordinates must stay below 1.8e308, the largest 64-bit float",
        )
    })
}

fn color_problem(Color([red, green, blue]): Color) -> Option<Problem> {
    let is_colored = [red, green, blue].iter().all(|part| (0.0..=1.0).contains(part));
    (!is_colored).then(|| {
        (
            format!("the colour is ({red:?}, {green:?}, {blue:?})"),
            "red, green and blue are linear, each from 0 to 1",
        )
    })
}

/// Refuses the first row with a problem.
fn check_rows<T>(rows: &[T], problem: impl Fn(&T) -> Option<Problem>) -> Result<()> {
    match rows.iter().enumerate().find_map(|(row, it)| Some((row, problem(it)?))) {
        Some((row, (found, help))) => {
            wrong_usage(format!("row {row} (counted from 0): {found}; {help}"))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_not_copied() {
        let rows = vec![[1.0, 2.0, 3.0, 0.5]; 100];
        let at = rows.as_ptr();
        let spheres = Spheres::from_rows(rows).unwrap();
        assert_eq!(spheres.rows().as_ptr(), at);
        assert_eq!(spheres.clone().rows().as_ptr(), at);
        assert_eq!((spheres[99].center, spheres[99].radius), (DVec3::new(1.0, 2.0, 3.0), 0.5));
        assert_eq!(spheres.bytes(), 3200);
        let colors = vec![[0.25, 0.5, 1.0]; 100];
        let colored = spheres.with_colors(colors).unwrap();
        assert_eq!((colored.rows().as_ptr(), colored.bytes()), (at, 5600));
        assert_eq!(colored.color(99), Some(Color([0.25, 0.5, 1.0])));
        assert_eq!((colored.color(100), colored.name(0)), (None, None));
    }

    #[test]
    fn a_wrong_row_is_named() {
        let with = |row: [f64; 4]| {
            let mut rows = vec![[0.0, 0.0, 0.0, 1.0]; 9];
            rows[7] = row;
            rows[8] = [f64::NAN; 4];
            Spheres::from_rows(rows).unwrap_err()
        };
        for (row, found) in [
            ([0.0, f64::NAN, 0.0, 1.0], "not all numbers are finite: centre (0.0, NaN, 0.0)"),
            ([0.0, 0.0, 0.0, f64::INFINITY], "radius inf"),
            ([0.0, 0.0, 0.0, 0.0], "the radius is 0.0"),
            ([0.0, 0.0, 0.0, -2.0], "the radius is -2.0"),
            ([f64::MAX, 0.0, 0.0, f64::MAX], "too far"),
        ] {
            let error = with(row);
            assert_eq!(error.exit_code(), 2);
            let text = error.to_string();
            assert!(text.starts_with("row 7 (counted from 0): ") && text.contains(found), "{text}");
        }
    }

    #[test]
    fn wrong_colors_are_named() {
        let spheres = Spheres::from_rows([[0.0, 0.0, 0.0, 1.0]; 3]).unwrap();
        let text = |result: Result<Spheres>| result.unwrap_err().to_string();
        let few = text(spheres.clone().with_colors([[0.0; 3]; 2]));
        assert!(few.contains("2 colours for 3 spheres"), "{few}");
        let wrong = text(spheres.clone().with_colors([[0.0; 3], [0.0, 1.5, 0.0], [2.0; 3]]));
        assert!(wrong.contains("row 1 ") && wrong.contains("(0.0, 1.5, 0.0)"), "{wrong}");
        let one = text(spheres.with_color([f32::NAN, 0.0, 0.0]));
        assert!(one.contains("(NaN, 0.0, 0.0)"), "{one}");
    }

    #[test]
    fn colors_are_kept_one_for_all_while_they_are_equal() {
        let sphere = |x| Sphere { center: DVec3::X * x, radius: 1.0 };
        let (red, blue) = (Color([1.0, 0.0, 0.0]), Color([0.0, 0.0, 1.0]));
        let mut spheres = Spheres::default();
        spheres.push(sphere(0.0), red);
        spheres.push(sphere(1.0), red);
        assert_eq!(spheres.bytes(), 2 * 32);
        let before = spheres.clone();
        spheres.push(sphere(2.0), blue);
        spheres.set_name(2, "last");
        assert_eq!(spheres.bytes(), 3 * 56);
        assert!(spheres.colors().eq([red, red, blue]));
        assert_eq!((spheres.name(1), spheres.name(2)), (None, Some("last")));
        assert_eq!((before.len(), before.color(1), before.color(2)), (2, Some(red), None));
        let each = Spheres::from_iter([(sphere(0.0), red), (sphere(1.0), red)]);
        assert_eq!(each, before);
        assert_ne!(each.with_color(blue).unwrap(), before);
    }
}
