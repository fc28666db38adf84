//! Whether a campaign's runs are what it requires.

use super::exposure::Exposure;
use super::file::Campaign;
use super::plan::Plan;
use super::record::Record;
use super::tally::{Sum, Tally, figure, is_least_number, limit_of_part, within};
use frame::batch::ProcessesSample;
use runtime::Mode;
use serde::Serialize;

/// The verdict over a campaign, as `campaign.json` has it.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    pub schema_version: u32,
    /// All runs were done, and everything required holds.
    pub ok: bool,
    pub campaign: String,
    pub mode: Mode,
    /// Runs that were to be done, and those of them of which nothing is known.
    pub planned: usize,
    pub unaccounted: usize,
    /// Combinations of a variation that break a constraint of its scenario, and are no runs.
    pub left_out: usize,
    /// What the drives of each scenario and controller meet without faults; empty without faults.
    pub exposure: Vec<Exposure>,
    /// No fault struck in a critical phase, and the campaign does not say that this is meant
    /// (`min_critical_faults = 0`): it shows nothing.
    pub met_nothing: bool,
    #[serde(flatten)]
    pub all: Tally,
    pub requirements: Vec<Requirement>,
    /// One entry for every combination of scenario, controller and fault.
    pub combinations: Vec<Combination>,
    /// The same runs by scenario, by controller, and by fault alone.
    pub scenarios: Vec<Part>,
    pub controllers: Vec<Part>,
    #[serde(rename = "by_fault")]
    pub faults: Vec<Part>,
    /// The runs to blame for a requirement that does not hold.
    pub failures: Vec<Failure>,
    /// The same by scenario and fault: a run with several faults counts for each.
    pub broken: Vec<Broken>,
    /// Runs in one process that were repeated in process groups.
    pub processes_sample: ProcessesSample,
}

/// Something required and what was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Requirement {
    /// Key in the campaign's file.
    pub requirement: String,
    pub limit: f64,
    /// Null if nothing measured it, which does not meet any requirement.
    pub found: Option<f64>,
    pub ok: bool,
}

/// Runs of the same scenario, controller and fault.
#[derive(Clone, Debug, Serialize)]
pub struct Combination {
    pub scenario: String,
    pub controller: String,
    pub fault: String,
    #[serde(flatten)]
    pub tally: Tally,
}

/// Runs that have one thing in common.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// What they have in common.
    pub of: String,
    #[serde(flatten)]
    pub tally: Tally,
}

/// Runs to blame that have a scenario and a fault in common.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Broken {
    pub scenario: String,
    pub fault: String,
    pub runs: u64,
}

/// A run to blame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    pub run: usize,
    pub scenario: String,
    pub faults: Vec<String>,
    pub why: String,
    /// The command that repeats it.
    pub repeat: String,
}

/// The runs added up, all together and by what they have in common.
#[derive(Debug, Default)]
pub struct Sums {
    all: Sum,
    combinations: Sorted<3>,
    scenarios: Sorted<1>,
    controllers: Sorted<1>,
    faults: Sorted<1>,
    processes_sample: ProcessesSample,
}

/// Runs by what they have in common, in the order of its first appearance.
#[derive(Debug)]
struct Sorted<const N: usize>(Vec<([String; N], Sum)>);

impl<const N: usize> Default for Sorted<N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<const N: usize> Sorted<N> {
    fn add(&mut self, names: [&str; N], record: &Record) {
        let known = self.0.iter().position(|(known, _)| known.each_ref() == names.each_ref());
        let place = known.unwrap_or_else(|| {
            self.0.push((names.map(str::to_owned), Sum::default()));
            self.0.len() - 1
        });
        self.0[place].1.add(record);
    }
}

impl Sums {
    /// Adds a run; they come in the order of their numbers.
    pub fn add(&mut self, record: &Record) {
        let Record { scenario, controller, fault, .. } = record;
        self.all.add(record);
        self.combinations.add([scenario, controller, fault], record);
        self.scenarios.add([scenario], record);
        self.controllers.add([controller], record);
        self.faults.add([fault], record);
        if let Some(same) = record.same_in_processes {
            self.processes_sample.runs += 1;
            self.processes_sample.different += usize::from(!same);
        }
    }
}

