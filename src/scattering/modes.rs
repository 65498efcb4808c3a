//! Facets of Gaussian amplitude: a few random processes stand for all that a facet holds.
//!
//! A facet is a sum over its sub-facets, `S = sum_n B_n gamma_n`, `B_n` the Bragg matrix of tilt `n`, weight
//! included. If the `gamma_n` are independent complex Gaussian processes of unit power, `S` is complex
//! Gaussian with the covariance `sum_n B_n B_n^H` of all polarisations, as the sum of many smaller facets of
//! the same waves is. Nine of them are not needed: `B_n` is smooth in the tilt, so it is expanded in the
//! polynomials that are orthonormal under the rule of the tilts,
//!
//! `sum_n B_n gamma_n ~ sum_r (sum_n B_n u_rn) g_r`,
//! `u_rn = sqrt(w_n) He_i(t_n) He_j(c_n) / sqrt(i! j!)`
//!
//! with `t_n`, `c_n` the tilt along and across the wind in standard deviations, `w_n` the weight, and the
//! **mode** `r` of degree `(i, j)` in the order `00, 10, 01, 20, 11, 02, 21, 12, 22`. The matrix of nine
//! modes is orthogonal: nothing is left out. Three modes (level, and both tilts) have all but 0.2 dB of the
//! power from 30 to 75 degrees of incidence (0.5 dB of the cross-polarised), and all but 1 dB of HH at 85;
//! six have all but 0.1 dB there.
//!
//! ```
//! use nereus::scattering::modes::TiltModes;
//! let rule = [[0.0, 0.0, 1.0]];
//! assert_eq!((TiltModes::new(&rule, 3).count(), TiltModes::new(&rule, 3).share(0, 0)), (1, 1.0));
//! ```

use num_complex::Complex64;

use super::two_scale::TILTS;

/// Degrees along and across the wind of the modes, the least first.
const DEGREES: [[usize; 2]; TILTS] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [2, 1], [1, 2], [2, 2]];

/// How the phasors of tilts follow from a few processes.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltModes {
    /// `[mode][tilt]`.
    shares: Vec<Vec<f64>>,
}

/// Hermite polynomial of a degree up to 2, of unit mean square under the normal law.
fn hermite(degree: usize, x: f64) -> f64 {
    match degree {
        0 => 1.0,
        1 => x,
        _ => (x * x - 1.0) * std::f64::consts::FRAC_1_SQRT_2,
    }
}

impl TiltModes {
    /// So many modes of tilts, which are given in standard deviations along and across the wind, with their
    /// weights: no more modes than tilts.
    pub fn new(tilts: &[[f64; 3]], modes: usize) -> Self {
        let share = |[i, j]: [usize; 2], [along, across, weight]: [f64; 3]| {
            weight.sqrt() * hermite(i, along) * hermite(j, across)
        };
        let degrees = DEGREES.iter().take(modes.clamp(1, tilts.len().max(1)));
        Self { shares: degrees.map(|of| tilts.iter().map(|tilt| share(*of, *tilt)).collect()).collect() }
    }

    /// Modes.
    pub fn count(&self) -> usize {
        self.shares.len()
    }

    /// What a tilt has of a mode.
    pub fn share(&self, mode: usize, tilt: usize) -> f64 {
        self.shares.get(mode).and_then(|of| of.get(tilt)).copied().unwrap_or(0.0)
    }

    /// Phasors of the specular part and of every tilt, from those of the specular part and of every mode.
    pub fn expand(&self, processes: &[Complex64], out: &mut [Complex64]) {
        let (Some((specular, modes)), Some((first, tilts))) =
            (processes.split_first(), out.split_first_mut())
        else {
            return;
        };
        *first = *specular;
        for (tilt, phasor) in tilts.iter_mut().enumerate() {
            *phasor = modes.iter().enumerate().map(|(mode, of)| of * self.share(mode, tilt)).sum();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule() -> Vec<[f64; 3]> {
        let nodes = [(0.0, 2.0 / 3.0), (-3f64.sqrt(), 1.0 / 6.0), (3f64.sqrt(), 1.0 / 6.0)];
        nodes.iter().flat_map(|u| nodes.map(|c| [u.0, c.0, u.1 * c.1])).collect()
    }

    /// Nine modes leave nothing out: their shares are orthogonal.
    #[test]
    fn all_modes_are_all_tilts() {
        let modes = TiltModes::new(&rule(), 9);
        for a in 0..9 {
            for b in 0..9 {
                let product: f64 = (0..9).map(|tilt| modes.share(a, tilt) * modes.share(b, tilt)).sum();
                let expected = f64::from(u8::from(a == b));
                assert!((product - expected).abs() < 1e-14, "{a} {b}: {product}");
            }
        }
        assert_eq!(TiltModes::new(&rule(), 99).count(), 9);
    }

    /// Fields that are linear in the tilt have all of their power in three modes, whatever the slopes.
    #[test]
    fn three_modes_have_all_that_is_linear() {
        let rule = rule();
        let of = |[u, c, w]: [f64; 3]| w.sqrt() * (1.0 - 0.3 * u + 0.2 * c);
        let power: f64 = rule.iter().map(|tilt| of(*tilt).powi(2)).sum();
        assert!((power - (1.0 + 0.09 + 0.04)).abs() < 1e-14, "{power}");
        let found = |count: usize| -> f64 {
            let modes = TiltModes::new(&rule, count);
            let amplitude = |mode: usize| -> f64 {
                rule.iter().enumerate().map(|(n, tilt)| of(*tilt) * modes.share(mode, n)).sum()
            };
            (0..count).map(|mode| amplitude(mode).powi(2)).sum()
        };
        assert!((found(3) - power).abs() < 1e-14 && (found(1) - 1.0).abs() < 1e-14);
    }
}
