//! Why an object is seen, or isn't.

use kugelblitz::exact::QuadraticSurd;
use kugelblitz::rays::Rays;
use kugelblitz::support::parallel;

use super::numbers::{COLUMNS, FormulaNumber, digits};
use super::ray::RayNumbers;
use super::words::Remark;
use super::{ObjectExplanation, Reason};

impl ObjectExplanation {
    /// The rows of the roots, the near one first.
    fn roots(&self) -> impl Iterator<Item = &FormulaNumber> {
        self.derivation.quantities.iter().filter(|quantity| quantity.symbol.starts_with('t'))
    }

    /// The signs of the roots, as far as there are any.
    fn root_signs(&self) -> Vec<i32> {
        self.roots().filter_map(|root| Some(root.exact.as_ref()?.signum)).collect()
    }

    /// The sign of the number that has this symbol.
    fn sign(&self, symbol: &str) -> Option<i32> {
        let row = self.derivation.quantities.iter().find(|row| row.symbol == symbol)?;
        row.exact.as_ref().map(|exact| exact.signum)
    }

    /// The reason, where `root` is the one at which the ray meets the object.
    pub(super) fn reason(&self, root: Option<&QuadraticSurd>, numbers: &RayNumbers) -> Reason {
        match (root, &numbers.hit) {
            (Some(_), Some(hit)) if hit.id == self.id => Reason::Visible,
            (Some(root), Some(hit)) if *root == hit.root => Reason::TieLost { to: hit.id },
            (Some(_), Some(hit)) => Reason::Farther { than: hit.id },
            (Some(_), None) => Reason::TooFar,
            (None, _) if !self.root_signs().is_empty() => Reason::Behind,
            (None, _) if self.sign("D") == Some(-1) => Reason::Missed,
            (None, _) if self.sign("d·n") == Some(0) => Reason::Parallel,
            (None, _) => Reason::Degenerate,
        }
    }

    /// The reason in words, first, then what else is worth a remark; of a ray that misses, `is_at_origin` says whether
    /// its origin is the point of it that is nearest.
    pub(super) fn why(&self, numbers: &RayNumbers, is_at_origin: bool) -> Vec<Remark> {
        let words = numbers.words;
        let (is_sphere, is_hit) = (self.shape == "sphere", self.gap.is_none());
        let touches = self.sign("D") == Some(0);
        let behind = words.behind[usize::from(matches!(numbers.rays, Rays::List(_)))];
        let signs = self.root_signs();
        let of_object = |phrase, id| Remark::of(phrase, [numbers.label(id)]);
        let mut why = vec![match self.reason {
            Reason::Visible => words.visible.into(),
            Reason::Farther { than } => of_object(words.farther, than),
            Reason::TieLost { to } => of_object(words.tie, to),
            Reason::Missed => words.missed.into(),
            Reason::Behind if !is_sphere && signs == [0] => words.in_plane.into(),
            Reason::Behind if !is_sphere => Remark::of(words.plane_behind, [behind]),
            Reason::Behind if signs.contains(&0) => words.at_back.into(),
            Reason::Behind if touches => Remark::of(words.touched_behind, [behind]),
            Reason::Behind => Remark::of(words.pierced_behind, [behind]),
            Reason::Parallel if self.sign("(a−o)·n") == Some(0) => {
                words.parallel_in_plane.into()
            }
            Reason::Parallel => words.parallel.into(),
            Reason::TooFar => words.too_far.into(),
            Reason::Degenerate => words.degenerate.into(),
        }];
        if let Some(gap) = self.gap.filter(|gap| *gap > 0.0) {
            let phrase = match self.reason {
                Reason::Parallel => words.stays_away,
                _ if is_at_origin => words.passes_at_origin,
                _ => words.passes,
            };
            why.push(Remark::of(phrase, [digits(gap, 4)]));
        }
        if self.reason == Reason::Visible {
            let root = numbers.hit.as_ref().map(|hit| &hit.root);
            let n_behind = numbers.scene.n_objects() - self.id as usize;
            let tied = parallel::filter_map(n_behind, |at| {
                let id = self.id + 1 + at as u32;
                (numbers.root(id).as_ref() == root).then_some(id)
            });
            if let Some(&other) = tied.first() {
                why.push(of_object(words.tie, other));
            }
        }
        match signs.first() {
            Some(-1) if is_hit && is_sphere => why.push(words.inside.into()),
            Some(0) if is_hit && is_sphere => why.push(words.at_front.into()),
            _ => {}
        }
        if touches && self.reason != Reason::Behind {
            why.push(words.touches.into());
        }
        for (column, name) in COLUMNS.into_iter().enumerate() {
            let mut found = self.roots().filter_map(|row| row.columns()[column]?.value);
            let sees = found.any(|t| t > 0.0);
            if sees != is_hit {
                let phrase = if sees { words.wrong_hit } else { words.wrong_miss };
                why.push(Remark::of(phrase, [name]));
            }
        }
        why
    }
}
