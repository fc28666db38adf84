//! What a person reads after a run.

use crate::chart::number;
use crate::summary::{Summary, Timing};
use crate::trip::Trip;
use group::{Error, RecordingSummary, Recovery};
use messages::level::Level;
use runtime::report::{Outcome, ProgramReport, WorstChain};
use runtime::statistics::Percentiles;
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};

/// Writes text on standard output. A closed pipe is not an error: its reader has read enough.
///
/// # Errors
/// [`Error::Path`] if standard output cannot be written.
pub fn out(text: &str) -> Result<(), Error> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|reason| Error::Path {
            action: "write",
            path: "standard output".into(),
            reason,
        }),
    }
}

/// Writes a line on standard error. One that is gone, with its terminal, is not an error.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// The run in ten seconds' reading.
pub fn summary(summary: &Summary) -> String {
    let mut text = String::new();
    let mut line = |label: &str, value: String| {
        writeln!(text, "  {label:<14} {value}").expect("a string takes all");
    };
    line("outcome", outcome(summary));
    program(summary, &mut line);
    drive(summary, &mut line);
    emergency_brake(summary, &mut line);
    radar(summary, &mut line);
    timing(summary, &mut line);
    messages(summary, &mut line);
    faults(summary, &mut line);
    machine(summary, &mut line);
    if let Some(recording) = &summary.recording {
        line("recording", self::recording(recording));
    }
    format!(
        "{} · {} · {} · seed {}\n{text}",
        summary.scenario,
        summary.driver(),
        summary.mode,
        summary.seed
    )
}

/// The programs of the user's, and how that of a foreign law fared.
fn program(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for service in &summary.services {
        let Some(program) = &service.program else { continue };
        let fared = match (&summary.timing.law_program, service.name) {
            (Some(report), "controller") => format!(", {}", fared(report)),
            _ => String::new(),
        };
        let (name, command) = (service.name, &program.command);
        line("program", format!("{name}: {command} (sha256 {}...){fared}", program.short_digest()));
    }
    for failure in summary.timing.law_program.iter().flat_map(|report| &report.failures) {
        line("", failure.clone());
    }
}

/// How a foreign law's program fared, in a line.
pub fn fared(report: &ProgramReport) -> String {
    let mut parts = vec![format!("{} answers", report.answers)];
    for (count, what) in
        [(report.late, "late"), (report.refused, "refused"), (report.absent, "without a program")]
    {
        if count > 0 {
            parts.push(format!("{count} {what}"));
        }
    }
    if report.starts > 1 {
        parts.push(format!("started {} times", report.starts));
    }
    if report.given_up {
        parts.push("GIVEN UP: the backup drove on".into());
    }
    parts.join(", ")
}

/// How a run ended, in a line.
pub fn outcome(summary: &Summary) -> String {
    let word = outcome_word(summary.outcome);
    let because =
        summary.aborted_because.as_ref().map_or_else(String::new, |why| format!(" ({why})"));
    let speed = match summary.simulated_per_wall {
        Some(ratio) if summary.mode == "lockstep" => format!(", {ratio:.0} simulated s per s"),
        _ => String::new(),
    };
    format!(
        "{word}{because}, {:.1} s driven in {:.2} s of wall time (ready after {:.0} ms{speed})",
        summary.duration_s, summary.wall_s, summary.ready_ms
    )
}

/// An outcome in a word.
pub fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Completed => "completed",
        Outcome::Collision => "COLLISION",
        Outcome::RedLight => "RED LIGHT",
        Outcome::SafeStop => "safe stop",
        Outcome::Aborted => "aborted",
    }
}

fn recording(recording: &RecordingSummary) -> String {
    let lost = match recording.lost {
        Some(lost) => format!("{lost} lost"),
        None => "losses not counted".into(),
    };
    let failed =
        recording.failed.as_ref().map_or_else(String::new, |why| format!("; ENDS EARLY: {why}"));
    let mib = recording.bytes as f64 / f64::from(1 << 20);
    format!("{} messages, {lost}, {mib:.2} MiB{failed}", recording.messages)
}

