//! The service's part of a road with a plan: the ego's place in the plane, and the course that is sent.

use std::array::from_fn;
use std::sync::Arc;

use messages::{COURSE_CELL_M, Course, Curves, EgoPose, EgoTruth, Header, LateralMotion};
use road::{Axis, Pose};
use runtime::{Publisher, Release, Runtime, RuntimeError, Subscriber};
use scenario::Scenario;
use scenario::perception::CourseSource;

use crate::radar::scene::{Ego, PlaneEgo};
use crate::tracking::road_ahead::RoadAhead;
use crate::tracking::sources::{MapAhead, Sources};

/// Age beyond which a measurement of the yaw rate is not used, ns.
const STALE_NS: i64 = 200_000_000;
/// Standard deviation of the course's place up to which the course is used, m: a quarter of a lane.
const USEFUL_M: f64 = 0.9;
/// Farthest distance to which it is used, m, and the steps of the search for it.
const FARTHEST_M: u32 = 150;
const STEP_M: u32 = 10;

/// Step of the ego's heading to the road, rad: far above rounding errors, far below all that a radar shows.
const HEADING_STEP_RAD: f64 = 1e-9;

/// The ports, and what stays the same over the drive.
pub(crate) struct PlanePorts {
    axis: Arc<Axis>,
    start: Pose,
    /// Distance from the centre of gravity to the front bumper, m.
    to_bumper_m: f64,
    lateral: Subscriber<LateralMotion>,
    pose: Subscriber<EgoPose>,
    curves: Subscriber<Curves>,
    course: Publisher<Course>,
}

/// The sources that a scenario chooses; none without a plan of the road.
pub(crate) fn sources(scenario: &Scenario) -> Sources {
    let uses = |source| scenario.road.plan().is_some() && scenario.perception.course.uses(source);
    Sources {
        yaw_rate: uses(CourseSource::YawRate),
        standing: uses(CourseSource::Standing),
        trails: uses(CourseSource::Trails),
        map: uses(CourseSource::Map),
    }
}

impl PlanePorts {
    /// Opens the ports; `None` without a plan of the road.
    pub(crate) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        let Some(plan) = scenario.road.plan() else { return Ok(None) };
        let (plant, keys) = (&scenario.plant, &scenario.plant.lateral);
        let wheelbase_m = keys.wheelbase_m.value();
        let overhang_m = 0.5 * (plant.length_m.value() - wheelbase_m).max(0.0);
        Ok(Some(Self {
            axis: Arc::new(plan.axis().clone()),
            start: plan.start.pose(),
            to_bumper_m: keys.cg_share.value() * wheelbase_m + overhang_m,
            lateral: runtime.subscriber()?,
            pose: runtime.subscriber()?,
            curves: runtime.subscriber()?,
            course: runtime.publisher()?,
        }))
    }

    pub(crate) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        runtime.update(&mut self.lateral)?;
        runtime.update(&mut self.pose)?;
        runtime.update(&mut self.curves)
    }

    /// The ego in the plane at a release, where the radar measures from; `truth` is the newest one.
    pub(crate) fn ego(&self, ego: &Ego, truth: Option<&EgoTruth>, release: &Release) -> PlaneEgo {
        let told = self
            .lateral
            .newest()
            .filter(|lateral| release.scheduled_ns - lateral.header.acquisition_ns <= STALE_NS);
        let told_yaw_rate_radps = told.map(|lateral| lateral.yaw_rate_radps);
        let (Some(pose), Some(truth)) = (self.pose.newest(), truth) else {
            // Before the first message the ego is where it starts.
            let curvature_perm = self.axis.curvature_perm(ego.position_m);
            return PlaneEgo {
                pose: self.axis.pose(ego.position_m),
                velocity_mps: (ego.speed_mps, 0.0),
                yaw_rate_radps: curvature_perm * ego.speed_mps,
                told_yaw_rate_radps: Some(curvature_perm * ego.speed_mps),
            };
        };
        let before = self.axis.pose(truth.position_m);
        // The road's place in the plane adds rounding errors; a drive does not depend on them.
        let askew_rad = pose.heading_rad - self.start.heading_rad - before.heading_rad;
        let askew_rad = (askew_rad / HEADING_STEP_RAD).round() * HEADING_STEP_RAD;
        let age_s = (release.time_s - pose.header.acquisition_ns as f64 * 1e-9).max(0.0);
        let sideways_mps =
            ego.speed_mps * libm::tan(pose.side_slip_rad) + self.to_bumper_m * pose.yaw_rate_radps;
        let turned_rad = (pose.yaw_rate_radps - pose.curvature_perm * ego.speed_mps) * age_s;
        let aside_mps = ego.speed_mps * askew_rad + sideways_mps;
        let here = self.axis.point(ego.position_m, pose.lateral_m + aside_mps * age_s);
        PlaneEgo {
            pose: Pose { heading_rad: here.heading_rad + askew_rad + turned_rad, ..here },
            velocity_mps: (ego.speed_mps, sideways_mps),
            yaw_rate_radps: pose.yaw_rate_radps,
            told_yaw_rate_radps,
        }
    }

    /// The map ahead of an ego by its odometry.
    pub(crate) fn map(&self, told: Option<Ego>) -> Option<MapAhead<'_>> {
        let (curves, told) = (self.curves.newest()?, told?);
        Some(MapAhead {
            curvatures_perm: curves.curvatures(),
            first_m: curves.first_cell_m + 0.5 * curves.cell_m - told.position_m,
            cell_m: curves.cell_m,
        })
    }

    /// Sends the course of a scan; without one it is not valid.
    pub(crate) fn send(
        &mut self,
        header: Header,
        ahead: Option<&RoadAhead>,
    ) -> Result<(), RuntimeError> {
        self.course.send_with(|message| {
            message.header = header;
            if let Some(ahead) = ahead.filter(|ahead| !ahead.course().is_straight) {
                write(message, ahead);
            }
        })?;
        Ok(())
    }
}

fn write(message: &mut Course, ahead: &RoadAhead) {
    let [heading_rad, curvature_perm, rate_perm2] = ahead.clothoid();
    message.heading_rad = heading_rad;
    message.curvature_perm = curvature_perm;
    message.curvature_rate_perm2 = rate_perm2;
    let middle_m = |cell: usize| (cell as f64 + 0.5) * COURSE_CELL_M;
    message.curvatures_perm = from_fn(|cell| ahead.course().curvature_perm(middle_m(cell)));
    message.sigma_50_m = ahead.sigma_m(50.0);
    message.sigma_100_m = ahead.sigma_m(100.0);
    let is_useful = |steps: &u32| ahead.sigma_m(f64::from(steps * STEP_M)) <= USEFUL_M;
    let steps = (1..=FARTHEST_M / STEP_M).take_while(is_useful).count();
    message.valid_m = (steps as u32 * STEP_M).into();
}
