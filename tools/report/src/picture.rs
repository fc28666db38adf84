//! Series over run time, from which the pictures of a run are drawn.

use crate::lateral::LateralSeries;
use crate::plane::PlaneView;
use crate::print;
use controller::laws;
use messages::level::{Level, Levels};
use messages::{AllVehicles, Service};
use runtime::statistics::QuantileCurve;
use scenario::Scenario;
use scenario::grade::GradeProfile;
use scenario::v2x::Phase;
use std::collections::BTreeMap;
use supervise::report::{ControllerReport, Payload, PlantReport, WorstChain};
use supervise::{Drive, DriveStep, FaultRecord, GroupOutcome, RequirementVerdict};
use v2x_sim::program::Program;

/// Run time in s and value. A value that is not finite begins a gap.
pub type Points = Vec<(f64, f64)>;

#[derive(Clone, Debug, Default)]
pub struct RunPicture {
    /// Run time reached, s.
    pub duration_s: f64,
    pub set_speed_mps: f64,
    pub speed_limit_mps: Option<f64>,
    /// Ego front bumper along the road, m.
    pub position_m: Points,
    pub speed_mps: Points,
    pub acceleration_mps2: Points,
    pub request_mps2: Points,
    /// Request after the gateway's bounds, m/s².
    pub applied_mps2: Points,
    /// Speed of the vehicle ahead, m/s.
    pub lead_speed_mps: Points,
    /// Gap to the vehicle ahead, m.
    pub gap_m: Points,
    /// Gap that the law aims at, m.
    pub desired_gap_m: Points,
    /// Time gap to the vehicle ahead at 1 m/s and faster, s.
    pub time_gap_s: Points,
    /// Time to collision while the ego approaches, s.
    pub time_to_collision_s: Points,
    /// Difference of two acceleration samples over their time, m/s³.
    pub jerk_mps3: Points,
    /// Height of the road below the ego, m; empty on a level road.
    pub height_m: Points,
    /// Grade of the road there, %, positive uphill.
    pub grade_percent: Points,
    /// The drive from above, on a road with a plan.
    pub plane: Option<PlaneView>,
    /// Its motion across the road; empty without a plan.
    pub lateral: LateralSeries,
    /// Gear of a truck, counted from 1.
    pub gear: Points,
    /// Torque of its engine at the crankshaft, kN m.
    pub engine_torque_knm: Points,
    pub service_brake_kn: Points,
    /// The other vehicles.
    pub actors: Vec<ActorPath>,
    pub signals: Vec<SignalPhases>,
    pub modes: Vec<Phased>,
    pub quality: Vec<Phased>,
    /// Degradation levels, by service.
    pub rungs: BTreeMap<&'static str, Vec<Phased>>,
    /// Faults, in order of time.
    pub faults: Vec<FaultMark>,
    /// Instants that decide the requirements.
    pub decided: Vec<Decided>,
    /// Distributions of the reaction time and its parts, by name.
    pub latencies: BTreeMap<String, QuantileCurve>,
    /// The chains with the longest reaction times, longest first.
    pub worst_chains: Vec<WorstChain>,
}

/// Path of another vehicle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ActorPath {
    pub name: String,
    /// Rear bumper along the road while its body reaches into the ego's lane, m.
    pub in_lane_m: Points,
    /// Rear bumper along the road otherwise, m.
    pub beside_m: Points,
}

#[derive(Clone, Debug, PartialEq)]
pub struct SignalPhases {
    pub name: String,
    /// Stop line along the road, m.
    pub stop_line_m: f64,
    /// Begin and end in s, and phase.
    pub phases: Vec<(f64, f64, Phase)>,
}

/// A time of constant state.
#[derive(Clone, Debug, PartialEq)]
pub struct Phased {
    pub from_s: f64,
    pub to_s: f64,
    pub label: String,
}

#[derive(Clone, Debug, PartialEq)]
pub struct FaultMark {
    /// Run time, s.
    pub t_s: f64,
    /// Kind and target.
    pub label: String,
    /// Effect and end, as far as known.
    pub outcome: String,
}

/// The instant that decides a requirement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decided {
    /// Run time, s.
    pub at_s: f64,
    pub letter: char,
    /// True if the requirement holds.
    pub met: bool,
}

/// Letter of a scenario's requirement by its place; more than 26 share the last one.
pub fn letter(place: usize) -> char {
    ('A'..='Z').nth(place).unwrap_or('Z')
}

impl RunPicture {
    /// This picture with the instants that decide requirements.
    pub fn judged(self, verdicts: &[RequirementVerdict]) -> Self {
        let decided = verdicts.iter().enumerate().filter(|(_, verdict)| verdict.margin.is_some());
        let decided = decided.map(|(place, verdict)| Decided {
            at_s: verdict.at_s,
            letter: letter(place),
            met: verdict.met,
        });
        Self { decided: decided.collect(), ..self }
    }

