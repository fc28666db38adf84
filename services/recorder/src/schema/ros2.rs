//! ROS 2 message definitions: in the form of MCAP's schema encoding `ros2msg`, and as a package.

use super::{all, collect, law};
use crate::LawNames;
use messages::names::{self, Enumeration};
use messages::{Element, Field, LAYOUT_VERSION, Layout, Scalar};
use std::fmt::Write;
use xxhash_rust::xxh3::Xxh3;

/// ROS 2 package that the types are said to be of.
const PACKAGE: &str = "timegap_msgs";

/// The definition of `layout` with those of all types in it. Comments give meanings and units, and constants named
/// numbers.
pub fn definition(layout: &'static Layout) -> String {
    definition_of(layout, &LawNames::default())
}

/// As [`definition`], with the names of a law's modes, reasons and figures.
pub(crate) fn definition_of(layout: &'static Layout, law: &LawNames) -> String {
    let mut structs = Vec::new();
    collect(layout, &mut structs);
    let mut text = fields(layout, law);
    for inner in structs.into_iter().rev().filter(|inner| inner.name != layout.name) {
        let rule = "=".repeat(80);
        write!(text, "{rule}\nMSG: {PACKAGE}/{}\n{}", inner.name, fields(inner, law))
            .expect("a string takes all");
    }
    text
}

/// A number that two definitions share if their fields are the same, whatever their comments, constants
/// and spaces.
pub(crate) fn fingerprint(definition: &str) -> u64 {
    let mut hash = Xxh3::new();
    for line in definition.lines() {
        let line = line.split_once('#').map_or(line, |(line, _)| line);
        if line.contains('=') && !line.starts_with("==") {
            continue;
        }
        for word in line.split_whitespace() {
            hash.update(word.as_bytes());
            hash.update(b" ");
        }
    }
    hash.digest()
}

/// The files of a ROS 2 package with all messages and the records of a law: name below the package's folder, and text.
pub fn package() -> Vec<(String, String)> {
    let law = LawNames::default();
    let mut files = vec![
        ("package.xml".to_owned(), package_xml()),
        ("CMakeLists.txt".to_owned(), cmake_lists()),
    ];
    let message = |layout: &&Layout| (format!("msg/{}.msg", layout.name), fields(layout, &law));
    files.extend(all().iter().chain(&law::all()).map(message));
    files
}

fn package_xml() -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<package format=\"3\">\n  <name>{PACKAGE}</name>\n  \
         <version>{LAYOUT_VERSION}.0.0</version>\n  <description>Messages of timegap, layout version \
         {LAYOUT_VERSION}</description>\n  <maintainer email=\"timegap@example.org\">timegap\
         </maintainer>\n  <license>MIT</license>\n  <license>Apache-2.0</license>\n  \
         <buildtool_depend>ament_cmake</buildtool_depend>\n  \
         <buildtool_depend>rosidl_default_generators</buildtool_depend>\n  \
         <exec_depend>rosidl_default_runtime</exec_depend>\n  \
         <member_of_group>rosidl_interface_packages</member_of_group>\n  <export>\n    \
         <build_type>ament_cmake</build_type>\n  </export>\n</package>\n"
    )
}

fn cmake_lists() -> String {
    let messages: String = (all().iter().chain(&law::all()))
        .map(|layout| format!("  \"msg/{}.msg\"\n", layout.name))
        .collect();
    format!(
        "cmake_minimum_required(VERSION 3.8)\nproject({PACKAGE})\n\nfind_package(ament_cmake REQUIRED)\n\
         find_package(rosidl_default_generators REQUIRED)\n\nrosidl_generate_interfaces(\
         ${{PROJECT_NAME}}\n{messages})\n\nament_export_dependencies(rosidl_default_runtime)\n\
         ament_package()\n"
    )
}

