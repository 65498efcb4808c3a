//! A random process with a given line in its spectrum, without a state: components of fixed frequency whose
//! weights follow the line.
//!
//! Frequencies are cut into cells of a width `d`; every cell of a facet has one component, of a frequency
//! `omega_m` anywhere in it and a phase `phi_m`, drawn once:
//!
//! `gamma(t) = sum_m sqrt(d f(omega_m)) e^{j (omega_m t + phi_m)}`, `f = (315/256) (1 - x^2)^4 / R`,
//! `x = (omega - Omega)/R`, `R = sqrt(11) s`
//!
//! `f` is a bell of mean `Omega` and deviation `s` that ends at `R`: near a Gaussian (kurtosis 2.5). `Omega`
//! and `s` change as antennas fly past. The phase of a component does not know of it, so that its rate is
//! `omega_m` at any time after the start; a phase `Omega(t) t` would be off by `t dOmega/dt`. The mean power
//! is 1; at any instant about `3.7 s/d` components of equal weight make it.

use num_complex::Complex64;

use std::f64::consts::TAU;

/// The bell's end in deviations.
const END: f64 = 3.316_624_790_355_4;
/// Its height at the middle times its end.
const HEIGHT: f64 = 315.0 / 256.0;
/// Least deviation in cells: narrower lines have no component to carry them.
const LEAST_CELLS: f64 = 0.5;

/// A line: what it returns, where it is and how wide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Root of its share of the power.
    pub amplitude: f64,
    /// Angular frequency of its middle, rad/s; positive where echoes come closer.
    pub centre_radps: f64,
    /// Rms deviation from it, rad/s.
    pub deviation_radps: f64,
}

/// Cells of frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comb {
    step_radps: f64,
    gaussian: bool,
}

impl Comb {
    /// Of cells so wide, whose components are of one amplitude.
    pub fn new(step_radps: f64) -> Self {
        Self { step_radps: step_radps.max(f64::MIN_POSITIVE), gaussian: false }
    }

    /// The same with components of complex Gaussian amplitude. So is their sum but for the random power of
    /// the cells that a line meets: the mean square of powers is 2.02 with three cells in its bell's end, and
    /// 2.14 in the narrowest line.
    pub fn gaussian(self) -> Self {
        Self { gaussian: true, ..self }
    }

    /// Whether components have [`Self::amplitude`].
    #[inline(always)]
    pub fn is_gaussian(&self) -> bool {
        self.gaussian
    }

    /// Amplitude of the component of a cell, of unit mean power.
    #[inline(always)]
    pub fn amplitude(facet: u64, number: u32, cell: i32) -> f32 {
        let [place, turns] = of_cell(facet, number, cell);
        // Half a step off 0, which has no logarithm.
        let share = (share(scrambled(place ^ turns.rotate_left(16))) + 0.5f64.powi(33)) as f32;
        (-logarithm(share)).max(0.0).sqrt()
    }

    /// Width of the cells, rad/s.
    pub fn step_radps(&self) -> f64 {
        self.step_radps
    }

    /// Where a line of a deviation ends to either side of its middle, rad/s.
    #[inline(always)]
    pub fn end_radps(&self, deviation_radps: f64) -> f64 {
        END * deviation_radps.max(LEAST_CELLS * self.step_radps)
    }

    /// What a component in the middle of a line has.
    #[inline]
    pub fn height(&self, line: Line) -> f64 {
        line.amplitude * (HEIGHT * self.step_radps / self.end_radps(line.deviation_radps)).sqrt()
    }

    /// Inverse of the end of a line of a deviation, s/rad, and what a component in its middle has over the
    /// root of its share.
    #[inline(always)]
    pub fn bell(&self, deviation_radps: f32) -> [f32; 2] {
        let step_radps = self.step_radps as f32;
        let inverse = 1.0 / (END as f32 * deviation_radps.max(LEAST_CELLS as f32 * step_radps));
        [inverse, (HEIGHT as f32 * step_radps * inverse).sqrt()]
    }

