//! The models' outcomes as a table.

use std::io::{self, Write};

use crate::cut_in::Case;
use crate::{Model, Outcome};

/// Writes the outcome of each cut-in with each model as comma-separated values. A row is the case,
/// then one digit per model (0 none, 1 side, 2 rear-end).
pub fn write_cut_ins(
    out: &mut impl Write,
    cases: impl IntoIterator<Item = Case>,
) -> io::Result<()> {
    write!(out, "ego_kmh,other_kmh,distance_m,lateral_mps")?;
    for model in Model::ALL {
        write!(out, ",{}", model.name().replace('-', "_"))?;
    }
    writeln!(out)?;
    for case in cases {
        write!(
            out,
            "{},{},{},{}.{}",
            case.ego_kmh,
            case.other_kmh,
            case.distance_m,
            case.lateral_tenths_mps / 10,
            case.lateral_tenths_mps % 10,
        )?;
        for (_, outcome) in case.outcomes().iter() {
            write!(out, ",{}", Outcome::digit(*outcome))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut_in;

    #[test]
    fn a_row_holds_the_case_and_a_digit_for_each_model() {
        let case = Case { ego_kmh: 60, other_kmh: 20, distance_m: 15, lateral_tenths_mps: 10 };
        let mut text = Vec::new();
        write_cut_ins(&mut text, [case]).expect("memory takes every byte");
        assert_eq!(
            String::from_utf8(text).expect("the table is ASCII"),
            "ego_kmh,other_kmh,distance_m,lateral_mps,careful_driver,regulation,rss,fuzzy\n\
             60,20,15,1.0,2,2,2,2\n"
        );
    }

    #[test]
    fn the_matrices_have_the_sizes_of_the_regulation() {
        assert_eq!(cut_in::low().count(), 15_930);
        assert_eq!(cut_in::high().count(), 14_040);
    }
}
