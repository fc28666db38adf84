//! The runs of the study. Drives that would have the same bytes are driven once.
//!
//! * The emergency brake reaches the plant alone, while it brakes or holds. A run in which it never did so equals the
//!   run without it.
//! * Without signals, a law may equal another law ([`without_signals`](controller::law::Descriptor::without_signals)).
//!
//! So a run of the study is a case with one group of equal laws, with and without the brake.

use crate::{Model, Verdict};
use controller::laws;
use group::Error;
use scenario::Scenario;

use super::R157Arguments;
use super::asked::{matrices, names, refuse, seed};
use super::drive::{Conditions, Driver};
use super::judged::{Driven, Judged};
use super::kept::{End, Kept};
use super::matrix::{Case, Matrix};
use super::scene;
use super::settled::Settled;
use frame::batch::{self, Done};

/// Laws whose runs are the same.
struct Laws {
    /// Their names; the first is driven.
    names: Vec<String>,
    /// True if there are detections for an emergency brake.
    with_brake: bool,
}

/// Every case of every matrix by every law, in this order.
pub struct Plan {
    /// The gaps of cases with a lead.
    pub settled: Settled,
    /// The matrices with their cases.
    pub matrices: Vec<(Matrix, Vec<Case>)>,
    /// In the order of the tables.
    drivers: Vec<Driver>,
    laws: Vec<Laws>,
}

impl Plan {
    /// The study of the arguments.
    ///
    /// # Errors
    /// [`Error::Scenario`] for an unknown law; [`Refused`](super::asked::Refused).
    pub fn of(arguments: &R157Arguments) -> Result<Self, Error> {
        refuse(arguments)?;
        let settled = Settled::under(Conditions {
            seed: seed(arguments).into(),
            laws: arguments.laws.clone(),
            formulas: arguments.require.clone(),
        });
        let names = names(arguments)?;
        let laws = laws_of(&names, &settled)?;
        let drivers = drivers_of(names, &laws);
        Ok(Self { settled, matrices: matrices(arguments), drivers, laws })
    }

    /// Number of runs.
    pub fn number_of_runs(&self) -> usize {
        self.matrices.iter().map(|(_, cases)| cases.len() * self.laws.len()).sum()
    }

    fn place(&self, run: usize) -> (&Laws, Matrix, usize, &Case) {
        let mut before = 0;
        for (matrix, cases) in &self.matrices {
            let place = run - before;
            if place < cases.len() * self.laws.len() {
                let (laws, case) = (&self.laws[place / cases.len()], place % cases.len());
                return (laws, *matrix, case, &cases[case]);
            }
            before += cases.len() * self.laws.len();
        }
        unreachable!("the runs are numbered up to their count")
    }

    /// The keys of a drive of run number `run`. Laws that are the same without signals share their drives, under the
    /// name of the first.
    pub fn keys_of(&self, run: usize, aebs: bool) -> Vec<(String, String)> {
        let (_, matrix, number, _) = self.place(run);
        let keys = [
            ("matrix", matrix.name().to_owned()),
            ("case", (number + 1).to_string()),
            ("aebs", aebs.to_string()),
        ];
        keys.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }

    /// The first drive of run number `run`.
    ///
    /// # Errors
    /// As [`scene::scenario`].
    pub fn first_of(&self, run: usize) -> Result<Scenario, Error> {
        let (laws, _, _, case) = self.place(run);
        let driver = Driver { law: laws.names[0].clone(), aebs: laws.with_brake };
        scene::scenario(case, &driver, &self.settled)
    }

    /// Drives run number `run` as often as it takes. `drive` does a drive, with or without the emergency brake.
    ///
    /// # Errors
    /// As `drive`; [`batch::Aborted`].
    pub fn drive_case(
        &self,
        run: usize,
        drive: &dyn Fn(bool, Scenario) -> Result<Done, Error>,
    ) -> Result<Kept, Error> {
        let (laws, _, _, case) = self.place(run);
        Kept::of(laws.with_brake, &|aebs| {
            let driver = Driver { law: laws.names[0].clone(), aebs };
            let done = drive(aebs, scene::scenario(case, &driver, &self.settled)?)?;
            batch::whole(&done.summary)?;
            Ok(done)
        })
    }

