//! All drives added up, and the goals.

use super::judge::Kept;
use super::limits::OF_RIVAL;
use super::{LAWS, OURS, RIVAL};
use frame::batch::ProcessesSample;
use group::report::Outcome;
use report::chart::number;
use report::table::{self, TextTable};
use serde::Serialize;

/// What came of all corridors.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    schema_version: u32,
    /// `cacc-mpc` crossed no red light, touched nothing and ended every run. The goals do not count here.
    pub ok: bool,
    corridors: usize,
    laws: Vec<Law>,
    goals: Vec<Goal>,
    /// Runs of `cacc-mpc` that broke a requirement.
    failures: Vec<String>,
    processes_sample: ProcessesSample,
}

/// A law's figures.
#[derive(Clone, Debug, Serialize)]
struct Law {
    law: String,
    red_lights: usize,
    collisions: usize,
    #[serde(flatten)]
    all: Figures,
    /// Corridors without and with a lead.
    free: Figures,
    led: Figures,
}

/// Figures of a law over some corridors.
#[derive(Clone, Debug, Serialize)]
struct Figures {
    corridors: usize,
    /// Trip time beyond the fastest legal trip.
    excess_trip_s: Excess,
    /// The same at the last line.
    excess_at_last_line_s: Excess,
    /// Trip time beyond the fastest legal trip that stays behind the lead.
    excess_behind_lead_s: Excess,
    /// Share of the lines that were crossed in the first green that could be reached from the line before.
    greens_used: f64,
    /// Lines that were not.
    greens_missed: usize,
    /// Lines that were not passed before the run's end.
    lines_not_passed: usize,
    stops_per_corridor: f64,
    energy_kwh_per_100km: f64,
    rms_jerk_mps3: f64,
    max_jerk_mps3: f64,
    emergency_brakings: u64,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Excess {
    mean: f64,
    p90: f64,
}

impl Excess {
    fn of(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let place = ((0.9 * all.len() as f64).ceil() as usize).saturating_sub(1);
        Self { mean, p90: all.get(place).copied().unwrap_or(0.0) }
    }
}

/// A figure of ours that is to be at most half of the rival's.
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

impl Table {
    /// Adds up.
    pub fn of(runs: &[Kept], processes_sample: ProcessesSample) -> Self {
        let laws: Vec<Law> = LAWS.iter().map(|law| Law::of(law, runs)).collect();
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
        let broken = |run: &&Kept| run.law == OURS && !run.holds();
        let failures: Vec<String> = runs.iter().filter(broken).map(Kept::failure).collect();
        Self {
            schema_version: 1,
            ok: failures.is_empty(),
            corridors: runs.len() / LAWS.len(),
            laws,
            goals,
            failures,
            processes_sample,
        }
    }

