//! `trajectory.csv`: the drive, one row per sample of the vehicle's motion.

use crate::table;
use supervise::{Drive, DriveStep, PowertrainStep};

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

/// Columns behind the law's own figures: later ones stand at the end, so that readers by place keep working.
const LATER: [&str; 7] = [
    "applied_mps2",
    "ttc_s",
    "stop_line_m",
    "signal",
    "brake_state",
    "lead",
    "lead_acceleration_mps2",
];

/// The drive as columns, each with a value for every step; none where a step has no message. `figure_names` name the
/// columns of the law's own figures; `law_` precedes a name that another column has.
pub fn columns(drive: &Drive, figure_names: &[&str]) -> Vec<(String, Vec<Option<f64>>)> {
    let of = |value: &dyn Fn(&DriveStep) -> Option<f64>| drive.steps.iter().map(value).collect();
    let powertrain = |value: fn(&PowertrainStep) -> f64| {
        of(&|step: &DriveStep| step.powertrain.as_ref().map(value))
    };
    let own: [Vec<Option<f64>>; COLUMNS.len()] = [
        of(&|step| Some(step.time_s)),
        of(&|step| Some(step.position_m)),
        of(&|step| Some(step.speed_mps)),
        of(&|step| Some(step.acceleration_mps2)),
        of(&|step| step.request_mps2),
        of(&|step| step.gap_m),
        of(&|step| step.lead_speed_mps),
        of(&|step| step.mode.map(f64::from)),
        powertrain(|powertrain| f64::from(powertrain.gear)),
        powertrain(|powertrain| powertrain.engine_torque_nm),
        powertrain(|powertrain| powertrain.fuel_g),
    ];
    let figures = figure_names.iter().enumerate().map(|(index, name)| {
        let is_taken = COLUMNS.contains(name) || LATER.contains(name);
        let name = if is_taken { format!("law_{name}") } else { (*name).to_owned() };
        (name, of(&|step| Some(step.figures?[index])))
    });
    let later: [Vec<Option<f64>>; LATER.len()] = [
        of(&|step| Some(step.applied_mps2)),
        of(&|step| Some(step.time_to_collision_s).filter(|time_s| time_s.is_finite())),
        of(&|step| Some(step.stop_line_m).filter(|way_m| way_m.is_finite())),
        of(&|step| step.signal.map(|phase| f64::from(phase.to_wire()))),
        of(&|step| step.brake.map(|state| f64::from(state as u32))),
        of(&|step| step.lead.map(f64::from)),
        of(&|step| step.lead_acceleration_mps2),
    ];
    let own = COLUMNS.map(str::to_owned).into_iter().zip(own);
    own.chain(figures).chain(LATER.map(str::to_owned).into_iter().zip(later)).collect()
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
        assert_eq!(lines.next(), Some("0.1,1.5,0,0,,49.5,,,,,,,,-1,,80,3,2,2,"));
    }
}
