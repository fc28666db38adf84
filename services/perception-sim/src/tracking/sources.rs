//! Sources of the course ([`super::road_ahead`]).

/// Sources of the course that are in use; without any the path is straight ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// Yaw rate of the ego, and the slip angle that follows from it.
    pub yaw_rate: bool,
    /// Standing objects beside the road.
    pub standing: bool,
    /// Trails of other vehicles.
    pub trails: bool,
    /// Curvatures of the map.
    pub map: bool,
}

impl Sources {
    /// One of them shows the road ahead of the ego. The yaw rate alone makes a circle.
    pub fn looks_ahead(&self) -> bool {
        self.standing || self.trails || self.map
    }
}

/// Curvatures of the map ahead.
#[derive(Clone, Copy, Debug)]
pub struct MapAhead<'a> {
    /// Curvatures of cells in a row, 1/m.
    pub curvatures_perm: &'a [f64],
    /// Distance of the first cell's middle ahead of the bumper, m; it may be behind.
    pub first_m: f64,
    /// Length of a cell, m.
    pub cell_m: f64,
}

impl MapAhead<'_> {
    /// Curvature at a distance ahead, 1/m; `None` of an empty map.
    pub fn curvature_perm(&self, ahead_m: f64) -> Option<f64> {
        let place = (ahead_m - self.first_m) / self.cell_m;
        let below = place.floor().clamp(0.0, (self.curvatures_perm.len().max(1) - 1) as f64);
        let share = (place - below).clamp(0.0, 1.0);
        let cell = |index: usize| self.curvatures_perm.get(index).copied();
        let low = cell(below as usize)?;
        Some(low + share * (cell(below as usize + 1).unwrap_or(low) - low))
    }
}
