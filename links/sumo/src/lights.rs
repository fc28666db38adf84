//! Lights: what they show, and what the program promises.
//!
//! A program of fixed times has certain ends. The phases of an actuated one last between `minDur` and `maxDur`, and its
//! next switch is likely.

use crate::client::State;
use crate::wire::Value;

/// Most intervals of a light that are given.
const MOST: usize = 8;

/// A colour for a movement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    Green,
    /// Stop if that is comfortable.
    Yellow,
    Red,
    /// Off, or blinking: the junction's signs hold.
    Dark,
}

impl Colour {
    /// The colour of a letter of a state.
    fn of(letter: u8) -> Self {
        match letter {
            b'G' | b'g' => Self::Green,
            b'y' | b'Y' => Self::Yellow,
            b'o' | b'O' => Self::Dark,
            _ => Self::Red,
        }
    }
}

/// An interval of one colour, with its end in s of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    pub colour: Colour,
    /// Earliest, likely and latest end, s of the run.
    pub ends_s: [f64; 3],
}

impl Interval {
    /// The end is certain.
    pub fn is_certain(&self) -> bool {
        self.ends_s[0] == self.ends_s[2]
    }
}

/// A phase of a program.
#[derive(Clone, Debug, PartialEq)]
struct Phase {
    letters: String,
    /// Least, usual and largest duration, s.
    lasts_s: [f64; 3],
    next: Option<usize>,
}

/// The program that a controller runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan(Vec<Phase>);

impl Plan {
    /// The program `present` of those that SUMO gives.
    pub fn of(present: &str, programs: &Value) -> Self {
        let own = programs
            .parts()
            .iter()
            .find(|one| one.parts().first().is_some_and(|id| id.text() == present));
        let parts = own.map_or(&[][..], Value::parts);
        let (kind, phases) = (parts.get(1).map_or(0.0, Value::number), parts.get(3));
        let phase = |phase: &Value| {
            let part = |index: usize| phase.parts().get(index);
            let number = |index: usize| part(index).map_or(f64::NAN, Value::number);
            let (usual_s, least_s, most_s) = (number(0), number(2), number(3));
            let lasts_s = match kind == 0.0 {
                true => [usual_s; 3],
                false => [least_s.min(usual_s), usual_s, most_s.max(usual_s)],
            };
            let next =
                part(4).and_then(|next| next.parts().first()).map(|next| next.number() as usize);
            Phase { letters: part(1).map_or("", Value::text).to_owned(), lasts_s, next }
        };
        Self(phases.map_or(&[][..], Value::parts).iter().map(phase).collect())
    }

    /// Phase of a movement in a state of `time_s` of the run, and what follows. SUMO's time is ahead by `ahead_s`.
    pub fn now(&self, state: &State, link: usize, time_s: f64, ahead_s: f64) -> Vec<Interval> {
        let Some(letter) = state.letters.as_bytes().get(link) else { return Vec::new() };
        let colour = Colour::of(*letter);
        let switch_s = state.next_s - ahead_s;
        let mut ends_s = [switch_s; 3];
        if let Some(phase) = self.0.get(state.phase) {
            let begun_s = time_s - state.spent_s;
            let [least_s, _, most_s] = phase.lasts_s;
            if least_s < most_s {
                let earliest_s = (begun_s + least_s).max(time_s);
                let latest_s = (begun_s + most_s).max(earliest_s);
                ends_s = [earliest_s, switch_s.clamp(earliest_s, latest_s), latest_s];
            }
        }
        let mut intervals = vec![Interval { colour, ends_s }];
        let mut index = state.phase;
        for _ in 0..4 * self.0.len() {
            index = self.0[index.min(self.0.len() - 1)].next.unwrap_or(index + 1) % self.0.len();
            let phase = &self.0[index];
            let last = intervals.len() - 1;
            let begin_s = intervals[last].ends_s;
            let ends_s = [0, 1, 2].map(|which| begin_s[which] + phase.lasts_s[which]);
            let colour = phase.letters.as_bytes().get(link).map_or(Colour::Red, |l| Colour::of(*l));
            if colour == intervals[last].colour {
                intervals[last].ends_s = ends_s;
            } else if intervals.len() == MOST {
                break;
            } else {
                intervals.push(Interval { colour, ends_s });
            }
        }
        if intervals.len() == 1 {
            // It never changes.
            intervals[0].ends_s = [f64::INFINITY; 3];
        } else if intervals.len() < MOST {
            // The last one may go on.
            intervals.pop();
        }
        intervals
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phase(letters: &str, lasts_s: [f64; 3]) -> Phase {
        Phase { letters: letters.to_owned(), lasts_s, next: None }
    }

    fn state(letters: &str, phase: usize, spent_s: f64, next_s: f64) -> State {
        let (controller, letters) = ("a".to_owned(), letters.to_owned());
        State { controller, letters, next_s, phase, spent_s }
    }

    #[test]
    fn a_program_of_fixed_times_promises_all_ends() {
        let plan = Plan(vec![
            phase("Gr", [30.0; 3]),
            phase("yr", [3.0; 3]),
            phase("rG", [20.0; 3]),
            phase("ry", [3.0; 3]),
        ]);
        // 5 s of the run are 105 s of SUMO, 10 s into the green.
        let now = plan.now(&state("Gr", 0, 10.0, 125.0), 0, 5.0, 100.0);
        let ends: Vec<_> = now.iter().map(|i| (i.colour, i.ends_s[1])).collect();
        assert_eq!(ends[..3], [(Colour::Green, 25.0), (Colour::Yellow, 28.0), (Colour::Red, 51.0)]);
        assert!(now.iter().all(Interval::is_certain));
        let other = plan.now(&state("Gr", 0, 10.0, 125.0), 1, 5.0, 100.0);
        assert_eq!((other[0].colour, other[0].ends_s[0]), (Colour::Red, 28.0));
    }

    #[test]
    fn an_actuated_green_ends_between_its_bounds() {
        let plan = Plan(vec![
            phase("Gr", [5.0, 40.0, 50.0]),
            phase("yr", [3.0; 3]),
            phase("rG", [5.0, 20.0, 30.0]),
        ]);
        let now = plan.now(&state("Gr", 0, 10.0, 12.0), 0, 11.0, 0.0);
        assert_eq!(now[0].ends_s, [11.0, 12.0, 51.0]);
        assert_eq!(now[1].ends_s, [14.0, 15.0, 54.0]);
        assert!(!now[1].is_certain());
    }

    #[test]
    fn a_light_that_never_changes_has_no_end() {
        let plan = Plan(vec![phase("G", [30.0; 3]), phase("g", [3.0; 3])]);
        let now = plan.now(&state("G", 0, 0.0, 30.0), 0, 0.0, 0.0);
        assert_eq!(now.len(), 1);
        assert!(now[0].ends_s[0].is_infinite());
        assert_eq!(plan.now(&state("o", 0, 0.0, 30.0), 0, 0.0, 0.0)[0].colour, Colour::Dark);
    }
}
