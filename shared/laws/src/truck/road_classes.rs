//! The road ahead as segments: steps 1 and 2 of the published planner.
//!
//! The limit grades are those that full load and drag hold at the set speed. Cells of 50 m are classed by them. Equal
//! neighbours merge at their length-weighted slope, which keeps the height. A stretch shorter than 150 m joins the
//! neighbour with the nearer slope. Then the last stretch before a change of class becomes a segment of its own, the
//! lead-in. Long bodies are divided.
//!
//! Before neighbours merge, a cell takes the median class of the five cells around it. An error of 0.3 m in one height
//! changes the grades of two cells by 0.6 %. If single cells of a wrong class were joined in turn, the segments' ends
//! would move by hundreds of metres. The median changes nothing if a class lasts for 150 m.

use super::settings::RoadKeys;
use law::{MAX_CELLS, Preview};
use truck_model::{GEARS, GRAVITY_MPS2, Truck};

const CELL_M: f64 = 50.0;
/// Cells whose median class counts, the middle one's: pieces of 150 m are a majority of them.
const MEDIAN_CELLS: usize = 5;

/// Stretches shorter than this join a neighbour, m. Inferred, as the next two: half and double changed no figure.
const SHORTEST_M: f64 = 150.0;
/// Length of the segment of its own before a change of class, and longest segment before that, m.
const LEAD_IN_M: f64 = 450.0;
const LONGEST_M: f64 = 600.0;

pub const MOST_SEGMENTS: usize = 3;

/// Effect of a slope on a truck at its set speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Steeper than drag holds: it runs away.
    Downhill,
    #[default]
    Level,
    /// Steeper than full load holds: it falls back.
    Uphill,
}

/// Limits between the classes, rise over run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimitGrades {
    /// From here on uphill.
    pub up: f64,
    /// To here downhill.
    pub down: f64,
}

impl LimitGrades {
    /// Limits of a truck at its set speed in the highest gear.
    pub fn new(truck: &Truck, set_speed_mps: f64) -> Self {
        let top = GEARS - 1;
        let (drag_nm, max_nm) = truck.net_torque_limits_nm(set_speed_mps, top);
        let weight_n = truck.parameters().mass_kg * GRAVITY_MPS2;
        let flat_n = truck.resistance_n(set_speed_mps, 0.0);
        Self {
            up: (truck.force_n(max_nm, top) - flat_n) / weight_n,
            down: (truck.force_n(drag_nm, top) - flat_n) / weight_n,
        }
    }

