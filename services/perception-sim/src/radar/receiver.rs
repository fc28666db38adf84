//! The receiver: what resolution merges, what rises above the threshold, and how exactly it is measured.
//!
//! * Echoes reach one cell of the receiver if range, range rate and azimuth all differ by less than the resolution.
//!   They come out as one, at their mean weighted by power.
//! * An echo of power s (noise: 1) meets complex Gaussian noise n; it is detected when
//!   |√s + n|² exceeds the threshold. Its probability of detection is therefore Marcum's Q function
//!   of s and the threshold, and with Swerling's fluctuation drawn before, Swerling's.
//! * Range, range rate and azimuth each come from the frequency of a sampled tone. Its error has at least the standard
//!   deviation √6/(2π) · resolution / √(S/N). Imperfections of the sensor add a floor.
//! * Noise alone exceeds the threshold in the measured volume. The number of times is Poisson distributed.
//! * The receiver keeps a constant false-alarm rate. Noise may exceed the set threshold more than
//!   [`Numbers::alarms_kept`] times in a scan. The receiver then raises the threshold for that scan. Noise power is
//!   exponential, so that ln(n / kept) more leaves that number of n alarms.
//!
//! Sources: Swerling (1960) as in [`super::echo`]; Rife and Boorstyn, Single-tone parameter estimation
//! from discrete-time observations, IEEE Trans. Information Theory 20 (1974) 591; Richards, Fundamentals
//! of Radar Signal Processing (2nd ed.), chapters 6 and 7.

use messages::{Detection, MAX_DETECTIONS};

use super::echo::{Antenna, Echo, decibels, ratio};
use super::numbers::Numbers;
use crate::random::Random;

/// √6/(2π).
const TONE: f64 = 0.389_848_400_616_838_7;
/// Number of the random numbers' stream; vehicles have those below.
const STREAM: u64 = 1 << 21;

/// Echoes on their way to the receiver, at most as many as there is room for.
#[derive(Clone, Debug)]
pub struct Echoes {
    list: Vec<Echo>,
    capacity: usize,
    least_power: f64,
    left_out: u64,
}

impl Echoes {
    pub fn new(capacity: usize, numbers: &Numbers) -> Self {
        let least_power = numbers.least_power;
        Self { list: Vec::with_capacity(capacity), capacity, least_power, left_out: 0 }
    }

    /// Adds an echo that is not lost in noise.
    pub fn add(&mut self, echo: Echo) {
        if echo.power < self.least_power {
            return;
        }
        if self.list.len() < self.capacity {
            self.list.push(echo);
        } else {
            self.left_out += 1;
        }
    }

    /// Makes room for the next scan.
    pub fn clear(&mut self) {
        self.list.clear();
        self.left_out = 0;
    }

    pub fn list(&self) -> &[Echo] {
        &self.list
    }
}

/// Resolution and accuracy of one measured quantity, in its unit.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// Two echoes nearer to each other than this are one.
    pub resolution: f64,
    /// Standard deviation that no signal-to-noise ratio improves.
    pub floor: f64,
}

impl Accuracy {
    /// Variance of a measurement at a signal-to-noise ratio.
    pub fn variance(&self, snr: f64) -> f64 {
        let tone = TONE * self.resolution;
        self.floor * self.floor + tone * tone / snr
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    pub range: Accuracy,
    pub range_rate: Accuracy,
    /// Accuracy of the azimuth on the axis, rad. The aperture shrinks with the cosine of the azimuth.
    pub azimuth: Accuracy,
    /// Echoes within one cell are merged.
    pub merges: bool,
    /// Threshold over the noise, as a ratio.
    pub threshold: f64,
    pub false_alarms: f64,
    pub numbers: Numbers,
}

/// Account of the echoes of one scan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Received {
    /// Detections written.
    pub count: usize,
    /// Echoes and detections without room.
    pub left_out: u64,
}

impl Receiver {
    /// Turns echoes into detections in the order of their ranges. The nearest detections are kept; the ones without
    /// room in `detections` are counted.
    pub fn detect(
        &self,
        seed: u64,
        time_ns: i64,
        antenna: &Antenna,
        echoes: &mut Echoes,
        detections: &mut [Detection; MAX_DETECTIONS],
    ) -> Received {
        let mut random = Random::of_scan(seed, STREAM, time_ns);
        let threshold = self.add_false_alarms(antenna, &mut random, echoes);
        let list = &mut echoes.list;
        list.sort_unstable_by(|a, b| a.range_m.total_cmp(&b.range_m));
        if self.merges {
            self.merge(list);
        }
        let mut received = Received { count: 0, left_out: echoes.left_out };
        for echo in list.iter().filter(|echo| echo.power > 0.0) {
            let Some(snr) = detected(echo, threshold, &mut random) else { continue };
            match detections.get_mut(received.count) {
                Some(place) => {
                    *place = self.measure(echo, snr, antenna, &mut random);
                    received.count += 1;
                }
                None => received.left_out += 1,
            }
        }
        received
    }

