//! The draws of each run: its number alone decides.
//!
//! A receiver without signatures cannot find a unit that is wrong from its first frame on. Only another unit that
//! contradicts it would help. Such units are left out: the air is clear at first. Only the map of the first
//! intersection may move its stop line away from the vehicle, after it was received. The other maps move their lines
//! towards the vehicle.

use rand_core::SeedableRng;
use rand_pcg::Pcg64;

/// Keys of the air with their largest values; each is drawn in one run of three.
const AIR: [(&str, f64); 10] = [
    ("v2x.air.loss_probability", 0.5),
    ("v2x.air.burst_begin_probability", 0.1),
    ("v2x.air.delay_ms", 400.0),
    ("v2x.air.jitter_ms", 300.0),
    ("v2x.air.reorder_probability", 0.3),
    ("v2x.air.duplicate_probability", 0.5),
    ("v2x.air.truncate_probability", 0.3),
    ("v2x.air.bit_flip_probability", 0.2),
    ("v2x.air.replay_probability", 0.3),
    ("v2x.air.replay_age_s", 60.0),
];
/// Offsets of clocks, ms, and drifts, millionths.
const CLOCKS: [(&str, f64); 4] = [
    ("v2x.unit.clock_offset_ms", 100.0),
    ("v2x.unit.clock_drift_ppm", 100.0),
    ("v2x.obu.clock_offset_ms", 100.0),
    ("v2x.obu.clock_drift_ppm", 100.0),
];

/// Keys of run `number`.
pub fn keys(number: u64) -> Vec<String> {
    let mut generator = Pcg64::seed_from_u64(number);
    let mut uniform = |low: f64, high: f64| low + (high - low) * random::uniform(&mut generator);
    let mut keys = Vec::new();
    for signal in 0..3 {
        keys.push(format!("v2x.signals.{signal}.offset_s={:.1}", uniform(0.0, 60.0)));
    }
    // The air gets bad after the vehicle can have received the first signal.
    keys.push(format!("v2x.air.from_s={:.1}", uniform(2.0, 60.0)));
    if uniform(0.0, 1.0) < 0.5 {
        keys.push(format!("v2x.air.for_s={:.1}", uniform(1.0, 60.0)));
    }
    for (key, most) in AIR {
        let (is_drawn, value) = (uniform(0.0, 3.0) < 1.0, uniform(0.0, most));
        let value = if key.ends_with("_ms") { value.round() } else { value };
        if is_drawn {
            keys.push(format!("{key}={value}"));
        }
    }
    for (key, most) in CLOCKS {
        keys.push(format!("{key}={}", uniform(-most, most).round()));
    }
    let (wrong, at_s) = (uniform(0.0, 8.0), uniform(5.0, 90.0));
    let (jump_s, slide, shift_m) = (uniform(-5.0, 5.0), uniform(-1.0, 1.0), uniform(-20.0, 20.0));
    match wrong as u32 {
        0 => keys.push(format!("v2x.unit.contradicted_from_s={at_s:.1}")),
        1 => {
            let is_away = shift_m > 0.0;
            // While the vehicle is on its way to that intersection.
            let at_s = if is_away { 5.0 + (at_s - 5.0) / 85.0 * 25.0 } else { at_s };
            keys.push(format!("v2x.unit.map_changes_at_s={at_s:.1}"));
            keys.push(format!("v2x.unit.map_shift_m={shift_m:.1}"));
            if is_away {
                keys.push("v2x.unit.map_changes_of=1".to_owned());
            }
        }
        2 => {
            keys.push(format!("v2x.unit.countdown_wrong_from_s={at_s:.1}"));
            keys.push(format!("v2x.unit.countdown_jump_s={jump_s:.2}"));
        }
        3 => {
            keys.push(format!("v2x.unit.countdown_wrong_from_s={at_s:.1}"));
            keys.push(format!("v2x.unit.countdown_slide={slide:.3}"));
        }
        _ => {}
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_makes_the_run() {
        assert_eq!(keys(7), keys(7));
        assert_ne!(keys(7), keys(8));
    }
}
