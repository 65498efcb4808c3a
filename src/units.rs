//! Physical constants, decibels, factors of numbers, and figures as text.
//!
//! Quantities carry their unit in the name (`carrier_hz`, `delay_s`, `range_m`); the few numbers
//! that are easy to mistake for one another at the interface of a module are newtypes.

/// Speed of light in vacuum, m/s (exact).
pub const SPEED_OF_LIGHT_MPS: f64 = 299_792_458.0;
/// Boltzmann constant, J/K (exact).
pub const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;
/// Reference noise temperature T0, K (IEEE definition of the noise figure).
pub const NOISE_TEMPERATURE_K: f64 = 290.0;
/// Mean Earth radius used for the drop of the sea surface, m.
pub const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// One international foot, m (exact).
pub const FOOT_M: f64 = 0.3048;
/// One knot, m/s (exact).
pub const KNOT_MPS: f64 = 1852.0 / 3600.0;

/// Whether a number is a product of some primes: a length of a fast transform.
///
/// ```
/// use nereus::units::is_product_of;
/// assert!(is_product_of(&[2, 3, 5], 360) && is_product_of(&[2], 1));
/// assert!(!is_product_of(&[2, 3, 5], 14) && !is_product_of(&[2], 0));
/// ```
pub fn is_product_of(primes: &[usize], mut n: usize) -> bool {
    for p in primes {
        while n > 0 && n.is_multiple_of(*p) {
            n /= p;
        }
    }
    n == 1
}

/// The least product of some primes that is not below `least`, or `least` where there is none.
pub fn next_product_of(primes: &[usize], least: usize) -> usize {
    (least.max(1)..).find(|n| is_product_of(primes, *n)).unwrap_or(least)
}

/// Samples that a length of time spans at a rate, one at least: `ceil(T fs)`, not counting one that rounding
/// alone would add.
pub fn spanned_samples(length_s: f64, sample_rate_hz: f64) -> usize {
    ((length_s * sample_rate_hz * (1.0 - 4.0 * f64::EPSILON)).ceil() as usize).max(1)
}

/// The entry that belongs to a number where entries recur in turn: `number` modulo how many there are; `None`
/// of none.
pub fn in_turn<T>(of: &[T], number: u64) -> Option<&T> {
    of.get(number.checked_rem(of.len() as u64)? as usize)
}

/// The least even number from `least` on that has no prime factor above 5: a length of a fast transform.
pub fn fast_len(least: usize) -> usize {
    2 * next_product_of(&[2, 3, 5], least.div_ceil(2))
}

/// `(node, weight)` of the positive half of Gauss-Legendre's rule with 16 points on [-1, 1] (Abramowitz and
/// Stegun, table 25.4).
pub const GAUSS_16: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];

