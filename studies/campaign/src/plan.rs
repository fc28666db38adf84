//! Way from a campaign to its runs: every combination of scenario, controller and fault, with every
//! seed.

use super::file::Campaign;
use super::record::Planned;
use super::template::{Drawing, check, drawn};
use super::variation::Variants;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use scenario::Setting;
use supervise::{Error, UsageError};

/// Largest number of runs of a campaign.
const MAX_RUNS: usize = 1_000_000;

/// The runs of a campaign. Each is made when its turn comes, since all of them do not fit in memory.
#[derive(Debug)]
pub struct Plan {
    campaign: Campaign,
    controllers: Vec<Option<String>>,
    faults: Vec<Drawing>,
    variants: Option<Variants>,
    /// Runs of the whole campaign, the fixed ones last.
    all: usize,
    /// Runs that are not fixed.
    drawn: usize,
    /// The numbers of the runs of a sample, in order; none: all are done.
    sampled: Option<Vec<usize>>,
}

/// All runs of a campaign. Neighbours belong to different combinations, so that a part of the campaign covers each
/// combination.
pub fn plan(campaign: &Campaign) -> Result<Plan, Error> {
    let variants = campaign.variation.as_deref().map(Variants::open).transpose()?;
    let named: Vec<_> = campaign.controllers.iter().cloned().map(Some).collect();
    let controllers = if named.is_empty() { vec![None] } else { named };
    for (key, value) in campaign.settings.values().flatten() {
        check(key, value)?;
    }
    let faults = Drawing::all(&campaign.faults, campaign.faults_per_run)?;
    let seeds = campaign.seeds.get();
    let values = variants.as_ref().map_or(1, Variants::len);
    let combinations = campaign.scenarios.len() * values * controllers.len() * faults.len();
    let fixed = campaign.cases.iter().map(|case| case.seeds.get() as usize).sum::<usize>();
    let fixed = fixed.saturating_mul(controllers.len());
    let drawn = combinations.checked_mul(seeds as usize).filter(|runs| *runs <= MAX_RUNS);
    let Some((drawn, all)) = drawn.map(|drawn| (drawn, drawn.saturating_add(fixed))) else {
        let why = format_args!("{combinations} combinations with {seeds} seeds each");
        let expected = format_args!("at most {MAX_RUNS} runs");
        return Err(UsageError::at("the campaign", why, expected).into());
    };
    let sampled = campaign.sample.map(|sample| draw_runs(all, sample.get(), campaign.first_seed));
    Ok(Plan { campaign: campaign.clone(), controllers, faults, variants, all, drawn, sampled })
}

impl Plan {
    /// Number of runs that are done.
    pub fn len(&self) -> usize {
        self.sampled.as_ref().map_or(self.all, Vec::len)
    }

    /// Number of runs of the whole campaign; a sample does some of them.
    pub fn whole(&self) -> usize {
        self.all
    }

    /// Number of combinations of a variation that break a constraint of its scenario.
    pub fn left_out(&self) -> usize {
        self.variants.as_ref().map_or(0, |variants| variants.left_out)
    }

    /// The number of the run at a place among those that are done.
    pub fn number(&self, place: usize) -> usize {
        self.sampled.as_ref().map_or(place, |sampled| sampled[place])
    }

    /// The run at a place among those that are done.
    pub fn at(&self, place: usize) -> Result<Planned, UsageError> {
        self.get(self.number(place))
    }

    /// A run of each scenario and controller without its faults.
    pub fn without_faults(&self) -> Vec<Planned> {
        let mut runs: Vec<Planned> = Vec::new();
        for scenario in &self.campaign.scenarios {
            for controller in &self.controllers {
                runs.push(Planned {
                    run: runs.len(),
                    scenario: scenario.clone(),
                    controller: controller.clone(),
                    fault: "none".into(),
                    seed: self.campaign.first_seed,
                    settings: self.settings(scenario, self.campaign.first_seed),
                    formulas: self.campaign.formulas.clone(),
                    parameters: self.variants.as_ref().map_or_else(Vec::new, |all| all.get(0)),
                });
            }
        }
        runs
    }

