//! Where the camera was: undo and redo.

use std::time::{Duration, Instant};

use super::rig::Rig;

/// A movement ends where the camera rests this long.
const PAUSE: Duration = Duration::from_millis(600);

/// Most steps that are kept.
const MOST_STEPS: usize = 200;

/// The cameras before and after the one that is there.
pub struct History {
    past: Vec<Rig>,
    future: Vec<Rig>,
    /// Where the last movement ended.
    settled: Rig,
    /// The camera as it was seen last, and since when.
    last: (Rig, Instant),
    /// The hand was on it when it was seen last.
    was_held: bool,
}

impl History {
    /// Begins with a camera.
    pub fn new(rig: &Rig) -> History {
        let last = (rig.clone(), Instant::now());
        let (past, future) = (Vec::new(), Vec::new());
        History { past, future, settled: rig.clone(), last, was_held: false }
    }

    /// Sees where the camera is now; `is_held` while a button or a key moves it. What moves without a rest
    /// is one step.
    pub fn follow(&mut self, rig: &Rig, now: Instant, is_held: bool) {
        if !self.was_held && now.duration_since(self.last.1) >= PAUSE {
            let last = self.last.0.clone();
            self.settle(&last);
        }
        if *rig != self.last.0 || is_held {
            self.last = (rig.clone(), now);
        }
        self.was_held = is_held;
    }

    /// Ends a movement: what comes now is another step.
    pub fn settle(&mut self, rig: &Rig) {
        if *rig != self.settled {
            if self.past.len() == MOST_STEPS {
                self.past.remove(0);
            }
            self.past.push(std::mem::replace(&mut self.settled, rig.clone()));
            self.future.clear();
        }
        self.last.0 = rig.clone();
    }

    /// The camera before the last step.
    pub fn undo(&mut self, rig: &Rig) -> Option<Rig> {
        self.settle(rig);
        let before = self.past.pop()?;
        self.future.push(std::mem::replace(&mut self.settled, before));
        Some(self.taken())
    }

    /// The camera after the step that was undone last, where nothing has moved since.
    pub fn redo(&mut self, rig: &Rig) -> Option<Rig> {
        self.settle(rig);
        let after = self.future.pop()?;
        self.past.push(std::mem::replace(&mut self.settled, after));
        Some(self.taken())
    }

    /// True where there is something to undo, and to redo.
    pub fn has(&self, rig: &Rig) -> [bool; 2] {
        let is_moved = *rig != self.settled;
        [is_moved || !self.past.is_empty(), !is_moved && !self.future.is_empty()]
    }

    fn taken(&mut self) -> Rig {
        self.last = (self.settled.clone(), Instant::now());
        self.settled.clone()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::Camera;

    fn at(x: f64) -> Rig {
        Rig::new(&Camera::new(DVec3::new(x, 0.0, 5.0), DVec3::new(x, 0.0, 0.0)))
    }

    #[test]
    fn a_movement_is_one_step_until_it_rests() {
        let mut history = History::new(&at(0.0));
        let start = Instant::now();
        let mut follow = |x, ms, is_held| {
            history.follow(&at(x), start + Duration::from_millis(ms), is_held);
        };
        // The wheel, twice without a rest, and once more after one.
        follow(1.0, 0, false);
        follow(2.0, 200, false);
        follow(3.0, 1200, false);
        // A drag that rests on its way.
        follow(3.5, 2400, true);
        follow(3.5, 9000, true);
        follow(4.0, 9100, true);
        follow(4.0, 9200, false);
        let mut now = at(4.0);
        for x in [3.0, 2.0, 0.0] {
            now = history.undo(&now).unwrap();
            assert_eq!(now, at(x));
        }
        assert_eq!(history.undo(&now), None);
        assert_eq!(history.has(&now), [false, true]);
        for x in [2.0, 3.0, 4.0] {
            now = history.redo(&now).unwrap();
            assert_eq!(now, at(x));
        }
        assert_eq!(history.redo(&now), None);
        now = history.undo(&now).unwrap();
        // Another way from here.
        assert_eq!((&now, history.redo(&at(7.0))), (&at(3.0), None));
        assert_eq!(history.undo(&at(7.0)), Some(at(3.0)));
    }

    #[test]
    fn keys_are_steps_of_their_own() {
        let mut history = History::new(&at(0.0));
        for x in [1.0, 2.0] {
            history.settle(&at(x - 1.0));
            history.follow(&at(x), Instant::now(), false);
        }
        assert_eq!(history.undo(&at(2.0)), Some(at(1.0)));
        assert_eq!(history.undo(&at(1.0)), Some(at(0.0)));
    }

    #[test]
    fn the_oldest_steps_are_forgotten() {
        let mut history = History::new(&at(0.0));
        for x in 1..=MOST_STEPS + 5 {
            history.settle(&at(x as f64));
        }
        let mut now = at((MOST_STEPS + 5) as f64);
        while let Some(before) = history.undo(&now) {
            now = before;
        }
        assert_eq!(now, at(5.0));
    }
}
