//! Random drives with the radar's detections, judged by drivers that do not use the code under test.
//!
//! | kind | what happens |
//! |---|---|
//! | steady | the ego follows a lead of its own speed |
//! | clutter | the same with 50 false alarms in a scan |
//! | queue | the ego passes a queue that stands in the next lane |
//! | two-wheeler | the ego passes a two-wheeler that stands 0.5 to 1 m beside its side |
//! | slower | the ego comes up to a slower or standing car and does nothing |
//! | braking | the lead brakes and the ego answers late and weakly |
//! | cut-in | a slower car cuts in and then brakes, and the ego answers late and weakly |
//!
//! Two drivers judge each drive. A collision was avoidable if 6 m/s², 0.35 s after the danger began, keeps the ego
//! clear. An intervention was needless if 1.5 m/s² from its first instant on would have kept the ego clear.

mod drives {
    pub mod kinds;
    pub mod simulation;
}

use drives::kinds::{KINDS, Kind, draw};
use drives::simulation::{Result, drive};

/// Drives of each kind. `DRIVES=200` in the environment drives more.
fn count() -> u64 {
    std::env::var("DRIVES").ok().and_then(|text| text.parse().ok()).unwrap_or(12)
}

fn all(kind: Kind) -> Vec<(u64, Result)> {
    (0..count()).map(|seed| (seed, drive(&draw(kind, seed)))).collect()
}

#[test]
fn no_collision_that_a_careful_driver_avoids_and_no_needless_intervention() {
    for kind in KINDS {
        let results = all(kind);
        let seeds = |of: fn(&Result) -> bool| -> Vec<u64> {
            results.iter().filter(|(_, result)| of(result)).map(|(seed, _)| *seed).collect()
        };
        let (avoidable, needless) = (seeds(|r| r.is_avoidable()), seeds(|r| r.is_needless));
        let braked = results.iter().filter(|(_, result)| result.braked).count();
        println!(
            "{kind:?}: {} drives, {braked} braked, avoidable {avoidable:?}, needless {needless:?}",
            results.len()
        );
        assert!(avoidable.is_empty(), "{kind:?}: {avoidable:?}");
        assert!(needless.is_empty(), "{kind:?}: {needless:?}");
        let never = matches!(kind, Kind::Steady | Kind::Clutter | Kind::Queue | Kind::TwoWheeler);
        assert!(!never || braked == 0, "{kind:?}: {braked} braked");
    }
}

#[test]
fn traction_and_brakes_change_with_the_stated_jerk_alone() {
    for seed in 0..count() {
        let result = drive(&draw(Kind::Slower, seed));
        // 12.65 m/s³ over a period of 10 ms.
        assert!(result.largest_step_mps2 < 0.13, "seed {seed}: {result:?}");
    }
}
