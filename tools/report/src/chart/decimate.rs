//! Fewer points, the same picture: of all points that fall into one column of pixels the first, the
//! lowest, the highest and the last are kept (Jugel et al. 2014, "M4"), so that no spike is lost; then
//! what is on the straight line between its neighbours goes.

/// Distance from a straight line that is too small to see, px.
const UNSEEN: f64 = 0.12;
/// Most points that one straight line replaces: bounds the work.
const LONGEST: usize = 64;

/// Points in px, as unbroken runs: a point that is not finite ends one. `x` must not decrease inside
/// a run for the reduction to be exact.
pub fn decimate(points: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<(f64, f64)>> {
    let mut runs = Vec::new();
    let mut run: Vec<(f64, f64)> = Vec::new();
    let mut column = Column::default();
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            column.empty_into(&mut run);
            if !run.is_empty() {
                runs.push(std::mem::take(&mut run));
            }
            continue;
        }
        if column.first().is_some_and(|first| first.0.floor() != x.floor()) {
            column.empty_into(&mut run);
        }
        column.take((x, y));
    }
    column.empty_into(&mut run);
    if !run.is_empty() {
        runs.push(run);
    }
    runs.iter().map(|run| straighten(run)).collect()
}

/// Drops the points that are no farther than [`UNSEEN`], measured vertically, from the line that
/// replaces them. Ends stay.
fn straighten(run: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = run.first().copied().into_iter().collect();
    let mut from = 0;
    for to in 2..run.len() {
        let (a, b) = (run[from], run[to]);
        let on_the_line = |point: &(f64, f64)| {
            let share = (point.0 - a.0) / (b.0 - a.0);
            (a.1 + share * (b.1 - a.1) - point.1).abs() <= UNSEEN
        };
        if to - from > LONGEST || b.0 <= a.0 || !run[from + 1..to].iter().all(on_the_line) {
            kept.push(run[to - 1]);
            from = to - 1;
        }
    }
    kept.extend(run.last().filter(|_| run.len() > 1));
    kept
}

/// The points of one column that matter so far, in order of arrival: at most first, two extremes and
/// last.
#[derive(Default)]
struct Column {
    /// With room for the one that arrives.
    points: [(f64, f64); 5],
    count: usize,
}

impl Column {
    fn first(&self) -> Option<(f64, f64)> {
        (self.count > 0).then_some(self.points[0])
    }

    fn take(&mut self, point: (f64, f64)) {
        self.points[self.count] = point;
        self.count += 1;
        if self.count < self.points.len() {
            return;
        }
        // Of the three inner points the one between the extremes goes, or two if all are as high.
        let (mut lowest, mut highest) = (1, 1);
        for index in 2..=3 {
            let height = self.points[index].1;
            if height.total_cmp(&self.points[lowest].1).is_lt() {
                lowest = index;
            }
            if height.total_cmp(&self.points[highest].1).is_ge() {
                highest = index;
            }
        }
        self.count = 1;
        for index in 1..self.points.len() {
            if index == lowest || index == highest || index + 1 == self.points.len() {
                self.points[self.count] = self.points[index];
                self.count += 1;
            }
        }
    }

    fn empty_into(&mut self, run: &mut Vec<(f64, f64)>) {
        run.extend_from_slice(&self.points[..self.count]);
        self.count = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_survive_and_little_else() {
        let wave = |i: usize| match i {
            5_432 => 100.0,
            7_654 => -100.0,
            _ => (i as f64).sin(),
        };
        let runs = decimate((0..10_000).map(|i| (i as f64 / 100.0, wave(i))));
        let [run] = runs.as_slice() else { panic!("one run") };
        assert!(run.len() <= 4 * 100, "{}", run.len());
        let heights = || run.iter().map(|point| point.1);
        assert_eq!(heights().fold(f64::MIN, f64::max), 100.0);
        assert_eq!(heights().fold(f64::MAX, f64::min), -100.0);
        assert!(run.windows(2).all(|pair| pair[0].0 <= pair[1].0), "order is kept");
        assert_eq!((run[0].0, run[run.len() - 1].0), (0.0, 99.99));
    }

    #[test]
    fn straight_parts_need_few_points() {
        let corner = |i: i32| (f64::from(i) / 10.0, f64::from((i - 500).abs()) / 10.0);
        let runs = decimate((0..1000).map(corner));
        let [run] = runs.as_slice() else { panic!("one run") };
        assert!(run.len() < 60, "{}", run.len());
        assert!(run.contains(&(50.0, 0.0)), "the corner stays");
        let staircase = [(0.0, 0.0), (5.0, 0.0), (5.0, 9.0), (9.0, 9.0)];
        assert_eq!(decimate(staircase.into_iter()), [staircase.to_vec()]);
    }

    #[test]
    fn few_points_stay_and_holes_break_the_curve() {
        let points = [(0.0, 1.0), (10.0, 2.0), (20.0, f64::NAN), (30.0, 3.0)];
        let runs = decimate(points.into_iter());
        assert_eq!(runs, [vec![(0.0, 1.0), (10.0, 2.0)], vec![(30.0, 3.0)]]);
        assert!(decimate(std::iter::empty()).is_empty());
    }
}
