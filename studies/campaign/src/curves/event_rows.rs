//! Rows of `events.csv`.

use report::results::{Column, count, number, word};
use serde::Serialize;
use serde_json::json;

use super::event::Event;
use super::judge::Kept;
use super::scene::Scene;

/// An event with its drive.
#[derive(Debug, Serialize)]
pub struct Row<'a> {
    number: usize,
    scene: Scene,
    sources: &'a str,
    event: Event,
}

impl<'a> Row<'a> {
    /// The events of all drives.
    pub fn all(runs: &'a [Kept]) -> Vec<Self> {
        let of_run = |run: &'a Kept| {
            let Kept { number, scene, ref sources, .. } = *run;
            run.events.iter().map(move |&event| Self { number, scene, sources, event })
        };
        runs.iter().flat_map(of_run).collect()
    }
}

/// Columns of `events.csv`.
pub fn columns<'a>() -> Vec<Column<Row<'a>>> {
    vec![
        count("number", "", "Number of the scene"),
        word("scene", "", "Kind of the scene"),
        word("sources", "", "Sources of the course"),
        word("event.kind", "", "A lost lead or a taken neighbour"),
        number("at_s", "", "s", 2, "When it began").of(|row| json!(row.event.at_s)),
        number("lasts_s", "", "s", 2, "How long it lasted").of(|row| json!(row.event.lasts_s)),
        word("event.place", "", "Part of a curve"),
        number("gap_m", "", "m", 1, "Gap to the lead").of(|row| json!(row.event.gap_m)),
        word("has_target", "", "Another vehicle was the target")
            .of(|row| json!(row.event.has_target)),
    ]
}
