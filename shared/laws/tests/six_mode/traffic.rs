//! Random traffic: noise, cut-ins, cut-outs, emergency braking, stop and go.

use super::plant::{Actor, DT, advance_ego, ask, input};
use law::{Ego, Law};
use laws::six_mode::{Mode, Parameters, SixMode};
use rand_core::Rng;
use rand_pcg::Pcg32;

const DURATION: f64 = 120.0;
/// Lag of the acceleration that a tracker estimates, s.
const TRACKER_LAG: f64 = 0.3;
const RUNS: u64 = 1000;
/// Reaction of the driver whose full braking says what physics allow, s.
const REACTION: f64 = 0.3;
/// Most mode changes in any minute of any run.
const CHANGES_PER_MINUTE: usize = 40;

fn uniform(rng: &mut Pcg32, low: f64, high: f64) -> f64 {
    low + (high - low) * f64::from(rng.next_u32()) / f64::from(u32::MAX)
}

/// A car that changes its acceleration at random, up to an emergency stop at a_p.
#[derive(Clone)]
struct Car {
    actor: Actor,
    rng: Pcg32,
    acceleration: f64,
    until: f64,
}

impl Car {
    fn new(id: u32, position: f64, speed: f64, rng: Pcg32) -> Self {
        Self { actor: Actor { id, position, speed }, rng, acceleration: 0.0, until: 0.0 }
    }

    /// Acceleration of the car; 0 for one that stands.
    fn acceleration(&self) -> f64 {
        if self.actor.speed > 0.0 { self.acceleration } else { 0.0 }
    }

    fn advance(&mut self, time: f64, hardest: f64) {
        if time >= self.until {
            let rng = &mut self.rng;
            self.acceleration = match rng.next_u32() % 8 {
                0 => -uniform(rng, 2.0, hardest),
                1 | 2 => -uniform(rng, 0.2, 2.0),
                3..=5 => uniform(rng, 0.2, 2.0),
                _ => 0.0,
            };
            self.until = time + uniform(rng, 0.5, 7.0);
        }
        let top = if self.actor.speed >= 35.0 { 0.0 } else { self.acceleration };
        self.actor.advance(self.acceleration.min(top));
    }
}

/// Ego and the car ahead of it, if any.
#[derive(Clone)]
struct World {
    time: f64,
    ego: Ego,
    lag: f64,
    car: Option<Car>,
}

impl World {
    fn advance(&mut self, request: f64, hardest: f64) {
        advance_ego(&mut self.ego, request, self.lag);
        if let Some(car) = &mut self.car {
            car.advance(self.time, hardest);
        }
        self.time += DT;
    }

    fn gap(&self) -> f64 {
        self.car.as_ref().map_or(f64::INFINITY, |c| c.actor.position - self.ego.position_m)
    }

    /// True if a driver who brakes fully after [`REACTION`] gets away without contact.
    fn avoidable(&self, braking: f64, hardest: f64) -> bool {
        let mut world = self.clone();
        let from = self.time + REACTION;
        while world.ego.speed_mps > 0.0 {
            let request = if world.time >= from { -braking } else { 0.0 };
            world.advance(request, hardest);
            if world.gap() <= 0.0 {
                return false;
            }
        }
        true
    }
}

#[derive(Default)]
struct Tally {
    encounters: usize,
    excused: usize,
    /// Contacts that full braking after [`REACTION`] would have avoided when the car came.
    contacts: usize,
    avoid_entries: usize,
    /// Mode changes in the busiest minute of each run.
    busiest: Vec<usize>,
    least_gap: f64,
}

