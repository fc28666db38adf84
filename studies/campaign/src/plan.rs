//! From a campaign to its runs: the matrix, and what is drawn for each run.

use super::file::Campaign;
use super::planned::Planned;
use super::variation::Variants;
use group::{Error, Failure};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use toml::{Table, Value};

/// Most runs of a campaign.
const MAX_RUNS: usize = 1_000_000;

/// The runs of a campaign, each made when it is asked for: all of them at once would not fit in memory.
#[derive(Debug)]
pub struct Plan {
    campaign: Campaign,
    controllers: Vec<Option<String>>,
    faults: Vec<Drawing>,
    variants: Option<Variants>,
    /// Runs of the whole campaign.
    all: usize,
    /// The numbers of the runs that were drawn, in order; none: all are done.
    drawn: Option<Vec<usize>>,
}

impl Planned {
    /// The command that repeats the run.
    pub fn repeat(&self, mode: &str) -> String {
        let seed = self.seed.to_string();
        let mut words = vec!["timegap", "run", &self.scenario];
        if let Some(controller) = &self.controller {
            words.extend(["--controller", controller]);
        }
        words.extend(["--mode", mode, "--seed", &seed]);
        words.extend(self.keys.iter().flat_map(|key| ["--set", key]));
        words.extend(self.parameters.iter().flat_map(|parameter| ["--param", parameter]));
        runtime::command_line(&words)
    }
}

/// Why the runs of a campaign cannot be laid out.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// There are too many.
    #[error("{combinations} combinations with {seeds} seeds each are more than {MAX_RUNS} runs")]
    TooManyRuns {
        /// Combinations of what varies.
        combinations: usize,
        /// Runs of each.
        seeds: u32,
    },
    /// A number of faults.
    #[error("faults: {key} = {value}, expected a whole number from 1 to 64")]
    Count {
        /// The key.
        key: String,
        /// Its value.
        value: Value,
    },
    /// Whether a fault has runs of its own.
    #[error("faults: alone = {0}, expected true or false")]
    Alone(Value),
    /// Not so many services to strike together.
    #[error(
        "faults: together needs `service` to be a list of as many or more, and no `count` beside it"
    )]
    Together,
    /// A value of a fault is neither one nor a choice of several.
    #[error(
        "faults: {key} = {value} cannot be drawn from, expected two numbers, the smaller first, or a \
         list of words or of tables"
    )]
    NotDrawable {
        /// The key.
        key: String,
        /// Its value.
        value: Value,
    },
}

impl Failure for PlanError {}

/// All runs of a campaign, its shard not regarded. Neighbouring runs belong to different
/// combinations, so that a part of the campaign says something about each.
pub fn plan(campaign: &Campaign) -> Result<Plan, Error> {
    let variants = campaign.variation.as_deref().map(Variants::open).transpose()?;
    let own = vec![None];
    let named: Vec<_> = campaign.controllers.iter().cloned().map(Some).collect();
    let controllers = if named.is_empty() { own } else { named };
    for (key, value) in campaign.settings.values().flatten() {
        check(key, value)?;
    }
    let templates = campaign.faults.iter().map(Template::of).collect::<Result<Vec<_>, _>>()?;
    let faults: Vec<_> = match campaign.faults_per_run {
        _ if templates.is_empty() => vec![Drawing::None],
        Some([least, most]) => {
            let (alone, templates): (Vec<_>, Vec<_>) =
                templates.into_iter().partition(|template| template.is_alone);
            let mixed =
                (!templates.is_empty()).then_some(Drawing::Mixed { templates, least, most });
            mixed.into_iter().chain(alone.into_iter().map(Drawing::One)).collect()
        }
        None => templates.into_iter().map(Drawing::One).collect(),
    };
    let seeds = campaign.seeds.get();
    let values = variants.as_ref().map_or(1, Variants::len);
    let combinations = campaign.scenarios.len() * values * controllers.len() * faults.len();
    let all = combinations.checked_mul(seeds as usize).filter(|runs| *runs <= MAX_RUNS);
    let Some(all) = all else {
        return Err(PlanError::TooManyRuns { combinations, seeds }.into());
    };
    let drawn = campaign.sample.map(|sample| draw(all, sample.get(), campaign.first_seed));
    Ok(Plan { campaign: campaign.clone(), controllers, faults, variants, all, drawn })
}

