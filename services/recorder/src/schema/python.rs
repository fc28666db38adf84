//! Python: `ctypes` structures that the `iceoryx2` package can subscribe to.

use super::all;
use messages::{Element, Field, LAYOUT_VERSION, Layout, Scalar, TOPICS};
use std::fmt::Write;

/// A Python module with a `ctypes.Structure` per struct and the type of each topic.
pub fn module() -> String {
    let mut text = format!(
        "\"\"\"Messages of timegap, layout version {LAYOUT_VERSION}: made by `timegap print layouts \
         --python`.\n\nEach class has the layout of the Rust struct of its name.\n\"\"\"\n\nimport \
         ctypes\n\nLAYOUT_VERSION = \"{LAYOUT_VERSION}\"\n"
    );
    let out = &mut text;
    for layout in all() {
        out.push_str(&class(layout));
    }
    out.push_str("\nTOPICS = {\n");
    for topic in TOPICS {
        writeln!(out, "    \"{}\": {},", topic.name(), topic.layout().name)
            .expect("a string takes all");
    }
    out.push_str("}\n");
    text
}

pub(super) fn class(layout: &Layout) -> String {
    let fields: String = layout
        .fields
        .iter()
        .map(|field| format!("        (\"{}\", {}),\n", field.name, type_of(field)))
        .collect();
    format!(
        "\n\nclass {}(ctypes.Structure):\n    _fields_ = [\n{fields}    ]\n\n    @staticmethod\n    \
         def type_name() -> str:\n        return \"{}\"\n\n\nassert ctypes.sizeof({0}) == {}\n",
        layout.name, layout.type_name, layout.bytes
    )
}

fn type_of(field: &Field) -> String {
    let element = match field.shape.element {
        Element::Scalar(Scalar::U8) => "ctypes.c_uint8",
        Element::Scalar(Scalar::U32) => "ctypes.c_uint32",
        Element::Scalar(Scalar::U64) => "ctypes.c_uint64",
        Element::Scalar(Scalar::I64) => "ctypes.c_int64",
        Element::Scalar(Scalar::F64) => "ctypes.c_double",
        Element::Struct(layout) => layout.name,
    };
    match field.shape.len {
        Some(len) => format!("{element} * {len}"),
        None => element.into(),
    }
}
