//! What timegap promises in terms of the machine's own floor, checked in the same run.

use super::plan::{CONTROLLER_PERIODS_US, Conditions, Load, Placement, Scheduling};
use super::results::Report;
use serde::{Deserialize, Serialize};

/// A figure over the one that it is compared with.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Goal {
    pub goal: String,
    pub placement: Placement,
    pub ours: f64,
    pub floor: f64,
    /// Largest factor between them.
    pub limit: f64,
    pub ok: bool,
}

impl Goal {
    fn new(goal: &str, placement: Placement, ours: f64, floor: f64, limit: f64) -> Self {
        Self { goal: goal.into(), placement, ours, floor, limit, ok: ours <= limit * floor }
    }
}

/// All goals whose figures are there.
pub fn check(report: &Report) -> Vec<Goal> {
    let mut goals = Vec::new();
    for placement in [Placement::SameCore, Placement::TwoCores] {
        let under = |load| Conditions { placement, scheduling: Scheduling::Fifo, load };
        let idle = report.message(under(Load::Idle));
        if let (Some(ours), Some(floor)) = (idle, report.floor.futex_us.of(placement)) {
            goals.push(Goal::new("transport over futex, p50", placement, ours.p50, floor.p50, 1.5));
            goals.push(Goal::new("transport over futex, p99", placement, ours.p99, floor.p99, 2.0));
        }
        for load in [Load::Cpu, Load::Memory] {
            if let (Some(idle), Some(loaded)) = (idle, report.message(under(load))) {
                let goal = format!("transport under {} load over idle, p99", load.name());
                goals.push(Goal::new(&goal, placement, loaded.p99, idle.p99, 2.0));
            }
            for period_us in CONTROLLER_PERIODS_US {
                let net = |load| report.chain(under(load), period_us)?.net_reaction_us;
                if let (Some(idle), Some(loaded)) = (net(Load::Idle), net(load)) {
                    let (load, period_ms) = (load.name(), period_us / 1000);
                    let goal =
                        format!("net reaction under {load} load over idle at {period_ms} ms, p99");
                    goals.push(Goal::new(&goal, placement, loaded.p99, idle.p99, 2.0));
                }
            }
        }
        for row in report.chain.iter().filter(|row| row.conditions == under(Load::Idle)) {
            if let (Some(net), Some(floor)) = (row.net_reaction_us, row.floor_sum_us) {
                let goal = format!(
                    "net reaction over the sum of its floors at {} ms, p50",
                    row.period_us / 1000
                );
                goals.push(Goal::new(&goal, placement, net.p50, floor, 2.0));
            }
        }
        for row in &report.deadlines {
            if row.conditions == under(Load::Idle)
                && row.period_us == 1_000
                && let (Some(ours), Some(floor)) =
                    (row.misses_per_million, row.floor_misses_per_million)
            {
                goals.push(Goal::new("misses per million at 1 ms", placement, ours, floor, 1.0));
            }
        }
    }
    goals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_is_met_up_to_its_limit() {
        let goal = |ours| Goal::new("transport", Placement::SameCore, ours, 10.0, 1.5).ok;
        assert!(goal(15.0) && !goal(15.1));
        assert!(Goal::new("misses", Placement::SameCore, 0.0, 0.0, 1.0).ok, "nothing of nothing");
    }
}
