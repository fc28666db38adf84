//! Tables of speeds over time, among them the standard drive cycles: what the lead does where a regulation says how fast
//! a vehicle drives.

use scenario_derive::tables;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

use crate::quantity::{Speed, Time};
use crate::schema::Schema;

/// A point of a speed table: `[time_s, speed_mps]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(expecting = "a point [time_s, speed_mps]")]
pub struct SpeedPoint(pub Time, pub Speed);

tables! {
    /// A standard drive cycle: speed over time, one point each second.
    pub enum Cycle {
        /// UDDS (FTP-72), United States: urban.
        Udds,
        /// HWFET, United States: rural road.
        Hwfet,
        /// US06, United States: hard motorway driving.
        Us06,
        /// WLTC class 3b, UN GTR 15: urban to motorway.
        #[serde(rename = "wltc-3b")]
        Wltc3b,
    }
}

impl Cycle {
    /// The points, from time 0.
    pub fn points(self) -> &'static [SpeedPoint] {
        static TABLES: [OnceLock<Vec<SpeedPoint>>; 4] = [const { OnceLock::new() }; 4];
        let text = match self {
            Self::Udds => include_str!("../../cycles/udds.txt"),
            Self::Hwfet => include_str!("../../cycles/hwfet.txt"),
            Self::Us06 => include_str!("../../cycles/us06.txt"),
            Self::Wltc3b => include_str!("../../cycles/wltc-3b.txt"),
        };
        TABLES[self as usize].get_or_init(|| parse(text))
    }
}

/// Reads speeds separated by white space; lines that begin with `#` are comments.
fn parse(text: &str) -> Vec<SpeedPoint> {
    let speeds = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(str::split_whitespace)
        .map(|speed| speed.parse().expect("a table that comes with the program holds numbers"));
    (0..)
        .zip(speeds)
        .map(|(second, speed)| SpeedPoint(Time::of(f64::from(second)), Speed::of(speed)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cycle_has_its_duration_length_and_highest_speed() {
        for (cycle, duration_s, distance_m, highest_mps) in [
            (Cycle::Udds, 1369.0, 11_990.0, 25.35),
            (Cycle::Hwfet, 765.0, 16_507.0, 26.78),
            (Cycle::Us06, 600.0, 12_888.0, 35.90),
            (Cycle::Wltc3b, 1800.0, 23_266.0, 36.47),
        ] {
            let points = cycle.points();
            let name = cycle.name();
            let speed = |point: &SpeedPoint| point.1.value();
            assert_eq!(points.last().map(|point| point.0.value()), Some(duration_s), "{name}");
            assert_eq!((speed(&points[0]), points.last().map(speed)), (0.0, Some(0.0)), "{name}");
            let driven_m: f64 = points.iter().map(speed).sum();
            assert!((driven_m - distance_m).abs() < 1.0, "{name}: {driven_m} m");
            let highest = points.iter().map(speed).fold(0.0, f64::max);
            assert!((highest - highest_mps).abs() < 0.01, "{name}: {highest} m/s");
        }
    }
}