    /// Adds what noise makes, and returns the threshold of this scan.
    fn add_false_alarms(&self, antenna: &Antenna, random: &mut Random, echoes: &mut Echoes) -> f64 {
        if self.false_alarms <= 0.0 {
            return self.threshold;
        }
        let half = antenna.half_field_of_view_rad;
        let fastest_mps = self.numbers.largest_range_rate_mps;
        let alarms = random.poisson(self.false_alarms);
        for _ in 0..alarms {
            echoes.add(Echo {
                range_m: random.between(0.0, antenna.max_range_m),
                range_rate_mps: random.between(-fastest_mps, fastest_mps),
                azimuth_rad: random.between(-half, half),
                power: self.threshold + random.exponential(),
                false_alarm: true,
            });
        }
        self.threshold + libm::log((f64::from(alarms) / self.numbers.alarms_kept).max(1.0))
    }

    /// Merges what is in one cell; `list` is in the order of ranges.
    fn merge(&self, list: &mut [Echo]) {
        for first in 0..list.len() {
            let (head, tail) = list.split_at_mut(first + 1);
            let echo = &mut head[first];
            if echo.power <= 0.0 || echo.false_alarm {
                continue;
            }
            let origin = *echo;
            let near = |other: &&mut Echo| other.range_m - origin.range_m < self.range.resolution;
            let (mut power, mut moment) = (origin.power, [0.0; 3]);
            for other in tail.iter_mut().take_while(near) {
                let off = [
                    other.range_m - origin.range_m,
                    other.range_rate_mps - origin.range_rate_mps,
                    other.azimuth_rad - origin.azimuth_rad,
                ];
                if other.power <= 0.0
                    || other.false_alarm
                    || off[1].abs() >= self.range_rate.resolution
                    || off[2].abs() >= self.azimuth.resolution
                {
                    continue;
                }
                power += other.power;
                for (sum, off) in moment.iter_mut().zip(off) {
                    *sum += other.power * off;
                }
                other.power = 0.0;
            }
            echo.range_m += moment[0] / power;
            echo.range_rate_mps += moment[1] / power;
            echo.azimuth_rad += moment[2] / power;
            echo.power = power;
        }
    }

    fn measure(&self, echo: &Echo, snr: f64, antenna: &Antenna, random: &mut Random) -> Detection {
        let mut noisy = |value: f64, variance: f64| value + variance.sqrt() * random.normal();
        let aperture = libm::cos(echo.azimuth_rad).max(0.1);
        let azimuth_variance = self.azimuth.variance(snr) / (aperture * aperture);
        let square_metre = antenna.power_of_square_metre(echo.range_m, echo.azimuth_rad);
        Detection {
            range_m: noisy(echo.range_m, self.range.variance(snr)).max(0.0),
            range_rate_mps: noisy(echo.range_rate_mps, self.range_rate.variance(snr)),
            azimuth_rad: noisy(echo.azimuth_rad, azimuth_variance),
            snr_db: decibels(snr),
            rcs_dbsm: decibels(snr / square_metre),
            flags: 0,
            ambiguity_group: 0,
        }
    }
}

/// Power of the echo with this scan's noise, if that exceeds the threshold.
///
/// The noise has the amplitude r with r² = -ln u, u uniform, and any phase. In phase with the echo it is too weak if
/// r < √threshold - √power =: m. That is so if u > 1 / (1 + m² + m⁴/2 + m⁶/6), which is above exp(-m²). Most weak echoes
/// are left out by this, without a logarithm.
fn detected(echo: &Echo, threshold: f64, random: &mut Random) -> Option<f64> {
    if echo.false_alarm {
        return (echo.power > threshold).then_some(echo.power);
    }
    let (u, phase) = (1.0 - random.uniform(), std::f64::consts::TAU * random.uniform());
    let amplitude = echo.power.sqrt();
    let missing = (threshold.sqrt() - amplitude).max(0.0);
    let square = missing * missing;
    if u * (1.0 + square * (1.0 + 0.5 * square * (1.0 + square * (1.0 / 3.0)))) > 1.0 {
        return None;
    }
    let noise = (-libm::log(u)).sqrt();
    let (sine, cosine) = libm::sincos(phase);
    let (in_phase, quadrature) = (amplitude + noise * cosine, noise * sine);
    let power = in_phase * in_phase + quadrature * quadrature;
    (power > threshold).then_some(power)
}

/// Signal-to-noise ratio of a detection.
pub fn snr_of(detection: &Detection) -> f64 {
    ratio(detection.snr_db)
}

#[cfg(test)]
mod tests;
