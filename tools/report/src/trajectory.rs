//! `trajectory.csv`: the drive, one row per sample of the vehicle's motion.

use group::Drive;
use std::fmt::Write;

/// The drive as CSV. What was not published in a step is left empty. The columns of the law's own
/// figures are named by `figure_names`.
pub fn csv(drive: &Drive, figure_names: &[&str]) -> String {
    let mut text = String::from(
        "time_s,position_m,speed_mps,acceleration_mps2,request_mps2,gap_m,lead_speed_mps,mode,\
         gear,engine_torque_nm,fuel_g",
    );
    for name in figure_names {
        text.push(',');
        text.push_str(name);
    }
    text.push('\n');
    for step in &drive.steps {
        write!(
            text,
            "{},{},{},{},{},{},{},{},{},{},{}",
            step.time_s,
            step.position_m,
            step.speed_mps,
            step.acceleration_mps2,
            field(step.request_mps2),
            field(step.gap_m),
            field(step.lead_speed_mps),
            step.mode.map_or_else(String::new, |mode| mode.to_string()),
            step.powertrain.map_or_else(String::new, |powertrain| powertrain.gear.to_string()),
            field(step.powertrain.map(|powertrain| powertrain.engine_torque_nm)),
            field(step.powertrain.map(|powertrain| powertrain.fuel_g)),
        )
        .expect("a string takes all");
        for index in 0..figure_names.len() {
            text.push(',');
            text.push_str(&field(step.figures.map(|figures| figures[index])));
        }
        text.push('\n');
    }
    text
}

fn field(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
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
        let text = csv(&drive, &["e_m"]);
        let mut lines = text.lines();
        assert!(lines.next().is_some_and(|head| head.ends_with(",fuel_g,e_m")));
        assert_eq!(lines.next(), Some("0.1,1.5,0,0,,49.5,,,,,,"));
    }
}
