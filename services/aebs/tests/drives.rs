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

use aebs::numbers::Numbers;
use parameters::{Row, Table};

use drives::kinds::{KINDS, Kind, draw};
use drives::simulation::{Result, drive};

/// Drives of each kind. `DRIVES=200` in the environment drives more.
fn count() -> u64 {
    std::env::var("DRIVES").ok().and_then(|text| text.parse().ok()).unwrap_or(12)
}

fn all(kind: Kind) -> Vec<(u64, Result)> {
    (0..count()).map(|seed| (seed, drive(&draw(kind, seed), Numbers::DEFAULT))).collect()
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
        let result = drive(&draw(Kind::Slower, seed), Numbers::DEFAULT);
        // 12.65 m/s³ over a period of 10 ms.
        assert!(result.largest_step_mps2 < 0.13, "seed {seed}: {result:?}");
    }
}

/// Prints what a fifth less and a fifth more of each number does, for the origins in the table. `NUMBERS=a,b` in the
/// environment names some of them.
#[test]
#[ignore = "it takes minutes: DRIVES=40 cargo test -p aebs --test drives -- --ignored --nocapture"]
fn what_each_number_does() {
    let judge = |numbers: Numbers| {
        let drives = KINDS[2..].iter().flat_map(|kind| (0..count()).map(|seed| draw(*kind, seed)));
        drives.fold([0; 3], |[avoidable, needless, braked], scene| {
            let result = drive(&scene, numbers);
            [
                avoidable + u32::from(result.is_avoidable()),
                needless + u32::from(result.is_needless),
                braked + u32::from(result.braked),
            ]
        })
    };
    let now = judge(Numbers::DEFAULT);
    println!("avoidable, needless, braked: {now:?}");
    let asked = std::env::var("NUMBERS").ok();
    let is_asked =
        |name: &str| asked.as_ref().is_none_or(|asked| asked.split(',').any(|asked| asked == name));
    let rows = Numbers::ROWS.iter().enumerate().filter(|(_, row)| is_asked(row.name));
    for (row, Row { name, .. }) in rows {
        let [less, more] = [0.8, 1.2].map(|factor| judge(Numbers::DEFAULT.scaled(row, factor)));
        println!("{name}: less {less:?}, more {more:?}");
    }
    assert!(now[2] > 0);
}
