//! Keys of a scenario with the values that they take, and their grid.
//!
//! ```
//! use frame::param::{Param, grid};
//!
//! let delay = Param::parse("runtime.extra_delay_ms=0..20/10").unwrap();
//! let law = Param::parse("controller.name=acc-mpc,six-mode").unwrap();
//! assert_eq!(delay.settings[1].to_string(), "runtime.extra_delay_ms=10");
//! assert_eq!(grid(&[delay, law]).len(), 6);
//! ```

use scenario::quantity::Seed;
use scenario::{Setting, Value};
use std::fmt::Display;
use supervise::{Error, ScenarioOptions, UsageError};

/// Most values of one key.
const MAX_VALUES: usize = 10_000;

fn backwards(from: &str, to: &str) -> String {
    format!("the range begins at {from}, after its end {to}")
}

/// A number of values, short where it has many digits.
fn count(values: f64) -> String {
    if values < 1e15 { format!("{values:.0}") } else { format!("{values:.1e}") }
}

/// A key and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Dotted path of the key, as it was typed.
    pub key: String,
    /// The key with each of the values.
    pub settings: Vec<Setting>,
}

impl Param {
    /// Reads `KEY=A..B/STEP` or `KEY=a,b,c`, the argument of `--vary`.
    pub fn parse(argument: &str) -> Result<Self, Error> {
        let refuse = |why: String| {
            UsageError::option("--vary", argument, why, "KEY=A..B/STEP, KEY=A..B:N or KEY=a,b,c")
        };
        let (key, list) = argument.split_once('=').ok_or_else(|| refuse("no `=`".to_owned()))?;
        let key = key.trim();
        let values = values(list, None).map_err(|why| refuse(why.to_string()))?;
        let setting = |value: &String| Setting::read("--vary", &format!("{key}={value}"));
        let settings = values.iter().map(setting).collect::<Result<_, _>>()?;
        Ok(Self { key: key.to_owned(), settings })
    }
}

/// Refuses an option that sets a key which the option `by` sweeps.
pub fn refuse_if_set(by: &str, key: &str, options: &ScenarioOptions) -> Result<(), UsageError> {
    let shown = |value: &Option<Value>| value.as_ref().map(Value::to_string);
    let by_name = [
        ("controller.name", "--controller", options.controller.clone()),
        ("duration_s", "--duration", shown(&options.duration)),
        ("seed", "--seed", shown(&options.seed)),
    ];
    let by_name = by_name.into_iter().filter(|(of, ..)| *of == key);
    let by_name = by_name.filter_map(|(_, option, value)| Some(format!("{option} {}", value?)));
    let of_key = |set: &&Setting| set.shown().0 == key;
    let by_set = options.set.iter().filter(of_key).map(|set| format!("--set {set}"));
    match by_name.chain(by_set).next() {
        Some(option) => {
            let why = format_args!("{option} says what it is");
            Err(UsageError::at(by, why, "the key in one of them"))
        }
        None => Ok(()),
    }
}

/// The fault of a list or range.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ListError(pub String);

/// The values of a list or a range, both ends included:
///
/// | text | values |
/// | --- | --- |
/// | `a,b,c` | these |
/// | `A..B/STEP` | from A in steps |
/// | `A..B:N` | N, evenly |
/// | `A..B:log:N` | N, evenly in the logarithm |
///
/// A range without a step takes `usual_step`, if there is one.
pub fn values(list: &str, usual_step: Option<&str>) -> Result<Vec<String>, ListError> {
    read(list, usual_step).map_err(ListError)
}

fn read(list: &str, usual_step: Option<&str>) -> Result<Vec<String>, String> {
    // A path may have two dots as well; a range begins with a number.
    if let Some((from, rest)) = list.split_once("..")
        && from.trim().parse::<f64>().is_ok()
    {
        return match (rest.split_once('/'), rest.split_once(':'), usual_step) {
            (Some((to, step)), ..) => range(from.trim(), to.trim(), step.trim()),
            (None, Some((to, points)), _) => evenly(from.trim(), to.trim(), points.trim()),
            (None, None, Some(step)) => range(from.trim(), rest.trim(), step),
            (None, None, None) => Err("the range has no step".to_owned()),
        };
    }
    let values: Vec<String> = list.split(',').map(|value| value.trim().to_owned()).collect();
    if values.iter().any(String::is_empty) {
        return Err("a value is missing".to_owned());
    }
    if let Some(twice) = values.iter().enumerate().find(|(i, v)| values[..*i].contains(v)) {
        return Err(format!("{} is there twice", twice.1));
    }
    Ok(values)
}

