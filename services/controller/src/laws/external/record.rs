//! From a law's input to the question's record, and from the answer's record to a law's output.

use crate::law::{Input, MAX_PLAN, Output, Phase};
use bytemuck::Zeroable;
use messages::{LAW_CELLS, LAW_INTERVALS, LAW_MODES, LAW_PLAN, LAW_SIGNALS, LawAnswer, LawInput};
use runtime::hosted::Hosting;
use truck_model::Demand;

const _: () = assert!(LAW_SIGNALS == crate::law::MAX_SIGNALS, "a question has every signal");
const _: () = assert!(LAW_INTERVALS == crate::law::MAX_PHASES, "and every interval");
const _: () = assert!(LAW_CELLS == crate::law::MAX_CELLS, "and every cell");
const _: () = assert!(LAW_PLAN < MAX_PLAN, "a command carries every plan");

pub(super) type Program = Hosting<LawInput, LawAnswer>;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) least_mps2: f64,
    pub(super) most_mps2: f64,
}

impl Bounds {
    pub(super) fn bring_in(self, request_mps2: f64) -> f64 {
        request_mps2.max(self.least_mps2).min(self.most_mps2)
    }
}

/// Question number `sequence`.
pub(super) fn question(input: &Input, sequence: u64, reset: bool) -> LawInput {
    let mut record = LawInput {
        sequence,
        reset: reset.into(),
        time_s: input.time_s,
        period_s: input.period_s,
        position_m: input.ego.position_m,
        speed_mps: input.ego.speed_mps,
        acceleration_mps2: input.ego.acceleration_mps2,
        set_speed_mps: input.set_speed_mps,
        speed_limit_mps: input.speed_limit_mps,
        ..LawInput::zeroed()
    };
    if let Some(target) = &input.target {
        record.has_target = 1;
        record.target_id = target.track_id.into();
        record.gap_m = target.gap_m;
        record.relative_speed_mps = target.relative_speed_mps;
        record.target_acceleration_mps2 = target.acceleration_mps2;
        record.target_age_s = target.age_s;
    }
    for (signal, place) in input.signals.iter().flatten().zip(&mut record.signals) {
        record.signal_count += 1;
        let count = signal.count.min(LAW_INTERVALS);
        (place.id, place.distance_m) = (signal.id.into(), signal.distance_m);
        place.interval_count = count as u64;
        for (interval, place) in signal.intervals[..count].iter().zip(&mut place.intervals) {
            place.phase = match interval.phase {
                Phase::Unknown => 0,
                Phase::Green => 1,
                Phase::Yellow => 2,
                Phase::Red => 3,
            };
            place.ends_in_s = interval.ends_in_s;
        }
    }
    if let Some(powertrain) = &input.powertrain {
        record.has_powertrain = 1;
        record.gear = powertrain.gear as u64 + 1;
        record.since_shift_s = powertrain.since_shift_s;
        record.engine_torque_nm = powertrain.engine_torque_nm;
        record.grade = powertrain.grade;
    }
    if let Some(preview) = &input.preview {
        record.cell_count = preview.count.min(LAW_CELLS) as u64;
        (record.first_cell_m, record.cell_m) = (preview.start_m, preview.cell_m);
        record.cell_grades = preview.grades;
    }
    record
}

/// Fault of an answer that no vehicle can follow: the field, and the expected value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Refused(pub(super) String);

