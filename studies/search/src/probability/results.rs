//! The answer: the estimates beside each other, and which variable matters.

use rare_events::sobol::{self, Indices};
use rare_events::{ENOUGH_EVENTS, Estimate, Replica, disagree};
use report::html::Tile;
use report::print::counted;
use report::results::{Column, Document, Format, Table, column, count, number, word};
use serde::Serialize;
use serde_json::{Value as Json, json};

use super::model::Model;
use super::unit::{Kind as UnitKind, Unit, Units};
use crate::problem::Problem;
use crate::results::Search;

pub(super) struct Answer {
    monte_carlo: Estimate,
    cross_entropy: Estimate,
    indices: Option<Vec<Indices>>,
    points: usize,
    driven: usize,
    clipped: usize,
}

/// An estimate, for people.
#[derive(Debug, Serialize)]
struct Line {
    method: &'static str,
    estimate: f64,
    low: f64,
    high: f64,
    runs: usize,
    events: usize,
    note: String,
}

#[derive(Debug, Serialize)]
struct VariableLine {
    name: String,
    distribution: String,
    importance: Option<f64>,
    first_order: Option<f64>,
    total: Option<f64>,
}

const LINES: &[Column<Line>] = &[
    word("method", "method", "Estimator"),
    word("", "probability", "Probability of a failure in a scene")
        .of(|line| json!(scientific(line.estimate))),
    word("", "from", "Lower end of the 95 % interval").of(|line| json!(scientific(line.low))),
    word("", "to", "Upper end of the 95 % interval").of(|line| json!(scientific(line.high))),
    count("runs", "points", "Points that it took"),
    count("events", "failures", "Points that failed"),
    column("note", "remark", "", Format::Sentence, "Limits of the estimate"),
];

const VARIABLES: &[Column<VariableLine>] = &[
    word("name", "variable", "Name of the variable"),
    word("distribution", "distribution", "Its distribution"),
    number("importance", "importance", "", 2, "Share in the direction of the failures"),
    number("first_order", "first order", "", 2, "Sobol's index of the value: it alone"),
    number("total", "total", "", 2, "Sobol's index of the value: with all others"),
];

impl Answer {
    pub(super) fn of(units: &Units, model: &Model, all: &[Unit]) -> Self {
        let replicas: Vec<Replica> = all.iter().filter_map(Unit::replica).collect();
        let mut events: Vec<Vec<f64>> = Vec::new();
        let mut runs = 0;
        for (number, unit) in all.iter().enumerate() {
            let is_plain = matches!(units.kind(number), UnitKind::MonteCarlo { .. });
            // Units after enough events may have been driven or not, by chance.
            if is_plain && events.len() < units.enough() {
                events.extend(unit.events.iter().cloned());
                runs += unit.points;
            }
        }
        let rows: Vec<Vec<f64>> = all.iter().flat_map(|unit| unit.rows.iter().cloned()).collect();
        let sum = |of: fn(&Unit) -> usize| all.iter().map(of).sum();
        Self {
            monte_carlo: Estimate::of_points(&events, runs),
            cross_entropy: Estimate::of_replicas(&replicas),
            indices: sobol::of_rows(&rows).filter(|_| !model.is_correlated),
            points: sum(|unit| unit.points),
            driven: sum(|unit| unit.driven),
            clipped: sum(|unit| unit.clipped),
        }
    }

    fn disagrees(&self) -> bool {
        disagree(&self.monte_carlo, &self.cross_entropy)
    }

    /// The estimate to quote: Monte Carlo with enough events, else the narrower interval by the ratio of its ends.
    fn best(&self) -> (&'static str, &Estimate) {
        let ratio = |of: &Estimate| match of.interval {
            [low, high] if low > 0.0 => high / low,
            _ => f64::INFINITY,
        };
        let has_enough = self.monte_carlo.events >= ENOUGH_EVENTS;
        let is_plain = has_enough || ratio(&self.monte_carlo) <= ratio(&self.cross_entropy);
        match is_plain || self.disagrees() {
            true => (PLAIN, &self.monte_carlo),
            false => (FITTED, &self.cross_entropy),
        }
    }

    fn lines(&self) -> Vec<Line> {
        let unsettled = match self.cross_entropy.unsettled {
            0 => String::new(),
            count => {
                format!("{count} of 5 replicas did not settle: the failures may have more parts")
            }
        };
        let line = |method, of: &Estimate, note| Line {
            method,
            estimate: of.probability,
            low: of.interval[0],
            high: of.interval[1],
            runs: of.runs,
            events: of.events,
            note,
        };
        vec![
            line(PLAIN, &self.monte_carlo, String::new()),
            line(FITTED, &self.cross_entropy, unsettled),
        ]
    }

