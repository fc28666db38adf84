//! Console lines about the drive.

use crate::chart::number;
use crate::summary::Summary;
use crate::trip::Trip;
use group::report::Outcome;

pub(super) fn drive(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let control = &summary.control.figures;
    if let Some(crossed) = control.stop_line_crossing_s {
        let past = control.past_stop_line_at_switch_m;
        let past = past.map_or_else(String::new, |past| format!(", {}", at_switch(past)));
        line("stop line", format!("crossed at {crossed:.2} s{past}"));
    } else if let Some(past) = control.past_stop_line_at_switch_m {
        line("stop line", at_switch(past));
    }
    if let Some(trip) = trip(&summary.control.trip) {
        line("trip", trip);
    }
    if let Some(gap) = control.min_gap_m {
        let ttc = control
            .min_ttc_s
            .map_or_else(String::new, |ttc| format!(", time to collision at least {ttc:.1} s"));
        let end = control.final_gap_error_m.map_or_else(String::new, |error| {
            format!(", gap error {} m at the end", number(error, 2))
        });
        let impact = control
            .impact_speed_mps
            .map_or_else(String::new, |impact| format!(" with {} m/s", number(impact, 1)));
        line("gap", format!("{}{impact}{end}{ttc}", smallest_gap(summary.outcome, gap)));
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
    if let Some(lateral) = control.max_abs_lateral_accel_mps2 {
        let jerk = control
            .max_abs_lateral_jerk_mps3
            .map_or_else(String::new, |jerk| format!(", jerk {} m/s³", number(jerk, 2)));
        let outside = match control.outside_lane_s {
            Some(time_s) if time_s > 0.0 => format!(", outside the lane for {time_s:.1} s"),
            _ => String::new(),
        };
        line("lateral", format!("at most {} m/s²{jerk}{outside}", number(lateral, 2)));
    }
    if let Some(energy) = control.wheel_energy_kwh_per_100km {
        let stops = match control.stops {
            Some(1) => ", 1 stop".to_owned(),
            Some(stops) => format!(", {stops} stops"),
            None => String::new(),
        };
        let mark = short(&summary.control.trip);
        line("energy", format!("{} kWh/100 km at the wheels{stops}{mark}", number(energy, 2)));
    }
    if let Some(fuel) = control.fuel_l_per_100km {
        let shifts = control
            .gear_shifts
            .map_or_else(String::new, |shifts| format!(", {shifts} gear shifts"));
        let braked = match control.service_brake_s {
            Some(time_s) if time_s > 0.0 => format!(", service brakes for {time_s:.1} s"),
            _ => ", no service brake".into(),
        };
        let mark = short(&summary.control.trip);
        line("fuel", format!("{fuel:.2} L/100 km{shifts}{braked}{mark}"));
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

/// The mark of energy that cannot be compared.
fn short(trip: &Trip) -> &'static str {
    let is_short = trip.energy_is_comparable == Some(false);
    if is_short { ", not comparable: a trip too short for its change of speed" } else { "" }
}

/// Position of the ego when the light changed, m past the stop line.
fn at_switch(past_m: f64) -> String {
    let side = if past_m < 0.0 { "before" } else { "past" };
    format!("{:.1} m {side} it when the light changed", past_m.abs())
}

/// The trip through the signals in words. A trip that did not pass all of them has only the bound.
pub fn trip(trip: &Trip) -> Option<String> {
    let fastest_s = trip.fastest_legal_trip_s?;
    Some(match trip.trip_time_s {
        Some(time_s) => format!(
            "past the last stop line after {time_s:.1} s, {} s longer than the fastest legal trip",
            number(time_s - fastest_s, 1)
        ),
        None => {
            format!("not past the last stop line; the fastest legal trip takes {fastest_s:.1} s")
        }
    })
}

pub(super) fn emergency_brake(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
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

/// Match of the radar's tracks with the traffic; omitted for an ideal radar.
pub(super) fn radar(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let Some(perception) =
        summary.perception.as_ref().filter(|perception| perception.gospa_m > 0.0)
    else {
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
        parts.push(format!("{left_out} detections and tracks did not fit into their messages"));
    }
    line("radar", parts.join(", "));
}

/// Remarks on the storyboard: the end of its road, and acts that never started.
pub(crate) fn storyboard_remarks(summary: &Summary) -> Option<String> {
    let perception = summary.perception.as_ref()?;
    let end = perception.road_ended.then(|| "ended where the ego's road ends".to_owned());
    let remarks: Vec<String> =
        end.into_iter().chain(unstarted_acts(&perception.unstarted_acts)).collect();
    (!remarks.is_empty()).then(|| remarks.join(", "))
}

/// Acts that never started, in words.
fn unstarted_acts(acts: &[String]) -> Option<String> {
    let named: Vec<String> = acts.iter().take(5).map(|act| format!("`{act}`")).collect();
    let more = acts.len() - named.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let what = if acts.len() == 1 { "act" } else { "acts" };
    (!acts.is_empty()).then(|| format!("{what} {}{more} never started", named.join(", ")))
}

pub(super) fn storyboard(summary: &Summary, line: &mut dyn FnMut(&str, String)) {
    let road_ended = summary.perception.as_ref().is_some_and(|perception| perception.road_ended);
    if let Some(text) = storyboard_remarks(summary) {
        line(if road_ended { "road" } else { "storyboard" }, text);
    }
}

/// The smallest gap in words. Touching bodies have no gap.
fn smallest_gap(outcome: Outcome, gap_m: f64) -> String {
    if outcome == Outcome::Collision && gap_m <= 0.0 {
        return "0 m at the collision".into();
    }
    format!("at least {} m", number(gap_m, 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_side_of_the_line_is_named_in_words() {
        assert_eq!(at_switch(-0.54), "0.5 m before it when the light changed");
        assert_eq!(at_switch(78.1), "78.1 m past it when the light changed");
    }

    #[test]
    fn a_gap_is_never_a_negative_zero() {
        assert_eq!(smallest_gap(Outcome::Completed, -0.01), "at least 0.0 m");
        assert_eq!(smallest_gap(Outcome::Collision, -0.01), "0 m at the collision");
        assert_eq!(smallest_gap(Outcome::Completed, 4.26), "at least 4.3 m");
    }
}
