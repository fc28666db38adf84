//! The layout of every message as data, made from the declaration of its struct.
//!
//! [`layout!`](self) takes a struct and derives three things from it. These are the struct itself as `repr(C)` plain
//! data, its [`Layout`], and the meaning of each field from its doc comment. The compiler refuses a struct with
//! padding, or one whose bytes are not its CDR body. Every view of a message reads the [`Layout`]. The views are the
//! schema in a recording, Python and C types, the columns of a CSV file, and the reference of the messages.
//!
//! ```
//! use messages::{Element, Scalar, Topic};
//!
//! let layout = Topic::Heartbeat.layout();
//! let cycles = layout.fields[1];
//! assert_eq!((cycles.name, cycles.offset), ("cycles", 208));
//! assert_eq!(cycles.shape.element, Element::Scalar(Scalar::U64));
//! assert_eq!(cycles.meaning(), "Cycles done so far.");
//! ```

use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

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
    Scalar(Scalar),
    Struct(&'static Layout),
}

impl Element {
    /// Name: `u8`, `f64` and the like, or the struct's.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scalar(Scalar::U8) => "u8",
            Self::Scalar(Scalar::U32) => "u32",
            Self::Scalar(Scalar::U64) => "u64",
            Self::Scalar(Scalar::I64) => "i64",
            Self::Scalar(Scalar::F64) => "f64",
            Self::Struct(layout) => layout.name,
        }
    }

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
    pub element: Element,
    /// Elements of an array; `None` for a single one.
    pub len: Option<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name, with its unit.
    pub name: &'static str,
    /// Distance from the start of the struct, bytes.
    pub offset: usize,
    pub shape: Shape,
    /// Lines of the doc comment in the declaration.
    pub comment: &'static [&'static str],
}

impl Field {
    pub fn meaning(&self) -> String {
        self.comment.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
    }
}

/// Largest message that its readers copy, and of which every byte is protected, bytes.
pub const SMALL_BYTES: usize = 4 << 10;

#[derive(Debug, PartialEq, Eq)]
pub struct Layout {
    /// Name without its package.
    pub name: &'static str,
    /// Name on the topics and in recordings, `timegap_msgs/msg/Name`.
    pub type_name: &'static str,
    pub bytes: usize,
    pub fields: &'static [Field],
}

/// A struct whose layout is known as data.
pub trait Laid: ZeroCopySend {
    const LAYOUT: &'static Layout;
}

pub trait FieldType {
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

impl Layout {
    /// Alignment of every struct, bytes.
    pub const ALIGNMENT: usize = 8;

    /// Checks that the struct's bytes are its CDR body: fields in order without gaps, and each scalar on a multiple of
    /// its size.
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

    /// Bytes from the start of `message` that are in use, which its end-to-end protection covers. A struct larger than
    /// [`SMALL_BYTES`] may end with `count` and an array. The bytes in use then end with the first `count` elements of
    /// that array. Else all bytes are in use.
    ///
    /// # Panics
    /// If `message` is shorter than the struct.
    #[inline]
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
}

/// Declares structs of fixed layout, each with its name on the wire: `pub struct Name "wire" { fields }`. A `message`
/// begins with the header. `lists entries: Entry` names an array of which `count` entries are valid, and makes the
/// reader that has the array's name.
macro_rules! layout {
    () => {};
    ($(#[$about:meta])* pub message $type:ident $type_name:literal
        $(lists $($entries:ident: $entry:ty),+)? { $($fields:tt)* } $($rest:tt)*) => {
        layout! {
            $(#[$about])*
            pub struct $type $type_name $(lists $($entries: $entry),+)? {
                /// Common header.
                pub header: crate::Header,
                $($fields)*
            }
            $($rest)*
        }
    };
    ($(#[$about:meta])* pub struct $type:ident $type_name:literal
        $(lists $($entries:ident: $entry:ty),+)? {
        $($(#[doc = $comment:literal])* pub $field:ident: $of:ty,)*
    } $($rest:tt)*) => {
        $(#[$about])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
        #[type_name($type_name)]
        pub struct $type {
            $($(#[doc = $comment])* pub $field: $of,)*
        }

        $(impl $type {
            $(#[doc = concat!("The valid entries of `", stringify!($entries), "`.")]
            pub fn $entries(&self) -> &[$entry] {
                let count = usize::try_from(self.count).unwrap_or(usize::MAX);
                &self.$entries[..count.min(self.$entries.len())]
            })+
        })?

        impl crate::Laid for $type {
            const LAYOUT: &'static crate::Layout = &crate::Layout {
                name: stringify!($type),
                type_name: $type_name,
                bytes: size_of::<$type>(),
                fields: &[$(crate::Field {
                    name: stringify!($field),
                    offset: core::mem::offset_of!($type, $field),
                    shape: <$of as crate::layout::FieldType>::SHAPE,
                    comment: &[$($comment),*],
                }),*],
            };
        }

        const _: () = <$type as crate::Laid>::LAYOUT.check();

        layout! { $($rest)* }
    };
}

/// Names that a file with [`layout!`](self) needs.
pub(crate) mod declare {
    pub(crate) use super::layout;
    pub(crate) use bytemuck::{Pod, Zeroable};
    pub(crate) use iceoryx2_bb_derive_macros::ZeroCopySend;
    pub(crate) use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
}
pub(crate) use layout;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RadarDetections, Spat, TOPICS, Topic};
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
    fn every_field_has_a_meaning_and_every_type_its_name_on_the_topics() {
        fn check(layout: &Layout) {
            assert_eq!(layout.type_name, format!("timegap_msgs/msg/{}", layout.name));
            for field in layout.fields {
                assert!(!field.meaning().is_empty(), "{}.{}", layout.name, field.name);
                if let Element::Struct(inner) = field.shape.element {
                    check(inner);
                }
            }
        }
        TOPICS.into_iter().for_each(|topic| check(topic.layout()));
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
}
