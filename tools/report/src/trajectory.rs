//! `trajectory.csv`: the drive, one row per sample of the vehicle's motion.

use crate::table;
use supervise::{Drive, DriveStep};

/// A column of a trajectory: its name, whether its values are whole, and its value in a step; none without a message.
pub type StepColumn = (&'static str, bool, fn(&DriveStep) -> Option<f64>);

/// Columns before the law's own figures.
pub const COLUMNS: [StepColumn; 11] = [
    ("time_s", false, |step| Some(step.time_s)),
    ("position_m", false, |step| Some(step.position_m)),
    ("speed_mps", false, |step| Some(step.speed_mps)),
    ("acceleration_mps2", false, |step| Some(step.acceleration_mps2)),
    ("request_mps2", false, |step| step.request_mps2),
    ("gap_m", false, |step| step.gap_m),
    ("lead_speed_mps", false, |step| step.lead_speed_mps),
    ("mode", true, |step| step.mode.map(f64::from)),
    ("gear", true, |step| step.powertrain.map(|powertrain| f64::from(powertrain.gear))),
    ("engine_torque_nm", false, |step| {
        step.powertrain.map(|powertrain| powertrain.engine_torque_nm)
    }),
    ("fuel_g", false, |step| step.powertrain.map(|powertrain| powertrain.fuel_g)),
];

/// Columns behind the law's own figures: later ones stand at the end, so that readers by place keep working.
pub const LATER: [StepColumn; 8] = [
    ("applied_mps2", false, |step| Some(step.applied_mps2)),
    ("ttc_s", false, |step| Some(step.time_to_collision_s).filter(|time_s| time_s.is_finite())),
    ("stop_line_m", false, |step| Some(step.stop_line_m).filter(|way_m| way_m.is_finite())),
    ("signal", true, |step| step.signal.map(|phase| f64::from(phase.to_wire()))),
    ("brake_state", true, |step| step.brake.map(|state| f64::from(state as u32))),
    ("lead", true, |step| step.lead.map(f64::from)),
    ("lead_acceleration_mps2", false, |step| step.lead_acceleration_mps2),
    ("quality", true, |step| step.quality.map(f64::from)),
];

/// The drive as columns, each with a value for every step. `figure_names` name the columns of the law's own figures;
/// `law_` precedes a name that another column has.
pub fn columns(drive: &Drive, figure_names: &[&str]) -> Vec<(String, Vec<Option<f64>>)> {
    let of = |value: &dyn Fn(&DriveStep) -> Option<f64>| drive.steps.iter().map(value).collect();
    let named = |(name, _, value): StepColumn| (name.to_owned(), of(&value));
    let figures = figure_names.iter().enumerate().map(|(index, name)| {
        let is_taken = COLUMNS.iter().chain(&LATER).any(|(known, ..)| known == name);
        let name = if is_taken { format!("law_{name}") } else { (*name).to_owned() };
        (name, of(&|step| Some(step.figures?[index])))
    });
    COLUMNS.into_iter().map(named).chain(figures).chain(LATER.into_iter().map(named)).collect()
}

/// The drive as CSV. Fields without a message in a step are empty.
pub fn csv(drive: &Drive, figure_names: &[&str]) -> String {
    let whole = &columns(drive, figure_names);
    let rows = (0..drive.steps.len()).map(|step| whole.iter().map(move |(_, values)| values[step]));
    table::csv_of_figures(whole.iter().map(|(name, _)| name), rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absent_values_are_empty_and_numbers_round_trip() {
        let step = DriveStep {
            time_s: 0.1,
            position_m: 1.5,
            gap_m: Some(49.5),
            applied_mps2: -1.0,
            time_to_collision_s: f64::INFINITY,
            stop_line_m: 80.0,
            signal: Some(messages::PhaseState::StopAndRemain),
            brake: Some(messages::BrakeState::Braking),
            lead: Some(2),
            ..DriveStep::default()
        };
        let drive = Drive { steps: vec![step], ..Drive::default() };
        let text = csv(&drive, &["e_m", "gap_m"]);
        let mut lines = text.lines();
        let head = lines.next().expect("a head");
        assert!(head.contains(",fuel_g,e_m,law_gap_m,applied_mps2,ttc_s,"), "{head}");
        assert_eq!(lines.next(), Some("0.1,1.5,0,0,,49.5,,,,,,,,-1,,80,3,2,2,,"));
    }
}
