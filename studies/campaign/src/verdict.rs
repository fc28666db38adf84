//! Whether the runs of a campaign keep its limits.

use super::blame::{Broken, Failure};
use super::exposure::Exposure;
use super::file::Campaign;
use super::plan::Plan;
use super::sums::{Combination, Limit, Shared, Sums, Tally};
use report::gate::{Against, Sample};
use report::results::Object;
use runtime::Mode;
use schemars::JsonSchema;
use serde::Serialize;

/// The verdict over a campaign.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Verdict {
    pub schema_version: u32,
    /// All runs were done, and all requirements hold.
    pub ok: bool,
    /// Name of the campaign.
    pub campaign: String,
    /// Clock of the runs.
    #[schemars(with = "String")]
    pub mode: Mode,
    /// Runs that were to be done.
    pub planned: usize,
    /// Planned runs without a record.
    pub unaccounted: usize,
    /// Combinations of a variation that break a constraint of its scenario.
    pub left_out: usize,
    /// Events of the drives without faults.
    pub exposure: Vec<Exposure>,
    /// No fault acted in a critical phase, and no limit allows that.
    pub met_nothing: bool,
    #[serde(flatten)]
    pub all: Tally,
    pub requirements: Vec<Requirement>,
    pub combinations: Vec<Combination>,
    pub scenarios: Vec<Shared>,
    pub controllers: Vec<Shared>,
    #[serde(rename = "by_fault")]
    pub faults: Vec<Shared>,
    pub failures: Vec<Failure>,
    pub broken: Vec<Broken>,
    /// Figures of each run, for `--against`; empty in a part.
    #[schemars(with = "Vec<Object>")]
    pub samples: Vec<Sample>,
    /// The runs against those of `--against`; null without it.
    pub against: Option<Against>,
}

/// A limit and what was found.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Requirement {
    pub requirement: String,
    pub limit: f64,
    /// Null if no run measured it, which breaks every limit.
    pub found: Option<f64>,
    pub ok: bool,
}

/// The runs that are judged.
#[derive(Clone, Copy, Debug)]
pub struct Scope {
    /// Number of runs that were to be done.
    pub planned: usize,
    /// They are a part of the campaign.
    pub is_part: bool,
}

impl Verdict {
    /// Judges the runs of `scope`. `exposure` is what the drives meet without faults.
    pub fn new(
        campaign: &Campaign,
        plan: &Plan,
        scope: Scope,
        exposure: Vec<Exposure>,
        sums: &Sums,
    ) -> Self {
        let Scope { planned, is_part } = scope;
        let all = sums.all.tally();
        let runs = usize::try_from(all.counts.runs).unwrap_or(usize::MAX);
        let share = planned as f64 / plan.whole().max(1) as f64;
        let judge = |(key, value): (&String, &f64)| {
            let limit = Limit::of(key, *value).for_share(share);
            // The merged whole is judged by its least numbers, and no part is.
            if is_part && limit.is_least_number() {
                return None;
            }
            let found = limit.figure.value(&all);
            let ok = found.is_some_and(|found| limit.holds(found));
            Some(Requirement { requirement: key.clone(), limit: limit.value, found, ok })
        };
        let requirements: Vec<_> = campaign.require.iter().filter_map(judge).collect();
        let met_nothing = !is_part
            && !campaign.faults.is_empty()
            && all.counts.critical_faults == 0
            && !campaign.require.contains_key("min_critical_faults");
        Self {
            schema_version: 1,
            ok: requirements.iter().all(|requirement| requirement.ok)
                && !met_nothing
                && runs == planned,
            campaign: campaign.name.as_str().into(),
            mode: campaign.mode,
            planned,
            unaccounted: planned.saturating_sub(runs),
            left_out: plan.left_out(),
            exposure,
            met_nothing,
            all,
            requirements,
            combinations: sums.combinations(),
            scenarios: sums.scenarios(),
            controllers: sums.controllers(),
            faults: sums.faults(),
            failures: Vec::new(),
            broken: Vec::new(),
            samples: Vec::new(),
            against: None,
        }
    }

    /// The limits that do not hold.
    pub fn broken_limits(&self) -> Vec<Limit> {
        let broken = self.requirements.iter().filter(|requirement| !requirement.ok);
        broken.map(|broken| Limit::of(&broken.requirement, broken.limit)).collect()
    }
}

#[cfg(test)]
pub mod tests {
    use super::super::blame::Blame;
    use super::super::plan;
    use super::super::record::Planned;
    use super::super::record::{Measured, Record};
    use super::*;
    use supervise::report::Outcome;

    const FILE: &str = "schema_version = 1\nname = \"x\"\nscenarios = [\"cacc-a\", \"cut-in\"]\n";

    fn campaign(require: &str) -> Campaign {
        toml::from_str(&format!("{FILE}seeds = 2\n[require]\n{require}\n")).expect("a campaign")
    }

