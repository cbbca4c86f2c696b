//! Why an object is seen, or isn't.

use kugelblitz::exact::{ExactHit, Root, Shape, visible_root};
use kugelblitz::scene::Scene;
use rayon::prelude::*;

use super::numbers::{COLUMNS, digits};
use super::ray::RayNumbers;
use super::words::Remark;
use super::{ObjectExplanation, Reason};
use crate::verify::is_clearly_missed;

impl ObjectExplanation {
    pub(super) fn reason(&self, root: Option<&Root>, hit: Option<&ExactHit>) -> Reason {
        match (root, hit) {
            (Some(_), Some(hit)) if hit.id == self.id => Reason::Visible,
            (Some(root), Some(hit)) if *root == hit.root => Reason::TieLost { to: hit.id },
            (Some(_), Some(hit)) => Reason::Farther { than: hit.id },
            (Some(_), None) => Reason::TooFar,
            (None, _) => self.why_missed(),
        }
    }

    fn why_missed(&self) -> Reason {
        let sign = |symbol| self.exact(symbol).map(|exact| exact.signum);
        match (sign("D"), sign("d·n")) {
            _ if self.roots().any(|root| root.exact.is_some()) => Reason::Behind,
            (Some(-1), _) => Reason::Missed,
            (_, Some(0)) => Reason::Parallel,
            _ => Reason::Degenerate,
        }
    }

    /// The reason in words, first, then what else is worth a remark; of a ray that misses, whether its
    /// origin is the point of it that is nearest.
    pub(super) fn why(
        &self,
        scene: &Scene,
        is_hit: bool,
        hit: Option<&ExactHit>,
        (numbers, is_at_origin): (&RayNumbers, bool),
    ) -> Vec<Remark> {
        let words = numbers.words;
        let is_sphere = self.shape == "sphere";
        let touches = self.exact("D").is_some_and(|exact| exact.signum == 0);
        let from = usize::from(!numbers.is_pixel);
        let signs: Vec<i32> =
            self.roots().filter_map(|root| Some(root.exact.as_ref()?.signum)).collect();
        let of_object = |phrase, id| Remark::of(phrase, [numbers.label(scene, id)]);
        let mut why = vec![match self.reason {
            Reason::Visible => words.visible.into(),
            Reason::Farther { than } => of_object(words.farther, than),
            Reason::TieLost { to } => of_object(words.tie, to),
            Reason::Missed => words.missed.into(),
            Reason::Behind if !is_sphere && signs == [0] => words.in_plane.into(),
            Reason::Behind if !is_sphere => Remark::of(words.plane_behind, [words.behind[from]]),
            Reason::Behind if signs.contains(&0) => words.at_back.into(),
            Reason::Behind if touches => Remark::of(words.touched_behind, [words.behind[from]]),
            Reason::Behind => Remark::of(words.pierced_behind, [words.behind[from]]),
            Reason::Parallel => match self.exact("(a−o)·n").map(|exact| exact.signum) {
                Some(0) => words.parallel_in_plane.into(),
                _ => words.parallel.into(),
            },
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
            let tied = |&id: &u32| {
                let root = scene
                    .object(id)
                    .filter(|object| !is_clearly_missed(&numbers.near, object))
                    .and_then(|object| visible_root(&numbers.exact, &Shape::from(object)));
                root.zip(hit).is_some_and(|((root, _), hit)| root == hit.root)
            };
            let others = self.id + 1..=scene.n_objects() as u32;
            if let Some(other) = others.into_par_iter().find_first(tied) {
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
            let found = self.roots().filter_map(|row| row.columns()[column]?.value);
            let sees = found.into_iter().any(|t| t > 0.0);
            if sees != is_hit {
                let phrase = if sees { words.wrong_hit } else { words.wrong_miss };
                why.push(Remark::of(phrase, [name]));
            }
        }
        why
    }
}
