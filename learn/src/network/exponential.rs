//! `exp` and `ln` that the compiler can turn into vector instructions: the library's are called one number at a time, and
//! differ from one library to the next.

use super::{greater, lesser};

/// `e^x`, to 2 units in the last place; `x` is clamped to where that is a normal number.
///
/// `x = n ln 2 + r`, `|r| <= ln 2 / 2`, and a Taylor polynomial in `r`, as Cody and Waite (1980) reduce it.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    /// Adding it rounds to a whole number, which then stands in the lowest bits.
    const ROUND: f32 = 12_582_912.0;
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let x = lesser(greater(x, -87.0), 88.0);
    let shifted = x.mul_add(std::f32::consts::LOG2_E, ROUND);
    let whole = shifted - ROUND;
    let rest = whole.mul_add(-LN_2_LOW, whole.mul_add(-LN_2_HIGH, x));
    let mut power = 1.0 / 720.0_f32;
    for coefficient in [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0] {
        power = power.mul_add(rest, coefficient);
    }
    let exponent = shifted.to_bits().wrapping_sub(ROUND.to_bits()).wrapping_add(127) << 23;
    power * f32::from_bits(exponent)
}

/// `ln x` of a positive normal number, to 3e-7.
///
/// `x = 2^n m`, `m` from `sqrt 1/2` to `sqrt 2`, and `ln m = 2 artanh((m - 1) / (m + 1))` as its Taylor series.
#[inline(always)]
pub(super) fn ln(x: f32) -> f32 {
    const LEAST_MANTISSA: u32 = std::f32::consts::FRAC_1_SQRT_2.to_bits();
    let power = x.to_bits().wrapping_sub(LEAST_MANTISSA).cast_signed() >> 23;
    let mantissa = f32::from_bits(x.to_bits().wrapping_sub((power << 23).cast_unsigned()));
    let ratio = (mantissa - 1.0) / (mantissa + 1.0);
    let square = ratio * ratio;
    let mut series = 2.0 / 9.0_f32;
    for coefficient in [2.0 / 7.0, 2.0 / 5.0, 2.0 / 3.0, 2.0] {
        series = series.mul_add(square, coefficient);
    }
    series.mul_add(ratio, power as f32 * std::f32::consts::LN_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_agree_with_the_library() {
        for step in -8700..8800 {
            let x = step as f32 / 100.0;
            let expected = f64::from(x).exp();
            let error = (f64::from(exp(x)) / expected - 1.0).abs();
            assert!(error < 3e-7, "exp({x}): {} instead of {expected}", exp(x));
        }
        for step in -1380..3000 {
            let x = (f64::from(step) / 100.0).exp();
            #[expect(clippy::cast_possible_truncation, reason = "that is what it takes")]
            let error = (f64::from(ln(x as f32)) - f64::from(x as f32).ln()).abs();
            assert!(error < 3e-7 * x.ln().abs().max(1.0), "ln({x}): {error}");
        }
        assert!(exp(-1e9) < 1e-37 && exp(-1e9) > 0.0);
    }
}