    /// Angular frequency, rad/s, and phase at the start, turns, of the component of a cell: `facet` is the
    /// facet's random number, `number` that of the line.
    #[inline(always)]
    pub fn component(&self, facet: u64, number: u32, cell: i32) -> (f64, f64) {
        let [place, turns] = of_cell(facet, number, cell).map(share);
        ((f64::from(cell) + place) * self.step_radps, turns)
    }

    /// A line at a time: `facet` is the facet's random number, `number` that of the line.
    pub fn phasor(&self, facet: u64, number: u32, line: Line, t_s: f64) -> Complex64 {
        if line.amplitude == 0.0 {
            return Complex64::ZERO;
        }
        let d = self.step_radps;
        let end = self.end_radps(line.deviation_radps);
        let (first, last) = ((line.centre_radps - end) / d, (line.centre_radps + end) / d);
        let mut sum = Complex64::ZERO;
        for cell in first.floor() as i32..=last.floor() as i32 {
            let (omega_radps, start) = self.component(facet, number, cell);
            let x = (omega_radps - line.centre_radps) / end;
            let fall = 1.0 - x * x;
            if fall > 0.0 {
                let turns = (omega_radps * t_s / TAU).fract() + start;
                let (sin, cos) = (TAU * turns).sin_cos();
                let own = if self.gaussian { f64::from(Self::amplitude(facet, number, cell)) } else { 1.0 };
                sum += own * fall * fall * Complex64::new(cos, sin);
            }
        }
        sum * self.height(line)
    }
}

/// Random bits as a share of 1. Signed words, for they are what vectors convert at once.
#[inline(always)]
fn share(bits: u32) -> f64 {
    f64::from(bits.cast_signed()) * (1.0 / (1u64 << 32) as f64) + 0.5
}

/// Natural logarithm of a number from 2^-33 to 1, within 2e-7 of it or of 1:
/// `ln m = 2 artanh((m - 1)/(m + 1))` of the mantissa.
#[inline(always)]
fn logarithm(x: f32) -> f32 {
    // From the root of a half to that of 2.
    let bits = x.to_bits().wrapping_sub(0x3f35_04f3);
    let octaves = (bits.cast_signed() >> 23) as f32;
    let mantissa = f32::from_bits((bits & 0x007f_ffff).wrapping_add(0x3f35_04f3));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let y = s * s;
    2.0 * s * (1.0 + y * (1.0 / 3.0 + y * (0.2 + y * (1.0 / 7.0 + y * (1.0 / 9.0)))))
        + octaves * std::f32::consts::LN_2
}

/// Random bits of a cell, for its frequency and its phase: each half of the facet's number hashed with the
/// cell, in words of 32 bits, which vectors can multiply.
#[inline(always)]
fn of_cell(facet: u64, number: u32, cell: i32) -> [u32; 2] {
    let index = cell.cast_unsigned().wrapping_mul(4).wrapping_add(number);
    let low = (facet as u32).wrapping_add(index.wrapping_mul(0x9e37_79b9));
    let high = ((facet >> 32) as u32).wrapping_add(index.wrapping_mul(0x85eb_ca77));
    [scrambled(low), scrambled(high)]
}

/// The finaliser of MurmurHash3 (Appleby 2011).
#[inline(always)]
fn scrambled(mut z: u32) -> u32 {
    z = (z ^ (z >> 16)).wrapping_mul(0x85eb_ca6b);
    z = (z ^ (z >> 13)).wrapping_mul(0xc2b2_ae35);
    z ^ (z >> 16)
}

