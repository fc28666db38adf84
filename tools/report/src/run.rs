//! The page of one run.

use super::chart::escape;
use super::html::{Column, Tile, document, figure, section, stacked_table, table, tiles};
use super::picture::{RunPicture, letter};
use super::{curve_plots, drive, timing};
use crate::print;
use crate::summary::{ServiceSummary, Summary};
use group::report::Outcome;
use scenario::Scenario;

/// Longest scenario that is printed in full, bytes.
const MAX_SCENARIO: usize = 100_000;

/// The page of a run.
pub fn page(scenario: &Scenario, summary: &Summary, run: &RunPicture) -> String {
    let body = [
        tiles(&figures(summary)),
        faults(run),
        requirements(summary),
        section("The drive", &(storyboard(summary) + &pictures(run))),
        tracking(summary),
        crate::radio::page(summary),
        crate::link::page(summary),
        section("Timing", &times(summary, run)),
        section("Messages", &messages(summary)),
        section("Processes and scheduling", &machine(summary)),
        repeat(scenario, summary),
    ]
    .concat();
    let (good, verdict) = verdict(summary);
    let about = [
        summary.driver(),
        summary.mode.to_owned(),
        format!("seed {}", summary.seed),
        scenario.description.as_str().to_owned(),
    ];
    let about: Vec<_> = about.into_iter().filter(|part| !part.is_empty()).collect();
    document(&summary.scenario, &about.join(" · "), good, &verdict, &body)
}

/// The requirements of the scenario with their margins and their marks in the charts; empty without one.
fn requirements(summary: &Summary) -> String {
    if summary.requirements.is_empty() {
        return String::new();
    }
    let rows: Vec<_> = (summary.requirements.iter().enumerate())
        .map(|(place, verdict)| {
            let mark = letter(place).to_string();
            vec![mark, verdict.requirement.clone(), print::requirement(verdict)]
        })
        .collect();
    let head = [("mark", Column::Text), ("requirement", Column::Text), ("verdict", Column::Text)];
    section("Requirements", &stacked_table(&head, &rows))
}

/// Remarks on the storyboard: where they stand, the drive was not the one of the file.
fn storyboard(summary: &Summary) -> String {
    let text = print::storyboard_remarks(summary);
    text.map_or_else(String::new, |text| format!("<p>{}</p>", escape(&text)))
}

/// Match of the radar's tracks with the traffic; empty for an ideal radar.
fn tracking(summary: &Summary) -> String {
    let Some(found) = summary.perception.as_ref().filter(|found| found.gospa_m > 0.0) else {
        return String::new();
    };
    let m = |value: f64| format!("{} m", super::chart::number(value, 2));
    let s = |value: f64| format!("{} s", super::chart::number(value, 2));
    let mut rows = vec![
        vec!["GOSPA (c = 10 m, p = 2), root mean square".to_owned(), m(found.gospa_m)],
        vec!["part from distances between tracks and vehicles".into(), m(found.localisation_m)],
        vec!["part from vehicles without a track".into(), m(found.missed_m)],
        vec!["part from tracks without a vehicle".into(), m(found.false_m)],
        vec!["false targets".into(), found.false_targets.to_string()],
        vec!["time with a false target".into(), s(found.false_target_s)],
    ];
    if let (Some(mean_s), Some(worst_s)) = (found.cut_in_mean_s, found.cut_in_worst_s) {
        rows.push(vec!["cut-ins confirmed".into(), found.cut_ins.to_string()]);
        rows.push(vec!["delay from overlap to a confirmed cut-in, mean".into(), s(mean_s)]);
        rows.push(vec!["delay from overlap to a confirmed cut-in, longest".into(), s(worst_s)]);
    }
    if found.cut_ins_unconfirmed > 0 {
        rows.push(vec!["cut-ins not confirmed".into(), found.cut_ins_unconfirmed.to_string()]);
    }
    if let Some(detections) = found.detections {
        rows.push(vec!["detections".into(), detections.to_string()]);
    }
    let left_out = found.detections_left_out.unwrap_or(0) + found.tracks_left_out;
    if left_out > 0 {
        let what = "detections and tracks that did not fit into their messages";
        rows.push(vec![what.into(), left_out.to_string()]);
    }
    let scans = format!("of {} scans", found.scans);
    let head =
        [("radar and tracker against ground truth", Column::Text), (&*scans, Column::Number)];
    section("Radar", &table(&head, &rows))
}

