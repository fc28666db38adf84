//! The layout of every message as data, taken from the Rust structs themselves.
//!
//! Everything that shows a message to others (the schema in a recording, Python and C types, CSV
//! columns) is made from a [`Layout`], and a `Layout` is made by [`layout!`](self) from the names of
//! the fields alone: the compiler fills in types and offsets, refuses a missing or an unknown field,
//! and refuses a struct whose bytes would not be its CDR body.

use iceoryx2::prelude::ZeroCopySend;

/// A scalar of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// A byte; an array of bytes is one value.
    U8,
    /// Unsigned, 32 bits.
    U32,
    /// Unsigned, 64 bits.
    U64,
    /// Signed, 64 bits.
    I64,
    /// IEEE 754 binary64.
    F64,
}

impl Scalar {
    /// Size and alignment, bytes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// The type of one element of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// A scalar.
    Scalar(Scalar),
    /// Another struct.
    Struct(&'static Layout),
}

impl Element {
    /// Size, bytes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::Scalar(scalar) => scalar.bytes(),
            Self::Struct(layout) => layout.bytes,
        }
    }
}

/// The type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Type of the element or elements.
    pub element: Element,
    /// Elements of an array; `None` for a single one.
    pub len: Option<usize>,
}

/// One field of a struct.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name, with its unit.
    pub name: &'static str,
    /// Distance from the start of the struct, bytes.
    pub offset: usize,
    /// Type.
    pub shape: Shape,
}

/// Largest message that its readers copy, and of which every byte is protected, bytes.
pub const SMALL_BYTES: usize = 4 << 10;

/// A struct of the messages.
#[derive(Debug, PartialEq, Eq)]
pub struct Layout {
    /// Name without its package.
    pub name: &'static str,
    /// Name on the topics and in recordings, `timegap_msgs/msg/Name`.
    pub type_name: &'static str,
    /// Size, bytes.
    pub bytes: usize,
    /// Fields in order.
    pub fields: &'static [Field],
}

/// A struct whose layout is known as data.
pub trait Laid: ZeroCopySend {
    /// The layout.
    const LAYOUT: &'static Layout;
}

/// A type that a field can have.
pub trait FieldType {
    /// Its shape.
    const SHAPE: Shape;
}

macro_rules! scalar {
    ($type:ty, $scalar:ident) => {
        impl FieldType for $type {
            const SHAPE: Shape = Shape { element: Element::Scalar(Scalar::$scalar), len: None };
        }
    };
}
scalar!(u8, U8);
scalar!(u32, U32);
scalar!(u64, U64);
scalar!(i64, I64);
scalar!(f64, F64);

impl<T: Laid> FieldType for T {
    const SHAPE: Shape = Shape { element: Element::Struct(T::LAYOUT), len: None };
}

impl<T: FieldType, const N: usize> FieldType for [T; N] {
    const SHAPE: Shape = {
        assert!(T::SHAPE.len.is_none(), "an array of arrays has no ROS 2 type");
        Shape { element: T::SHAPE.element, len: Some(N) }
    };
}

/// Shape of the field that a projection picks: lets a macro find a type by a field's name.
pub(crate) const fn shape_of<S, F: FieldType>(_: fn(&S) -> &F) -> Shape {
    F::SHAPE
}

impl Layout {
    /// Checks that the struct's bytes are its CDR body: fields in order without gaps, each scalar on
    /// a multiple of its size.
    pub(crate) const fn check(&self) {
        let mut end = 0;
        let mut index = 0;
        while index < self.fields.len() {
            let field = &self.fields[index];
            assert!(field.offset == end, "a gap, or fields out of order");
            let element = field.shape.element;
            if let Element::Scalar(scalar) = element {
                assert!(field.offset.is_multiple_of(scalar.bytes()), "CDR would pad here");
            } else {
                assert!(field.offset.is_multiple_of(8), "nested structs begin on whole words");
            }
            let count = match field.shape.len {
                Some(len) => len,
                None => 1,
            };
            end += element.bytes() * count;
            index += 1;
        }
        assert!(end == self.bytes && end.is_multiple_of(8), "padding at the end");
    }

    /// Bytes from the start of `message` that are in use, which its end-to-end protection covers. If the struct is larger
    /// than [`SMALL_BYTES`] and ends with `count` and an array, the first `count` elements of that array are the last of
    /// them; all bytes otherwise.
    ///
    /// # Panics
    /// If `message` is shorter than the struct.
    #[inline]
    #[must_use]
    pub fn bytes_in_use(&self, message: &[u8]) -> usize {
        if self.bytes <= SMALL_BYTES { self.bytes } else { self.bytes_that_count(message) }
    }

