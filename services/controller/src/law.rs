//! What every control law sees and returns.
//!
//! A law is plain code: no clock, no shared memory, no thread, no logging. The control loop samples
//! its inputs, ages them, and calls [`Law::step`] once per release; time is an argument.
//!
//! Frame: x forward along the lane, origin at the ego's start. All quantities in SI units.

use crate::predictive::{Plan, PlanRequest, Planner, Preview};

/// Longest plan a command can carry, in control steps.
pub const MAX_PLAN: usize = 128;
/// Most signals a law is told about, nearest first.
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
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
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
    /// Phase shown during the interval.
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
    /// Number of valid entries in `intervals`.
    pub count: usize,
}

/// Engine and gearbox of a truck, and the slope it feels, as its own computers report them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Powertrain {
    /// Gear, counted from 0, the lowest; the one being engaged during a shift.
    pub gear: usize,
    /// Time since the last shift began, s.
    pub since_shift_s: f64,
    /// Torque at the crankshaft, N m.
    pub engine_torque_nm: f64,
    /// The vehicle's own estimate of the grade under it (rise over run).
    pub grade: f64,
}

/// Everything a law is told at one release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// Time of the release since the start of the run, s.
    pub time_s: f64,
    /// Control period, s.
    pub period_s: f64,
    /// Ego state.
    pub ego: Ego,
    /// In-path target, if the radar has one.
    pub target: Option<Target>,
    /// Signals ahead, nearest first.
    pub signals: [Option<SignalAhead>; MAX_SIGNALS],
    /// Engine and gearbox, if the vehicle is a truck.
    pub powertrain: Option<Powertrain>,
    /// The road ahead, if a map describes it.
    pub preview: Option<Preview>,
    /// Driver's set speed, m/s.
    pub set_speed_mps: f64,
    /// Legal limit on this road, m/s (infinite when unknown).
    pub speed_limit_mps: f64,
}

/// How good the returned command is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The law's full function.
    #[default]
    Full,
    /// Usable, but some constraint had to be relaxed (an infeasible light, a violated buffer).
    Relaxed,
    /// The law failed and its backup produced the command.
    Backup,
}

/// A request to a truck's engine, beside the acceleration requests.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorqueRequest {
    /// Torque at the crankshaft, N m; below the drag torque it asks for the engine brake.
    pub engine_torque_nm: f64,
    /// Force of the service brakes at the wheels, N: the last resort, 0 otherwise.
    pub service_brake_n: f64,
    /// Gear to engage, counted from 0; `None` leaves it to the gearbox.
    pub gear: Option<usize>,
}

/// What a law returns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// Planned requests, m/s², one per control period; the first acts now. `plan_len` are valid.
    pub plan_mps2: [f64; MAX_PLAN],
    /// Valid entries of `plan_mps2`, at least 1.
    pub plan_len: usize,
    /// For a truck: what the engine is asked for now. It comes before `plan_mps2[0]`, which says the
    /// same as an acceleration; the later requests of the plan have no torque.
    pub torque: Option<TorqueRequest>,
    /// Mode of the law, an index into [`Law::mode_names`].
    pub mode: u32,
    /// Reason of the last mode change, an index into [`Law::reason_names`].
    pub mode_reason: u32,
    /// Quality of the command.
    pub quality: Quality,
    /// Iterations the solver took, 0 for explicit laws.
    pub solver_iterations: u32,
    /// Law-specific figures for `control/diagnostics`, named by [`Law::figure_names`].
    pub figures: [f64; 8],
}

impl Default for Output {
    fn default() -> Self {
        Self {
            plan_mps2: [0.0; MAX_PLAN],
            plan_len: 1,
            torque: None,
            mode: 0,
            mode_reason: 0,
            quality: Quality::Full,
            solver_iterations: 0,
            figures: [0.0; 8],
        }
    }
}

impl Output {
    /// Sets a plan of one request, the form of every law without a horizon.
    pub fn set_request(&mut self, request_mps2: f64) {
        self.plan_mps2[0] = request_mps2;
        self.plan_len = 1;
        self.torque = None;
    }

    /// Makes every figure finite: what is no number is 0, what is beyond all numbers the largest one.
    pub fn bound_figures(&mut self) {
        for figure in &mut self.figures {
            *figure = if figure.is_nan() { 0.0 } else { figure.clamp(f64::MIN, f64::MAX) };
        }
    }

    /// Request that acts now, m/s².
    #[must_use]
    pub fn request_mps2(&self) -> f64 {
        self.plan_mps2[0]
    }
}

/// What a law wants done beside the control loop, in a thread that may take longer than a cycle.
pub trait Planning {
    /// Whoever makes the plans; asked for once.
    fn planner(&self) -> Box<dyn Planner>;

    /// The plan that is wanted after the last step, if any.
    fn request(&mut self) -> Option<PlanRequest>;

    /// Takes a plan, or learns from an empty one that there is none.
    fn accept(&mut self, plan: &Plan);
}

/// A cruise controller.
///
/// Every law passes one conformance suite: its output is finite and within bounds for any input, it
/// copes with a lost target and lost signals, `reset` brings back the initial behaviour exactly,
/// the same inputs give the same bits, and `step` allocates nothing.
pub trait Law {
    /// Forgets all history; the next `step` behaves as the first.
    fn reset(&mut self);

    /// Computes the command for one release into `output`, overwriting all of it.
    fn step(&mut self, input: &Input, output: &mut Output);

    /// Smallest and largest request the law ever returns, m/s².
    fn request_bounds_mps2(&self) -> (f64, f64);

    /// The planning that goes on beside the law, if it has any.
    fn planning(&mut self) -> Option<&mut dyn Planning> {
        None
    }

    /// Names of the modes, in the order of [`Output::mode`].
    fn mode_names(&self) -> &'static [&'static str];

    /// Names of the reasons for a mode change, in the order of [`Output::mode_reason`].
    fn reason_names(&self) -> &'static [&'static str] {
        &["none"]
    }

    /// Names of [`Output::figures`], with units; at most eight.
    fn figure_names(&self) -> &'static [&'static str] {
        &[]
    }
}
