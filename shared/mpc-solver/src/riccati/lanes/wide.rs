//! Wide registers of x86-64 (AVX2), for loops that the compiler does not vectorise.

#![allow(
    unsafe_code,
    reason = "the machine's own instructions; see `Wide` for why they may be used"
)]

use std::arch::x86_64::{
    __m256d, _mm256_add_pd, _mm256_loadu_pd, _mm256_mul_pd, _mm256_permute4x64_pd, _mm256_set1_pd,
    _mm256_storeu_pd, _mm256_sub_pd,
};
use std::ops::{Add, Mul, Sub};

use super::{Vector, WIDTH};

/// Returns whether this machine has AVX2.
pub(in crate::riccati) fn is_available() -> bool {
    std::arch::is_x86_feature_detected!("avx2")
}

/// Four numbers in a register. Only functions with the target feature `avx2` construct one, and
/// they are called only if [`is_available`]. So its operations may use the instructions.
#[derive(Clone, Copy, Debug)]
pub(in crate::riccati) struct Wide(__m256d);

impl Vector for Wide {
    #[inline(always)]
    fn from_array(numbers: [f64; WIDTH]) -> Self {
        // SAFETY: the four numbers are readable; AVX: see `Wide`.
        Self(unsafe { _mm256_loadu_pd(numbers.as_ptr()) })
    }

    #[inline(always)]
    fn to_array(self) -> [f64; WIDTH] {
        let mut numbers = [0.0; WIDTH];
        // SAFETY: the four numbers are writable; AVX: see `Wide`.
        unsafe { _mm256_storeu_pd(numbers.as_mut_ptr(), self.0) };
        numbers
    }

    #[inline(always)]
    fn all(value: f64) -> Self {
        // SAFETY: AVX: see `Wide`.
        Self(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn rotated(self) -> Self {
        // SAFETY: AVX2: see `Wide`.
        Self(unsafe { _mm256_permute4x64_pd::<0b00_00_10_01>(self.0) })
    }
}

impl Add for Wide {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // SAFETY: AVX: see `Wide`.
        Self(unsafe { _mm256_add_pd(self.0, other.0) })
    }
}

impl Sub for Wide {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        // SAFETY: AVX: see `Wide`.
        Self(unsafe { _mm256_sub_pd(self.0, other.0) })
    }
}

impl Mul for Wide {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        // SAFETY: AVX: see `Wide`.
        Self(unsafe { _mm256_mul_pd(self.0, other.0) })
    }
}
