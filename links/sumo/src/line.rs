//! Lines of points in the plane.

/// A line of two points at least, with the way to each, m.
pub struct Line<'a> {
    points: &'a [[f64; 2]],
    ways_m: Vec<f64>,
}

impl<'a> Line<'a> {
    pub fn of(points: &'a [[f64; 2]]) -> Self {
        let mut ways_m = vec![0.0];
        ways_m.extend(points.windows(2).scan(0.0, |way_m, pair| {
            *way_m += distance(pair[0], pair[1]);
            Some(*way_m)
        }));
        Self { points, ways_m }
    }

    pub fn length_m(&self) -> f64 {
        self.ways_m[self.ways_m.len() - 1]
    }

    /// The point after a way along the line.
    pub fn at(&self, way_m: f64) -> [f64; 2] {
        let next = self.ways_m.partition_point(|passed_m| *passed_m <= way_m);
        let next = next.clamp(1, self.points.len() - 1);
        let (from_m, to_m) = (self.ways_m[next - 1], self.ways_m[next]);
        let share = ((way_m - from_m) / (to_m - from_m).max(1e-9)).clamp(0.0, 1.0);
        [0, 1].map(|axis| {
            let (a, b) = (self.points[next - 1][axis], self.points[next][axis]);
            a + share * (b - a)
        })
    }

    /// The points between two ways along the line, with those at the ends.
    pub fn part(&self, from_m: f64, to_m: f64) -> Vec<[f64; 2]> {
        let inner = self.points.iter().zip(&self.ways_m);
        let inner = inner.filter(|(_, way_m)| (from_m..to_m).contains(way_m));
        let ends = [self.at(from_m), self.at(to_m)];
        [&ends[..1], &inner.map(|(point, _)| *point).collect::<Vec<_>>(), &ends[1..]].concat()
    }
}

/// Distance of two points, m.
pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}
