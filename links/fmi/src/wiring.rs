//! Which variable of a unit has which quantity: by names and units of measure, or as the user maps them.

use crate::UnitError;
use crate::description::{Description, Variable};
use crate::measure::{ACCELERATION, Measure, dimension_name};
use crate::quantity::{Flow, Quantity};

pub struct Wiring<Q: 'static, A: 'static> {
    /// Quantities with the variables that have them, and with the measures of these.
    pub wires: Vec<(&'static Quantity<Q, A>, Variable, Measure)>,
    /// Values that the user gives to variables before the unit initialises.
    pub starts: Vec<(Variable, f64)>,
    /// Inputs of the unit that keep their start.
    pub unused: Vec<String>,
}

fn number(text: &str) -> Option<f64> {
    match text {
        "true" => Some(1.0),
        "false" => Some(0.0),
        text => text.parse().ok().filter(|number: &f64| number.is_finite()),
    }
}

/// Letters and digits of a name in lower case, and the same without a unit of measure at its end.
fn bare(name: &str) -> (String, String, Option<Measure>) {
    let plain = |text: &str| text.chars().filter(char::is_ascii_alphanumeric).collect::<String>();
    let lower = name.to_lowercase();
    let ends = lower.match_indices('_').map(|(at, _)| at).chain(lower.rfind('['));
    let cut = ends.filter_map(|at| {
        let end = lower[at + 1..].trim_matches(['[', ']']).replace("_per_", "/").replace('_', "/");
        Some((at, Measure::named(&end)?)).filter(|(_, m)| !end.is_empty() && m.factor != 0.0)
    });
    match cut.min_by_key(|(at, _)| *at) {
        Some((at, measure)) => (plain(&lower), plain(&lower[..at]), Some(measure)),
        None => (plain(&lower), plain(&lower), None),
    }
}

impl<Q, A> Wiring<Q, A> {
    /// Wires a unit; `unit` names it in errors, `needed` are the quantities without which it is of no use. Words of a
    /// command behind the unit are `--VARIABLE=NUMBER`, which sets a start, and `QUANTITY=VARIABLE`, which maps.
    ///
    /// # Errors
    /// Names the variable or the quantity that does not fit.
    pub fn of(
        unit: &str,
        description: &Description,
        quantities: &'static [Quantity<Q, A>],
        needed: &[&str],
        words: &[String],
    ) -> Result<Self, UnitError> {
        let variables = &description.variables;
        let find = |name: &str| {
            variables.iter().find(|variable| variable.name == name).ok_or_else(|| {
                let may = ["input", "output", "parameter"];
                let names = list(variables.iter().filter(|v| may.contains(&&*v.causality)));
                UnitError::new(unit, format!("no variable `{name}` of one number"), names)
            })
        };
        let (mut wires, mut starts) = (Vec::new(), Vec::new());
        for word in words {
            let refuse = |expected: &str| {
                Err(UnitError::new(unit, format!("cannot use the word `{word}`"), expected))
            };
            let Some((key, value)) = word.split_once('=') else {
                return refuse("QUANTITY=VARIABLE or --VARIABLE=NUMBER");
            };
            let unfit = |variable: &Variable, expected: String| {
                let (name, causality) = (&variable.name, &variable.causality);
                UnitError::new(unit, format!("`{name}` is of causality `{causality}`"), expected)
            };
            if let Some(name) = key.strip_prefix("--") {
                let Some(start) = number(value) else { return refuse("--VARIABLE=NUMBER") };
                let variable = find(name)?;
                if !variable.has_start {
                    return Err(unfit(variable, "a parameter or an input to give a start".into()));
                }
                starts.push((variable.clone(), start));
                continue;
            }
            let quantity = quantities.iter().find(|quantity| quantity.key == key);
            let quantity = quantity.ok_or_else(|| {
                let keys: Vec<_> = quantities.iter().map(|quantity| quantity.key).collect();
                UnitError::new(unit, format!("no quantity `{key}` to map"), keys.join(", "))
            })?;
            let variable = find(value)?;
            if !fits(quantity, variable) {
                return Err(unfit(variable, format!("{} for {key}", quantity.flow.word())));
            }
            wires.push((quantity, variable.clone(), measure(unit, quantity, variable)?));
        }
        let mut wiring = Self { wires, starts, unused: Vec::new() };
        for quantity in quantities {
            wiring.find(quantity, variables);
        }
        for key in needed {
            let is_wired = key.split('|').any(|key| wiring.has(key));
            if !is_wired {
                return Err(missing(unit, key, quantities, variables));
            }
        }
        let inputs = variables.iter().filter(|v| v.causality == "input");
        let unused = inputs.filter(|v| {
            wiring.is_free(v) && wiring.starts.iter().all(|(given, _)| given.name != v.name)
        });
        wiring.unused = unused.map(|variable| variable.name.clone()).collect();
        // An input that is known by its name, and not by its measure, would keep its start unseen.
        let open =
            quantities.iter().filter(|q| matches!(q.flow, Flow::Input(_)) && !wiring.has(q.key));
        for quantity in open {
            let mut unused = variables.iter().filter(|v| wiring.unused.contains(&v.name));
            let named = unused.find(|variable| rank(quantity, variable).is_some());
            named.map(|variable| measure(unit, quantity, variable)).transpose()?;
        }
        Ok(wiring)
    }

    /// True if a variable has this quantity.
    pub fn has(&self, key: &str) -> bool {
        self.wires.iter().any(|(quantity, ..)| quantity.key == key)
    }

    fn is_free(&self, variable: &Variable) -> bool {
        self.wires.iter().all(|(_, wired, _)| wired.name != variable.name)
    }