fn fields(layout: &Layout, law: &LawNames) -> String {
    let mut text = String::new();
    for field in layout.fields {
        writeln!(text, "# {}", plain(&field.meaning())).expect("a string takes all");
        if layout.name == "Diagnostics" || layout.name == "Command" {
            text.push_str(&of_law(field.name, law));
        }
        if let Some(enumeration) = names::of_field(layout.name, field.name) {
            text.push_str(&constants(enumeration, &type_of(field)));
        }
        let unit =
            names::unit_of(field.name).map_or_else(String::new, |unit| format!("  # {unit}"));
        writeln!(text, "{} {}{unit}", type_of(field), field.name).expect("a string takes all");
    }
    text
}

/// A documentation comment without its links and marks.
fn plain(comment: &str) -> String {
    comment.replace("`]", "").replace(['[', ']', '`'], "")
}

/// Viewers show the constants right before a field as the names of its numbers.
fn constants(enumeration: &Enumeration, type_name: &str) -> String {
    let prefix = enumeration.name.to_uppercase();
    let line = |(number, name): &(u32, &str)| {
        let name = name.to_uppercase().replace('-', "_");
        format!("{type_name} {prefix}_{name}={number}\n")
    };
    enumeration.values.iter().map(line).collect()
}

/// Meaning of the numbers in a field that the law defines.
fn of_law(field: &str, law: &LawNames) -> String {
    let numbered = |prefix: &str, names: &[String]| -> String {
        let word =
            |name: &str| name.to_uppercase().replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        let lines = names.iter().enumerate();
        lines.map(|(number, name)| format!("uint32 {prefix}_{}={number}\n", word(name))).collect()
    };
    match field {
        "mode" => numbered("MODE", &law.modes),
        "mode_reason" => numbered("REASON", &law.reasons),
        "figures" => {
            let figures = law.figures.iter().enumerate();
            figures
                .map(|(index, figure)| {
                    format!("# figures[{index}]: {}, {}\n", figure.name, figure.unit)
                })
                .collect()
        }
        _ => String::new(),
    }
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
        let bare = |text: &str| {
            let lines = text.lines().map(|line| line.split('#').next().unwrap_or("").trim());
            lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
        };
        assert!(
            bare(&text).starts_with(
                "timegap_msgs/Header header\nuint64 count\ntimegap_msgs/Signal[8] signals\n="
            ),
            "{text}"
        );
        for inner in ["Header", "Origins", "Origin", "Signal", "Interval"] {
            assert_eq!(text.matches(&format!("MSG: timegap_msgs/{inner}\n")).count(), 1, "{inner}");
        }
        assert!(!text.contains("MSG: timegap_msgs/Spat"));
        assert!(
            text.contains("# Likely end, s of run time.\nfloat64 likely_end_s  # s\n"),
            "{text}"
        );
        assert!(text.contains("uint32 PHASE_STOP_AND_REMAIN=3\n"), "{text}");
    }

    #[test]
    fn the_names_of_a_law_are_constants_and_comments() {
        let law = LawNames {
            modes: vec!["idle".into(), "follow lead".into()],
            reasons: vec!["none".into()],
            figures: vec![crate::FigureName { name: "gap_error_m".into(), unit: "m".into() }],
        };
        let text = definition_of(Topic::Diagnostics.layout(), &law);
        for line in
            ["uint32 MODE_FOLLOW_LEAD=1", "uint32 REASON_NONE=0", "# figures[0]: gap_error_m, m"]
        {
            assert!(text.contains(&format!("\n{line}\n")), "{line}: {text}");
        }
        // Their names do not change their type.
        assert_eq!(fingerprint(&text), fingerprint(&definition(Topic::Diagnostics.layout())));
    }

    #[test]
    fn a_fingerprint_is_of_the_fields_alone() {
        let fields = "uint32 a\nfloat64[4] b\n";
        let same = "# What it is.\nuint32 A_ONE=1\nuint32   a  # m\n\nfloat64[4] b";
        assert_eq!(fingerprint(fields), fingerprint(same));
        assert_ne!(fingerprint(fields), fingerprint("uint32 a\nfloat64[5] b\n"));
        assert_ne!(fingerprint(fields), fingerprint("uint32 b\nfloat64[4] a\n"));
    }
}
