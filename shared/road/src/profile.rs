//! Values that change along a road: cubics by stretches.

use serde::{Deserialize, Serialize};

/// Start of a stretch that holds everywhere, m.
const BEFORE_ALL_M: f64 = -1e9;

/// `a + b x + c x² + d x³` with `x` from the stretch's start, up to the next stretch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Its start along the road, m.
    pub from_m: f64,
    /// a, b, c, d.
    pub factors: [f64; 4],
}

/// A value along a road, such as the width of a lane.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Profile {
    stretches: Vec<Stretch>,
}

impl Stretch {
    fn at(&self, s_m: f64) -> f64 {
        let ([a, b, c, d], x) = (self.factors, s_m - self.from_m);
        a + x * (b + x * (c + x * d))
    }

    fn slope(&self, s_m: f64) -> f64 {
        let ([_, b, c, d], x) = (self.factors, s_m - self.from_m);
        b + x * (2.0 * c + 3.0 * x * d)
    }

    fn bend(&self, s_m: f64) -> f64 {
        let ([_, _, c, d], x) = (self.factors, s_m - self.from_m);
        2.0 * c + 6.0 * x * d
    }

    /// The same function, counted from another place.
    fn counted_from(&self, from_m: f64) -> Self {
        let factors = match from_m == self.from_m {
            true => self.factors,
            false => {
                [self.at(from_m), self.slope(from_m), 0.5 * self.bend(from_m), self.factors[3]]
            }
        };
        Self { from_m, factors }
    }
}

impl Profile {
    /// A profile of stretches; it is 0 before the first.
    ///
    /// ```
    /// use road::{Profile, Stretch};
    /// let taper = Profile::new(vec![Stretch { from_m: 100.0, factors: [0.0, 0.1, 0.0, 0.0] }]);
    /// assert_eq!((taper.at(50.0), taper.at(120.0), taper.slope(120.0)), (0.0, 2.0, 0.1));
    /// ```
    pub fn new(mut stretches: Vec<Stretch>) -> Self {
        stretches.sort_by(|a, b| a.from_m.total_cmp(&b.from_m));
        Self { stretches }
    }

    /// The same value everywhere.
    pub fn constant(value: f64) -> Self {
        match value == 0.0 {
            true => Self::default(),
            false => {
                Self::new(vec![Stretch { from_m: BEFORE_ALL_M, factors: [value, 0.0, 0.0, 0.0] }])
            }
        }
    }

    pub fn stretches(&self) -> &[Stretch] {
        &self.stretches
    }

    /// The stretch that holds at a place.
    fn stretch(&self, s_m: f64) -> Stretch {
        let behind = self.stretches.partition_point(|stretch| stretch.from_m <= s_m);
        behind.checked_sub(1).map_or(Stretch::default(), |index| self.stretches[index])
    }

    /// The value at a place.
    pub fn at(&self, s_m: f64) -> f64 {
        self.stretch(s_m).at(s_m)
    }

    /// The change along the road, per m.
    pub fn slope(&self, s_m: f64) -> f64 {
        self.stretch(s_m).slope(s_m)
    }

    /// The change of the slope, per m².
    pub fn bend(&self, s_m: f64) -> f64 {
        self.stretch(s_m).bend(s_m)
    }

    /// The value, if it is the same everywhere from 0 to `length_m`.
    pub fn uniform(&self, length_m: f64) -> Option<f64> {
        let value = self.at(0.0);
        let is_flat = |stretch: &Stretch| {
            let [a, b, c, d] = stretch.factors;
            [b, c, d] == [0.0; 3] && a == value
        };
        let inside = self.stretches.iter().filter(|stretch| stretch.from_m < length_m);
        let mut used: Vec<&Stretch> = inside.collect();
        let begun = used.partition_point(|stretch| stretch.from_m <= 0.0);
        used.drain(..begun.saturating_sub(1));
        used.into_iter().all(is_flat).then_some(value)
    }

