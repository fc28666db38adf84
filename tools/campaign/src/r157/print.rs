//! The results for people.

use std::fmt::Write;

use super::results::{Figures, LawResult, Results};

/// The results as text: one block for each matrix and part.
pub fn text(results: &Results) -> String {
    let mut text = String::new();
    for matrix in &results.matrices {
        if matrix.parts.is_empty() {
            block(&mut text, matrix.matrix, &matrix.all);
        }
        // Low before high.
        for (part, figures) in matrix.parts.iter().rev() {
            block(&mut text, &format!("{}, {part}", matrix.matrix), figures);
        }
    }
    text
}

fn block(text: &mut String, name: &str, figures: &Figures) {
    let Figures { cases, mastered_by_both, .. } = figures;
    writeln!(text, "{name}: {cases} cases, {mastered_by_both} mastered by both models")
        .expect("a string takes all");
    writeln!(
        text,
        "  {:<24} {:>10} {:>9} {:>18} {:>14} {:>12} {:>12}",
        "",
        "collisions",
        "rear-end",
        "avoidable by both",
        "within a step",
        "impact, m/s",
        "model's, m/s"
    )
    .expect("a string takes all");
    for (model, collisions) in &figures.models {
        let rear_ends = figures.models_rear_end[model];
        writeln!(text, "  {model:<24} {:>10} {:>9}", number(*collisions), number(rear_ends))
            .expect("a string takes all");
    }
    for law in &figures.laws {
        let mark = if figures.holds(law) { "" } else { "  MISSED" };
        writeln!(
            text,
            "  {:<24} {:>10} {:>9} {:>18} {:>14} {:>12} {:>12}{mark}",
            driver(law),
            law.collisions,
            law.rear_end,
            share(law.avoidable.both, figures.mastered_by_both),
            number(law.avoidable.both_within_a_step),
            speed(law.mean_impact_mps),
            speed(law.model_impact_mps),
        )
        .expect("a string takes all");
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
