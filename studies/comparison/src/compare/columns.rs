//! The columns of a comparison, written once for the terminal and for the page.

use super::Row;
use report::chart::number;
use report::print;
use report::table::NONE;

/// A column: its heading with the unit, and its cell in a row; none where it does not apply.
pub struct Column {
    /// Heading.
    pub heading: &'static str,
    /// Whether a narrow page leaves it out.
    pub more: bool,
    /// The cell.
    of: fn(&Row) -> Option<String>,
}

/// All columns after controller and outcome, in their order.
static ALL: [Column; 17] = [
    first("min gap, m", |row| figure(row.control.figures.min_gap_m.map(|gap| gap.max(0.0)), 1)),
    first("min time gap, s", |row| figure(row.control.following.min_time_gap_s, 2)),
    first("median time gap, s", |row| figure(row.control.following.median_time_gap_s, 2)),
    first("min TTC, s", |row| figure(row.control.figures.min_ttc_s, 1)),
    first("emergency brakings", |row| row.aebs.interventions.map(|times| times.to_string())),
    more("trip over the fastest legal, s", |row| {
        let trip = &row.control.trip;
        let (time_s, fastest_s) = trip.trip_time_s.zip(trip.fastest_legal_trip_s)?;
        Some(number(time_s - fastest_s, 1))
    }),
    more("gap error rms, m", |row| figure(row.control.figures.rms_gap_error_m, 2)),
    more("gap error at the end, m", |row| figure(row.control.figures.final_gap_error_m, 1)),
    more("acceleration, m/s²", |row| {
        let figures = &row.control.figures;
        let (low, high) = figures.min_accel_mps2.zip(figures.max_accel_mps2)?;
        Some(format!("{} to {}", number(low, 2), number(high, 2)))
    }),
    more("jerk rms, m/s³", |row| figure(row.control.figures.rms_jerk_mps3, 2)),
    more("max jerk, m/s³", |row| figure(row.control.figures.max_abs_jerk_mps3, 1)),
    more("fuel, L/100 km", |row| figure(row.control.figures.fuel_l_per_100km, 2)),
    more("wheels, kWh/100 km", |row| figure(row.control.figures.wheel_energy_kwh_per_100km, 2)),
    more("stops", |row| row.control.figures.stops.map(|stops| stops.to_string())),
    more("law p50", |row| row.timing.solve_us.map(|p| print::duration(p.p50))),
    more("law p99", |row| row.timing.solve_us.map(|p| print::duration(p.p99))),
    more("deadlines missed", |row| row.timing.deadline_misses.map(|misses| misses.to_string())),
];

const fn first(heading: &'static str, of: fn(&Row) -> Option<String>) -> Column {
    Column { heading, more: false, of }
}

const fn more(heading: &'static str, of: fn(&Row) -> Option<String>) -> Column {
    Column { heading, more: true, of }
}

fn figure(value: Option<f64>, decimals: usize) -> Option<String> {
    value.map(|value| number(value, decimals))
}

impl Column {
    /// The cell of a row.
    pub fn cell(&self, row: &Row) -> String {
        (self.of)(row).unwrap_or_else(|| NONE.to_owned())
    }
}

/// The columns that have a figure in one of `rows` at least.
pub fn shown(rows: &[Row]) -> Vec<&'static Column> {
    ALL.iter().filter(|column| rows.iter().any(|row| (column.of)(row).is_some())).collect()
}
