//! What a check found.

use serde::Serialize;
use std::fmt::Write;

/// How good it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// As good as it gets.
    Ok,
    /// It works, at a cost.
    Warn,
    /// What timegap asks for is refused.
    Bad,
}

/// What one check found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub check: &'static str,
    /// How good it is.
    pub verdict: Verdict,
    /// What is there.
    pub found: String,
    /// What that costs; null when it costs nothing.
    pub costs: Option<String>,
    /// The command that improves it; null when nothing is to be improved, or no command can.
    pub fix: Option<String>,
    /// No run can start as long as it is so.
    pub prevents_runs: bool,
}

impl Finding {
    /// Nothing to complain of.
    pub fn ok(check: &'static str, found: impl Into<String>) -> Self {
        let (verdict, found) = (Verdict::Ok, found.into());
        Self { check, verdict, found, costs: None, fix: None, prevents_runs: false }
    }

    /// Something that costs.
    pub fn warn(
        check: &'static str,
        found: impl Into<String>,
        costs: impl Into<String>,
        fix: Option<String>,
    ) -> Self {
        let costs = Some(costs.into());
        Self { verdict: Verdict::Warn, costs, fix, ..Self::ok(check, found) }
    }

    /// Something that is refused.
    pub fn bad(
        check: &'static str,
        found: impl Into<String>,
        costs: impl Into<String>,
        fix: Option<String>,
    ) -> Self {
        Self { verdict: Verdict::Bad, ..Self::warn(check, found, costs, fix) }
    }

    /// Something without which nothing runs.
    pub fn fatal(check: &'static str, found: impl Into<String>, fix: &str) -> Self {
        let finding = Self::bad(check, found, "nothing can run", Some(fix.into()));
        Self { prevents_runs: true, ..finding }
    }
}

/// The findings for people.
pub fn table(findings: &[Finding]) -> String {
    let width = findings.iter().map(|finding| finding.check.len()).max().unwrap_or(0);
    let mut text = String::new();
    for finding in findings {
        let mark = match finding.verdict {
            Verdict::Ok => "ok",
            Verdict::Warn => "warn",
            Verdict::Bad => "BAD",
        };
        let mut line = |mark: &str, check: &str, words: &str| {
            writeln!(text, "  {mark:<4}  {check:<width$}  {words}").expect("a string takes all");
        };
        line(mark, finding.check, &finding.found);
        if let Some(costs) = &finding.costs {
            line("", "", &format!("costs: {costs}"));
        }
        if let Some(fix) = &finding.fix {
            line("", "", &format!("fix:   {fix}"));
        }
    }
    text
}