/// Random bits from others and an index: SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
#[inline(always)]
pub(super) fn mixed(from: u64, index: u64) -> u64 {
    let mut z = from.wrapping_add(0x9e37_79b9_7f4a_7c15u64.wrapping_mul(index.wrapping_add(1)));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_of_shares() {
        for n in 0..=33 {
            for m in 0..64 {
                let x = 0.5f32.powi(n) * (1.0 - m as f32 / 128.0);
                let (found, exact) = (f64::from(logarithm(x)), f64::from(x).ln());
                assert!((found - exact).abs() < 2e-7 * exact.abs().max(1.0), "{x}: {found} {exact}");
            }
        }
    }

    /// A line of one component at a time, or of four, is complex Gaussian: powers are exponential, to the
    /// fourth moment.
    #[test]
    fn gaussian_components_make_gaussian_sums() {
        const FACETS: u64 = 40_000;
        for step in [1.0, 4.0, 20.0] {
            let comb = Comb::new(step).gaussian();
            let mut moments = [0.0; 4];
            for facet in 0..FACETS {
                let power = comb.phasor(mixed(facet, 577), 3, line(5.0), 3.7).norm_sqr();
                for (n, moment) in (1..).zip(&mut moments) {
                    *moment += power.powi(n) / FACETS as f64;
                }
            }
            println!("{step}: {moments:?}");
            // Of an exponential law the moments are n!; their standard errors 0.005, 0.022, 0.13, 1. A
            // narrow line meets more or less of its cells.
            let more = if step > 10.0 { [0.0, 0.14, 1.2, 10.0] } else { [0.0; 4] };
            for ((moment, more), (exact, within)) in
                moments.iter().zip(more).zip([(1.0, 0.025), (2.0, 0.11), (6.0, 0.65), (24.0, 5.0)])
            {
                assert!((moment - more - exact).abs() < within, "{step}: {moments:?}");
            }
        }
    }

    fn line(deviation_radps: f64) -> Line {
        Line { amplitude: 1.0, centre_radps: 21.0, deviation_radps }
    }

    /// Covariance over many facets: power, mean frequency and width are those asked, whatever the time.
    #[test]
    fn power_centre_and_width_are_those_asked() {
        const FACETS: u64 = 20_000;
        for (deviation, step) in [(5.0, 1.0), (5.0, 4.0), (0.6, 1.0)] {
            let comb = Comb::new(step);
            for t_s in [0.0, 3.7, 1e6] {
                let lag_s = 0.2 / deviation;
                let (mut power, mut square, mut covariance) = (0.0, 0.0, Complex64::ZERO);
                for facet in 0..FACETS {
                    let facet = mixed(facet, 577);
                    let now = comb.phasor(facet, 3, line(deviation), t_s);
                    let later = comb.phasor(facet, 3, line(deviation), t_s + lag_s);
                    power += 0.5 * (now.norm_sqr() + later.norm_sqr()) / FACETS as f64;
                    square += now.norm_sqr().powi(2) / FACETS as f64;
                    covariance += now.conj() * later / FACETS as f64;
                }
                // From the middle on: the lag is several turns of narrow lines.
                let centre = 21.0 + (covariance * Complex64::cis(-21.0 * lag_s)).arg() / lag_s;
                let width = (2.0 * (1.0 - covariance.norm() / power)).sqrt() / lag_s;
                println!("{deviation} {step} {t_s}: {power:.3} {square:.3} {centre:.3} {width:.3}");
                // One in the root of 20 000 is 0.7 %, of a power that fluctuates by itself.
                assert!((power - 1.0).abs() < 0.03 && (centre - 21.0).abs() < 0.03 * deviation);
                assert!((width / deviation - 1.0).abs() < 0.03, "{width} {deviation}");
                // Components that are many are speckle: mean of squares 2.
                assert!(step > deviation / 4.0 || (square / power / power - 2.0).abs() < 0.15);
            }
        }
    }

    /// A line that drifts 10 rad/s in a second has the rate of the line after an hour as at the start.
    #[test]
    fn a_drifting_line_keeps_its_rate_at_any_time() {
        let comb = Comb::new(1.0);
        for t_s in [0.0, 60.0, 3600.0] {
            let at = |facet: u64, t: f64| {
                let centre_radps = 100.0 + 10.0 * (t - t_s);
                comb.phasor(
                    mixed(facet, 0),
                    0,
                    Line { amplitude: 1.0, centre_radps, deviation_radps: 4.0 },
                    t,
                )
            };
            let lag_s = 0.01;
            let sum: Complex64 = (0..4000).map(|n| at(n, t_s).conj() * at(n, t_s + lag_s)).sum();
            let found = sum.arg() / lag_s;
            assert!((found - 100.0).abs() < 0.5, "{t_s}: {found}");
        }
    }
}
