//! The scenarios that come with the program.

use crate::ScenarioError;
use crate::reading::problem::nearest;

/// A scenario compiled into the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    /// Name, as given on the command line.
    pub name: &'static str,
    /// The scenario file.
    pub text: &'static str,
}

macro_rules! builtins {
    ($($name:literal,)+) => {
        /// Every built-in scenario, in the order of `timegap list`.
        pub const ALL: &[Builtin] = &[$(Builtin {
            name: $name,
            text: include_str!(concat!("../scenarios/", $name, ".toml")),
        }),+];
    };
}

builtins! {
    "cacc-a", "cacc-b", "cacc-c", "cacc-table3", "following", "stop-and-go", "cut-in",
    "curved-following", "corridor", "udds", "hwfet", "us06", "wltc-3b", "six-mode",
    "quadratic-bounded-follow", "quadratic-bounded-depart", "quadratic-bounded-cut-in",
    "truck-hills", "truck-follow", "truck-traffic", "truck-brake", "tight-cut-in", "tight-brake",
}

impl Builtin {
    /// Its subject, in one line.
    pub fn summary(&self) -> &'static str {
        let described = self.text.lines().find_map(|line| line.strip_prefix("description = \""));
        described.map_or("", |text| text.trim_end_matches('"'))
    }
}

pub fn find(name: &str) -> Option<&'static Builtin> {
    ALL.iter().find(|builtin| builtin.name == name)
}

/// The error for a name that is neither built in nor a file.
pub(super) fn unknown(name: &str) -> ScenarioError {
    let names: Vec<&str> = ALL.iter().map(|builtin| builtin.name).collect();
    let expected = format!("a path to a scenario file or one of {}", names.join(", "));
    // Before the list, behind which it is not seen.
    let meant = nearest(name, names).map(|known| format!(" (did you mean {known}?)"));
    let message = "no built-in scenario and no file of this name".to_owned();
    ScenarioError::whole(name, message + &meant.unwrap_or_default()).expecting(expected)
}
