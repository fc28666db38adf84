//! Message definitions of ROS 1 and ROS 2, as bags carry them: the type itself, then those that it uses.

use std::collections::BTreeMap;

/// Most levels of a type in another.
pub(crate) const DEEPEST: usize = 32;
/// Most paths that are listed of a type.
const MOST_PATHS: usize = 500;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    /// Signed whole number of this many bytes.
    Signed(usize),
    /// Unsigned whole number of this many bytes; `bool` and `byte` too.
    Unsigned(usize),
    /// Floating-point number of this many bytes.
    Float(usize),
    Text,
    /// ROS 1: seconds and nanoseconds, unsigned.
    Time,
    /// ROS 1: seconds and nanoseconds, signed.
    Duration,
}

/// Type of a field without its repetition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Scalar(Scalar),
    /// A type of the definition, by its full name.
    Struct(String),
}

/// Repetition of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Repeat {
    Once,
    Fixed(usize),
    Counted,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) repeat: Repeat,
}

/// A message type with all types that it uses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Definition {
    pub(crate) root: String,
    types: BTreeMap<String, Vec<Field>>,
}

impl Definition {
    /// Parses the text of a definition. Lines that are not fields are passed over.
    pub(crate) fn parse(type_name: &str, text: &str) -> Self {
        let root = short(type_name);
        let mut definition = Self { root: root.clone(), types: BTreeMap::new() };
        let mut name = root;
        let mut fields = Vec::new();
        for line in text.lines().map(str::trim) {
            if line.starts_with("====") {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                let done = std::mem::replace(&mut name, short(next.trim()));
                definition.types.entry(done).or_insert_with(|| std::mem::take(&mut fields));
                fields.clear();
                continue;
            }
            let package = name.split('/').next().unwrap_or_default();
            fields.extend(field(line, package));
        }
        definition.types.entry(name).or_insert(fields);
        definition
    }

    pub(crate) fn fields(&self, name: &str) -> Option<&[Field]> {
        self.types.get(name).map(Vec::as_slice)
    }

    /// True if the type is ROS 2's time or duration.
    pub(crate) fn is_time(&self, name: &str) -> bool {
        matches!(name, "builtin_interfaces/Time" | "builtin_interfaces/Duration")
    }

    /// Paths of the numbers in a message; of an array the first element.
    pub(crate) fn numbers(&self) -> Vec<String> {
        let mut paths = Vec::new();
        self.collect(&self.root, "", 0, &mut paths);
        paths
    }

    fn collect(&self, name: &str, before: &str, depth: usize, paths: &mut Vec<String>) {
        if depth > DEEPEST || paths.len() >= MOST_PATHS {
            return;
        }
        for field in self.fields(name).unwrap_or_default() {
            let index = if field.repeat == Repeat::Once { "" } else { "[0]" };
            let path = format!("{before}{}{index}", field.name);
            match &field.kind {
                Kind::Scalar(Scalar::Text) => {}
                Kind::Scalar(_) => paths.push(path),
                Kind::Struct(name) if self.is_time(name) => paths.push(path),
                Kind::Struct(name) => self.collect(name, &format!("{path}."), depth + 1, paths),
            }
        }
    }
}

/// `pkg/msg/Type` as `pkg/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// The field that a line declares; a constant and an empty line declare none.
fn field(line: &str, package: &str) -> Option<Field> {
    let line = line.split('#').next()?.trim();
    let (kind, rest) = line.split_once(char::is_whitespace)?;
    let rest = rest.trim();
    let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    // A constant has `=` behind its name; a default value stands behind a space.
    if name.is_empty() || rest[name.len()..].trim_start().starts_with('=') {
        return None;
    }
    let (kind, repeat) = match kind.split_once('[') {
        None => (kind, Repeat::Once),
        Some((kind, size)) => match size.trim_end_matches(']') {
            size if size.is_empty() || size.starts_with("<=") => (kind, Repeat::Counted),
            size => (kind, Repeat::Fixed(size.parse().ok()?)),
        },
    };
    // A bound on a text's length does not change its bytes.
    let kind = kind.split_once("<=").map_or(kind, |(kind, _)| kind);
    let kind = match scalar(kind) {
        Some(scalar) => Kind::Scalar(scalar),
        None if kind == "Header" => Kind::Struct("std_msgs/Header".into()),
        None if kind.contains('/') => Kind::Struct(short(kind)),
        None => Kind::Struct(format!("{package}/{kind}")),
    };
    Some(Field { name, kind, repeat })
}

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "bool" | "uint8" | "char" => Scalar::Unsigned(1),
        "byte" | "int8" => Scalar::Signed(1),
        "uint16" => Scalar::Unsigned(2),
        "int16" => Scalar::Signed(2),
        "uint32" => Scalar::Unsigned(4),
        "int32" => Scalar::Signed(4),
        "uint64" => Scalar::Unsigned(8),
        "int64" => Scalar::Signed(8),
        "float32" => Scalar::Float(4),
        "float64" => Scalar::Float(8),
        "string" => Scalar::Text,
        "time" => Scalar::Time,
        "duration" => Scalar::Duration,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWIST: &str = "# stamped\nstd_msgs/Header header\nTwist twist\nuint8 KIND=1\nfloat64[36] covariance\n\
        string<=10 label \"none\"\n====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ====\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
        ====\nMSG: geometry_msgs/Twist\nfloat64 x\nint16[] more\n";

    #[test]
    fn numbers_are_listed_by_their_paths() {
        let definition = Definition::parse("geometry_msgs/msg/TwistStamped", TWIST);
        let expected = ["header.stamp", "twist.x", "twist.more[0]", "covariance[0]"];
        assert_eq!(definition.numbers(), expected);
    }

    #[test]
    fn a_type_that_holds_itself_ends() {
        let definition = Definition::parse("a/B", "B b\nfloat32 x\n");
        assert!(definition.numbers().len() <= MOST_PATHS + DEEPEST);
    }
}
