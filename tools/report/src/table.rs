//! Text tables and CSV: the one place where rows become text.

use comfy_table::{CellAlignment, Table, presets};
use std::fmt::Write;

/// Text where a figure does not apply.
pub const NONE: &str = "-";

/// Side on which a column's cells are flush.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    Left,
    Right,
}

/// Rows under headings, for a terminal. Columns are as wide as their widest cell; one in which no
/// row has a figure is left out.
#[derive(Clone, Debug)]
pub struct TextTable {
    head: Vec<(String, Align)>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table without rows.
    pub fn new<'a>(head: impl IntoIterator<Item = (&'a str, Align)>) -> Self {
        let head = head.into_iter().map(|(name, align)| (name.to_owned(), align)).collect();
        Self { head, rows: Vec::new() }
    }

    /// Adds a row; missing cells are empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let mut row: Vec<String> = cells.into_iter().collect();
        row.resize(self.head.len(), String::new());
        self.rows.push(row);
    }

    /// The table as lines, indented by two spaces and ended by a line break.
    pub fn text(&self) -> String {
        let empty = |cell: &str| cell.is_empty() || cell == NONE;
        let shown: Vec<usize> = (0..self.head.len())
            .filter(|&column| {
                self.rows.is_empty() || self.rows.iter().any(|row| !empty(&row[column]))
            })
            .collect();
        let mut table = Table::new();
        table.load_preset(presets::NOTHING);
        table.set_header(shown.iter().map(|&column| &self.head[column].0));
        for row in &self.rows {
            table.add_row(shown.iter().map(|&column| &row[column]));
        }
        for (place, &column) in shown.iter().enumerate() {
            let column_of_text = table.column_mut(place).expect("the header has it");
            column_of_text.set_padding((2, 0));
            column_of_text.set_cell_alignment(match self.head[column].1 {
                Align::Left => CellAlignment::Left,
                Align::Right => CellAlignment::Right,
            });
        }
        table.trim_fmt() + "\n"
    }
}

/// One row of CSV (RFC 4180, ended by a line feed). A field is quoted where it must be, and empty where nothing
/// applies.
pub fn csv_row<R>(row: R) -> Vec<u8>
where
    R: IntoIterator<Item: AsRef<[u8]>>,
{
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(row).expect("memory takes all");
    writer.into_inner().expect("memory takes all")
}

/// Rows of two or more figures under `head`, each with all of its digits, or nothing. Figures need no quotes, so each is
/// written in place.
pub fn csv_of_figures<H, R>(head: H, rows: impl IntoIterator<Item = R>) -> String
where
    H: IntoIterator<Item: AsRef<[u8]>>,
    R: IntoIterator<Item = Option<f64>>,
{
    let mut text = String::from_utf8(csv_row(head)).expect("made of strings");
    let mut digits = zmij::Buffer::new();
    for row in rows {
        for (place, figure) in row.into_iter().enumerate() {
            if place > 0 {
                text.push(',');
            }
            let Some(figure) = figure else { continue };
            if figure == 0.0 || (1e-4..1e15).contains(&figure.abs()) {
                let shown = digits.format_finite(figure);
                text.push_str(shown.strip_suffix(".0").unwrap_or(shown));
            } else {
                // Others may have an exponent there.
                write!(text, "{figure}").expect("a string takes all");
            }
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_without_a_figure_are_left_out_and_the_others_line_up() {
        let mut table = TextTable::new([
            ("", Align::Left),
            ("gap, m", Align::Right),
            ("fuel", Align::Right),
            ("jerk", Align::Right),
        ]);
        table.row(["acc-mpc", "10.5", NONE, "1.0"].map(String::from));
        table.row(["six-mode", "9.0", NONE, "250.0"].map(String::from));
        assert_eq!(
            table.text(),
            "            gap, m   jerk\n  acc-mpc     10.5    1.0\n  six-mode     9.0  250.0\n"
        );
    }

    #[test]
    fn a_row_may_be_short_and_a_table_empty() {
        let mut table = TextTable::new([("name", Align::Left), ("note", Align::Left)]);
        assert_eq!(table.text(), "  name  note\n");
        table.row(["a".to_owned()]);
        assert_eq!(table.text(), "  name\n  a\n");
    }

    #[test]
    fn rows_of_figures_have_all_digits_and_fields_are_quoted_where_they_must_be() {
        let rows = [[Some(0.1), None, Some(-1e-7)], [Some(f64::NAN), Some(3.0), Some(1e21)]];
        assert_eq!(
            csv_of_figures(["a", "b, c", "d\""], rows),
            "a,\"b, c\",\"d\"\"\"\n0.1,,-0.0000001\nNaN,3,1000000000000000000000\n"
        );
        let figures = [-0.0, 1.5, f64::MAX, f64::MIN_POSITIVE, 1e-4, 999_999_999_999_999.9, 0.3];
        let shown = figures.map(|figure| figure.to_string()).join(",");
        assert_eq!(csv_of_figures(["a"], [figures.map(Some)]), format!("a\n{shown}\n"));
    }
}