    fn record(planned: &Planned, outcome: Outcome, gap_m: f64, recovery_us: &[f64]) -> Record {
        Record {
            run: planned.run,
            scenario: planned.scenario.clone(),
            controller: "acc-mpc".into(),
            fault: planned.fault.clone(),
            seed: planned.seed,
            parameters: Vec::new(),
            outcome,
            aborted_because: None,
            requirements: Vec::new(),
            measured: Measured {
                duration_s: 1.0,
                min_gap_m: Some(gap_m),
                kills: recovery_us.len() as u64,
                detection_us: recovery_us.to_vec(),
                recovery_us: recovery_us.to_vec(),
                rungs_s: [("plant full".to_owned(), 1.0)].into(),
                command_overdue_ms: Some(20.0),
                messages_lost: 1,
                ..Measured::default()
            },
        }
    }

    /// Two runs of each of two scenarios, judged.
    pub fn verdict(require: &str, outcomes: [Outcome; 4]) -> Verdict {
        let campaign = campaign(require);
        let plan = plan::plan(&campaign).expect("a plan");
        let records = planned(&plan).into_iter().zip(outcomes).enumerate();
        let records = records.map(|(number, (planned, outcome))| {
            record(&planned, outcome, 10.0 - number as f64, &[1e3 * (number + 1) as f64])
        });
        of_records(&campaign, &plan, false, &records.collect::<Vec<_>>())
    }

    fn planned(plan: &Plan) -> Vec<Planned> {
        (0..plan.len()).map(|place| plan.at(place).expect("right faults")).collect()
    }

    fn of_records(campaign: &Campaign, plan: &Plan, is_part: bool, records: &[Record]) -> Verdict {
        let mut sums = Sums::default();
        records.iter().for_each(|record| sums.add(record));
        let scope = Scope { planned: plan.len(), is_part };
        let mut verdict = Verdict::new(campaign, plan, scope, Vec::new(), &sums);
        let mut blame = Blame::new(plan, campaign.mode, verdict.broken_limits());
        records.iter().for_each(|record| blame.add(record).expect("right faults"));
        (verdict.failures, verdict.broken) = blame.found();
        verdict
    }

    pub const WHOLE: [Outcome; 4] = [Outcome::Completed; 4];

    #[test]
    fn what_holds_holds() {
        let require = "max_collisions = 0\nmin_gap_m = 7\nmax_recovery_p50_ms = 2.1\nmin_kills = 4";
        let verdict = verdict(require, WHOLE);
        assert!(verdict.ok && verdict.failures.is_empty(), "{verdict:?}");
        assert_eq!(
            (verdict.all.counts.runs, verdict.all.counts.kills, verdict.all.counts.messages_lost),
            (4, 4, 4)
        );
        assert_eq!(verdict.all.measures.extremes.min_gap_m, Some(7.0));
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
    fn a_sample_requires_its_share_of_a_least_number() {
        let text =
            format!("{FILE}seeds = 2\nsample = 2\n[require]\nmin_kills = 9\nmin_gap_m = 3\n");
        let campaign: Campaign = toml::from_str(&text).expect("a campaign");
        let plan = plan::plan(&campaign).expect("a plan");
        assert_eq!((plan.len(), plan.whole()), (2, 4));
        let limits = of_records(&campaign, &plan, false, &[]).requirements;
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
            let record = |planned: &Planned| {
                let mut record = record(planned, Outcome::Completed, 5.0, &[]);
                (record.measured.faults, record.measured.critical_faults) = (2, critical);
                record
            };
            let records: Vec<_> = planned(&plan).iter().map(record).collect();
            let verdict = of_records(&campaign, &plan, false, &records);
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
        let text = format!("{FILE}{require}{fault}");
        let campaign: Campaign = toml::from_str(&text).expect("a campaign");
        let plan = plan::plan(&campaign).expect("a plan");
        let record = |planned: &Planned| record(planned, Outcome::Completed, 5.0, &[]);
        let records: Vec<_> = planned(&plan).iter().map(record).collect();
        let verdict = of_records(&campaign, &plan, true, &records);
        assert!(verdict.ok && !verdict.met_nothing, "{verdict:?}");
        let judged: Vec<_> = verdict.requirements.iter().map(|r| r.requirement.as_str()).collect();
        assert_eq!(judged, ["max_collisions", "min_gap_m"]);
    }

    #[test]
    fn missing_runs_make_no_whole_campaign() {
        let campaign = campaign("max_collisions = 0");
        let plan = plan::plan(&campaign).expect("a plan");
        let records = [record(&plan.get(0).expect("no faults"), Outcome::Completed, 1.0, &[])];
        let verdict = of_records(&campaign, &plan, false, &records);
        assert!(!verdict.ok && verdict.failures.is_empty());
        assert_eq!((verdict.all.counts.runs, verdict.planned, verdict.unaccounted), (1, 4, 3));
    }
}