    /// The verdicts of models and drivers; `None` if a run is missing.
    ///
    /// # Errors
    /// As [`Settled::gap_m`], for the gaps from which cut-outs are judged.
    pub fn judged(&self, kept: &[Option<Kept>]) -> Result<Option<Vec<Judged>>, Error> {
        let mut first = 0;
        let mut all = Vec::new();
        for (matrix, cases) in &self.matrices {
            let mut judged = Judged::new(*matrix, cases.clone());
            for driver in &self.drivers {
                let found = self.laws.iter().position(|laws| laws.names.contains(&driver.law));
                let place = found.expect("every driver's law is one of the plan's");
                let begin = first + place * cases.len();
                let of_laws = kept[begin..begin + cases.len()].iter();
                let ends = of_laws.map(|kept| kept.as_ref()?.end(driver.aebs));
                let Some(ends) = ends.collect::<Option<Vec<End>>>() else { return Ok(None) };
                let verdicts = ends.iter().map(|end| end.verdict()).collect();
                let is_judged = !self.settled.conditions().formulas.is_empty();
                let broken = is_judged.then(|| ends.iter().map(|end| end.is_broken()).collect());
                let from_its_gap = self.yardstick(&self.laws[place], cases)?;
                judged.laws.push(Driven { driver: driver.clone(), verdicts, from_its_gap, broken });
            }
            first += cases.len() * self.laws.len();
            all.push(judged);
        }
        Ok(Some(all))
    }

    /// Verdicts of `careful-driver` on cut-outs from a law's gap; `None` for other cases.
    fn yardstick(&self, laws: &Laws, cases: &[Case]) -> Result<Option<Vec<Verdict>>, Error> {
        let cut_outs = cases.iter().filter_map(|case| match case {
            Case::CutOut(case) => Some(case),
            Case::CutIn(_) | Case::Following(_) => None,
        });
        let verdicts = cut_outs.map(|case| {
            let gap_m = self.settled.gap_m(&laws.names[0], case.speed_kmh)?;
            Ok(case.drive_from(Model::CarefulDriver, gap_m))
        });
        let verdicts: Vec<Verdict> = verdicts.collect::<Result<_, Error>>()?;
        Ok((!verdicts.is_empty()).then_some(verdicts))
    }
}

/// A scenario that identifies the study in its parts.
///
/// # Errors
/// As [`scene::scenario`].
pub fn first_scenario(settled: &Settled) -> Result<Scenario, Error> {
    let law = laws::ALL[0].name.to_owned();
    let driver = Driver { law, aebs: false };
    scene::scenario(&Matrix::Following.cases()[0], &driver, settled)
}

/// Puts laws together that are the same without signals.
fn laws_of(names: &[String], settled: &Settled) -> Result<Vec<Laws>, Error> {
    let case = Matrix::CutIn.cases()[0];
    let mut all: Vec<(String, Laws)> = Vec::new();
    for name in names {
        let driver = Driver { law: name.clone(), aebs: false };
        let scenario = scene::scenario(&case, &driver, settled)?;
        let descriptor = laws::of(&scenario).expect("the scenario was checked");
        // Laws of the user's own have one descriptor.
        let is_own = scenario.laws.contains_key(name);
        let same_as = descriptor.without_signals.unwrap_or(descriptor).name;
        let same_as = if is_own { name.clone() } else { same_as.to_owned() };
        match all.iter_mut().find(|(name, _)| *name == same_as) {
            Some((_, laws)) => laws.names.push(name.clone()),
            None => {
                // The emergency brake reads the radar's detections.
                let with_brake = scenario.perception.gives_detections();
                all.push((same_as, Laws { names: vec![name.clone()], with_brake }));
            }
        }
    }
    Ok(all.into_iter().map(|(_, laws)| laws).collect())
}

