//! How a ship heaves, pitches and rolls in a regular wave: transfer functions in closed form.
//!
//! A wave `zeta = Re a e^{j (K.x - w t)}` of wave number `k` (`k_x` ahead, `k_y` to port) meets a ship at the
//! frequency `w_e = q w`. The hull is a box of length `L`, draught `T` and the breadth `B = C_B B_hull`.
//! Heave `z` (up) and pitch `p` (bow up) per amplitude of the wave at midship are
//!
//! `H = f s(k_x L/2) m / D` , `P = j k_x f c(k_x L/2) m / D` ,
//! `f = 1 - k T - j b/|q|` , `D = 1 - 2 k T q^2 - j sgn(q) b` , `b = A^2/(k B q^2)` ,
//! `A = 2 sin(k B q^2/2) e^{-k T q^2}` ,
//! `s(y) = sin(y)/y` , `c(y) = 3 (sin y - y cos y)/y^3` , `m = e^{-k T} s(k_y B_hull/2)` ,
//!
//! and roll (port up), with the natural frequency `w_r` and [`ROLL_DAMPING`] `d`,
//!
//! `R = j k_y s(k_x L/2) c(k_y B_hull/2) e^{-k T} / (1 - (w_e/w_r)^2 - 2 j d w_e/w_r)` .
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `A` | radiated wave over motion of a section (Yamamoto): damping | |
//! | `f`, `D` | what drives the box, and how it answers: added mass as large as its own | |
//! | `b` | damping over stiffness, over the unit of time `1/w_e` | |
//! | `m` | Smith's reduction with depth, and the mean across the beam | |
//! | `w_r = 2 pi/T_r` | natural frequency of roll | rad/s |
//!
//! **From the paper**: moduli of `f`, `D`, `s`, `c`, and `C_B`, for heave and pitch. **Simplified here**: its
//! phases, which the relative motion of water and box gives that leads to its moduli; Smith's reduction with
//! `k` in place of `|k_x|` and the mean across the beam (the same in head seas; in beam seas of short waves
//! the paper's heave does not vanish); damping of no less than a tenth where very broad boxes radiate nothing
//! at resonance; roll, for which the paper has a law of its own, is one degree of freedom, driven by the mean
//! slope across the beam. Its period, unless given, is `T_r = 2 C B/sqrt(GM)` with the `C` of the weather
//! criterion of the IMO (2008 IS Code, part A, 2.3) and [`METACENTRIC_RATIO`] for `GM/B`.
//!
//! Source: Jensen, Mansour, Olsen, "Estimation of ship motions using closed-form expressions", Ocean
//! Engineering 31 (2004) 61.
//!
//! Limits: linear; deep water; motions do not drive each other; no surge, sway and yaw; the ship turns about
//! midship at the waterline; full hulls better than slender ones, Froude numbers below some 0.3.
//!
//! ```
//! use nereus::scene::ship::HullForm;
//! use nereus::sea::seakeeping::Seakeeping;
//! let form = HullForm { length_m: 100.0, beam_m: 14.0, draught_m: 4.5, block: 0.6 };
//! let ship = Seakeeping::new(&form, None);
//! // C = 0.373 + 0.023 B/d - 0.043 L/100 = 0.4016, GM = 0.98 m.
//! assert!((ship.roll_period_s() - 11.36).abs() < 0.01);
//! // A swell of 2 km from the bow lifts it as high as itself.
//! let k = std::f64::consts::TAU / 2000.0;
//! let w = (9.81 * k).sqrt();
//! let [heave, ..] = ship.transfer([-k, 0.0], w, w);
//! assert!((heave.norm() - 1.0).abs() < 0.03);
//! ```

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::scene::ship::HullForm;

/// Damping of roll over critical damping: hulls with bilge keels under way.
pub const ROLL_DAMPING: f64 = 0.1;
/// Metacentric height over beam, where the period of roll is not given.
pub const METACENTRIC_RATIO: f64 = 0.07;