    /// The picture of a run from the launcher's records.
    pub fn of(scenario: &Scenario, group: &GroupOutcome) -> Self {
        let modes = group.formulation(scenario).map_or(&[][..], |law| law.modes);
        let mut run = Self::of_modes(scenario, &group.drive, modes);
        let mark = |record: &FaultRecord| FaultMark {
            t_s: record.t_s,
            label: print::fault_name(record),
            outcome: print::fault_outcome(record),
        };
        run.faults = group.faults.iter().map(mark).collect();
        run.faults.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        let details = |service| group.reports.get(&service).map(|report| &report.details);
        if let Some(plant) = details(Service::Plant).and_then(Payload::read::<PlantReport>) {
            let curves =
                plant.histograms.iter().map(|(name, h)| (name.clone(), h.quantile_curve()));
            run.latencies = curves.collect();
            run.worst_chains = plant.worst_chains;
            run.rungs.insert(Service::Plant.name(), phases_of(&plant.rungs, run.duration_s));
        }
        let controller = details(Service::Controller);
        if let Some(controller) = controller.and_then(Payload::read::<ControllerReport>) {
            let phases = phases_of(&controller.rungs, run.duration_s);
            run.rungs.insert(Service::Controller.name(), phases);
        }
        run
    }

    /// The picture of a drive alone.
    pub fn of_drive(scenario: &Scenario, drive: &Drive) -> Self {
        Self::of_modes(scenario, drive, laws::mode_names(scenario))
    }

    fn of_modes(scenario: &Scenario, drive: &Drive, modes: &[&str]) -> Self {
        let steps = &drive.steps;
        let duration_s = steps.last().map_or(0.0, |step| step.time_s);
        let series = |value: fn(&DriveStep) -> Option<f64>| -> Points {
            steps.iter().filter_map(|step| value(step).map(|value| (step.time_s, value))).collect()
        };
        // Ground truth of the other vehicles comes in some steps only. Only there does a missing gap mean that
        // no vehicle is ahead.
        let heard: std::collections::BTreeSet<u64> =
            drive.vehicles.iter().map(|truth| truth.header.step).collect();
        let told: Vec<_> = steps.iter().filter(|step| heard.contains(&step.step)).collect();
        let ahead = |value: fn(&DriveStep) -> Option<f64>| -> Points {
            told.iter().map(|step| (step.time_s, value(step).unwrap_or(f64::NAN))).collect()
        };
        let mode = |mode: u32| {
            modes.get(mode as usize).map_or_else(|| format!("mode {mode}"), ToString::to_string)
        };
        let quality = |quality: u32| match quality {
            0 => "full".to_owned(),
            1 => "relaxed".to_owned(),
            3 => "fall-back".to_owned(),
            _ => "backup".to_owned(),
        };
        let road = scenario.road.profile().ok().filter(|road| !road.points().is_empty());
        let of_road = |value: &dyn Fn(&GradeProfile, f64) -> f64| -> Points {
            let road = road.iter();
            let along = |road| steps.iter().map(move |s| (s.time_s, value(road, s.position_m)));
            road.flat_map(along).collect()
        };
        Self {
            duration_s,
            set_speed_mps: scenario.set_speed_mps.value(),
            speed_limit_mps: scenario.speed_limit_mps.map(|limit| limit.value()),
            position_m: series(|step| Some(step.position_m)),
            speed_mps: series(|step| Some(step.speed_mps)),
            acceleration_mps2: series(|step| Some(step.acceleration_mps2)),
            request_mps2: series(|step| step.request_mps2),
            applied_mps2: series(|step| Some(step.applied_mps2)),
            lead_speed_mps: ahead(|step| step.lead_speed_mps),
            gap_m: ahead(|step| step.gap_m),
            desired_gap_m: desired_gap(scenario, drive),
            time_gap_s: ahead(DriveStep::time_gap_s),
            time_to_collision_s: series(|step| Some(step.time_to_collision_s)),
            jerk_mps3: jerk(steps),
            height_m: of_road(&GradeProfile::height_m),
            grade_percent: of_road(&|road, position_m| 100.0 * road.grade(position_m)),
            plane: PlaneView::of(scenario, drive),
            lateral: LateralSeries::of(&drive.plane),
            gear: series(|step| step.powertrain.map(|p| f64::from(p.gear))),
            engine_torque_knm: series(|step| step.powertrain.map(|p| p.engine_torque_nm / 1e3)),
            service_brake_kn: series(|step| step.powertrain.map(|p| p.service_brake_n / 1e3)),
            actors: actors(scenario, &drive.vehicles),
            signals: signals(scenario, duration_s),
            modes: phases(steps.iter().filter_map(|s| Some((s.time_s, s.mode?))), duration_s, mode),
            quality: phases(
                steps.iter().filter_map(|step| Some((step.time_s, step.quality?))),
                duration_s,
                quality,
            ),
            rungs: BTreeMap::new(),
            faults: Vec::new(),
            decided: Vec::new(),
            latencies: BTreeMap::new(),
            worst_chains: Vec::new(),
        }
    }
}

/// Degradation levels of a service, from the start to `until_s`.
fn phases_of(levels: &Levels, until_s: f64) -> Vec<Phased> {
    let first = levels.changes.first().map_or(Level::Full, |change| change.from);
    let changes = levels.changes.iter().map(|change| (change.t_s, change.to));
    phases([(0.0, first)].into_iter().chain(changes), until_s, |level| level.name().to_owned())
}

