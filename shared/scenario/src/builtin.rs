//! The scenarios that come with the program.

use crate::ScenarioError;
use crate::reading::words::nearest;

/// A scenario compiled into the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Builtin {
    /// Name, as given on the command line.
    pub name: &'static str,
    /// Its subject, in one line.
    pub summary: &'static str,
    /// The scenario file.
    pub text: &'static str,
}

macro_rules! builtins {
    ($($name:literal: $summary:literal;)+) => {
        /// Every built-in scenario, in the order of `timegap list`.
        pub const ALL: &[Builtin] = &[$(Builtin {
            name: $name,
            summary: $summary,
            text: include_str!(concat!("../scenarios/", $name, ".toml")),
        }),+];
    };
}

builtins! {
    "cacc-a": "CACC paper, scenario A: through on green behind a lead at constant speed";
    "cacc-b": "CACC paper, scenario B: through on green behind an oscillating lead";
    "cacc-c": "CACC paper, scenario C: a standing lead starts when the light turns green";
    "cacc-table3": "CACC paper, Table 3: from standstill through the end of a green";
    "following": "plain following behind a lead of varying speed, seen by a noisy radar";
    "stop-and-go": "a lead in congested traffic, down to standstill and off again";
    "cut-in": "a slower car cuts in close ahead and later out again before a slow lorry";
    "curved-following": "an S-curve behind a lead, with a vehicle on either side";
    "corridor": "three signals in sequence behind a lead";
    "udds": "following a lead that drives UDDS: 23 minutes of urban traffic";
    "hwfet": "following a lead that drives HWFET: 13 minutes of rural road";
    "us06": "following a lead that drives US06: 10 minutes of hard accelerations and braking";
    "wltc-3b": "following a lead that drives WLTC class 3b: 30 minutes, town to motorway";
    "six-mode": "six-mode paper: a lead that brakes, then a car that cuts in and stops";
    "quadratic-bounded-follow":
        "quadratic-bounded paper: a slower lead comes into range, then speeds up";
    "quadratic-bounded-depart":
        "quadratic-bounded paper: a lead drives away until the set speed is reached";
    "quadratic-bounded-cut-in":
        "quadratic-bounded paper: a slower car moves into the path 150 m ahead";
    "truck-hills":
        "predictive paper: a 49 t truck on ten kilometres of hills, planning two ahead";
    "truck-follow": "predictive paper: following over a valley, the lead brakes uphill";
    "truck-traffic": "a 49 t truck on hills behind a lead whose speed goes up and down";
    "truck-brake": "a 49 t truck downhill behind a lead that brakes to standstill at 6 m/s²";
    "tight-cut-in": "a car cuts in 10 m/s slower and brakes to standstill: 6 m/s² in time just avoids it";
    "tight-brake": "a lead at a short gap brakes to standstill with 8 m/s²: 6 m/s² in time just avoids it";
}

/// The built-in scenario of that name.
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
