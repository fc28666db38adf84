//! The lead of a corridor: a driver with free road ahead. He obeys the signals by the rules and values of
//! `acc-signal-stop`.

use crate::scene::fixed;
use controller::law::following::driver::{Driver, Obstacle};
use controller::laws::signal_stop::SignalStop;
use scenario::{Table, Value, table};
use std::f64::consts::TAU;

const STEP_S: f64 = 0.1;
/// Steps between two points of its table of speeds.
const EVERY: usize = 5;
const LONGEST_S: f64 = 900.0;
/// Way beyond the last line, m.
const BEYOND_M: f64 = 400.0;
/// Way from a line to the place where it turns off, m.
const TURN_M: f64 = 8.0;
const LENGTH_M: f64 = 4.5;
/// Its temper on an open road and in front of a line.
const DRIVER: Driver = Driver { acceleration_mps2: 2.0, deceleration_mps2: 1.7, hardest_mps2: 6.0 };

/// Random traits of a lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traits {
    /// Gap from the ego at the start, m.
    pub gap_m: f64,
    pub speed_mps: f64,
    pub desired_mps: f64,
    /// Share by which that speed varies, and the period, s.
    pub waves: (f64, f64),
    /// The line behind which it turns off; none where there are fewer.
    pub turns_off_at: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Lead {
    gap_m: f64,
    leaves_at_s: Option<f64>,
    /// Speeds over time.
    speeds: Vec<(f64, f64)>,
    /// Positions of its rear at these times, m.
    places: Vec<f64>,
}

/// The driver's decision at the next signal.
#[derive(Clone, Copy, Default)]
struct Heed {
    line: usize,
    phase: usize,
    since_s: f64,
    goes_on: bool,
}

impl Lead {
    pub fn drive(traits: &Traits, signals: &[Signal]) -> Self {
        let rules = SignalStop::default();
        let last_m = signals.last().map_or(0.0, |signal| signal.line_m) + BEYOND_M;
        let (mut front_m, mut v, mut step) = (traits.gap_m + LENGTH_M, traits.speed_mps, 0_usize);
        let mut lead = Self {
            gap_m: traits.gap_m,
            leaves_at_s: None,
            speeds: Vec::new(),
            places: vec![traits.gap_m],
        };
        let mut heed = Heed::default();
        while front_m < last_m && (step as f64) * STEP_S < LONGEST_S {
            let time_s = step as f64 * STEP_S;
            if step.is_multiple_of(EVERY) {
                lead.speeds.push((time_s, v));
            }
            let turn = signals.get(traits.turns_off_at).map(|signal| signal.line_m + TURN_M);
            if turn.is_some_and(|turn_m| front_m >= turn_m) {
                lead.leaves_at_s = Some(time_s);
                break;
            }
            let (share, period_s) = traits.waves;
            let desired = traits.desired_mps * (1.0 + share * libm::sin(TAU * time_s / period_s));
            let mut a = DRIVER.free_mps2(v, desired);
            let next = signals.iter().position(|signal| signal.line_m > front_m);
            let near = next.filter(|&i| signals[i].line_m - front_m <= rules.sight_m);
            if let Some(i) = near
                && heed.closes(i, &signals[i], time_s, signals[i].line_m - front_m, v, &rules)
            {
                let line = Obstacle {
                    gap_m: signals[i].line_m - front_m,
                    speed_mps: 0.0,
                    acceleration_mps2: 0.0,
                    headway_s: 1.0,
                    standstill_m: rules.stop_margin_m,
                };
                a = a.min(DRIVER.follow_mps2(v, desired, &line));
            }
            let faster = (v + a * STEP_S).max(0.0);
            front_m += 0.5 * STEP_S * (v + faster);
            v = faster;
            step += 1;
        }
        for pair in lead.speeds.windows(2) {
            let way_m = 0.5 * (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1);
            lead.places.push(lead.places.last().copied().unwrap_or(0.0) + way_m);
        }
        lead
    }