    /// Settings of the run of a scenario with this seed, without its faults.
    fn settings(&self, scenario: &str, seed: u32) -> Vec<Setting> {
        // The streams of the faults count from 0.
        let mut random = Pcg64::new(seed.into(), u128::from(u64::MAX));
        random.next_u64();
        let settings = self.campaign.settings.get(scenario).into_iter().flatten();
        let settings = settings.map(|(key, value)| Setting::new(key, drawn(value, &mut random)));
        self.campaign.set.iter().cloned().chain(settings).collect()
    }

    pub fn first_of_cases(&self) -> impl Iterator<Item = Result<Planned, UsageError>> + '_ {
        let seeds = self.campaign.cases.iter().map(|case| case.seeds.get() as usize);
        let before = seeds.scan(self.drawn, |run, seeds| {
            let first = *run;
            *run += seeds * self.controllers.len();
            Some(first)
        });
        before.map(|run| self.get(run))
    }

    /// A run of a case; `place` counts the runs of all cases.
    fn fixed(&self, run: usize, mut place: usize) -> Option<Planned> {
        let controllers = self.controllers.len();
        for case in &self.campaign.cases {
            let runs = case.seeds.get() as usize * controllers;
            if place >= runs {
                place -= runs;
                continue;
            }
            let number =
                u32::try_from(place / controllers).expect("fewer runs than u32 has numbers");
            return Some(Planned {
                run,
                scenario: case.scenario.clone(),
                controller: self.controllers[place % controllers].clone(),
                fault: format!("case {}", case.name.as_str()),
                seed: self.campaign.first_seed.saturating_add(number),
                settings: self.campaign.set.iter().chain(&case.set).cloned().collect(),
                formulas: self.campaign.formulas.clone(),
                parameters: Vec::new(),
            });
        }
        None
    }

    /// A run by its number in the whole campaign.
    pub fn get(&self, run: usize) -> Result<Planned, UsageError> {
        let place = run.checked_sub(self.drawn);
        if let Some(fixed) = place.and_then(|place| self.fixed(run, place)) {
            return Ok(fixed);
        }
        let Self { campaign, controllers, faults, variants, .. } = self;
        // The last counts fastest.
        let (rest, which) = (run / faults.len(), run % faults.len());
        let (rest, controller) = (rest / controllers.len(), rest % controllers.len());
        let values = variants.as_ref().map_or(1, Variants::len);
        let places = campaign.scenarios.len() * values;
        let (number, place) = (rest / places, rest % places);
        let number = u32::try_from(number).expect("fewer runs than u32 has numbers");
        let seed = campaign.first_seed.saturating_add(number);
        let fault = &faults[which];
        let mut settings = self.settings(&campaign.scenarios[place / values], seed);
        // Controllers meet the same faults; scenarios do not.
        let stream = (place * faults.len() + which) as u128;
        let drawn = Some(fault.draw(seed, stream)?).filter(|drawn| !drawn.is_empty());
        settings.extend(drawn.map(|faults| Setting::faults(&faults)));
        Ok(Planned {
            run,
            scenario: campaign.scenarios[place / values].clone(),
            controller: controllers[controller].clone(),
            fault: fault.label().into(),
            seed,
            settings,
            formulas: campaign.formulas.clone(),
            parameters: variants.as_ref().map_or_else(Vec::new, |all| all.get(place % values)),
        })
    }
}

