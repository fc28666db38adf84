//! Four numbers that are treated alike, in one wide register where the machine has them.
//!
//! The loops over the stages are compiled twice, for any x86-64 and for its wide registers (AVX2), and the machine
//! decides at run time. Both do the same operations in the same order, and none of them is contracted (a fused
//! multiply-add would round once instead of twice), so that the bits do not depend on the machine; a test of
//! the crate runs both.
//!
//! That four of [`Lanes`] share a register is the compiler's finding, from where they go: lane by lane to memory or to each other.
//! What mixes lanes at the end of a loop, a sum of all or the greatest, therefore is a function of its own: inlined, it made the
//! compiler pair the lanes in the order of that sum and treat the loop number by number (a third slower). A loop that mixes
//! them at each stage is written for any [`Vector`], and takes the registers themselves ([`wide`]) where the machine has them.

#[cfg(target_arch = "x86_64")]
pub(super) mod wide;

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of lanes.
pub(super) const WIDTH: usize = 4;

/// The four numbers.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Lanes(pub(super) [f64; WIDTH]);

impl Lanes {
    /// The same number everywhere.
    #[inline(always)]
    pub(super) const fn all(value: f64) -> Self {
        Self([value; WIDTH])
    }

    /// The numbers of any vector.
    #[inline(always)]
    pub(super) fn from_vector<V: Vector>(vector: V) -> Self {
        Self(vector.to_array())
    }

    /// Lane by lane the greater of two numbers, as one instruction; the other one where `self` is not a number.
    #[inline(always)]
    pub(super) fn greater(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(std::array::from_fn(|i| if a[i] > b[i] { a[i] } else { b[i] }))
    }

    /// The same for the lesser.
    #[inline(always)]
    pub(super) fn lesser(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] }))
    }

    /// Lane by lane the number of `self` where `condition` holds, else the other one.
    #[inline(always)]
    pub(super) fn where_or(self, condition: [bool; WIDTH], other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self(std::array::from_fn(|i| if condition[i] { a[i] } else { b[i] }))
    }

    /// The square roots.
    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    /// The numbers without their signs.
    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    /// The sum of all; not inlined, see the head of the module.
    #[inline(never)]
    pub(super) fn sum(self) -> f64 {
        let [a, b, c, d] = self.0;
        (a + b) + (c + d)
    }

    /// The greatest of all; not inlined either.
    #[inline(never)]
    pub(super) fn largest(self) -> f64 {
        let [a, b, c, d] = self.0;
        a.max(b).max(c.max(d))
    }

    /// The first three moved on by one place: `(a, b, c, d)` becomes `(b, c, a, a)`. What becomes of the last means nothing, but
    /// its product must not be one that another sum has too: the compiler would take it from there, lane by lane.
    #[inline(always)]
    pub(super) fn rotated(self) -> Self {
        let [a, b, c, _] = self.0;
        Self([b, c, a, a])
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

impl Div for Lanes {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] / other.0[i]))
    }
}

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

/// Four numbers that an algorithm is written for once: as [`Lanes`], or as the machine's own register.
pub(super) trait Vector:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    fn from_array(numbers: [f64; WIDTH]) -> Self;

    fn to_array(self) -> [f64; WIDTH];

    /// The same number everywhere.
    fn all(value: f64) -> Self;

    /// Everywhere what is in one lane.
    #[inline(always)]
    fn lane(self, i: usize) -> Self {
        Self::all(self.to_array()[i])
    }

    /// The first three moved on by one place, see [`Lanes::rotated`].
    fn rotated(self) -> Self;
}

impl Vector for Lanes {
    #[inline(always)]
    fn from_array(numbers: [f64; WIDTH]) -> Self {
        Self(numbers)
    }

    #[inline(always)]
    fn to_array(self) -> [f64; WIDTH] {
        self.0
    }

    #[inline(always)]
    fn all(value: f64) -> Self {
        Self::all(value)
    }

    #[inline(always)]
    fn rotated(self) -> Self {
        self.rotated()
    }
}

/// What a sweep carries for each state: the linear part of the cost-to-go alone, or `Ψ`'s row and, in the last lane,
/// that.
pub(super) trait Row<V>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Whether `Ψ` is in it.
    const HAS_TERMINAL: bool;

    /// The same number everywhere.
    fn splat(value: f64) -> Self;

    /// A number for the linear part, zero for `Ψ`.
    fn linear(value: f64) -> Self;

    /// From all four numbers.
    fn of(lanes: V) -> Self;

    /// All four numbers, zero where there is no `Ψ`.
    fn lanes(self) -> V;
}

impl<V: Vector> Row<V> for f64 {
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
    fn of(lanes: V) -> Self {
        lanes.to_array()[3]
    }

    #[inline(always)]
    fn lanes(self) -> V {
        V::from_array([0.0, 0.0, 0.0, self])
    }
}

impl<V: Vector> Row<V> for V {
    const HAS_TERMINAL: bool = true;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::all(value)
    }

    #[inline(always)]
    fn linear(value: f64) -> Self {
        Self::from_array([0.0, 0.0, 0.0, value])
    }

    #[inline(always)]
    fn of(lanes: V) -> Self {
        lanes
    }

    #[inline(always)]
    fn lanes(self) -> V {
        self
    }
}
