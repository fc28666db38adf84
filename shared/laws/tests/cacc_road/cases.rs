//! Random cases, and what counts as survivable and as comfortable.
//!
//! Survivable: at the start, and when a vehicle appears ahead, full braking begun at once keeps 2 m from it. Full
//! braking is 4.9 m/s² behind the lag of 0.5 s. The vehicle ahead brakes at 4 m/s² from that moment. Leads never brake
//! harder. The first line is farther than the full braking distance. A jump can end a green at once, but never its
//! yellow of at least 3 s. It can shorten or stretch a red. Signals do not jump while they are silent, and each was
//! received at least once.
//!
//! Comfortable: a constant request of -2 m/s² from each event on would have been enough. Events are start, jump,
//! silence, change of yellow, braking lead and an appearing vehicle. Enough means three things. The ego would have
//! stopped 1 m before the nearest line, or crossed before red at the speed kept. It would have kept 2 m from the lead:
//! from its real drive, and from its motion at the event. All the way it would have kept a safe gap: full braking
//! survives a lead that brakes at 4 m/s².

use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::world::{Event, Lead, PERIOD_S, Signal, World};

/// A world and what happens in it.
pub(crate) struct Case {
    pub(crate) world: World,
    pub(crate) seconds: f64,
    pub(crate) random: Random,
    pub(crate) kind: Kind,
}

/// Course of the lead, and other events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kind {
    pub(crate) lead_obeys: bool,
    pub(crate) wild_lead: bool,
    pub(crate) jumps: bool,
    pub(crate) silences: bool,
}

pub(crate) struct Random(Pcg64Mcg);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    pub(crate) fn unit(&mut self) -> f64 {
        random::uniform(&mut self.0)
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }
}

/// Distance and time to stop from a speed and acceleration with a constant request, by small steps.
pub(crate) fn stop(v: f64, a: f64, u: f64) -> f64 {
    let (mut x, mut v, mut a) = (0.0, v, a);
    let dt = 0.01;
    while v > 0.0 {
        a += dt / 0.5 * (u - a);
        v += dt * a;
        x += dt * v.max(0.0);
    }
    x
}

/// True if full braking from now on keeps `margin` from a lead that brakes at 4 m/s².
pub(crate) fn survives(v: f64, a: f64, gap: f64, v_lead: f64, margin: f64) -> bool {
    let (mut x, mut v, mut a) = (0.0, v, a);
    let (mut x_lead, mut v_lead) = (gap, v_lead);
    let dt = 0.02;
    while v > 0.0 {
        if x_lead - x < margin {
            return false;
        }
        a += dt / 0.5 * (-4.9 - a);
        v += dt * a;
        x += dt * v.max(0.0);
        x_lead += dt * v_lead;
        v_lead = (v_lead - dt * 4.0).max(0.0);
    }
    x_lead - x >= margin
}

impl Case {
    pub(crate) fn new(seed: u64) -> Self {
        let mut r = Random::new(seed);
        let set = r.between(8.0, 22.0);
        let v = if r.chance(0.2) { 0.0 } else { r.between(0.0, set) };
        let mut world = World::new(v, set);
        let mut line = stop(v, 0.0, -4.9) + r.between(5.0, 220.0);
        let count = 1 + (r.unit() * 3.0) as usize;
        for i in 0..count {
            let lengths_s = [r.between(5.0, 30.0), r.between(3.0, 4.5), r.between(5.0, 30.0)];
            let phase = (r.unit() * 3.0) as usize;
            let left_s = r.between(0.05, lengths_s[phase]);
            world.signals.push(Signal {
                id: 256 + i as u32,
                line_m: line,
                lengths_s,
                phase,
                left_s,
            });
            line += r.between(40.0, 250.0);
        }
        // A yellow that has begun may leave neither a stop nor a crossing.
        let first = &mut world.signals[0];
        if first.phase == 1 && first.left_s * v < first.line_m + 5.0 {
            first.left_s = first.lengths_s[1];
        }
        let kind = Kind {
            lead_obeys: r.chance(0.5),
            wild_lead: r.chance(0.5),
            jumps: r.chance(0.5),
            silences: r.chance(0.3),
        };
        if r.chance(0.75) {
            let event = appear(&mut r, &world);
            world.apply(event);
        }
        Self { world, seconds: 60.0, random: r, kind }
    }

    /// Event of this step.
    pub(crate) fn events(&mut self) -> Vec<Event> {
        let (r, world) = (&mut self.random, &self.world);
        let mut events = Vec::new();
        if self.kind.jumps && world.silence == 0 && r.chance(0.01) {
            let signal = (r.unit() * world.signals.len() as f64) as usize;
            let s = &world.signals[signal];
            match s.phase {
                0 => events.push(Event::Jump { signal, left_s: s.left_s * r.unit() + 1e-3 }),
                2 => events.push(Event::Jump { signal, left_s: r.between(0.2, 20.0) }),
                _ => {}
            }
        }
        if self.kind.silences {
            if world.silence == 0 && world.time_s > 0.5 * PERIOD_S && r.chance(0.005) {
                events.push(Event::Silence { unknown: r.chance(0.5) });
            } else if world.silence != 0 && r.chance(0.02) {
                events.push(Event::Heard);
            }
        }
        match &world.lead {
            Some(lead) => {
                if r.chance(0.003) {
                    events.push(Event::LeadLeaves);
                } else if let Some(a) = drive(r, lead, world, self.kind) {
                    events.push(Event::LeadAccelerates(a));
                }
            }
            None if r.chance(0.005) => events.push(appear(r, world)),
            None => {}
        }
        events
    }
}

fn appear(r: &mut Random, world: &World) -> Event {
    let ego = &world.ego;
    let speed_mps = if r.chance(0.2) { 0.0 } else { r.between(0.0, 22.0) };
    let mut gap_m = r.between(4.0, 120.0);
    while !survives(ego.speed_mps, ego.acceleration_mps2.max(0.0), gap_m, speed_mps, 2.0) {
        gap_m += 5.0;
    }
    Event::LeadAppears { gap_m, speed_mps }
}

/// The lead's next acceleration, when it changes.
fn drive(r: &mut Random, lead: &Lead, world: &World, kind: Kind) -> Option<f64> {
    let v = lead.speed_mps;
    if kind.lead_obeys {
        let closed = world.signals.iter().find(|s| s.line_m > lead.position_m && s.phase != 0);
        if let Some(signal) = closed {
            let needed = v * v / (2.0 * (signal.line_m - lead.position_m).max(0.1));
            if needed > 1.5 && needed < 4.0 {
                return Some(-needed);
            }
        }
    }
    let steps = 1.0 / PERIOD_S;
    if v <= 0.0 && lead.acceleration_mps2 <= 0.0 {
        return r.chance(0.2 / steps).then(|| r.between(0.5, 2.5));
    }
    if v > 22.0 && lead.acceleration_mps2 > 0.0 {
        return Some(0.0);
    }
    if !r.chance(0.4 / steps) {
        return None;
    }
    Some(if kind.wild_lead && r.chance(0.4) {
        r.between(-4.0, 2.5)
    } else if r.chance(0.3) {
        0.0
    } else {
        r.between(-1.5, 1.5)
    })
}
