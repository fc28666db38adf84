//! The best trip through a corridor, by dynamic programming.
//!
//! It knows all phases and the lead's motion, so no law can be faster with its limits:
//!
//! ```text
//! state     place and speed, in steps of 0.25 m/s and of what one of them drives in 0.25 s
//! step      0.5 s: every speed within -2.5 and +2 m/s², up to the limit
//! lead      front <= rear of the lead - 4.5 m - 1.5 s v
//! line      crossed in green, or in yellow where a driver could not stop: its age is at most 1 s + v / 6.1 m/s²
//! ```
//!
//! The reachable states of an instant are one bit each, a row for each speed. A step from one speed to another moves a
//! row by a whole number of places.

use super::corridor::Corridor;
use super::lead::Signal;

const STEP_S: f64 = 0.5;
const SPEED_STEP_MPS: f64 = 0.25;
/// Largest acceleration and deceleration, m/s².
const ACCELERATION_MPS2: f64 = 2.0;
const DECELERATION_MPS2: f64 = 2.5;
/// Gap behind the lead: at a stand, m, and time headway, s.
const STANDSTILL_GAP_M: f64 = 4.5;
const HEADWAY_S: f64 = 1.5;
/// A driver's reaction to yellow, s, and twice the deceleration, m/s² (ITE 2020).
const REACTION_S: f64 = 1.0;
const TWICE_YELLOW_MPS2: f64 = 6.1;
/// Time beyond that of the study's drives after which the bound gives up, s.
const LONGER_S: f64 = 60.0;

/// Earliest times at which the lines of a corridor and a place behind them can be passed, s. Fewer where the rest cannot
/// be reached.
pub fn earliest_s(corridor: &Corridor, end_m: f64) -> Vec<f64> {
    let grid = Grid::of(corridor, end_m);
    let places = corridor.signals.iter().map(|signal| signal.line_m).chain([end_m]);
    let mut wanted = places.map(|place_m| grid.place(place_m)).peekable();
    let mut passed_s = Vec::new();
    let mut now = Reached::new(&grid);
    now.rows[grid.start].set(0);
    let mut time_s = 0.0;
    while time_s < corridor.duration_s() + LONGER_S {
        let (next, farthest) = now.step(&grid, corridor, time_s);
        time_s += STEP_S;
        let Some(farthest) = farthest else { break };
        while let Some(place) = wanted.next_if(|place| *place < farthest) {
            let beyond_s = (farthest - place) as f64 * grid.place_m / corridor.limit_mps;
            passed_s.push(time_s - beyond_s.min(STEP_S));
        }
        if wanted.peek().is_none() {
            break;
        }
        now = next;
    }
    passed_s
}

/// Places and speeds.
struct Grid {
    speed_mps: f64,
    place_m: f64,
    speeds: usize,
    places: usize,
    start: usize,
    gain: usize,
    loss: usize,
}

impl Grid {
    fn of(corridor: &Corridor, end_m: f64) -> Self {
        let steps = (corridor.limit_mps / SPEED_STEP_MPS).round();
        let speed_mps = corridor.limit_mps / steps;
        let place_m = 0.5 * STEP_S * speed_mps;
        // Rounded up, so that the bound is not above what a law can do.
        let change = |mps2: f64| (mps2 * STEP_S / speed_mps - 0.05).ceil() as usize;
        let top = steps as usize;
        Self {
            speed_mps,
            place_m,
            speeds: top + 1,
            places: (end_m / place_m) as usize + 2 * top + 1,
            start: ((corridor.speed_mps / speed_mps).ceil() as usize).min(top),
            gain: change(ACCELERATION_MPS2),
            loss: change(DECELERATION_MPS2),
        }
    }

    fn place(&self, place_m: f64) -> usize {
        (place_m / self.place_m).round() as usize
    }
}

/// Reachable states of an instant.
struct Reached {
    rows: Vec<Bits>,
}

impl Reached {
    fn new(grid: &Grid) -> Self {
        Self { rows: vec![Bits(vec![0; grid.places.div_ceil(64)]); grid.speeds] }
    }

    /// The states a step after `time_s`, and the farthest place of them.
    fn step(&self, grid: &Grid, corridor: &Corridor, time_s: f64) -> (Self, Option<usize>) {
        let mut next = Self::new(grid);
        let closed: Vec<(usize, &Signal)> = (corridor.signals.iter())
            .filter(|signal| {
                // A phase is longer than a step.
                signal.phase_at(time_s) != 0
                    || !is_legal(signal, time_s + STEP_S, corridor.limit_mps)
            })
            .map(|signal| (grid.place(signal.line_m), signal))
            .collect();
        for (v, row) in self.rows.iter().enumerate().filter(|(_, row)| !row.is_empty()) {
            let faster = (v + grid.gain).min(grid.speeds - 1);
            for w in v.saturating_sub(grid.loss)..=faster {
                let way = v + w;
                let mut row = row.clone();
                for (line, signal) in &closed {
                    for from in (line + 1).saturating_sub(way)..=*line {
                        let share = (line - from) as f64 / way.max(1) as f64;
                        let mean_mps = 0.5 * way as f64 * grid.speed_mps;
                        if row.has(from) && !is_legal(signal, time_s + share * STEP_S, mean_mps) {
                            row.clear(from);
                        }
                    }
                }
                next.rows[w].add_shifted(&row, way);
            }
        }
        let rear_m = corridor.lead.as_ref().map_or(f64::INFINITY, |l| l.rear_m(time_s + STEP_S));
        for (w, row) in next.rows.iter_mut().enumerate() {
            let most_m = rear_m - STANDSTILL_GAP_M - HEADWAY_S * w as f64 * grid.speed_mps;
            // A negative place is no place.
            row.keep_below((most_m / grid.place_m + 1.0).max(0.0) as usize);
        }
        let farthest = next.rows.iter().filter_map(Bits::last).max();
        (next, farthest)
    }
}