    /// For a terminal.
    pub fn text(&self) -> String {
        let mut rows = TextTable::of_figures([
            "law",
            "corridors",
            "trip beyond the fastest, s: mean",
            "p90",
            "behind the lead",
            "greens used",
            "missed",
            "stops",
            "kWh/100 km",
            "jerk rms, m/s³",
            "max",
        ]);
        for law in &self.laws {
            for (kind, figures) in [("all", &law.all), ("free", &law.free), ("led", &law.led)] {
                rows.row([
                    law.law.clone(),
                    format!("{} {kind}", figures.corridors),
                    number(figures.excess_trip_s.mean, 2),
                    number(figures.excess_trip_s.p90, 2),
                    number(figures.excess_behind_lead_s.mean, 2),
                    format!("{:.1} %", 100.0 * figures.greens_used),
                    figures.greens_missed.to_string(),
                    number(figures.stops_per_corridor, 2),
                    number(figures.energy_kwh_per_100km, 2),
                    number(figures.rms_jerk_mps3, 3),
                    number(figures.max_jerk_mps3, 1),
                ]);
            }
        }
        let mut text = format!("{} corridors\n{}", self.corridors, rows.text());
        for law in &self.laws {
            let mark = if law.law != OURS || self.ok { "" } else { "  BROKEN" };
            text += &format!(
                "  {}: {} red lights, {} collisions{mark}\n",
                law.law, law.red_lights, law.collisions
            );
        }
        for goal in &self.goals {
            let mark = if goal.met { "met" } else { "missed" };
            text += &format!(
                "  goal {mark:<7} {} at most {} of {RIVAL}'s: {} against {}\n",
                goal.name,
                goal.limit,
                number(goal.ours, 2),
                number(goal.rival, 2)
            );
        }
        for failure in &self.failures {
            text += &format!("  {failure}\n");
        }
        text
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
}

impl Figures {
    fn of(runs: &[&Kept]) -> Self {
        let mean = |figure: &dyn Fn(&Kept) -> Option<f64>| {
            let figures: Vec<f64> = runs.iter().filter_map(|run| figure(run)).collect();
            figures.iter().sum::<f64>() / figures.len().max(1) as f64
        };
        let lines: usize = runs.iter().map(|run| run.lines).sum();
        let used: usize = runs.iter().map(|run| run.greens_used).sum();
        Self {
            corridors: runs.len(),
            excess_trip_s: Excess::of(runs.iter().map(|run| run.excess_s).collect()),
            excess_at_last_line_s: Excess::of(
                runs.iter().map(|run| run.excess_at_line_s).collect(),
            ),
            excess_behind_lead_s: Excess::of(
                runs.iter().map(|run| run.excess_behind_lead_s).collect(),
            ),
            greens_used: used as f64 / lines.max(1) as f64,
            greens_missed: lines - used,
            lines_not_passed: runs.iter().map(|run| run.not_passed).sum(),
            stops_per_corridor: mean(&|run| Some(run.stops as f64)),
            energy_kwh_per_100km: mean(&|run| run.energy_kwh_per_100km),
            rms_jerk_mps3: mean(&|run| run.rms_jerk_mps3),
            max_jerk_mps3: runs.iter().filter_map(|run| run.max_jerk_mps3).fold(0.0, f64::max),
            emergency_brakings: runs.iter().map(|run| run.interventions).sum(),
        }
    }
}

impl Goal {
    fn of(name: &'static str, ours: f64, rival: f64) -> Self {
        let ratio = (rival > 0.0).then(|| ours / rival);
        Self { name, ours, rival, ratio, limit: OF_RIVAL, met: ours <= OF_RIVAL * rival }
    }
}

/// One row for each drive.
pub fn csv(runs: &[Kept]) -> String {
    let head = [
        "corridor",
        "law",
        "is_led",
        "ahead_s",
        "outcome",
        "excess_s",
        "excess_at_line_s",
        "excess_behind_lead_s",
        "lines",
        "greens_used",
        "not_passed",
        "stops",
        "energy_kwh_per_100km",
        "rms_jerk_mps3",
        "max_jerk_mps3",
        "emergency_brakings",
    ];
    let rows = runs.iter().map(|run| {
        [
            run.corridor.to_string(),
            run.law.clone(),
            run.is_led.to_string(),
            format!("{:.1}", run.ahead_s),
            report::print::outcome_word(run.outcome).to_lowercase(),
            format!("{:.3}", run.excess_s),
            format!("{:.3}", run.excess_at_line_s),
            format!("{:.3}", run.excess_behind_lead_s),
            run.lines.to_string(),
            run.greens_used.to_string(),
            run.not_passed.to_string(),
            run.stops.to_string(),
            table::field(run.energy_kwh_per_100km),
            table::field(run.rms_jerk_mps3),
            table::field(run.max_jerk_mps3),
            run.interventions.to_string(),
        ]
    });
    table::csv(head, rows)
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
        let table = Table::of(&runs, ProcessesSample::default());
        assert!(table.ok);
        assert_eq!(table.goals.iter().map(|goal| goal.met).collect::<Vec<_>>(), [true, true, true]);
        let runs = [run(OURS, 3.0, 2, Outcome::RedLight), run(RIVAL, 5.0, 2, Outcome::RedLight)];
        let table = Table::of(&runs, ProcessesSample::default());
        assert!(!table.ok && table.failures.len() == 1 && table.failures[0].contains("red light"));
        assert_eq!(
            table.goals.iter().map(|goal| goal.met).collect::<Vec<_>>(),
            [false, false, false]
        );
    }
}
