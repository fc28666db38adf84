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
        let own =
            |d: &&Detection| (d.range_m - 50.0).abs() < 1.0 && (d.range_rate_mps + 2.0).abs() < 1.0;
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
