//! The figures of the table.

use report::summary::Summary;

type Figure = (&'static str, fn(&Summary) -> Option<f64>);

/// Names as in `summary.json`, with the values. They do not depend on the wall clock in lockstep.
pub const FIGURES: &[Figure] = &[
    ("min_gap_m", |s| s.control.figures.min_gap_m),
    ("rms_gap_error_m", |s| s.control.figures.rms_gap_error_m),
    ("max_abs_gap_error_m", |s| s.control.figures.max_abs_gap_error_m),
    ("final_gap_error_m", |s| s.control.figures.final_gap_error_m),
    ("min_ttc_s", |s| s.control.figures.min_ttc_s),
    ("impact_speed_mps", |s| s.control.figures.impact_speed_mps),
    ("min_time_gap_s", |s| s.control.following.min_time_gap_s),
    ("median_time_gap_s", |s| s.control.following.median_time_gap_s),
    ("final_speed_error_mps", |s| s.control.figures.final_speed_error_mps),
    ("max_abs_jerk_mps3", |s| s.control.figures.max_abs_jerk_mps3),
    ("rms_jerk_mps3", |s| s.control.figures.rms_jerk_mps3),
    ("min_accel_mps2", |s| s.control.figures.min_accel_mps2),
    ("max_accel_mps2", |s| s.control.figures.max_accel_mps2),
    ("stop_line_crossing_s", |s| s.control.figures.stop_line_crossing_s),
    ("past_stop_line_at_switch_m", |s| s.control.figures.past_stop_line_at_switch_m),
    ("trip_time_s", |s| s.control.trip.trip_time_s),
    ("fastest_legal_trip_s", |s| s.control.trip.fastest_legal_trip_s),
    ("stops", |s| count(s.control.figures.stops)),
    ("wheel_energy_kwh_per_100km", |s| s.control.figures.wheel_energy_kwh_per_100km),
    ("fuel_l_per_100km", |s| s.control.figures.fuel_l_per_100km),
    ("gear_shifts", |s| count(s.control.figures.gear_shifts)),
    ("service_brake_s", |s| s.control.figures.service_brake_s),
    ("warnings", |s| count(s.aebs.warnings)),
    ("interventions", |s| count(s.aebs.interventions)),
    ("braking_s", |s| s.aebs.braking_s),
    ("data_age_p50_us", |s| s.timing.data_age_us.map(|age| age.p50)),
    ("reaction_time_p50_us", |s| s.timing.reaction_time_us.map(|time| time.p50)),
    ("deadline_misses", |s| count(s.timing.deadline_misses)),
    ("undelivered_commands", |s| count(s.timing.undelivered_commands)),
    ("cycles_by_backup", |s| count(s.law.as_ref().map(|law| law.backup))),
];

fn count(number: Option<u64>) -> Option<f64> {
    number.map(|number| number as f64)
}