    fn variables(&self, problem: &Problem, model: &Model) -> Vec<VariableLine> {
        let importance = match self.cross_entropy.importance.is_empty() {
            true => &self.monte_carlo.importance,
            false => &self.cross_entropy.importance,
        };
        let index = |place: usize| self.indices.as_ref().map(|indices| indices[place]);
        let variables = problem.variables.iter().zip(&model.distributions).enumerate();
        let line =
            |(place, (variable, distribution)): (usize, (&crate::problem::Variable, &String))| {
                VariableLine {
                    name: variable.name.clone(),
                    distribution: distribution.clone(),
                    importance: importance.get(place).copied(),
                    first_order: index(place).map(|index| index.first),
                    total: index(place).map(|index| index.total),
                }
            };
        variables.map(line).collect()
    }

    /// The rate by the user's exposure.
    fn rate(&self, model: &Model) -> Option<Json> {
        let exposure = model.exposure.as_ref()?;
        let (_, best) = self.best();
        let times = |p: f64| p * exposure.events;
        Some(json!({
            "per": exposure.per,
            "scenes": exposure.events,
            "source": exposure.source,
            "rate": times(best.probability),
            "ci95": best.interval.map(times),
        }))
    }

    fn json(&self, problem: &Problem, model: &Model) -> Json {
        let (method, best) = self.best();
        let of = |of: &Estimate| {
            json!({
                "estimate": of.probability,
                "ci95": of.interval,
                "runs": of.runs,
                "failures": of.events,
                "replicas": of.replicas,
                "unsettled": of.unsettled,
            })
        };
        json!({
            "estimate": best.probability,
            "ci95": best.interval,
            "runs": self.points,
            "method": method,
            "disagreement": self.disagrees(),
            "monte_carlo": of(&self.monte_carlo),
            "cross_entropy": of(&self.cross_entropy),
            "driven": self.driven,
            "clipped": self.clipped,
            "exposure": self.rate(model),
            "variables": self.variables(problem, model),
        })
    }

    /// The result for every output.
    pub(super) fn document(&self, problem: &Problem, model: &Model) -> Document {
        let ok = !self.disagrees();
        let found = (self.json(problem, model), ok);
        let whole = Search::of_probability(problem, found, self.points);
        let about = format!(
            "{} ({}): {}, {}",
            problem.name,
            problem.nominal.controller.name.as_str(),
            counted(problem.dimensions() as u64, "variable"),
            problem.nominal.require.formulas.join(", ")
        );
        let mut document =
            Document::new("search", &format!("Probability in {}", problem.name), &whole)
                .about(about)
                .tiles(self.tiles())
                .table(Table::new("Estimates", LINES, &self.lines()).without_cases())
                .table(
                    Table::new("Variables", VARIABLES, &self.variables(problem, model))
                        .without_cases(),
                )
                .verdict(ok, self.sentence());
        if let Some(exposure) = &model.exposure {
            let (_, best) = self.best();
            let rate = |p: f64| scientific(p * exposure.events);
            let [low, high] = best.interval;
            document = document.text(format!(
                "With {} scenes per {} ({}): {} failures per {}, 95 % {} to {}.",
                exposure.events,
                exposure.per,
                exposure.source,
                rate(best.probability),
                exposure.per,
                rate(low),
                rate(high)
            ));
        }
        if self.clipped > 0 {
            document = document.text(format!(
                "{} of {} points had a value beyond its variable's range; it counted as the range's end.",
                self.clipped, self.points
            ));
        }
        document.text(NOTE)
    }

    fn tiles(&self) -> Vec<Tile> {
        let (method, best) = self.best();
        let [low, high] = best.interval;
        let tile = |label, value: String, note: String| Tile { label, value, note };
        let interval = format!("95 % {} to {}, {method}", scientific(low), scientific(high));
        vec![
            tile("Probability per scene", scientific(best.probability), interval),
            tile("Points", self.points.to_string(), format!("{} driven", self.driven)),
        ]
    }

    fn sentence(&self) -> String {
        let (method, best) = self.best();
        let words = |of: &Estimate| {
            let [low, high] = of.interval;
            format!(
                "{} (95 % {} to {})",
                scientific(of.probability),
                scientific(low),
                scientific(high)
            )
        };
        if self.disagrees() {
            return format!(
                "DISAGREEMENT: {PLAIN} {}, {FITTED} {}: the fit misses a part of the failures",
                words(&self.monte_carlo),
                words(&self.cross_entropy)
            );
        }
        format!("a failure in a scene has the probability {}, by {method}", words(best))
    }
}

const PLAIN: &str = "monte-carlo";
const FITTED: &str = "cross-entropy";

/// A note on what the numbers mean.
const NOTE: &str = "The probability is one of the distributions that were given. The importance is the share of a \
                    variable in the mean direction of the failures; a correlated variable has the share that it adds to \
                    the variables before it. Sobol's indices explain the variance of the value.";

fn scientific(number: f64) -> String {
    if number == 0.0 { "0".to_owned() } else { format!("{number:.1e}") }
}
