//! A result as JUnit XML: every row with a verdict is a test case, and the verdict over all is one.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::document::{Document, Part};
use super::table::Table;

impl Document {
    /// JUnit XML.
    #[must_use]
    pub fn junit(&self) -> String {
        text(self)
    }
}

/// The document.
fn text(document: &Document) -> String {
    let mut report = Report::new(format!("timegap {}", document.command));
    let mut suite = TestSuite::new(document.title.clone());
    suite.add_test_case(case("verdict", &document.verdict, document.ok));
    report.add_test_suite(suite);
    for part in &document.parts {
        if let Part::Table(table) = part
            && table.has_cases
            && table.columns.iter().any(super::Head::is_verdict)
        {
            report.add_test_suite(rows(table));
        }
    }
    report.to_string().expect("memory takes all")
}

fn rows(table: &Table) -> TestSuite {
    let mut suite = TestSuite::new(table.heading.clone());
    for (row, cells) in table.rows.iter().enumerate() {
        let verdict = table.columns.iter().position(super::Head::is_verdict).unwrap_or_default();
        let pairs = || table.columns.iter().zip(cells).filter(|(_, cell)| !cell.is_null());
        // A row is named by the words and counts that stand before its first verdict or figure.
        let is_key = |place: &usize| {
            use super::Format::{Decimals, Exact};
            !matches!(table.columns[*place].format, Decimals(_) | Exact)
        };
        let keys = (0..verdict).take_while(is_key).filter(|&place| !cells[place].is_null());
        let name: Vec<_> = keys.map(|place| table.columns[place].text(&cells[place])).collect();
        let name = if name.is_empty() { format!("row {}", row + 1) } else { name.join(", ") };
        let figures: Vec<_> = pairs()
            .filter(|(head, _)| !matches!(head.format, super::Format::Nested(_)))
            .map(|(head, cell)| format!("{} = {}", head.title(), head.text(cell)))
            .collect();
        suite.add_test_case(case(&name, &figures.join("\n"), table.is_good(row)));
    }
    suite
}

fn case(name: &str, said: &str, ok: bool) -> TestCase {
    let status = if ok {
        TestCaseStatus::success()
    } else {
        let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
        status.set_message(said.lines().next().unwrap_or_default().to_owned());
        status.set_description(said.to_owned());
        status
    };
    TestCase::new(name.to_owned(), status)
}