impl Plan {
    /// Runs that are to be done.
    pub fn len(&self) -> usize {
        self.drawn.as_ref().map_or(self.all, Vec::len)
    }

    /// Runs of the whole campaign, of which a sample does a part.
    pub fn whole(&self) -> usize {
        self.all
    }

    /// Combinations of a variation that break a constraint of its scenario.
    pub fn left_out(&self) -> usize {
        self.variants.as_ref().map_or(0, |variants| variants.left_out)
    }

    /// The number of the run at a place among those that are to be done.
    pub fn number(&self, place: usize) -> usize {
        self.drawn.as_ref().map_or(place, |drawn| drawn[place])
    }

    /// The numbers of the runs that are to be done, in order.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).map(|place| self.number(place))
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
                    keys: self.keys(scenario, self.campaign.first_seed),
                    parameters: self.variants.as_ref().map_or_else(Vec::new, |all| all.get(0)),
                });
            }
        }
        runs
    }

    /// Keys set in the run of a scenario with this seed, but for its faults.
    fn keys(&self, scenario: &str, seed: u32) -> Vec<String> {
        // Far from the streams of the faults.
        let mut random = Pcg64::new(seed.into(), u128::from(u64::MAX));
        random.next_u64();
        let settings = self.campaign.settings.get(scenario).into_iter().flatten();
        let settings = settings.map(|(key, value)| format!("{key}={}", drawn(value, &mut random)));
        self.campaign.set.iter().cloned().chain(settings).collect()
    }

    /// The run of a number below that of all runs.
    pub fn get(&self, run: usize) -> Planned {
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
        let mut keys = self.keys(&campaign.scenarios[place / values], seed);
        // Controllers meet the same faults; scenarios do not.
        let stream = (place * faults.len() + which) as u128;
        let drawn = Some(fault.draw(seed, stream)).filter(|drawn| !drawn.is_empty());
        keys.extend(drawn.map(|drawn| format!("faults=[{}]", drawn.join(", "))));
        Planned {
            run,
            scenario: campaign.scenarios[place / values].clone(),
            controller: controllers[controller].clone(),
            fault: fault.label().into(),
            seed,
            keys,
            parameters: variants.as_ref().map_or_else(Vec::new, |all| all.get(place % values)),
        }
    }
}

/// `count` of the numbers below `all`, drawn by a seed, in their order.
fn draw(all: usize, count: usize, seed: u32) -> Vec<usize> {
    let mut random = Pcg64::seed_from_u64(seed.into());
    let mut left = all;
    let mut wanted = count.min(left);
    // Knuth's algorithm S: each run is kept with the chance that makes the number come out.
    let mut keep = |_: &usize| {
        let uniform = random::uniform(&mut random);
        let keep = uniform * (left as f64) < wanted as f64;
        left -= 1;
        wanted -= usize::from(keep);
        keep
    };
    (0..all).filter(|run| keep(run)).collect()
}

/// What is drawn for a run.
#[derive(Debug)]
enum Drawing {
    /// Nothing.
    None,
    /// As many of one template as it says.
    One(Template),
    /// A number of faults, each of any of the templates.
    Mixed { templates: Vec<Template>, least: u32, most: u32 },
}

impl Drawing {
    fn label(&self) -> &str {
        match self {
            Self::None => "none",
            Self::One(template) => &template.label,
            Self::Mixed { .. } => "mixed",
        }
    }

    /// The faults of a run, as TOML, by its seed and the stream of its scenario and drawing.
    fn draw(&self, seed: u32, stream: u128) -> Vec<String> {
        let mut random = Pcg64::new(seed.into(), stream);
        // The stream's first number says nothing for small seeds.
        random.next_u64();
        match self {
            Self::None => Vec::new(),
            Self::One(template) => template.draw(&mut random),
            Self::Mixed { templates, least, most } => {
                let span = f64::from(most - least + 1);
                let count = least + (random::uniform(&mut random) * span) as u32;
                let mut each = |_| {
                    let which = random::uniform(&mut random) * templates.len() as f64;
                    templates[which as usize].draw(&mut random)
                };
                (0..count).flat_map(&mut each).collect()
            }
        }
    }
}