fn drive(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let control = &summary.control.figures;
    if let Some(crossed) = control.stop_line_crossing_s {
        let past = control.past_stop_line_at_switch_m.map_or_else(String::new, |past| {
            format!(", {past:.1} m past it when the light changed")
        });
        line("stop line", format!("crossed at {crossed:.2} s{past}"));
    } else if let Some(past) = control.past_stop_line_at_switch_m {
        line("stop line", format!("{:.1} m before it when the light changed", -past));
    }
    if let Some(trip) = trip(&summary.control.trip) {
        line("trip", trip);
    }
    if let Some(gap) = control.min_gap_m {
        let ttc = control
            .min_ttc_s
            .map_or_else(String::new, |ttc| format!(", time to collision at least {ttc:.1} s"));
        let end = control.final_gap_error_m.map_or_else(String::new, |error| {
            format!(", off the desired one by {} m at the end", number(error, 2))
        });
        line("gap", format!("{}{end}{ttc}", smallest_gap(summary.outcome, gap)));
    }
    let following = &summary.control.following;
    if let (Some(least), Some(median)) = (following.min_time_gap_s, following.median_time_gap_s) {
        let (least, median) = (number(least, 2), number(median, 2));
        line("time gap", format!("at least {least} s, median {median} s"));
    }
    if let (Some(low), Some(high)) = (control.min_accel_mps2, control.max_accel_mps2) {
        let jerk = control
            .max_abs_jerk_mps3
            .map_or_else(String::new, |jerk| format!(", jerk at most {jerk:.1} m/s³"));
        let (low, high) = (number(low, 2), number(high, 2));
        line("acceleration", format!("{low} to {high} m/s²{jerk}"));
    }
    if let Some(energy) = control.wheel_energy_kwh_per_100km {
        let stops = match control.stops {
            Some(1) => ", 1 stop".to_owned(),
            Some(stops) => format!(", {stops} stops"),
            None => String::new(),
        };
        line("energy", format!("{} kWh/100 km at the wheels{stops}", number(energy, 2)));
    }
    if let Some(fuel) = control.fuel_l_per_100km {
        let shifts = control
            .gear_shifts
            .map_or_else(String::new, |shifts| format!(", {shifts} gear shifts"));
        let braked = match control.service_brake_s {
            Some(time_s) if time_s > 0.0 => format!(", service brakes for {time_s:.1} s"),
            _ => ", no service brake".into(),
        };
        line("fuel", format!("{fuel:.2} L/100 km{shifts}{braked}"));
    }
    if let Some(changes) = &summary.control.mode_changes
        && !changes.is_empty()
    {
        let shown: Vec<_> =
            changes.iter().take(8).map(|c| format!("{} at {:.1} s", c.to, c.t_s)).collect();
        let more = changes.len().saturating_sub(8);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        line("modes", shown.join(", ") + &more);
    }
}

/// The way through the signals in words; one that did not pass them all has only the bound.
pub fn trip(trip: &Trip) -> Option<String> {
    let fastest_s = trip.fastest_legal_trip_s?;
    Some(match trip.trip_time_s {
        Some(time_s) => format!(
            "past the last stop line after {time_s:.1} s, {} s more than the fastest legal trip",
            number(time_s - fastest_s, 1)
        ),
        None => {
            format!("not past the last stop line; the fastest legal trip takes {fastest_s:.1} s")
        }
    })
}

fn emergency_brake(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let aebs = &summary.aebs;
    let (Some(warnings), Some(interventions), Some(braking_s)) =
        (aebs.warnings, aebs.interventions, aebs.braking_s)
    else {
        return;
    };
    let braked = match interventions {
        0 => "never braked".to_owned(),
        1 => format!("braked once, {braking_s:.1} s"),
        n => format!("braked {n} times, {braking_s:.1} s in all"),
    };
    let blind = match aebs.unavailable_s {
        Some(time_s) if time_s > 0.0 => format!(", not available for {time_s:.1} s"),
        _ => String::new(),
    };
    line("emergency", format!("{braked}, {warnings} warnings{blind}"));
}