impl Verdict {
    /// Judges the `planned` runs that were to be done of the plan. `exposure` is what the drives meet without
    /// faults.
    pub fn new(
        campaign: &Campaign,
        plan: &Plan,
        planned: usize,
        exposure: Vec<Exposure>,
        sums: Sums,
    ) -> Self {
        let Sums { all, combinations, scenarios, controllers, faults, processes_sample } = sums;
        let all = all.tally();
        let share = planned as f64 / plan.whole().max(1) as f64;
        // What has to happen so often in all runs says nothing of one part: the merged whole is judged by it.
        let is_part = campaign.shard.is_some();
        let limits = campaign.require.iter().filter(|(key, _)| !(is_part && is_least_number(key)));
        let requirements: Vec<_> =
            limits.map(|(key, limit)| judge(key, *limit, share, &all)).collect();
        let met = requirements.iter().all(|requirement| requirement.ok);
        let same = processes_sample.different == 0;
        let met_nothing = !is_part
            && !campaign.faults.is_empty()
            && all.critical_faults == 0
            && !campaign.require.contains_key("min_critical_faults");
        let combinations =
            combinations.0.into_iter().map(|([scenario, controller, fault], sum)| Combination {
                scenario,
                controller,
                fault,
                tally: sum.tally(),
            });
        let parts = |sums: Sorted<1>| {
            sums.0.into_iter().map(|([of], sum)| Part { of, tally: sum.tally() }).collect()
        };
        Self {
            schema_version: 1,
            ok: met && same && !met_nothing && all.runs == planned as u64,
            campaign: campaign.name.as_str().into(),
            mode: campaign.mode,
            planned,
            unaccounted: planned.saturating_sub(usize::try_from(all.runs).unwrap_or(usize::MAX)),
            left_out: plan.left_out(),
            exposure,
            met_nothing,
            all,
            requirements,
            combinations: combinations.collect(),
            scenarios: parts(scenarios),
            controllers: parts(controllers),
            faults: parts(faults),
            failures: Vec::new(),
            broken: Vec::new(),
            processes_sample,
        }
    }

    /// Notes what a run is to blame for; they come in the order of their numbers.
    pub fn blame(&mut self, plan: &Plan, record: &Record) {
        let broken = self.requirements.iter().filter(|requirement| !requirement.ok);
        let reasons = broken.filter_map(|requirement| {
            let (figure, least) = figure(&requirement.requirement);
            let value = figure.blames(record, requirement.limit, least)?;
            Some(format!("{} {value}", figure.name))
        });
        let mut reasons: Vec<String> = reasons.collect();
        if record.same_in_processes == Some(false) {
            reasons.push("other bytes in a process group".into());
        }
        if reasons.is_empty() {
            return;
        }
        reasons.extend(record.aborted_because.clone());
        reasons.extend(record.leaks.iter().chain(&record.degraded).cloned());
        let planned = plan.get(record.run);
        let faults = planned.faults();
        for fault in &faults {
            self.count(&record.scenario, fault);
        }
        self.failures.push(Failure {
            run: record.run,
            scenario: record.scenario.clone(),
            why: reasons.join("; "),
            repeat: planned.repeat(self.mode.name()),
            faults,
        });
    }

    /// Counts a run to blame; the most frequent pairs come first.
    fn count(&mut self, scenario: &str, fault: &str) {
        let known = |broken: &&mut Broken| broken.scenario == scenario && broken.fault == fault;
        match self.broken.iter_mut().find(known) {
            Some(broken) => broken.runs += 1,
            None => {
                let (scenario, fault) = (scenario.to_owned(), fault.to_owned());
                self.broken.push(Broken { scenario, fault, runs: 1 });
            }
        }
        self.broken.sort_by_key(|broken| std::cmp::Reverse(broken.runs));
    }
}

/// Judges `share` of a campaign's runs: of what has to happen so often in all of them, a part is due.
fn judge(key: &str, limit: f64, share: f64, all: &Tally) -> Requirement {
    let limit = limit_of_part(key, limit, share);
    let (figure, least) = figure(key);
    let found = figure.value(all);
    let ok = found.is_some_and(|value| within(value, limit, least));
    Requirement { requirement: key.into(), limit, found, ok }
}

