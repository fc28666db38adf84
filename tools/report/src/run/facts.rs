//! A run in lines of a name and a value.

use crate::print::duration;
use crate::results::Fact;
use crate::summary::{Summary, Timing, TopicCounts};
use messages::Service;
use messages::level::Level;
use std::collections::BTreeMap;
use supervise::RecordingSummary;
use supervise::report::{ClockComparison, ProgramReport, StationReport};

/// Most changes of mode that are listed.
const MOST_CHANGES: usize = 8;
const MOST_ACTS: usize = 5;

/// What drove, the figures of the drive, and all that was not as it should be.
pub fn of(summary: &Summary) -> Vec<Fact> {
    let mut facts = vec![("driven".to_owned(), driven(summary))];
    let mut add = |name: &str, value: String| facts.push((name.to_owned(), value));
    programs(summary, &mut add);
    for (figure, value) in super::shown(summary) {
        add(figure.heading, value);
    }
    if summary.control.trip.energy_is_comparable == Some(false) {
        add("energy", "not comparable: a trip too short for its change of speed".into());
    }
    if let Some(text) = mode_changes(summary) {
        add("modes", text);
    }
    if let Some(text) = storyboard(summary) {
        add("storyboard", text);
    }
    if let Some(law) = summary.law.as_ref().filter(|law| law.backup > 0) {
        add("backup", law.to_string());
    }
    let timing = &summary.timing;
    if let (Some(relaxed @ 1..), Some(cycles)) = (timing.relaxed_cycles, timing.cycles) {
        add("relaxed", format!("{relaxed} of {cycles} commands"));
    }
    if let Some(planning) = &timing.planning {
        add("late plans", format!("{} of {}", planning.late, planning.asked));
    }
    if let Some(text) = deadlines(timing).filter(|_| summary.mode == "realtime") {
        add("deadline", text);
    }
    messages(&summary.messages, &mut add);
    degraded(summary, &mut add);
    if let Some(text) = refusals(summary) {
        add("not granted", text);
    }
    let host = &summary.host;
    let kind = if host.realtime_kernel { "real-time kernel" } else { "not a real-time kernel" };
    add("machine", format!("{} processors, Linux {}, {kind}", host.cpus, host.kernel));
    if let Some(recorded) = &summary.recording {
        add("recording", recording(recorded));
    }
    facts
}

/// Length of the run and its cost.
pub fn driven(summary: &Summary) -> String {
    let speed = match summary.simulated_per_wall {
        Some(ratio) if summary.mode == "lockstep" => format!(", {ratio:.0} simulated s per s"),
        _ => String::new(),
    };
    format!(
        "{:.1} s in {:.2} s of wall time (ready after {:.0} ms{speed})",
        summary.duration_s, summary.wall_s, summary.ready_ms
    )
}

/// The user's programs, and the performance of a foreign law's program.
fn programs(summary: &Summary, add: &mut dyn FnMut(&str, String)) {
    let report = summary.timing.law_program.as_ref();
    for service in &summary.services {
        let Some(program) = &service.program else { continue };
        let of_law = report.filter(|_| service.name == Service::Controller.name());
        let fared = of_law.map_or_else(String::new, |report| format!(", {}", fared(report)));
        let (name, command) = (service.name, &program.command);
        add("program", format!("{name}: {command} (sha256 {}...){fared}", program.short_digest()));
    }
    for failure in report.iter().flat_map(|report| &report.failures) {
        add("", failure.clone());
    }
}

/// Performance of a foreign law's program, in a line.
fn fared(report: &ProgramReport) -> String {
    let counts =
        [(report.late, "late"), (report.refused, "refused"), (report.absent, "without a program")];
    let counts = counts.into_iter().filter(|(count, _)| *count > 0);
    let mut parts = vec![format!("{} answers", report.answers)];
    parts.extend(counts.map(|(count, what)| format!("{count} {what}")));
    if report.starts > 1 {
        parts.push(format!("started {} times", report.starts));
    }
    if report.given_up {
        parts.push("GIVEN UP: the backup law drove the rest".into());
    }
    parts.join(", ")
}

fn mode_changes(summary: &Summary) -> Option<String> {
    let changes = summary.control.mode_changes.as_ref().filter(|changes| !changes.is_empty())?;
    let shown = changes.iter().take(MOST_CHANGES).map(|c| format!("{} at {:.1} s", c.to, c.t_s));
    let more = match changes.len().saturating_sub(MOST_CHANGES) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    Some(shown.collect::<Vec<_>>().join(", ") + &more)
}

/// Remarks on the storyboard: where they stand, the drive was not the one of the file.
fn storyboard(summary: &Summary) -> Option<String> {
    let perception = summary.perception.as_ref()?;
    let end = perception.road_ended.then(|| "ended where the ego's road ends".to_owned());
    let remarks: Vec<String> =
        end.into_iter().chain(unstarted_acts(&perception.unstarted_acts)).collect();
    (!remarks.is_empty()).then(|| remarks.join(", "))
}

