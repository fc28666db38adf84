//! The variables' joint distribution.

use rare_events::{Copula, Distribution};
use std::num::NonZeroUsize;
use std::path::Path;
use supervise::UsageError;

use crate::problem::{Domain, Exposure, Problem, SearchError, Stated, Value, Variable};

/// Largest CSV file, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The variables' distributions with what else the file says of them.
#[derive(Clone, Debug)]
pub struct Model {
    copula: Copula,
    rows: usize,
    /// Points of Monte Carlo that the file asks for.
    pub(super) monte_carlo: Option<usize>,
    /// The distributions in words, in the order of the variables.
    pub(super) distributions: Vec<String>,
    /// Rate at which such scenes are met.
    pub(super) exposure: Option<Exposure>,
    /// Variables depend on each other.
    pub(super) is_correlated: bool,
}

impl Model {
    pub fn of(problem: &Problem) -> Result<Self, SearchError> {
        let Some((stated, folder)) = &problem.stated else {
            let why = "nothing says how the variables are distributed";
            let expected = "a search file with [probability.distributions]";
            return Err(UsageError::at("--probability", why, expected).into());
        };
        Self::new(stated, folder, &problem.variables)
    }

    fn new(stated: &Stated, folder: &Path, variables: &[Variable]) -> Result<Self, SearchError> {
        let place = |table: &str, name: &String| {
            let names = || variables.iter().map(|variable| variable.name.as_str());
            let unknown = || {
                let why = format_args!("no variable `{name}`");
                UsageError::at(table, why, scenario::accepted(name, names()))
            };
            names().position(|known| known == name).ok_or_else(unknown)
        };
        for name in stated.distributions.keys() {
            place("probability.distributions", name)?;
        }
        let distributions = variables.iter().map(|variable| {
            let name = &variable.name;
            let at = format!("probability.distributions.{name}");
            if variable.domain.is_of_words() {
                let why = "the variable's values are words";
                return Err(UsageError::at(at, why, "numbers; fix it by --set").into());
            }
            match stated.distributions.get(name) {
                Some(text) => read(&at, text, folder),
                None => {
                    let why = format_args!("`{name}` has no distribution");
                    Err(UsageError::at("probability.distributions", why, "one for each variable")
                        .into())
                }
            }
        });
        let distributions = distributions.collect::<Result<Vec<Distribution>, _>>()?;
        let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
        for correlation in &stated.correlations {
            let [a, b] = &correlation.variables;
            let (i, j) =
                (place("probability.correlations", a)?, place("probability.correlations", b)?);
            let is_there = pairs.iter().any(|&(k, l, _)| (k, l) == (i, j) || (k, l) == (j, i));
            if i == j || is_there {
                let why = format_args!("{a} and {b}");
                let expected = "each pair of two variables once";
                return Err(UsageError::at("probability.correlations", why, expected).into());
            }
            pairs.push((i, j, correlation.rank));
        }
        if let Some(Exposure { events, .. }) = stated.exposure
            && !(events > 0.0 && events.is_finite())
        {
            let place = format_args!("probability.exposure.events = {events}");
            return Err(UsageError::at(place, "no rate", "a number above 0").into());
        }
        let words = distributions.iter().map(ToString::to_string).collect();
        let wrong = |reason| SearchError::part("probability.correlations", reason);
        Ok(Self {
            distributions: words,
            copula: Copula::new(distributions, &pairs).map_err(wrong)?,
            rows: stated.indices.into(),
            monte_carlo: stated.monte_carlo.map(NonZeroUsize::get),
            exposure: stated.exposure.clone(),
            is_correlated: !pairs.is_empty(),
        })
    }

    /// Rows for Sobol's indices.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// The values at a point, and whether one of them was beyond its variable's range and counts as its end.
    pub(super) fn values(&self, problem: &Problem, point: &[f64]) -> (Vec<Value>, bool) {
        let drawn = self.copula.values(point);
        let pairs = problem.variables.iter().zip(&drawn);
        let values: Vec<Value> =
            pairs.map(|(of, number)| of.domain.nearest(&Value::Number(*number))).collect();
        let is_clipped = problem.variables.iter().zip(&drawn).any(|(of, number)| match of.domain {
            Domain::Range { from, to, .. } => !(from..=to).contains(number),
            Domain::Numbers(_) | Domain::Words(_) => false,
        });
        (values, is_clipped)
    }
}