#[cfg(test)]
mod tests {
    use super::super::plan;
    use super::super::planned::Planned;
    use super::*;
    use group::report::Outcome;

    const FILE: &str = "schema_version = 1\nname = \"x\"\nscenarios = [\"cacc-a\", \"cut-in\"]\n";

    fn campaign(require: &str) -> Campaign {
        toml::from_str(&format!("{FILE}seeds = 2\n[require]\n{require}\n")).expect("a campaign")
    }

    fn record(planned: &Planned, outcome: Outcome, gap_m: f64, recovery_us: &[f64]) -> Record {
        let value = serde_json::json!({
            "run": planned.run, "scenario": planned.scenario, "controller": "acc-mpc",
            "fault": planned.fault, "seed": planned.seed, "outcome": outcome,
            "aborted_because": null, "avoidable": false, "duration_s": 1.0, "min_gap_m": gap_m,
            "min_ttc_s": null, "kills": recovery_us.len(), "detection_us": recovery_us,
            "recovery_us": recovery_us, "unrecovered": 0, "rungs_s": {"plant full": 1.0},
            "degraded": [], "command_overdue_ms": 20.0,
            "messages_lost": 1, "disturbed": 0, "corrupted": 0, "undetected": 0, "leaks": [], "growth": null,
        });
        serde_json::from_value(value).expect("a record")
    }

    fn verdict(require: &str, outcomes: [Outcome; 4]) -> Verdict {
        let campaign = campaign(require);
        let plan = plan::plan(&campaign).expect("a plan");
        let records = plan.numbers().map(|run| plan.get(run)).zip(outcomes).enumerate();
        let records = records.map(|(number, (planned, outcome))| {
            record(&planned, outcome, 10.0 - number as f64, &[1e3 * (number + 1) as f64])
        });
        of_records(&campaign, &plan, &records.collect::<Vec<_>>())
    }

    fn of_records(campaign: &Campaign, plan: &Plan, records: &[Record]) -> Verdict {
        let mut sums = Sums::default();
        records.iter().for_each(|record| sums.add(record));
        let mut verdict = Verdict::new(campaign, plan, plan.len(), Vec::new(), sums);
        records.iter().for_each(|record| verdict.blame(plan, record));
        verdict
    }

    const WHOLE: [Outcome; 4] = [Outcome::Completed; 4];

    #[test]
    fn what_holds_holds() {
        let require = "max_collisions = 0\nmin_gap_m = 7\nmax_recovery_p50_ms = 2.1\nmin_kills = 4";
        let verdict = verdict(require, WHOLE);
        assert!(verdict.ok && verdict.failures.is_empty(), "{verdict:?}");
        assert_eq!((verdict.all.runs, verdict.all.kills, verdict.all.messages_lost), (4, 4, 4));
        assert_eq!(verdict.all.min_gap_m, Some(7.0));
        assert_eq!(verdict.combinations.len(), 2);
        assert_eq!(verdict.all.rungs_s["plant full"], 4.0);
        let json = serde_json::to_value(&verdict).expect("plain data");
        for key in ["ok", "runs", "kills", "collisions", "red_lights", "leaks", "detection_us"] {
            assert!(json.get(key).is_some(), "{key} is promised");
        }
        for key in
            ["faults", "critical_faults", "interventions", "unaccounted", "avoidable_collisions"]
        {
            assert_eq!(json[key], 0, "{key} is promised as a number");
        }
    }

    #[test]
    fn the_run_to_blame_comes_with_its_command() {
        let [whole, ..] = WHOLE;
        let verdict = verdict("max_red_lights = 0", [whole, whole, Outcome::RedLight, whole]);
        assert!(!verdict.ok);
        let [failure] = verdict.failures.as_slice() else { panic!("{:?}", verdict.failures) };
        assert_eq!((failure.run, failure.why.as_str()), (2, "red_lights 1"));
        assert_eq!(failure.repeat, "timegap run cacc-a --mode lockstep --seed 2");
    }

