//! Words that are accepted, and the one that was meant.

/// The accepted words as an author writes them, with the nearest one where `refused` may be a slip of it.
pub fn accepted<'a>(refused: &str, words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<&str> = words.into_iter().collect();
    let quoted: Vec<String> = words.iter().map(|word| format!("`{word}`")).collect();
    let listed = match quoted.as_slice() {
        [] => "no key here".to_owned(),
        [a, b] => format!("{a} or {b}"),
        all => all.join(", "),
    };
    match nearest(refused, words) {
        Some(near) => format!("{listed} (did you mean `{near}`?)"),
        None => listed,
    }
}

/// The word nearest to the refused one, when it is near enough to be a slip.
pub(crate) fn nearest<'a>(
    refused: &str,
    words: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let limit = 1 + refused.chars().count() / 4;
    let distances = words.into_iter().map(|word| (edit_distance(refused, word), word));
    let (distance, word) = distances.min_by_key(|(distance, _)| *distance)?;
    (distance <= limit).then_some(word)
}

/// Levenshtein's distance, on the first 64 characters of each word.
fn edit_distance(a: &str, b: &str) -> usize {
    let cut = |word: &str| word.chars().take(64).collect::<String>();
    strsim::levenshtein(&cut(a), &cut(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_pen_gets_a_suggestion() {
        let words = ["period_ms", "range_m", "core"];
        let listed = "`period_ms`, `range_m`, `core`";
        assert_eq!(accepted("perod_ms", words), format!("{listed} (did you mean `period_ms`?)"));
        assert_eq!(accepted("colour", words), listed);
        assert_eq!(accepted("a", ["pause", "stop"]), "`pause` or `stop`");
        assert_eq!(accepted("a", []), "no key here");
    }

    #[test]
    fn edit_distances() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("gap_m", "gap_m"), 0);
    }
}
