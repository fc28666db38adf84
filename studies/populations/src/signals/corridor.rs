//! The draws of a corridor: its number alone decides.
//!
//! | drawn | from | to |
//! |---|---|---|
//! | speed limit and set speed, m/s | 8.3 (30 km/h) | 16.7 (60 km/h) |
//! | signals | 1 | 5 |
//! | first line; way from line to line, m | 150 | 450 |
//! | green; red, s | 10 | 40 |
//! | yellow, s | 3 | 5 |
//! | time before the line at which its countdown arrives, at the set speed, s | 2 | 60 |
//!
//! A vehicle cannot stop for a red signal that it receives too late. So the radio reaches at least the stopping
//! distance, with a reaction time and a gentle deceleration.
//!
//! Two corridors of three have a lead, which obeys the signals as the rival's driver does.

use super::lead::{self, Signal};
use crate::scene::{Draws, Scene, fixed};
use scenario::{Setting, Table, table};

/// Selects the draws of this study.
const STREAM: u64 = 0x5e1e_c7ed_c0aa_1d05;
/// Reaction time in the least range of the radio, s.
const REACTION_S: f64 = 1.5;
/// Deceleration in the least range of the radio, m/s².
const GENTLE_MPS2: f64 = 2.0;
/// Range within which the rival's eyes replace the radio, m: beyond its sight distance.
const EYES_M: f64 = 300.0;

#[derive(Clone, Debug, PartialEq)]
pub struct Corridor {
    /// Speed limit and set speed, m/s.
    pub limit_mps: f64,
    pub speed_mps: f64,
    /// Time before a line at which its countdown arrives at the set speed, s.
    pub ahead_s: f64,
    /// Signals in order of their lines.
    pub signals: Vec<Signal>,
    pub lead: Option<lead::Lead>,
}

impl Corridor {
    pub fn new(number: u64) -> Self {
        let mut draws = Draws::new(number, STREAM);
        let mut between = |low: f64, high: f64| draws.between(low, high);
        let limit_mps = between(8.3, 16.7);
        let speed_mps = limit_mps * between(0.6, 1.0);
        let ahead_s = between(2.0, 60.0);
        let mut line_m = 0.0;
        let signals: Vec<Signal> = (0..between(1.0, 6.0) as usize)
            .map(|_| {
                line_m += between(150.0, 450.0);
                let lengths_s = [between(10.0, 40.0), between(3.0, 5.0), between(10.0, 40.0)];
                let offset_s = between(0.0, lengths_s.iter().sum());
                Signal { line_m, lengths_s, offset_s }
            })
            .collect();
        let traits = lead::Traits {
            gap_m: 5.0 + speed_mps * between(1.5, 4.0),
            speed_mps,
            desired_mps: limit_mps * between(0.75, 1.05),
            waves: (between(0.0, 0.1), between(8.0, 20.0)),
            turns_off_at: between(0.0, 2.0 * signals.len() as f64) as usize,
        };
        let has_lead = between(0.0, 3.0) >= 1.0;
        let lead = has_lead.then(|| lead::Lead::drive(&traits, &signals));
        Self { limit_mps, speed_mps, ahead_s, signals, lead }
    }

    /// Time in which every law has passed all lines, unless it stands in front of green, s.
    pub fn duration_s(&self) -> f64 {
        let waits_s: f64 =
            self.signals.iter().map(|signal| signal.lengths_s.iter().sum::<f64>()).sum();
        (self.last_line_m() / (0.5 * self.limit_mps) + waits_s + 20.0).ceil()
    }

    pub fn last_line_m(&self) -> f64 {
        self.signals.last().map_or(0.0, |signal| signal.line_m)
    }

    fn range_m(&self, has_eyes: bool) -> f64 {
        let v = self.limit_mps;
        let stop_m = v * REACTION_S + v * v / (2.0 * GENTLE_MPS2);
        let range_m = (v * self.ahead_s).max(stop_m);
        if has_eyes { range_m.max(EYES_M) } else { range_m }
    }

    /// The scene for a law; one that has eyes sees near signals without the radio.
    pub fn scene(&self, law: &str, has_eyes: bool) -> Scene {
        let limit_mps = fixed(self.limit_mps, 3);
        let mut scene = Scene::new(fixed(self.speed_mps, 3), limit_mps, self.duration_s());
        scene.law = law.to_owned();
        let signal = |(signal, id): (&Signal, i64)| {
            let phase = |(phase, length_s): (&str, f64)| {
                table! { phase: phase, duration_s: fixed(length_s, 2) }
            };
            let phases = ["green", "yellow", "red"].into_iter().zip(signal.lengths_s);
            table! {
                intersection_id: id,
                stop_line_m: fixed(signal.line_m, 2),
                offset_s: fixed(signal.offset_s, 2),
                program: phases.map(phase).collect::<Vec<_>>(),
            }
        };
        let signals: Vec<Table> = self.signals.iter().zip(1..).map(signal).collect();
        let range_m = fixed(self.range_m(has_eyes), 1);
        let v2x = table! { radio: "frames", range_m: range_m, signals: signals };
        let radar = table! { dropout_probability: 0.02, latency_ms: 50 };
        scene.keys = vec![
            Setting::new("speed_limit_mps", limit_mps),
            Setting::new("perception.radar", radar),
            Setting::new("v2x", v2x),
        ];
        scene.others.extend(self.lead.as_ref().map(lead::Lead::table));
        scene
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_makes_the_corridor() {
        assert_eq!(Corridor::new(7), Corridor::new(7));
        assert_ne!(Corridor::new(7), Corridor::new(8));
    }

    #[test]
    fn corridors_are_as_the_table_says() {
        let all: Vec<Corridor> = (1..=600).map(Corridor::new).collect();
        for corridor in &all {
            assert!((1..=5).contains(&corridor.signals.len()));
            assert!((2.0..60.0).contains(&corridor.ahead_s));
            for signal in &corridor.signals {
                assert!((3.0..5.0).contains(&signal.lengths_s[1]));
            }
        }
        for count in 1..=5 {
            let with = all.iter().filter(|corridor| corridor.signals.len() == count).count();
            assert!((80..160).contains(&with), "{with} with {count} signals");
        }
        let led = all.iter().filter(|corridor| corridor.lead.is_some()).count();
        assert!((350..450).contains(&led), "{led}");
    }
}
