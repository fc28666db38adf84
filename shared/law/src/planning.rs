//! Planning in the background of the control loop: what a planner is asked and what it answers.
//!
//! Request and plan are plain values without pointers, so that they can go to another thread as they
//! are.

use super::preview::Preview;

pub const MAX_SEGMENTS: usize = 24;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanRequest {
    /// Number of the request; the plan carries it back.
    pub number: u64,
    pub time_s: f64,
    pub position_m: f64,
    pub speed_mps: f64,
    /// Gear, counted from 0.
    pub gear: usize,
    pub engine_torque_nm: f64,
    pub set_speed_mps: f64,
    /// Legal limit, m/s (infinite when unknown).
    pub speed_limit_mps: f64,
    /// Price of time relative to the one of the flat, beta / beta_0.
    pub time_price: f64,
    pub preview: Preview,
}

/// Constant torque over a stretch of road.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    pub end_m: f64,
    pub engine_torque_nm: f64,
    /// Gear, counted from 0; `None` leaves it to the gearbox.
    pub gear: Option<usize>,
    /// Kinetic energy at its end per unit of mass, v²/2, m²/s².
    pub end_speed2_half: f64,
}

/// A planner's answer: what to do from `start_m` on, and what speed comes of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plan {
    /// Number of the request that it answers.
    pub number: u64,
    /// Time of that request, s.
    pub time_s: f64,
    pub start_m: f64,
    /// Speed there, m/s.
    pub start_speed_mps: f64,
    /// Segments in order; `len` are valid.
    pub segments: [Segment; MAX_SEGMENTS],
    /// Number of valid segments; 0 when there is no plan.
    pub len: usize,
    /// Number of these that may be driven before the road is planned anew.
    pub binding: usize,
}

impl Plan {
    /// Empties it as the answer to a request.
    pub fn begin(&mut self, request: &PlanRequest) {
        self.number = request.number;
        self.time_s = request.time_s;
        self.start_m = request.position_m;
        self.start_speed_mps = request.speed_mps;
        self.len = 0;
        self.binding = 0;
    }

    pub fn push(&mut self, end_m: f64, engine_torque_nm: f64, gear: Option<usize>, speed_mps: f64) {
        let end_speed2_half = 0.5 * speed_mps * speed_mps;
        self.segments[self.len] = Segment { end_m, engine_torque_nm, gear, end_speed2_half };
        self.len += 1;
    }

    /// Index of the segment at a position; `None` outside.
    pub fn segment_at(&self, position_m: f64) -> Option<usize> {
        if position_m.is_nan() || position_m < self.start_m {
            return None;
        }
        self.segments[..self.len].iter().position(|segment| position_m < segment.end_m)
    }

    pub fn end_m(&self) -> f64 {
        self.segments[..self.len].last().map_or(self.start_m, |segment| segment.end_m)
    }

    /// Planned speed at a position in segment `index`, m/s: energy is linear within a segment.
    pub fn speed_mps(&self, index: usize, position_m: f64) -> f64 {
        let (start_m, start) = self.start_of(index);
        let segment = &self.segments[index];
        let share = ((position_m - start_m) / (segment.end_m - start_m)).clamp(0.0, 1.0);
        (2.0 * (start + share * (segment.end_speed2_half - start))).max(0.0).sqrt()
    }

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
    /// Answers a request. Returns `false` and an empty plan in two cases. The road is not known far enough, or the
    /// truck's speed is outside the planned range.
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool;
}

/// Planning in a background thread that may take longer than a cycle.
pub trait Planning {
    /// Makes the planner; called once.
    fn planner(&self) -> Box<dyn Planner>;

    /// The plan that is needed after the last step, if any.
    fn request(&mut self) -> Option<PlanRequest>;

    /// Takes a plan; an empty one means "no plan".
    fn accept(&mut self, plan: &Plan);
}
