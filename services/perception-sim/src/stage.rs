//! Vehicles that a storyboard moves.
//!
//! The storyboard's world has the road's coordinates. The simulation's axis begins at the middle of the ego's front
//! bumper where the run starts. It points the way the ego faces.

use std::sync::Arc;

use openscenario::model::{Body, Drive};
use openscenario::world::{Extent, State, Way};
use openscenario::{Motion, World};
use scenario::Scenario;
use scenario::actor::Profile;

use crate::radar::scene::Ego;
use crate::vehicle::Vehicle;

/// A world with its place on the simulation's axis.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    world: World,
    /// The entity of each actor of the scenario.
    entities: Vec<usize>,
    start: Motion,
    /// 1 where the ego faces along the road, -1 where it faces against it.
    direction: f64,
    /// The ego's front bumper and the middle of its body at the start, m.
    front_s_m: f64,
    middle_t_m: f64,
    ego_width_m: f64,
    /// The ego's axis, where the storyboard's road has curves. Places count along it then.
    way: Option<Way>,
}

impl Stage {
    /// The storyboard of a scenario, where it has one.
    pub(crate) fn of(scenario: &Scenario, axis: Option<Arc<road::Axis>>) -> Option<Self> {
        let script = scenario.script()?;
        let ego = script.ego;
        let by_storyboard =
            scenario.actors.iter().any(|actor| actor.profile == Profile::Storyboard);
        let moved = |index: &usize| match by_storyboard {
            true => script.entities[*index].drive == Drive::Scripted,
            false => *index != ego,
        };
        let entities = (0..script.entities.len()).filter(moved).collect();
        let ego_width_m = script.entities[ego].body.width_m;
        let mut world = World::new(script).expect("the scenario has been checked");
        let start = world.motion(ego);
        let extent = world.extent(ego);
        let direction = start.direction();
        let front_s_m = extent.front_s_m(direction);
        let middle_t_m = 0.5 * (extent.from_t_m + extent.to_t_m);
        let line = scenario.road.plan().and_then(|plan| plan.opendrive.as_ref()?.line.as_ref());
        let line = line.filter(|_| scenario.storyboard.is_some());
        let way = line.map(|line| Way::of(&world, line).expect("the scenario has been checked"));
        if let Some(axis) = axis.filter(|_| way.is_none()) {
            world.bend((*axis).clone(), (front_s_m, middle_t_m));
        }
        Some(Self { entities, direction, front_s_m, middle_t_m, ego_width_m, way, world, start })
    }

    /// Brings the world to `time_ns`. `actors` are the scenario's; those that the storyboard moves are
    /// filled in, the others are taken from it.
    pub(crate) fn advance(&mut self, time_ns: u64, ego: &Ego, actors: &mut [Vehicle]) {
        self.world.observe(self.world.script().ego, self.motion_of_ego(ego));
        for (&entity, vehicle) in self.entities.iter().zip(&*actors) {
            if self.world.script().entities[entity].drive == Drive::External {
                self.world.observe(entity, self.motion_of(entity, vehicle));
            }
        }
        self.world.step(time_ns);
        for (&entity, vehicle) in self.entities.iter().zip(actors) {
            if self.world.script().entities[entity].drive == Drive::Scripted {
                *vehicle = self.vehicle(entity, ego.position_m);
            }
        }
    }

    /// The storyboard has come to its end.
    pub(crate) fn is_over(&self) -> bool {
        self.world.is_stopped()
    }

    /// The ego came to the end of the file's road.
    pub(crate) fn has_road_ended(&self) -> bool {
        self.world.has_road_ended()
    }

    /// Names of the storyboard's acts that have not started.
    pub(crate) fn unstarted_acts(&self) -> Vec<String> {
        self.world.unstarted_acts().map(str::to_owned).collect()
    }

    pub(crate) fn state(&self) -> &State {
        self.world.state()
    }

