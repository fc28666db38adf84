//! The layouts of all messages in the languages of those who read them.

mod c;
mod law;
mod python;
mod ros2;

pub use c::header as c_header;
pub use law::{all as law_records, c_header as law_c_header, python_module as law_python_module};
pub use python::module as python_module;
pub use ros2::definition as ros2_definition;
pub use ros2::package as ros2_package;
pub(crate) use ros2::{definition_of as ros2_definition_of, fingerprint};

use messages::{Element, Layout, TOPICS};

/// All structs that the messages are made of, each after those that it contains.
pub fn all() -> Vec<&'static Layout> {
    let mut found = Vec::new();
    for topic in TOPICS {
        collect(topic.layout(), &mut found);
    }
    found
}

/// `layout` and what it contains, each after those that it contains, without duplicates.
fn collect(layout: &'static Layout, into: &mut Vec<&'static Layout>) {
    for field in layout.fields {
        if let Element::Struct(inner) = field.shape.element {
            collect(inner, into);
        }
    }
    if !into.iter().any(|known| known.name == layout.name) {
        into.push(layout);
    }
}
