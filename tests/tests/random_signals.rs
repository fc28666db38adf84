//! Random signals, speeds and leads through the real processes: no red light and no collision. The law's
//! property tests check thousands of such drives.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::fmt::Write;
use system_tests::Corner;

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const CASES: u64 = 12;

struct Random(Pcg64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        let unit = (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + unit * (high - low)
    }
}

/// A road with three signals and a lead that may stop and go, with a noisy radar.
fn scenario(seed: u64) -> String {
    let mut random = Random(Pcg64::seed_from_u64(seed));
    let speed = random.between(5.0, 18.0);
    let limit = random.between(speed, 20.0);
    let mut text = format!(
        "schema_version = 1\nname = \"random\"\nduration_s = 90\nseed = {seed}\n\
         set_speed_mps = {limit:.3}\nspeed_limit_mps = {limit:.3}\n\
         [plant]\ninitial_speed_mps = {speed:.3}\n[controller]\nname = \"cacc-mpc\"\n"
    );
    let mut line = random.between(120.0, 250.0);
    for id in 1..=3 {
        let green = random.between(6.0, 30.0);
        let red = random.between(6.0, 40.0);
        let offset = random.between(0.0, green + red);
        write!(
            text,
            "[[v2x.signals]]\nintersection_id = {id}\nstop_line_m = {line:.2}\n\
             offset_s = {offset:.2}\nprogram = [{{ phase = \"green\", duration_s = {green:.2} }}, \
             {{ phase = \"yellow\", duration_s = 4 }}, {{ phase = \"red\", duration_s = {red:.2} }}]\n"
        )
        .expect("a string takes all");
        line += random.between(150.0, 400.0);
    }
    if !seed.is_multiple_of(3) {
        let gap = speed * random.between(1.5, 4.0) + 10.0;
        write!(
            text,
            "[[actors]]\nname = \"lead\"\ngap_m = {gap:.2}\ninitial_speed_mps = {speed:.3}\n\
             leaves_at_s = {:.1}\nprofile.steps = [\n\
             {{ time_s = {:.1}, speed_mps = {:.2}, acceleration_mps2 = {:.2} }},\n\
             {{ time_s = {:.1}, speed_mps = {:.2}, acceleration_mps2 = {:.2} }}]\n",
            random.between(30.0, 85.0),
            random.between(3.0, 15.0),
            random.between(0.0, 12.0),
            random.between(0.5, 3.0),
            random.between(20.0, 30.0),
            random.between(5.0, 18.0),
            random.between(0.5, 2.0),
        )
        .expect("a string takes all");
    }
    text
}

#[test]
fn no_red_light_and_no_collision() {
    let corner = Corner::new(PROGRAM);
    let mut crossed = 0;
    for seed in 0..CASES {
        let file = corner.path().join("random.toml");
        std::fs::write(&file, scenario(seed)).expect("our own directory");
        let output = corner.run(&["run", "random.toml", "--mode", "lockstep", "--json"]);
        let said = system_tests::text(&output);
        assert!(output.status.success(), "seed {seed}: {said}\n{}", scenario(seed));
        let summary: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("one JSON object");
        assert_eq!(summary["outcome"], "completed", "seed {seed}");
        crossed += u32::from(!summary["control"]["stop_line_crossing_s"].is_null());
    }
    assert!(
        crossed > CASES as u32 / 2,
        "the signals were met: {crossed} of {CASES} crossed the first"
    );
}
