//! The topics of a road with a plan, and the speed along it.

use crate::curve_speed::{Cells, CurveSpeed, OwnWay, RoadAhead};
use crate::law::Input;
use messages::{Course, Curves, LateralMotion};
use runtime::{Runtime, RuntimeError, Subscriber};
use scenario::Scenario;
use scenario::sumo_traffic::Limit;

/// Periods of the radar after which a course is of no use.
const STALE_PERIODS: f64 = 4.0;

/// Topics about the road ahead.
pub(super) struct CurveTopics {
    lateral: Subscriber<LateralMotion>,
    course: Subscriber<Course>,
    pub(super) map: Subscriber<Curves>,
    stale_s: f64,
    own: OwnWay,
    speed: CurveSpeed,
    /// Speed limits along the road.
    limits: Vec<Limit>,
}

impl CurveTopics {
    /// Opens the topics; `None` where nothing caps the speed in curves.
    pub(super) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        let keys = &scenario.controller.curve_speed;
        if scenario.road.plan().is_none() || !keys.enabled {
            return Ok(None);
        }
        Ok(Some(Self {
            lateral: runtime.subscriber()?,
            course: runtime.subscriber()?,
            map: runtime.subscriber()?,
            stale_s: STALE_PERIODS * f64::from(scenario.perception.period_ms.value()) / 1e3
                + f64::from(scenario.perception.radar.latency_ms.value()) / 1e3,
            own: OwnWay::default(),
            speed: CurveSpeed::new(keys),
            limits: scenario.traffic.route.as_ref().map_or_else(Vec::new, |r| r.limits.clone()),
        }))
    }

    pub(super) fn update(&mut self, runtime: &Runtime) -> Result<(), RuntimeError> {
        runtime.update(&mut self.lateral)?;
        runtime.update(&mut self.course)?;
        runtime.update(&mut self.map)
    }

    /// Caps the set speed of `input`. `requested_mps2` is what the last command asked for.
    pub(super) fn cap(&mut self, input: &mut Input, requested_mps2: f64) {
        let own_perm = self.lateral.newest().and_then(|sample| {
            self.own.take(sample.yaw_rate_radps, input.ego.speed_mps, input.period_s)
        });
        let map = self.map.newest().map(|map| Cells {
            first_m: map.first_cell_m - input.ego.position_m,
            cell_m: map.cell_m,
            curvatures_perm: map.curvatures(),
        });
        let course = self.course.newest().filter(|course| {
            let age_s = input.time_s - course.header.acquisition_ns as f64 / 1e9;
            course.valid_m > 0.0 && age_s <= self.stale_s
        });
        let (limits, place_m) = (&self.limits[..], input.ego.position_m);
        let road = RoadAhead { own_perm, course, map, limits, place_m };
        self.speed.cap(input, &road, requested_mps2);
    }

    /// The law's largest request in a curve, m/s²; infinite elsewhere.
    pub(super) fn most_mps2(&self) -> f64 {
        self.speed.most_mps2()
    }
}
