//! The false senders of the table.

/// A fault: its kind, its size, the scenario, the keys, and the earliest and latest time of its start, s.
pub type Case = (&'static str, &'static str, &'static str, &'static str, f64, f64);

/// Keys of a sender that repeats its message, but for its topic.
pub const FREEZE: &str = "kind = \"freeze\", for_s = 10, topic = ";
/// Keys of a sender with a wrong figure, but for its topic and field.
pub const BIAS: &str = "kind = \"bias\", for_s = 10, topic = ";

/// The false senders.
pub const CASES: [Case; 20] = [
    ("odometry frozen", "driving", "following", "\"vehicle/odometry\"", 5.0, 40.0),
    ("odometry frozen", "standing", "stop-and-go", "\"vehicle/odometry\"", 13.0, 17.0),
    (
        "speed biased",
        "+0.3 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 0.3",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "+1 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 1",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "+3 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 3",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "-3 m/s",
        "following",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = -3",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "-5 m/s",
        "corridor",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = -5",
        5.0,
        40.0,
    ),
    (
        "speed biased",
        "+5 m/s, truck",
        "truck-follow",
        "\"vehicle/odometry\", field = \"speed_mps\", amount = 5",
        5.0,
        40.0,
    ),
    ("radar frozen", "following", "following", "\"radar/tracks\"", 5.0, 40.0),
    ("radar frozen", "stop-and-go", "stop-and-go", "\"radar/tracks\"", 5.0, 80.0),
    ("radar frozen", "object list", "truck-follow", "\"radar/tracks\"", 5.0, 80.0),
    (
        "gap biased",
        "+2 m",
        "stop-and-go",
        "\"radar/tracks\", field = \"gap_m\", amount = 2",
        5.0,
        80.0,
    ),
    (
        "gap biased",
        "+5 m",
        "stop-and-go",
        "\"radar/tracks\", field = \"gap_m\", amount = 5",
        5.0,
        80.0,
    ),
    (
        "gap biased",
        "-5 m",
        "following",
        "\"radar/tracks\", field = \"gap_m\", amount = -5",
        5.0,
        40.0,
    ),
    (
        "relative speed biased",
        "+1 m/s",
        "stop-and-go",
        "\"radar/tracks\", field = \"relative_speed_mps\", amount = 1",
        5.0,
        80.0,
    ),
    (
        "relative speed biased",
        "+3 m/s",
        "stop-and-go",
        "\"radar/tracks\", field = \"relative_speed_mps\", amount = 3",
        5.0,
        80.0,
    ),
    (
        "countdown biased",
        "-0.5 s",
        "corridor",
        "\"v2x/spat\", field = \"end_s\", amount = -0.5",
        5.0,
        90.0,
    ),
    (
        "countdown biased",
        "-2 s",
        "corridor",
        "\"v2x/spat\", field = \"end_s\", amount = -2",
        5.0,
        90.0,
    ),
    (
        "countdown biased",
        "+2 s",
        "corridor",
        "\"v2x/spat\", field = \"end_s\", amount = 2",
        5.0,
        90.0,
    ),
    ("countdown frozen", "", "corridor", "\"v2x/spat\"", 5.0, 90.0),
];
