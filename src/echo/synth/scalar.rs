//! The two precisions of the fast echo: how each holds a phase, turns it into a phasor and finds a cell.
//!
//! Phase of a scatterer path over a block, in turns, `m` the whole number of pulses from the middle of the
//! block:
//!
//! `phi(m) = phi0 + phi1 m + phi2 m^2 + phi3 m^3`, modulo 1.
//!
//! | precision | `phi0 phi1 phi2` | `phi3` | error at `abs m <= 32` |
//! | --- | --- | --- | --- |
//! | `f32` | u32 fractions of a turn (`2^-32`), so whole turns vanish and products with `m`, `m^2` are exact modulo 1 | float | `2^-33 (1 + 32 + 1024)` turn `= 7.7e-7` rad, and `2^-24 abs(phi3 m^3)` turn |
//! | `f64` | fractions within half a turn | float | `2^-53 x 530` turn |
//!
//! Where intervals differ `m` is no whole number. It is cut into whole **ticks**, of which an interval has
//! 256, and what is left: `phi1` times the ticks is exact modulo 1, `phi1` times the rest is below
//! `phi1/512`, and the powers above are floats: rounded to `2^-24` of the turns that they add at the end of
//! an interval between nodes, of which there are few.
//!
//! Phasor of `t` in `[-1/2, 1/2]` turn in f32: `s = sin(pi t)`, `c = cos(pi t)` by minimax polynomials in
//! `t^2` (errors 6.6e-9 and 4.7e-8), then `cos(2 pi t) = 1 - 2 s^2`, `sin(2 pi t) = 2 s c`. In f64:
//! [`phasor`].

use super::Precision;
use crate::radar::phasor::phasor;
use crate::units::{COSINE_OF_HALF_TURNS, SINE_OF_HALF_TURNS};

/// Adding it rounds an f32 below `2^22` to the nearest integer, which its low bits then hold.
const TO_INTEGER_F32: f32 = 12_582_912.0;
/// The same for an f64 below `2^51`.
const TO_INTEGER_F64: f64 = 6_755_399_441_055_744.0;

mod sealed {
    use super::super::variant::{Body, body_f32, body_f64};
    use crate::cpu::Variant;

    pub trait Sealed: Sized {
        /// The inner loop of a variant that is available.
        fn body(variant: Variant, width: usize, lanes: usize) -> Body<Self>
        where
            Self: super::Scalar;
    }

    impl Sealed for f32 {
        fn body(variant: Variant, width: usize, lanes: usize) -> Body<Self> {
            body_f32(variant, width, lanes)
        }
    }

    impl Sealed for f64 {
        fn body(variant: Variant, width: usize, lanes: usize) -> Body<Self> {
            body_f64(variant, width, lanes)
        }
    }
}

/// A floating-point type in which the fast echo is made.
pub trait Scalar: nereus_fft::Precision + Default + PartialOrd + Into<f64> + sealed::Sealed {
    /// Which it is.
    const PRECISION: Precision;
    /// A phase modulo one turn.
    type Turns: Copy + Default + std::fmt::Debug + Send + Sync;
    /// Rounded from f64.
    fn round_from(value: f64) -> Self;
    /// The fraction of a phase, turns.
    fn turns(value: f64) -> Self::Turns;
    /// The sum of two phases.
    fn sum(a: Self::Turns, b: Self::Turns) -> Self::Turns;
    /// `phi(m)`, in `[-1/2, 1/2]`.
    fn phase(phi: [Self::Turns; 3], cubic: Self, m: i32) -> Self;
    /// `phi0 + phi1 ticks + high`, in `[-1/2, 1/2]`.
    fn uneven_phase(phi0: Self::Turns, phi1: Self::Turns, ticks: i32, high: Self) -> Self;
    /// `a b + c`, rounded once if `FUSED`.
    fn fma<const FUSED: bool>(a: Self, b: Self, c: Self) -> Self;
    /// `(cos, sin)(2 pi t)` of `t` in `[-1/2, 1/2]`.
    fn phasor<const FUSED: bool>(t: Self) -> (Self, Self);
    /// The nearest integer of a number below `2^21` in size, both as integer and as number.
    fn nearest(y: Self) -> (i32, Self);
}

