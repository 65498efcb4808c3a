//! `exp(j 2 pi x)` of a phase counted in turns.
//!
//! Phases of a radar echo are large (`f0 tau` is 2.4e5 turns at 3.6 km and X band, 5e7 from orbit) and only
//! their fraction matters. In turns the reduction is exact: `x - round(4x)/4` has no rounding error for
//! `|x| < 2^49`, so the result is as exact as `x` itself. What is left, at most 1/8 turn, goes through the
//! Taylor series of sine (to `y^17`) and cosine (to `y^16`), whose first neglected terms are below 1e-17.
//!
//! ```
//! use nereus::radar::phasor::phasor;
//! let quarter = phasor(1_000_000.25);
//! assert!((quarter.re).abs() < 1e-15 && (quarter.im - 1.0).abs() < 1e-15);
//! ```

use num_complex::Complex64;

/// Adding it rounds a number below `2^51` to the nearest integer.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// 1/3!, 1/5!, ... with alternating signs.
const SINE: [f64; 8] = {
    let mut c = [0.0; 8];
    let (mut n, mut factorial, mut sign) = (0, 1.0, 1.0);
    while n < 8 {
        factorial *= ((2 * n + 2) * (2 * n + 3)) as f64;
        sign = -sign;
        c[n] = sign / factorial;
        n += 1;
    }
    c
};

/// 1/2!, 1/4!, ... with alternating signs.
const COSINE: [f64; 8] = {
    let mut c = [0.0; 8];
    let (mut n, mut factorial, mut sign) = (0, 1.0, 1.0);
    while n < 8 {
        factorial *= ((2 * n + 1) * (2 * n + 2)) as f64;
        sign = -sign;
        c[n] = sign / factorial;
        n += 1;
    }
    c
};

/// `sum c_i z^i`, by halves so that the two chains run side by side.
#[inline(always)]
fn series(c: &[f64; 8], z: f64) -> f64 {
    let z2 = z * z;
    let even = ((c[6] * z2 + c[4]) * z2 + c[2]) * z2 + c[0];
    let odd = ((c[7] * z2 + c[5]) * z2 + c[3]) * z2 + c[1];
    even + z * odd
}

/// `exp(j 2 pi turns)`.
#[inline(always)]
pub fn phasor(turns: f64) -> Complex64 {
    let shifted = turns * 4.0 + TO_INTEGER;
    let quarters = shifted - TO_INTEGER;
    let y = (turns - 0.25 * quarters) * std::f64::consts::TAU;
    let z = y * y;
    let sin = y + y * z * series(&SINE, z);
    let cos = 1.0 + z * series(&COSINE, z);
    // The last two bits of the mantissa are the quadrant. (An exponent beyond 2^51 leaves some quadrant.)
    match shifted.to_bits() & 3 {
        0 => Complex64::new(cos, sin),
        1 => Complex64::new(-sin, cos),
        2 => Complex64::new(-cos, -sin),
        _ => Complex64::new(sin, -cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_standard_library_in_every_quadrant() {
        let mut worst = 0.0f64;
        for i in -40_000..=40_000 {
            let x = f64::from(i) / 10_007.0;
            let fraction = x - x.round();
            let (sin, cos) = (std::f64::consts::TAU * fraction).sin_cos();
            worst = worst.max((phasor(x) - Complex64::new(cos, sin)).norm());
        }
        println!("worst phasor error {worst:.2e}");
        // Two roundings of a component of size 1, and one of 2 pi y in the argument: 5 x 1.1e-16.
        assert!(worst < 5.6e-16, "{worst}");
    }

    #[test]
    fn whole_turns_change_nothing() {
        for x in [0.1, 0.25, -0.3, 0.4999] {
            // 2^20 turns cost 20 bits of x and nothing else.
            let far = phasor(x + 1_048_576.0);
            assert!((far - phasor(x)).norm() < 1e-9);
            let exact = phasor((x + 1_048_576.0) - 1_048_576.0);
            assert_eq!(far, exact);
        }
        for x in [1e15, 1e300, -1e300] {
            assert!(phasor(x).is_finite());
        }
    }
}