/// Each law alone and with the emergency brake.
fn drivers_of(names: Vec<String>, laws: &[Laws]) -> Vec<Driver> {
    let with_brake =
        |name: &String| laws.iter().any(|laws| laws.with_brake && laws.names.contains(name));
    let drivers = names.into_iter().flat_map(|law| {
        let brake = with_brake(&law).then(|| Driver { law: law.clone(), aebs: true });
        [Some(Driver { law, aebs: false }), brake]
    });
    drivers.flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::super::judge;
    use super::super::matrix;
    use super::*;
    use clap::ValueEnum;
    use std::cell::Cell;
    use std::collections::BTreeMap;
    use std::num::NonZeroUsize;

    use frame::Command;
    use group::in_process::run_watched;
    use group::report::Details;
    use messages::Service;

    fn arguments(words: &[&str]) -> R157Arguments {
        Command::read(words).expect("they are arguments").study
    }

    /// Digests of all messages except the brake's own, and the count of its interventions.
    fn drive(case: &Case, law: &str, aebs: bool) -> (BTreeMap<String, String>, u64) {
        let driver = Driver { law: law.into(), aebs };
        let scenario = scene::scenario(case, &driver, &Settled::new(1)).expect("a law");
        let group = run_watched(&scenario, &|| false, &mut |_| {}).expect("it runs");
        let Details::Plant(plant) = &group.reports[&Service::Plant].details else {
            panic!("the plant tells of itself")
        };
        let reports = group.reports.iter().filter(|(service, _)| **service != Service::Aebs);
        let sent = reports.flat_map(|(_, report)| &report.sent);
        let sent = sent.filter(|sent| sent.topic != "health/heartbeat");
        let digests = sent.map(|sent| (sent.topic.clone(), sent.digest.clone().expect("sealed")));
        (digests.collect(), plant.aebs.as_ref().map_or(0, |brake| brake.interventions))
    }

    #[test]
    fn a_run_in_which_the_brake_never_acted_is_the_run_without_it() {
        let (mut silent, mut acted) = (0, 0);
        for matrix in Matrix::value_variants() {
            for case in matrix::sample(matrix.cases(), 8, 3) {
                let (with_brake, interventions) = drive(&case, "six-mode", true);
                let (alone, _) = drive(&case, "six-mode", false);
                if interventions == 0 {
                    assert_eq!(with_brake, alone, "{case:?}");
                    silent += 1;
                } else {
                    assert_ne!(with_brake, alone, "{case:?}");
                    acted += 1;
                }
            }
        }
        assert!(silent > 0 && acted > 0, "{silent} and {acted}");
    }

    #[test]
    fn laws_that_are_the_same_without_signals_send_the_same_bytes() {
        for law in laws::own() {
            let Some(same) = law.without_signals else { continue };
            for matrix in Matrix::value_variants() {
                for case in matrix::sample(matrix.cases(), 2, 5) {
                    let (one, other) =
                        (drive(&case, law.name, true), drive(&case, same.name, true));
                    assert_eq!(one, other, "{} {case:?}", law.name);
                }
            }
        }
    }

    #[test]
    fn a_matrix_that_is_there_twice_and_a_seed_of_nothing_are_refused() {
        for (words, what) in [
            (&["--matrix", "cut-in", "--matrix", "cut-in"][..], "--matrix: cut-in is there twice"),
            (&["--models-only", "--seed", "7"], "--seed 7: the models have no noise"),
        ] {
            let said = Plan::of(&arguments(words)).err().expect(what).to_string();
            assert!(said.contains(what), "{said}");
        }
        let drawn = ["--models-only", "--seed", "7", "--sample", "2"];
        assert!(Plan::of(&arguments(&drawn)).is_ok());
    }

    #[test]
    fn every_driver_has_the_verdict_of_a_run_of_its_own() {
        let sample = NonZeroUsize::new(2);
        let controllers = ["--controllers", "six-mode,cacc-mpc,acc-mpc"];
        let plan = Plan::of(&R157Arguments { sample, ..arguments(&controllers) }).expect("laws");
        assert_eq!(plan.laws.len(), 2, "cacc-mpc and acc-mpc are one");
        assert_eq!((plan.drivers.len(), plan.number_of_runs()), (6, 12));
        let group = Command::<R157Arguments>::read(&[]).expect("no words").options.group;
        let observed = Cell::new(0);
        let lockstep = |scenario: &Scenario| batch::lockstep(scenario, &group, &|| true);
        let drive = |run| {
            let one = |_: bool, scenario: Scenario| {
                observed.set(observed.get() + 1);
                lockstep(&scenario)
            };
            plan.drive_case(run, &one).expect("it runs")
        };
        let kept: Vec<_> = (0..plan.number_of_runs()).map(|run| Some(drive(run))).collect();
        assert!(observed.get() >= plan.number_of_runs(), "{observed:?}");
        assert_eq!(plan.keys_of(7, true)[0].1, "following", "{:?}", plan.keys_of(7, true));
        for judged in plan.judged(&kept).expect("it runs").expect("none is missing") {
            let drivers: Vec<_> =
                judged.laws.iter().map(|d| (d.driver.law.as_str(), d.driver.aebs)).collect();
            let laws = ["six-mode", "cacc-mpc", "acc-mpc"];
            let expected: Vec<_> =
                laws.iter().flat_map(|&law| [(law, false), (law, true)]).collect();
            assert_eq!(drivers, expected);
            for Driven { driver, verdicts, from_its_gap, .. } in &judged.laws {
                assert_eq!(from_its_gap.is_some(), judged.matrix == Matrix::CutOut);
                for (case, verdict) in judged.cases.iter().zip(verdicts) {
                    let scenario = scene::scenario(case, driver, &plan.settled).expect("a law");
                    let done = lockstep(&scenario);
                    let own = judge::verdict(&done.expect("it runs").drive);
                    assert_eq!(*verdict, own, "{driver:?} {case:?}");
                }
            }
        }
        let mut missing = kept;
        missing[7] = None;
        assert!(plan.judged(&missing).expect("it runs").is_none());
    }
}
