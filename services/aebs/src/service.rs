//! The emergency brake's loop: released by the radar's detections, or by its timer when they are late.

use crate::decision::{Decision, Demand, Settings};
use crate::objects::Objects;
use crate::prediction::{Authority, Ego};
use crate::sight::Sight;
use crate::way::Way;
use messages::{
    Brake, BrakeState, Course, Header, LateralMotion, Odometry, Origins, RadarDetections, Service,
    ServiceState,
};
use runtime::statistics::{Latencies, Percentiles};
use runtime::{
    Clock, Count, Cycle, Figures, Group, Publisher, Release, Runtime, RuntimeError, Subscriber,
    monotonic_ns,
};
use scenario::Scenario;
use scenario::lateral::LateralModel;
use serde::{Deserialize, Serialize};

/// Periods of the radar after which its detections are of no use.
const STALE_PERIODS: i64 = 4;
/// Age at which odometry is of no use, ns.
const STALE_ODOMETRY_NS: i64 = 100_000_000;
/// Least difference of the speeds of odometry and the radar's scan that the time in between cannot explain, m/s. The
/// second value is the largest acceleration, m/s².
const DISAGREES_MPS: f64 = 1.0;
const MAX_MPS2: f64 = 12.0;

/// Posts on each side of a kilometre from which a scan always shows one.
const POSTS_PER_KM: f64 = 40.0;

/// Names of what outlives the process.
const DECIDE: &str = "decide";
const LATE: &str = "late";

/// Figures of the loop of the emergency brake, which it reports at its end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AebsReport {
    /// Deadline after each scheduled release, µs.
    pub deadline_us: f64,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: u64,
    /// Time for objects and decision, on the wall clock in both modes.
    pub decide_us: Option<Percentiles>,
}

/// Runs the emergency brake in its group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut aebs = Aebs::open(&mut runtime, &scenario)?;
    runtime.begin(&scenario)?;
    runtime.run_cycles(|runtime| aebs.cycle(runtime))?;
    // A release left out is a deadline missed.
    let misses = aebs.late.get() + runtime.skipped();
    runtime.finish(report(&scenario, misses, aebs.decide.percentiles_us()))
}

/// Sum of the reports of all processes of a run's emergency brake, which left out `skipped` releases.
pub fn last_known(group: &Group, scenario: &Scenario, skipped: u64) -> AebsReport {
    let figures = Figures::of(group, Service::Aebs);
    let late = figures.count(LATE).map_or(0, |late| late.get());
    let decide = figures.latencies(DECIDE).ok();
    report(scenario, late + skipped, decide.and_then(|decide| decide.percentiles_us()))
}

fn report(scenario: &Scenario, misses: u64, decide_us: Option<Percentiles>) -> AebsReport {
    let deadline_us = f64::from(scenario.aebs.deadline_ms.value()) * 1e3;
    AebsReport { deadline_us, deadline_misses: misses, decide_us }
}

pub fn settings(scenario: &Scenario) -> Settings {
    let keys = &scenario.aebs;
    Settings {
        authority: Authority {
            dead_time_s: 1e-9 * keys.dead_time_ms.nanoseconds() as f64,
            jerk_mps3: keys.jerk_mps3.value(),
            deceleration_mps2: keys.deceleration_mps2.value(),
        },
        horizon_s: keys.lateral_horizon_s.value(),
        period_s: 1e-3 * f64::from(scenario.perception.period_ms.value()),
        margin_m: keys.margin_m.value(),
        warning_s: keys.warning_s.value(),
        ego_length_m: scenario.plant.length_m.value(),
    }
}

/// The objects that a scenario's radar sees, none yet.
pub fn objects(scenario: &Scenario) -> Objects {
    Objects::new(0.5 * scenario.perception.radar.field_of_view_deg.value().to_radians())
}

/// Sight of a scenario's radar before its first scan.
pub fn sight(scenario: &Scenario) -> Sight {
    let posts_per_km = scenario.perception.radar.detections.standing_objects_per_km.value();
    Sight::new(posts_per_km >= POSTS_PER_KM)
}

/// The way ahead on a scenario's road, before its first yaw rate.
pub fn way(scenario: &Scenario) -> Way {
    if scenario.road.plan().is_none() || scenario.perception.course.sources.is_empty() {
        return Way::default();
    }
    let keys = &scenario.plant.lateral;
    match keys.model {
        // The axles stand in the middle of the body.
        LateralModel::SingleTrack => Way::new(
            0.5 * (keys.wheelbase_m.value() + scenario.plant.length_m.value()),
            keys.slip_rad_per_mps2.value(),
        ),
        LateralModel::OnAxis => Way::new(0.0, 0.0),
    }
}

struct Aebs {
    odometry: Subscriber<Odometry>,
    /// Present on a road with curves.
    road: Option<(Subscriber<LateralMotion>, Subscriber<Course>)>,
    way: Way,
    detections: Subscriber<RadarDetections>,
    brake: Publisher<Brake>,
    objects: Objects,
    sight: Sight,
    decision: Decision,
    deadline_ns: i64,
    period_ns: i64,
    stale_ns: i64,
    decide: Latencies,
    late: Count,
}

