//! Input of the filter about the lines ahead.

use super::RoadLaw;
use super::decision::Choice;
use super::filter::{Filter, Gate, Rule};
use super::planner::Seen;
use crate::law::{Input, MAX_SIGNALS};

impl RoadLaw {
    /// The rules of the filter for all lines ahead.
    pub(super) fn gates(
        &self,
        input: &Input,
        seen: &Seen,
        choice: Option<Choice>,
        filter: &Filter,
    ) -> ([Gate; MAX_SIGNALS], usize) {
        let now = input.time_s;
        let n = self.config.horizon_steps;
        let mut gates = [Gate { distance_m: 0.0, rule: Rule::Stop }; MAX_SIGNALS];
        for (j, line) in seen.lines[..seen.count].iter().enumerate() {
            let distance_m = line.at_m - input.ego.position_m;
            let open = line.shown(now);
            let passes = match (j, open) {
                (_, None) => false,
                // Beyond the point of no return a stop is no longer a choice.
                (0, Some(_)) => {
                    choice == Some(Choice::Pass) || !filter.can_stop(seen.ego, distance_m)
                }
                (_, Some(green)) => {
                    let reference =
                        &self.planner.candidate_of(choice.unwrap_or(Choice::Pass)).reference;
                    line.known
                        && reference.reaches(distance_m, n).is_some_and(|k| {
                            now + k as f64 * self.planner.lag.step_s <= green.likely_s
                        })
                }
            };
            let rule = match open {
                Some(green) if passes => {
                    Rule::Pass { red_in_s: green.clear_s - now, most_mps: seen.desired_mps }
                }
                _ => Rule::Stop,
            };
            gates[j] = Gate { distance_m, rule };
        }
        (gates, seen.count)
    }
}
