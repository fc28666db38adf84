//! Limits of the study. A changed limit is an entry of its own in CHANGELOG.md.
//!
//! | since | limit | value | source |
//! | --- | --- | --- | --- |
//! | 2026-11-25 | collisions in the cut-ins that both models master, low and high together | 0.5 % | chosen; UN R157, 5.2.5.2, allows none |
//! | 2026-11-21 | collisions in each part of the cut-ins | a third of `regulation`'s | chosen |
//! | 2026-11-21 | collisions while following | 0 | UN R157, 5.2.5.2 |
//! | 2026-11-25 | collisions in the cut-outs that `careful-driver` masters from the law's gap | 0.5 % | chosen; UN R157, 5.2.5.2, allows none |
//!
//! A law with the emergency brake has to hold its limits. A law alone is measured against the same limits, and the
//! result names it. It does not decide the exit status.
//!
//! A sample of the cases is within a limit, or beyond it, or leaves it open. Beyond it are samples whose 95 % interval
//! (Wilson 1927) is above the limit as a whole. So a sample does not call a law missed that the whole matrix finds
//! within, apart from one sample in forty.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

use super::matrix::Matrix;

/// Share of the cases that a model masters in which a law may collide.
const FEW: f64 = 0.005;
/// Collisions of a law, as a share of those of `regulation`.
const OF_REGULATION: f64 = 1.0 / 3.0;

#[derive(Clone, Copy, Debug)]
pub struct Limit {
    share: f64,
    /// The cases of which that is a share, for people.
    of: &'static str,
    /// The collisions that count, and the cases of which they are a share.
    count: fn(&Counts) -> Option<(u32, u32)>,
}

/// Numbers of a law's cases that a limit may count.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    pub cases: u32,
    pub collisions: u32,
    pub mastered_by_both: u32,
    /// Collisions of the law in those.
    pub avoidable_by_both: u32,
    pub of_regulation: Option<u32>,
    /// Collisions in the cases that `careful-driver` masters from the law's gap, and these cases.
    pub from_its_gap: Option<(u32, u32)>,
}

/// A figure that is held against a limit.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Held {
    /// Collisions that count.
    pub count: u32,
    /// Cases of which they are a share.
    pub of: u32,
    /// 95 % interval of the share over the whole matrix; null where the whole matrix was driven.
    pub ci95: Option<[f64; 2]>,
    pub verdict: Position,
}

/// Position of a figure to its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Position {
    /// At most the limit.
    Within,
    /// A sample above the limit, whose interval has the limit in it.
    Undecided,
    /// Above the limit.
    Beyond,
}

impl Limit {
    const MASTERED_BY_BOTH: Self = Self {
        share: FEW,
        of: "the cases that both models master",
        count: |counts| Some((counts.avoidable_by_both, counts.mastered_by_both)),
    };
    const THIRD_OF_REGULATION: Self = Self {
        share: OF_REGULATION,
        of: "the number with regulation",
        count: |counts| Some((counts.collisions, counts.of_regulation?)),
    };
    const NO_COLLISION: Self = Self {
        share: 0.0,
        of: "the cases",
        count: |counts| Some((counts.collisions, counts.cases)),
    };
    const MASTERED_FROM_ITS_GAP: Self = Self {
        share: FEW,
        of: "the cases that careful-driver masters from the law's gap",
        count: |counts| counts.from_its_gap,
    };