/// How well the tracks of a radar that errs matched the traffic.
fn radar(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let Some(perception) = summary.perception.filter(|perception| perception.gospa_m > 0.0) else {
        return;
    };
    let mut parts = vec![format!(
        "GOSPA {:.2} m (localisation {:.2}, missed {:.2}, false {:.2})",
        perception.gospa_m, perception.localisation_m, perception.missed_m, perception.false_m
    )];
    if let (Some(mean_s), Some(worst_s)) = (perception.cut_in_mean_s, perception.cut_in_worst_s) {
        parts.push(format!("cut-in confirmed {mean_s:+.2} s after overlap, worst {worst_s:+.2}"));
    }
    if perception.cut_ins_unconfirmed > 0 {
        parts.push(format!("{} cut-ins not confirmed", perception.cut_ins_unconfirmed));
    }
    if perception.false_targets > 0 {
        let (count, time_s) = (perception.false_targets, perception.false_target_s);
        parts.push(format!("{count} false targets, {time_s:.2} s"));
    }
    let left_out = perception.detections_left_out.unwrap_or(0) + perception.tracks_left_out;
    if left_out > 0 {
        parts.push(format!("{left_out} detections and tracks found no room in their messages"));
    }
    line("radar", parts.join(", "));
}

/// The smallest gap in words; bodies that touch have none.
fn smallest_gap(outcome: Outcome, gap_m: f64) -> String {
    if outcome == Outcome::Collision && gap_m <= 0.0 {
        return "none left at the collision".into();
    }
    format!("at least {} m", number(gap_m, 1))
}

fn timing(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let timing = &summary.timing;
    if let Some(solve) = timing.solve_us {
        line("law", percentiles(&solve));
    }
    if let (Some(cycles), Some(relaxed), Some(backup)) =
        (timing.cycles, timing.relaxed_cycles, timing.backup_cycles)
        && relaxed + backup > 0
    {
        line("", format!("{relaxed} of {cycles} commands relaxed, {backup} from the backup law"));
    }
    if let Some(planning) = &timing.planning {
        let took = planning.plan_us.map_or_else(|| "none came".into(), |took| percentiles(&took));
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
        line("", format!("without its designed waits {}", percentiles(&net)));
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

/// The three deadlines of one length, each with what missed it: the control cycle's own, the command's at
/// the plant, the whole way from the radar to the actuators.
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
            "; the plant missed more than the controller says"
        }
        _ => "",
    };
    (!parts.is_empty()).then(|| format!("{deadline}, missed: {}{disagree}", parts.join(", ")))
}

/// The longest chain in one line: where its undesigned time went, and what its control cycle met.
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
        "longest {} at {:.2} s: {name} {}; {} context switches, {} page faults, {} iterations",
        duration(chain.reaction_time_us),
        chain.t_s,
        duration(us),
        chain.voluntary_switches + chain.involuntary_switches,
        chain.minor_faults + chain.major_faults,
        chain.solver_iterations,
    )
}

fn messages(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let sent: u64 = summary.messages.values().map(|topic| topic.sent).sum();
    let lost: u64 = summary.messages.values().filter_map(|topic| topic.lost).sum();
    if sent > 0 {
        line("messages", format!("{sent} sent on {} topics, {lost} lost", summary.messages.len()));
    }
}

/// Most faults that are told one by one.
const SHOWN_FAULTS: usize = 8;

fn faults(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for (index, fault) in summary.faults.iter().take(SHOWN_FAULTS).enumerate() {
        let victim = fault.service.map(|service| service.name()).or(fault.topic).unwrap_or("");
        let mut text = format!("{} {victim} at {:.2} s", fault.kind, fault.t_s);
        for (what, us) in
            [("detected", fault.detected_after_us), ("back", fault.recovered_after_us)]
        {
            if let Some(us) = us {
                write!(text, ", {what} after {}", duration(us)).expect("a string takes all");
            }
        }
        if fault.recovered_by == Some(Recovery::TakeOver) {
            text.push_str(" by take-over");
        }
        if let Some(messages) = fault.messages {
            write!(text, ", {messages} messages").expect("a string takes all");
        }
        line(if index == 0 { "faults" } else { "" }, text);
    }
    if summary.faults.len() > SHOWN_FAULTS {
        line("", format!("and {} more", summary.faults.len() - SHOWN_FAULTS));
    }
    let rungs: Vec<String> = (summary.rungs.iter())
        .flat_map(|(who, rungs)| rungs.time_s.iter().map(move |(rung, time_s)| (who, rung, time_s)))
        .filter(|(_, rung, _)| rung.as_str() != Level::Full.name())
        .map(|(who, rung, time_s)| format!("{who} {rung} {time_s:.2} s"))
        .collect();
    if !rungs.is_empty() {
        line("degraded", rungs.join(", "));
    }
    let refused: u64 = summary.messages.values().filter_map(|topic| topic.e2e_errors).sum();
    let unknown: u64 = summary.messages.values().map(|topic| topic.e2e.unknown_sender).sum();
    if refused > unknown {
        let refused = refused - unknown;
        line("refused", format!("{refused} messages, by the end-to-end check"));
    }
    for (topic, counts) in &summary.messages {
        if counts.e2e.unknown_sender > 0 {
            let count = counts.e2e.unknown_sender;
            line("refused", format!("{count} messages of an unknown sender on {topic}"));
        }
    }
}

