//! Whether the faults of a campaign have something to act on.
//!
//! Faults are drawn for scenarios of all kinds, and a fault may have no receiver in some of them. A fault without a
//! receiver in any scenario shows nothing: a campaign refuses it, as `timegap run` does.

use scenario::Scenario;
use scenario::faults::Target;
use supervise::{UsageError, absent};

/// The targets of the faults, and those without a receiver.
#[derive(Debug, Default)]
pub struct Targets {
    present: Vec<Target>,
    absent: Vec<(Target, UsageError)>,
}

impl Targets {
    /// Notes the faults of a run.
    pub fn note(&mut self, scenario: &Scenario) {
        for fault in &scenario.faults {
            let target = fault.effect.target();
            match absent(fault, scenario) {
                None if !self.present.contains(&target) => self.present.push(target),
                Some(what) if self.absent.iter().all(|(known, _)| *known != target) => {
                    self.absent.push((target, what));
                }
                _ => {}
            }
        }
    }

    /// Refuses a target that was absent in every run.
    pub fn check(self) -> Result<(), UsageError> {
        let Self { present, absent } = self;
        match absent.into_iter().find(|(target, _)| !present.contains(target)) {
            Some((_, what)) => {
                let place = "faults, in every scenario of the campaign".to_owned();
                Err(UsageError { place, ..what })
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario(aebs: bool, topic: &str) -> Scenario {
        let text = format!(
            "schema_version = 1\nname = \"x\"\n[aebs]\nenabled = {aebs}\n[[faults]]\nkind = \"drop\"\n\
             topic = \"{topic}\"\nat_s = 1.0\nfor_s = 1.0\n"
        );
        Scenario::parse("x.toml", &text).expect("a scenario")
    }

    #[test]
    fn a_topic_that_no_scenario_receives_is_refused() {
        let mut targets = Targets::default();
        targets.note(&scenario(true, "radar/tracks"));
        targets.note(&scenario(false, "radar/detections"));
        let refused = targets.check().expect_err("no emergency brake takes part").to_string();
        assert!(refused.contains("radar/detections"), "{refused}");
    }

    #[test]
    fn a_topic_that_one_scenario_receives_is_drawn() {
        let mut targets = Targets::default();
        targets.note(&scenario(false, "radar/detections"));
        targets.note(&scenario(true, "radar/detections"));
        assert!(targets.check().is_ok());
    }
}
