//! Four numbers that are treated alike, in one wide register where the machine has them.
//!
//! The loops over the stages are compiled twice, for any x86-64 and for its wide registers (AVX2), and the machine
//! decides at run time. Both do the same operations in the same order, and none of them is contracted (a fused
//! multiply-add would round once instead of twice), so that the bits do not depend on the machine; a test of
//! the crate runs both.

use std::ops::{Add, Mul, Sub};

/// The four numbers.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Lanes(pub(super) [f64; 4]);

impl Lanes {
    /// The first three moved on by one place: `(a, b, c, d)` becomes `(b, c, a, d)`.
    #[inline(always)]
    pub(super) fn rotated(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([b, c, a, d])
    }
}

impl Add for Lanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Lanes {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

impl Mul for Lanes {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] * other.0[i]))
    }
}

/// What a sweep carries for each state: the linear part of the cost-to-go alone, or `Ψ`'s row and, in the last lane,
/// that.
pub(super) trait Row:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Whether `Ψ` is in it.
    const HAS_TERMINAL: bool;

    /// The same number everywhere.
    fn splat(value: f64) -> Self;

    /// A number for the linear part, zero for `Ψ`.
    fn linear(value: f64) -> Self;

    /// From all four numbers.
    fn of(lanes: Lanes) -> Self;

    /// All four numbers, zero where there is no `Ψ`.
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
        Self([value; 4])
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
