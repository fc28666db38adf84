//! The sources of a course that the study compares.

/// Sources of a course, as `[perception.course]` names them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sources {
    /// Name in tables.
    pub name: &'static str,
    /// The value of `perception.course.sources`.
    pub toml: &'static str,
}

/// The sources, each with all of the earlier ones.
pub const ALL: [Sources; 5] = [
    Sources { name: "straight", toml: "[]" },
    Sources { name: "yaw rate", toml: "[\"yaw-rate\"]" },
    Sources { name: "+ standing", toml: "[\"yaw-rate\", \"standing\"]" },
    JUDGED,
    Sources { name: "+ map", toml: "[\"yaw-rate\", \"standing\", \"trails\", \"map\"]" },
];

/// The ones that drive by default. Limits hold for them.
pub const JUDGED: Sources =
    Sources { name: "+ trails", toml: "[\"yaw-rate\", \"standing\", \"trails\"]" };