/// `count` of the numbers below `all`, drawn by a seed, in their order.
fn draw_runs(all: usize, count: usize, seed: u32) -> Vec<usize> {
    let mut random = Pcg64::seed_from_u64(seed.into());
    let mut left = all;
    let mut wanted = count.min(left);
    // Knuth's algorithm S: a run is kept with the probability needed / left.
    let mut keep = |_: &usize| {
        let uniform = random::uniform(&mut random);
        let keep = uniform * (left as f64) < wanted as f64;
        left -= 1;
        wanted -= usize::from(keep);
        keep
    };
    (0..all).filter(|run| keep(run)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use toml::Value;

    fn texts(run: &Planned) -> Vec<String> {
        run.settings.iter().map(Setting::to_string).collect()
    }

    fn campaign(lines: &str) -> Campaign {
        let head = "schema_version = 1\nname = \"x\"\nscenarios = [\"cacc-a\", \"cut-in\"]\n";
        toml::from_str(&format!("{head}{lines}")).expect("a campaign")
    }

    fn runs(lines: &str) -> Vec<Planned> {
        let plan = plan(&campaign(lines)).expect("a plan");
        (0..plan.len()).map(|place| plan.at(place).expect("right faults")).collect()
    }

    const FAULTS: &str = "seeds = 50\ncontrollers = [\"acc-mpc\", \"six-mode\"]
[[faults]]
kind = \"kill\"
service = [\"plant\", \"controller\"]
at_s = [1.0, 3.0]
count = 2
[[faults]]
kind = \"corrupt\"
topic = \"radar/tracks\"
bits = [1, 3]
";

    #[test]
    fn every_combination_has_every_seed() {
        let runs = runs(FAULTS);
        assert_eq!(runs.len(), 2 * 2 * 2 * 50);
        assert!(runs.iter().enumerate().all(|(number, run)| run.run == number));
        let one = runs.iter().filter(|run| {
            run.scenario == "cut-in"
                && run.controller.as_deref() == Some("six-mode")
                && run.fault == "corrupt radar/tracks"
        });
        let seeds: Vec<_> = one.map(|run| run.seed).collect();
        assert_eq!(seeds, (1..=50).collect::<Vec<_>>());
    }

    #[test]
    fn cases_come_after_the_drawn_runs_as_they_are() {
        let cases = "[[cases]]\nname = \"a\"\nscenario = \"cut-in\"\nset = [\"duration_s=9\"]\n\
                     seeds = 3\nfrom = \"a search\"\n[[cases]]\nname = \"b\"\nscenario = \"cacc-a\"\n\
                     set = []\nseeds = 2\nfrom = \"another\"\n";
        let text = format!("set = [\"seed=0\"]\n{FAULTS}{cases}");
        let runs = runs(&text);
        assert_eq!(runs.len(), 2 * 2 * 2 * 50 + (3 + 2) * 2);
        let fixed = &runs[400..];
        assert!(fixed.iter().enumerate().all(|(place, run)| run.run == 400 + place));
        let of = |place: usize| {
            let Planned { scenario, fault, seed, .. } = &fixed[place];
            (scenario.as_str(), fault.as_str(), *seed)
        };
        assert_eq!(of(0), ("cut-in", "case a", 1));
        assert_eq!(of(5), ("cut-in", "case a", 3));
        assert_eq!(of(6), ("cacc-a", "case b", 1));
        assert_eq!(fixed[1].controller.as_deref(), Some("six-mode"));
        assert_eq!(texts(&fixed[0]), ["seed=0", "duration_s=9"]);
        let plan = plan(&campaign(&text)).expect("a plan");
        let first: Vec<_> = plan.first_of_cases().map(|run| run.expect("right").run).collect();
        assert_eq!(first, [400, 406]);
    }

    #[test]
    fn draws_stay_in_their_ranges_and_repeat() {
        let runs = runs(FAULTS);
        assert_eq!(runs, self::runs(FAULTS));
        let faults = |run: &Planned| {
            run.settings.last().expect("faults").value().as_array().expect("a list").clone()
        };
        let mut seen = BTreeSet::new();
        let mut instants = Vec::new();
        for fault in runs.iter().flat_map(faults) {
            match fault["kind"].as_str() {
                Some("kill") => {
                    let at_s = fault["at_s"].as_float().expect("a number");
                    assert!((1.0..=3.0).contains(&at_s), "{at_s}");
                    instants.push(at_s);
                    seen.insert(fault["service"].to_string());
                }
                _ => {
                    let bits = fault["bits"].as_integer().expect("a whole number");
                    assert!((1..=3).contains(&bits), "{bits}");
                    seen.insert(bits.to_string());
                }
            }
        }
        assert_eq!(seen.len(), 5, "every word and every number comes up: {seen:?}");
        let mean = instants.iter().sum::<f64>() / instants.len() as f64;
        assert!((mean - 2.0).abs() < 0.1, "spread over the range: {mean}");
        assert_ne!(instants[0], instants[1], "each of a run's faults is drawn anew");
    }

    #[test]
    fn faults_that_strike_together_have_one_instant_and_two_services() {
        let fault = "seeds = 40\nfaults_per_run = [1, 1]\n[[faults]]\nkind = \"kill\"\ntogether = 2\n\
            service = [\"plant\", \"controller\", \"aebs\"]\nat_s = [1.0, 9.0]\n[[faults]]\n\
            kind = \"kill-helper\"\nhelper = \"launcher\"\nat_s = [1.0, 9.0]\nalone = true\n";
        let runs = runs(fault);
        assert_eq!(runs.len(), 2 * 2 * 40);
        let (mixed, alone): (Vec<_>, Vec<_>) = runs.iter().partition(|run| run.fault == "mixed");
        assert_eq!((mixed.len(), alone.len()), (80, 80));
        for run in mixed {
            let faults = run.settings.last().expect("faults").value();
            let [one, other] = faults.as_array().expect("a list").as_slice() else {
                panic!("{faults}")
            };
            assert_eq!(one["at_s"], other["at_s"]);
            assert_ne!(one["service"], other["service"]);
        }
    }

    #[test]
    fn a_scenario_has_settings_of_its_own() {
        let runs = runs("seeds = 20\n[settings.cut-in]\n\"seed\" = [5, 35]\n");
        let values: BTreeSet<String> =
            runs.iter().filter_map(|run| run.settings.first()).map(Setting::to_string).collect();
        assert!(
            values.len() > 8 && values.iter().all(|key| key.starts_with("seed=")),
            "{values:?}"
        );
        assert!(runs.iter().all(|run| run.settings.is_empty() == (run.scenario == "cacc-a")));
    }

    #[test]
    fn a_mixed_run_has_faults_of_any_kind_and_phases_are_drawn_too() {
        let mixed = "seeds = 60\nfaults_per_run = [2, 4]\n[[faults]]\nkind = \"kill\"\n\
            service = \"plant\"\nwhen = [{ ttc_below_s = [2.0, 4.0] }, { standstill = true }]\n\
            [[faults]]\nkind = \"drop\"\ntopic = \"v2x/spat\"\nat_s = [1.0, 3.0]\n";
        let runs = runs(mixed);
        assert_eq!((runs.len(), runs[0].fault.as_str()), (2 * 60, "mixed"));
        let mut counts = [0; 5];
        let (mut phases, mut kinds) = (BTreeSet::new(), BTreeSet::new());
        for run in &runs {
            let faults = run.settings.last().expect("faults").value().as_array().expect("a list");
            counts[faults.len()] += 1;
            for fault in faults {
                kinds.insert(fault["kind"].to_string());
                let when = fault.get("when").and_then(Value::as_table);
                phases.extend(when.iter().flat_map(|when| when.keys().cloned()));
                if let Some(ttc_s) = when.and_then(|when| when.get("ttc_below_s")) {
                    let ttc_s = ttc_s.as_float().expect("one number");
                    assert!((2.0..=4.0).contains(&ttc_s), "{ttc_s}");
                }
            }
        }
        assert!(counts[2..].iter().all(|count| *count > 20), "{counts:?}");
        assert_eq!((phases.len(), kinds.len()), (2, 2));
    }

    #[test]
    fn without_faults_and_controllers_there_is_one_run_per_scenario_and_seed() {
        let runs = runs("set = [\"duration_s=2\"]");
        assert_eq!(runs.len(), 2);
        assert_eq!(texts(&runs[0]), ["duration_s=2"]);
        assert_eq!(
            runs[0].repeat("lockstep"),
            "timegap run cacc-a --mode lockstep --seed 1 --set 'duration_s=2'"
        );
    }

    #[test]
    fn the_repeating_command_survives_a_shell() {
        let runs = runs(FAULTS);
        let said = runs[0].repeat("realtime");
        assert!(said.contains("--set 'faults=[{ "), "{said}");
    }

    #[test]
    fn a_table_that_cannot_be_drawn_from_is_refused() {
        for line in ["at_s = [1.0]", "at_s = [3, 1]", "at_s = []", "at_s = [nan, 1.0]", "count = 0"]
        {
            let text = format!("[[faults]]\nkind = \"kill\"\n{line}\n");
            let said = plan(&campaign(&text)).expect_err("it is wrong").to_string();
            assert!(said.contains("expected"), "{said}");
        }
        assert!(plan(&campaign("seeds = 4000000000")).is_err());
    }
}
