//! The result of a check.

use report::results::{Column, Format, Table, column, word};
use serde::Serialize;
use serde_json::{Value, json};

/// Grade of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing to improve.
    Ok,
    /// It works, at a cost.
    Warn,
    /// The machine refuses a need of timegap.
    Bad,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    pub check: &'static str,
    pub verdict: Verdict,
    /// State of the machine.
    pub found: String,
    /// Cost of that state; null without one.
    pub costs: Option<String>,
    /// The command that improves it; null if none can.
    pub fix: Option<String>,
    /// True if no run can start in this state.
    pub prevents_runs: bool,
}

impl Finding {
    /// A state without a cost.
    pub fn ok(check: &'static str, found: impl Into<String>) -> Self {
        let (verdict, found) = (Verdict::Ok, found.into());
        Self { check, verdict, found, costs: None, fix: None, prevents_runs: false }
    }

    /// A state with a cost.
    pub fn warn(
        check: &'static str,
        found: impl Into<String>,
        costs: impl Into<String>,
        fix: Option<String>,
    ) -> Self {
        let costs = Some(costs.into());
        Self { verdict: Verdict::Warn, costs, fix, ..Self::ok(check, found) }
    }

    /// A refused need.
    pub fn bad(
        check: &'static str,
        found: impl Into<String>,
        costs: impl Into<String>,
        fix: Option<String>,
    ) -> Self {
        Self { verdict: Verdict::Bad, ..Self::warn(check, found, costs, fix) }
    }

    /// A state in which no run can start.
    pub fn fatal(check: &'static str, found: impl Into<String>, fix: &str) -> Self {
        let finding = Self::bad(check, found, "nothing can run", Some(fix.into()));
        Self { prevents_runs: true, ..finding }
    }
}

pub fn table(findings: &[Finding]) -> Table {
    fn labelled(label: &str, words: &Option<String>) -> Value {
        json!(words.as_ref().map(|words| format!("{label} {words}")))
    }
    let columns: [Column<Finding>; 5] = [
        column("verdict", "", "", Format::Verdict(words), "Grade"),
        word("check", "", "Name of the check"),
        word("found", "", "State of the machine"),
        column("", "", "", Format::Sentence, "Cost of that state")
            .of(|finding| labelled("costs:", &finding.costs)),
        column("", "", "", Format::Command, "The command that improves it")
            .of(|finding| labelled("fix:", &finding.fix)),
    ];
    Table::new("Findings", &columns, findings)
}

/// Some costs are accepted, a refusal is not.
fn words(verdict: &str) -> (&'static str, bool) {
    match verdict {
        "ok" => ("ok", true),
        "warn" => ("warn", true),
        _ => ("BAD", false),
    }
}
