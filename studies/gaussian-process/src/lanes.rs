//! Numbers side by side, as a processor computes them.
//!
//! Each lane goes its own way, and no operation is contracted: the width of the processor changes no bit.

/// Numbers that are computed side by side: enough that one addition need not wait for the one before it.
pub(crate) const LANES: usize = 16;

pub(crate) type Lanes = [f64; LANES];

/// Bits of ln 2 that a product with a small whole number keeps, and the rest of it.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// Added to a number, it leaves its nearest whole number in the last bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// Below it, the exponential is 0 beside 1 by far: no result is denormal.
const LEAST: f64 = -700.0;

/// The exponential of numbers that are not above 0.
///
/// ```text
/// exp(x) = 2^k exp(f),   k = round(x / ln 2),   f = x − k ln 2,   exp(f) = Σ f^n / n!   up to n = 12
/// ```
#[inline(always)]
pub(crate) fn exp(x: &Lanes) -> Lanes {
    let mut result = [0.0; LANES];
    for lane in 0..LANES {
        let x = x[lane].max(LEAST);
        let shifted = x * std::f64::consts::LOG2_E + WHOLE;
        let k = shifted - WHOLE;
        let f = (x - k * LN_2[0]) - k * LN_2[1];
        let mut sum = INVERSE_FACTORIALS[0];
        for inverse in &INVERSE_FACTORIALS[1..] {
            sum = sum * f + inverse;
        }
        let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
        result[lane] = sum * scale;
    }
    result
}

/// 1/12!, 1/11!, … 1/0!.
const INVERSE_FACTORIALS: [f64; 13] = {
    let mut all = [1.0; 13];
    let (mut n, mut factorial) = (1, 1.0);
    while n < 13 {
        factorial *= n as f64;
        all[12 - n] = 1.0 / factorial;
        n += 1;
    }
    all
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_that_of_libm() {
        let mut x = 0.0;
        while x > -690.0 {
            let all: Lanes = std::array::from_fn(|lane| x - 1e-3 * lane as f64);
            for (x, found) in all.into_iter().zip(exp(&all)) {
                let expected = libm::exp(x);
                assert!(
                    (found - expected).abs() <= 4e-16 * expected,
                    "{x}: {found:e} {expected:e}"
                );
            }
            x -= 0.377;
        }
        assert_eq!(exp(&[0.0; LANES]), [1.0; LANES]);
        assert!(exp(&[f64::NEG_INFINITY; LANES])[0] < 1e-300);
    }
}