    /// Wires the variable whose name and measure are a quantity's, if there is one. A single output that is an
    /// acceleration by its measure is the request of a law.
    fn find(&mut self, quantity: &'static Quantity<Q, A>, variables: &[Variable]) {
        if self.has(quantity.key) {
            return;
        }
        let ranked = variables.iter().filter(|variable| {
            let given = self.starts.iter().any(|(given, _)| given.name == variable.name);
            let may = matches!(quantity.flow, Flow::Start(_)) || self.is_free(variable);
            fits(quantity, variable) && may && !given
        });
        let is_acceleration = |v: &&Variable| {
            let measure = v.measure.as_ref().and_then(|(_, measure)| *measure);
            fits(quantity, v) && measure.is_some_and(|m| m.dimension == ACCELERATION)
        };
        let is_request = quantity.key == "request_mps2"
            && matches!(quantity.flow, Flow::Output(_))
            && variables.iter().filter(is_acceleration).count() == 1;
        let ranked = ranked.filter_map(|variable| {
            let last = (is_request && is_acceleration(&variable)).then_some((usize::MAX, 0));
            let rank = rank(quantity, variable).or(last)?;
            let measure = measure("", quantity, variable).ok()?;
            Some((rank, variable, measure))
        });
        if let Some((_, variable, measure)) = ranked.min_by_key(|(rank, ..)| *rank) {
            self.wires.push((quantity, variable.clone(), measure));
        }
    }
}

/// True if a variable may play the part.
fn fits<Q, A>(quantity: &Quantity<Q, A>, variable: &Variable) -> bool {
    match quantity.flow {
        Flow::Input(_) => variable.causality == "input",
        Flow::Start(_) => variable.has_start && variable.causality != "input",
        Flow::Output(_) => variable.causality == "output",
    }
}

/// How likely a variable has a quantity by its name: least first. A whole name comes before the last part of one.
fn rank<Q, A>(quantity: &Quantity<Q, A>, variable: &Variable) -> Option<(usize, usize)> {
    if !fits(quantity, variable) {
        return None;
    }
    let own = bare(quantity.key).1;
    let part = variable.name.rsplit('.').next().unwrap_or(&variable.name);
    let ranks = [(&*variable.name, 0), (part, 1)].map(|(name, inner)| {
        let (whole, base, _) = bare(name);
        let place = quantity.names.iter().position(|n| *n == whole || *n == base);
        let is_own = variable.name == quantity.key || base == own;
        let place = if is_own { Some(0) } else { place.map(|place| place + 1) };
        place.map(|place| (place, inner))
    });
    ranks.into_iter().flatten().min()
}

/// The measure of a variable: as it says, as its name ends, or SI.
fn measure<Q, A>(
    unit: &str,
    quantity: &Quantity<Q, A>,
    variable: &Variable,
) -> Result<Measure, UnitError> {
    let name = &variable.name;
    let expected = dimension_name(quantity.dimension);
    match &variable.measure {
        Some((_, Some(measure))) if measure.dimension == quantity.dimension => Ok(*measure),
        Some((word, Some(_))) if word != "1" && word != "-" => {
            let fault = format!("`{name}` has the unit `{word}`");
            Err(UnitError::new(unit, fault, format!("{expected} for {}", quantity.key)))
        }
        Some((word, None)) => {
            let fault = format!("the unit `{word}` of `{name}` is not defined");
            Err(UnitError::new(unit, fault, format!("{expected}, or a `BaseUnit` for it")))
        }
        _ => {
            let ends = bare(name).2.filter(|measure| measure.dimension == quantity.dimension);
            Ok(ends.unwrap_or(Measure::si(quantity.dimension)))
        }
    }
}

/// Names of variables with their parts.
fn list<'a>(variables: impl Iterator<Item = &'a Variable>) -> String {
    let shown = variables.map(|v| format!("`{}` ({})", v.name, v.causality));
    let names: Vec<_> = shown.take(20).collect();
    match names.is_empty() {
        true => "a unit with inputs and outputs of one number each".to_owned(),
        false => format!("one of {}", names.join(", ")),
    }
}

fn missing<Q, A>(
    unit: &str,
    key: &str,
    quantities: &[Quantity<Q, A>],
    variables: &[Variable],
) -> UnitError {
    let quantity = quantities.iter().find(|quantity| key.split('|').any(|key| key == quantity.key));
    let shown = quantity.map_or("a variable", |quantity| quantity.flow.word());
    let of_part = variables.iter().filter(|v| quantity.is_some_and(|q| fits(q, v)));
    let (keys, first) = (key.replace('|', " or "), key.split('|').next().unwrap_or(key));
    let expected = match of_part.clone().next() {
        None => shown.to_owned(),
        Some(_) => format!("a map {first}=VARIABLE with {}", list(of_part)),
    };
    UnitError::new(unit, format!("{shown} for {keys} is not found"), expected)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::SPEED;

    #[test]
    fn a_name_is_read_without_its_unit_of_measure() {
        let read = |name: &str| (bare(name).1, bare(name).2.map(|measure| measure.factor));
        assert_eq!(read("speed_mps"), ("speed".to_owned(), Some(1.0)));
        assert_eq!(read("Speed_km_h"), ("speed".to_owned(), Some(1.0 / 3.6)));
        assert_eq!(read("v_kmh"), ("v".to_owned(), Some(1.0 / 3.6)));
        assert_eq!(read("v_ego"), ("vego".to_owned(), None));
        assert_eq!(bare("request_mps2").2.map(|m| m.dimension), Some(ACCELERATION));
        assert_eq!(bare("a[m/s2]").2.map(|m| m.dimension), Some(ACCELERATION));
        assert_eq!(bare("v_m_per_s").2.map(|m| m.dimension), Some(SPEED));
    }
}