/// A fault of which some values are drawn for each run.
#[derive(Debug)]
struct Template {
    label: String,
    /// In runs of its own, also where a run's faults are drawn from all.
    is_alone: bool,
    count: usize,
    /// All of them begin at the same instant, and no two act on the same service.
    is_together: bool,
    keys: Table,
}

impl Template {
    fn of(table: &Table) -> Result<Self, PlanError> {
        let mut keys = table.clone();
        let mut whole = |key: &str| match keys.remove(key) {
            None => Ok(None),
            Some(Value::Integer(count @ 1..=64)) => Ok(Some(count as usize)),
            Some(value) => Err(PlanError::Count { key: key.to_owned(), value }),
        };
        let (count, together) = (whole("count")?, whole("together")?);
        let is_alone = match keys.remove("alone") {
            None => false,
            Some(Value::Boolean(alone)) => alone,
            Some(other) => {
                return Err(PlanError::Alone(other));
            }
        };
        let services = keys.get("service").and_then(Value::as_array).map_or(0, Vec::len);
        if together.is_some_and(|together| together > services || count.is_some()) {
            return Err(PlanError::Together);
        }
        for (key, value) in &keys {
            check(key, value)?;
        }
        let word = |key: &str| match keys.get(key) {
            Some(Value::String(word)) => Some(word.clone()),
            _ => None,
        };
        let parts = ["kind", "service", "topic", "field"].into_iter().filter_map(word);
        Ok(Self {
            label: parts.collect::<Vec<_>>().join(" "),
            is_alone,
            count: count.or(together).unwrap_or(1),
            is_together: together.is_some(),
            keys,
        })
    }

    /// So many faults as the template says, as TOML.
    fn draw(&self, random: &mut Pcg64) -> Vec<String> {
        let shared = |key: &str| self.is_together && matches!(key, "at_s" | "when");
        let mut keys = self.keys.clone();
        for (_, value) in keys.iter_mut().filter(|(key, _)| shared(key)) {
            *value = drawn(value, random);
        }
        let mut draw = |_| {
            let mut pairs = Vec::new();
            for (key, value) in &mut keys {
                let one = if shared(key) { value.clone() } else { drawn(value, random) };
                if self.is_together
                    && key == "service"
                    && let Value::Array(left) = value
                {
                    left.retain(|other| *other != one);
                }
                pairs.push(format!("{key} = {one}"));
            }
            format!("{{ {} }}", pairs.join(", "))
        };
        (0..self.count).map(&mut draw).collect()
    }
}

/// Checks that a value, or each value of a table, can be drawn from.
fn check(key: &str, value: &Value) -> Result<(), PlanError> {
    match value {
        Value::Table(table) => table.iter().try_for_each(|(key, value)| check(key, value)),
        Value::Array(values) if is_choice(values) => {
            let mut tables = values.iter().filter(|value| value.is_table());
            tables.try_for_each(|table| check(key, table))
        }
        Value::Array(values) if range(values).is_none() => {
            Err(PlanError::NotDrawable { key: key.to_owned(), value: value.clone() })
        }
        _ => Ok(()),
    }
}

/// True of a list of which one element is drawn.
fn is_choice(values: &[Value]) -> bool {
    let all = |is: fn(&Value) -> bool| !values.is_empty() && values.iter().all(is);
    all(Value::is_str) || all(Value::is_table)
}

/// The ends of a range: two numbers, in order.
fn range(values: &[Value]) -> Option<(f64, f64)> {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|i| i as f64));
    let [from, to] = values else { return None };
    let (from, to) = (number(from)?, number(to)?);
    (from < to && (to - from).is_finite()).then_some((from, to))
}

