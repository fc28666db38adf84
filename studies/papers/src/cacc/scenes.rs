//! The paper's scenarios as pure closed loops in its own kinematic plant.
//!
//! ```text
//! x+ = x + T v,  v+ = v + T a,  a+ = (1 - T/tau) a + (T/tau) u        ego and, with its own a, lead
//! ```
//!
//! The figures and the reference trajectories were made with this. The process group runs the same
//! scenarios through its own plant. In Table 3 the ego cannot reverse.

use super::trajectory::Trajectory;
use controller::law::{
    Ego, Input, Law, MAX_SIGNALS, Output, Phase, PhaseInterval, SignalAhead, Target,
};

/// Step of plant and controller, s.
const STEP_S: f64 = 0.1;
/// Lag of the plant, s.
const LAG_S: f64 = 0.5;

/// Motion of the lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lead {
    /// At constant speed.
    Constant,
    /// With the acceleration `amplitude sin(2 pi t / period)`.
    Sine {
        /// m/s².
        amplitude_mps2: f64,
        /// s.
        period_s: f64,
    },
    /// From `start_s` on with a constant acceleration up to a speed.
    Launch {
        /// s.
        start_s: f64,
        /// m/s².
        acceleration_mps2: f64,
        /// m/s.
        top_mps: f64,
    },
}

impl Lead {
    fn acceleration_mps2(&self, time_s: f64, speed_mps: f64) -> f64 {
        match *self {
            Self::Constant => 0.0,
            Self::Sine { amplitude_mps2, period_s } => {
                amplitude_mps2 * libm::sin(2.0 * std::f64::consts::PI * time_s / period_s)
            }
            Self::Launch { start_s, acceleration_mps2, top_mps } => {
                if time_s >= start_s - 1e-9 && speed_mps < top_mps - 1e-9 {
                    acceleration_mps2.min((top_mps - speed_mps) / STEP_S)
                } else {
                    0.0
                }
            }
        }
    }
}

/// One scenario of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Speed of the ego at the start, m/s.
    pub ego_speed_mps: f64,
    /// Speed of the lead at the start, m/s.
    pub lead_speed_mps: f64,
    /// Gap at the start, m.
    pub gap_m: f64,
    /// Motion of the lead.
    pub lead: Lead,
    /// First phase of the light.
    pub phase: Phase,
    /// Distance to the stop line at the start, m.
    pub line_m: f64,
    /// Time of the light's switch, s.
    pub switch_s: f64,
    /// Set speed, m/s; infinite where the paper gives no speed.
    pub set_speed_mps: f64,
    /// Control steps.
    pub steps: usize,
    /// True if the plant keeps the ego from reversing.
    pub no_reverse: bool,
}

/// Scenario A: a lead at constant speed, green.
pub const A: Scene = Scene {
    ego_speed_mps: 15.0,
    lead_speed_mps: 15.0,
    gap_m: 49.5,
    lead: Lead::Constant,
    phase: Phase::Green,
    line_m: 80.0,
    switch_s: 5.0,
    set_speed_mps: f64::INFINITY,
    steps: 100,
    no_reverse: false,
};

/// Scenario B: as A with a lead whose acceleration is a sine.
pub const B: Scene = Scene { lead: Lead::Sine { amplitude_mps2: 2.0, period_s: 10.0 }, ..A };

/// Scenario C: a standing lead that starts at the switch, red.
pub const C: Scene = Scene {
    lead_speed_mps: 0.0,
    gap_m: 99.5,
    lead: Lead::Launch { start_s: 5.0, acceleration_mps2: 3.0, top_mps: 15.0 },
    phase: Phase::Red,
    line_m: 100.0,
    ..A
};

/// Table 3: a start from standstill behind a lead that starts with `lead_mps2`, green.
#[must_use]
pub const fn table_3(lead_mps2: f64) -> Scene {
    Scene {
        ego_speed_mps: 0.0,
        lead_speed_mps: 0.0,
        gap_m: 26.0,
        lead: Lead::Launch { start_s: 0.0, acceleration_mps2: lead_mps2, top_mps: 8.33 },
        phase: Phase::Green,
        line_m: 58.0,
        switch_s: 10.0,
        set_speed_mps: 11.1,
        steps: 150,
        no_reverse: true,
    }
}

