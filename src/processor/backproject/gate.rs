//! Which pulses make a pixel: those in whose beam it lies, by Doppler.
//!
//! ```text
//! u_m(x) = (f_m(x) - f_m(aim)) / B_D,   w_m(x) = w_m t(u_m(x)),   t = 0 beyond |u| = 1/2
//! ```
//!
//! `f_m` Doppler of a point at rest, `B_D` the processed Doppler bandwidth, `t` a taper over it. Where `B_D`
//! is at most the pulse rate, points that the pulse rate cannot separate (`lambda R PRF / v` along the
//! track, `v` the sum of both speeds) do not take each other's pulses: ghosts are those that the beam's side
//! lobes leave. An image is divided by the weights that each pixel has taken, so that a point keeps its
//! amplitude wherever it lies; a pixel without pulses is zero.

use glam::DVec3;

use crate::processor::taper::Taper;

/// Points of the table of a taper, from one end of the band to the other.
const TABLE: usize = 1024;

/// A Doppler band about that of the aim.
#[derive(Clone, Debug, PartialEq)]
pub struct Gate {
    /// Processed Doppler bandwidth, Hz.
    pub bandwidth_hz: f64,
    /// Taper over it.
    pub taper: Taper,
    /// Doppler of the aim in every pulse of the aperture, Hz.
    pub aim_hz: Vec<f64>,
}

impl Gate {
    /// Place of a Doppler frequency in the band of a pulse: -1/2 to 1/2 inside. Outside where the pulse has
    /// no aim.
    pub fn place(&self, pulse: usize, doppler_hz: f64) -> f64 {
        let aim_hz = self.aim_hz.get(pulse).copied().unwrap_or(f64::NAN);
        (doppler_hz - aim_hz) / self.bandwidth_hz
    }

    /// Weight of a pulse at that Doppler frequency.
    pub fn weight(&self, pulse: usize, doppler_hz: f64) -> f64 {
        self.taper.weight(self.place(pulse, doppler_hz))
    }

    /// The taper for look-up in f32.
    pub(super) fn table(&self) -> Table {
        let weight = |i: usize| self.taper.weight(i as f64 / TABLE as f64 - 0.5) as f32;
        Table((0..=TABLE + 1).map(|i| if i > TABLE { 0.0 } else { weight(i) }).collect())
    }
}

/// A taper at [`TABLE`] + 1 places and a zero beyond, linear between them: cosines of a few periods are met
/// to 1e-5.
pub(super) struct Table(Vec<f32>);

impl Table {
    /// Weight at a place in the band; zero outside, and where it is no number.
    #[inline(always)]
    pub fn weight(&self, u: f32) -> f32 {
        let at = (u + 0.5) * TABLE as f32;
        let inside = (0.0..=TABLE as f32).contains(&at);
        let low = if inside { at as usize } else { 0 };
        let part = at - low as f32;
        match self.0.get(low..low + 2) {
            Some([a, b]) if inside => a + (b - a) * part,
            _ => 0.0,
        }
    }
}

/// Speed along the line of sight of a point that goes by `step` (m): its value (m/s), first and half its
/// second derivative over steps. `away` from the end that moves at `velocity` to the point; the third
/// derivative, `v/R` times `(step/R)^3` at most, is left out.
#[inline(always)]
pub(super) fn closing(velocity: DVec3, away: DVec3, step: DVec3) -> [f64; 3] {
    let range = away.length().max(1e-3);
    let unit = away / range;
    let value = velocity.dot(unit);
    let along = unit.dot(step);
    let first = (velocity.dot(step) - value * along) / range;
    let bend = (step.length_squared() - along * along) / range;
    [value, first, -0.5 * (2.0 * first * along + value * bend) / range]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_meet_their_tapers() {
        for taper in [Taper::Uniform, Taper::Hann, Taper::Taylor, Taper::Kaiser] {
            let gate = Gate { bandwidth_hz: 200.0, taper, aim_hz: vec![30.0] };
            let table = gate.table();
            for i in -700..=700 {
                let u = f64::from(i) * 1.000_1e-3;
                let exact = gate.weight(0, 30.0 + 200.0 * u);
                assert!((f64::from(table.weight(u as f32)) - exact).abs() < 2e-5, "{taper:?} {u}: {exact}");
            }
            assert_eq!(table.weight(f32::NAN), 0.0);
            assert_eq!(gate.weight(1, 30.0), 0.0, "a pulse without aim");
        }
    }

    #[test]
    fn closing_speeds_are_quadratics_of_the_step() {
        let (velocity, away, step) =
            (DVec3::new(200.0, -10.0, 3.0), DVec3::new(300.0, 2900.0, -2800.0), DVec3::new(1.0, 0.3, 0.0));
        let [value, first, half] = closing(velocity, away, step);
        for k in [-16.0, -3.0, 8.0, 16.0] {
            let exact = velocity.dot((away + step * k).normalize());
            let found = value + k * (first + k * half);
            // v/R (k step/R)^3 = 200 x (17/4000)^3.
            assert!((found - exact).abs() < 200.0 * (17.0f64 / 4000.0).powi(3), "{k}: {found} {exact}");
        }
    }
}