    /// The limit over all the cases of a matrix.
    pub fn of_whole(matrix: Matrix) -> &'static Self {
        match matrix {
            Matrix::CutIn => &Self::MASTERED_BY_BOTH,
            Matrix::Following => &Self::NO_COLLISION,
            Matrix::CutOut => &Self::MASTERED_FROM_ITS_GAP,
        }
    }

    /// The limit over each part of a matrix.
    pub fn of_parts(matrix: Matrix) -> Option<&'static Self> {
        (matrix == Matrix::CutIn).then_some(&Self::THIRD_OF_REGULATION)
    }

    pub fn hold(&self, counts: &Counts, is_sample: bool) -> Option<Held> {
        let (count, of) = (self.count)(counts)?;
        Some(self.held(count, of, is_sample))
    }

    fn held(&self, count: u32, of: u32, is_sample: bool) -> Held {
        let ci95 = is_sample.then(|| rare_events::wilson(count.min(of) as usize, of as usize));
        let verdict = match ci95 {
            _ if f64::from(count) <= self.share * f64::from(of) => Position::Within,
            Some([low, _]) if low <= self.share => Position::Undecided,
            _ => Position::Beyond,
        };
        Held { count, of, ci95, verdict }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.share {
            0.0 => f.write_str("no collision"),
            share => write!(f, "collisions in at most {:.1} % of {}", 100.0 * share, self.of),
        }
    }
}

impl fmt::Display for Held {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { count, of, ci95, .. } = self;
        write!(f, "{count} of {of}")?;
        if *of > 0 {
            write!(f, ", {:.2} %", 100.0 * f64::from(*count) / f64::from(*of))?;
        }
        if let Some([low, high]) = ci95 {
            write!(f, " ({:.2} to {:.2})", 100.0 * low, 100.0 * high)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::matrix::sample;
    use super::*;

    #[test]
    fn a_share_at_the_limit_is_within_and_one_case_more_is_beyond() {
        let position = |limit: Limit, count, of| limit.held(count, of, false).verdict;
        // 0.5 % of 22,475 are 112, a third of 2,252 are 750.
        for (limit, count, of) in [
            (Limit::MASTERED_BY_BOTH, 112, 22_475),
            (Limit::THIRD_OF_REGULATION, 750, 2_252),
            (Limit::THIRD_OF_REGULATION, 1, 3),
            (Limit::NO_COLLISION, 0, 1_121),
        ] {
            assert_eq!(position(limit, count, of), Position::Within, "{limit}");
            assert_eq!(position(limit, count + 1, of), Position::Beyond, "{limit}");
        }
    }

    /// 98 of 22,475 mastered cases of 29,970, and samples of 2,000: the interval of a sample has the share of the whole
    /// matrix in it, and hardly a sample is beyond a limit that the whole is within.
    #[test]
    fn a_sample_says_what_the_whole_matrix_says() {
        const WHOLE: usize = 29_970;
        let is_mastered = |case: usize| case % 4 != 3 && case < WHOLE - 3;
        let is_hit = |case: usize| is_mastered(case) && case.is_multiple_of(306);
        let of = (0..WHOLE).filter(|case| is_mastered(*case)).count();
        let hits = (0..WHOLE).filter(|case| is_hit(*case)).count();
        let share = hits as f64 / of as f64;
        assert!((0.0040..0.0050).contains(&share), "{hits} of {of}");
        let (mut misses, mut beyond) = (0, 0);
        for seed in 0..400 {
            let drawn = sample((0..WHOLE).collect(), 2_000, seed);
            let count = |holds: &dyn Fn(usize) -> bool| {
                drawn.iter().filter(|case| holds(**case)).count() as u32
            };
            let held = Limit::MASTERED_BY_BOTH.held(count(&is_hit), count(&is_mastered), true);
            let [low, high] = held.ci95.expect("it is a sample");
            misses += u32::from(!(low..=high).contains(&share));
            beyond += u32::from(held.verdict == Position::Beyond);
        }
        // 20 and fewer than 10 expected.
        assert!(misses <= 32 && beyond <= 16, "{misses} misses, {beyond} beyond");
    }

    #[test]
    fn a_sample_far_above_the_limit_is_beyond_it_and_one_near_it_leaves_it_open() {
        let position = |count| Limit::MASTERED_BY_BOTH.held(count, 1_500, true).verdict;
        assert_eq!([7, 9, 30].map(position), {
            [Position::Within, Position::Undecided, Position::Beyond]
        });
        let held = Limit::MASTERED_BY_BOTH.held(14, 1_500, true);
        assert_eq!(held.to_string(), "14 of 1500, 0.93 % (0.56 to 1.56)");
    }
}
