//! What a planner is asked and what it answers. Both are plain values without pointers, so that they
//! can cross to another thread as they are.

use super::preview::Preview;

/// Most segments of a plan.
pub const MAX_SEGMENTS: usize = 24;

/// A question to a planner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanRequest {
    /// Number of the request; the plan carries it back.
    pub number: u64,
    /// Time of the request, s.
    pub time_s: f64,
    /// Position of the truck, m.
    pub position_m: f64,
    /// Speed of the truck, m/s.
    pub speed_mps: f64,
    /// Gear, counted from 0.
    pub gear: usize,
    /// Torque at the crankshaft, N m.
    pub engine_torque_nm: f64,
    /// Driver's set speed, m/s.
    pub set_speed_mps: f64,
    /// Legal limit, m/s (infinite when unknown).
    pub speed_limit_mps: f64,
    /// Price of time relative to the one of the flat, beta / beta_0.
    pub time_price: f64,
    /// The road ahead.
    pub preview: Preview,
}

impl PlanRequest {
    /// Highest speed of the plan, m/s: 5 km/h above the set speed and within the limit.
    #[must_use]
    pub fn max_speed_mps(&self) -> f64 {
        max_speed_mps(self.set_speed_mps, self.speed_limit_mps)
    }

    /// Lowest speed of the plan where the truck can hold it, m/s: 13 km/h below the set speed.
    #[must_use]
    pub fn min_speed_mps(&self) -> f64 {
        min_speed_mps(self.set_speed_mps).min(self.max_speed_mps())
    }
}

/// Highest speed that is planned, m/s.
pub(crate) fn max_speed_mps(set_speed_mps: f64, speed_limit_mps: f64) -> f64 {
    (set_speed_mps + ABOVE_SET_MPS).min(speed_limit_mps)
}

/// Lowest speed that is planned where the truck can hold it, m/s.
pub(crate) fn min_speed_mps(set_speed_mps: f64) -> f64 {
    set_speed_mps - BELOW_SET_MPS
}

/// How far a plan may exceed the set speed, m/s.
const ABOVE_SET_MPS: f64 = 5.0 / 3.6;
/// How far it may fall below (62 km/h at a set speed of 75 km/h), m/s.
const BELOW_SET_MPS: f64 = 13.0 / 3.6;

/// Constant torque over a stretch of road.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// Where it ends, m.
    pub end_m: f64,
    /// Torque at the crankshaft, N m.
    pub engine_torque_nm: f64,
    /// Gear, counted from 0; `None` leaves it to the gearbox.
    pub gear: Option<usize>,
    /// Kinetic energy at its end per unit of mass, v²/2, m²/s².
    pub end_speed2_half: f64,
}

/// A planner's answer: what to do from `start_m` on, and what speed comes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Number of the request that it answers.
    pub number: u64,
    /// Time of that request, s.
    pub time_s: f64,
    /// Where it starts, m.
    pub start_m: f64,
    /// Speed there, m/s.
    pub start_speed_mps: f64,
    /// Segments in order; `len` are valid.
    pub segments: [Segment; MAX_SEGMENTS],
    /// Number of valid segments; 0 when there is no plan.
    pub len: usize,
    /// Of these, how many may be driven before the road is planned anew.
    pub binding: usize,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            number: 0,
            time_s: 0.0,
            start_m: 0.0,
            start_speed_mps: 0.0,
            segments: [Segment::default(); MAX_SEGMENTS],
            len: 0,
            binding: 0,
        }
    }
}

impl Plan {
    /// Empties it as the answer to a request.
    pub(crate) fn begin(&mut self, request: &PlanRequest) {
        self.number = request.number;
        self.time_s = request.time_s;
        self.start_m = request.position_m;
        self.start_speed_mps = request.speed_mps;
        self.len = 0;
        self.binding = 0;
    }

    /// Appends a segment.
    pub(crate) fn push(
        &mut self,
        end_m: f64,
        engine_torque_nm: f64,
        gear: Option<usize>,
        speed_mps: f64,
    ) {
        let end_speed2_half = 0.5 * speed_mps * speed_mps;
        self.segments[self.len] = Segment { end_m, engine_torque_nm, gear, end_speed2_half };
        self.len += 1;
    }

    /// Index of the segment at a position; `None` outside.
    #[must_use]
    pub fn segment_at(&self, position_m: f64) -> Option<usize> {
        if position_m.is_nan() || position_m < self.start_m {
            return None;
        }
        self.segments[..self.len].iter().position(|segment| position_m < segment.end_m)
    }

    /// Where the plan ends, m.
    #[must_use]
    pub fn end_m(&self) -> f64 {
        self.segments[..self.len].last().map_or(self.start_m, |segment| segment.end_m)
    }

    /// Planned speed at a position in segment `index`, m/s: energy is linear within a segment.
    #[must_use]
    pub fn speed_mps(&self, index: usize, position_m: f64) -> f64 {
        let (start_m, start) = self.start_of(index);
        let segment = &self.segments[index];
        let share = ((position_m - start_m) / (segment.end_m - start_m)).clamp(0.0, 1.0);
        (2.0 * (start + share * (segment.end_speed2_half - start))).max(0.0).sqrt()
    }

    /// Planned acceleration in segment `index`, m/s².
    #[must_use]
    pub fn acceleration_mps2(&self, index: usize) -> f64 {
        let (start_m, start) = self.start_of(index);
        let segment = &self.segments[index];
        (segment.end_speed2_half - start) / (segment.end_m - start_m)
    }

    /// Position and v²/2 at the start of a segment.
    fn start_of(&self, index: usize) -> (f64, f64) {
        match index.checked_sub(1) {
            Some(before) => (self.segments[before].end_m, self.segments[before].end_speed2_half),
            None => (self.start_m, 0.5 * self.start_speed_mps * self.start_speed_mps),
        }
    }
}

/// Plans speed, torque and gear over the road ahead. Allocates only when it is made.
pub trait Planner: Send {
    /// Answers a request. `false`, and an empty plan, when there is none: the road is not known far
    /// enough, or the truck is too slow or too fast to plan for.
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool;
}