/// How often something happened, behind what it is; nothing if it did not.
fn how_often(what: &str, count: u32) -> String {
    match count {
        0 => String::new(),
        1 => format!("{what} once"),
        n => format!("{what} {n} times"),
    }
}

fn machine(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    for service in &summary.services {
        let Some(granted) = &service.scheduling else { continue };
        let core = granted.core.map_or_else(|| "any core".into(), |core| format!("core {core}"));
        let locked = if granted.memory_locked { "memory locked" } else { "memory not locked" };
        let rss = service.peak_rss_kib.unwrap_or(0) as f64 / 1024.0;
        let took_over = service.take_overs.unwrap_or(0);
        let restarts = how_often(", restarted", service.restarts.saturating_sub(took_over))
            + &how_often(", taken over by its standby", took_over);
        let granted = &granted.granted;
        line(service.name, format!("{granted}, {core}, {locked}, {rss:.1} MiB{restarts}"));
    }
    for service in &summary.services {
        if let Some(cost) = &service.standby_cost {
            let (cpu, mib) = (cost.cpu_percent, cost.private_kib as f64 / 1024.0);
            let name = service.name;
            line("standby", format!("{name}: {cpu:.2} % of a core, {mib:.1} MiB of its own"));
        }
    }
    for service in &summary.services {
        let starved_ms = service.heartbeats.map_or(0.0, |heartbeats| heartbeats.starved_ms);
        if starved_ms > 0.0 {
            let starved = duration(starved_ms * 1e3);
            let name = service.name;
            line("starved", format!("{name}: by the machine, for {starved} without the processor"));
        }
    }
    if let Some(text) = refusals(summary) {
        line("not granted", text);
    }
}

/// What the machine refused, each reason once, and where the remedy is.
fn refusals(summary: &Summary) -> Option<String> {
    let granted = summary.services.iter().filter_map(|service| service.scheduling.as_ref());
    let mut refused: Vec<String> = Vec::new();
    for line in granted.flat_map(|granted| &granted.refused) {
        // Priorities differ from service to service; the reason does not.
        let line = match line.split_once(": ") {
            Some((what, why)) if what.starts_with("fifo") => format!("real-time priority: {why}"),
            _ => line.clone(),
        };
        if !refused.contains(&line) {
            refused.push(line);
        }
    }
    (!refused.is_empty())
        .then(|| format!("{} (`timegap doctor` shows how to get it)", refused.join("; ")))
}

fn percentiles(p: &Percentiles) -> String {
    format!(
        "p50 {}, p99 {}, max {} (n = {})",
        duration(p.p50),
        duration(p.p99),
        duration(p.max),
        p.count
    )
}

/// A duration in µs with the unit that reads best.
pub fn duration(us: f64) -> String {
    if us < 1e3 {
        format!("{us:.1} µs")
    } else if us < 1e6 {
        format!("{:.2} ms", us / 1e3)
    } else {
        format!("{:.2} s", us / 1e6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_never_a_negative_zero() {
        assert_eq!(smallest_gap(Outcome::Completed, -0.01), "at least 0.0 m");
        assert_eq!(smallest_gap(Outcome::Collision, -0.01), "none left at the collision");
        assert_eq!(smallest_gap(Outcome::Completed, 4.26), "at least 4.3 m");
    }

    #[test]
    fn durations_choose_their_unit() {
        assert_eq!(duration(12.34), "12.3 µs");
        assert_eq!(duration(1234.0), "1.23 ms");
        assert_eq!(duration(2_500_000.0), "2.50 s");
    }
}
