//! A road with signals and a lead, closed around a law. The plant is a first-order lag, integrated
//! with a hundredth of the controller's period.

use law::{Ego, Input, Law, MAX_SIGNALS, Output, Phase, PhaseInterval, SignalAhead, Target};

/// Control period, s.
pub(crate) const PERIOD_S: f64 = 0.1;
const SUBSTEPS: usize = 100;
const LAG_S: f64 = 0.5;

/// A fixed-time signal whose running phase can be cut or stretched.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Signal {
    pub(crate) id: u32,
    pub(crate) line_m: f64,
    /// Lengths of green, yellow and red, s.
    pub(crate) lengths_s: [f64; 3],
    /// 0 green, 1 yellow, 2 red.
    pub(crate) phase: usize,
    pub(crate) left_s: f64,
}

const PHASES: [Phase; 3] = [Phase::Green, Phase::Yellow, Phase::Red];

impl Signal {
    fn advance(&mut self, dt: f64) {
        self.left_s -= dt;
        while self.left_s <= 1e-9 {
            self.phase = (self.phase + 1) % 3;
            self.left_s += self.lengths_s[self.phase];
        }
    }

    fn announce(&self, ego_m: f64) -> SignalAhead {
        let distance_m = self.line_m - ego_m;
        let mut ahead = SignalAhead { id: self.id, distance_m, count: 6, ..SignalAhead::default() };
        let (mut phase, mut ends_in_s) = (self.phase, self.left_s);
        for interval in &mut ahead.intervals[..6] {
            *interval = PhaseInterval { phase: PHASES[phase], ends_in_s };
            phase = (phase + 1) % 3;
            ends_in_s += self.lengths_s[phase];
        }
        ahead
    }
}

/// Event in the scene at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Event {
    /// The running phase of a signal ends after this time, s.
    Jump { signal: usize, left_s: f64 },
    /// All signals fall silent, or (`unknown`) announce an unknown phase.
    Silence { unknown: bool },
    /// They are received again.
    Heard,
    /// The lead takes up an acceleration, m/s².
    LeadAccelerates(f64),
    /// The lead leaves the lane.
    LeadLeaves,
    /// A vehicle is ahead from now on.
    LeadAppears { gap_m: f64, speed_mps: f64 },
}

/// A vehicle ahead; position of its rear bumper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lead {
    pub(crate) track: u32,
    pub(crate) position_m: f64,
    pub(crate) speed_mps: f64,
    pub acceleration_mps2: f64,
}

/// The state of everything.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) time_s: f64,
    pub(crate) ego: Ego,
    pub(crate) lead: Option<Lead>,
    pub(crate) signals: Vec<Signal>,
    pub(crate) set_speed_mps: f64,
    /// 0 received, 1 silent, 2 unknown.
    pub(crate) silence: u8,
    pub(crate) tracks: u32,
}

/// Something that must not happen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Breach {
    Collision { time_s: f64 },
    RedLight { time_s: f64, line_m: f64, speed_mps: f64 },
}

impl World {
    pub(crate) fn new(speed_mps: f64, set_speed_mps: f64) -> Self {
        Self {
            time_s: 0.0,
            ego: Ego { speed_mps, ..Ego::default() },
            lead: None,
            signals: Vec::new(),
            set_speed_mps,
            silence: 0,
            tracks: 0,
        }
    }

    pub(crate) fn apply(&mut self, event: Event) {
        match event {
            Event::Jump { signal, left_s } => self.signals[signal].left_s = left_s,
            Event::Silence { unknown } => self.silence = if unknown { 2 } else { 1 },
            Event::Heard => self.silence = 0,
            Event::LeadAccelerates(a) => {
                if let Some(lead) = &mut self.lead {
                    lead.acceleration_mps2 = a;
                }
            }
            Event::LeadLeaves => self.lead = None,
            Event::LeadAppears { gap_m, speed_mps } => {
                self.tracks += 1;
                self.lead = Some(Lead {
                    track: self.tracks,
                    position_m: self.ego.position_m + gap_m,
                    speed_mps,
                    acceleration_mps2: 0.0,
                });
            }
        }
    }

    pub(crate) fn input(&self) -> Input {
        let mut signals = [None; MAX_SIGNALS];
        if self.silence != 1 {
            let ahead = self.signals.iter().filter(|s| s.line_m > self.ego.position_m);
            for (slot, signal) in signals.iter_mut().zip(ahead) {
                let mut announced = signal.announce(self.ego.position_m);
                if self.silence == 2 {
                    announced.intervals[0].phase = Phase::Unknown;
                    announced.count = 1;
                }
                *slot = Some(announced);
            }
        }
        Input {
            time_s: self.time_s,
            period_s: PERIOD_S,
            ego: self.ego,
            target: self.lead.map(|lead| Target {
                track_id: lead.track,
                gap_m: lead.position_m - self.ego.position_m,
                relative_speed_mps: lead.speed_mps - self.ego.speed_mps,
                acceleration_mps2: lead.acceleration_mps2,
                age_s: 0.0,
            }),
            signals,
            set_speed_mps: self.set_speed_mps,
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        }
    }

    /// One control period under `law`.
    pub(crate) fn step(&mut self, law: &mut dyn Law, output: &mut Output) -> Result<(), Breach> {
        law.step(&self.input(), output);
        let u = output.request_mps2();
        assert!((-4.9..=4.9).contains(&u), "request {u} out of bounds");
        self.advance(u)
    }

    /// One control period under a request.
    pub(crate) fn advance(&mut self, u: f64) -> Result<(), Breach> {
        let dt = PERIOD_S / SUBSTEPS as f64;
        for _ in 0..SUBSTEPS {
            let before = self.ego.position_m;
            let ego = &mut self.ego;
            let a = ego.acceleration_mps2;
            let v = ego.speed_mps;
            ego.acceleration_mps2 += dt / LAG_S * (u - a);
            ego.speed_mps += dt * 0.5 * (a + ego.acceleration_mps2);
            if ego.speed_mps <= 0.0 {
                ego.speed_mps = 0.0;
                ego.acceleration_mps2 = ego.acceleration_mps2.max(0.0);
            }
            ego.position_m += dt * 0.5 * (v + ego.speed_mps);
            if let Some(lead) = &mut self.lead {
                let next = (lead.speed_mps + dt * lead.acceleration_mps2).max(0.0);
                lead.position_m += dt * 0.5 * (lead.speed_mps + next);
                lead.speed_mps = next;
                if next == 0.0 {
                    lead.acceleration_mps2 = lead.acceleration_mps2.max(0.0);
                }
            }
            self.time_s += dt;
            for signal in &mut self.signals {
                let crossed = before < signal.line_m && self.ego.position_m >= signal.line_m;
                if crossed && signal.phase == 2 {
                    return Err(Breach::RedLight {
                        time_s: self.time_s,
                        line_m: signal.line_m,
                        speed_mps: self.ego.speed_mps,
                    });
                }
                signal.advance(dt);
            }
            if self.lead.is_some_and(|lead| lead.position_m <= self.ego.position_m) {
                return Err(Breach::Collision { time_s: self.time_s });
            }
        }
        Ok(())
    }
}
