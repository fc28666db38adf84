//! Counts of the figures within their tolerance.

use super::row::{Kind, Row, Verdict};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// Figures of one kind. Rows of several sets that share an id are one figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Tally {
    /// Their kind.
    pub kind: Kind,
    /// Different figures that are compared.
    pub figures: usize,
    /// Figures within their tolerance in every set that has them.
    pub in_every_set: usize,
    /// Figures within it in one set and outside it in another.
    pub in_some_sets: usize,
    /// Figures outside it in every set.
    pub in_no_set: usize,
}

/// The compared figures among `rows`, one entry a kind that is there.
pub fn tally(rows: &[Row]) -> Vec<Tally> {
    [Kind::Paper, Kind::Reconstruction, Kind::Requirement]
        .into_iter()
        .map(|kind| of_kind(rows, kind))
        .filter(|tally| tally.figures > 0)
        .collect()
}

fn of_kind(rows: &[Row], kind: Kind) -> Tally {
    let compared = |row: &&Row| row.kind == kind && row.verdict() != Verdict::Shown;
    let mut figures: BTreeMap<&str, (bool, bool)> = BTreeMap::new();
    for row in rows.iter().filter(compared) {
        let (within, outside) = figures.entry(&row.id).or_default();
        *within |= row.ok;
        *outside |= !row.ok;
    }
    let count =
        |within, outside| figures.values().filter(|seen| **seen == (within, outside)).count();
    Tally {
        kind,
        figures: figures.len(),
        in_every_set: count(true, false),
        in_some_sets: count(true, true),
        in_no_set: count(false, true),
    }
}

impl Tally {
    /// In words: "18 of 19 figures of the paper, 1 more in some sets".
    pub fn in_words(&self) -> String {
        let kind = match self.kind {
            Kind::Paper => "figures of the paper",
            Kind::Reconstruction => "of the reconstruction",
            Kind::Requirement => "requirements",
            Kind::Input => "inputs",
        };
        let more = match self.in_some_sets {
            0 => String::new(),
            some => format!(" ({some} more in some sets)"),
        };
        format!("{} of {} {kind}{more}", self.in_every_set, self.figures)
    }
}

/// All kinds in one line.
pub fn in_words(tallies: &[Tally]) -> String {
    tallies.iter().map(Tally::in_words).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::row::{EXACT, paper, requirement};
    use super::*;

    #[test]
    fn a_figure_of_several_sets_counts_once() {
        let row = |id: &str, ours| Row::near(id, "s", paper(4.0), Some(ours), EXACT);
        let rows = [
            row("a", 4.0).in_set("joint"),
            row("b", 4.0).in_set("joint"),
            row("c", 5.0).in_set("joint"),
            row("a", 4.0).in_set("fitted"),
            row("b", 5.0).in_set("fitted"),
            Row::near("d", "s", requirement(1.0), None, EXACT),
            Row::input("e", "s", paper(4.0), Some(4.0)),
        ];
        let tallies = tally(&rows);
        let of_paper = tallies[0];
        assert_eq!((of_paper.kind, of_paper.figures), (Kind::Paper, 3));
        let counts = (of_paper.in_every_set, of_paper.in_some_sets, of_paper.in_no_set);
        assert_eq!(counts, (1, 1, 1));
        assert_eq!(
            in_words(&tallies),
            "1 of 3 figures of the paper (1 more in some sets), 0 of 1 requirements"
        );
    }
}