/// True if the line may be crossed at a time and speed.
fn is_legal(signal: &Signal, time_s: f64, speed_mps: f64) -> bool {
    let [green_s, yellow_s, red_s] = signal.lengths_s;
    let into_s = (time_s + signal.offset_s) % (green_s + yellow_s + red_s);
    let usable_s = (REACTION_S + speed_mps / TWICE_YELLOW_MPS2).min(yellow_s);
    into_s < green_s + usable_s
}

/// A row of places.
#[derive(Clone)]
struct Bits(Vec<u64>);

impl Bits {
    fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }

    fn has(&self, place: usize) -> bool {
        self.0.get(place / 64).is_some_and(|word| word >> (place % 64) & 1 == 1)
    }

    fn set(&mut self, place: usize) {
        self.0[place / 64] |= 1 << (place % 64);
    }

    fn clear(&mut self, place: usize) {
        self.0[place / 64] &= !(1 << (place % 64));
    }

    fn last(&self) -> Option<usize> {
        let word = self.0.iter().rposition(|word| *word != 0)?;
        Some(64 * word + 63 - self.0[word].leading_zeros() as usize)
    }

    /// Adds another row, moved ahead by `by` places.
    fn add_shifted(&mut self, other: &Self, by: usize) {
        let (words, bits) = (by / 64, by % 64);
        let mut carried = 0;
        for (word, from) in self.0[words..].iter_mut().zip(&other.0) {
            *word |= from << bits | carried;
            carried = if bits == 0 { 0 } else { from >> (64 - bits) };
        }
    }

    /// Drops the places from `end` on.
    fn keep_below(&mut self, end: usize) {
        let word = end / 64;
        if let Some(first) = self.0.get_mut(word) {
            *first &= (1 << (end % 64)) - 1;
            self.0[word + 1..].fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corridor(offset_s: f64) -> Corridor {
        let signal = Signal { line_m: 200.0, lengths_s: [20.0, 3.0, 20.0], offset_s };
        let (limit_mps, speed_mps, ahead_s) = (10.0, 10.0, 60.0);
        Corridor { limit_mps, speed_mps, ahead_s, signals: vec![signal], lead: None }
    }

    #[test]
    fn a_free_way_is_driven_at_the_limit_and_a_red_is_met_rolling() {
        assert_eq!(earliest_s(&corridor(0.0), 350.0), [20.0, 35.0]);
        // Green at 20 s ends at 17.5 s and its usable yellow at 17.5 + 2.6 s.
        assert_eq!(earliest_s(&corridor(2.5), 350.0), [20.0, 35.0]);
        // At 16.5 + 2.6 s that is over: at the limit when green comes at 39.5 s.
        let waits = earliest_s(&corridor(3.5), 350.0);
        assert!((waits[0] - 39.5).abs() <= 0.5 && (waits[1] - 54.5).abs() <= 0.5, "{waits:?}");
    }

    #[test]
    fn a_start_takes_as_long_as_two_metres_per_second_squared() {
        let stands = Corridor { speed_mps: 0.0, ..corridor(0.0) };
        // 25 m and 5 s to the limit, then 175 m: in yellow, 22.5 s after the start.
        let times = earliest_s(&stands, 350.0);
        assert!((times[0] - 22.5).abs() <= 0.25, "{times:?}");
        let late =
            Corridor { signals: vec![Signal { offset_s: 1.0, ..stands.signals[0] }], ..stands };
        assert!(earliest_s(&late, 350.0)[0] > 41.4);
    }

    #[test]
    fn it_stays_behind_the_lead() {
        let led = (1..100).map(Corridor::new).find(|corridor| corridor.lead.is_some());
        let led = led.expect("two of three have one");
        let end_m = led.last_line_m() + 150.0;
        let alone = Corridor { lead: None, ..led.clone() };
        let (behind, before) = (earliest_s(&led, end_m), earliest_s(&alone, end_m));
        assert!(behind.iter().zip(&before).all(|(behind, before)| behind >= before));
        for (time_s, signal) in behind.iter().zip(&led.signals) {
            let rear_m = led.lead.as_ref().expect("it has one").rear_m(*time_s);
            assert!(rear_m >= signal.line_m + STANDSTILL_GAP_M - led.limit_mps * STEP_S);
        }
    }
}
