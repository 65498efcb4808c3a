//! How fast a wave travels.
//!
//! `omega^2 = g K (1 + (K/km)^2) tanh(K d)`, `km = 370 rad/m`; the bracket only with surface tension, the
//! tanh only in finite depth `d`. A particle at the surface moves horizontally `coth(K d)` times as far as
//! vertically.
//!
//! Limits: linear waves, no current.
//!
//! ```
//! use nereus::scene::water::Dispersion;
//! let deep = Dispersion::default();
//! assert!((deep.angular_frequency_rad_s(0.1).powi(2) - 0.981).abs() < 1e-12);
//! let shallow = Dispersion { depth_m: Some(1.0), ..deep };
//! assert!((shallow.phase_speed_mps(1e-3) - 9.81f64.sqrt()).abs() < 1e-5);
//! ```

use crate::scene::water::Dispersion;
use crate::sea::GRAVITY_MPS2;

/// Wave number of the slowest capillary-gravity wave, rad/m.
pub const CAPILLARY_PEAK_RAD_M: f64 = 370.0;
/// Depths that may be given, m.
pub const DEPTH_RANGE_M: [f64; 2] = [0.1, 1e5];

/// What is wrong with a depth.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("water depth of {depth_m} m: allowed are {} to {} m, or none for deep water", DEPTH_RANGE_M[0], DEPTH_RANGE_M[1])]
pub struct DepthError {
    /// The depth given, m.
    pub depth_m: f64,
}

impl Dispersion {
    /// Checks the depth.
    ///
    /// # Errors
    /// A depth outside the range.
    pub fn check(&self) -> Result<(), DepthError> {
        match self.depth_m {
            Some(depth_m) if !(DEPTH_RANGE_M[0]..=DEPTH_RANGE_M[1]).contains(&depth_m) => {
                Err(DepthError { depth_m })
            }
            _ => Ok(()),
        }
    }

    /// Angular frequency, rad/s, of wave number K, rad/m.
    pub fn angular_frequency_rad_s(&self, k_rad_m: f64) -> f64 {
        let tension = if self.capillary { 1.0 + (k_rad_m / CAPILLARY_PEAK_RAD_M).powi(2) } else { 1.0 };
        let bottom = self.depth_m.map_or(1.0, |depth_m| (k_rad_m * depth_m).tanh());
        (GRAVITY_MPS2 * k_rad_m * tension * bottom).sqrt()
    }

    /// Wave numbers, rad/m, become their angular frequencies, rad/s: those of
    /// [`angular_frequency_rad_s`](Self::angular_frequency_rad_s), side by side in single precision.
    #[inline(always)]
    pub fn angular_frequencies_rad_s<const N: usize>(&self, k_rad_m: &mut [f32; N]) {
        let mut bottom = [1.0; N];
        if let Some(depth_m) = self.depth_m {
            for i in 0..N {
                bottom[i] = (f64::from(k_rad_m[i]) * depth_m).tanh() as f32;
            }
        }
        let (gravity, peak) = (GRAVITY_MPS2 as f32, CAPILLARY_PEAK_RAD_M.recip() as f32);
        for i in 0..N {
            let share = k_rad_m[i] * peak;
            let tension = if self.capillary { 1.0 + share * share } else { 1.0 };
            k_rad_m[i] = (gravity * k_rad_m[i] * tension * bottom[i]).sqrt();
        }
    }

    /// Wave numbers above 0, rad/m, become group speeds, m/s, given their angular frequencies: those of
    /// [`group_speed_mps`](Self::group_speed_mps), side by side in single precision.
    #[inline(always)]
    pub fn group_speeds_mps<const N: usize>(&self, omega_rad_s: &[f32; N], k_rad_m: &mut [f32; N]) {
        let mut bottom = [0.0; N];
        if self.depth_m.is_some() {
            for i in 0..N {
                bottom[i] = self.bottom(f64::from(k_rad_m[i])) as f32;
            }
        }
        let peak = CAPILLARY_PEAK_RAD_M.recip() as f32;
        for i in 0..N {
            let share = k_rad_m[i] * peak;
            let q = share * share;
            let tension = if self.capillary { 2.0 * q / (1.0 + q) } else { 0.0 };
            k_rad_m[i] = 0.5 * (omega_rad_s[i] / k_rad_m[i]) * (1.0 + tension + bottom[i]);
        }
    }

    /// What a bottom adds to a group speed: `2x/sinh 2x`, without overflow for large x.
    fn bottom(&self, k_rad_m: f64) -> f64 {
        self.depth_m.map_or(0.0, |depth_m| {
            let x2 = 2.0 * k_rad_m * depth_m;
            if x2 > 700.0 { 0.0 } else { x2 / x2.sinh() }
        })
    }

    /// Phase speed, m/s; that of the limit of long waves for K = 0 (infinite in deep water).
    pub fn phase_speed_mps(&self, k_rad_m: f64) -> f64 {
        if k_rad_m > 0.0 {
            return self.angular_frequency_rad_s(k_rad_m) / k_rad_m;
        }
        self.depth_m.map_or(f64::INFINITY, |depth_m| (GRAVITY_MPS2 * depth_m).sqrt())
    }

    /// Group speed `d omega / dK`, m/s, for K > 0.
    pub fn group_speed_mps(&self, k_rad_m: f64) -> f64 {
        let tension = if self.capillary {
            let q = (k_rad_m / CAPILLARY_PEAK_RAD_M).powi(2);
            2.0 * q / (1.0 + q)
        } else {
            0.0
        };
        0.5 * self.phase_speed_mps(k_rad_m) * (1.0 + tension + self.bottom(k_rad_m))
    }

    /// Horizontal over vertical excursion of a particle at the surface, `coth(K d)`, for K > 0.
    pub fn excursion_ratio(&self, k_rad_m: f64) -> f64 {
        self.depth_m.map_or(1.0, |depth_m| 1.0 / (k_rad_m * depth_m).tanh())
    }

    /// Wave number, rad/m, of an angular frequency, rad/s (0 for 0).
    pub fn wave_number_rad_m(&self, omega_rad_s: f64) -> f64 {
        if omega_rad_s <= 0.0 {
            return 0.0;
        }
        // omega rises with K. Tension only shortens K against deep water, a bottom only lengthens it:
        // omega^2 = g K tanh(K d) has K <= max(2 K_deep, 2 omega/sqrt(g d)), since tanh x >= x/2 for
        // x <= 1.9 and tanh x >= 0.5 beyond.
        let deep = omega_rad_s * omega_rad_s / GRAVITY_MPS2;
        let shallow = self.depth_m.map_or(0.0, |d| 2.0 * omega_rad_s / (GRAVITY_MPS2 * d).sqrt());
        let (mut low, mut high) = (0.0, 2.0 * deep.max(shallow));
        for _ in 0..1100 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.angular_frequency_rad_s(middle) < omega_rad_s {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }
}
