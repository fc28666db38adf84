//! Question to a foreign law and its answer: two records of fixed layout, by pipe.
//!
//! They are not messages of a topic: no header, no protection. The host of the law exchanges
//! records with one program, which it started itself. All numbers are little-endian, 8 bytes each.

use crate::layout::declare::*;

/// Most signals in a question to a law.
pub const LAW_SIGNALS: usize = 4;
/// Most intervals of a signal.
pub const LAW_INTERVALS: usize = 8;
/// Most cells of the road ahead.
pub const LAW_CELLS: usize = 64;
/// Most requests that can follow the one that acts now.
pub const LAW_PLAN: usize = 96;
/// Modes that a foreign law can show.
pub const LAW_MODES: usize = 8;
/// Figures that a foreign law can show.
pub const LAW_FIGURES: usize = 8;

layout! {
    /// One announced interval of a signal.
    pub struct LawInterval "timegap_msgs/msg/LawInterval" {
        /// Phase: 0 unknown (never to be treated as green), 1 green, 2 yellow, 3 red.
        pub phase: u64,
        /// Time from the release until the interval ends, s.
        pub ends_in_s: f64,
    }

    /// A signal ahead on the ego's lane.
    pub struct LawSignal "timegap_msgs/msg/LawSignal" {
        /// Intersection id times 256 plus signal group id.
        pub id: u64,
        /// Distance from the ego's front bumper to the stop line, m; negative once it is passed.
        pub distance_m: f64,
        /// Valid entries of `intervals`.
        pub interval_count: u64,
        /// The current interval and those that follow.
        pub intervals: [LawInterval; LAW_INTERVALS],
    }

    /// Question to a law at one release. The first 13 fields never move.
    pub struct LawInput "timegap_msgs/msg/LawInput" {
        /// Number of the question; the answer carries it back.
        pub sequence: u64,
        /// 1 if the law must clear its history before it answers.
        pub reset: u64,
        /// Time of the release since the start of the run, s.
        pub time_s: f64,
        /// Control period, s.
        pub period_s: f64,
        /// Distance travelled since the start of the run, m.
        pub position_m: f64,
        /// Speed, m/s, never negative.
        pub speed_mps: f64,
        /// Acceleration, m/s².
        pub acceleration_mps2: f64,
        /// Driver's set speed, m/s.
        pub set_speed_mps: f64,
        /// Legal limit on this road, m/s; infinite when unknown.
        pub speed_limit_mps: f64,
        /// 1 if there is a vehicle ahead; the other fields of the target are 0 otherwise.
        pub has_target: u64,
        /// Identity of the target: a new number means a new vehicle.
        pub target_id: u64,
        /// Bumper-to-bumper distance to the target, m.
        pub gap_m: f64,
        /// Target speed minus ego speed, m/s, negative when closing.
        pub relative_speed_mps: f64,
        /// Absolute acceleration of the target, m/s².
        pub target_acceleration_mps2: f64,
        /// Age of the sample behind the target, s.
        pub target_age_s: f64,
        /// Valid entries of `signals`.
        pub signal_count: u64,
        /// Signals ahead, nearest first.
        pub signals: [LawSignal; LAW_SIGNALS],
        /// 1 if the vehicle is a truck; the other fields of its powertrain are 0 otherwise.
        pub has_powertrain: u64,
        /// Gear, counted from 1; the one being engaged during a shift.
        pub gear: u64,
        /// Time since the last shift began, s.
        pub since_shift_s: f64,
        /// Torque at the crankshaft, N m.
        pub engine_torque_nm: f64,
        /// The vehicle's own estimate of the grade under it, rise over run.
        pub grade: f64,
        /// Valid entries of `cell_grades`; 0 where no map describes the road.
        pub cell_count: u64,
        /// Beginning of the first cell of the road ahead, m, as `position_m`.
        pub first_cell_m: f64,
        /// Length of a cell, m.
        pub cell_m: f64,
        /// Mean grade of each cell, rise over run.
        pub cell_grades: [f64; LAW_CELLS],
    }

    /// Answer of a law. A 0 behind the request leaves the value to the default.
    pub struct LawAnswer "timegap_msgs/msg/LawAnswer" {
        /// Number of the question.
        pub sequence: u64,
        /// Requested acceleration, m/s²; bounded by `controller.min_request_mps2` and `max_request_mps2`.
        pub request_mps2: f64,
        /// Mode of the law, 0 to 7, for people.
        pub mode: u64,
        /// Figures of the law's own, for people; they steer nothing.
        pub figures: [f64; LAW_FIGURES],
        /// 1 if the engine of a truck is asked for a torque.
        pub has_torque: u64,
        /// Torque at the crankshaft, N m; below the drag torque it asks for the engine brake.
        pub engine_torque_nm: f64,
        /// Force of the service brakes at the wheels, N.
        pub service_brake_n: f64,
        /// Gear to engage, counted from 1; 0 leaves it to the gearbox.
        pub gear: u64,
        /// Valid entries of `plan_mps2`.
        pub plan_count: u64,
        /// Requests for the control periods that follow, m/s²: what the vehicle does if no answer comes.
        pub plan_mps2: [f64; LAW_PLAN],
    }
}

pub const LAW_RECORDS: [&crate::Layout; 2] =
    [<LawInput as crate::Laid>::LAYOUT, <LawAnswer as crate::Laid>::LAYOUT];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Laid;

    #[test]
    fn a_question_is_written_to_a_pipe_in_one_piece() {
        // A record that fits into PIPE_BUF is written whole or not at all.
        assert!(size_of::<LawInput>() <= 4096 && size_of::<LawAnswer>() <= 4096);
    }

    #[test]
    fn the_first_fields_are_where_the_examples_look_for_them() {
        let at = |name: &str| {
            let field = LawInput::LAYOUT.fields.iter().find(|field| field.name == name);
            field.expect("a field of the input").offset
        };
        assert_eq!((at("sequence"), at("reset"), at("time_s"), at("has_target")), (0, 8, 16, 72));
        assert_eq!((at("gap_m"), at("relative_speed_mps")), (88, 96));
    }

    #[test]
    fn every_field_has_a_meaning() {
        let nested = [LawSignal::LAYOUT, LawInterval::LAYOUT];
        for layout in LAW_RECORDS.into_iter().chain(nested) {
            for field in layout.fields {
                assert!(!field.meaning().is_empty(), "{}", field.name);
            }
        }
    }
}