/// A number that begins with a digit: a third dot is a slip, and no fraction.
fn number(text: &str) -> Result<f64, String> {
    let digits = text.trim_start_matches(['-', '+']).starts_with(|c: char| c.is_ascii_digit());
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && digits => Ok(number),
        _ => Err(format!("`{text}` is not a number")),
    }
}

/// Values from `from` to `to`, evenly, or evenly in their logarithms.
fn evenly(from: &str, to: &str, points: &str) -> Result<Vec<String>, String> {
    let (is_log, points) =
        points.strip_prefix("log:").map_or((false, points), |points| (true, points.trim()));
    let (first, last) = (number(from)?, number(to)?);
    let count = points.parse::<usize>().ok().filter(|count| (2..=MAX_VALUES).contains(count));
    let count = count
        .ok_or_else(|| format!("`{points}` is not a number of values from 2 to {MAX_VALUES}"))?;
    if first >= last {
        return Err(backwards(from, to));
    }
    if is_log && first <= 0.0 {
        let why = format!("a logarithmic range begins above 0, not at {from}");
        return Err(why);
    }
    let steps = (count - 1) as f64;
    let at = |place: usize| match is_log {
        true => first * libm::exp(libm::log(last / first) / steps * place as f64),
        false => first + (last - first) / steps * place as f64,
    };
    let inner = (1..count - 1).map(|place| at(place).to_string());
    Ok([from.to_owned()].into_iter().chain(inner).chain([to.to_owned()]).collect())
}

fn range(from: &str, to: &str, step: &str) -> Result<Vec<String>, String> {
    let [first, last, width] = [number(from)?, number(to)?, number(step)?];
    if width <= 0.0 {
        return Err(format!("the step {step} is not above 0"));
    }
    if first > last {
        return Err(backwards(from, to));
    }
    if first < last && width > last - first {
        return Err(format!("the step {step} is longer than the range"));
    }
    // The last value may miss the end by rounding alone.
    let count = ((last - first) / width + 1e-9).floor() + 1.0;
    if count > MAX_VALUES as f64 {
        let values = self::count(count);
        return Err(format!("{values} values, more than {MAX_VALUES}"));
    }
    let decimals = decimals(from).zip(decimals(step)).map(|(from, step)| from.max(step));
    Ok((0..count as usize)
        .map(|index| {
            let value = first + index as f64 * width;
            // As many digits as were typed: 0.1 + 2 * 0.1 is 0.3.
            decimals.map_or_else(|| value.to_string(), |digits| format!("{value:.digits$}"))
        })
        .collect())
}

/// Digits behind the point of a number in plain notation.
fn decimals(number: &str) -> Option<usize> {
    let plain = number.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
    plain.then(|| number.split_once('.').map_or(0, |(_, digits)| digits.len()))
}

/// The seeds that an argument of `--seeds` names. A number N of seeds means 1 to N.
///
/// ```
/// let seeds = |text| -> Vec<u64> {
///     frame::param::seeds(text).unwrap().into_iter().map(|seed| seed.value()).collect()
/// };
/// assert_eq!(seeds("3"), [1, 2, 3], "a number of seeds");
/// assert_eq!((seeds("5..7"), seeds("4,2")), (vec![5, 6, 7], vec![4, 2]));
/// assert!(frame::param::seeds("0").is_err());
/// ```
pub fn seeds(text: &str) -> Result<Vec<Seed>, UsageError> {
    let refuse = |why: &dyn Display| {
        UsageError::option("--seeds", text, why, "a number of seeds of 1 or more, A..B or a,b,c")
    };
    let list = match text.trim().parse::<u64>() {
        Ok(0) => return Err(refuse(&"no seeds")),
        Ok(count) => &format!("1..{count}"),
        Err(_) => text,
    };
    let values = self::values(list, Some("1")).map_err(|why| refuse(&why))?;
    let seed = |value: String| {
        let seed = value.parse::<i64>().ok().and_then(|seed| Seed::try_from(seed).ok());
        seed.ok_or_else(|| refuse(&format_args!("`{value}` is not a seed")))
    };
    values.into_iter().map(seed).collect()
}