impl Scalar for f32 {
    const PRECISION: Precision = Precision::Single;
    type Turns = u32;

    #[inline(always)]
    fn round_from(value: f64) -> Self {
        value as f32
    }

    #[inline(always)]
    fn turns(value: f64) -> u32 {
        // 2^32 itself wraps to 0.
        ((value - value.floor()) * 4_294_967_296.0).round() as u64 as u32
    }

    #[inline(always)]
    fn sum(a: u32, b: u32) -> u32 {
        a.wrapping_add(b)
    }

    #[inline(always)]
    fn phase(phi: [u32; 3], cubic: f32, m: i32) -> f32 {
        let m1 = m as u32;
        let exact = phi[0]
            .wrapping_add(phi[1].wrapping_mul(m1))
            .wrapping_add(phi[2].wrapping_mul(m1.wrapping_mul(m1)));
        let m = m as f32;
        let t = (exact as i32) as f32 * (1.0 / 4_294_967_296.0) + cubic * (m * m * m);
        t - ((t + TO_INTEGER_F32) - TO_INTEGER_F32)
    }

    #[inline(always)]
    fn uneven_phase(phi0: u32, phi1: u32, ticks: i32, high: f32) -> f32 {
        let exact = phi0.wrapping_add(phi1.wrapping_mul(ticks as u32));
        let t = (exact as i32) as f32 * (1.0 / 4_294_967_296.0) + high;
        t - ((t + TO_INTEGER_F32) - TO_INTEGER_F32)
    }

    #[inline(always)]
    fn fma<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
        if FUSED { a.mul_add(b, c) } else { a * b + c }
    }

    #[inline(always)]
    fn phasor<const FUSED: bool>(t: f32) -> (f32, f32) {
        let z = t * t;
        let series = |c: &[f32; 5]| {
            let high = Self::fma::<FUSED>(Self::fma::<FUSED>(c[4], z, c[3]), z, c[2]);
            Self::fma::<FUSED>(Self::fma::<FUSED>(high, z, c[1]), z, c[0])
        };
        let (s, c) = (t * series(&SINE_OF_HALF_TURNS), series(&COSINE_OF_HALF_TURNS));
        let twice = s + s;
        (1.0 - twice * s, twice * c)
    }

    #[inline(always)]
    fn nearest(y: f32) -> (i32, f32) {
        let shifted = y + TO_INTEGER_F32;
        ((shifted.to_bits() as i32).wrapping_sub(TO_INTEGER_F32.to_bits() as i32), shifted - TO_INTEGER_F32)
    }
}

impl Scalar for f64 {
    const PRECISION: Precision = Precision::Double;
    type Turns = f64;

    #[inline(always)]
    fn round_from(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn turns(value: f64) -> f64 {
        value - value.round()
    }

    #[inline(always)]
    fn sum(a: f64, b: f64) -> f64 {
        a + b
    }

    #[inline(always)]
    fn phase(phi: [f64; 3], cubic: f64, m: i32) -> f64 {
        let m = f64::from(m);
        let t = phi[0] + m * (phi[1] + m * (phi[2] + m * cubic));
        t - ((t + TO_INTEGER_F64) - TO_INTEGER_F64)
    }

    #[inline(always)]
    fn uneven_phase(phi0: f64, phi1: f64, ticks: i32, high: f64) -> f64 {
        let t = phi0 + phi1 * f64::from(ticks) + high;
        t - ((t + TO_INTEGER_F64) - TO_INTEGER_F64)
    }

    #[inline(always)]
    fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
        if FUSED { a.mul_add(b, c) } else { a * b + c }
    }

    #[inline(always)]
    fn phasor<const FUSED: bool>(t: f64) -> (f64, f64) {
        let z = phasor(t);
        (z.re, z.im)
    }

