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
    /// Room for `capacity` echoes.
    #[must_use]
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

    /// The echoes.
    #[must_use]
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
    #[must_use]
    pub fn variance(&self, snr: f64) -> f64 {
        let tone = TONE * self.resolution;
        self.floor * self.floor + tone * tone / snr
    }
}

/// The receiver.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// Accuracy of the range, m.
    pub range: Accuracy,
    /// Accuracy of the range rate, m/s.
    pub range_rate: Accuracy,
    /// Accuracy of the azimuth on the axis, rad. The aperture shrinks with the cosine of the azimuth.
    pub azimuth: Accuracy,
    /// Echoes within one cell are merged.
    pub merges: bool,
    /// Threshold over the noise, as a ratio.
    pub threshold: f64,
    /// Mean number of false alarms in a scan.
    pub false_alarms: f64,
    /// Numbers of its noise.
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
#[must_use]
pub fn snr_of(detection: &Detection) -> f64 {
    ratio(detection.snr_db)
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    const RECEIVER: Receiver = Receiver {
        range: Accuracy { resolution: 0.75, floor: 0.1 },
        range_rate: Accuracy { resolution: 0.2, floor: 0.03 },
        azimuth: Accuracy { resolution: 0.05, floor: 0.002 },
        merges: true,
        threshold: 16.0,
        false_alarms: 0.0,
        numbers: Numbers::DEFAULT,
    };

    fn antenna() -> Antenna {
        Antenna::new(15.0, 0.0, 60.0, 150.0)
    }

    fn echo(range_m: f64, power: f64) -> Echo {
        Echo { range_m, range_rate_mps: -2.0, azimuth_rad: 0.1, power, false_alarm: false }
    }

    /// The detections of `scans` scans of the same echoes.
    fn scans(receiver: &Receiver, echoes: &[Echo], scans: i64) -> Vec<Vec<Detection>> {
        let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
        (0..scans)
            .map(|scan| {
                let mut list = Echoes::new(8000, &Numbers::DEFAULT);
                echoes.iter().for_each(|echo| list.add(*echo));
                let received = receiver.detect(1, scan, &antenna(), &mut list, &mut detections);
                detections[..received.count].to_vec()
            })
            .collect()
    }

    /// Marcum's Q function of first order, by its series in Poisson terms. It is the probability that an echo of power
    /// `s` in noise exceeds `threshold`.
    fn marcum(s: f64, threshold: f64) -> f64 {
        let (mut weight, mut term, mut tail, mut sum) =
            (libm::exp(-s), libm::exp(-threshold), libm::exp(-threshold), 0.0);
        for k in 1..400 {
            sum += weight * tail;
            weight *= s / f64::from(k);
            term *= threshold / f64::from(k);
            tail += term;
        }
        sum
    }

    #[test]
    fn the_probability_of_detection_is_marcums() {
        for power in [6.0, 12.0, 16.0, 25.0] {
            let n = 20_000;
            let seen = scans(&RECEIVER, &[echo(50.0, power)], n);
            let seen = seen.iter().filter(|detections| !detections.is_empty()).count() as f64;
            let expected = marcum(power, RECEIVER.threshold);
            let sigma = (expected * (1.0 - expected) / n as f64).sqrt();
            assert!((seen / n as f64 - expected).abs() < 4.0 * sigma, "{power}: {expected}");
        }
    }

    #[test]
    fn the_errors_follow_from_the_signal_to_noise_ratio() {
        for power in [100.0, 10_000.0] {
            let all = scans(&RECEIVER, &[echo(50.0, power)], 20_000);
            let expected = [RECEIVER.range, RECEIVER.range_rate, RECEIVER.azimuth];
            let mut squares = [0.0; 3];
            for detections in &all {
                let d = detections[0];
                let off = [d.range_m - 50.0, d.range_rate_mps + 2.0, d.azimuth_rad - 0.1];
                (0..3).for_each(|i| squares[i] += off[i] * off[i] / all.len() as f64);
            }
            for (square, accuracy) in squares.into_iter().zip(expected) {
                let ratio = square / accuracy.variance(power);
                assert!((ratio - 1.0).abs() < 0.06, "{ratio} at {power}");
            }
        }
    }

    #[test]
    fn one_cell_gives_one_detection_at_the_powers_mean() {
        let receiver = Receiver { range: Accuracy { resolution: 0.75, floor: 0.0 }, ..RECEIVER };
        let pair = [echo(50.0, 3e6), echo(50.6, 1e6)];
        let merged = scans(&receiver, &pair, 1);
        assert_eq!(merged[0].len(), 1);
        assert!((merged[0][0].range_m - 50.15).abs() < 0.01);
        for apart in [
            echo(50.8, 1e6),
            Echo { range_rate_mps: -2.3, ..pair[1] },
            Echo { azimuth_rad: 0.16, ..pair[1] },
        ] {
            assert_eq!(scans(&receiver, &[pair[0], apart], 1)[0].len(), 2);
        }
        let keeps_apart = Receiver { merges: false, ..receiver };
        assert_eq!(scans(&keeps_apart, &pair, 1)[0].len(), 2);
    }

    #[test]
    fn false_alarms_are_poisson_and_everywhere() {
        let receiver = Receiver { false_alarms: 0.5, ..RECEIVER };
        let all = scans(&receiver, &[], 5000);
        let (mut sum, mut squares) = (0.0, 0.0);
        for detections in &all {
            let count = detections.len() as f64;
            sum += count / 5000.0;
            squares += count * count / 5000.0;
            assert!(detections.iter().all(|d| d.range_m <= 151.0 && d.azimuth_rad.abs() < 0.6));
        }
        assert!((sum - 0.5).abs() < 0.05 && (squares - sum * sum - 0.5).abs() < 0.1);
    }

    #[test]
    fn noise_raises_the_threshold_and_the_rate_of_false_alarms_stays() {
        for false_alarms in [10.0, 50.0, 200.0] {
            let receiver = Receiver { false_alarms, ..RECEIVER };
            let all = scans(&receiver, &[], 2000);
            let mean = all.iter().map(|detections| detections.len() as f64).sum::<f64>() / 2000.0;
            assert!((3.5..4.5).contains(&mean), "{mean} of {false_alarms}");
        }
        // A weak echo pays for it, a strong one does not.
        let seen = |false_alarms: f64, power: f64| {
            let receiver = Receiver { false_alarms, ..RECEIVER };
            let all = scans(&receiver, &[echo(50.0, power)], 2000);
            let own = |d: &&Detection| {
                (d.range_m - 50.0).abs() < 1.0 && (d.range_rate_mps + 2.0).abs() < 1.0
            };
            all.iter().filter(|detections| detections.iter().any(|d| own(&d))).count()
        };
        assert!(seen(200.0, 16.0) < seen(0.0, 16.0) - 300);
        assert_eq!(seen(200.0, 200.0), 2000);
    }

    #[test]
    fn detections_without_room_are_counted_and_the_nearest_are_kept() {
        let receiver = Receiver { false_alarms: 0.0, ..RECEIVER };
        let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
        let mut list = Echoes::new(4096, &Numbers::DEFAULT);
        (0..1500).for_each(|k| list.add(echo(0.1 * f64::from(k), 1e6)));
        let receiver = Receiver { merges: false, ..receiver };
        let received = receiver.detect(1, 0, &antenna(), &mut list, &mut detections);
        assert_eq!(received.count, MAX_DETECTIONS);
        assert_eq!(received.left_out, 1500 - MAX_DETECTIONS as u64);
        let farthest = detections.iter().map(|d| d.range_m).fold(0.0, f64::max);
        assert!(farthest < 120.0, "{farthest}");
    }

    #[test]
    fn a_weak_echo_has_the_cross_section_that_was_put_in() {
        let antenna = antenna();
        let direct = antenna.echo((80.0, 0.0), (0.0, 0.0), || 10.0).expect("in sight");
        let detections = &scans(&RECEIVER, &[direct], 1)[0];
        assert!((detections[0].rcs_dbsm - 10.0).abs() < 3.0, "{detections:?}");
    }
}