/// A value, one of a list of words or tables, or a number between two: whole if both are, else to three
/// digits. Of a table each value.
fn drawn(value: &Value, random: &mut Pcg64) -> Value {
    if let Value::Table(table) = value {
        let each = table.iter().map(|(key, value)| (key.clone(), drawn(value, random)));
        return Value::Table(each.collect());
    }
    let Value::Array(values) = value else { return value.clone() };
    let uniform = random::uniform(random);
    match range(values) {
        Some((from, to)) if values.iter().all(Value::is_integer) => {
            Value::Integer((from + uniform * (to - from + 1.0)).floor() as i64)
        }
        Some((from, to)) => Value::Float(((from + uniform * (to - from)) * 1e3).round() / 1e3),
        None => drawn(&values[(uniform * values.len() as f64) as usize], random),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn campaign(lines: &str) -> Campaign {
        let head = "schema_version = 1\nname = \"x\"\nscenarios = [\"cacc-a\", \"cut-in\"]\n";
        toml::from_str(&format!("{head}{lines}")).expect("a campaign")
    }

    fn runs(lines: &str) -> Vec<Planned> {
        let plan = plan(&campaign(lines)).expect("a plan");
        plan.numbers().map(|run| plan.get(run)).collect()
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
    fn draws_stay_in_their_ranges_and_repeat() {
        let runs = runs(FAULTS);
        assert_eq!(runs, self::runs(FAULTS));
        let faults = |run: &Planned| {
            let table: Table = toml::from_str(run.keys.last().expect("faults")).expect("TOML");
            table["faults"].as_array().expect("a list").clone()
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
    fn what_strikes_together_has_one_instant_and_two_services() {
        let fault = "seeds = 40\nfaults_per_run = [1, 1]\n[[faults]]\nkind = \"kill\"\ntogether = 2\n\
            service = [\"plant\", \"controller\", \"aebs\"]\nat_s = [1.0, 9.0]\n[[faults]]\n\
            kind = \"kill-helper\"\nhelper = \"launcher\"\nat_s = [1.0, 9.0]\nalone = true\n";
        let runs = runs(fault);
        assert_eq!(runs.len(), 2 * 2 * 40);
        let (mixed, alone): (Vec<_>, Vec<_>) = runs.iter().partition(|run| run.fault == "mixed");
        assert_eq!((mixed.len(), alone.len()), (80, 80));
        for run in mixed {
            let table: Table = toml::from_str(run.keys.last().expect("faults")).expect("TOML");
            let [one, other] = table["faults"].as_array().expect("a list").as_slice() else {
                panic!("{table}")
            };
            assert_eq!(one["at_s"], other["at_s"]);
            assert_ne!(one["service"], other["service"]);
        }
    }

    #[test]
    fn a_scenario_has_settings_of_its_own() {
        let runs = runs("seeds = 20\n[settings.cut-in]\n\"seed\" = [5, 35]\n");
        let values: BTreeSet<&String> = runs.iter().filter_map(|run| run.keys.first()).collect();
        assert!(
            values.len() > 8 && values.iter().all(|key| key.starts_with("seed=")),
            "{values:?}"
        );
        assert!(runs.iter().all(|run| run.keys.is_empty() == (run.scenario == "cacc-a")));
    }

    #[test]
    fn a_mixed_run_has_so_many_faults_of_any_kind_and_phases_are_drawn_too() {
        let mixed = "seeds = 60\nfaults_per_run = [2, 4]\n[[faults]]\nkind = \"kill\"\n\
            service = \"plant\"\nwhen = [{ ttc_below_s = [2.0, 4.0] }, { standstill = true }]\n\
            [[faults]]\nkind = \"drop\"\ntopic = \"v2x/spat\"\nat_s = [1.0, 3.0]\n";
        let runs = runs(mixed);
        assert_eq!((runs.len(), runs[0].fault.as_str()), (2 * 60, "mixed"));
        let mut counts = [0; 5];
        let (mut phases, mut kinds) = (BTreeSet::new(), BTreeSet::new());
        for run in &runs {
            let table: Table = toml::from_str(run.keys.last().expect("faults")).expect("TOML");
            let faults = table["faults"].as_array().expect("a list");
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
        assert_eq!(runs[0].keys, ["duration_s=2"]);
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
    fn what_cannot_be_drawn_from_is_refused() {
        for line in ["at_s = [1.0]", "at_s = [3, 1]", "at_s = []", "at_s = [nan, 1.0]", "count = 0"]
        {
            let text = format!("[[faults]]\nkind = \"kill\"\n{line}\n");
            let said = plan(&campaign(&text)).expect_err("it is wrong").to_string();
            assert!(said.contains("expected"), "{said}");
        }
        assert!(plan(&campaign("seeds = 4000000000")).is_err());
    }
}
