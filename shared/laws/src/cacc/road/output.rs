//! The output of a cycle: the chosen plan, and its first request as the filter lets it through.

use super::decision::Choice;
use super::filter::{Filter, Gate, Pass, SOFT_SHARE};
use super::planner::Seen;
use super::{Decision, MAX_PLAN_AGE_S, RoadLaw, WAITS_WITHIN_M};
use crate::cacc::plan::PlanMemory;
use law::following::kinematics::Lag;
use law::following::soft_stop::{Room, soften, within_set_speed};
use law::{Input, MAX_SIGNALS, Output, Quality};

/// Below this speed a vehicle at a closed line waits, m/s.
const STANDSTILL_MPS: f64 = 0.1;
/// Room that a soft stop leaves to a closed line, m.
const LINE_ROOM_M: f64 = 0.3;

impl RoadLaw {
    /// Writes the chosen plan, the previous one or the driver's, and filters its first request.
    /// Returns whether the nearest line is to be stopped at as things stand.
    pub(super) fn write(
        &mut self,
        input: &Input,
        seen: &Seen,
        decision: &Decision,
        filter: &Filter,
        output: &mut Output,
    ) -> bool {
        let choice = decision.choice;
        let taken = choice.unwrap_or(Choice::Pass);
        let n = self.config.horizon;
        let candidate = self.planner.candidate_of(taken);
        output.solver_iterations = candidate.iterations;
        output.figures[3] = candidate.residual;
        let plan = &mut self.state.plan;
        if candidate.solved {
            plan.store(&candidate.requests[..n], input.time_s, self.config.step_s);
            self.state.planned = choice;
            output.quality = if decision.shortfall_m > 0.0 && taken == Choice::Pass {
                Quality::Relaxed
            } else {
                Quality::Full
            };
        } else {
            output.quality = Quality::Backup;
        }
        let same = self.state.planned == choice;
        let written = (candidate.solved || same)
            && plan.write(input.time_s, input.period_s, MAX_PLAN_AGE_S, output);
        if !written {
            let mut driver = PlanMemory::default();
            driver.store(&candidate.requests[..n], input.time_s, self.config.step_s);
            driver.write(input.time_s, input.period_s, 0.0, output);
        }
        let (min, max) = (self.config.min_request_mps2, self.config.road.acceleration_mps2);
        for request in &mut output.plan_mps2[..output.plan_len] {
            *request = request.clamp(min, max);
        }
        let wanted = output.request_mps2();
        let (gates, count) = self.gates(input, seen, choice, filter);
        // Nothing calls for more than the comfort bound. Where more is needed, exactly that is asked for: less now would
        // take more at the end.
        let comfort = -self.config.road.comfort_deceleration_mps2;
        let enough = filter.enough_mps2(seen.ego, seen.lead.as_ref(), &gates[..count]);
        let needed = if enough < comfort { wanted.min(enough) } else { wanted };
        let tempered = needed.max(filter.hardest_mps2(enough, seen.begin));
        let mut safe = filter.apply(tempered, seen.ego, seen.lead.as_ref(), &gates[..count]);
        let stop = gates[..count].first().filter(|gate| gate.pass.is_none());
        let line_m = stop.map_or(f64::INFINITY, |gate| gate.distance_m);
        if line_m < WAITS_WITHIN_M && seen.ego.speed_mps < STANDSTILL_MPS {
            // It waits at the line.
            safe = safe.min(0.0);
        }
        safe = within_set_speed(safe, seen.desired_mps);
        let spare_m = SOFT_SHARE * self.config.road.min_gap_m;
        let soft_gap_m = self.config.road.min_gap_m + spare_m;
        let lead_m = seen.lead.map_or(f64::INFINITY, |lead| lead.room_m(soft_gap_m));
        let to_line_m = line_m - LINE_ROOM_M;
        let room = if lead_m < to_line_m {
            Room { wanted_m: lead_m, spare_m }
        } else {
            Room { wanted_m: to_line_m, spare_m: 0.0 }
        };
        safe = soften(safe, seen.ego, self.config.model_time_constant_s, room);
        output.figures[2] = safe - wanted;
        if safe < wanted - 1e-9 {
            // The rest of the plan was made for another beginning: it must not undo the braking.
            for request in &mut output.plan_mps2[1..output.plan_len] {
                *request = request.min(safe.max(-self.config.road.comfort_deceleration_mps2));
            }
        }
        output.plan_mps2[0] = safe;
        let lag = Lag { tau_s: self.config.model_time_constant_s };
        self.state.own.ask(safe, seen.ego.acceleration_mps2, lag, input.period_s);
        stop.is_some()
    }

    /// The rules of the filter for all lines ahead.
    fn gates(
        &self,
        input: &Input,
        seen: &Seen,
        choice: Option<Choice>,
        filter: &Filter,
    ) -> ([Gate; MAX_SIGNALS], usize) {
        let now = input.time_s;
        let n = self.config.horizon;
        let mut gates = [Gate { distance_m: 0.0, pass: None }; MAX_SIGNALS];
        for (j, line) in seen.signals.lines().iter().enumerate() {
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
            let pass = open
                .filter(|_| passes)
                .map(|green| Pass { red_in_s: green.clear_s - now, most_mps: seen.desired_mps });
            gates[j] = Gate { distance_m, pass };
        }
        (gates, seen.signals.lines().len())
    }
}
