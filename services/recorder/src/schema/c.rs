//! C: a header whose structs are the messages' bytes, with assertions of that.

use super::all;
use messages::{Element, Field, LAYOUT_VERSION, Layout, Scalar, TOPICS};
use std::fmt::Write;

/// A C11 header with a struct per message and each topic's name.
pub fn header() -> String {
    let mut text = format!(
        "/* Messages of timegap, layout version {LAYOUT_VERSION}: made by `timegap print layouts --c`. */\n\
         #ifndef TIMEGAP_MESSAGES_H\n#define TIMEGAP_MESSAGES_H\n\n#include <assert.h>\n#include \
         <stddef.h>\n#include <stdint.h>\n\n#define TIMEGAP_LAYOUT_VERSION \"{LAYOUT_VERSION}\"\n"
    );
    let out = &mut text;
    for topic in TOPICS {
        let name = topic.name();
        let constant = name.to_uppercase().replace('/', "_");
        writeln!(out, "#define TIMEGAP_TOPIC_{constant} \"{name}\"").expect("a string takes all");
    }
    for layout in all() {
        out.push_str(&structure(layout));
    }
    out.push_str("\n#endif\n");
    text
}

/// One struct, and assertions that it has the message's bytes.
pub(super) fn structure(layout: &Layout) -> String {
    let name = layout.name;
    let fields: String = layout.fields.iter().map(member).collect();
    let mut text = format!(
        "\n/* \"{}\" */\ntypedef struct Timegap{name} {{\n{fields}}} Timegap{name};\n\
         static_assert(sizeof(Timegap{name}) == {}, \"size of {name}\");\n",
        layout.type_name, layout.bytes
    );
    for field in layout.fields {
        writeln!(
            text,
            "static_assert(offsetof(Timegap{name}, {}) == {}, \"{name}.{0}\");",
            field.name, field.offset
        )
        .expect("a string takes all");
    }
    text
}

fn member(field: &Field) -> String {
    let element = match field.shape.element {
        Element::Scalar(Scalar::U8) => "uint8_t".into(),
        Element::Scalar(Scalar::U32) => "uint32_t".into(),
        Element::Scalar(Scalar::U64) => "uint64_t".into(),
        Element::Scalar(Scalar::I64) => "int64_t".into(),
        Element::Scalar(Scalar::F64) => "double".into(),
        Element::Struct(layout) => format!("Timegap{}", layout.name),
    };
    let len = field.shape.len.map_or_else(String::new, |len| format!("[{len}]"));
    format!("    {element} {}{len};\n", field.name)
}
