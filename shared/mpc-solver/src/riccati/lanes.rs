//! Four numbers processed alike, in one wide register where the machine has one.
//!
//! The loops over the stages are compiled twice, for any x86-64 and for its wide registers (AVX2). The machine decides
//! at run time. Both versions perform the same operations in the same order. Neither uses a fused multiply-add, which
//! would round once instead of twice. The bits therefore do not depend on the machine; a test of the crate runs both.
//!
//! The compiler assigns four [`Lanes`] to a register when they go lane by lane to memory or to each other. Reductions
//! at the end of a loop (sum, maximum) are functions that are not inlined. Inlined, they made the compiler pair the
//! lanes in the order of the reduction. It then processed the loop number by number, a third slower.

use std::ops::{Add, Div, Mul, Neg, Sub};

pub(super) const WIDTH: usize = 4;

#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Lanes(pub(super) [f64; WIDTH]);

impl Lanes {
    /// Returns the same number in all lanes.
    #[inline(always)]
    pub(super) const fn all(value: f64) -> Self {
        Self([value; WIDTH])
    }

    /// Returns the lane-wise maximum by one instruction; `other` where `self` is NaN.
    #[inline(always)]
    pub(super) fn greater(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] }))
    }

    /// Returns the lane-wise minimum; `other` where `self` is NaN.
    #[inline(always)]
    pub(super) fn lesser(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] }))
    }

    /// Returns the sum of the lanes; not inlined, see the head of the module.
    #[inline(never)]
    pub(super) fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }

    /// Returns the largest lane; not inlined, see the head of the module.
    #[inline(never)]
    pub(super) fn largest(self) -> f64 {
        let [a, b, c, d] = self.0;
        a.max(b).max(c.max(d))
    }

    /// Rotates the first three lanes: `(a, b, c, d)` becomes `(b, c, a, a)`. The last lane has no
    /// meaning. Its product must not occur in another sum, or the compiler computes both lane by
    /// lane.
    #[inline(always)]
    pub(super) fn rotated(self) -> Self {
        let [a, b, c, _] = self.0;
        Self([b, c, a, a])
    }
}

macro_rules! lane_wise {
    ($($operator:ident::$function:ident $symbol:tt)*) => {$(
        impl $operator for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i] $symbol other.0[i]))
            }
        }
    )*};
}

lane_wise!(Add::add + Sub::sub - Mul::mul * Div::div /);

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

/// Data that a sweep carries for each state. It is the linear part of the cost-to-go alone, or
/// `Ψ`'s row with that part in the last lane.
pub(super) trait Row:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// True if it contains `Ψ`.
    const HAS_TERMINAL: bool;

    /// Returns the same number everywhere.
    fn splat(value: f64) -> Self;

    /// Returns a number for the linear part and zero for `Ψ`.
    fn linear(value: f64) -> Self;

    /// Converts from four numbers.
    fn of(lanes: Lanes) -> Self;

    /// Converts to four numbers, zero in place of an absent `Ψ`.
    fn lanes(self) -> Lanes;
}

impl Row for f64 {
    const HAS_TERMINAL: bool = false;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn linear(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn of(lanes: Lanes) -> Self {
        lanes.0[3]
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        Lanes([0.0, 0.0, 0.0, self])
    }
}

impl Row for Lanes {
    const HAS_TERMINAL: bool = true;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::all(value)
    }

    #[inline(always)]
    fn linear(value: f64) -> Self {
        Self([0.0, 0.0, 0.0, value])
    }

    #[inline(always)]
    fn of(lanes: Lanes) -> Self {
        lanes
    }

    #[inline(always)]
    fn lanes(self) -> Lanes {
        self
    }
}
