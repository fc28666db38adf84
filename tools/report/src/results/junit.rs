//! A result as JUnit XML. Every row with a verdict is a test case, and the verdict over all is one.

use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};

use super::document::{Document, Part};
use super::head::{Format, Head};
use super::table::Table;

impl Document {
    pub fn junit(&self) -> String {
        let mut report = Report::new(format!("timegap {}", self.command));
        let mut whole = TestSuite::new(self.title.as_str());
        whole.add_test_case(case("verdict", &self.verdict, self.ok));
        report.add_test_suite(whole);
        for part in &self.parts {
            if let Part::Table(table) = part
                && table.has_cases
                && table.columns.iter().any(Head::is_verdict)
            {
                report.add_test_suite(rows(table));
            }
        }
        report.to_string().expect("memory takes all")
    }
}

/// A verdict. Its words are shown where it failed.
fn case(name: &str, words: &str, ok: bool) -> TestCase {
    if ok {
        return TestCase::new(name, TestCaseStatus::success());
    }
    let mut failed = TestCaseStatus::non_success(NonSuccessKind::Failure);
    failed.set_message(words.lines().next().unwrap_or_default()).set_description(words);
    TestCase::new(name, failed)
}

fn rows(table: &Table) -> TestSuite {
    let verdict = table.columns.iter().position(Head::is_verdict).unwrap_or_default();
    let mut suite = TestSuite::new(table.heading.as_str());
    for (row, cells) in table.rows.iter().enumerate() {
        // A row is named by the words and counts that stand before its first verdict or figure.
        let is_key = |place: &usize| {
            !matches!(table.columns[*place].format, Format::Decimals(_) | Format::Exact)
        };
        let keys = (0..verdict).take_while(is_key).filter(|&place| !cells[place].is_null());
        let name: Vec<_> = keys.map(|place| table.columns[place].text(&cells[place])).collect();
        let name = if name.is_empty() { format!("row {}", row + 1) } else { name.join(", ") };
        let shown =
            table.columns.iter().zip(cells).filter(|(head, cell)| {
                !cell.is_null() && !matches!(head.format, Format::Nested(_))
            });
        let words = shown.map(|(head, cell)| format!("{} = {}", head.title(), head.text(cell)));
        let words: Vec<_> = words.collect();
        suite.add_test_case(case(&name, &words.join("\n"), table.is_good(row)));
    }
    suite
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::{Column, flag, word};
    use super::*;

    #[test]
    fn every_row_with_a_verdict_is_a_case_with_its_words() {
        let columns: [Column<serde_json::Value>; 2] =
            [word("law", "law", ""), flag("ok", "verdict", ("ok", "MISSED"), "")];
        let rows =
            [json!({"law": "a & <b>", "ok": true}), json!({"law": "c\u{1}\"é", "ok": false})];
        let document = Document::new("x", "Laws \u{1}> 1", &json!({}))
            .verdict(false, "1 of 2 laws")
            .table(Table::new("Rows", &columns, &rows));
        let text = document.junit();
        let read = Report::deserialize_from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        assert_eq!((read.tests, read.failures, read.errors), (3, 2, 0), "{text}");
        let [whole, of_rows] = read.test_suites.as_slice() else { panic!("{text}") };
        assert_eq!((whole.name.as_str(), whole.failures), ("Laws > 1", 1));
        let cases = &of_rows.test_cases;
        let names: Vec<_> = cases.iter().map(|case| case.name.as_str()).collect();
        assert_eq!(names, ["a & <b>", "c\"é"]);
        let TestCaseStatus::NonSuccess { message, description, .. } = &cases[1].status else {
            panic!("{text}")
        };
        assert_eq!(message.as_deref(), Some("law = c\"é"));
        assert_eq!(description.as_deref(), Some("law = c\"é\nverdict = MISSED"));
    }
}