/// Jerk at the later of two steps; not a number where none is defined.
fn jerk(steps: &[DriveStep]) -> Points {
    let pairs = steps.windows(2).filter(|pair| pair[1].time_s > pair[0].time_s);
    pairs.map(|pair| (pair[1].time_s, pair[1].jerk_since(&pair[0]).unwrap_or(f64::NAN))).collect()
}

/// Gap that the law aims at, while a vehicle is ahead.
fn desired_gap(scenario: &Scenario, drive: &Drive) -> Points {
    let desired = laws::desired_gap(scenario);
    let error = laws::gap_error_figure(scenario);
    let steps = drive.steps.iter();
    steps
        .filter_map(|step| {
            let gap_m = step.gap_m?;
            let by_law = || Some(gap_m - step.figures?[error?]);
            let known = desired.map(|desired| desired.at(step.speed_mps));
            Some((step.time_s, known.or_else(by_law)?))
        })
        .collect()
}

/// Paths of the other vehicles. Ground truth lists the present ones in the scenario's order.
fn actors(scenario: &Scenario, truths: &[AllVehicles]) -> Vec<ActorPath> {
    let mut paths: Vec<ActorPath> = (scenario.actors.iter())
        .map(|actor| ActorPath { name: actor.name.as_str().into(), ..ActorPath::default() })
        .collect();
    for truth in truths {
        let time_ns = truth.header.acquisition_ns.unsigned_abs();
        let time_s = time_ns as f64 / 1e9;
        let mut vehicles = truth.vehicles.iter();
        for (path, actor) in paths.iter_mut().zip(&scenario.actors) {
            let leaves_ns = actor.leaves_at_s.map_or(u64::MAX, |time| time.nanoseconds());
            let present = (actor.appears_at_s.nanoseconds()..leaves_ns).contains(&time_ns);
            let vehicle = if present { vehicles.next() } else { None };
            let nowhere = (time_s, f64::NAN);
            let place = vehicle.map_or(nowhere, |vehicle| (time_s, vehicle.rear_position_m));
            let in_lane = vehicle.is_some_and(|vehicle| vehicle.in_lane != 0);
            path.in_lane_m.push(if in_lane { place } else { nowhere });
            path.beside_m.push(if in_lane { nowhere } else { place });
        }
    }
    paths
}

/// Phases of the signals' programs within `duration_s`.
fn signals(scenario: &Scenario, duration_s: f64) -> Vec<SignalPhases> {
    let signals = scenario.v2x.signals.iter();
    signals
        .map(|signal| {
            let mut from_s = 0.0;
            let mut phases = Vec::new();
            for interval in Program::new(signal).intervals(0) {
                let to_s = interval.end_ns.map_or(duration_s, |end| end as f64 / 1e9);
                let to_s = to_s.min(duration_s);
                if to_s > from_s {
                    phases.push((from_s, to_s, interval.phase));
                }
                from_s = to_s;
                if from_s >= duration_s {
                    break;
                }
            }
            SignalPhases {
                name: format!("signal {}", signal.intersection_id.value()),
                stop_line_m: signal.stop_line_m.value(),
                phases,
            }
        })
        .collect()
}

/// Times of a constant sampled value, each up to the next sample that differs.
fn phases<T: PartialEq + Copy>(
    samples: impl Iterator<Item = (f64, T)>,
    until_s: f64,
    name: impl Fn(T) -> String,
) -> Vec<Phased> {
    let mut phases: Vec<Phased> = Vec::new();
    let mut last = None;
    for (time_s, value) in samples {
        if last == Some(value) {
            continue;
        }
        if let Some(before) = phases.last_mut() {
            before.to_s = time_s;
        }
        phases.push(Phased { from_s: time_s, to_s: until_s, label: name(value) });
        last = Some(value);
    }
    phases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_become_phases_up_to_the_end() {
        let samples = [(0.0, 1), (0.1, 1), (0.2, 2), (0.3, 1)];
        let phases = phases(samples.into_iter(), 0.4, |value| value.to_string());
        let spans: Vec<_> = phases.iter().map(|p| (p.from_s, p.to_s, p.label.as_str())).collect();
        assert_eq!(spans, [(0.0, 0.2, "1"), (0.2, 0.3, "2"), (0.3, 0.4, "1")]);
    }

    #[test]
    fn a_signal_shows_its_program_and_ends_with_the_run() {
        let scenario = Scenario::open("corridor", &Default::default(), &|_| Ok(Default::default()));
        let scenario = scenario.expect("built in");
        let signals = signals(&scenario, 100.0);
        assert_eq!(signals.len(), 3);
        for signal in &signals {
            let joined = signal.phases.windows(2).all(|pair| pair[0].1 == pair[1].0);
            assert!(joined && signal.phases[0].0 == 0.0, "{signal:?}");
            assert_eq!(signal.phases.last().map(|phase| phase.1), Some(100.0));
        }
        assert_eq!(signals[0].phases[1], (27.0, 30.0, Phase::Yellow));
    }
}
