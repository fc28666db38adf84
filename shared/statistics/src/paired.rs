//! An interval for the centre of differences, from the means of their subsets.
//!
//! Differences d₁ … dₙ that lie symmetrically about a centre split the line at the means of their 2ⁿ - 1 subsets. The
//! centre is in each of the 2ⁿ pieces with the same probability. So the interval from the k-th smallest subset mean to
//! the k-th largest one holds the centre. Its probability is 1 - 2k/2ⁿ. With equal differences it holds it at least as
//! often.
//!
//! Nothing else is assumed: no normal distribution, no number of pairs. With too few pairs there is no interval.
//! Above [`MOST_LISTED`] pairs as many subsets are drawn at random, which leaves the statement exact.
//!
//! Sources: Hartigan, "Using subsample values as typical values", JASA 64 (1969) 1303-1317, theorems 1 and 2. It is the
//! interval of Fisher's sign-flip test, "The design of experiments" (1935), section 21.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// Most pairs of which all subsets are listed.
const MOST_LISTED: usize = 16;
/// Pieces of the line where the subsets are drawn.
const DRAWN: usize = 1 << MOST_LISTED;
/// Random sequence of the draw: the same differences give the same interval.
const STREAM: u128 = 0x7a11;

/// Place of the centre of differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// True if all of it is above 0, or all of it below.
    pub fn leaves_out_zero(&self) -> bool {
        self.low > 0.0 || self.high < 0.0
    }
}

/// Interval that holds the centre of the differences with a probability of at least 1 - `tails`; none of too few.
///
/// # Panics
/// If `tails` is not between 0 and 1.
pub fn interval(differences: &[f64], tails: f64) -> Option<Interval> {
    assert!(tails > 0.0 && tails < 1.0, "a probability, and no {tails}");
    let pieces = pieces(differences.len());
    let place = place(pieces, tails)?;
    let mut means =
        if differences.len() > MOST_LISTED { drawn(differences) } else { listed(differences) };
    // The means are one fewer than the pieces.
    let (_, low, _) = means.select_nth_unstable_by(place - 1, f64::total_cmp);
    let low = *low;
    let last = means.len() - place;
    let (_, high, _) = means.select_nth_unstable_by(last, f64::total_cmp);
    Some(Interval { low, high: *high })
}

/// The smallest number of pairs with an interval at `tails`; none if no number has one.
///
/// ```
/// assert_eq!(statistics::least_pairs(0.05), Some(6));
/// assert_eq!(statistics::least_pairs(0.05 / 12.0), Some(9));
/// ```
pub fn least_pairs(tails: f64) -> Option<usize> {
    (1..=MOST_LISTED).find(|pairs| place(pieces(*pairs), tails).is_some())
}

/// Pieces into which the means of the subsets split the line.
fn pieces(pairs: usize) -> usize {
    1 << pairs.min(MOST_LISTED)
}

/// The number k of pieces that are left out at each end; none where that is less than one.
fn place(pieces: usize, tails: f64) -> Option<usize> {
    let place = (tails / 2.0 * pieces as f64).floor() as usize;
    (place > 0).then_some(place)
}

/// The means of all subsets but the empty one.
fn listed(values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; 1 << values.len()];
    for subset in 1..sums.len() {
        let first = subset.trailing_zeros() as usize;
        sums[subset] = sums[subset & (subset - 1)] + values[first];
    }
    let mean = |(subset, sum): (usize, f64)| sum / f64::from(subset.count_ones());
    sums.into_iter().enumerate().skip(1).map(mean).collect()
}

/// The means of subsets that are drawn: each but the empty one is as likely as any other.
fn drawn(values: &[f64]) -> Vec<f64> {
    let mut random = Pcg64::new(values.len() as u128, STREAM);
    let mut means = Vec::with_capacity(DRAWN - 1);
    while means.len() < DRAWN - 1 {
        let (mut sum, mut count) = (0.0, 0_u32);
        for word in values.chunks(64) {
            let bits = random.next_u64();
            for (place, value) in word.iter().enumerate() {
                if bits >> place & 1 == 1 {
                    sum += value;
                    count += 1;
                }
            }
        }
        if count > 0 {
            means.push(sum / f64::from(count));
        }
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Darwin's differences of crossed and self-fertilised plants, eighths of an inch (Fisher 1935, table 3).
    const DARWIN: [f64; 15] =
        [49.0, -67.0, 8.0, 16.0, 6.0, 23.0, 28.0, 41.0, 14.0, 29.0, 56.0, 24.0, 75.0, 60.0, -48.0];

    #[test]
    fn darwins_plants_have_fishers_probability() {
        // Fisher counts 863 of 32,768 sign patterns at each end that are as extreme: 5.267 %.
        assert_eq!(listed(&DARWIN).iter().filter(|mean| **mean <= 0.0).count(), 862);
        let at = |tails| interval(&DARWIN, tails).expect("15 pairs");
        assert!(!at(0.0526).leaves_out_zero() && at(0.0528).leaves_out_zero());
        assert!(at(0.05).low > -1.0 && at(0.05).high < 42.0, "{:?}", at(0.05));
    }

    #[test]
    fn six_pairs_are_the_fewest_at_five_percent() {
        assert!(interval(&[1.0; 5], 0.05).is_none());
        assert_eq!(interval(&[1.0; 6], 0.05), Some(Interval { low: 1.0, high: 1.0 }));
        assert!(interval(&[], 0.5).is_none());
        assert_eq!(least_pairs(1e-9), None);
    }

    /// Share of intervals that hold the centre 0 of `draw`'s values.
    fn held(pairs: usize, tails: f64, rounds: u64, draw: fn(&mut Pcg64) -> f64) -> f64 {
        let mut random = Pcg64::new(11, 3);
        let holds = |_: &u64| {
            let values: Vec<f64> = (0..pairs).map(|_| draw(&mut random)).collect();
            !interval(&values, tails).expect("enough pairs").leaves_out_zero()
        };
        (0..rounds).filter(holds).count() as f64 / rounds as f64
    }

    #[test]
    fn the_interval_holds_the_centre_as_often_as_it_says() {
        let laplace = |random: &mut Pcg64| {
            let (sign, size) = (random.next_u64() & 1, random::open_uniform(random));
            if sign == 0 { size.ln() } else { -size.ln() }
        };
        // Most seeds make no difference: a count with ties, as many figures of a drive have.
        let ties = |random: &mut Pcg64| (random.next_u64() % 5) as f64 - 2.0;
        for (pairs, tails, exact) in
            [(6, 0.05, 1.0 - 2.0 / 64.0), (8, 0.25, 0.75), (10, 0.05, 0.951)]
        {
            let found = held(pairs, tails, 4_000, laplace);
            // Standard deviation of the share: at most 0.007.
            assert!((found - exact).abs() < 0.025, "{pairs} pairs: {found} and not {exact}");
            assert!(held(pairs, tails, 2_000, ties) > 1.0 - tails - 0.03);
        }
        let found = held(20, 0.2, 200, laplace);
        assert!((found - 0.8).abs() < 0.12, "drawn subsets: {found}");
    }

    #[test]
    fn a_shift_of_the_differences_shifts_the_interval() {
        let shifted = DARWIN.map(|difference| difference + 100.0);
        let (here, there) = (interval(&DARWIN, 0.05), interval(&shifted, 0.05));
        let (here, there) = (here.expect("15 pairs"), there.expect("15 pairs"));
        assert!((there.low - here.low - 100.0).abs() < 1e-9);
        assert!((there.high - here.high - 100.0).abs() < 1e-9);
    }
}
