//! What the keys mean: the doc comments of the types that read them.

/// The sources of this crate that declare keys, by the name of the top-level table that they are about.
const SOURCES: &[(&str, &str)] = &[
    ("", include_str!("../lib.rs")),
    ("actors", include_str!("../actor.rs")),
    ("actors", include_str!("../recorded/keys.rs")),
    ("aebs", include_str!("../aebs.rs")),
    ("controller", include_str!("../controller.rs")),
    ("events", include_str!("../event.rs")),
    ("faults", include_str!("../faults/begin.rs")),
    ("faults", include_str!("../faults/effect.rs")),
    ("faults", include_str!("../faults/mod.rs")),
    ("faults", include_str!("../faults/topic.rs")),
    ("perception", include_str!("../perception.rs")),
    ("plant", include_str!("../plant.rs")),
    ("referee", include_str!("../referee.rs")),
    ("require", include_str!("../require.rs")),
    ("road", include_str!("../road.rs")),
    ("runtime", include_str!("../runtime.rs")),
    ("supervision", include_str!("../supervision.rs")),
    ("v2x", include_str!("../preview.rs")),
    ("v2x", include_str!("../radio.rs")),
    ("v2x", include_str!("../v2x.rs")),
];

/// The comment on field `key` of struct `name`, or on a variant of an enum, which a key below the
/// top-level table `table` reads; the table's own source comes first, since names repeat.
pub(super) fn of(table: &str, name: &str, key: &str) -> Option<String> {
    let own = SOURCES.iter().filter(|(about, _)| *about == table);
    let others = SOURCES.iter().filter(|(about, _)| *about != table);
    let field = key.replace('-', "_");
    let variant = pascal(name);
    own.chain(others).find_map(|(_, source)| {
        messages::notes::in_source(source, name, &field)
            .or_else(|| messages::notes::in_variant(source, &variant, &field))
    })
}

/// The comment on key `key` of a table that is read key by key: on a field of the variant of that
/// kind, or else on one of the types that all kinds share.
pub(super) fn of_kind(table: &str, kind: &str, key: &str) -> Option<String> {
    let sources = || SOURCES.iter().filter(|(about, _)| *about == table).map(|(_, source)| *source);
    let of_variant =
        sources().find_map(|source| messages::notes::in_variant(source, &pascal(kind), key));
    of_variant.or_else(|| sources().find_map(|source| in_any(source, key)))
}

/// The comment on field `key` of the first type of `source` that has one.
fn in_any(source: &str, key: &str) -> Option<String> {
    let mut heads = source.lines().map(str::trim).filter_map(|line| line.strip_suffix(" {"));
    heads.find_map(|head| match head.strip_prefix("pub struct ") {
        Some(name) => messages::notes::in_source(source, name, key),
        None => messages::notes::in_variant(source, head, key),
    })
}

/// The name of a variant from its name in a file: `wave-length` is `WaveLength`.
fn pascal(name: &str) -> String {
    let words = name.split('-').map(|word| {
        let mut letters = word.chars();
        let first = letters.next().map(|letter| letter.to_ascii_uppercase());
        first.into_iter().chain(letters).collect::<String>()
    });
    words.collect()
}