pub(super) fn unstarted_acts(acts: &[String]) -> Option<String> {
    let named: Vec<String> = acts.iter().take(MOST_ACTS).map(|act| format!("`{act}`")).collect();
    let more = acts.len() - named.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let what = if acts.len() == 1 { "act" } else { "acts" };
    (!acts.is_empty()).then(|| format!("no event of {what} {}{more} started", named.join(", ")))
}

/// Misses of the three deadlines of equal length. They are the control cycle, the command at the plant, and the whole
/// chain from the radar to the actuators.
fn deadlines(timing: &Timing) -> Option<String> {
    let cycle = timing.deadline_misses.zip(timing.cycles);
    let plant = timing.missed_at_plant.zip(timing.due_at_plant);
    let whole = timing.late_reactions.zip(timing.reaction_time_us.map(|p| p.count));
    let all =
        [("control cycle", cycle), ("command late at the plant", plant), ("end to end", whole)];
    let parts = all.into_iter().filter_map(|(name, counts)| {
        counts.map(|(missed, all)| format!("{name} {missed} of {all}"))
    });
    let parts: Vec<String> = parts.collect();
    let deadline = duration(timing.deadline_us?);
    let disagree = match (timing.deadline_misses, timing.missed_at_plant) {
        (Some(own), Some(at_plant)) if own < at_plant => {
            "; the plant counted more than the controller"
        }
        _ => "",
    };
    (!parts.is_empty()).then(|| format!("{deadline}, missed: {}{disagree}", parts.join(", ")))
}

/// Messages that were lost or refused, by reader and topic. A late reader finds the oldest ones overwritten.
fn messages(topics: &BTreeMap<String, TopicCounts>, add: &mut dyn FnMut(&str, String)) {
    let sum = |of: &dyn Fn(&TopicCounts) -> u64| topics.values().map(of).sum::<u64>();
    let (sent, lost) = (sum(&|topic| topic.sent), sum(&|topic| topic.lost.unwrap_or(0)));
    if sent > 0 {
        add("messages", format!("{sent} sent on {} topics, {lost} lost", topics.len()));
    }
    for (topic, counts) in topics {
        for (reader, lost) in &counts.lost_by {
            let of = counts.sent;
            add(
                "",
                format!("{reader} read {topic} too late: its queue was full, {lost} of {of} lost"),
            );
        }
    }
    let unknown = sum(&|topic| topic.e2e.unknown_sender);
    let refused = sum(&|topic| topic.e2e_errors.unwrap_or(0)).saturating_sub(unknown);
    if refused > 0 {
        add("refused", format!("{refused} messages, by the end-to-end check"));
    }
    let ahead = sum(&|topic| topic.e2e.from_the_future);
    if ahead > 0 {
        add(
            "clocks",
            format!("{ahead} messages of a clock that is ahead, their stamps moved back"),
        );
    }
    for (topic, counts) in topics.iter().filter(|(_, counts)| counts.e2e.unknown_sender > 0) {
        let count = counts.e2e.unknown_sender;
        add("refused", format!("{count} messages of an unknown sender on {topic}"));
    }
}

/// Time on the degradation levels below the full one.
fn degraded(summary: &Summary, add: &mut dyn FnMut(&str, String)) {
    let levels = summary.rungs.iter().flat_map(|(who, levels)| {
        levels.time_s.iter().map(move |(level, time_s)| (who, level, time_s))
    });
    let below = levels.filter(|(_, level, _)| level.as_str() != Level::Full.name());
    let words: Vec<_> =
        below.map(|(who, level, time_s)| format!("{who} {level} {time_s:.2} s")).collect();
    if !words.is_empty() {
        add("degraded", words.join(", "));
    }
}

/// Requests that the machine refused, each reason once, with the command that shows the remedy.
fn refusals(summary: &Summary) -> Option<String> {
    let granted = summary.services.iter().filter_map(|service| service.scheduling.as_ref());
    let mut refused: Vec<String> = Vec::new();
    for refusal in granted.flat_map(|granted| &granted.refused) {
        // Priorities differ between services; the reason does not.
        let line = match refusal.strip_prefix("fifo:").and_then(|rest| rest.split_once(": ")) {
            Some((_, why)) => format!("real-time priority: {why}"),
            None => refusal.clone(),
        };
        if !refused.contains(&line) {
            refused.push(line);
        }
    }
    (!refused.is_empty())
        .then(|| format!("{} (`timegap doctor` shows the remedy)", refused.join("; ")))
}