    #[inline(always)]
    fn nearest(y: f64) -> (i32, f64) {
        let whole = (y + TO_INTEGER_F64) - TO_INTEGER_F64;
        (whole as i32, whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phasors_in_f32_are_those_in_f64() {
        let mut worst = 0.0f64;
        for i in -50_000..=50_000 {
            let t = i as f32 / 100_000.0;
            let (c, s) = <f32 as Scalar>::phasor::<false>(t);
            let exact = phasor(f64::from(t));
            worst = worst.max((f64::from(c) - exact.re).hypot(f64::from(s) - exact.im));
        }
        println!("worst f32 phasor error {worst:.2e}");
        // Half units in the last place, all added up, of coefficients (times z^i <= 4^-i), of the sums and
        // products of Horner's rule and of the polynomials themselves: 2.6e-7 for s, 3.4e-7 for c. Then d(1 -
        // 2 s^2) <= 4 ds, d(2 s c) <= 2 dc at s = 1.
        assert!(worst < (4.0 * 2.6e-7f64).hypot(2.0 * 3.4e-7), "{worst}");
    }

    #[test]
    fn phases_are_the_polynomial_modulo_one_turn() {
        let mut worst = [0.0f64; 2];
        for i in 0..200 {
            let x = f64::from(i);
            let p = [240_123.1 + 0.37 * x, 66.6 - 0.91 * x, 0.0157 * (x - 90.0), 1e-6 * (x - 100.0)];
            for m in -32..=31 {
                let s = f64::from(m);
                let exact = p[0] + s * (p[1] + s * (p[2] + s * p[3]));
                let single =
                    <f32 as Scalar>::phase([0, 1, 2].map(|k| <f32 as Scalar>::turns(p[k])), p[3] as f32, m);
                let double = <f64 as Scalar>::phase([0, 1, 2].map(|k| <f64 as Scalar>::turns(p[k])), p[3], m);
                for (worst, t) in worst.iter_mut().zip([f64::from(single), double]) {
                    let error = t - exact;
                    assert!(t.abs() <= 0.5 + 1e-6);
                    *worst = worst.max((error - error.round()).abs());
                }
            }
        }
        println!("worst phase error: f32 {:.2e}, f64 {:.2e} turn", worst[0], worst[1]);
        // Coefficients 2^-33 (1 + 32 + 1024), cubic (3.3 turns) and its power and product 3 x 2^-24 x 3.3,
        // sum and fraction 2^-24 x 4.
        assert!(worst[0] < 1057.0 * 2f64.powi(-33) + 14.0 * 2f64.powi(-24), "{}", worst[0]);
        // The exact sum itself is rounded at 2.5e5 turns: 3 x 2^-35.
        assert!(worst[1] < 3.0 * 2f64.powi(-35), "{}", worst[1]);
    }

    #[test]
    fn phases_between_whole_intervals() {
        use super::super::spread::{Emitted, TICKS};
        let mut worst = 0.0f64;
        for i in 0..200 {
            let x = f64::from(i);
            let p = [240_123.1 + 0.37 * x, 66.6 - 0.91 * x, 1.57e-4 * (x - 90.0), 1e-6 * (x - 100.0)];
            for m in -300..=300 {
                let time = 0.1031 * f64::from(m);
                let exact = p[0] + time * (p[1] + time * (p[2] + time * p[3]));
                let Emitted { ticks, rest, time, .. } =
                    Emitted::<f32>::new((0, 0.0), [time; 2], (0, 0), true);
                let high = time * time * (p[3] as f32 * time + p[2] as f32) + p[1] as f32 * rest;
                let [phi0, phi1] = [p[0], p[1] / TICKS].map(<f32 as Scalar>::turns);
                let error = f64::from(<f32 as Scalar>::uneven_phase(phi0, phi1, ticks, high)) - exact;
                worst = worst.max((error - error.round()).abs());
            }
        }
        println!("worst phase error where intervals differ: f32 {worst:.2e} turn");
        // Coefficients 2^-33 (1 + 31 x 256); square and cube, 20 turns at most, are rounded four times.
        assert!(worst < 7937.0 * 2f64.powi(-33) + 4.0 * 2f64.powi(-24) * 20.0, "{worst}");
    }

    #[test]
    fn nearest_integers_below_two_million() {
        for y in [0.0f32, 0.49, 0.51, -0.51, 1.5, 2.5, 1_999_999.4, -1_999_999.6] {
            assert_eq!(<f32 as Scalar>::nearest(y).0, y.round_ties_even() as i32);
            assert_eq!(<f64 as Scalar>::nearest(y.into()).0, y.round_ties_even() as i32);
            assert_eq!(<f32 as Scalar>::nearest(y).1, y.round_ties_even());
        }
    }
}