    #[test]
    fn a_measure_blames_the_runs_beyond_its_limit() {
        let verdict = verdict("min_gap_m = 8.5\nmax_recovery_max_ms = 3.5", WHOLE);
        let blamed: Vec<_> = verdict.failures.iter().map(|failure| failure.run).collect();
        assert_eq!(blamed, [2, 3]);
        assert!(verdict.failures[1].why.contains("recovery_max_ms 4"), "{:?}", verdict.failures);
    }

    #[test]
    fn too_few_samples_are_no_verdict_and_a_missing_figure_is_a_failure() {
        let few = verdict("min_kills = 1000", WHOLE);
        assert!(!few.ok && few.failures.is_empty());
        let nothing = verdict("min_ttc_s = 1", WHOLE);
        assert!(!nothing.ok && nothing.requirements[0].found.is_none());
    }

    #[test]
    fn of_a_sample_its_share_of_a_least_number_is_required() {
        let text =
            format!("{FILE}seeds = 2\nsample = 2\n[require]\nmin_kills = 9\nmin_gap_m = 3\n");
        let campaign: Campaign = toml::from_str(&text).expect("a campaign");
        let plan = plan::plan(&campaign).expect("a plan");
        assert_eq!((plan.len(), plan.whole()), (2, 4));
        let limits = of_records(&campaign, &plan, &[]).requirements;
        let limit = |key: &str| limits.iter().find(|r| r.requirement == key).map(|r| r.limit);
        assert_eq!((limit("min_kills"), limit("min_gap_m")), (Some(4.0), Some(3.0)));
    }

    #[test]
    fn faults_that_met_nothing_show_nothing() {
        let judged = |require: &str, critical: u64| {
            let fault = "[[faults]]\nkind = \"drop\"\ntopic = \"radar/tracks\"\n";
            let text = format!("{FILE}[require]\n{require}\n{fault}");
            let campaign: Campaign = toml::from_str(&text).expect("a campaign");
            let plan = plan::plan(&campaign).expect("a plan");
            let records = plan.numbers().map(|run| Record {
                faults: 2,
                critical_faults: critical,
                ..record(&plan.get(run), Outcome::Completed, 5.0, &[])
            });
            let verdict = of_records(&campaign, &plan, &records.collect::<Vec<_>>());
            (verdict.ok, verdict.met_nothing)
        };
        assert_eq!(judged("max_collisions = 0", 0), (false, true));
        assert_eq!(judged("max_collisions = 0", 1), (true, false));
        assert_eq!(judged("min_critical_faults = 3", 1), (false, false));
        assert_eq!(judged("min_critical_faults = 0", 0), (true, false));
    }

    #[test]
    fn a_part_is_not_judged_by_least_numbers_of_the_whole() {
        let fault = "[[faults]]\nkind = \"drop\"\ntopic = \"radar/tracks\"\n";
        let require = "[require]\nmin_critical_faults = 1\nmin_gap_m = 3\nmax_collisions = 0\n";
        let text = format!("{FILE}shard = \"1/2\"\n{require}{fault}");
        let campaign: Campaign = toml::from_str(&text).expect("a campaign");
        let plan = plan::plan(&campaign).expect("a plan");
        let records =
            plan.numbers().map(|run| record(&plan.get(run), Outcome::Completed, 5.0, &[]));
        let verdict = of_records(&campaign, &plan, &records.collect::<Vec<_>>());
        assert!(verdict.ok && !verdict.met_nothing, "{verdict:?}");
        let judged: Vec<_> = verdict.requirements.iter().map(|r| r.requirement.as_str()).collect();
        assert_eq!(judged, ["max_collisions", "min_gap_m"]);
    }

    #[test]
    fn missing_runs_make_no_whole_campaign() {
        let campaign = campaign("max_collisions = 0");
        let plan = plan::plan(&campaign).expect("a plan");
        let records = [record(&plan.get(0), Outcome::Completed, 1.0, &[])];
        let verdict = of_records(&campaign, &plan, &records);
        assert!(!verdict.ok && verdict.failures.is_empty());
        assert_eq!((verdict.all.runs, verdict.planned, verdict.unaccounted), (1, 4, 3));
    }
}
