//! Lines of points in the plane.

/// A line of two points at least.
pub struct Line {
    /// The coordinates of its points, each with the way to it, m.
    along: [Vec<[f64; 2]>; 2],
}

impl Line {
    pub fn of(points: &[[f64; 2]]) -> Self {
        let mut along = points[0].map(|coordinate| vec![[0.0, coordinate]]);
        let mut way_m = 0.0;
        for pair in points.windows(2) {
            way_m += distance(pair[0], pair[1]);
            for (line, coordinate) in along.iter_mut().zip(pair[1]) {
                line.push([way_m, coordinate]);
            }
        }
        Self { along }
    }

    pub fn length_m(&self) -> f64 {
        self.along[0][self.along[0].len() - 1][0]
    }

    /// The point after a way along the line.
    pub fn at(&self, way_m: f64) -> [f64; 2] {
        [0, 1].map(|axis| road::offset_at(&self.along[axis], way_m))
    }

    /// The points between two ways along the line, with those at the ends.
    pub fn part(&self, from_m: f64, to_m: f64) -> Vec<[f64; 2]> {
        let inner = self.along[0].iter().map(|[way_m, _]| *way_m);
        let inner = inner.filter(|way_m| (from_m..to_m).contains(way_m));
        [from_m].into_iter().chain(inner).chain([to_m]).map(|way_m| self.at(way_m)).collect()
    }
}

pub fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}
