//! Types of scenario keys by their paths.

use scenario::schema::{Key, Shape};

/// True if the key at a dotted path holds whole numbers.
///
/// ```
/// assert!(search::problem::is_whole("runtime.extra_delay_ms"));
/// assert!(!search::problem::is_whole("actors.0.gap_m"));
/// ```
pub fn is_whole(path: &str) -> bool {
    let segments: Vec<&str> =
        path.split(['.', '[']).map(|part| part.trim_end_matches(']')).collect();
    below(scenario::keys(), &segments)
}

fn below(keys: &[Key], path: &[&str]) -> bool {
    let Some((first, rest)) = path.split_first() else { return false };
    keys.iter().filter(|key| key.name == *first).any(|key| of_shape(&key.shape, rest))
}

fn of_shape(shape: &Shape, path: &[&str]) -> bool {
    match (shape, path.split_first()) {
        (Shape::Number { is_whole, .. }, None) => *is_whole,
        (Shape::List(element), Some((_, rest))) => of_shape(element, rest),
        (Shape::Tuple(elements, _), Some((place, rest))) => {
            let element = place.parse().ok().and_then(|place: usize| elements.get(place));
            element.is_some_and(|element| of_shape(element, rest))
        }
        (Shape::Table(keys), Some(_)) => below(keys, path),
        (Shape::Choice(variants), Some((name, rest))) => variants
            .iter()
            .filter(|variant| variant.name == *name)
            .any(|variant| variant.shape.as_ref().is_some_and(|shape| of_shape(shape, rest))),
        (Shape::Kinds(kinds), Some(_)) => kinds.iter().any(|(_, keys)| below(keys, path)),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_found_below_lists_kinds_and_choices() {
        for path in ["seed", "plant.period_ms", "faults.0.delay_ms", "faults[2].bits"] {
            assert!(is_whole(path), "{path}");
        }
        for path in ["duration_s", "faults.0.at_s", "actors.0.profile.sine.period_s", "no.such", ""]
        {
            assert!(!is_whole(path), "{path}");
        }
    }
}