impl Aebs {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        let way = way(scenario);
        let road = match way.is_curved {
            true => Some((runtime.subscriber()?, runtime.subscriber()?)),
            false => None,
        };
        let period_ns = i64::from(scenario.perception.period_ms.value()) * 1_000_000;
        let latency_ns = i64::from(scenario.perception.radar.latency_ms.value()) * 1_000_000;
        Ok(Self {
            odometry: runtime.subscriber()?,
            road,
            way,
            detections: runtime.releasing_subscriber()?,
            brake: runtime.publisher()?,
            objects: objects(scenario),
            sight: sight(scenario),
            decision: Decision::new(settings(scenario)),
            deadline_ns: i64::from(scenario.aebs.deadline_ms.value()) * 1_000_000,
            period_ns,
            stale_ns: latency_ns + STALE_PERIODS * period_ns,
            decide: runtime.figures().latencies(DECIDE)?,
            late: runtime.figures().count(LATE)?,
        })
    }

    fn cycle(&mut self, runtime: &mut Runtime) -> Result<Cycle, RuntimeError> {
        // The timer releases a cycle if detections are late by half a period.
        let late_ns = self.period_ns / 2;
        let Some(release) = runtime.next_release_by(&mut self.detections, late_ns)? else {
            return Ok(Cycle::Last);
        };
        // The detections come last of all that a step makes wait for.
        runtime.update(&mut self.detections)?;
        runtime.update(&mut self.odometry)?;
        if let Some((lateral, course)) = &mut self.road {
            runtime.update(lateral)?;
            runtime.update(course)?;
        }
        let begun = monotonic_ns();
        let demand = self.demand(&release);
        self.decide.record_ns(monotonic_ns() - begun);
        let mut message = self.brake.loan()?;
        self.write(&mut message, runtime.clock(), &release, demand);
        let published_ns = self.brake.send(message)?;
        self.late.add(u64::from(published_ns - release.scheduled_ns > self.deadline_ns));
        let state = if demand.is_some() { ServiceState::Running } else { ServiceState::Degraded };
        runtime.end_cycle(state)?;
        Ok(Cycle::Next)
    }

    /// `None` without detections of use.
    fn demand(&mut self, release: &Release) -> Option<Demand> {
        let now_ns = release.scheduled_ns;
        let scan = self.detections.newest()?;
        let scanned_ns = scan.header.acquisition_ns;
        if now_ns - scanned_ns > self.stale_ns {
            return None;
        }
        let age_s = (now_ns - scanned_ns) as f64 / 1e9;
        let scanned_mps = scan.ego_speed_mps;
        let ego = self.ego(release, scanned_mps, age_s);
        self.sight.take_scan(scanned_ns, scan.detections());
        if let Some((lateral, course)) = &self.road {
            if let Some(sample) = lateral.newest() {
                self.way.take(sample.header.acquisition_ns, sample.yaw_rate_radps, scanned_mps);
            }
            self.way.look(scanned_ns, course.newest(), self.stale_ns);
        }
        let share = self.sight.expected_share();
        self.objects.take_scan(&self.way, share, scanned_ns, scanned_mps, scan.detections());
        let mean_mps = 0.5 * (scanned_mps + ego.speed_mps);
        let threats = self.objects.threats(self.decision.settings.horizon_s);
        let now = threats.map(|mut object| {
            object.predict(age_s, mean_mps);
            object
        });
        Some(self.decision.step(&ego, now))
    }

    /// The ego's motion by odometry. Odometry that is missing, or that does not fit what stands beside the road, is
    /// wrong: the radar's own speed then.
    fn ego(&self, release: &Release, scanned_mps: f64, age_s: f64) -> Ego {
        let stale_ns = STALE_ODOMETRY_NS.max(self.period_ns);
        let odometry = (self.odometry.newest())
            .filter(|sample| release.scheduled_ns - sample.header.acquisition_ns <= stale_ns);
        let ego = odometry.map(|sample| Ego {
            speed_mps: sample.moved_to(release.time_s).1,
            acceleration_mps2: sample.acceleration_mps2,
        });
        let differs = |ego: &Ego| (ego.speed_mps - scanned_mps).abs();
        ego.filter(|ego| differs(ego) <= DISAGREES_MPS + MAX_MPS2 * age_s)
            .unwrap_or(Ego { speed_mps: scanned_mps, acceleration_mps2: 0.0 })
    }

    fn write(&self, message: &mut Brake, clock: &Clock, release: &Release, demand: Option<Demand>) {
        let origins = Origins {
            odometry: self.odometry.origin(),
            radar: self.detections.origin(),
            ..Origins::NONE
        };
        let newest = self.detections.newest();
        message.header = Header::new(release.step, release.scheduled_ns, origins);
        message.radar_release_ns = newest.map_or(-1, |scan| clock.scheduled_ns(scan.header.step));
        message.idle_ns = release.idle_ns;
        message.start_ns = release.start_ns;
        // It brakes for what it still sees, but does not report itself available for the rest.
        let state = demand.map_or(BrakeState::Blind, |demand| demand.state);
        let is_idle = matches!(state, BrakeState::Monitoring | BrakeState::Warning);
        message.state =
            if is_idle && self.sight.is_blind { BrakeState::Blind } else { state } as u32;
        message.objects = u32::try_from(self.objects.confirmed().count()).unwrap_or(u32::MAX);
        let demand = demand.unwrap_or_default();
        message.deceleration_mps2 = demand.deceleration_mps2;
        (message.gap_m, message.relative_speed_mps, message.lateral_m) =
            demand.threat.unwrap_or_default();
    }
}
