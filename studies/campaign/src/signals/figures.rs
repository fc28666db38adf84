//! Figures of a law over some corridors, and their columns.

use report::results::{Column, count, number};
use serde::Serialize;

use super::judge::Kept;

/// Figures of a law over some corridors.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Number of corridors.
    pub corridors: usize,
    /// Trip time beyond the fastest legal trip.
    pub excess_trip_s: Excess,
    /// The same at the last line.
    pub excess_at_last_line_s: Excess,
    /// Trip time beyond the fastest legal trip that stays behind the lead.
    pub excess_behind_lead_s: Excess,
    /// Share of the lines that were crossed in the first green that could be reached.
    pub greens_used: f64,
    /// Number of the other lines.
    pub greens_missed: usize,
    lines_not_passed: usize,
    stops_per_corridor: f64,
    energy_kwh_per_100km: f64,
    rms_jerk_mps3: f64,
    max_jerk_mps3: f64,
    emergency_brakings: u64,
}

/// Mean and 90th percentile of an excess, s.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Excess {
    /// Mean.
    pub mean: f64,
    /// 90th percentile.
    pub p90: f64,
}

impl Excess {
    fn of(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let place = ((0.9 * all.len() as f64).ceil() as usize).saturating_sub(1);
        Self { mean, p90: all.get(place).copied().unwrap_or(0.0) }
    }
}

impl Figures {
    /// The figures over these drives.
    pub fn of(runs: &[&Kept]) -> Self {
        let mean = |figure: &dyn Fn(&Kept) -> Option<f64>| {
            let figures: Vec<f64> = runs.iter().filter_map(|run| figure(run)).collect();
            figures.iter().sum::<f64>() / figures.len().max(1) as f64
        };
        let lines: usize = runs.iter().map(|run| run.lines).sum();
        let used: usize = runs.iter().map(|run| run.greens_used).sum();
        Self {
            corridors: runs.len(),
            excess_trip_s: Excess::of(runs.iter().map(|run| run.excess_s).collect()),
            excess_at_last_line_s: Excess::of(
                runs.iter().map(|run| run.excess_at_line_s).collect(),
            ),
            excess_behind_lead_s: Excess::of(
                runs.iter().map(|run| run.excess_behind_lead_s).collect(),
            ),
            greens_used: used as f64 / lines.max(1) as f64,
            greens_missed: lines - used,
            lines_not_passed: runs.iter().map(|run| run.not_passed).sum(),
            stops_per_corridor: mean(&|run| Some(run.stops as f64)),
            energy_kwh_per_100km: mean(&|run| run.energy_kwh_per_100km),
            rms_jerk_mps3: mean(&|run| run.rms_jerk_mps3),
            max_jerk_mps3: runs.iter().filter_map(|run| run.max_jerk_mps3).fold(0.0, f64::max),
            emergency_brakings: runs.iter().map(|run| run.interventions).sum(),
        }
    }
}

/// Columns of a law's figures, at a path below its row: `free.` for example.
pub fn columns<R>(below: &str) -> Vec<Column<R>> {
    let all = [
        count("corridors", "corridors", "Corridors").hidden(),
        number(
            "excess_trip_s.mean",
            "trip over the fastest",
            "s",
            2,
            "Mean trip time beyond the fastest legal trip",
        )
        .less(),
        number("excess_trip_s.p90", "90th percentile", "s", 2, "90th percentile of it").less(),
        number("excess_at_last_line_s.mean", "", "s", 2, "The same mean at the last line").hidden(),
        number("excess_at_last_line_s.p90", "", "s", 2, "90th percentile of it").hidden(),
        number(
            "excess_behind_lead_s.mean",
            "over the fastest behind the lead",
            "s",
            2,
            "Mean trip time beyond the fastest legal trip that stays behind the lead",
        )
        .less(),
        number("excess_behind_lead_s.p90", "", "s", 2, "90th percentile of it").hidden(),
        number(
            "greens_used",
            "greens used",
            "",
            2,
            "Share of the lines that were crossed in the first green that could be reached",
        )
        .more(),
        count("greens_missed", "greens missed", "Lines that were not").less(),
        count("lines_not_passed", "lines not passed", "Lines that were not passed before the end")
            .weight(2),
        number("stops_per_corridor", "stops per corridor", "", 2, "Mean number of standstills")
            .less()
            .weight(1),
        number("energy_kwh_per_100km", "wheels", "kWh/100 km", 2, "Mean energy at the wheels")
            .less()
            .weight(1),
        number("rms_jerk_mps3", "jerk rms", "m/s³", 3, "Mean root mean square of the jerk")
            .less()
            .weight(1),
        number("max_jerk_mps3", "max jerk", "m/s³", 1, "Largest magnitude of the jerk")
            .less()
            .weight(2),
        count("emergency_brakings", "emergency brakings", "Interventions of the emergency brake")
            .less()
            .weight(1),
    ];
    let at_path = |column: Column<R>| {
        let (name, heading) = (column.head.name.to_string(), column.head.heading.to_string());
        column.named(format!("{below}{name}"), heading)
    };
    all.into_iter().map(at_path).collect()
}
