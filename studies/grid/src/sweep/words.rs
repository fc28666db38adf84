//! Keys of a scenario for people: `runtime.extra_delay_ms` is the extra delay in ms.

/// Suffixes of keys, and the units that they stand for; longer ones before those that end them.
const UNITS: [(&str, &str); 14] = [
    ("_per_m2", "1/m²"),
    ("_mps2", "m/s²"),
    ("_mps3", "m/s³"),
    ("_percent", "%"),
    ("_mps", "m/s"),
    ("_kmh", "km/h"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_us", "µs"),
    ("_ms", "ms"),
    ("_s", "s"),
    ("_m", "m"),
];

/// The name of a key in words, and its unit if the key has one.
pub fn name(key: &str) -> (String, Option<&'static str>) {
    let last = key.rsplit('.').next().unwrap_or(key);
    let unit = UNITS.iter().find_map(|(suffix, unit)| Some((last.strip_suffix(suffix)?, *unit)));
    let (words, unit) = unit.map_or((last, None), |(words, unit)| (words, Some(unit)));
    // A last part without a meaning of its own stands with the one before it: `controller.name`.
    let words = match key.rsplit('.').nth(1) {
        Some(before) if matches!(words, "name" | "vehicle" | "model" | "kind") => {
            format!("{before} {words}")
        }
        _ => words.to_owned(),
    };
    (words.replace('_', " "), unit)
}

/// A key at an axis: its name and unit, then the key itself.
pub fn axis(key: &str) -> String {
    match name(key) {
        (words, Some(unit)) => format!("{words}, {unit} ({key})"),
        (words, None) => format!("{words} ({key})"),
    }
}

/// A key's value in a legend.
pub fn value(key: &str, value: &str) -> String {
    match name(key) {
        (words, Some(unit)) => format!("{words} {value} {unit}"),
        // The value of a name is a name.
        (words, None) if words.ends_with(" name") => value.to_owned(),
        (words, None) => format!("{words} {value}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_become_words_with_units() {
        assert_eq!(axis("runtime.extra_delay_ms"), "extra delay, ms (runtime.extra_delay_ms)");
        assert_eq!(value("plant.mass_factor", "1.15"), "mass factor 1.15");
        assert_eq!(value("set_speed_mps", "25"), "set speed 25 m/s");
        assert_eq!(value("v2x.preview.noise_percent", "0.25"), "noise 0.25 %");
        assert_eq!(value("controller.name", "acc-mpc"), "acc-mpc");
        assert_eq!(axis("controller.weights.q1"), "q1 (controller.weights.q1)");
    }
}
