//! Campaign files that are compiled into the program.

/// A campaign compiled into the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Name, as given on the command line.
    pub name: &'static str,
    /// Its purpose, in one line.
    pub summary: &'static str,
    /// The campaign file.
    pub text: &'static str,
}

/// Every built-in campaign file.
pub const BUILTIN: [Builtin; 6] = [
    Builtin {
        name: "kills",
        summary: "1,000 SIGKILLs over all processes of a run, most of them in critical phases, in realtime",
        text: include_str!("../campaigns/kills.toml"),
    },
    Builtin {
        name: "messages",
        summary: "10,000 runs in lockstep, each with 2 to 4 seeded faults of messages of up to 20 s",
        text: include_str!("../campaigns/messages.toml"),
    },
    Builtin {
        name: "radio",
        summary: "2,000 drives through signals whose frames are lost, late and falsified",
        text: include_str!("../campaigns/radio.toml"),
    },
    Builtin {
        name: "restarts",
        summary: "1,000 SIGKILLs of services without a standby, each replaced at once",
        text: include_str!("../campaigns/restarts.toml"),
    },
    Builtin {
        name: "soak",
        summary: "half an hour of realtime with random kills: nothing grows",
        text: include_str!("../campaigns/soak.toml"),
    },
    Builtin {
        name: "takeovers",
        summary: "1,000 SIGKILLs of a controller with a standby, at control periods of 10 ms",
        text: include_str!("../campaigns/takeovers.toml"),
    },
];