/// Greatest common divisor.
pub fn common_divisor(mut a: usize, mut b: usize) -> usize {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// A power ratio in decibels.
///
/// ```
/// use nereus::units::Decibels;
/// assert!((Decibels(3.0).power_ratio() - 1.995_262_314_968_88).abs() < 1e-12);
/// assert!((Decibels::from_power_ratio(100.0).0 - 20.0).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Decibels(pub f64);

impl Decibels {
    /// `10^(dB/10)`.
    pub fn power_ratio(self) -> f64 {
        10f64.powf(self.0 / 10.0)
    }

    /// `10^(dB/20)`.
    pub fn amplitude_ratio(self) -> f64 {
        10f64.powf(self.0 / 20.0)
    }

    /// `10 log10(ratio)`; minus infinity for zero.
    pub fn from_power_ratio(ratio: f64) -> Self {
        Self(10.0 * ratio.log10())
    }
}
/// `sin(pi t) / t` in `t^2`, minimax for `|t| <= 1/2`: 6.6e-9.
pub const SINE_OF_HALF_TURNS: [f32; 5] = [3.141_592_5, -5.167_703_7, 2.549_985, -0.597_798, 0.076_780_86];
/// `cos(pi t)` in `t^2`, minimax for `|t| <= 1/2`: 4.7e-8.
pub const COSINE_OF_HALF_TURNS: [f32; 5] = [0.999_999_94, -4.934_793, 4.058_412, -1.331_880_2, 0.219_696_8];

/// Cosine and sine of a phase in turns, in f32, from f64: whole turns are taken out before anything is
/// rounded. Error 5e-7.
///
/// ```
/// use nereus::units::cos_sin_of_turns;
/// let (cos, sin) = cos_sin_of_turns(1e6 + 0.25);
/// assert!(cos.abs() < 5e-7 && (sin - 1.0).abs() < 5e-7);
/// ```
#[inline(always)]
pub fn cos_sin_of_turns(turns: f64) -> (f32, f32) {
    // Rounds to the nearest integer without asking the CPU for an instruction.
    const TO_INTEGER: f64 = 6_755_399_441_055_744.0;
    let t = (turns - ((turns + TO_INTEGER) - TO_INTEGER)) as f32;
    let z = t * t;
    let series = |c: [f32; 5]| c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * c[4])));
    let (s, c) = (t * series(SINE_OF_HALF_TURNS), series(COSINE_OF_HALF_TURNS));
    (1.0 - 2.0 * s * s, 2.0 * s * c)
}

/// `e^x` for `x <= 0`, relative error 2e-7; 0 below -86.
#[inline(always)]
pub fn exponential(x: f32) -> f32 {
    const TO_INTEGER: f32 = 12_582_912.0;
    let turns = x.max(-86.0) * std::f32::consts::LOG2_E;
    let shifted = turns + TO_INTEGER;
    let whole = shifted - TO_INTEGER;
    // 2^f = e^(f ln 2), f in [-1/2, 1/2]; Taylor, remainder 1e-8.
    let f = (turns - whole) * std::f32::consts::LN_2;
    let series =
        1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f / 720.0)))));
    let bits = (shifted.to_bits() as i32).wrapping_sub(TO_INTEGER.to_bits() as i32);
    let scale = f32::from_bits((bits.wrapping_add(127) as u32) << 23);
    if x < -86.0 { 0.0 } else { series * scale }
}

/// Cosine and sine of an angle in degrees, exact at right angles: straight back is straight back, and
/// crosswind is neither up- nor downwind.
pub(crate) fn cos_sin_of_degrees(angle_deg: f64) -> (f64, f64) {
    match angle_deg.rem_euclid(360.0) {
        0.0 => (1.0, 0.0),
        90.0 => (0.0, 1.0),
        180.0 => (-1.0, 0.0),
        270.0 => (0.0, -1.0),
        turned => {
            let (sin, cos) = turned.to_radians().sin_cos();
            (cos, sin)
        }
    }
}

/// A scaled figure without the last digits that scaling made up.
pub(crate) fn neat(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Two digits, or all before the point.
pub(crate) fn digits(value: f64) -> String {
    if !(value > 0.0 && value.is_finite()) {
        return format!("{value}");
    }
    let decimals = (1 - value.log10().floor() as i64).clamp(0, 12) as usize;
    format!("{value:.decimals$}")
}

/// So many of something: `1 pulse`, `2 pulses`.
pub(crate) fn counted<N: std::fmt::Display + PartialEq + From<u8>>(count: N, what: &str) -> String {
    let plural = if count == N::from(1) { "" } else { "s" };
    format!("{count} {what}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials() {
        for i in 0..9000 {
            let x = -0.01 * i as f32;
            let exact = f64::from(x).exp();
            let found = f64::from(exponential(x));
            // Eight roundings of 2^-24, and the argument's own (86 turns into 124 of 2^-24 of them).
            let slack = (8.0 + 124.0 * 0.7) * 2f64.powi(-24);
            assert!((found - exact).abs() <= slack * exact || x < -86.0 && found == 0.0, "{x}");
        }
    }
}
