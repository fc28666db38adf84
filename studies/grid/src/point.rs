//! Rows of several seeds as one point.

use report::figures::{Fold, Folded, compared};
use report::{print, verdicts};
use serde_json::{Map, Value, json};
use supervise::RequirementVerdict;
use supervise::report::Outcome;

use crate::row::Row;

/// A cell of the grid, folded over its seeds.
pub struct Point<'a> {
    /// Its runs; the first stands for all.
    pub rows: &'a [Row],
    /// Runs that reached the scenario's end.
    pub completed: usize,
    /// The compared figures.
    pub folded: Vec<Folded>,
    /// Least margin of each requirement.
    pub requirements: Vec<RequirementVerdict>,
}

/// The points of rows whose seeds stand together.
pub fn points(rows: &[Row]) -> Vec<Point<'_>> {
    let cell = |row: &Row| (row.scenario.clone(), row.controller.clone(), row.values.clone());
    rows.chunk_by(|a, b| cell(a) == cell(b)).map(Point::of).collect()
}

impl<'a> Point<'a> {
    fn of(rows: &'a [Row]) -> Self {
        let fold = |figure: &'static report::figures::Figure| {
            figure.fold.over(rows.iter().map(|row| row.figures.get(figure)))
        };
        let verdicts = rows.iter().map(|row| (String::new(), row.requirements.as_slice()));
        let least = verdicts::least(verdicts).into_iter().map(|least| least.verdict);
        Self {
            rows,
            completed: rows.iter().filter(|row| row.outcome == Outcome::Completed).count(),
            folded: compared().map(fold).collect(),
            requirements: least.collect(),
        }
    }

    pub fn figures(&self, of: impl Fn(&Folded) -> Value) -> Map<String, Value> {
        let names = compared().map(|figure| figure.name.to_owned());
        names.zip(self.folded.iter().map(of)).collect()
    }

    /// The row for people. A mean has its spread, and its n where the figure does not apply in every run; `all_means`
    /// shows means of the other figures too.
    pub fn shown(&self, all_means: bool) -> Map<String, Value> {
        let mut shown = Map::new();
        for (figure, Folded { value, spread }) in compared().zip(&self.folded) {
            let n = (spread.n != self.rows.len()).then_some(spread.n);
            let is_mean = all_means || (figure.fold == Fold::Mean && spread.deviation.is_some());
            let cell = match spread.mean.filter(|_| is_mean) {
                Some(mean) => json!({"mean": mean, "deviation": spread.deviation, "n": n}),
                None => json!(value),
            };
            shown.insert(figure.name.to_owned(), cell);
        }
        let ended = print::outcomes(self.rows.iter().map(|row| row.outcome));
        let ok = self.completed == self.rows.len();
        shown.insert("ended".to_owned(), json!({"text": ended, "ok": ok}));
        shown.insert("margins".to_owned(), json!(verdicts::words(&self.requirements)));
        shown
    }
}
