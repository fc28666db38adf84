//! A whole result, for every output.

use serde::Serialize;
use serde_json::Value;

use super::console;
use super::table::{Fact, Table};
use crate::html::Tile;

/// Most findings that a terminal shows.
const MOST_BROKEN: usize = 12;

/// A part of a result for people.
#[derive(Clone, Debug)]
pub enum Part {
    Table(Table),
    /// HTML of the page alone, below a heading.
    Figures(String, String),
    Text(String),
    /// Figures that are read at a glance, on the page alone.
    Tiles(Vec<Tile>),
    /// Facts below a heading, which a terminal leaves out.
    Facts(String, Vec<Fact>),
}

/// A finding against the verdict, and the command that repeats it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Broken {
    /// The finding, in a few words.
    pub what: String,
    /// The command; empty where none repeats it.
    pub command: String,
}

impl Broken {
    /// A finding that `command` repeats.
    pub fn new(what: impl Into<String>, command: impl Into<String>) -> Self {
        Self { what: what.into(), command: command.into() }
    }

    pub(super) fn line(&self) -> String {
        match self.command.as_str() {
            "" => self.what.clone(),
            command => format!("{}: {command}", self.what),
        }
    }
}

/// A result: verdict, tables, charts, and its JSON.
///
/// ```
/// use report::results::{Document, Table, number, word};
/// use serde_json::json;
///
/// let whole = json!({"schema_version": 1, "rows": [{"law": "acc-mpc", "gap_m": 8.25}]});
/// let columns = [word("law", "law", "Control law"), number("gap_m", "gap", "m", 1, "Smallest gap")];
/// let rows = whole["rows"].as_array().unwrap();
/// let document = Document::new("gaps", "Gaps", &whole)
///     .verdict(true, "every law kept 5 m")
///     .table(Table::new("Laws", &columns, rows));
/// assert_eq!(document.console(80), "  law      gap, m\n  acc-mpc     8.2\nevery law kept 5 m\n");
/// assert!(document.junit().contains("<testcase name=\"verdict\""));
/// assert!(document.markdown().contains("| acc-mpc | 8.2 |"));
/// ```
#[derive(Clone, Debug)]
pub struct Document {
    pub(super) command: &'static str,
    /// Name of the file with the JSON, where it is not the command's.
    json_file: Option<&'static str>,
    pub(super) title: String,
    pub(super) about: String,
    pub(super) ok: bool,
    /// True if the command succeeds, where that is not the verdict.
    pub(super) succeeds: Option<bool>,
    pub(super) verdict: String,
    pub(super) broken: Vec<Broken>,
    pub(super) json: String,
    pub(super) parts: Vec<Part>,
    /// Names and contents of the files beside it.
    pub(super) files: Vec<(String, Vec<u8>)>,
}

impl Document {
    /// The result of `command`, whose JSON is `whole`: `COMMAND.json` in its directory.
    pub fn new(command: &'static str, title: &str, whole: &impl Serialize) -> Self {
        let json = serde_json::to_string_pretty(whole).expect("plain data") + "\n";
        Self {
            command,
            json_file: None,
            title: title.to_owned(),
            about: String::new(),
            ok: true,
            succeeds: None,
            verdict: String::new(),
            broken: Vec::new(),
            json,
            parts: Vec::new(),
            files: Vec::new(),
        }
    }

    /// The same with a verdict: whether all is well, and the sentence that answers the command's question.
    pub fn verdict(mut self, ok: bool, sentence: impl Into<String>) -> Self {
        (self.ok, self.verdict) = (ok, sentence.into());
        self
    }

    /// The same with another verdict in place of its own, whose sentence stays. What it had found is no case any more.
    pub fn judged_anew(mut self, ok: bool, words: &str) -> Self {
        (self.ok, self.succeeds) = (ok, Some(ok));
        self.verdict = format!("{}; {words}", self.verdict);
        for part in &mut self.parts {
            if let Part::Table(table) = part {
                table.has_cases = false;
            }
        }
        self
    }