fn read(place: &str, text: &str, folder: &Path) -> Result<Distribution, SearchError> {
    let wrong = |reason| SearchError::part(place, reason);
    let measured = text.trim().strip_prefix("csv(").and_then(|rest| rest.strip_suffix(')'));
    let Some((file, column)) = measured.and_then(|rest| rest.rsplit_once(',')) else {
        return text.parse().map_err(wrong);
    };
    let path = folder.join(file.trim());
    let values = column_of(&path, column.trim());
    let place = format!("{place}: {}", path.display());
    Distribution::empirical(values.map_err(|reason| SearchError::part(&place, reason))?)
        .map_err(wrong)
}

/// The numbers of a column; empty fields are left out.
fn column_of(path: &Path, column: &str) -> Result<Vec<f64>, String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let bytes = std::fs::metadata(path).map_err(|error| said(&error))?.len();
    if bytes > MAX_BYTES {
        return Err(format!("{bytes} bytes, expected at most {MAX_BYTES}"));
    }
    let mut reader = csv::Reader::from_path(path).map_err(|error| said(&error))?;
    let head = reader.headers().map_err(|error| said(&error))?.clone();
    let place = head.iter().position(|name| name.trim() == column).ok_or_else(|| {
        let names: Vec<&str> = head.iter().collect();
        format!("no column `{column}`, expected one of {}", names.join(", "))
    })?;
    let mut values = Vec::new();
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|error| said(&error))?;
        let field = record.get(place).unwrap_or_default().trim();
        if field.is_empty() {
            continue;
        }
        let number = field.parse().ok().filter(|number: &f64| number.is_finite());
        values.push(number.ok_or_else(|| format!("row {}: `{field}` is not a number", row + 2))?);
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variables() -> Vec<Variable> {
        let of = |name: &str, text: &str| {
            let domain = Domain::parse(text).expect(text);
            let nominal = domain.middle();
            Variable { name: name.to_owned(), domain, nominal }
        };
        vec![of("v0", "10..40"), of("thw", "0.5..3")]
    }

    fn model(text: &str) -> Result<Model, String> {
        let stated: Stated = toml::from_str(text).map_err(|error| error.to_string())?;
        let folder = std::env::temp_dir();
        Model::new(&stated, &folder, &variables()).map_err(|error| error.to_string())
    }

    const BOTH: &str = "[distributions]\nv0 = \"normal(24, 4)\"\nthw = \"lognormal(1.3, 0.3)\"\n";

    #[test]
    fn mistakes_name_their_place_and_what_was_expected() {
        assert!(model(BOTH).is_ok());
        for (rest, what) in [
            ("x = \"uniform(0, 1)\"", "probability.distributions: "),
            (
                "[[correlations]]\nvariables = [\"v0\", \"v0\"]\nrank = 0.1",
                "v0 and v0, expected each pair",
            ),
            (
                "[[correlations]]\nvariables = [\"v0\", \"thw\"]\nrank = 2",
                "a rank correlation of 2",
            ),
            (
                "[exposure]\nper = \"hour\"\nevents = 0\nsource = \"x\"",
                "events = 0: no rate, expected",
            ),
            ("[exposure]\nper = \"hour\"\nevents = 1", "missing field `source`"),
            ("[[correlations]]\nvariables = [\"v0\", \"thw\"]\nrank = \"much\"", "expected f"),
        ] {
            let said = model(&format!("{BOTH}{rest}")).expect_err(rest);
            assert!(said.contains(what), "{rest}: {said}");
        }
        let said = model("[distributions]\nv0 = \"normal(24, 4)\"").expect_err("one is missing");
        assert!(said.contains("`thw` has no distribution"), "{said}");
        let said = model("[distributions]\nv0 = \"normal(24)\"\nthw = \"uniform(1, 2)\"");
        assert!(said.expect_err("no form").contains("probability.distributions.v0: `normal(24)`"));
    }

    #[test]
    fn a_column_of_a_file_is_a_distribution() {
        let name = format!("timegap-probability-{}.csv", std::process::id());
        let path = std::env::temp_dir().join(&name);
        let rows: String = (1..=20).map(|k| format!("a,{}\n", f64::from(k) / 10.0)).collect();
        std::fs::write(&path, format!("id,thw_s\n{rows}b,\n")).expect("writable");
        let of = |column: &str| {
            model(&format!(
                "[distributions]\nv0 = \"normal(24, 4)\"\nthw = \"csv({name}, {column})\""
            ))
        };
        let measured = of("thw_s").expect("a column");
        let missing = of("thw").expect_err("no such column");
        std::fs::remove_file(&path).expect("it was written");
        assert_eq!(measured.distributions[1], "20 measured values from 0.1 to 2");
        assert!(missing.contains("no column `thw`, expected one of id, thw_s"), "{missing}");
        assert!(of("thw_s").is_err(), "the file is gone");
    }
}
