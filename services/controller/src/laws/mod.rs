//! The registry: the crate `laws`, and the law that a program of the user's computes.

pub mod external;

pub use ::laws::{cacc, quadratic_bounded, signal_stop, six_mode, truck};

use crate::law::settings::Table;
use crate::law::{Descriptor, Formulation, GapPolicy, Law, Reader};
use scenario::referee::DesiredGap;
use scenario::{Problem, Reads, Scenario, accepted};

/// Every law, in the order of `timegap list`.
pub static ALL: &[&Descriptor] = {
    let [acc, cacc, signal_stop, six_mode, quadratic_bounded, truck] = ::laws::ALL;
    &[acc, cacc, signal_stop, six_mode, quadratic_bounded, truck, &external::EXTERNAL]
};

/// The laws that need no program of the user's.
pub fn own() -> impl Iterator<Item = &'static Descriptor> {
    ALL.iter().copied().filter(|law| !std::ptr::eq(*law, &external::EXTERNAL))
}

/// Those that drive such a vehicle.
pub fn driving(is_truck: bool) -> impl Iterator<Item = &'static Descriptor> {
    own().filter(move |law| is_truck || !law.trucks_alone)
}

pub fn find(name: &str) -> Option<&'static Descriptor> {
    ALL.iter().copied().find(|law| law.name == name)
}

/// The tables below `[controller]` that laws read, each once.
pub fn tables() -> Vec<Table> {
    let mut tables: Vec<_> = ALL.iter().filter_map(|law| law.table).collect();
    tables.dedup_by_key(|table| table.name);
    tables
}

/// The law that a scenario names.
///
/// # Errors
/// Names the key when there is no such law.
pub fn of(scenario: &Scenario) -> Result<&'static Descriptor, Problem> {
    let name = scenario.controller.name.as_str();
    find(name).or_else(|| external::named(scenario)).ok_or_else(|| {
        let message = format!("unknown value `{name}`");
        let own = scenario.laws.keys().map(String::as_str);
        let names = ALL.iter().map(|law| law.name).chain(own);
        Problem::new("controller.name", message, accepted(name, names))
    })
}

/// Builds the law of a scenario.
///
/// # Errors
/// Names the key that the law refuses.
pub fn build(scenario: &Scenario) -> Result<Box<dyn Law>, Problem> {
    (of(scenario)?.build)(&Reader::new(scenario))
}

/// The program of the user's that the scenario's law hosts, if it hosts one.
///
/// # Errors
/// Names the key when there is no such program.
pub fn program(scenario: &Scenario) -> Result<Option<runtime::Program>, Problem> {
    match std::ptr::eq(of(scenario)?, &external::EXTERNAL) {
        true => external::program(scenario).map(Some),
        false => Ok(None),
    }
}

/// Checks the law's name, the tables of all laws, and that the scenario's law accepts its settings. Returns the keys
/// that the law reads.
///
/// # Errors
/// Names the first key that is wrong.
pub fn check(scenario: &Scenario) -> Result<Reads, Problem> {
    let controller = &scenario.controller;
    if let Some(name) = scenario.laws.keys().find(|name| find(name).is_some()) {
        let message = format!("`{name}` is a law of timegap's own");
        return Err(Problem::new(format!("laws.{name}"), message, "another name"));
    }
    let law = of(scenario)?;
    for name in controller.tables.names() {
        let tables = tables();
        match tables.iter().find(|table| table.name == name) {
            Some(table) => (table.check)(controller, name)?,
            None => {
                let known = accepted(name, tables.iter().map(|table| table.name));
                let message = format!("unknown key `{name}`");
                return Err(controller.tables.refuse(name, &message, &known));
            }
        }
    }
    let reader = Reader::new(scenario);
    (law.build)(&reader)?;
    Ok(reader.reads())
}

/// The formulation that a scenario chooses; `None` if this registry does not have its law.
pub fn formulation(scenario: &Scenario) -> Option<&'static Formulation> {
    of(scenario).ok().map(|law| (law.formulation)(&scenario.controller))
}

/// Names of the figures that the scenario's law puts into `control/diagnostics`.
pub fn figure_names(scenario: &Scenario) -> Vec<&'static str> {
    formulation(scenario).map_or_else(Vec::new, Formulation::figure_names)
}

pub fn mode_names(scenario: &Scenario) -> &'static [&'static str] {
    formulation(scenario).map_or(&[], |formulation| formulation.modes)
}

