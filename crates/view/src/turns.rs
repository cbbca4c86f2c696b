//! What comes in during one long frame, in turns.

use std::collections::VecDeque;

use eframe::egui::{Event, RawInput};

/// Events that wait for their turn.
///
/// egui looks once a frame at what is under the pointer, where it is in the end, and a press whose moves come in its
/// own frame drags nothing. A turn holds no more than such a frame may: a slow frame then loses nothing of what the
/// hand did.
#[derive(Default)]
pub struct Turns {
    /// Each with the time of the frame in which it came, seconds.
    waiting: VecDeque<(f64, Event)>,
    /// Events of a turn that no frame has taken: eframe hands them in again, before all others.
    n_untaken: usize,
    /// The time of that turn.
    time: Option<f64>,
}

impl Turns {
    /// Takes what comes in, and leaves in `input` what belongs to this frame.
    pub fn give(&mut self, input: &mut RawInput) {
        let now = input.time.unwrap_or_default();
        let new = input.events.split_off(self.n_untaken.min(input.events.len()));
        self.waiting.extend(new.into_iter().map(|event| (now, event)));
        if input.events.is_empty() {
            self.time = input.time;
            let events = &mut input.events;
            while let Some((time, event)) =
                self.waiting.pop_front_if(|(_, next)| !begins_a_turn(events, next))
            {
                // Of clicks it is asked how long after each other they came.
                self.time = Some(time);
                events.push(event);
            }
        }
        input.time = self.time;
        self.n_untaken = input.events.len();
    }

    /// A frame has taken the turn. True where more wait.
    pub fn taken(&mut self) -> bool {
        self.n_untaken = 0;
        !self.waiting.is_empty()
    }
}

/// True where an event must not come in one frame with those before it.
fn begins_a_turn(before: &[Event], next: &Event) -> bool {
    let is_move = |event: &Event| matches!(event, Event::PointerMoved(_) | Event::PointerGone);
    let is_button = |event: &Event| matches!(event, Event::PointerButton { .. });
    let after_button = before.iter().any(is_button);
    match next {
        Event::PointerButton { pressed: false, .. } => !after_button && before.iter().any(is_move),
        // Keys are carried out before the mouse, whichever came first.
        Event::Key { .. } => after_button,
        next => is_move(next) && after_button,
    }
}

#[cfg(test)]
mod tests {
    use eframe::egui::{Key, Modifiers, PointerButton, Pos2, pos2};

    use super::*;

    const AT: Pos2 = pos2(1.0, 2.0);

    fn button(pressed: bool) -> Event {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos: AT, button, pressed, modifiers }
    }

    /// A letter for each event.
    fn letters(events: &[Event]) -> String {
        let letter = |event: &Event| match event {
            Event::PointerMoved(_) => 'm',
            Event::PointerButton { pressed: true, .. } => 'P',
            Event::PointerButton { .. } => 'R',
            Event::Key { .. } => 'k',
            _ => 's',
        };
        events.iter().map(letter).collect()
    }

    fn input(time: f64, letters: &str) -> RawInput {
        let event = |letter| match letter {
            'm' => Event::PointerMoved(AT),
            's' => Event::ModifiersChanged(Modifiers::SHIFT),
            'k' => Event::Key {
                key: Key::A,
                physical_key: None,
                pressed: true,
                repeat: false,
                modifiers: Modifiers::NONE,
            },
            letter => button(letter == 'P'),
        };
        let events = letters.chars().map(event).collect();
        RawInput { time: Some(time), events, ..RawInput::default() }
    }

    /// The turns of what comes in one frame, until none waits.
    fn turns(all: &str) -> String {
        let mut turns = Turns::default();
        let mut next = input(7.0, all);
        let mut given = Vec::new();
        loop {
            turns.give(&mut next);
            assert_eq!(next.time, Some(7.0));
            given.push(letters(&next.events));
            if !turns.taken() {
                return given.join(" ");
            }
            next = input(8.0, "");
        }
    }

    #[test]
    fn a_turn_holds_what_a_frame_may() {
        for (all, expected) in [
            ("", ""),
            ("mmkm", "mmkm"),
            ("mPR", "mPR"),
            ("mPRPR", "mPRPR"),
            ("smPmmsR", "smP mms R"),
            ("kPRsk", "kPRs k"),
            ("mmR", "mm R"),
            ("RmPRmk", "R mPR mk"),
        ] {
            assert_eq!(turns(all), expected, "{all}");
        }
    }

    #[test]
    fn later_input_comes_after_what_waits_and_keeps_its_time() {
        let mut turns = Turns::default();
        let mut give = |time, all| {
            let mut input = input(time, all);
            turns.give(&mut input);
            let waits = turns.taken();
            (letters(&input.events), input.time, waits)
        };
        assert_eq!(give(1.0, "Pm"), ("P".into(), Some(1.0), true));
        assert_eq!(give(2.0, "mR"), ("mm".into(), Some(2.0), true));
        assert_eq!(give(3.0, ""), ("R".into(), Some(2.0), false));
        assert_eq!(give(4.0, ""), (String::new(), Some(4.0), false));
    }

    /// eframe hands in again what it could not show.
    #[test]
    fn what_no_frame_took_stays_first() {
        let mut turns = Turns::default();
        let mut first = input(1.0, "Pm");
        turns.give(&mut first);
        let mut again = input(2.0, "P");
        again.events.extend(input(2.0, "R").events);
        turns.give(&mut again);
        assert_eq!((letters(&again.events), again.time), ("P".into(), Some(1.0)));
        assert!(turns.taken());
        let mut next = input(3.0, "");
        turns.give(&mut next);
        assert_eq!(letters(&next.events), "m");
        assert!(turns.taken());
    }
}