/// Lead acceleration in Table 3 that goes with the joint weights, m/s². The paper does not give it.
pub const TABLE_3_LEAD_JOINT_MPS2: f64 = 2.388;
/// The same for the weights fitted to Table 3 alone, m/s².
pub const TABLE_3_LEAD_SINGLE_MPS2: f64 = 2.594;

/// A recorded run, one entry per control step and one for the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Ego position, m.
    pub position_m: Vec<f64>,
    /// Ego speed, m/s.
    pub speed_mps: Vec<f64>,
    /// Ego acceleration, m/s².
    pub acceleration_mps2: Vec<f64>,
    /// Request that acts from this time on, m/s².
    pub request_mps2: Vec<f64>,
    /// Spacing error as the law saw it, m.
    pub gap_error_m: Vec<f64>,
    /// Speed error, m/s.
    pub speed_error_mps: Vec<f64>,
    /// Gap, m.
    pub gap_m: Vec<f64>,
}

impl Recording {
    /// The recording as the figures need it.
    #[must_use]
    pub fn trajectory(&self) -> Trajectory<'_> {
        Trajectory {
            time_s: &self.time_s,
            position_m: &self.position_m,
            speed_mps: &self.speed_mps,
            acceleration_mps2: &self.acceleration_mps2,
            request_mps2: &self.request_mps2,
            gap_error_m: &self.gap_error_m,
            speed_error_mps: &self.speed_error_mps,
            gap_m: &self.gap_m,
        }
    }
}

/// Drives `law` through `scene` from its initial state. The law's first figure is taken as the
/// spacing error.
pub fn run(scene: &Scene, law: &mut dyn Law) -> Recording {
    law.reset();
    let (mut x, mut v, mut a) = (0.0, scene.ego_speed_mps, 0.0);
    let (mut x_lead, mut v_lead) = (scene.gap_m, scene.lead_speed_mps);
    let mut recording = Recording::default();
    let mut output = Output::default();
    for step in 0..=scene.steps {
        let time = step as f64 * STEP_S;
        let a_lead = scene.lead.acceleration_mps2(time, v_lead);
        let input = Input {
            time_s: time,
            period_s: STEP_S,
            ego: Ego { position_m: x, speed_mps: v, acceleration_mps2: a },
            target: Some(Target {
                track_id: 1,
                gap_m: x_lead - x,
                relative_speed_mps: v_lead - v,
                acceleration_mps2: a_lead,
                age_s: 0.0,
            }),
            signals: signals(scene, time, x),
            set_speed_mps: scene.set_speed_mps,
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        };
        law.step(&input, &mut output);
        let u = output.request_mps2();
        recording.time_s.push(time);
        recording.position_m.push(x);
        recording.speed_mps.push(v);
        recording.acceleration_mps2.push(a);
        recording.request_mps2.push(u);
        recording.gap_error_m.push(output.figures[0]);
        recording.speed_error_mps.push(v - v_lead);
        recording.gap_m.push(x_lead - x);
        x += STEP_S * v;
        v += STEP_S * a;
        a += STEP_S / LAG_S * (u - a);
        x_lead += STEP_S * v_lead;
        v_lead += STEP_S * a_lead;
        if scene.no_reverse && v < 0.0 {
            v = 0.0;
            a = a.max(0.0);
        }
    }
    recording
}

fn signals(scene: &Scene, time_s: f64, x: f64) -> [Option<SignalAhead>; MAX_SIGNALS] {
    let other = if scene.phase == Phase::Green { Phase::Red } else { Phase::Green };
    let mut signal =
        SignalAhead { id: 256, distance_m: scene.line_m - x, count: 1, ..SignalAhead::default() };
    let left = scene.switch_s - time_s;
    if left > 1e-9 {
        signal.intervals[0] = PhaseInterval { phase: scene.phase, ends_in_s: left };
        signal.intervals[1] = PhaseInterval { phase: other, ends_in_s: left + 60.0 };
        signal.count = 2;
    } else {
        signal.intervals[0] = PhaseInterval { phase: other, ends_in_s: left + 60.0 };
    }
    let mut all = [None; MAX_SIGNALS];
    all[0] = Some(signal);
    all
}