    /// The same with what broke, the worst first: the last lines of the console, and the first ones of the page.
    ///
    /// ```
    /// use report::results::{Broken, Document};
    ///
    /// let broken = [Broken::new("cut-in with acc-mpc, seed 3: COLLISION", "timegap run cut-in --seed 3")];
    /// let document = Document::new("gaps", "Gaps", &()).verdict(false, "1 of 9 runs").broken(broken);
    /// assert_eq!(
    ///     document.console(80),
    ///     "1 of 9 runs\n  cut-in with acc-mpc, seed 3: COLLISION: timegap run cut-in --seed 3\n"
    /// );
    /// ```
    pub fn broken(mut self, broken: impl IntoIterator<Item = Broken>) -> Self {
        self.broken.extend(broken);
        self
    }

    /// The same for a question whose answer may be no: `succeeds` alone decides the exit status.
    pub fn succeeds(mut self, succeeds: bool) -> Self {
        self.succeeds = Some(succeeds);
        self
    }

    pub fn json_file(mut self, name: &'static str) -> Self {
        self.json_file = Some(name);
        self
    }

    /// The same with a line about what was driven.
    pub fn about(mut self, about: impl Into<String>) -> Self {
        self.about = about.into();
        self
    }

    /// The same with a table more. One without rows is not shown.
    pub fn table(mut self, table: Table) -> Self {
        self.parts.push(Part::Table(table));
        self
    }

    /// The same with pictures on the page; an empty string adds nothing.
    pub fn figures(mut self, heading: &str, html: String) -> Self {
        if !html.is_empty() {
            self.parts.push(Part::Figures(heading.to_owned(), html));
        }
        self
    }

    /// The same with a paragraph; an empty one adds nothing.
    pub fn text(mut self, text: impl Into<String>) -> Self {
        let text = text.into();
        if !text.is_empty() {
            self.parts.push(Part::Text(text));
        }
        self
    }

    /// The same with named values, a line each; none add nothing.
    pub fn facts<N: Into<String>>(
        mut self,
        heading: &str,
        facts: impl IntoIterator<Item = (N, String)>,
    ) -> Self {
        let facts: Vec<Fact> =
            facts.into_iter().map(|(name, value)| (name.into(), value)).collect();
        if !facts.is_empty() {
            self.parts.push(Part::Facts(heading.to_owned(), facts));
        }
        self
    }

    /// The same with figures that the page shows at a glance.
    pub fn tiles(mut self, tiles: Vec<Tile>) -> Self {
        self.parts.push(Part::Tiles(tiles));
        self
    }

    /// The same with a file more in its directory.
    pub fn file(mut self, name: &str, contents: impl Into<Vec<u8>>) -> Self {
        self.files.push((name.to_owned(), contents.into()));
        self
    }

    pub fn is_ok(&self) -> bool {
        self.ok
    }

    pub fn json(&self) -> &str {
        &self.json
    }

    pub fn value(&self) -> Value {
        serde_json::from_str(&self.json).expect("it was written as JSON")
    }

    /// The text for a terminal of this width. It ends with the verdict and what broke.
    pub fn console(&self, width: usize) -> String {
        let mut text = String::new();
        if !self.about.is_empty() {
            text += &console::folded(&self.about, 0, width);
        }
        let tables = self.parts.iter().filter(|part| matches!(part, Part::Table(_))).count();
        for part in &self.parts {
            match part {
                Part::Table(table) if !table.is_on_terminals() => {}
                Part::Table(table) => {
                    if tables > 1 && table.block.is_none() {
                        text += &console::folded(&table.heading, 0, width);
                    }
                    text += &table.console(width);
                    if table.is_cut() {
                        text += &format!("  (all rows: {})\n", self.json_name());
                    }
                }
                Part::Text(words) => {
                    words.lines().for_each(|line| text += &console::folded(line, 0, width));
                }
                Part::Facts(_, facts) => text += &console::facts(facts, width),
                Part::Figures(..) | Part::Tiles(_) => {}
            }
        }
        if !self.verdict.is_empty() {
            text += &console::folded(&self.verdict, 0, width);
        }
        for broken in self.broken.iter().take(MOST_BROKEN) {
            text += &format!("  {}\n", broken.line());
        }
        if self.broken.len() > MOST_BROKEN {
            let more = self.broken.len() - MOST_BROKEN;
            text += &format!("  and {more} more: {}, {}\n", self.json_name(), crate::FILE);
        }
        // Names in a file of another program must not command the terminal.
        let is_bad = |c: char| c.is_control() && c != '\n';
        text.replace(is_bad, "\u{fffd}")
    }

    pub(super) fn json_name(&self) -> String {
        self.json_file.map_or_else(|| format!("{}.json", self.command), str::to_owned)
    }
}
