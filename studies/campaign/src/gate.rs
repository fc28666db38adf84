//! Figures of each run, by which a campaign is compared with an earlier one.

use super::record::Record;
use report::gate::Sample;
use report::results::Good;
use runtime::Mode;
use supervise::report::Outcome;

/// The compared figures of a run.
pub struct Run {
    controller: String,
    values: [Option<f64>; 5],
}

/// Name, good values and least difference of each.
const FIGURES: [(&str, Good, f64); 5] = [
    ("completed", Good::More, 0.0),
    ("min_gap_m", Good::More, 0.005),
    ("min_ttc_s", Good::More, 0.005),
    ("interventions", Good::Less, 0.0),
    ("recovery_us", Good::Less, 0.5),
];

impl Run {
    pub fn of(record: &Record) -> Self {
        let measured = &record.measured;
        let completed = f64::from(u8::from(record.outcome == Outcome::Completed));
        let longest_us = measured.recovery_us.iter().copied().reduce(f64::max);
        let values = [
            Some(completed),
            measured.min_gap_m,
            measured.min_ttc_s,
            Some(measured.interventions as f64),
            longest_us,
        ];
        Self { controller: record.controller.clone(), values }
    }
}

/// The figures of all runs, law by law. In simulated time each run repeats exactly.
pub fn samples(runs: &[Run], mode: Mode) -> Vec<Sample> {
    let mut laws: Vec<&String> = runs.iter().map(|run| &run.controller).collect();
    laws.sort_unstable();
    laws.dedup();
    let of = |law: &String, place: usize| {
        let (figure, good, shown) = FIGURES[place];
        let own = runs.iter().filter(|run| run.controller == *law);
        let is_exact = mode == Mode::Lockstep && place == 0;
        let values = own.map(|run| run.values[place]).collect();
        Sample { of: law.clone(), figure: figure.to_owned(), values, good, shown, is_exact }
    };
    let all = laws.iter().flat_map(|law| (0..FIGURES.len()).map(|place| of(law, place)));
    all.filter(|sample| sample.values.iter().any(Option::is_some)).collect()
}