/// One run; panics if the law breaks a guarantee.
fn run(seed: u64, p: &Parameters, tally: &mut Tally) {
    let mut rng = Pcg32::new(seed, 7);
    let mut law = SixMode::new(p.clone()).expect("the parameters are valid");
    let (low, high) = law.request_bounds_mps2();
    let hardest = p.lead_braking_mps2;
    let speed = uniform(&mut rng, 0.0, 33.0);
    let set_speed = uniform(&mut rng, 8.0, 36.0);
    let lag = uniform(&mut rng, 0.1, 0.4);
    let steps = [5, 10][seed as usize % 2];
    let period = steps as f64 * DT;
    let ego = Ego { speed_mps: speed, ..Ego::default() };
    let mut world = World { time: 0.0, ego, lag, car: None };
    let mut ids = 0;
    let mut next_event = 0.0;
    let (mut request, mut estimate) = (0.0, 0.0);
    let mut previous: Option<(u32, f64)> = None;
    let mut change_times: Vec<f64> = Vec::new();
    for step in 0..(DURATION / DT) as u64 {
        if world.time >= next_event {
            next_event = world.time + uniform(&mut rng, 5.0, 30.0);
            ids += 1;
            let ego = world.ego;
            world.car = match rng.next_u32() % 5 {
                0 => None,
                1 => {
                    // A cut-in, which may be far too close.
                    let gap = uniform(&mut rng, 3.0, 50.0);
                    let speed = (ego.speed_mps + uniform(&mut rng, -8.0, 6.0)).max(0.0);
                    let car = Pcg32::new(seed, 100 + u64::from(ids));
                    Some(Car::new(ids, ego.position_m + gap, speed, car))
                }
                _ => {
                    let gap = uniform(&mut rng, 30.0, 200.0);
                    let speed = uniform(&mut rng, 0.0, 33.0);
                    let car = Pcg32::new(seed, 100 + u64::from(ids));
                    Some(Car::new(ids, ego.position_m + gap, speed, car))
                }
            };
            tally.encounters += usize::from(world.car.is_some());
            if !world.avoidable(p.braking_mps2, hardest) {
                // No driver could have: take that car away again.
                tally.excused += 1;
                world.car = None;
            }
        }
        let real = world.car.as_ref().map_or(0.0, Car::acceleration);
        estimate += (real - estimate) * DT / TRACKER_LAG;
        if step % steps == 0 {
            let target = world.car.as_ref().map(|c| {
                let mut t = c.actor.seen_from(&world.ego);
                t.gap_m += uniform(&mut rng, -0.5, 0.5);
                t.relative_speed_mps += uniform(&mut rng, -0.17, 0.17);
                t.acceleration_mps2 = estimate;
                t
            });
            let out = ask(&mut law, &input(world.time, period, set_speed, world.ego, target));
            request = out.request_mps2();
            assert!((low..=high).contains(&request), "seed {seed}: request {request}");
            if let Some((mode, before)) = previous {
                let rate = (request - before) / period;
                let limit = 1e-9
                    + if out.mode == Mode::Avoid as u32 {
                        p.emergency_jerk_limit_mps3
                    } else {
                        p.jerk_limit_mps3
                    };
                assert!(rate >= -limit, "seed {seed} at {:.1}: jerk {rate}", world.time);
                assert!(
                    rate <= limit || out.mode == Mode::Avoid as u32,
                    "seed {seed} at {:.1}: jerk {rate}",
                    world.time
                );
                if mode != out.mode {
                    change_times.push(world.time);
                    tally.avoid_entries += usize::from(out.mode == Mode::Avoid as u32);
                }
            }
            previous = Some((out.mode, request));
        }
        world.advance(request, hardest);
        tally.least_gap = tally.least_gap.min(world.gap());
        if world.gap() <= 0.0 {
            tally.contacts += 1;
            world.car = None;
        }
    }
    let minute_from =
        |i: usize| change_times[i..].iter().take_while(|t| **t < change_times[i] + 60.0).count();
    tally.busiest.push((0..change_times.len()).map(minute_from).max().unwrap_or(0));
}

#[test]
fn random_traffic_keeps_every_guarantee() {
    let mut tally = Tally { least_gap: f64::INFINITY, ..Tally::default() };
    for seed in 0..RUNS {
        run(seed, &Parameters::default(), &mut tally);
    }
    tally.busiest.sort_unstable();
    let (median, most) = (tally.busiest[RUNS as usize / 2], tally.busiest[RUNS as usize - 1]);
    println!(
        "{RUNS} runs of {DURATION} s: {} cars met, {} of them unavoidable, {} contacts, {} entries into avoid, \
         least gap {:.2} m; mode changes in a run's busiest minute: median {median}, most {most}",
        tally.encounters, tally.excused, tally.contacts, tally.avoid_entries, tally.least_gap
    );
    // A gap that a cut-in leaves is opened gently. So the worst braking of the lead can meet a small gap.
    assert!(
        tally.contacts * 100 <= tally.encounters - tally.excused,
        "{} contacts",
        tally.contacts
    );
    assert!(tally.avoid_entries > 200, "the traffic is too tame to prove anything");
    assert!(tally.excused < tally.encounters / 10, "the traffic is beyond physics");
    assert!(most <= CHANGES_PER_MINUTE, "{most} changes in a minute");
}