    pub(crate) fn restore(&mut self, state: State) {
        self.world.restore(state);
    }

    fn motion_of_ego(&self, ego: &Ego) -> Motion {
        let Ego { position_m, speed_mps, acceleration_mps2, .. } = *ego;
        let moved = Motion { speed_mps, acceleration_mps2, ..self.start };
        let script = self.world.script();
        let Some(way) = &self.way else {
            return Motion { s_m: self.start.s_m + self.direction * position_m, ..moved };
        };
        let body = &script.entities[script.ego].body;
        let front_m = body.center_ahead_m + 0.5 * body.length_m;
        let (s_m, t_m) = (position_m - front_m, -body.center_left_m);
        let near_s_m = self.world.motion(script.ego).s_m;
        way.on_road(&self.world, &Motion { s_m, t_m, heading_rad: 0.0, ..moved }, near_s_m)
    }

    /// A vehicle on the simulation's axis. `ego_m` is the ego's place there.
    fn vehicle(&self, entity: usize, ego_m: f64) -> Vehicle {
        let motion = self.world.motion(entity);
        if !motion.present {
            return Vehicle::default();
        }
        let Some(way) = &self.way else {
            let origin = (self.direction, self.front_s_m, self.middle_t_m);
            return self.seen(entity, motion, origin);
        };
        let ego = self.world.motion(self.world.script().ego);
        let near_m = ego_m + self.direction * (motion.s_m - ego.s_m);
        let along = way.along(&self.world, entity, near_m);
        let vehicle = self.seen(entity, along, (1.0, 0.0, 0.0));
        if motion.row == ego.row {
            return vehicle;
        }
        // One on another road may be at any angle to the axis.
        let Body { length_m, width_m, .. } = self.world.script().entities[entity].body;
        let turned_rad = libm::remainder(along.heading_rad, std::f64::consts::PI);
        Vehicle { length_m, width_m, turned_rad, ..vehicle }
    }

    /// A vehicle from its motion in coordinates in which the axis has a direction and an origin.
    fn seen(
        &self,
        entity: usize,
        motion: Motion,
        (direction, front_s_m, middle_t_m): (f64, f64, f64),
    ) -> Vehicle {
        let extent = Extent::of(&self.world.script().entities[entity].body, &motion);
        let rear_s_m = if direction > 0.0 { extent.from_s_m } else { extent.to_s_m };
        let own_t_m = 0.5 * (extent.from_t_m + extent.to_t_m);
        let width_m = extent.to_t_m - extent.from_t_m;
        let along = direction * libm::cos(motion.heading_rad);
        Vehicle {
            present: true,
            rear_position_m: direction * (rear_s_m - front_s_m),
            speed_mps: along * motion.speed_mps,
            acceleration_mps2: along * motion.acceleration_mps2,
            lateral_m: direction * (own_t_m - middle_t_m),
            lateral_speed_mps: direction
                * (motion.lateral_mps + motion.speed_mps * libm::sin(motion.heading_rad)),
            length_m: extent.to_s_m - extent.from_s_m,
            width_m,
            touches_within_m: 0.5 * (width_m + self.ego_width_m),
            turned_rad: 0.0,
        }
    }