/// Gap from which gap errors are measured. It is the scenario's own, else the one at which its law aims, if the
/// scenario shows it.
pub fn desired_gap(scenario: &Scenario) -> Option<DesiredGap> {
    scenario.referee.desired_gap.or_else(|| match of(scenario).ok()?.gap {
        GapPolicy::Scenario(gap) => Some(gap(scenario)),
        GapPolicy::Figure(_) | GapPolicy::Internal => None,
    })
}

/// The place among the law's figures of gap minus desired gap, if only the law has it.
pub fn gap_error_figure(scenario: &Scenario) -> Option<usize> {
    match of(scenario).ok()?.gap {
        GapPolicy::Figure(name) => formulation(scenario)?.figure(name),
        GapPolicy::Scenario(_) | GapPolicy::Internal => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Overrides;
    use scenario::schema::{Key, Shape};

    fn refused(lines: &str) -> String {
        let text = format!("schema_version = 1\nname = \"mine\"\n[controller]\n{lines}");
        Scenario::parse_with("mine.toml", &text, &Overrides::new(), &check)
            .expect_err("it is wrong")
            .to_string()
    }

    #[test]
    fn names_and_tables_are_found_once() {
        for &law in ALL {
            assert!(std::ptr::eq(find(law.name).expect("it is in the list"), law));
            assert!(!law.formulations.is_empty() && !law.description.contains('\n'));
        }
    }

    #[test]
    fn every_key_of_a_table_has_a_meaning_a_default_and_a_range() {
        let ranges: usize = tables().iter().map(|table| ranges(table.name, (table.keys)())).sum();
        assert!(ranges > 40, "{ranges}");
    }

    /// Numbers with a range below a table; each key is checked.
    fn ranges(table: &str, keys: Vec<Key>) -> usize {
        let mut ranges = 0;
        for key in keys {
            let place = format!("{table}.{}", key.name);
            assert!(!key.meaning.is_empty(), "{place}");
            // A key of the vehicle stands in for the preset's, or for a value that is computed.
            let may_be_absent = place == "quadratic_bounded.design"
                || place.starts_with("predictive.truck.")
                || key.meaning.contains("absent:");
            match &key.shape {
                Shape::Table(below) => ranges += self::ranges(&place, below.clone()),
                _ => assert!(key.default.is_some() || may_be_absent, "{place}"),
            }
            if let Shape::Number { range, .. } = key.shape {
                ranges += usize::from(range.is_some());
                let says = key.expected.is_some() || key.meaning.contains("; from ");
                assert!(says || may_be_absent, "{place} does not say its range");
            }
        }
        ranges
    }

    #[test]
    fn an_unknown_name_is_shown_with_the_nearest_one() {
        let shown = refused("name = \"cac-mpc\"\n");
        assert!(
            shown.contains("mine.toml:4:8") && shown.contains("did you mean `cacc-mpc`?"),
            "{shown}"
        );
    }

    #[test]
    fn a_wrong_key_in_a_laws_table_is_marked_at_the_key() {
        let shown = refused("name = \"six-mode\"\n[controller.six_mode]\nbraking_mps3 = 2\n");
        assert!(shown.contains("mine.toml:6:1: unknown key `braking_mps3`"), "{shown}");
        assert!(
            shown.contains("   | ^^^^^^^^^^^^ expected")
                || shown.contains("  | ^^^^^^^^^^^^ expected"),
            "{shown}"
        );
        assert!(shown.contains("did you mean `braking_mps2`?"), "{shown}");
        let shown = refused("[controller.predictive]\nplanner = \"dynamic\"\n");
        assert!(shown.contains("mine.toml:5:11: unknown value `dynamic`"), "{shown}");
        let shown = refused("name = \"six-mode\"\n[controller.six_mode]\nbraking_mps2 = -1\n");
        assert!(shown.contains("mine.toml:6:16") && shown.contains("at most 12"), "{shown}");
        let shown = refused("road.min_gap_m = \"near\"\n");
        assert!(shown.contains("mine.toml:4:18") && shown.contains("expected a number"), "{shown}");
    }

    #[test]
    fn a_table_that_belongs_to_no_law_is_marked_at_its_name() {
        let shown = refused("six_mod = { braking_mps2 = 2 }\n");
        assert!(shown.contains("mine.toml:4:1: unknown key `six_mod`"), "{shown}");
        assert!(shown.contains("did you mean `six_mode`?"), "{shown}");
    }
}
