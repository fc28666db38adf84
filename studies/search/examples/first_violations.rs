//! The first violation of each method, over repetitions.
//!
//!     cargo run --release -p search --example first_violations -- 10 300 gp studies/search/problems/timing-brake.toml …
//!
//! Arguments: repetitions, budget of a search, methods (all if none is named), files. A search without a violation
//! counts as its budget.

use std::time::Instant;

use frame::Command;
use frame::batch::share;
use indicatif::ProgressBar;
use search::method::MethodName;
use search::problem::Problem;
use search::{SearchArguments, first_violation};
use supervise::Error;

const METHODS: [MethodName; 3] = [MethodName::Random, MethodName::Sobol, MethodName::Gp];

fn main() -> Result<(), Error> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number =
        |place: usize, usual| words.get(place).and_then(|word| word.parse().ok()).unwrap_or(usual);
    let (repetitions, budget) = (number(0, 10), number(1, 400));
    println!(
        "problem, method: first violation at run (a dash: none in {budget}), median, runs a second"
    );
    let method_of = |word: &String| METHODS.into_iter().find(|method| method.name() == word);
    let named: Vec<MethodName> = words.iter().filter_map(method_of).collect();
    let methods = if named.is_empty() { METHODS.to_vec() } else { named };
    for file in words.iter().skip(2).filter(|word| method_of(word).is_none()) {
        let Command { study, options } =
            Command::<SearchArguments>::read(&[file]).expect("the name of a file");
        let problem = Problem::open(&study, &options.group)?;
        for &method in &methods {
            let begun = Instant::now();
            let work = |place: usize, going_on: &dyn Fn() -> bool| {
                let which = (method, 1_000 + place as u64);
                first_violation(&problem, which, budget, &options.group, going_on)
            };
            let mut found: Vec<Option<usize>> = vec![None; repetitions];
            let mut each = |place: usize, first: Result<Option<usize>, Error>| {
                found[place] = first?;
                Ok(())
            };
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            share(repetitions, cores, &ProgressBar::hidden(), &work, &mut each)?;
            let mut counted: Vec<usize> =
                found.iter().map(|first| first.unwrap_or(budget)).collect();
            let runs: usize = counted.iter().sum();
            counted.sort_unstable();
            let median = counted[(repetitions - 1) / 2].midpoint(counted[repetitions / 2]);
            let all =
                found.iter().map(|one| one.map_or_else(|| "-".to_owned(), |run| run.to_string()));
            println!(
                "{}, {}: {}; median {median}; {:.0}/s",
                problem.name,
                method.name(),
                all.collect::<Vec<_>>().join(" "),
                runs as f64 / begun.elapsed().as_secs_f64()
            );
        }
    }
    Ok(())
}