    /// The profile of a road that is driven from its end: the value at `length_m - s`.
    pub fn reversed(&self, length_m: f64) -> Self {
        let mut turned = Vec::with_capacity(self.stretches.len() + 1);
        let mut end_m = length_m;
        for stretch in self.stretches.iter().rev() {
            if stretch.from_m < end_m {
                let [a, b, c, d] = stretch.counted_from(end_m).factors;
                turned.push(Stretch { from_m: length_m - end_m, factors: [a, -b, c, -d] });
                end_m = stretch.from_m;
            }
        }
        if end_m > 0.0 {
            turned.push(Stretch { from_m: length_m - end_m, factors: [0.0; 4] });
        }
        Self::new(turned)
    }

    /// The part from 0 to `length_m`, put behind `to`, which is `at_m` long.
    pub fn append_to(&self, to: &mut Self, at_m: f64, length_m: f64) {
        to.stretches.retain(|stretch| stretch.from_m < at_m);
        let first = self.stretch(0.0).counted_from(0.0);
        let rest = self.stretches.iter().filter(|s| s.from_m > 0.0 && s.from_m < length_m);
        for stretch in std::iter::once(&first).chain(rest) {
            to.stretches.push(Stretch { from_m: at_m + stretch.from_m, factors: stretch.factors });
        }
    }

    /// The sum of profiles with weights, from `from_m` to `to_m`.
    pub fn sum(parts: &[(f64, &Self)], from_m: f64, to_m: f64) -> Self {
        let mut starts = vec![from_m];
        for (_, profile) in parts {
            let inside = profile.stretches.iter().map(|stretch| stretch.from_m);
            starts.extend(inside.filter(|start| *start > from_m && *start < to_m));
        }
        starts.sort_by(f64::total_cmp);
        starts.dedup();
        let stretch = |from_m: f64| {
            let mut factors = [0.0; 4];
            for (weight, profile) in parts {
                let part = profile.stretch(from_m).counted_from(from_m).factors;
                for (sum, factor) in factors.iter_mut().zip(part) {
                    *sum += weight * factor;
                }
            }
            Stretch { from_m, factors }
        };
        Self { stretches: starts.into_iter().map(stretch).collect() }
    }

    /// Adds `by_m` to the places of all stretches.
    pub fn moved(mut self, by_m: f64) -> Self {
        for stretch in &mut self.stretches {
            stretch.from_m += by_m;
        }
        self
    }

    pub fn negated(mut self) -> Self {
        for stretch in &mut self.stretches {
            stretch.factors = stretch.factors.map(|factor| 0.0 - factor);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hill() -> Profile {
        Profile::new(vec![
            Stretch { from_m: 20.0, factors: [1.0, 0.1, 0.02, -0.001] },
            Stretch { from_m: 50.0, factors: [3.0, 0.0, 0.0, 0.0] },
        ])
    }

    #[test]
    fn a_reversed_profile_has_the_same_values() {
        let (hill, back) = (hill(), hill().reversed(80.0));
        for s_m in [0.0, 10.0, 19.9, 20.1, 33.0, 49.9, 50.1, 79.0] {
            assert!((hill.at(s_m) - back.at(80.0 - s_m)).abs() < 1e-12, "{s_m}");
            assert!((hill.slope(s_m) + back.slope(80.0 - s_m)).abs() < 1e-12, "{s_m}");
        }
    }

    #[test]
    fn sums_and_chains_hold_everywhere() {
        let (hill, other) = (hill(), hill().moved(7.0));
        let sum = Profile::sum(&[(1.0, &hill), (-0.5, &other)], 5.0, 90.0);
        let mut chain = Profile::constant(2.0);
        hill.append_to(&mut chain, 100.0, 60.0);
        for s_m in [5.0, 21.0, 27.5, 52.0, 58.0, 59.0] {
            assert!((sum.at(s_m) - hill.at(s_m) + 0.5 * other.at(s_m)).abs() < 1e-12, "{s_m}");
            assert!((chain.at(100.0 + s_m) - hill.at(s_m)).abs() < 1e-12, "{s_m}");
        }
        assert_eq!((chain.at(99.0), chain.at(-5.0)), (2.0, 2.0));
    }

    #[test]
    fn only_a_profile_without_changes_is_uniform() {
        assert_eq!(Profile::constant(3.5).uniform(10.0), Some(3.5));
        assert_eq!(Profile::default().uniform(10.0), Some(0.0));
        assert_eq!((hill().uniform(20.0), hill().uniform(21.0)), (Some(0.0), None));
    }
}
