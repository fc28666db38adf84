//! `trajectory.csv`: the drive, one row per sample of the vehicle's motion.

use crate::table;
use group::Drive;

/// Columns before the law's own figures.
const COLUMNS: [&str; 11] = [
    "time_s",
    "position_m",
    "speed_mps",
    "acceleration_mps2",
    "request_mps2",
    "gap_m",
    "lead_speed_mps",
    "mode",
    "gear",
    "engine_torque_nm",
    "fuel_g",
];

/// The drive as CSV. Fields without a message in a step are empty. `figure_names` name the columns of the
/// law's own figures; `law_` precedes a name that another column has.
pub fn csv(drive: &Drive, figure_names: &[&str]) -> String {
    let rows = drive.steps.iter().map(|step| {
        let own = [
            Some(step.time_s),
            Some(step.position_m),
            Some(step.speed_mps),
            Some(step.acceleration_mps2),
            step.request_mps2,
            step.gap_m,
            step.lead_speed_mps,
            step.mode.map(f64::from),
            step.powertrain.map(|powertrain| f64::from(powertrain.gear)),
            step.powertrain.map(|powertrain| powertrain.engine_torque_nm),
            step.powertrain.map(|powertrain| powertrain.fuel_g),
        ];
        let figures = (0..figure_names.len()).map(|index| Some(step.figures?[index]));
        own.into_iter().chain(figures)
    });
    let own_names = figure_names.iter().map(|name| {
        if COLUMNS.contains(name) { format!("law_{name}") } else { (*name).to_owned() }
    });
    table::csv_of_figures(COLUMNS.map(str::to_owned).into_iter().chain(own_names), rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use group::DriveStep;

    #[test]
    fn absent_values_are_empty_and_numbers_round_trip() {
        let step =
            DriveStep { time_s: 0.1, position_m: 1.5, gap_m: Some(49.5), ..DriveStep::default() };
        let drive = Drive { steps: vec![step], ..Drive::default() };
        let text = csv(&drive, &["e_m", "gap_m"]);
        let mut lines = text.lines();
        assert!(lines.next().is_some_and(|head| head.ends_with(",fuel_g,e_m,law_gap_m")));
        assert_eq!(lines.next(), Some("0.1,1.5,0,0,,49.5,,,,,,,"));
    }
}
