//! A result as JUnit XML. Every row with a verdict is a test case, and the verdict over all is one.

use std::io::Error;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::document::{Document, Part};
use super::table::Table;

impl Document {
    /// JUnit XML.
    #[must_use]
    pub fn junit(&self) -> String {
        text(self)
    }
}

/// Cases below one heading.
struct Suite {
    name: String,
    cases: Vec<Case>,
}

/// A verdict. Its words are shown where it failed.
struct Case {
    name: String,
    words: String,
    ok: bool,
}

/// The document.
fn text(document: &Document) -> String {
    let Document { title, verdict, ok, .. } = document;
    let whole = Case { name: "verdict".to_owned(), words: verdict.clone(), ok: *ok };
    let mut suites = vec![Suite { name: title.clone(), cases: vec![whole] }];
    for part in &document.parts {
        if let Part::Table(table) = part
            && table.has_cases
            && table.columns.iter().any(super::Head::is_verdict)
        {
            suites.push(rows(table));
        }
    }
    let written = write(&format!("timegap {}", document.command), &suites);
    String::from_utf8(written.expect("memory takes all")).expect("made of strings")
}

fn rows(table: &Table) -> Suite {
    let mut cases = Vec::new();
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
        cases.push(Case { name, words: figures.join("\n"), ok: table.is_good(row) });
    }
    Suite { name: table.heading.clone(), cases }
}

/// Writes the suites. XML itself has no place for control characters; they are left out.
fn write(name: &str, suites: &[Suite]) -> Result<Vec<u8>, Error> {
    let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
    writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let all = counts(suites.iter().flat_map(|suite| &suite.cases));
    element(&mut writer, "testsuites", name, &all, |writer| {
        suites.iter().try_for_each(|suite| {
            element(writer, "testsuite", &suite.name, &counts(&suite.cases), |writer| {
                suite.cases.iter().try_for_each(|case| write_case(writer, case))
            })
        })
    })?;
    let mut text = writer.into_inner();
    text.push(b'\n');
    Ok(text)
}

fn write_case(writer: &mut Writer<Vec<u8>>, case: &Case) -> Result<(), Error> {
    let name = of_xml(&case.name);
    let element = writer.create_element("testcase").with_attribute(("name", &*name));
    if case.ok {
        return element.write_empty().map(|_| ());
    }
    let words = of_xml(&case.words);
    let message = words.lines().next().unwrap_or_default();
    let failed = element.write_inner_content(|writer| {
        let failure = writer.create_element("failure").with_attribute(("message", message));
        failure.write_text_content(BytesText::new(&words)).map(|_| ())
    });
    failed.map(|_| ())
}

/// Writes an element with its name, its counts and what `inside` writes.
fn element(
    writer: &mut Writer<Vec<u8>>,
    kind: &str,
    name: &str,
    counts: &[(&str, String)],
    inside: impl FnOnce(&mut Writer<Vec<u8>>) -> Result<(), Error>,
) -> Result<(), Error> {
    let name = of_xml(name);
    let counts = counts.iter().map(|(key, count)| (*key, count.as_str()));
    let element = writer.create_element(kind).with_attribute(("name", &*name));
    element.with_attributes(counts).write_inner_content(inside).map(|_| ())
}

/// Counts that readers expect beside a name.
fn counts<'a>(cases: impl IntoIterator<Item = &'a Case>) -> [(&'static str, String); 3] {
    let (all, failed) = cases
        .into_iter()
        .fold((0, 0), |(all, failed), case| (all + 1, failed + usize::from(!case.ok)));
    [("tests", all.to_string()), ("failures", failed.to_string()), ("errors", "0".to_owned())]
}

/// The characters that XML 1.0 allows.
fn of_xml(text: &str) -> String {
    let is_allowed = |c: &char| match c {
        '\t' | '\n' | '\r' => true,
        '\u{fffe}' | '\u{ffff}' => false,
        c => *c >= ' ',
    };
    text.chars().filter(is_allowed).collect()
}

#[cfg(test)]
mod tests {
    use quick_junit::{Report, TestCaseStatus};
    use serde_json::json;

    use super::super::{Column, flag, word};
    use super::*;

    /// Another program's reader understands the document.
    #[test]
    fn a_reader_of_junit_finds_every_case_with_its_words() {
        let columns: [Column<serde_json::Value>; 2] =
            [word("law", "law", ""), flag("ok", "verdict", ("ok", "MISSED"), "")];
        let rows =
            [json!({"law": "a & <b>", "ok": true}), json!({"law": "c\u{1b}\"é", "ok": false})];
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
        assert!(matches!(cases[0].status, TestCaseStatus::Success { .. }));
        let TestCaseStatus::NonSuccess { message, description, .. } = &cases[1].status else {
            panic!("{text}")
        };
        assert_eq!(message.as_deref(), Some("law = c\"é"));
        assert_eq!(description.as_deref(), Some("law = c\"é\nverdict = MISSED"));
    }
}
