//! The result: all drives added up, and the goals.

use group::report::Outcome;
use report::results::{
    Column, Document, Format, Kind, Schema, Table, column, count, fact, flag, nested, number,
    outcome, word,
};
use serde::Serialize;
use serde_json::json;

use super::figures::{self, Figures};
use super::judge::Kept;
use super::limits::OF_RIVAL;
use super::{LAWS, NAME, OURS, RIVAL, corridor};
use crate::required;
use report::verdicts::{self, LEAST, Least};

/// The sums over all corridors.
#[derive(Clone, Debug, Serialize)]
struct Results {
    schema_version: u32,
    ok: bool,
    corridors: usize,
    laws: Vec<Law>,
    goals: Vec<Goal>,
    failures: Vec<String>,
    margins: Vec<Least>,
}

/// Figures of a law.
#[derive(Clone, Debug, Serialize)]
struct Law {
    law: String,
    red_lights: usize,
    collisions: usize,
    #[serde(flatten)]
    all: Figures,
    /// Corridors without a lead.
    free: Figures,
    /// Corridors with a lead.
    led: Figures,
}

/// A figure of ours that may be at most half of the rival's.
#[derive(Clone, Debug, Serialize)]
struct Goal {
    name: &'static str,
    ours: f64,
    rival: f64,
    /// Ours over the rival's; null where that is 0.
    ratio: Option<f64>,
    limit: f64,
    met: bool,
}

/// A law over corridors of one kind, for people.
#[derive(Serialize)]
struct Line<'a> {
    kind: String,
    law: &'a str,
    #[serde(flatten)]
    figures: &'a Figures,
}

/// Fields of the JSON.
const FIELDS: &[Column<Results>] = &[
    frame::ok(
        "cacc-mpc and laws of --law crossed no red light, touched nothing and ended every run; goals do not count",
    ),
    count("corridors", "", "Corridors, each driven by every law"),
    nested(
        "failures",
        Kind::List,
        "Runs that broke a requirement, but for those of acc-signal-stop, with the command",
    ),
];

/// Columns of the goals.
const GOALS: &[Column<Goal>] = &[
    word("name", "goal", "Figure of cacc-mpc beside the one of acc-signal-stop"),
    number("ours", OURS, "", 2, "Figure of cacc-mpc"),
    number("rival", RIVAL, "", 2, "Figure of acc-signal-stop"),
    number("ratio", "ratio", "", 2, "Ours over the rival's; null where that is 0"),
    number("limit", "at most", "", 2, "Largest accepted ratio"),
    flag("met", "verdict", ("met", "missed"), "The ratio is within its limit"),
];

/// Columns of `signals.csv`.
const DRIVES: &[Column<Kept>] = &[
    count("corridor", "", "Number of the corridor"),
    word("law", "", "Control law"),
    fact("is_led", "", "The corridor has a lead"),
    number("ahead_s", "", "s", 1, "Time before a line at which its countdown arrives"),
    outcome("outcome"),
    number("excess_s", "", "s", 3, "Trip time beyond the fastest legal trip"),
    number("excess_at_line_s", "", "s", 3, "The same at the last line"),
    number("excess_behind_lead_s", "", "s", 3, "The same beyond the fastest trip behind the lead"),
    count("lines", "", "Stop lines"),
    count("greens_used", "", "Lines crossed in the first green that could be reached"),
    count("not_passed", "", "Lines that were not passed"),
    count("stops", "", "Standstills"),
    number("energy_kwh_per_100km", "", "kWh/100 km", 2, "Energy at the wheels"),
    number("rms_jerk_mps3", "", "m/s³", 3, "Root mean square of the jerk"),
    number("max_jerk_mps3", "", "m/s³", 1, "Largest magnitude of the jerk"),
    count("emergency_brakings", "", "Interventions of the emergency brake")
        .of(|run| json!(run.interventions)),
    word("margins", "", "Margins of the requirements")
        .of(|run| json!(verdicts::words(&run.requirements))),
];

/// Columns of the drives that broke a requirement.
const FAILURES: &[Column<Kept>] = &[
    count("corridor", "corridor", "Number of the corridor"),
    word("law", "law", "Control law"),
    outcome("outcome"),
    column("repeat", "", "", Format::Command, "Command that repeats all drives of the corridor")
        .of(|run| json!(run.repeat())),
];

/// Contents of the JSON.
#[must_use]
pub fn schema() -> Schema {
    let law = [
        word("law", "", "Control law"),
        count("red_lights", "", "Runs that crossed a red light"),
        count("collisions", "", "Runs that ended in a collision"),
    ];
    let laws: Vec<Column<()>> = law
        .into_iter()
        .chain(["", "free.", "led."].into_iter().flat_map(figures::columns))
        .collect();
    Schema::new(NAME, "Corridors of signals, driven by cacc-mpc and by an ACC that stops for them")
        .fields(FIELDS)
        .rows("laws", "Each law over all corridors, without a lead, and with one", &laws)
        .rows("goals", "Figures of cacc-mpc that may be at most a share of the rival's", GOALS)
        .rows(
            "margins",
            "Least margins of the requirements of the command, but for the rival's",
            LEAST,
        )
}