fn recording(recording: &RecordingSummary) -> String {
    let lost = match recording.lost {
        Some(0) => "0 lost".into(),
        Some(lost) if recording.failed.is_some() => format!("{lost} lost"),
        Some(lost) => format!("{lost} lost (the recorder read too late)"),
        None => "losses not counted".into(),
    };
    let failed =
        recording.failed.as_ref().map_or_else(String::new, |why| format!("; ENDS EARLY: {why}"));
    let mib = recording.bytes as f64 / f64::from(1 << 20);
    format!("{} messages, {lost}, {mib:.2} MiB{failed}", recording.messages)
}

/// Match of the radar's tracks with the traffic; empty for an ideal radar.
pub fn radar(summary: &Summary) -> Vec<Fact> {
    let Some(found) = summary.perception.as_ref().filter(|found| found.gospa_m > 0.0) else {
        return Vec::new();
    };
    let m = |value: f64| Some(format!("{value:.2} m"));
    let s = |value: f64| format!("{value:.2} s");
    let some = |count: u64| (count > 0).then(|| count.to_string());
    let left_out = found.detections_left_out.unwrap_or(0) + found.tracks_left_out;
    facts([
        ("GOSPA (c = 10 m, p = 2)", m(found.gospa_m)),
        ("… from distances", m(found.localisation_m)),
        ("… from vehicles without a track", m(found.missed_m)),
        ("… from tracks without a vehicle", m(found.false_m)),
        ("false targets", some(found.false_targets)),
        ("time with a false target", some(found.false_targets).map(|_| s(found.false_target_s))),
        ("cut-in confirmed after overlap", found.cut_in_mean_s.map(s)),
        ("… longest", found.cut_in_worst_s.map(s)),
        ("cut-ins not confirmed", some(found.cut_ins_unconfirmed)),
        ("detections and tracks without room", some(left_out)),
        ("scans", some(found.scans)),
    ])
}

/// The on-board unit's verdicts; empty where no signal came by radio.
pub fn radio(summary: &Summary) -> Vec<Fact> {
    let Some(radio) = &summary.radio else { return Vec::new() };
    let given = radio.verdicts.iter().filter(|(_, count)| **count > 0);
    let given: Vec<_> =
        given.map(|(verdict, count)| format!("{count} {}", verdict.replace('_', " "))).collect();
    let verdicts = if given.is_empty() { "none received".to_owned() } else { given.join(", ") };
    let left_out = (radio.left_out > 0).then(|| radio.left_out.to_string());
    facts([
        ("radio", Some(format!("{} frames, {verdicts}", radio.frames))),
        ("frames without room in a batch", left_out),
        ("own CAMs sent", Some(radio.cams_sent.to_string())),
        ("signatures", Some("none (IEEE 1609.2): the identity of a sender is not proven".into())),
    ])
}

/// Frames between the vehicle and other hosts; empty where the roadside units were simulated.
pub fn link(summary: &Summary) -> Vec<Fact> {
    let Some(link) = &summary.link else { return Vec::new() };
    let count = |count: u64| (count > 0).then(|| count.to_string());
    let radio = &link.radio;
    let frames =
        format!("{}: {} frames received, {} sent", radio.carrier, radio.received, radio.sent);
    let mut lines = facts([
        ("link", Some(frames)),
        ("… from before the start", count(link.before_start)),
        ("… for which the queue was full", count(radio.dropped)),
        ("… packets that are not frames", count(radio.malformed)),
        ("… own frames not sent", count(radio.not_sent)),
    ]);
    for station in radio.stations.iter().filter(|station| station.received > 0) {
        let StationReport { sender, received, lost, duplicates, reordered, .. } = station;
        let clock = clock(station).map_or_else(String::new, |clock| format!("; {clock}"));
        lines.push((
            format!("station {sender}"),
            format!("{received} received, {lost} lost, {duplicates} repeated, {reordered} out of order{clock}"),
        ));
    }
    if !link.truth_known {
        let unknown = "not known on this host: red lights were not judged";
        lines.push(("true signal phases".to_owned(), unknown.to_owned()));
    }
    lines
}

fn clock(station: &StationReport) -> Option<String> {
    let ClockComparison { offset_us, uncertainty_us, .. } = station.clock?;
    let (sign, by) = (if offset_us < 0.0 { "behind" } else { "ahead" }, offset_us.abs());
    Some(format!("its clock {} {sign}, known to {}", duration(by), duration(uncertainty_us)))
}

fn facts<const N: usize>(all: [(&str, Option<String>); N]) -> Vec<Fact> {
    all.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
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

    #[test]
    fn a_loss_is_reported_with_its_topic_and_its_reader() {
        let late = TopicCounts {
            sent: 600,
            lost_by: [("controller", 6)].into(),
            ..TopicCounts::default()
        };
        let topics =
            [("v2x/map".to_owned(), TopicCounts::default()), ("vehicle/odometry".to_owned(), late)];
        let mut said = Vec::new();
        messages(&topics.into(), &mut |_, value| said.push(value));
        let loss = "controller read vehicle/odometry too late: its queue was full, 6 of 600 lost";
        assert_eq!(said[1..], [loss]);
    }
}
