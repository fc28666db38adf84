//! What the drives meet without faults, as a table of the terminal and of the page.

use super::exposure::Exposure;
use report::chart::number;
use report::html::{self, Column};
use report::table::{NONE, TextTable};

/// Headings of the figures, after scenario and controller.
const FIGURES: [&str; 8] = [
    "hardest braking, m/s²",
    "least TTC, s",
    "lights on red",
    "on yellow",
    "standstills",
    "stands, s",
    "cut-ins",
    "critical, %",
];

fn figures(met: &Exposure) -> [String; 8] {
    [
        number(met.hardest_braking_mps2, 1),
        met.min_ttc_s.map_or_else(|| NONE.into(), |ttc_s| number(ttc_s, 1)),
        met.reds_met.to_string(),
        met.yellows_met.to_string(),
        met.standstills.to_string(),
        number(met.standstill_s, 0),
        met.cut_ins.to_string(),
        number(100.0 * met.critical_share, 0),
    ]
}

/// For the terminal; empty without a drive.
pub fn text(exposure: &[Exposure]) -> String {
    if exposure.is_empty() {
        return String::new();
    }
    let mut table = TextTable::of_figures(std::iter::once("drives meet").chain(FIGURES));
    for met in exposure {
        let drive = format!("{} {}", met.scenario, met.controller);
        table.row(std::iter::once(drive).chain(figures(met)));
    }
    table.text()
}

/// The section of the page; empty without a drive.
pub fn section(exposure: &[Exposure]) -> String {
    if exposure.is_empty() {
        return String::new();
    }
    let words = [("scenario", Column::Text), ("controller", Column::Text)];
    let head: Vec<_> =
        (words.into_iter()).chain(FIGURES.map(|heading| (heading, Column::Number))).collect();
    let rows: Vec<Vec<String>> = (exposure.iter())
        .map(|met| {
            let words = [met.scenario.clone(), met.controller.clone()];
            words.into_iter().chain(figures(met)).collect()
        })
        .collect();
    html::section("What the drives meet without faults", &html::table(&head, &rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_is_a_row_of_both_tables_and_no_drive_is_none() {
        assert_eq!(text(&[]) + &section(&[]), "");
        let met = Exposure {
            scenario: "corridor".into(),
            controller: "cacc-mpc".into(),
            hardest_braking_mps2: 2.31,
            min_ttc_s: None,
            yellows_met: 1,
            reds_met: 2,
            standstills: 1,
            cut_ins: 0,
            standstill_s: 22.4,
            cut_in_s: 0.0,
            critical_share: 0.428,
        };
        let text = text(std::slice::from_ref(&met));
        let words: Vec<&str> = text.lines().nth(1).expect("a row").split_whitespace().collect();
        assert_eq!(words, ["corridor", "cacc-mpc", "2.3", "2", "1", "1", "22", "0", "43"]);
        let page = section(&[met]);
        assert!(page.contains("corridor") && page.contains(">2.3<"), "{page}");
    }
}