/// The document of all drives.
pub fn document(runs: &[Kept]) -> Document {
    let results = Results::of(runs);
    let columns: Vec<Column<Line<'_>>> =
        [word("kind", "corridors", "Kind of the corridors"), word("law", "law", "Control law")]
            .into_iter()
            .chain(figures::columns(""))
            .collect();
    let of_kind = |kind: &str, of: fn(&Law) -> &Figures| {
        let lines = results.laws.iter().map(|law| {
            let figures = of(law);
            Line { kind: format!("{} corridors{kind}", figures.corridors), law: &law.law, figures }
        });
        lines.filter(|line| line.figures.corridors > 0).collect::<Vec<_>>()
    };
    let mut lines = of_kind("", |law| &law.all);
    lines.extend(of_kind(" without a lead", |law| &law.free));
    lines.extend(of_kind(" with a lead", |law| &law.led));
    let failed: Vec<Kept> = runs.iter().filter(|run| !run.holds()).cloned().collect();
    let broken: Vec<String> = results.laws.iter().map(Law::in_words).collect();
    let met = results.goals.iter().filter(|goal| goal.met).count();
    let verdict = format!("{}; {met} of {} goals met", broken.join("; "), results.goals.len());
    let document = Document::new(NAME, "Corridors of signals", &results)
        .about(format!("{} corridors, lockstep", results.corridors))
        .verdict(results.ok, verdict)
        .table(Table::new("Laws", &columns, &lines).blocks("kind"))
        // A goal is not a requirement.
        .table(Table::new("Goals", GOALS, &results.goals).without_cases())
        .table(Table::new("Runs that broke a requirement", FAILURES, &failed))
        .file("signals.csv", Table::new("", DRIVES, runs).csv());
    let document = required::show(document, &results.margins);
    failed.iter().fold(document, |document, run| {
        let name = format!("corridor-{}-{}.toml", run.corridor, run.law);
        document.file(&name, corridor(run.corridor as u64, &run.law))
    })
}

impl Results {
    fn of(runs: &[Kept]) -> Self {
        let mut names: Vec<&str> = LAWS.to_vec();
        for run in runs {
            if !names.contains(&run.law.as_str()) {
                names.push(&run.law);
            }
        }
        let laws: Vec<Law> = names.iter().map(|law| Law::of(law, runs)).collect();
        let figures = |name: &str| laws.iter().find(|law| law.law == name).map(|law| &law.all);
        let goals = figures(OURS).zip(figures(RIVAL)).map_or_else(Vec::new, |(ours, rival)| {
            let missed = |figures: &Figures| figures.greens_missed as f64;
            vec![
                Goal::of("excess_trip_s.mean", ours.excess_trip_s.mean, rival.excess_trip_s.mean),
                Goal::of(
                    "excess_behind_lead_s.mean",
                    ours.excess_behind_lead_s.mean,
                    rival.excess_behind_lead_s.mean,
                ),
                Goal::of("greens_missed", missed(ours), missed(rival)),
            ]
        });
        // The rival is a yardstick, and not judged.
        let broken = |run: &&Kept| run.law != RIVAL && !run.holds();
        let failures: Vec<String> = runs.iter().filter(broken).map(Kept::failure).collect();
        let judged = runs.iter().filter(|run| run.law != RIVAL);
        let name = |run: &Kept| format!("corridor {}, {}", run.corridor, run.law);
        let margins = verdicts::least(judged.map(|run| (name(run), run.requirements.as_slice())));
        Self {
            schema_version: 1,
            ok: failures.is_empty(),
            corridors: laws.iter().map(|law| law.all.corridors).max().unwrap_or(0),
            laws,
            goals,
            failures,
            margins,
        }
    }
}

impl Law {
    fn of(law: &str, runs: &[Kept]) -> Self {
        let of_law = || runs.iter().filter(|run| run.law == law);
        let count = |outcome| of_law().filter(|run| run.outcome == outcome).count();
        Self {
            law: law.to_owned(),
            red_lights: count(Outcome::RedLight),
            collisions: count(Outcome::Collision),
            all: Figures::of(&of_law().collect::<Vec<_>>()),
            free: Figures::of(&of_law().filter(|run| !run.is_led).collect::<Vec<_>>()),
            led: Figures::of(&of_law().filter(|run| run.is_led).collect::<Vec<_>>()),
        }
    }

    fn in_words(&self) -> String {
        let Self { law, red_lights, collisions, .. } = self;
        format!("{law}: {red_lights} red lights, {collisions} collisions")
    }
}

impl Goal {
    fn of(name: &'static str, ours: f64, rival: f64) -> Self {
        let ratio = (rival > 0.0).then(|| ours / rival);
        Self { name, ours, rival, ratio, limit: OF_RIVAL, met: ours <= OF_RIVAL * rival }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(law: &str, excess_s: f64, greens_used: usize, outcome: Outcome) -> Kept {
        Kept { greens_used, outcome, ..Kept::example(law, excess_s) }
    }

    #[test]
    fn a_goal_is_judged_by_the_rival_and_a_red_light_by_itself() {
        let done = Outcome::Completed;
        let runs = [run(OURS, 2.0, 3, done), run(RIVAL, 5.0, 2, done)];
        let results = Results::of(&runs);
        assert!(results.ok);
        assert_eq!(
            results.goals.iter().map(|goal| goal.met).collect::<Vec<_>>(),
            [true, true, true]
        );
        let runs = [run(OURS, 3.0, 2, Outcome::RedLight), run(RIVAL, 5.0, 2, Outcome::RedLight)];
        let results = Results::of(&runs);
        assert!(
            !results.ok && results.failures.len() == 1 && results.failures[0].contains("red light")
        );
        assert_eq!(
            results.goals.iter().map(|goal| goal.met).collect::<Vec<_>>(),
            [false, false, false]
        );
        let document = document(&runs);
        assert!(
            document.console(80).contains("cacc-mpc: 1 red lights"),
            "{}",
            document.console(80)
        );
        assert!(document.junit().contains("<failure"), "{}", document.junit());
        assert_eq!(report::results::check(&schema().json(), &document.value()), [""; 0]);
    }
}
