//! The scalars of a message: where each one is, and its value.
//!
//! ```
//! use messages::{Topic, Value};
//!
//! let message = vec![0; Topic::Command.message_bytes()];
//! let places = Topic::Command.layout().scalars();
//! let request = places.iter().find(|place| place.path == "plan_mps2.0").expect("a field");
//! assert_eq!(request.read(&message), Value::Float(0.0));
//! ```

use crate::{Element, Layout, Scalar};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Dotted path from the message.
    pub path: String,
    /// Struct that declares the field.
    pub layout: &'static str,
    pub field: &'static str,
    /// Distance from the start of the message, bytes.
    pub offset: usize,
    pub bytes: usize,
    pub scalar: Scalar,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// Bytes, printed as one hexadecimal number.
    Bytes(&'a [u8]),
    Unsigned(u64),
    Signed(i64),
    Float(f64),
}

impl std::fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bytes(bytes) => {
                f.write_str("0x")?;
                bytes.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
            }
            Self::Unsigned(value) => value.fmt(f),
            Self::Signed(value) => value.fmt(f),
            Self::Float(value) => value.fmt(f),
        }
    }
}

impl Place {
    /// Reads the scalar from a message's bytes.
    ///
    /// # Panics
    /// If `message` is shorter than the struct that the place belongs to.
    pub fn read<'a>(&self, message: &'a [u8]) -> Value<'a> {
        let bytes = &message[self.offset..self.offset + self.bytes];
        match self.scalar {
            Scalar::U8 => Value::Bytes(bytes),
            Scalar::U32 => Value::Unsigned(bytemuck::pod_read_unaligned::<u32>(bytes).into()),
            Scalar::U64 => Value::Unsigned(bytemuck::pod_read_unaligned(bytes)),
            Scalar::I64 => Value::Signed(bytemuck::pod_read_unaligned(bytes)),
            Scalar::F64 => Value::Float(bytemuck::pod_read_unaligned(bytes)),
        }
    }
}

impl Layout {
    /// All scalars of the struct in order, by their dotted path: `header.sequence`,
    /// `tracks.0.range_m`.
    pub fn scalars(&self) -> Vec<Place> {
        let mut places = Vec::new();
        self.collect("", 0, &mut places);
        places
    }

    fn collect(&self, prefix: &str, base: usize, into: &mut Vec<Place>) {
        for field in self.fields {
            let name = format!("{prefix}{}", field.name);
            let element = field.shape.element;
            // An array of bytes is one value.
            let (len, bytes) = match element {
                Element::Scalar(Scalar::U8) => (None, field.shape.len.unwrap_or(1)),
                _ => (field.shape.len, element.bytes()),
            };
            for index in 0..len.unwrap_or(1) {
                let path = len.map_or_else(|| name.clone(), |_| format!("{name}.{index}"));
                let offset = base + field.offset + index * bytes;
                let (layout, field) = (self.name, field.name);
                match element {
                    Element::Scalar(scalar) => {
                        into.push(Place { path, layout, field, offset, bytes, scalar });
                    }
                    Element::Struct(inner) => inner.collect(&format!("{path}."), offset, into),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Command, Message, Topic};
    use bytemuck::Zeroable;

    #[test]
    fn values_are_read_by_path() {
        let mut command = Command::zeroed();
        command.header_mut().origins.radar.acquisition_ns = -1;
        command.plan_mps2[2] = -1.5;
        let bytes = bytemuck::bytes_of(&command);
        let at = |path: &str| {
            let places = Topic::Command.layout().scalars();
            places.into_iter().find(|place| place.path == path).map(|place| place.read(bytes))
        };
        assert_eq!(at("header.origins.radar.acquisition_ns"), Some(Value::Signed(-1)));
        assert_eq!(at("plan_mps2.2"), Some(Value::Float(-1.5)));
        assert_eq!(at("plan_mps2.128"), None);
    }
}