/// Least `C` of the period of roll.
const LEAST_C: f64 = 0.3;
/// Least damping over stiffness at resonance of heave and pitch.
const LEAST_DAMPING: f64 = 0.1;

/// How a hull answers waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seakeeping {
    form: HullForm,
    roll_radps: f64,
}

impl Seakeeping {
    /// Of a hull with a natural period of roll, s; `None`: that of its form.
    pub fn new(form: &HullForm, roll_period_s: Option<f64>) -> Self {
        let HullForm { length_m, beam_m, draught_m, .. } = *form;
        let c = (0.373 + 0.023 * beam_m / draught_m - 0.043 * length_m / 100.0).max(LEAST_C);
        let period_s = roll_period_s.unwrap_or(2.0 * c * (beam_m / METACENTRIC_RATIO).sqrt());
        Self { form: *form, roll_radps: TAU / period_s }
    }

    /// Natural period of roll, s.
    pub fn roll_period_s(&self) -> f64 {
        TAU / self.roll_radps
    }

    /// Heave, m/m, pitch, bow up, and roll, port up, rad/m, per complex amplitude of a wave at midship:
    /// wave vector ahead and to port, rad/m, its frequency, and that with which the ship meets it (negative:
    /// it overtakes the wave), rad/s.
    pub fn transfer(&self, [ahead, port]: [f64; 2], omega: f64, met: f64) -> [Complex64; 3] {
        let HullForm { length_m, beam_m, draught_m, block } = self.form;
        let k = ahead.hypot(port);
        if !(k > 0.0 && omega > 0.0) {
            return [Complex64::ONE, Complex64::ZERO, Complex64::ZERO];
        }
        let (q, depth, breadth_m) = (met / omega, k * draught_m, block * beam_m);
        // b/q^2, which stays finite where the ship runs along with the wave.
        let radiates = k * breadth_m * (mean(0.5 * k * breadth_m * q * q) * (-depth * q * q).exp()).powi(2);
        let inertia = 2.0 * depth * q * q;
        let least = LEAST_DAMPING * inertia.min(1.0 / inertia.max(f64::MIN_POSITIVE));
        let damping = (radiates * q * q).max(least);
        let answer = Complex64::new(1.0 - inertia, -damping.copysign(q));
        let drive = Complex64::new(1.0 - depth, -radiates * q.abs());
        let (along, across) = (0.5 * ahead * length_m, 0.5 * port * beam_m);
        let smith = (-depth).exp();
        let box_like = drive / answer * (smith * mean(across));
        let heave = box_like * mean(along);
        let pitch = Complex64::I * ahead * box_like * mean_slope(along);
        let over = met / self.roll_radps;
        let slope = Complex64::I * port * smith * mean(along) * mean_slope(across);
        [heave, pitch, slope / Complex64::new(1.0 - over * over, -2.0 * ROLL_DAMPING * over)]
    }
}

/// Mean of `cos` over -y to y: `sin(y)/y`.
fn mean(y: f64) -> f64 {
    if y.abs() < 1e-4 { 1.0 - y * y / 6.0 } else { y.sin() / y }
}

