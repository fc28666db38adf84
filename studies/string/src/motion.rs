//! A car's true motion, which the next car sees.

use scenario::Scenario;
use scenario::actor::MAX_PROFILE_POINTS;
use scenario::quantity::{Speed, Time};
use scenario::speeds::SpeedPoint;
use supervise::report::Outcome;
use supervise::{Drive, DriveStep};

/// Points that a motion may have beside those of a stop after a collision.
const MAX_POINTS: usize = MAX_PROFILE_POINTS - 1_000;

/// A car's true speed over time. Between two points it is a straight line. So the position is off by no more than `h²
/// |Δa| / 12`: 0.02 mm at the plant's period of 10 ms, 0.1 mm at 20 ms.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion(Vec<SpeedPoint>);

impl Motion {
    /// The motion in a drive. It has a point for every step of the plant, or as many as a table of speeds may have. A
    /// car that collided brakes as hard as it can, since a vehicle stands in its way.
    pub fn of(scenario: &Scenario, drive: &Drive, outcome: Outcome) -> Self {
        let steps = &drive.steps;
        let point_of = |step: &DriveStep| point(step.time_s, step.speed_mps);
        let strided = steps.iter().step_by(stride(steps.len()));
        let mut points: Vec<SpeedPoint> = strided.map(point_of).collect();
        if let Some(last) = steps.last()
            && points.last().is_none_or(|point| point.0.value() < last.time_s)
        {
            points.push(point_of(last));
        }
        if let (Outcome::Collision, Some(last)) = (outcome, steps.last()) {
            let braking_mps2 = -scenario.plant.min_acceleration_mps2.value();
            let stands_s = last.time_s + (last.speed_mps / braking_mps2).max(1e-3);
            points.push(SpeedPoint(time(stands_s), Speed::of(0.0)));
        }
        if points.is_empty() {
            points.push(SpeedPoint(time(0.0), scenario.plant.initial_speed_mps));
        }
        Self(points)
    }

    /// One that never changes its speed.
    #[cfg(test)]
    pub fn constant(speed_mps: f64) -> Self {
        Self(vec![SpeedPoint(time(0.0), Speed::of(speed_mps))])
    }

    pub fn points(&self) -> &[SpeedPoint] {
        &self.0
    }
}

/// Steps from one point to the next, if a drive has at least this number.
fn stride(steps: usize) -> usize {
    steps.div_ceil(MAX_POINTS).max(1)
}

fn point(time_s: f64, speed_mps: f64) -> SpeedPoint {
    let speed_mps = Speed::try_from(speed_mps.clamp(0.0, 100.0));
    SpeedPoint(time(time_s), speed_mps.expect("inside the range"))
}

fn time(time_s: f64) -> Time {
    Time::try_from(time_s.clamp(0.0, 86_400.0)).expect("inside the range")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(steps: u32) -> Drive {
        let step = |k: u32| DriveStep {
            time_s: f64::from(k) * 0.01,
            speed_mps: 20.0 - f64::from(k % 100) * 0.01,
            ..DriveStep::default()
        };
        Drive { steps: (0..=steps).map(step).collect(), ..Drive::default() }
    }

    fn scenario() -> Scenario {
        Scenario::parse("x", "schema_version = 1\nname = \"x\"").expect("a scenario")
    }

    #[test]
    fn every_step_is_a_point_while_there_is_room() {
        let motion = Motion::of(&scenario(), &drive(1000), Outcome::Completed);
        assert_eq!(motion.points().len(), 1001);
        let long = Motion::of(&scenario(), &drive(30_000), Outcome::Completed);
        assert_eq!(long.points().len(), 15_001);
        assert_eq!(long.points().last().map(|point| point.0.value()), Some(300.0));
    }

    #[test]
    fn after_a_collision_a_car_brakes_to_a_stand() {
        let motion = Motion::of(&scenario(), &drive(1000), Outcome::Collision);
        let [.., before, last] = motion.points() else { panic!("two points") };
        assert_eq!(last.1.value(), 0.0);
        let braking = before.1.value() / (last.0.value() - before.0.value());
        assert!((braking - 9.0).abs() < 1e-9, "the plant's strongest: {braking}");
    }
}