    fn class(&self, grade: f64) -> Class {
        if grade >= self.up {
            Class::Uphill
        } else if grade <= self.down {
            Class::Downhill
        } else {
            Class::Level
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    pub length_m: f64,
    pub grade: f64,
    pub class: Class,
}

impl Stretch {
    fn absorb(&mut self, other: &Self, limits: &LimitGrades) {
        let length_m = self.length_m + other.length_m;
        self.grade = (self.grade * self.length_m + other.grade * other.length_m) / length_m;
        self.length_m = length_m;
        self.class = limits.class(self.grade);
    }
}

/// The reconstructed road ahead; it allocates when it is made.
#[derive(Clone, Debug)]
pub struct Reconstruction {
    keys: RoadKeys,
    stretches: Vec<Stretch>,
}

impl Reconstruction {
    pub fn new(keys: &RoadKeys) -> Self {
        Self { keys: *keys, stretches: Vec::with_capacity(MAX_CELLS) }
    }

    /// Reconstructs the road from `position_m` on, as far as the preview and the horizon reach.
    pub fn rebuild(&mut self, preview: &Preview, position_m: f64, limits: &LimitGrades) {
        self.stretches.clear();
        let cells = ((self.keys.horizon_m / CELL_M) as usize).min(MAX_CELLS);
        for cell in 0..cells {
            let from_m = position_m + CELL_M * cell as f64;
            let Some(grade) = preview.mean_grade(from_m, from_m + CELL_M) else { break };
            self.stretches.push(Stretch { length_m: CELL_M, grade, class: limits.class(grade) });
        }
        self.smooth_classes();
        self.merge_equals(limits);
        while let Some(short) = self.short() {
            let other = self.nearer_neighbour(short);
            self.join(short.min(other), limits);
            self.merge_equals(limits);
        }
    }

    /// The stretches, nearest first.
    pub fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// The segments to plan, nearest first: lead-ins apart, bodies divided.
    pub fn segments(&self) -> impl Iterator<Item = Stretch> {
        self.stretches.iter().enumerate().flat_map(|(index, stretch)| {
            let changes = index + 1 < self.stretches.len();
            let lead_in_m = if changes { LEAD_IN_M } else { 0.0 };
            let body_m = stretch.length_m - lead_in_m;
            let (body_m, lead_in_m) = if body_m < 0.5 * LEAD_IN_M {
                (0.0, stretch.length_m)
            } else {
                (body_m, lead_in_m)
            };
            let pieces = (body_m / LONGEST_M).ceil() as usize;
            let bodies = core::iter::repeat_n(body_m / pieces.max(1) as f64, pieces);
            let lengths_m = bodies.chain((lead_in_m > 0.0).then_some(lead_in_m));
            lengths_m.map(|length_m| Stretch { length_m, ..*stretch })
        })
    }

    /// Gives each cell the median class around it; at the ends the last cell counts for what is not known.
    fn smooth_classes(&mut self) {
        let mut classes = [Class::default(); MAX_CELLS];
        for (class, cell) in classes.iter_mut().zip(&self.stretches) {
            *class = cell.class;
        }
        let last = self.stretches.len().saturating_sub(1);
        for (index, cell) in self.stretches.iter_mut().enumerate() {
            let mut around = core::array::from_fn::<_, MEDIAN_CELLS, _>(|other| {
                classes[(index + other).saturating_sub(MEDIAN_CELLS / 2).min(last)]
            });
            around.sort_unstable();
            cell.class = around[MEDIAN_CELLS / 2];
        }
    }

    /// The first stretch that joins a neighbour.
    fn short(&self) -> Option<usize> {
        let is_short = |stretch: &Stretch| stretch.length_m < SHORTEST_M;
        self.stretches.iter().position(is_short).filter(|_| self.stretches.len() > 1)
    }

    fn nearer_neighbour(&self, index: usize) -> usize {
        let off = |other: usize| {
            let other = self.stretches.get(other);
            other.map_or(f64::INFINITY, |other| (other.grade - self.stretches[index].grade).abs())
        };
        if index > 0 && off(index - 1) < off(index + 1) { index - 1 } else { index + 1 }
    }

    fn merge_equals(&mut self, limits: &LimitGrades) {
        let mut index = 0;
        while index + 1 < self.stretches.len() {
            if self.stretches[index].class == self.stretches[index + 1].class {
                self.join(index, limits);
                // The joint stretch may now equal the one before it.
                index = index.saturating_sub(1);
            } else {
                index += 1;
            }
        }
    }

    fn join(&mut self, index: usize, limits: &LimitGrades) {
        let next = self.stretches.remove(index + 1);
        self.stretches[index].absorb(&next, limits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: LimitGrades = LimitGrades { up: 0.014, down: -0.011 };

    fn rebuilt(pieces: &[(usize, f64)]) -> Reconstruction {
        let mut preview = Preview::default();
        for &(cells, grade) in pieces {
            preview.grades[preview.count..preview.count + cells].fill(grade);
            preview.count += cells;
        }
        let mut road = Reconstruction::new(&RoadKeys::default());
        road.rebuild(&preview, 0.0, &LIMITS);
        road
    }

    fn rise_m(road: &Reconstruction) -> f64 {
        road.stretches().iter().map(|s| s.length_m * s.grade).sum()
    }

    #[test]
    fn equal_neighbours_merge_and_keep_the_height() {
        let road = rebuilt(&[(10, 0.002), (10, 0.006), (10, 0.02), (10, -0.02)]);
        let classes: Vec<Class> = road.stretches().iter().map(|s| s.class).collect();
        assert_eq!(classes, [Class::Level, Class::Uphill, Class::Downhill]);
        assert!((rise_m(&road) - 4.0).abs() < 1e-9, "{}", rise_m(&road));
        assert!((road.stretches()[0].grade - 0.004).abs() < 1e-12);
    }

    #[test]
    fn short_pieces_are_absorbed() {
        let road = rebuilt(&[(19, 0.0), (2, 0.02), (19, 0.0)]);
        assert_eq!(road.stretches().len(), 1);
        assert!((rise_m(&road) - 2.0).abs() < 1e-9);
    }

    /// One point is 0.4 m too high: the cells before and after it are off by 0.8 %.
    #[test]
    fn an_error_of_one_height_makes_no_piece() {
        let road = rebuilt(&[(19, 0.008), (1, 0.016), (1, 0.0), (19, 0.008)]);
        assert_eq!(road.stretches().len(), 1);
        assert_eq!(road.stretches()[0].class, Class::Level);
        let road = rebuilt(&[(20, 0.016), (1, 0.024), (1, 0.008), (18, 0.016)]);
        assert_eq!(road.stretches().len(), 1);
        assert_eq!(road.stretches()[0].class, Class::Uphill);
    }

    #[test]
    fn the_lead_in_is_a_segment_of_its_own() {
        let road = rebuilt(&[(24, 0.0), (16, 0.02)]);
        let segments: Vec<Stretch> = road.segments().take(2).collect();
        assert_eq!(segments.len(), 2);
        assert!((segments[0].length_m - 375.0).abs() < 1e-9, "{segments:?}");
        assert!((segments[1].length_m - 375.0).abs() < 1e-9, "{segments:?}");
        let road = rebuilt(&[(16, 0.0), (24, 0.02)]);
        let segments: Vec<Stretch> = road.segments().take(2).collect();
        assert!((segments[0].length_m - 350.0).abs() < 1e-9, "{segments:?}");
        assert_eq!(segments[1].length_m, 450.0);
    }

    #[test]
    fn a_preview_that_ends_early_is_used_as_far_as_it_goes() {
        let road = rebuilt(&[(3, 0.0)]);
        assert_eq!(
            road.stretches(),
            [Stretch { length_m: 150.0, grade: 0.0, class: Class::Level }]
        );
        assert_eq!(rebuilt(&[]).segments().count(), 0);
    }
}
