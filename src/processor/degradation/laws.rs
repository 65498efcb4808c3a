//! Closed forms of what known errors of the path do to a point.
//!
//! `e(t)` is the error of the whole bistatic path, reported less true, m: `u_T . e_T + u_R . e_R`, `u` the
//! unit vectors from the point to the ends (one platform with both antennas: twice its own). Phase
//! `2 pi e/lambda`, aperture of `T` s, a cell of cross-range is `1/T` of Doppler.
//!
//! | error | what it does |
//! | --- | --- |
//! | constant `e` | everything moves: `-e B/c` cells of range |
//! | ramp `r` m/s | everything moves: `-r T/lambda` cells of cross-range, nothing is lost |
//! | sinusoid `a`, `f` Hz | `e^{j beta sin} = sum J_n(beta) e^{j n}`, `beta = 2 pi a/lambda`: main lobe `J0(beta)`, paired echoes `+-f T` cells away, `J1(beta)/J0(beta)` |
//! | step `phi` rad in the middle | `\|I(u)\| = \|sinc(u/2) cos((pi u + phi)/2)\|`, no taper, `u` cells |
//! | white, `sigma` rad | power `e^{-sigma^2}` |
//! | Gauss-Markov, `sigma` rad, `tau` | power at the place expected: `2 int_0^1 (1 - x) e^{-sigma^2 (1 - e^{-x T/tau})} dx`, no taper |
//!
//! Limits: `u` the same over the aperture; paired echoes further from the main lobe than it is wide; the last
//! two are means over an ensemble. Sources: the Jacobi-Anger expansion for the sinusoid; for the noise
//! `<e^{j(phi_1 - phi_2)}> = e^{-D/2}` of a Gaussian phase, `D` its structure function. As in W. G. Carrara,
//! R. S. Goodman, R. M. Majewski, *Spotlight Synthetic Aperture Radar* (1995), chapter 5.
//!
//! ```
//! use nereus::processor::degradation::laws::paired_echoes;
//! // Tenth of a radian: the textbook's beta/2, -26 dB.
//! let echoes = paired_echoes(0.1, 2.0, 2.5);
//! assert!((echoes.level_db + 26.0).abs() < 0.02 && echoes.distance_cells == 5.0);
//! ```

use std::f64::consts::PI;

/// What a sinusoid of phase does to a point.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct PairedEchoes {
    /// Main lobe over the one without error, dB.
    pub main_db: f64,
    /// First pair over the main lobe, dB.
    pub level_db: f64,
    /// Its distance to either side, cells.
    pub distance_cells: f64,
}

/// Paired echoes of a sinusoid of `beta_rad` and `frequency_hz` over an aperture of `aperture_s`.
pub fn paired_echoes(beta_rad: f64, frequency_hz: f64, aperture_s: f64) -> PairedEchoes {
    let db = |x: f64| 20.0 * x.abs().max(1e-300).log10();
    let (main, first) = (libm::j0(beta_rad), libm::j1(beta_rad));
    PairedEchoes {
        main_db: db(main),
        level_db: db(first) - db(main),
        distance_cells: frequency_hz * aperture_s,
    }
}

/// Cells of cross-range by which a path that grows too fast by `rate_mps` moves everything.
pub fn ramp_cells(rate_mps: f64, aperture_s: f64, wavelength_m: f64) -> f64 {
    -rate_mps * aperture_s / wavelength_m
}

/// Amplitude `u` cells off the place expected, behind a step of `phase_rad` in the middle of an aperture
/// without taper; 1 without a step at 0.
pub fn step_amplitude(phase_rad: f64, cells: f64) -> f64 {
    let x = 0.5 * PI * cells;
    let half = if x == 0.0 { 1.0 } else { x.sin() / x };
    (half * (x + 0.5 * phase_rad).cos()).abs()
}

/// The highest of that: cells off the place expected (nearest to it, of two that are equal the negative one)
/// and its level, dB.
pub fn step_peak(phase_rad: f64) -> (f64, f64) {
    // Steps are reported but for whole turns; the lobe's top lies within half a cell.
    let phase = phase_rad - 2.0 * PI * (phase_rad / (2.0 * PI)).round();
    let (mut low, mut high) = if phase >= 0.0 { (-1.0, 0.0) } else { (0.0, 1.0) };
    for _ in 0..100 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if step_amplitude(phase, a) < step_amplitude(phase, b) { low = a } else { high = b }
    }
    let cells = 0.5 * (low + high);
    (cells, 20.0 * step_amplitude(phase, cells).log10())
}

/// Mean power of the peak behind white phase of `sigma_rad`, dB.
pub fn white_db(sigma_rad: f64) -> f64 {
    -10.0 * std::f64::consts::LOG10_E * sigma_rad * sigma_rad
}

/// Mean power at the place expected behind Gauss-Markov phase of `sigma_rad`, whose correlation time is
/// `tau_s`, over an aperture of `aperture_s`, dB.
pub fn gauss_markov_db(sigma_rad: f64, tau_s: f64, aperture_s: f64) -> f64 {
    let ratio = aperture_s / tau_s.max(1e-12 * aperture_s);
    // In x = y^2 the integrand is smooth on the scale of the process for short correlation times too;
    // Simpson's rule.
    let law = |y: f64| {
        let x = y * y;
        4.0 * y * (1.0 - x) * (sigma_rad * sigma_rad * (-x * ratio).exp_m1()).exp()
    };
    let steps = 4096;
    let h = 1.0 / f64::from(steps);
    let weight = |i: i32| {
        if i == 0 || i == steps {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        }
    };
    let sum: f64 = (0..=steps).map(|i| weight(i) * law(f64::from(i) * h)).sum();
    10.0 * (sum * h / 3.0).log10()
}
