//! Whether a comfortable solution existed: an independent computation on the recorded run.

use law::Ego;

use crate::cases::{stop, survives};
use crate::world::{Event, Lead, PERIOD_S, World};

/// Constant request of the comfortable reference, m/s².
const COMFORTABLE_MPS2: f64 = -2.0;
/// Distance that it keeps, to a lead and to a line, m.
const GAP_M: f64 = 2.0;
const LINE_M: f64 = 1.0;

struct Sample {
    ego: Ego,
    lead: Option<Lead>,
    /// Distance to the nearest line and time to its red; none when it is red.
    line: Option<(f64, Option<f64>)>,
    event: bool,
}

/// The run, step by step.
#[derive(Default)]
pub(crate) struct Record {
    samples: Vec<Sample>,
    braked_mps2: f64,
    last_phase: Option<(u32, usize)>,
}

impl Record {
    /// Notes the world at a release, after `events`.
    pub(crate) fn note(&mut self, world: &World, events: &[Event]) {
        let nearest = world.signals.iter().find(|s| s.line_m > world.ego.position_m);
        let line = nearest.map(|s| {
            let red_in = match s.phase {
                // A silent signal may be red: no way across it is certain.
                _ if world.silence != 0 => None,
                0 => Some(s.left_s + s.lengths_s[1]),
                1 => Some(s.left_s),
                _ => None,
            };
            (s.line_m - world.ego.position_m, red_in)
        });
        let phase = nearest.map(|s| (s.id, s.phase));
        let mut event = self.samples.is_empty() || (phase != self.last_phase);
        self.last_phase = phase;
        for e in events {
            event |= match e {
                Event::LeadAccelerates(a) => *a < self.braked_mps2 - 0.3,
                Event::Jump { .. } | Event::Silence { .. } | Event::LeadAppears { .. } => true,
                Event::Heard | Event::LeadLeaves => false,
            };
        }
        self.braked_mps2 = world.lead.map_or(0.0, |lead| lead.acceleration_mps2.min(0.0));
        self.samples.push(Sample { ego: world.ego, lead: world.lead, line, event });
    }

    /// True if there was a comfortable way on at every event.
    pub(crate) fn comfortable(&self) -> bool {
        (0..self.samples.len()).filter(|&i| self.samples[i].event).all(|i| self.exists(i))
    }

    fn exists(&self, i: usize) -> bool {
        let here = &self.samples[i];
        let (v, a) = (here.ego.speed_mps, here.ego.acceleration_mps2);
        if !self.clear_of_lead(i, COMFORTABLE_MPS2, usize::MAX) {
            return false;
        }
        let Some((distance, red_in)) = here.line else { return true };
        if stop(v, a, COMFORTABLE_MPS2) <= distance - LINE_M {
            return true;
        }
        let crossing = (distance / (v.max(0.1) * PERIOD_S)).ceil() as usize;
        red_in.is_some_and(|left| v * left >= distance + LINE_M)
            && self.clear_of_lead(i, 0.0, crossing)
    }

    /// True if a constant request keeps clear of the lead. It must do so in the lead's real drive, and in the motion
    /// that it had at the event. Gentle braking in the hope that a braking lead changes its mind is lucky, not
    /// comfortable. Number of clear steps that is enough.
    fn clear_of_lead(&self, i: usize, u: f64, steps: usize) -> bool {
        let Some(lead) = self.samples[i].lead else { return true };
        let real = self.samples[i..].iter().map(|later| later.lead);
        let mut expected = lead;
        let on = std::iter::repeat_with(|| {
            let now = expected;
            let a = now.acceleration_mps2.min(0.0);
            expected.speed_mps = (now.speed_mps + PERIOD_S * a).max(0.0);
            expected.position_m += 0.5 * PERIOD_S * (now.speed_mps + expected.speed_mps);
            Some(now)
        });
        let ego = self.samples[i].ego;
        keeps_clear(ego, lead.track, real, u, steps)
            && keeps_clear(ego, lead.track, on.take(600), u, steps)
    }
}

/// True if a constant request keeps clear of a lead. It must do so until the lead is gone, the ego stands, or the steps
/// are over.
fn keeps_clear(
    mut ego: Ego,
    track: u32,
    leads: impl Iterator<Item = Option<Lead>>,
    u: f64,
    steps: usize,
) -> bool {
    for (step, lead) in leads.enumerate() {
        if step >= steps {
            return true;
        }
        let Some(now) = lead.filter(|now| now.track == track) else { return true };
        let gap = now.position_m - ego.position_m;
        let (v, a) = (ego.speed_mps, ego.acceleration_mps2);
        if gap < GAP_M || !survives(v, a, gap, now.speed_mps, GAP_M) {
            return false;
        }
        if v <= 0.0 {
            return true;
        }
        let next = (v + PERIOD_S * a).max(0.0);
        ego.position_m += 0.5 * PERIOD_S * (v + next);
        ego.speed_mps = next;
        ego.acceleration_mps2 += PERIOD_S / 0.5 * (u - a);
    }
    // The record ends before the reference stands: not shown.
    false
}
