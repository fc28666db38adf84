//! Meanings of numbers in messages, and units of fields: for schemas, tables and layouts.

use crate::level::Level;
use crate::{BrakeState, PhaseState, Service, ServiceState};

/// The names of a field's numbers.
#[derive(Clone, Copy, Debug)]
pub struct Enumeration {
    /// Name of the set, in capitals before each constant.
    pub name: &'static str,
    /// The fields that hold it: struct and field.
    pub fields: &'static [(&'static str, &'static str)],
    pub values: &'static [(u32, &'static str)],
}

impl Enumeration {
    pub fn value(&self, number: u64) -> Option<&'static str> {
        let mut values = self.values.iter();
        values.find(|(known, _)| u64::from(*known) == number).map(|(_, name)| *name)
    }
}

/// All enumerations whose meaning does not depend on the law.
pub static ENUMERATIONS: [Enumeration; 6] = [
    Enumeration { name: "service", fields: &[("Header", "source")], values: Service::NAMES },
    Enumeration { name: "rung", fields: &[("Diagnostics", "rung")], values: Level::NAMES },
    Enumeration {
        name: "quality",
        fields: &[("Diagnostics", "quality")],
        values: &[(0, "full"), (1, "relaxed"), (2, "backup")],
    },
    Enumeration { name: "brake_state", fields: &[("Brake", "state")], values: BrakeState::NAMES },
    Enumeration { name: "phase", fields: &[("Interval", "state")], values: PhaseState::NAMES },
    Enumeration {
        name: "service_state",
        fields: &[("Heartbeat", "state")],
        values: ServiceState::NAMES,
    },
];

/// The names of the numbers in a field of the struct `layout`.
pub fn of_field(layout: &str, field: &str) -> Option<&'static Enumeration> {
    ENUMERATIONS.iter().find(|enumeration| enumeration.fields.contains(&(layout, field)))
}

/// Endings of names and the units that they stand for, longer ones first.
const UNITS: [(&str, &str); 18] = [
    ("_radps", "rad/s"),
    ("_perm2", "1/m²"),
    ("_perm", "1/m"),
    ("_mps3", "m/s³"),
    ("_mps2", "m/s²"),
    ("_dbsm", "dB relative to 1 m²"),
    ("_mps", "m/s"),
    ("_rad", "rad"),
    ("_rpm", "rpm"),
    ("_gps", "g/s"),
    ("_db", "dB"),
    ("_ns", "ns"),
    ("_nm", "N m"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
    ("_g", "g"),
    ("_share", "1"),
];

/// The unit that the ending of a field's name stands for; `None` for a field without one.
pub fn unit_of(field: &str) -> Option<&'static str> {
    match field {
        "grades" => return Some("m/m"),
        "curvatures" => return Some("1/m"),
        _ => {}
    }
    UNITS.iter().find(|(ending, _)| field.ends_with(ending)).map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TOPICS;
    use crate::{Element, Layout, Scalar};

    fn fields(layout: &'static Layout, check: &mut dyn FnMut(&'static Layout, &'static str, bool)) {
        for field in layout.fields {
            let is_float = field.shape.element == Element::Scalar(Scalar::F64);
            check(layout, field.name, is_float);
            if let Element::Struct(inner) = field.shape.element {
                fields(inner, check);
            }
        }
    }

    #[test]
    fn every_enumeration_has_its_field_and_every_quantity_a_unit() {
        let mut found = Vec::new();
        for topic in TOPICS {
            fields(topic.layout(), &mut |layout, field, is_float| {
                found.push((layout.name, field));
                let is_named_by_law = (layout.name, field) == ("Diagnostics", "figures");
                assert!(
                    !is_float || is_named_by_law || unit_of(field).is_some(),
                    "{}.{field} has no unit in its name",
                    layout.name
                );
            });
        }
        for enumeration in &ENUMERATIONS {
            assert!(enumeration.fields.iter().all(|field| found.contains(field)));
            assert!(enumeration.values.iter().all(|(_, name)| !name.is_empty()));
        }
    }

    #[test]
    fn numbers_have_the_names_of_results() {
        let rung = of_field("Diagnostics", "rung").expect("named");
        assert_eq!(rung.value(1), Some(Level::SignalsLost.name()));
        assert_eq!(rung.value(99), None);
        assert_eq!(of_field("Header", "source").and_then(|s| s.value(4)), Some("controller"));
        assert_eq!((unit_of("speed_mps"), unit_of("sequence")), (Some("m/s"), None));
        let curved = ["yaw_rate_radps", "curvature_perm", "curvature_rate_perm2"].map(unit_of);
        assert_eq!(curved, [Some("rad/s"), Some("1/m"), Some("1/m²")]);
    }
}