    fn bytes_that_count(&self, message: &[u8]) -> usize {
        let [.., Field { name: "count", offset, .. }, array] = self.fields else {
            return self.bytes;
        };
        let Some(capacity) = array.shape.len else { return self.bytes };
        let count: u64 = bytemuck::pod_read_unaligned(&message[*offset..offset + 8]);
        let count = usize::try_from(count).map_or(capacity, |count| count.min(capacity));
        array.offset + count * array.shape.element.bytes()
    }

    /// All scalars of the struct in order, by their dotted path: `header.sequence`,
    /// `tracks.0.range_m`.
    #[must_use]
    pub fn scalars(&self) -> Vec<Place> {
        let mut places = Vec::new();
        self.collect("", 0, &mut places);
        places
    }

    fn collect(&self, prefix: &str, base: usize, into: &mut Vec<Place>) {
        for field in self.fields {
            let name = format!("{prefix}{}", field.name);
            if field.shape.element == Element::Scalar(Scalar::U8) {
                let bytes = field.shape.len.unwrap_or(1);
                let offset = base + field.offset;
                let (layout, field) = (self.name, field.name);
                into.push(Place { path: name, layout, field, offset, bytes, scalar: Scalar::U8 });
                continue;
            }
            for index in 0..field.shape.len.unwrap_or(1) {
                let path = match field.shape.len {
                    Some(_) => format!("{name}.{index}"),
                    None => name.clone(),
                };
                let offset = base + field.offset + index * field.shape.element.bytes();
                match field.shape.element {
                    Element::Scalar(scalar) => into.push(Place {
                        path,
                        layout: self.name,
                        field: field.name,
                        offset,
                        bytes: scalar.bytes(),
                        scalar,
                    }),
                    Element::Struct(layout) => layout.collect(&format!("{path}."), offset, into),
                }
            }
        }
    }
}

/// Where a scalar is in a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Dotted path from the message.
    pub path: String,
    /// Struct that declares the field.
    pub layout: &'static str,
    /// The field.
    pub field: &'static str,
    /// Distance from the start of the message, bytes.
    pub offset: usize,
    /// Its size, bytes.
    pub bytes: usize,
    /// Type.
    pub scalar: Scalar,
}

/// A scalar's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// Bytes, printed as one hexadecimal number.
    Bytes(&'a [u8]),
    /// Unsigned.
    Unsigned(u64),
    /// Signed.
    Signed(i64),
    /// Floating point.
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
    #[must_use]
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

/// Makes the [`Layout`] of `$type` from the names of all its fields, in order.
macro_rules! layout {
    ($type:ident { $($field:ident),* $(,)? }) => {
        impl crate::Laid for $type {
            const LAYOUT: &'static crate::Layout = &crate::Layout {
                name: stringify!($type),
                type_name: concat!("timegap_msgs/msg/", stringify!($type)),
                bytes: core::mem::size_of::<$type>(),
                fields: &[$(crate::Field {
                    name: stringify!($field),
                    offset: core::mem::offset_of!($type, $field),
                    shape: crate::shape_of(|message: &$type| &message.$field),
                }),*],
            };
        }

        const _: () = <$type as crate::Laid>::LAYOUT.check();
    };
}
pub(crate) use layout;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Command, Message, RadarDetections, Spat, TOPICS, Topic};
    use bytemuck::Zeroable;
    use std::collections::BTreeSet;

    #[test]
    fn a_layout_is_the_struct() {
        for topic in TOPICS {
            let layout = topic.layout();
            let places = layout.scalars();
            let covered: usize = places.iter().map(|place| place.bytes).sum();
            assert_eq!(covered, layout.bytes, "{}: every byte belongs to a scalar", layout.name);
            let paths: BTreeSet<_> = places.iter().map(|place| &place.path).collect();
            assert_eq!(paths.len(), places.len(), "{}: paths are unique", layout.name);
        }
    }

    #[test]
    fn what_is_in_use_ends_with_the_last_element_that_counts() {
        let mut scan = RadarDetections::zeroed();
        let layout = Topic::RadarDetections.layout();
        let empty = size_of::<RadarDetections>() - size_of_val(&scan.detections);
        let whole = size_of::<RadarDetections>();
        for (count, bytes) in [(0, empty), (3, empty + 3 * 48), (1024, whole), (u64::MAX, whole)] {
            scan.count = count;
            assert_eq!(layout.bytes_in_use(bytemuck::bytes_of(&scan)), bytes, "{count}");
        }
        // A small one.
        let layout = Topic::Spat.layout();
        assert_eq!(layout.bytes_in_use(bytemuck::bytes_of(&Spat::zeroed())), size_of::<Spat>());
    }

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
