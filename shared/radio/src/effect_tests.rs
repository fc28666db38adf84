//! Effect of each number of the carriers, for the origins in their table.
//!
//! Clocks: twenty pairs of hosts whose clocks drift apart by 60 parts per million are compared for two minutes. A way
//! takes 2 ms, and an exponential rest of 3 ms in the mean. Every twentieth one takes 40 ms more.
//!
//! Numbers: a sender of 20,000 frames, of which 2 % are lost and 1 % overtaken by up to 40 others. One frame has a
//! wrong number. The sender starts again twice: once far from its last number, and once near to it.
//!
//! ```sh
//! cargo test --release -p radio --lib each_number -- --ignored --nocapture
//! ```

use parameters::effect::{Figure, effects};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;

use crate::clock::{Comparison, Exchange};
use crate::numbers::{NUMBERS, Numbers};
use crate::sequence::Sequence;

static FIGURES: [Figure; 6] = [
    Figure::percent("uncertainty in the first second", "ms", 2.0),
    Figure::percent("uncertainty later", "ms", 2.0),
    Figure::percent("error later", "ms", 2.0),
    Figure::difference("time outside of the uncertainty", "%", 0.5),
    Figure::difference("questions", "", 1.0),
    Figure::difference("new frames refused", "", 1.0),
];

/// Drift of the other clock.
const DRIFT_PPM: f64 = 60.0;
const PAIRS: u64 = 20;
const DURATION_S: f64 = 120.0;

/// The figures of one pair of hosts, as sums over instants of 0.1 s.
#[derive(Default)]
struct Sums {
    first_ms: f64,
    later_ms: f64,
    error_ms: f64,
    outside: f64,
    instants: [f64; 2],
    questions: f64,
}

fn ns(time_s: f64) -> i64 {
    (1e9 * time_s) as i64
}

fn compare(numbers: &Numbers, seed: u64, sums: &mut Sums) {
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut way_s = || {
        let rest_s = -0.003 * random::open_uniform(&mut generator).ln();
        0.002 + rest_s + if random::uniform(&mut generator) < 0.05 { 0.04 } else { 0.0 }
    };
    let offset_s = |now_s: f64| 7.0 + 1e-6 * DRIFT_PPM * now_s;
    let mut clock = Comparison::default();
    clock.numbers = *numbers;
    let (mut ask_at_s, mut asked, mut answers) = (0.0, 0, Vec::new());
    for now_s in (1..(10.0 * DURATION_S) as u64).map(|k| 0.1 * k as f64) {
        while ask_at_s < now_s {
            let (heard_s, back_s) = (ask_at_s + way_s(), way_s());
            let returned_s = heard_s + back_s;
            let there_ns = ns(heard_s + offset_s(heard_s));
            answers.push(Exchange {
                asked_ns: ns(ask_at_s),
                heard_ns: there_ns,
                answered_ns: there_ns,
                returned_ns: ns(returned_s),
            });
            asked += 1;
            let is_first = asked < numbers.first_questions;
            ask_at_s += if is_first { numbers.first_period_s } else { numbers.period_s };
        }
        answers.retain(|answer| {
            let has_come = answer.returned_ns <= ns(now_s);
            if has_come {
                clock.take(*answer);
            }
            !has_come
        });
        let Some(found) = clock.difference(ns(now_s)) else { continue };
        let uncertainty_ms = 1e-6 * found.uncertainty_ns as f64;
        let error_ms = (1e-6 * found.offset_ns as f64 - 1e3 * offset_s(now_s)).abs();
        let late = usize::from(now_s > 1.0);
        sums.instants[late] += 1.0;
        *if late == 1 { &mut sums.later_ms } else { &mut sums.first_ms } += uncertainty_ms;
        if late == 1 {
            sums.error_ms += error_ms;
        }
        sums.outside += f64::from(u8::from(error_ms > uncertainty_ms));
    }
    sums.questions += f64::from(asked);
}

/// New frames that are refused.
fn refused(numbers: &Numbers) -> f64 {
    let mut generator = Pcg64::seed_from_u64(1);
    let mut sequence = Sequence::default();
    sequence.numbers = *numbers;
    let (mut sent, mut late) = (Vec::new(), Vec::<(usize, u64)>::new());
    for k in 0..20_000_usize {
        let number = match k {
            5_000 => 1 << 40,
            // Far from the last number, then some frames before the number that was the last.
            ..10_000 => 100_000 + k as u64,
            10_000..15_000 => k as u64 - 10_000,
            _ => k as u64 - 10_200,
        };
        match random::uniform(&mut generator) {
            ..0.02 => {}
            ..0.03 => {
                late.push((k + 1 + (40.0 * random::uniform(&mut generator)) as usize, number))
            }
            _ => sent.push(number),
        }
        sent.extend(late.extract_if(.., |(due, _)| *due <= k).map(|(_, number)| number));
    }
    sent.into_iter().map(|number| f64::from(u8::from(!sequence.take(number)))).sum()
}

fn figures(numbers: &Numbers) -> Vec<f64> {
    let mut sums = Sums::default();
    (0..PAIRS).for_each(|seed| compare(numbers, seed, &mut sums));
    let [first, later] = sums.instants;
    vec![
        sums.first_ms / first,
        sums.later_ms / later,
        sums.error_ms / later,
        100.0 * sums.outside / (first + later),
        sums.questions / PAIRS as f64,
        refused(numbers),
    ]
}

#[test]
#[ignore = "it judges nothing: it prints what the origins in `numbers.rs` state"]
fn each_number_has_a_measured_effect() {
    let base = figures(&NUMBERS);
    for (figure, value) in FIGURES.iter().zip(&base) {
        println!("{}", figure.text(*value));
    }
    effects(&NUMBERS, &FIGURES, &base, figures).for_each(|line| println!("{line}"));
    assert_eq!(base[3], 0.0, "the truth is within the uncertainty");
}
