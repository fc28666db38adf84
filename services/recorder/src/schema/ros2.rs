//! ROS 2 message definitions, as MCAP's schema encoding `ros2msg` wants them.

use super::collect;
use messages::{Element, Field, Layout, Scalar};
use std::fmt::Write;

/// ROS 2 package that the types are said to be of.
const PACKAGE: &str = "timegap_msgs";

/// The definition of `layout` with those of all types in it.
#[must_use]
pub fn definition(layout: &'static Layout) -> String {
    let mut structs = Vec::new();
    collect(layout, &mut structs);
    let mut text = fields(layout);
    for inner in structs.into_iter().rev().filter(|inner| inner.name != layout.name) {
        let rule = "=".repeat(80);
        write!(text, "{rule}\nMSG: {PACKAGE}/{}\n{}", inner.name, fields(inner))
            .expect("a string takes all");
    }
    text
}

fn fields(layout: &Layout) -> String {
    layout.fields.iter().map(|field| format!("{} {}\n", type_of(field), field.name)).collect()
}

fn type_of(field: &Field) -> String {
    let element = match field.shape.element {
        Element::Scalar(Scalar::U8) => "uint8".into(),
        Element::Scalar(Scalar::U32) => "uint32".into(),
        Element::Scalar(Scalar::U64) => "uint64".into(),
        Element::Scalar(Scalar::I64) => "int64".into(),
        Element::Scalar(Scalar::F64) => "float64".into(),
        // In full: readers take a bare `Header` for that of `std_msgs`.
        Element::Struct(layout) => format!("{PACKAGE}/{}", layout.name),
    };
    match field.shape.len {
        Some(len) => format!("{element}[{len}]"),
        None => element,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Topic;

    #[test]
    fn a_definition_brings_every_type_that_it_names() {
        let text = definition(Topic::Spat.layout());
        assert!(
            text.starts_with(
                "timegap_msgs/Header header\nuint64 count\ntimegap_msgs/Signal[8] signals\n="
            ),
            "{text}"
        );
        for inner in ["Header", "Origins", "Origin", "Signal", "Interval"] {
            assert_eq!(text.matches(&format!("MSG: timegap_msgs/{inner}\n")).count(), 1, "{inner}");
        }
        assert!(!text.contains("MSG: timegap_msgs/Spat"));
    }
}