/// Verdict of the requirement, and the outcome in words.
fn verdict(summary: &Summary) -> (bool, String) {
    let at = format!("{:.1} s", summary.duration_s);
    match summary.outcome {
        Outcome::Completed => {
            let helped = summary
                .aebs
                .interventions
                .map_or_else(String::new, |times| format!("; {}", super::summary::braked(times)));
            (true, format!("Completed: {at} driven without a collision or a red light{helped}"))
        }
        Outcome::Collision => (false, format!("Collision after {at}")),
        Outcome::RedLight => {
            (false, format!("Red light: a stop line was crossed at red after {at}"))
        }
        Outcome::SafeStop => {
            (false, format!("Safe stop: the plant received no valid commands; {at} driven"))
        }
        Outcome::DrivenByBackup => {
            let law = print::backup(summary).unwrap_or_default();
            (false, format!("Driven by the backup: {law}. These figures say little about the law"))
        }
        Outcome::RequirementBroken => {
            let broken = summary.requirements.iter().filter(|verdict| !verdict.met);
            let texts: Vec<_> = broken.map(|verdict| verdict.requirement.as_str()).collect();
            (false, format!("Requirement broken: {}", texts.join("; ")))
        }
        Outcome::Aborted => {
            let why = summary.aborted_because.as_deref().unwrap_or("ended early");
            (false, format!("Aborted after {at}: {why}"))
        }
    }
}