    /// Position of its rear at a time, m; infinite once it has left.
    pub fn rear_m(&self, time_s: f64) -> f64 {
        if self.leaves_at_s.is_some_and(|leaves_s| time_s >= leaves_s) {
            return f64::INFINITY;
        }
        let end = self.speeds.partition_point(|(at_s, _)| *at_s <= time_s).max(1);
        let (from_s, v) = self.speeds[end - 1];
        let slope = self.speeds.get(end).map_or(0.0, |(to_s, next)| (next - v) / (to_s - from_s));
        let since_s = time_s - from_s;
        self.places[end - 1] + since_s * (v + 0.5 * slope * since_s)
    }

    pub fn table(&self) -> Table {
        let point = |&(time_s, v): &(f64, f64)| Value::from(vec![fixed(time_s, 1), fixed(v, 3)]);
        let points: Vec<Value> = self.speeds.iter().map(point).collect();
        let profile = table! { speeds: points };
        let mut table = table! { name: "lead", gap_m: fixed(self.gap_m, 2), profile: profile };
        table.extend(self.leaves_at_s.map(|s| ("leaves_at_s".to_owned(), fixed(s, 1).into())));
        table
    }
}

impl Heed {
    /// True if the driver stops for signal `line`, `distance_m` ahead.
    fn closes(
        &mut self,
        line: usize,
        signal: &Signal,
        time_s: f64,
        distance_m: f64,
        v: f64,
        rules: &SignalStop,
    ) -> bool {
        // The driver reacts to the phase of a reaction time ago.
        let phase = signal.phase_at((time_s - rules.reaction_s).max(0.0));
        if (self.line, self.phase) != (line, phase) || self.since_s == 0.0 {
            let was_yellow = self.line == line && self.phase == 1;
            let room_m = (distance_m - rules.stop_margin_m).max(0.0);
            let too_late = v * v > 2.0 * rules.yellow_deceleration_mps2 * room_m;
            let goes_on = phase != 0 && (if was_yellow { self.goes_on } else { too_late });
            *self = Self { line, phase, since_s: time_s.max(STEP_S), goes_on };
        }
        self.phase != 0 && !self.goes_on
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal {
    /// Position of its stop line, m.
    pub line_m: f64,
    /// Lengths of green, yellow and red, s.
    pub lengths_s: [f64; 3],
    /// Time by which its program is ahead at the start, s.
    pub offset_s: f64,
}

impl Signal {
    /// 0 green, 1 yellow, 2 red.
    pub fn phase_at(&self, time_s: f64) -> usize {
        let [green_s, yellow_s, red_s] = self.lengths_s;
        let into_s = (time_s + self.offset_s) % (green_s + yellow_s + red_s);
        usize::from(into_s >= green_s) + usize::from(into_s >= green_s + yellow_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::corridor::Corridor;

    /// Speed that counts as standing: the driver comes to rest asymptotically, m/s.
    const STANDS_MPS: f64 = 0.3;

    /// The lead stops in some corridors, and is never past a line while its signal has been red for long.
    #[test]
    fn it_obeys_the_signals() {
        let (mut stops, mut late) = (0, 0);
        for number in 1..=300 {
            let corridor = Corridor::new(number);
            let Some(lead) = corridor.lead else { continue };
            let mut front_m = lead.gap_m + LENGTH_M;
            for pair in lead.speeds.windows(2) {
                let [(from_s, v), (to_s, faster)] = pair else { unreachable!("two") };
                let next_m = front_m + 0.5 * (to_s - from_s) * (v + faster);
                stops += usize::from(*v > STANDS_MPS && *faster <= STANDS_MPS);
                for signal in &corridor.signals {
                    let crosses = front_m < signal.line_m && next_m >= signal.line_m;
                    late += usize::from(crosses && signal.phase_at(*from_s) == 2);
                }
                front_m = next_m;
            }
        }
        assert!(stops > 100, "{stops}");
        // In the dilemma of a short yellow a driver can neither stop nor clear the line.
        assert!(late < stops / 20, "{late} of {stops}");
    }
}
