//! Console lines about time.

use crate::duration::{duration, percentiles};
use crate::summary::{Summary, Timing};
use group::report::WorstChain;

pub(super) fn timing(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let timing = &summary.timing;
    if let Some(solve) = timing.solve_us {
        line("law", percentiles(&solve));
    }
    let counts = [
        (timing.relaxed_cycles, "commands were relaxed"),
        (timing.backup_cycles, "commands came from the backup law, not from the law itself"),
    ];
    for (count, what) in counts {
        if let (Some(count @ 1..), Some(cycles)) = (count, timing.cycles) {
            line("", format!("{count} of {cycles} {what}"));
        }
    }
    if let Some(planning) = &timing.planning {
        let took = planning.plan_us.map_or_else(|| "no plan".into(), |took| percentiles(&took));
        line("planning", format!("{took}, {} of {} late", planning.late, planning.asked));
    }
    if summary.mode == "lockstep" {
        return;
    }
    if let Some(reaction) = timing.reaction_time_us {
        line("reaction time", percentiles(&reaction));
        let hops = &timing.hops_us;
        let parts = [
            ("radar to controller", hops.radar_to_controller),
            ("compute", hops.controller_compute),
            ("controller to plant", hops.controller_to_plant),
        ];
        let parts: Vec<_> = parts
            .iter()
            .filter_map(|(name, p)| p.map(|p| format!("{name} {}", duration(p.p50))))
            .collect();
        line("", format!("medians of its parts: {}", parts.join(", ")));
    }
    if let Some(net) = timing.net_reaction_us {
        line(
            "",
            format!("software overhead {}, without radar latency and waits", percentiles(&net)),
        );
    }
    if let Some(worst) = timing.worst_chains.first() {
        line("", longest(worst));
    }
    if let Some(text) = deadlines(timing) {
        line("deadline", text);
    }
    if let Some(undelivered) = timing.undelivered_commands.filter(|count| *count > 0) {
        line("undelivered", format!("{undelivered} commands never reached the actuators"));
    }
}

/// Misses of the three deadlines of equal length. They are the control cycle, the command at the plant, and the whole
/// chain from the radar to the actuators.
fn deadlines(timing: &Timing) -> Option<String> {
    let cycle = timing.deadline_misses.zip(timing.cycles);
    let plant = timing.missed_at_plant.zip(timing.due_at_plant);
    let whole = timing.late_reactions.zip(timing.reaction_time_us.map(|p| p.count));
    let parts: Vec<String> =
        [("control cycle", cycle), ("command late at the plant", plant), ("end to end", whole)]
            .into_iter()
            .filter_map(|(name, counts)| {
                counts.map(|(missed, all)| format!("{name} {missed} of {all}"))
            })
            .collect();
    let deadline = duration(timing.deadline_us?);
    let disagree = match (timing.deadline_misses, timing.missed_at_plant) {
        (Some(own), Some(at_plant)) if own < at_plant => {
            "; the plant counted more than the controller"
        }
        _ => "",
    };
    (!parts.is_empty()).then(|| format!("{deadline}, missed: {}{disagree}", parts.join(", ")))
}

/// The longest chain in one line: its largest avoidable part, and the events of its control cycle.
fn longest(chain: &WorstChain) -> String {
    let hops = &chain.hops_us;
    let parts = [
        ("radar publish", hops.radar_publish),
        ("controller queue", hops.controller_queue),
        ("radar transport", hops.radar_transport),
        ("compute", hops.controller_compute),
        ("command transport", hops.command_transport),
        ("actuate", hops.actuate),
    ];
    let (name, us) = parts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("six parts");
    format!(
        "longest {} at {:.2} s: {name} {}; context switches {}, page faults {}, iterations {}",
        duration(chain.reaction_time_us),
        chain.t_s,
        duration(us),
        chain.voluntary_switches + chain.involuntary_switches,
        chain.minor_faults + chain.major_faults,
        chain.solver_iterations,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_deadline_is_named_and_counted() {
        let timing = Timing {
            deadline_us: Some(100_000.0),
            deadline_misses: Some(1),
            cycles: Some(600),
            missed_at_plant: Some(3),
            due_at_plant: Some(599),
            ..Timing::default()
        };
        let said = deadlines(&timing).expect("there is a deadline");
        let counts = "control cycle 1 of 600, command late at the plant 3 of 599;";
        assert!(said.starts_with("100.00 ms, missed: ") && said.contains(counts), "{said}");
    }
}