/// What is left of a slope, as the lever arm weighs it: `3 (sin y - y cos y)/y^3`.
fn mean_slope(y: f64) -> f64 {
    if y.abs() < 1e-2 { 1.0 - y * y / 10.0 } else { 3.0 * (y.sin() - y * y.cos()) / y.powi(3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORM: HullForm = HullForm { length_m: 120.0, beam_m: 18.0, draught_m: 6.0, block: 0.65 };

    fn deep(k: f64) -> f64 {
        (9.81 * k).sqrt()
    }

    /// Head seas at 4.5 m/s of a ship as the paper writes it: `Phi = eta F` and `eta G`, by its own symbols.
    #[test]
    fn head_seas_have_the_moduli_of_the_paper() {
        let HullForm { length_m: l, beam_m, draught_m: t, block } = FORM;
        let (ship, b) = (Seakeeping::new(&FORM, None), block * beam_m);
        for lambda_m in [30.0, 70.0, 120.0, 200.0, 500.0] {
            let k = TAU / lambda_m;
            let (w, fn_) = (deep(k), 4.5 / (9.81 * l).sqrt());
            let alpha = 1.0 + fn_ * (k * l).sqrt();
            let a = 2.0 * (0.5 * k * b * alpha * alpha).sin() * (-k * t * alpha * alpha).exp();
            let f = ((1.0 - k * t).powi(2) + (a * a / (k * b * alpha.powi(3))).powi(2)).sqrt();
            let eta = ((1.0 - 2.0 * k * t * alpha * alpha).powi(2)
                + (a * a / (k * b * alpha * alpha)).powi(2))
            .sqrt()
            .recip();
            let (kappa, half) = ((-k * t).exp(), 0.5 * k * l);
            let heave = eta * kappa * f * 2.0 / (k * l) * half.sin();
            let pitch = eta * kappa * f * 24.0 / ((k * l).powi(2) * l) * (half.sin() - half * half.cos());
            let [z, p, r] = ship.transfer([-k, 0.0], w, w + 4.5 * k);
            assert!((z.norm() - heave.abs()).abs() < 1e-3, "{lambda_m}: {z} {heave}");
            assert!((p.norm() - pitch.abs()).abs() < 1e-3 * k, "{lambda_m}: {p} {pitch}");
            assert_eq!(r.norm(), 0.0);
        }
    }

    /// Very long waves carry the ship with them, in phase; very short ones leave it alone.
    #[test]
    fn limits_are_the_wave_and_nothing() {
        let ship = Seakeeping::new(&FORM, Some(11.0));
        for bearing in 0..24 {
            let (sin, cos) = (f64::from(bearing) * TAU / 24.0 + 0.1).sin_cos();
            let k = 1e-6;
            let [z, p, r] = ship.transfer([k * cos, k * sin], deep(k), deep(k) - 5.0 * k * cos);
            assert!((z - 1.0).norm() < 1e-3, "{z}");
            assert!((p / k - Complex64::I * cos).norm() < 1e-3, "{p}");
            assert!((r / k - Complex64::I * sin).norm() < 2e-3, "{r}");
            let k = 8.0;
            let short = ship.transfer([k * cos, k * sin], deep(k), deep(k) - 5.0 * k * cos);
            assert!(short.iter().all(|t| t.norm() < 1e-6), "{short:?}");
        }
    }

    /// At its natural period a ship abeam rolls by the mean slope over twice the damping, a quarter later.
    #[test]
    fn roll_at_resonance_is_the_slope_over_twice_the_damping() {
        let ship = Seakeeping::new(&FORM, Some(25.0));
        let w = TAU / 25.0;
        let k = w * w / 9.81;
        let [.., roll] = ship.transfer([0.0, k], w, w);
        let y: f64 = 0.5 * k * FORM.beam_m;
        let slope = k * (-k * FORM.draught_m).exp() * 3.0 * (y.sin() - y * y.cos()) / y.powi(3);
        assert!((roll + slope / (2.0 * ROLL_DAMPING)).norm() < 1e-9 * slope, "{roll} {slope}");
        // Long waves: the slope itself, less 4 % for the depth.
        assert!((slope / k - 1.0).abs() < 0.05);
    }

    /// No wave, course or form makes it infinite.
    #[test]
    fn answers_are_finite() {
        for beam_m in [1e-3, 18.0, 120.0] {
            let ship = Seakeeping::new(&HullForm { beam_m, ..FORM }, None);
            assert!((0.01..200.0).contains(&ship.roll_period_s()));
            for n in 0..4000 {
                let k = 1e-4 * 1.003f64.powi(n);
                let w = deep(k);
                for met in [w, 0.0, -w, w + 30.0 * k, w - 30.0 * k] {
                    let [z, p, r] = ship.transfer([0.6 * k, 0.8 * k], w, met);
                    assert!(
                        z.norm() < 11.0 && p.norm() < 11.0 * k && r.norm() < 5.1 * k,
                        "{k} {met}: {z} {p} {r}"
                    );
                }
            }
        }
    }
}