/// Figures at the top of the page.
fn figures(summary: &Summary) -> Vec<Tile> {
    let control = &summary.control.figures;
    let timing = &summary.timing;
    let tile =
        |label, value: Option<String>, note: String| value.map(|value| Tile { label, value, note });
    let number = |value: Option<f64>, decimals: usize, unit: &str| {
        value.map(|value| format!("{} {unit}", super::chart::number(value, decimals)))
    };
    let range = control.min_accel_mps2.zip(control.max_accel_mps2).map(|(low, high)| {
        let of = |value| super::chart::number(value, 1);
        format!("{} to {} m/s²", of(low), of(high))
    });
    let past = control.past_stop_line_at_switch_m.map_or_else(String::new, |past| {
        let side = if past < 0.0 { "before" } else { "past" };
        format!("{:.1} m {side} it when the light changed", past.abs())
    });
    let crossed = match (control.stop_line_crossing_s, control.past_stop_line_at_switch_m) {
        (None, Some(_)) => Some("not crossed".to_owned()),
        (crossed, _) => number(crossed, 2, "s"),
    };
    let reaction = timing.reaction_time_us.filter(|_| summary.mode == "realtime");
    let missed = timing.deadline_misses.zip(timing.cycles);
    let late = timing.missed_at_plant.zip(timing.due_at_plant);
    let deadline = timing.deadline_us.map(print::duration);
    let deadline = deadline.map_or_else(String::new, |time| format!("deadline {time}"));
    [
        tile(
            "Smallest gap",
            number(control.min_gap_m.map(|gap| gap.max(0.0)), 1, "m"),
            String::new(),
        ),
        tile(
            "Shortest time gap",
            number(summary.control.following.min_time_gap_s, 2, "s"),
            summary
                .control
                .following
                .median_time_gap_s
                .map_or_else(String::new, |median| format!("median {median:.2} s")),
        ),
        tile("Impact speed", number(control.impact_speed_mps, 1, "m/s"), String::new()),
        tile("Smallest time to collision", number(control.min_ttc_s, 1, "s"), String::new()),
        tile("Gap error at the end", number(control.final_gap_error_m, 2, "m"), String::new()),
        tile("First stop line", crossed, past),
        tile(
            "Last stop line",
            number(summary.control.trip.trip_time_s, 1, "s"),
            summary
                .control
                .trip
                .fastest_legal_trip_s
                .map_or_else(String::new, |fastest| format!("fastest legal trip {fastest:.1} s")),
        ),
        tile("Acceleration", range, String::new()),
        tile(
            "Emergency brakings",
            summary.aebs.interventions.map(|times| times.to_string()),
            summary
                .aebs
                .warnings
                .map_or_else(String::new, |warnings| format!("{warnings} warnings")),
        ),
        tile("Largest jerk", number(control.max_abs_jerk_mps3, 1, "m/s³"), String::new()),
        tile(
            "Largest lateral acceleration",
            number(control.max_abs_lateral_accel_mps2, 2, "m/s²"),
            number(control.max_abs_lateral_jerk_mps3, 2, "m/s³")
                .map_or_else(String::new, |jerk| format!("lateral jerk {jerk}")),
        ),
        tile(
            "Outside the lane",
            number(control.outside_lane_s.filter(|time_s| *time_s > 0.0), 1, "s"),
            String::new(),
        ),
        tile(
            "Fuel",
            number(control.fuel_l_per_100km, 2, "L/100 km"),
            match summary.control.trip.energy_is_comparable {
                Some(false) => "not comparable: a trip too short for its change of speed".into(),
                _ => String::new(),
            },
        ),
        tile(
            "Reaction time, median",
            reaction.map(|p| print::duration(p.p50)),
            reaction.map_or_else(String::new, |p| {
                format!("max {}, n = {}", print::duration(p.max), p.count)
            }),
        ),
        tile(
            "Control cycles late",
            missed.map(|(missed, cycles)| format!("{missed} of {cycles}")),
            deadline.clone(),
        ),
        tile(
            "Commands late at the plant",
            late.map(|(missed, due)| format!("{missed} of {due}")),
            deadline,
        ),
        tile(
            "Solve time, median",
            timing.solve_us.map(|p| print::duration(p.p50)),
            timing.solve_us.map_or_else(String::new, |p| {
                format!("max {}, n = {}", print::duration(p.max), p.count)
            }),
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Table of the faults by their numbers in the charts; empty without faults.
fn faults(run: &RunPicture) -> String {
    if run.faults.is_empty() {
        return String::new();
    }
    let rows: Vec<_> = (run.faults.iter().enumerate())
        .map(|(index, fault)| {
            let number = (index + 1).to_string();
            vec![number, format!("{:.3}", fault.t_s), fault.label.clone(), fault.outcome.clone()]
        })
        .collect();
    let head = [
        ("no.", Column::Number),
        ("at, s", Column::Number),
        ("fault", Column::Text),
        ("result", Column::Text),
    ];
    section("Faults", &table(&head, &rows))
}

/// Charts of the drive.
pub fn pictures(run: &RunPicture) -> String {
    let following = [drive::gap(run), drive::time_gap(run), drive::time_to_collision(run)];
    let plots = [drive::speed(run)].into_iter().chain(following.into_iter().flatten());
    let motion = plots.chain([drive::acceleration(run), drive::jerk(run), drive::road(run)]);
    let below = curve_plots::plots(run).into_iter().chain(drive::profile(run));
    let below = below.chain(drive::powertrain(run));
    let drawn: String = motion.map(|plot| figure(&plot)).collect();
    let modes = drive::modes(run).map_or_else(String::new, |modes| figure(&modes));
    let below: String = below.map(|plot| figure(&plot)).collect();
    let above = run.plane.as_ref().map_or_else(String::new, |plane| plane.html());
    format!("{above}<div class=\"columns\">\n{drawn}{modes}{below}</div>\n")
}

fn times(summary: &Summary, run: &RunPicture) -> String {
    if summary.mode == "lockstep" {
        let note = "<p class=\"quiet\">In lockstep all stamps are simulated time: latencies say \
                    nothing about a machine. The law alone is timed by the wall clock.</p>\n";
        return note.to_owned() + &timing::percentiles(summary);
    }
    let count = summary.timing.reaction_time_us.map_or(0, |p| p.count);
    let hops = timing::latencies(run, count).map_or_else(String::new, |plot| figure(&plot));
    let worst =
        timing::worst_chains(&run.worst_chains).map_or_else(String::new, |bands| figure(&bands));
    let mut text =
        format!("<div class=\"grid\">\n{hops}{worst}</div>\n<div class=\"gap\"></div>\n");
    text.push_str(&timing::percentiles(summary));
    if !run.worst_chains.is_empty() {
        text.push_str("<h3 class=\"sub\">The longest chains</h3>\n");
        text.push_str(&timing::worst_table(&run.worst_chains));
    }
    text
}

fn messages(summary: &Summary) -> String {
    let count = |value: Option<u64>| value.map_or_else(|| "–".to_owned(), |n| n.to_string());
    let rows: Vec<_> = (summary.messages.iter())
        .map(|(topic, counts)| {
            vec![
                topic.clone(),
                counts.sent.to_string(),
                count(counts.received),
                count(counts.lost),
                count(counts.e2e_errors),
                counts.e2e.unknown_sender.to_string(),
            ]
        })
        .collect();
    let head = [
        ("topic", Column::Text),
        ("sent", Column::Number),
        ("received", Column::Number),
        ("lost", Column::Number),
        ("invalid", Column::MoreNumber),
        ("from unknown senders", Column::MoreNumber),
    ];
    table(&head, &rows)
}

fn machine(summary: &Summary) -> String {
    let rows: Vec<_> = summary.services.iter().map(service).collect();
    let head = [
        ("service", Column::Text),
        ("granted", Column::Text),
        ("requested", Column::MoreText),
        ("core", Column::Text),
        ("memory", Column::Text),
        ("peak", Column::Number),
        ("restarts", Column::MoreNumber),
        ("take-overs", Column::MoreNumber),
        ("standby", Column::MoreText),
        ("end", Column::MoreText),
        ("not granted", Column::Text),
    ];
    let host = &summary.host;
    let kind = if host.realtime_kernel { "real-time kernel" } else { "not a real-time kernel" };
    let host = format!(
        "<p class=\"quiet\">{} processors, Linux {}, {kind}; ready after {:.0} ms, {:.2} s of wall \
         time</p>\n",
        host.cpus,
        escape(&host.kernel),
        summary.ready_ms,
        summary.wall_s,
    );
    stacked_table(&head, &rows) + &host
}

fn service(service: &ServiceSummary) -> Vec<String> {
    let dash = || "–".to_owned();
    let granted = service.scheduling.as_ref();
    let rss =
        service.peak_rss_kib.map_or_else(dash, |kib| format!("{:.1} MiB", kib as f64 / 1024.0));
    vec![
        service.name.to_owned(),
        granted.map_or_else(dash, |granted| granted.granted.clone()),
        granted.map_or_else(dash, |granted| granted.requested.clone()),
        granted.map_or_else(dash, |granted| {
            granted.core.map_or("any".into(), |core| core.to_string())
        }),
        granted.map_or_else(dash, |granted| {
            if granted.memory_locked { "locked".into() } else { "not locked".into() }
        }),
        rss,
        service.restarts.to_string(),
        service.take_overs.map_or_else(dash, |count| count.to_string()),
        service.standby_cost.map_or_else(dash, |cost| {
            let (cpu, mib) = (cost.cpu_percent, cost.private_kib as f64 / 1024.0);
            format!("{cpu:.2} % of a core, {mib:.1} MiB")
        }),
        service.exit.clone().unwrap_or_else(dash),
        granted.map_or_else(String::new, |granted| {
            let refused = granted.refused.iter().map(ToString::to_string);
            refused.collect::<Vec<_>>().join(", ")
        }),
    ]
}

/// Instructions to repeat the run, with the scenario that took effect.
fn repeat(scenario: &Scenario, summary: &Summary) -> String {
    let toml = scenario.to_toml();
    let whole = if toml.len() <= MAX_SCENARIO {
        format!(
            "<details><summary>The scenario with all options applied</summary>\n<pre>{}</pre>\n</details>\n",
            escape(&toml)
        )
    } else {
        String::new()
    };
    let mode = if summary.mode == "lockstep" { " --mode lockstep" } else { "" };
    let again = format!(
        "<p>In the directory of this page: <code>timegap run scenario.toml{mode}</code></p>\n"
    );
    section("Repeat this run", &(again + &whole))
}
