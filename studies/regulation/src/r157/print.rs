//! The results for people.

use std::fmt::Write;

use super::results::{Figures, LawResult, Results};

/// The results as text: one block for each matrix and part.
pub fn text(results: &Results) -> String {
    let mut text = String::new();
    for matrix in &results.matrices {
        // Low before high, then both together.
        for (part, figures) in matrix.parts.iter().rev() {
            block(&mut text, &format!("{}, {part}", matrix.matrix), figures);
        }
        block(&mut text, matrix.matrix, &matrix.all);
    }
    text
}

fn block(text: &mut String, name: &str, figures: &Figures) {
    let Figures { cases, mastered_by_both, .. } = figures;
    let mut line = |words: std::fmt::Arguments<'_>| {
        text.write_fmt(words).expect("a string takes all");
        text.push('\n');
    };
    line(format_args!("{name}: {cases} cases, {mastered_by_both} mastered by both models"));
    let (mut from, mut avoidable) = ("", "");
    if figures.laws.iter().any(|law| law.from_its_gap.is_some()) {
        (from, avoidable) = (" careful-driver from its gap", " avoidable from it");
    }
    line(format_args!(
        "  {:<24} {:>10} {:>9} {:>18} {:>14} {:>12} {:>12}{from}{avoidable}",
        "",
        "collisions",
        "rear-end",
        "avoidable by both",
        "within a step",
        "impact, m/s",
        "model's, m/s"
    ));
    for (model, collisions) in &figures.models {
        let rear_ends = figures.models_rear_end[model];
        let (collisions, rear_ends) = (number(*collisions), number(rear_ends));
        line(format_args!("  {model:<24} {collisions:>10} {rear_ends:>9}"));
    }
    for law in &figures.laws {
        let by_gap = law.from_its_gap.as_ref().map_or_else(String::new, |model| {
            let share = share(model.avoidable, model.mastered);
            let (wide, narrow) = (from.len(), avoidable.len());
            format!("{:>wide$}{share:>narrow$}", model.collisions)
        });
        let mark = if figures.holds(law) { "" } else { "  MISSED" };
        line(format_args!(
            "  {:<24} {:>10} {:>9} {:>18} {:>14} {:>12} {:>12}{by_gap}{mark}",
            driver(law),
            law.collisions,
            law.rear_end,
            share(law.avoidable.both, figures.mastered_by_both),
            number(law.avoidable.both_within_a_step),
            speed(law.mean_impact_mps),
            speed(law.model_impact_mps),
        ));
    }
}

/// A law with or without the emergency brake.
pub fn driver(law: &LawResult) -> String {
    let with = if law.aebs { " + AEBS" } else { "" };
    format!("{}{with}", law.law)
}

/// A number of cases and its share of `all`.
pub fn share(count: u32, all: u32) -> String {
    if all == 0 {
        return count.to_string();
    }
    format!("{count} ({:.2} %)", 100.0 * f64::from(count) / f64::from(all))
}

/// A number, or a dash where it does not apply.
pub fn number(count: Option<u32>) -> String {
    count.map_or_else(|| "-".into(), |count| count.to_string())
}

/// A speed, or a dash where there is none.
pub fn speed(mps: Option<f64>) -> String {
    mps.map_or_else(|| "-".into(), |mps| format!("{mps:.1}"))
}