/// All combinations of the values, the last key's varying fastest.
pub fn grid(params: &[Param]) -> Vec<Vec<Setting>> {
    params.iter().fold(vec![Vec::new()], |points, param| {
        let with = |point: &Vec<Setting>, setting: &Setting| {
            [&point[..], std::slice::from_ref(setting)].concat()
        };
        let all = |point| param.settings.iter().map(move |setting| with(point, setting));
        points.iter().flat_map(all).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(argument: &str) -> Vec<String> {
        let param = Param::parse(argument).expect("a good argument");
        param.settings.iter().map(|setting| setting.shown().1).collect()
    }

    fn refusal(argument: &str) -> String {
        Param::parse(argument).expect_err("a bad argument").to_string()
    }

    #[test]
    fn a_range_has_both_ends_and_as_many_digits_as_were_typed() {
        assert_eq!(of("a=0..60/20"), ["0", "20", "40", "60"]);
        assert_eq!(of("a=0..0.3/0.1"), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(of("a=-1..1/0.75"), ["-1.00", "-0.25", "0.50"]);
        assert_eq!(of("a=5..5/1"), ["5"]);
        assert_eq!(of("a=1e3..2e3/5e2"), ["1000", "1500", "2000"]);
    }

    #[test]
    fn a_range_of_a_number_of_values_is_even_or_even_in_the_logarithm() {
        assert_eq!(of("a=0..3:4"), ["0", "1", "2", "3"]);
        assert_eq!(of("a=-1..1:3"), ["-1", "0", "1"]);
        let all: Vec<f64> = of("a=0.1..10:log:3").iter().map(|v| v.parse().expect("one")).collect();
        assert!(all[0] == 0.1 && (all[1] - 1.0).abs() < 1e-12 && all[2] == 10.0, "{all:?}");
    }

    #[test]
    fn a_list_is_taken_as_it_is() {
        assert_eq!(of("controller.name=acc-mpc, six-mode"), ["acc-mpc", "six-mode"]);
        assert_eq!(of("x=../a.json,../b.json"), ["../a.json", "../b.json"]);
    }

    #[test]
    fn a_bad_argument_is_refused_with_what_was_expected() {
        for (argument, what) in [
            ("a", "no `=`"),
            ("a=0..10", "has no step"),
            ("a=0..10/0", "not above 0"),
            ("a=0..10/-1", "not above 0"),
            ("a=0.1..0.5/7", "the step 7 is longer than the range"),
            ("a=0..1:1", "`1` is not a number of values"),
            ("a=0..1:log:5", "begins above 0, not at 0"),
            ("a=2..1:5", "after its end"),
            ("a=10..0/1", "after its end"),
            ("a=0..x/1", "`x` is not a number"),
            ("a=0..inf/1", "`inf` is not a number"),
            ("a=0..1/nan", "`nan` is not a number"),
            ("a=0...10/5", "`.10` is not a number"),
            ("a=0..1e9/1", "1000000001 values, more than 10000"),
            ("a=0..1/1e-300", "1.0e300 values, more than 10000"),
            ("a=1,,2", "a value is missing"),
            ("a=", "a value is missing"),
            ("a=1,2,1", "1 is there twice"),
        ] {
            let said = refusal(argument);
            assert!(said.contains(what) && said.contains("expected KEY=A..B/STEP"), "{said}");
        }
    }

    #[test]
    fn a_swept_key_that_an_option_sets_too_is_refused() {
        let options = ScenarioOptions {
            controller: Some("acc-mpc".into()),
            set: vec!["a.b = 3".parse().expect("KEY=VALUE")],
            ..ScenarioOptions::default()
        };
        for (key, option) in [("controller.name", "--controller acc-mpc"), ("a.b", "--set a.b = 3")]
        {
            let said = refuse_if_set("--vary x", key, &options).expect_err(key).to_string();
            assert!(said.contains(&format!("--vary x: {option} says")), "{said}");
        }
        assert!(refuse_if_set("--vary a.c", "a.c", &options).is_ok());
        assert!(refuse_if_set("--vary x", "duration_s", &options).is_ok());
    }

    #[test]
    fn a_grid_has_every_combination_once() {
        let params = [Param::parse("a=1,2").expect("good"), Param::parse("b=x,y").expect("good")];
        let grid = grid(&params);
        let words = |point: &Vec<Setting>| point.iter().map(Setting::to_string).collect::<Vec<_>>();
        let grid: Vec<Vec<String>> = grid.iter().map(words).collect();
        assert_eq!(grid, [["a=1", "b=x"], ["a=1", "b=y"], ["a=2", "b=x"], ["a=2", "b=y"]]);
    }

    #[test]
    fn bad_seeds_are_refused_with_what_was_expected() {
        for (text, words) in [
            ("0", "no seeds"),
            ("1..x", "`x` is not a number"),
            ("1,,2", "a value is missing"),
            ("3..1", "after its end"),
            ("1,1", "1 is there twice"),
            ("1.5,2", "`1.5` is not a seed"),
            ("-1,2", "`-1` is not a seed"),
            ("1000000", "1000000 values, more than 10000"),
        ] {
            let said = seeds(text).expect_err(text).to_string();
            assert!(said.contains(words) && said.contains("expected"), "{said}");
        }
    }
}
