//! Input of a law at one release.

use super::following::kinematics::Motion;
use super::following::safe_gap::LeadNow;
use super::preview::Preview;
use super::profile::SpeedProfile;

/// Largest number of signals in a law's input, nearest first.
pub const MAX_SIGNALS: usize = 4;
/// Most future phases a signal announces, the current one included.
pub const MAX_PHASES: usize = 8;

/// State of the ego vehicle at the time of the release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ego {
    /// Distance travelled since the start of the run, m.
    pub position_m: f64,
    /// Speed, m/s, never negative.
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

impl Ego {
    /// Its motion in its own frame.
    pub fn motion(&self) -> Motion {
        let Self { speed_mps, acceleration_mps2, .. } = *self;
        Motion { position_m: 0.0, speed_mps, acceleration_mps2 }
    }
}

/// The in-path target as the tracker reports it, brought to the time of the release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Target {
    /// Identity of the track: a new number means a new vehicle.
    pub track_id: u32,
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Range rate: target speed minus ego speed, m/s (negative when closing).
    pub relative_speed_mps: f64,
    /// Absolute acceleration of the target, m/s².
    pub acceleration_mps2: f64,
    /// Age of the sample behind this estimate, s.
    pub age_s: f64,
}

impl Target {
    /// The vehicle ahead of an ego at `ego_mps`; it does not drive backwards.
    pub fn lead(&self, ego_mps: f64) -> LeadNow {
        LeadNow {
            gap_m: self.gap_m,
            speed_mps: (ego_mps + self.relative_speed_mps).max(0.0),
            acceleration_mps2: self.acceleration_mps2,
        }
    }
}

/// Movement phase of a signal group (SAE J2735 movement phase state, reduced).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phase {
    /// Not known: never to be treated as green.
    #[default]
    Unknown,
    /// Protected movement allowed.
    Green,
    /// Clearance: stop if that is comfortable.
    Yellow,
    /// Stop and remain.
    Red,
}

/// One announced interval of a signal program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhaseInterval {
    pub phase: Phase,
    /// Time from the release until the interval ends, s.
    pub ends_in_s: f64,
}

/// A signal ahead on the ego's lane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalAhead {
    /// Intersection id times 256 plus signal group id.
    pub id: u32,
    /// Distance from the ego's front bumper to the stop line, m; negative once it is passed.
    pub distance_m: f64,
    /// Current and next intervals, in order of time; `count` of them are valid.
    pub intervals: [PhaseInterval; MAX_PHASES],
    pub count: usize,
    /// Likely end of the shown phase, s from the release, if its announced bounds differ; infinite if it is not known,
    /// and 0 otherwise. `intervals` have the earliest end of a green or yellow and the latest of a red.
    pub likely_s: f64,
}

/// Engine and gearbox of a truck, and the slope it feels, as its own computers report them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Powertrain {
    /// Gear, counted from 0, the lowest; the one being engaged during a shift.
    pub gear: usize,
    /// Time since the last shift began, s.
    pub since_shift_s: f64,
    pub engine_torque_nm: f64,
    /// The vehicle's own estimate of the grade under it (rise over run).
    pub grade: f64,
}

/// Input of a law at one release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// Time of the release since the start of the run, s.
    pub time_s: f64,
    pub period_s: f64,
    pub ego: Ego,
    /// In-path target, if the radar has one.
    pub target: Option<Target>,
    /// Signals ahead, nearest first.
    pub signals: [Option<SignalAhead>; MAX_SIGNALS],
    /// Engine and gearbox, if the vehicle is a truck.
    pub powertrain: Option<Powertrain>,
    /// The road ahead, if a map describes it.
    pub preview: Option<Preview>,
    /// Driver's set speed, or what the road ahead allows now, m/s.
    pub set_speed_mps: f64,
    /// The same along the road, where it is known to bend. For laws with a horizon.
    pub profile: Option<SpeedProfile>,
    /// Legal limit on this road, m/s (infinite when unknown).
    pub speed_limit_mps: f64,
}

/// No road vehicle is faster, m/s; anything above is a broken input.
const FASTEST_MPS: f64 = 150.0;
/// No sensor sees farther and no drive is longer, m and s.
const FARTHEST: f64 = 1e6;
/// No vehicle accelerates or brakes harder, m/s².
const HARDEST_MPS2: f64 = 50.0;

impl Input {
    /// Caps the set speed, now and along the road, m/s.
    pub fn cap_speed(&mut self, most_mps: f64) {
        self.set_speed_mps = self.set_speed_mps.min(most_mps);
        if let Some(profile) = &mut self.profile {
            profile.cap(0.0, f64::INFINITY, most_mps, 0.0);
        }
    }

    /// The speed to drive without a target, m/s: the set speed within the limit.
    pub fn wanted_speed_mps(&self) -> f64 {
        self.set_speed_mps.min(self.speed_limit_mps).max(0.0)
    }

    /// The input with a speed that is not negative and a set speed within the limit, if a road vehicle can have it.
    pub fn sound(&self) -> Option<Self> {
        let ego = Ego { speed_mps: self.ego.speed_mps.max(0.0), ..self.ego };
        let set_speed_mps = self.wanted_speed_mps();
        self.is_plausible().then_some(Self { ego, set_speed_mps, ..*self })
    }

    /// Time, place, speeds, accelerations and gap are numbers that a road vehicle can have.
    pub fn is_plausible(&self) -> bool {
        let within = |v: f64, low: f64, high: f64| (low..=high).contains(&v);
        let up_to = |v: f64, most: f64| within(v, -most, most);
        within(self.period_s, 1e-4, 10.0)
            && up_to(self.time_s, FARTHEST)
            && up_to(self.ego.position_m, FARTHEST)
            && within(self.ego.speed_mps, -1.0, FASTEST_MPS)
            && up_to(self.ego.acceleration_mps2, HARDEST_MPS2)
            && within(self.wanted_speed_mps(), 0.0, FASTEST_MPS)
            && !self.set_speed_mps.is_nan()
            && !self.speed_limit_mps.is_nan()
            && self.target.is_none_or(|target| {
                up_to(target.gap_m, FARTHEST)
                    && up_to(target.acceleration_mps2, HARDEST_MPS2)
                    && within(target.relative_speed_mps, -2.0 * FASTEST_MPS, FASTEST_MPS)
            })
    }
}