/// Takes an answer into `output`; its requests are brought within `bounds`.
///
/// # Errors
/// [`Refused`], with `output` as it was.
pub(super) fn accept(
    answer: &LawAnswer,
    bounds: Bounds,
    output: &mut Output,
) -> Result<(), Refused> {
    let finite = |name: &str, value: f64| match value.is_finite() {
        true => Ok(()),
        false => Err(Refused(format!("{name} = {value}, expected a finite number"))),
    };
    let at_most = |name: &str, value: u64, most: usize| match value <= most as u64 {
        true => Ok(value as usize),
        false => Err(Refused(format!("{name} = {value}, expected at most {most}"))),
    };
    finite("request_mps2", answer.request_mps2)?;
    let mode = at_most("mode", answer.mode, LAW_MODES - 1)?;
    let count = at_most("plan_count", answer.plan_count, LAW_PLAN)?;
    // Names are made for what is refused alone: a step allocates nothing.
    if let Some(index) = answer.plan_mps2[..count].iter().position(|value| !value.is_finite()) {
        finite(&format!("plan_mps2[{index}]"), answer.plan_mps2[index])?;
    }
    let torque = match answer.has_torque {
        0 => None,
        _ => {
            finite("engine_torque_nm", answer.engine_torque_nm)?;
            finite("service_brake_n", answer.service_brake_n)?;
            let gear = at_most("gear", answer.gear, 64)?;
            Some(Demand {
                engine_torque_nm: answer.engine_torque_nm,
                service_brake_n: answer.service_brake_n.max(0.0),
                gear: gear.checked_sub(1),
            })
        }
    };
    *output = Output { mode: mode as u32, torque, ..Output::default() };
    output.plan_mps2[0] = bounds.bring_in(answer.request_mps2);
    for (place, request) in output.plan_mps2[1..].iter_mut().zip(&answer.plan_mps2[..count]) {
        *place = bounds.bring_in(*request);
    }
    output.plan_len = count + 1;
    output.figures = answer.figures;
    output.bound_figures();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{PhaseInterval, Powertrain, Preview, SignalAhead, Target};

    const BOUNDS: Bounds = Bounds { least_mps2: -4.0, most_mps2: 2.0 };

    #[test]
    fn a_question_has_all_inputs_of_a_law() {
        let signal = |distance_m| {
            let mut signal =
                SignalAhead { id: 257, distance_m, count: 1, ..SignalAhead::default() };
            signal.intervals[0] = PhaseInterval { phase: Phase::Red, ends_in_s: 7.0 };
            Some(signal)
        };
        let input = Input {
            time_s: 3.0,
            target: Some(Target { track_id: 9, gap_m: 40.0, age_s: 0.02, ..Target::default() }),
            signals: [signal(50.0), signal(300.0), None, None],
            powertrain: Some(Powertrain { gear: 4, grade: 0.01, ..Powertrain::default() }),
            preview: Some(Preview { count: 2, ..Preview::default() }),
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        };
        let record = question(&input, 12, true);
        assert_eq!((record.sequence, record.reset, record.time_s), (12, 1, 3.0));
        assert_eq!((record.has_target, record.target_id, record.gap_m), (1, 9, 40.0));
        assert_eq!((record.signal_count, record.signals[1].distance_m), (2, 300.0));
        assert_eq!(
            (record.signals[0].interval_count, record.signals[0].intervals[0].phase),
            (1, 3)
        );
        assert_eq!((record.has_powertrain, record.gear, record.cell_count), (1, 5, 2));
        assert!(record.speed_limit_mps.is_infinite());
        let nothing = question(&Input::default(), 1, false);
        assert_eq!((nothing.has_target, nothing.signal_count, nothing.gear), (0, 0, 0));
    }

    #[test]
    fn an_answer_is_bounded_and_a_short_one_has_defaults() {
        let mut output = Output { mode: 7, plan_len: 40, ..Output::default() };
        let mut answer = LawAnswer { request_mps2: -30.0, ..LawAnswer::zeroed() };
        accept(&answer, BOUNDS, &mut output).expect("a vehicle can follow it");
        assert_eq!(output, Output { plan_mps2: output.plan_mps2, ..Output::default() });
        assert_eq!(output.plan_mps2[..2], [-4.0, 0.0]);
        answer.plan_count = 2;
        (answer.plan_mps2[0], answer.plan_mps2[1]) = (9.0, -1.0);
        (answer.has_torque, answer.gear, answer.figures[3]) = (1, 3, f64::NAN);
        accept(&answer, BOUNDS, &mut output).expect("a vehicle can follow it");
        assert_eq!((output.plan_len, output.plan_mps2[1], output.plan_mps2[2]), (3, 2.0, -1.0));
        assert_eq!(output.torque.expect("asked for").gear, Some(2));
        assert_eq!(output.figures[3], 0.0);
    }

    #[test]
    fn a_value_that_no_vehicle_can_follow_is_refused_by_its_name() {
        let good = LawAnswer::zeroed();
        let refused = |answer: LawAnswer| {
            let mut output = Output { mode: 5, ..Output::default() };
            let why = accept(&answer, BOUNDS, &mut output).expect_err("refused").0;
            assert_eq!(output.mode, 5, "left as it was");
            why
        };
        assert!(refused(LawAnswer { request_mps2: f64::NAN, ..good }).contains("request_mps2"));
        assert!(refused(LawAnswer { mode: 8, ..good }).contains("at most 7"));
        assert!(refused(LawAnswer { plan_count: 97, ..good }).contains("plan_count"));
        let mut plan = LawAnswer { plan_count: 1, ..good };
        plan.plan_mps2[0] = f64::INFINITY;
        assert!(refused(plan).contains("plan_mps2[0]"));
        let torque = LawAnswer { has_torque: 1, engine_torque_nm: f64::NAN, ..good };
        assert!(refused(torque).contains("engine_torque_nm"));
    }
}
