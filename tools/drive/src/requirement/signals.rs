//! The signals that requirements name, sampled from a drive.

use crate::{Drive, DriveStep};
use messages::{BrakeState, PhaseState};
use std::collections::BTreeSet;
use temporal_logic::{Signal, Unit};

/// A signal and its value in a step. Without a value in a step the last one holds.
struct Sampled {
    signal: Signal,
    value: fn(&DriveStep, &Context) -> Option<f64>,
}

/// The facts beside a step that its values depend on.
struct Context {
    /// The ground truth of the other vehicles is of this step: a gap that is missing means an empty road.
    sees: bool,
    /// The drive has messages of an emergency brake.
    has_brake: bool,
    set_speed_mps: f64,
}

const fn signal(
    name: &'static str,
    unit: Unit,
    value: fn(&DriveStep, &Context) -> Option<f64>,
) -> Sampled {
    Sampled { signal: Signal { name, unit }, value }
}

/// A value that exists behind a vehicle, and `without` on an empty road.
fn ahead(value: Option<f64>, without: f64, context: &Context) -> Option<f64> {
    value.or_else(|| context.sees.then_some(without))
}

const fn flag(holds: bool) -> Option<f64> {
    Some(if holds { 1.0 } else { 0.0 })
}

static ALL: [Sampled; 18] = [
    signal("time_s", Unit::SECOND, |step, _| Some(step.time_s)),
    signal("position_m", Unit::METRE, |step, _| Some(step.position_m)),
    signal("speed_mps", Unit::METRE_PER_SECOND, |step, _| Some(step.speed_mps)),
    signal("set_speed_mps", Unit::METRE_PER_SECOND, |_, context| Some(context.set_speed_mps)),
    signal("acceleration_mps2", Unit::METRE_PER_SECOND_SQUARED, |step, _| {
        Some(step.acceleration_mps2)
    }),
    signal("request_mps2", Unit::METRE_PER_SECOND_SQUARED, |step, _| step.request_mps2),
    signal("applied_mps2", Unit::METRE_PER_SECOND_SQUARED, |step, _| Some(step.applied_mps2)),
    // From two accelerations: `samples` fills it.
    signal("jerk_mps3", Unit::METRE_PER_SECOND_CUBED, |_, _| None),
    signal("gap_m", Unit::METRE, |step, context| ahead(step.gap_m, f64::INFINITY, context)),
    signal("time_gap_s", Unit::SECOND, |step, context| {
        let gap_s = step.gap_m.map(|_| step.time_gap_s().unwrap_or(f64::INFINITY));
        ahead(gap_s, f64::INFINITY, context)
    }),
    signal("lead_speed_mps", Unit::METRE_PER_SECOND, |step, context| {
        ahead(step.lead_speed_mps, f64::INFINITY, context)
    }),
    signal("lead_acceleration_mps2", Unit::METRE_PER_SECOND_SQUARED, |step, context| {
        ahead(step.lead_acceleration_mps2, f64::INFINITY, context)
    }),
    signal("ttc_s", Unit::SECOND, |step, _| Some(step.time_to_collision_s)),
    signal("stop_line_m", Unit::METRE, |step, _| Some(step.stop_line_m)),
    signal("is_red", Unit::ONE, |step, _| flag(step.signal == Some(PhaseState::StopAndRemain))),
    signal("is_yellow", Unit::ONE, |step, _| {
        flag(step.signal == Some(PhaseState::ProtectedClearance))
    }),
    signal("is_emergency_braking", Unit::ONE, |step, context| match step.brake {
        Some(state) => flag(matches!(state, BrakeState::Braking | BrakeState::Holding)),
        None if context.has_brake => None,
        None => flag(false),
    }),
    signal("is_cut_in", Unit::ONE, |step, _| flag(step.cut_in)),
];

/// The signals, in the order of a trace's samples.
pub(super) fn signals() -> Vec<Signal> {
    ALL.iter().map(|sampled| sampled.signal).collect()
}

/// The signals `read` of a drive on a grid of `period_s`; the others are left empty.
pub(super) struct Samples {
    pub begin_s: f64,
    pub period_s: f64,
    pub of: Vec<Vec<f64>>,
}

impl Samples {
    /// Samples a drive; `None` without a step.
    pub(super) fn of(drive: &Drive, read: &[usize], set_speed_mps: f64) -> Option<Self> {
        let (first, last) = (drive.steps.first()?, drive.steps.last()?);
        let between = drive.steps.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        // Steps of a long drive are thinned out, and single ones of a realtime run may be missing.
        let period_s = between.filter(|time_s| *time_s > 0.0).fold(f64::INFINITY, f64::min);
        let period_s = if period_s.is_finite() { period_s } else { 0.01 };
        let count = ((last.time_s - first.time_s) / period_s).round() as usize + 1;
        let heard: BTreeSet<u64> = drive.vehicles.iter().map(|truth| truth.header.step).collect();
        let has_brake = drive.steps.iter().any(|step| step.brake.is_some());
        let mut of = vec![Vec::new(); ALL.len()];
        for &index in read {
            of[index] = vec![f64::NAN; count];
        }
        for step in &drive.steps {
            let at = ((step.time_s - first.time_s) / period_s).round() as usize;
            let sees = heard.contains(&step.step);
            let context = Context { sees, has_brake, set_speed_mps };
            for &index in read {
                if let (Some(value), Some(sample)) =
                    ((ALL[index].value)(step, &context), of[index].get_mut(at))
                {
                    *sample = value;
                }
            }
        }
        for &index in read {
            match ALL[index].signal.name {
                "jerk_mps3" => of[index] = jerk(&drive.steps, first.time_s, period_s, count),
                _ => hold(&mut of[index]),
            }
        }
        let any = of.iter().map(Vec::len).max().unwrap_or(0).max(count);
        for samples in of.iter_mut().filter(|samples| samples.is_empty()) {
            *samples = vec![0.0; any];
        }
        Some(Self { begin_s: first.time_s, period_s, of })
    }
}

/// Fills samples without a value: the last one holds, and the first one before it.
fn hold(samples: &mut [f64]) {
    let Some(mut held) = samples.iter().copied().find(|sample| !sample.is_nan()) else { return };
    for sample in samples {
        if sample.is_nan() {
            *sample = held;
        }
        held = *sample;
    }
}

/// The jerk at the later of two steps; 0 where none is defined.
fn jerk(steps: &[DriveStep], begin_s: f64, period_s: f64, count: usize) -> Vec<f64> {
    let mut jerk = vec![0.0; count];
    for pair in steps.windows(2).filter(|pair| pair[1].time_s > pair[0].time_s) {
        let at = ((pair[1].time_s - begin_s) / period_s).round() as usize;
        if let (Some(sample), Some(found)) = (jerk.get_mut(at), pair[1].jerk_since(&pair[0])) {
            *sample = found;
        }
    }
    jerk
}
