//! Lights: what they show, and what the program promises.
//!
//! A program of fixed times has certain ends. The phases of an actuated one last between `minDur` and `maxDur`, and its
//! next switch is likely.

use messages::{MAX_INTERVALS, PhaseState};

use crate::wire::Value;

/// The state that a movement has, and its earliest, likely and latest end, s of the run.
pub type Interval = (PhaseState, [f64; 3]);

/// The state of a movement by its letter in a phase: red without one.
fn state_of(letters: &str, link: usize) -> PhaseState {
    match letters.as_bytes().get(link) {
        Some(b'G' | b'g') => PhaseState::ProtectedMovementAllowed,
        Some(b'y' | b'Y') => PhaseState::ProtectedClearance,
        // Off, or blinking: the junction's signs hold.
        Some(b'o' | b'O') => PhaseState::Unavailable,
        _ => PhaseState::StopAndRemain,
    }
}

/// A controller of lights as SUMO has it.
#[derive(Clone, Debug)]
pub struct State {
    pub controller: String,
    /// A letter for each movement.
    pub letters: String,
    /// Next switch, s of SUMO's time.
    pub next_s: f64,
    pub phase: usize,
    /// Time spent in the phase, s.
    pub spent_s: f64,
}

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
        let own = programs.parts().iter().find_map(|program| match program.parts() {
            [id, Value::Number(kind), _, phases, ..] if id.text() == present => {
                Some((*kind, phases))
            }
            _ => None,
        });
        let Some((kind, phases)) = own else { return Self::default() };
        let phase = |phase: &Value| {
            let [usual, letters, least, most, next, ..] = phase.parts() else { return None };
            let (usual_s, least_s, most_s) = (usual.number(), least.number(), most.number());
            let lasts_s = match kind == 0.0 {
                true => [usual_s; 3],
                false => [least_s.min(usual_s), usual_s, most_s.max(usual_s)],
            };
            let next = next.parts().first().map(|next| next.number() as usize);
            Some(Phase { letters: letters.text().to_owned(), lasts_s, next })
        };
        Self(phases.parts().iter().filter_map(phase).collect())
    }

    /// Phase of a movement in a state of `time_s` of the run, and what follows. SUMO's time is ahead by `ahead_s`.
    pub fn now(&self, state: &State, link: usize, time_s: f64, ahead_s: f64) -> Vec<Interval> {
        if link >= state.letters.len() {
            return Vec::new();
        }
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
        let mut intervals = vec![(state_of(&state.letters, link), ends_s)];
        let mut index = state.phase;
        for _ in 0..4 * self.0.len() {
            index = self.0[index.min(self.0.len() - 1)].next.unwrap_or(index + 1) % self.0.len();
            let phase = &self.0[index];
            let last = intervals.len() - 1;
            let (before, begin_s) = intervals[last];
            let ends_s = [0, 1, 2].map(|which| begin_s[which] + phase.lasts_s[which]);
            let shown = state_of(&phase.letters, link);
            if shown == before {
                intervals[last].1 = ends_s;
            } else if intervals.len() == MAX_INTERVALS {
                break;
            } else {
                intervals.push((shown, ends_s));
            }
        }
        if intervals.len() == 1 {
            // It never changes.
            intervals[0].1 = [f64::INFINITY; 3];
        } else if intervals.len() < MAX_INTERVALS {
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
        let ends: Vec<_> = now.iter().map(|(state, ends_s)| (*state, ends_s[1])).collect();
        let expected = [
            (PhaseState::ProtectedMovementAllowed, 25.0),
            (PhaseState::ProtectedClearance, 28.0),
            (PhaseState::StopAndRemain, 51.0),
        ];
        assert_eq!(ends[..3], expected);
        assert!(now.iter().all(|(_, ends_s)| ends_s[0] == ends_s[2]));
        let other = plan.now(&state("Gr", 0, 10.0, 125.0), 1, 5.0, 100.0);
        assert_eq!((other[0].0, other[0].1[0]), (PhaseState::StopAndRemain, 28.0));
    }

    #[test]
    fn an_actuated_green_ends_between_its_bounds() {
        let plan = Plan(vec![
            phase("Gr", [5.0, 40.0, 50.0]),
            phase("yr", [3.0; 3]),
            phase("rG", [5.0, 20.0, 30.0]),
        ]);
        let now = plan.now(&state("Gr", 0, 10.0, 12.0), 0, 11.0, 0.0);
        assert_eq!(now[0].1, [11.0, 12.0, 51.0]);
        assert_eq!(now[1].1, [14.0, 15.0, 54.0]);
        assert_ne!(now[1].1[0], now[1].1[2]);
    }

    #[test]
    fn a_light_that_never_changes_has_no_end() {
        let plan = Plan(vec![phase("G", [30.0; 3]), phase("g", [3.0; 3])]);
        let now = plan.now(&state("G", 0, 0.0, 30.0), 0, 0.0, 0.0);
        assert_eq!(now.len(), 1);
        assert!(now[0].1[0].is_infinite());
        assert_eq!(plan.now(&state("o", 0, 0.0, 30.0), 0, 0.0, 0.0)[0].0, PhaseState::Unavailable);
    }
}
