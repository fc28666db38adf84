//! `[v2x.preview]`: the maps of the road ahead, of grades and of curves, and what is wrong with them.

use scenario_derive::tables;

use crate::quantity::{Distance, MapShift, Percent};

tables! {
    /// Faults of the maps. Without any they are exact.
    #[derive(Copy)]
    pub struct Preview {
        /// Distance by which everything on the maps is too far ahead, m.
        pub shift_m: MapShift = 0.0,
        /// Standard deviation of an error of each cell, made from the run's seed. A grade's is in percentage points, a
        /// curvature's in percent of it.
        pub noise_percent: Percent = 0.0,
        /// End of the maps, m; absent: they have no end.
        pub ends_at_m: Option<Distance>,
    }
}