    /// An actor with a profile, whose origin is at its rear bumper.
    fn motion_of(&self, entity: usize, vehicle: &Vehicle) -> Motion {
        let body = &self.world.script().entities[entity].body;
        let behind_m = 0.5 * body.length_m - body.center_ahead_m;
        Motion {
            present: vehicle.present,
            s_m: self.front_s_m + vehicle.rear_position_m + behind_m,
            t_m: self.middle_t_m + vehicle.lateral_m,
            speed_mps: vehicle.speed_mps,
            acceleration_mps2: vehicle.acceleration_mps2,
            ..Motion::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::Traffic;

    const CUT_IN: &str = r#"
        schema_version = 1
        name = "x"
        [plant]
        initial_speed_mps = 25
        [[actors]]
        name = "lorry"
        gap_m = 100
        initial_speed_mps = 20
        [[actors]]
        name = "car"
        gap_m = 60
        initial_speed_mps = 20
        lateral_offset_m = -3.5
        [[actors.events]]
        name = "cut-in"
        when = { gap_below_m = 30 }
        lateral = { to_m = 0, duration_s = 2 }
        speed = { to_mps = 16, rate_mps2 = 2 }
        [[actors.events]]
        when = { completed = "cut-in" }
        delay_s = 1
        lateral = { to_m = 3.5, duration_s = 2 }
        [[actors.events]]
        when = { gap_above_m = 40 }
        to = "lorry"
        delay_s = 100
        speed = { to_mps = 0, rate_mps2 = 2 }
    "#;

    /// The ego keeps `ego_mps`; gives (gap, car) for every 10 ms.
    fn drive(text: &str, ego_mps: f64, until_s: f64) -> Vec<(f64, Vehicle)> {
        let scenario = Scenario::parse("x.toml", text).unwrap_or_else(|error| panic!("{error}"));
        let mut traffic = Traffic::new(&scenario);
        (0..(until_s * 100.0) as u64)
            .map(|k| {
                let position_m = ego_mps * k as f64 * 0.01;
                let ego = Ego { position_m, speed_mps: ego_mps, acceleration_mps2: 0.0 };
                traffic.advance(k * 10_000_000, &ego);
                let car = traffic.vehicles()[1];
                (car.rear_position_m - position_m, car)
            })
            .collect()
    }

    #[test]
    fn a_cut_in_begins_at_its_gap_whatever_the_ego_does() {
        for ego_mps in [22.0, 25.0, 30.0] {
            let steps = drive(CUT_IN, ego_mps, 40.0);
            assert_eq!(steps[0].1.rear_position_m, 60.0);
            let begins = steps.iter().find(|(_, car)| car.lateral_m > -3.49).expect("it cuts in");
            // The first centimetre of a lane change takes some 0.06 s, at up to 14 m/s of closing speed.
            assert!((begins.0 - 30.0).abs() < 1.0, "{}", begins.0);
            let slowest = steps.iter().map(|(_, car)| car.speed_mps).fold(f64::INFINITY, f64::min);
            assert!((slowest - 16.0).abs() < 1e-9);
            let in_path = steps.iter().position(|(_, car)| car.in_ego_path()).expect("it is ahead");
            let last = steps.last().expect("there are steps").1;
            assert!(in_path > 0 && !last.in_ego_path());
            assert!((last.lateral_m - 3.5).abs() < 1e-9);
        }
    }

    #[test]
    fn profiles_beside_events_move_as_ever() {
        let scenario = Scenario::parse("x.toml", CUT_IN).expect("it is right");
        let mut traffic = Traffic::new(&scenario);
        for k in 0..=500 {
            traffic.advance(k * 10_000_000, &Ego::default());
        }
        assert!((traffic.vehicles()[0].rear_position_m - 200.0).abs() < 1e-8);
    }

    #[test]
    fn restored_traffic_goes_on_the_same_way() {
        let scenario = Scenario::parse("x.toml", CUT_IN).expect("it is right");
        let at = |k: u64| {
            let position_m = 0.25 * k as f64;
            (k * 10_000_000, Ego { position_m, speed_mps: 25.0, acceleration_mps2: 0.0 })
        };
        let mut whole = Traffic::new(&scenario);
        for k in 0..700 {
            let (time_ns, ego) = at(k);
            whole.advance(time_ns, &ego);
        }
        let mut next = Traffic::new(&scenario);
        next.restore(&whole.snapshot());
        for k in 700..1500 {
            let (time_ns, ego) = at(k);
            whole.advance(time_ns, &ego);
            next.advance(time_ns, &ego);
            assert_eq!(whole.vehicles(), next.vehicles());
        }
    }
}
