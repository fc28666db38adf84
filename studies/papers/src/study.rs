//! The papers as a study: each piece of a paper is a run.

use frame::{Crew, Found, Needs, Recorded, RunOptions, Study};
use report::gate::{Baseline, Sample};
use report::results::{Document, Good};
use std::path::PathBuf;
use supervise::Error;

use super::row::{Row, Verdict};
use super::runner::{self, Part, Piece, Runner};
use super::{
    PAPERS, Paper, PaperName, Pictures, ReproduceArguments, Reproduction, page, tally::tally,
};

/// The study: the pieces of the papers, in their order.
pub struct Papers {
    papers: Vec<PaperName>,
    pieces: Vec<(PaperName, Piece)>,
    /// Standard deviation of the skilled driver's aimed speed, m/s.
    driver_spread_mps: f64,
    baseline: Option<Baseline>,
}

impl Study for Papers {
    type Arguments = ReproduceArguments;
    type Record = Vec<Row>;
    type Seen = Pictures;

    const NAME: &'static str = "reproduce";
    const NEEDS: Needs = Needs::All;

    fn plan(arguments: &ReproduceArguments, _: &RunOptions) -> Result<Self, Error> {
        let papers = arguments.paper.map_or(PAPERS.to_vec(), |paper| vec![paper]);
        let of_paper = |&paper: &PaperName| {
            paper.pieces(arguments.variants).into_iter().map(move |piece| (paper, piece))
        };
        let pieces = papers.iter().flat_map(of_paper).collect();
        let read = |file: &PathBuf| Baseline::read(file, "the reproduce.json of an earlier run");
        let baseline = arguments.against.as_ref().map(read).transpose()?;
        let driver_spread_mps = arguments.driver_spread / 3.6;
        Ok(Self { papers, pieces, driver_spread_mps, baseline })
    }

    fn runs(&self) -> usize {
        self.pieces.len()
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        let (paper, piece) = &self.pieces[run];
        runner::keys(paper.as_str(), &piece.name, 1, &[])
    }

    /// The words of the command name no file.
    fn subject(&self) -> Result<String, Error> {
        Ok(String::new())
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        let (paper, piece) = &self.pieces[run];
        let names = (paper.as_str(), piece.name.as_str());
        let runner = Runner::new(crew, run, names, self.driver_spread_mps);
        let Part { rows, pictures } = piece.reproduce(&runner)?;
        Ok((rows, pictures))
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let Found { records, mut seen, .. } = found;
        let mut papers: Vec<Paper> = self.papers.iter().map(|&name| empty(name)).collect();
        for (run, rows) in records.all()? {
            let name = self.pieces[run].0;
            let place = self.papers.iter().position(|paper| *paper == name);
            let paper = &mut papers[place.expect("every piece is of a paper of the study")];
            paper.rows.extend(rows);
            paper.pictures.extend(seen.remove(&run).unwrap_or_default());
        }
        let mut whole = reproduction(papers);
        let baseline = self.baseline.as_ref();
        whole.against = baseline.map(|file| file.judge(&whole.samples)).transpose()?;
        let document = page::document(&whole);
        Ok(match &whole.against {
            Some(against) => against.onto(document),
            None => document,
        })
    }
}

fn empty(name: PaperName) -> Paper {
    let (tally, rows, pictures) = (Vec::new(), Vec::new(), Pictures::default());
    Paper { paper: name.as_str(), tally, rows, pictures }
}

/// Judges the rows.
pub fn reproduction(mut papers: Vec<Paper>) -> Reproduction {
    for paper in &mut papers {
        by_set(&mut paper.rows);
        paper.tally = tally(&paper.rows);
    }
    let mut rows = papers.iter().flat_map(|paper| &paper.rows);
    let ok = rows.all(|row| row.verdict() != Verdict::Outside);
    let samples = papers.iter().flat_map(samples).collect();
    Reproduction { schema_version: 1, ok, papers, samples, against: None }
}

/// The accepted rows of a paper, and by how much of its tolerance each row differs. Every row repeats exactly.
fn samples(paper: &Paper) -> [Sample; 2] {
    let sample = |figure: &str, good, shown, is_exact, value: fn(&Row) -> Option<f64>| {
        let values = paper.rows.iter().map(value).collect();
        let (of, figure) = (paper.paper.to_owned(), figure.to_owned());
        Sample { of, figure, values, good, shown, is_exact }
    };
    let deviation = |row: &Row| {
        let tolerance = row.tolerance.filter(|tolerance| *tolerance > 0.0)?;
        Some((row.ours? - row.expected?).abs() / tolerance)
    };
    [
        sample("accepted", Good::More, 0.0, true, |row| Some(f64::from(u8::from(row.ok)))),
        sample("difference over tolerance", Good::Less, 0.01, false, deviation),
    ]
}

/// Puts the rows of each set together. The sets keep their order.
fn by_set(rows: &mut [Row]) {
    let mut sets: Vec<String> = Vec::new();
    for row in rows.iter() {
        if !sets.contains(&row.set) {
            sets.push(row.set.clone());
        }
    }
    rows.sort_by_key(|row| sets.iter().position(|set| *set == row.set));
}

#[cfg(test)]
mod tests {
    use super::super::row::{EXACT, paper};
    use super::*;

    #[test]
    fn rows_of_a_set_stand_together_in_the_order_in_which_they_came() {
        let row =
            |id: &str, set: &str| Row::near(id, "s", paper(1.0), Some(1.0), EXACT).in_set(set);
        let mut rows = vec![row("a", "x"), row("a", "y"), row("b", "x"), row("b", "y")];
        by_set(&mut rows);
        let places: Vec<_> = rows.iter().map(|row| format!("{}{}", row.set, row.id)).collect();
        assert_eq!(places, ["xa", "xb", "ya", "yb"]);
    }

    #[test]
    fn every_piece_has_a_name_of_its_own() {
        for paper in PAPERS {
            let mut names: Vec<_> = paper.pieces(1).into_iter().map(|piece| piece.name).collect();
            let count = names.len();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), count, "{paper:?}");
        }
    }
}
