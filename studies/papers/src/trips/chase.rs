//! Driving behind a lead, and what it costs.

use super::road::Road;
use super::trip::{CONTROL_PERIOD_S, Driver, SUBSTEPS, Seen};
use controller::law::Target;
use rand_pcg::Pcg64;
use truck_model::{Motion, Truck};

/// Farthest that the radar sees, m.
const RANGE_M: f64 = 200.0;

/// A driver with a radar.
pub trait Follower: Driver {
    /// Content of the radar from now on.
    fn show(&mut self, target: Option<Target>);

    /// Mode of the law; 0 for one without modes.
    fn mode(&self) -> u32 {
        0
    }
}

/// The vehicle ahead: a speed at the start and accelerations that end at the given times.
#[derive(Clone, Debug, PartialEq)]
pub struct Lead {
    /// Gap to it at the start, m.
    pub gap_m: f64,
    /// Its speed at the start, m/s.
    pub speed_mps: f64,
    /// (until, acceleration) in s and m/s², in order of time; it keeps its speed afterwards.
    pub accelerations: Vec<(f64, f64)>,
}

impl Lead {
    fn acceleration_mps2(&self, time_s: f64) -> f64 {
        let part = self.accelerations.iter().find(|(until_s, _)| time_s < *until_s);
        part.map_or(0.0, |part| part.1)
    }
}

/// Noise of the radar: standard deviations of gap and relative speed, m and m/s, and its seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the gap, m.
    pub gap_m: f64,
    /// Standard deviation of the relative speed, m/s.
    pub relative_speed_mps: f64,
    /// Seed.
    pub seed: u64,
}

/// One control period of a chase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time since the start, s.
    pub time_s: f64,
    /// Position of the truck, m.
    pub position_m: f64,
    /// Speed of the truck, m/s.
    pub speed_mps: f64,
    /// Acceleration of the truck, m/s².
    pub acceleration_mps2: f64,
    /// Speed of the lead, m/s.
    pub lead_mps: f64,
    /// Gap, m.
    pub gap_m: f64,
    /// Mode of the law.
    pub mode: u32,
    /// Torque at the crankshaft, N m.
    pub engine_torque_nm: f64,
    /// Force of the service brakes, N.
    pub service_brake_n: f64,
}

/// Result of a chase.
#[derive(Clone, Debug, PartialEq)]
pub struct Chase {
    /// Control periods, in order.
    pub moments: Vec<Moment>,
    /// Fuel burnt, g.
    pub fuel_g: f64,
    /// Kinetic energy at the end less that at the start, J.
    pub gained_j: f64,
    /// Work of the service brakes, J.
    pub service_brake_j: f64,
    /// Work of the engine brake beyond the drag, J.
    pub engine_brake_j: f64,
    /// Distance, m.
    pub length_m: f64,
}

impl Chase {
    /// Least time headway while the truck moves faster than 5 m/s, s.
    #[must_use]
    pub fn least_headway_s(&self) -> f64 {
        let moving = self.moments.iter().filter(|moment| moment.speed_mps > 5.0);
        moving.map(|moment| moment.gap_m / moment.speed_mps).fold(f64::INFINITY, f64::min)
    }

    /// Least gap, m.
    #[must_use]
    pub fn least_gap_m(&self) -> f64 {
        self.moments.iter().map(|moment| moment.gap_m).fold(f64::INFINITY, f64::min)
    }
}

/// Drives behind a lead for `duration_s`, or to the road's end.
#[must_use]
pub fn chase(
    truck: &Truck,
    road: &Road,
    start_mps: f64,
    lead: &Lead,
    noise: Option<Noise>,
    duration_s: f64,
    follower: &mut dyn Follower,
) -> Chase {
    let dt_s = CONTROL_PERIOD_S / SUBSTEPS as f64;
    let mut rng = noise.map(|noise| Pcg64::new(u128::from(noise.seed), 3));
    let mut motion = Motion::new(truck, 0.0, start_mps, road.grade(0.0));
    let (mut lead_m, mut lead_mps) = (lead.gap_m, lead.speed_mps);
    let mut moments = Vec::with_capacity((duration_s / CONTROL_PERIOD_S) as usize + 1);
    for period in 0..(duration_s / CONTROL_PERIOD_S) as u64 {
        let time_s = period as f64 * CONTROL_PERIOD_S;
        let lead_mps2 = lead.acceleration_mps2(time_s);
        let gap_m = lead_m - motion.position_m;
        let mut spread = |sigma: Option<f64>| match (&mut rng, sigma) {
            (Some(rng), Some(sigma)) => sigma * normal(rng),
            _ => 0.0,
        };
        let target = Target {
            track_id: 1,
            gap_m: gap_m + spread(noise.map(|noise| noise.gap_m)),
            relative_speed_mps: lead_mps - motion.speed_mps
                + spread(noise.map(|noise| noise.relative_speed_mps)),
            acceleration_mps2: lead_mps2,
            age_s: 0.0,
        };
        follower.show((gap_m < RANGE_M).then_some(target));
        let grade = road.grade(motion.position_m);
        let demand = follower.demand(&Seen { time_s, motion: &motion, grade });
        moments.push(Moment {
            time_s,
            position_m: motion.position_m,
            speed_mps: motion.speed_mps,
            acceleration_mps2: motion.acceleration_mps2,
            lead_mps,
            gap_m,
            mode: follower.mode(),
            engine_torque_nm: motion.engine_torque_nm,
            service_brake_n: demand.service_brake_n,
        });
        for _ in 0..SUBSTEPS {
            motion.step(truck, dt_s, &demand, road.grade(motion.position_m));
            let end_mps = (lead_mps + dt_s * lead_mps2).max(0.0);
            lead_m += 0.5 * dt_s * (lead_mps + end_mps);
            lead_mps = end_mps;
        }
        if motion.position_m >= road.length_m() {
            break;
        }
    }
    Chase {
        moments,
        fuel_g: motion.fuel_g,
        gained_j: truck.kinetic_energy_j(motion.speed_mps) - truck.kinetic_energy_j(start_mps),
        service_brake_j: motion.ledger.service_brake_j,
        engine_brake_j: motion.ledger.engine_brake_j,
        length_m: motion.position_m,
    }
}

/// Box and Muller.
fn normal(rng: &mut Pcg64) -> f64 {
    let (u, angle) = (random::open_uniform(rng), random::open_uniform(rng));
    random::box_muller(u, angle)
}
