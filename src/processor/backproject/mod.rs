//! Bistatic time-domain back-projection.
//!
//! ```text
//! I(x) = sum_m w_m C_m(tau_m(x)) e^{+j 2 pi f0 tau_m(x)} / sum_m w_m
//! ```
//!
//! `C_m` the [compressed](super::range_compress) echo of pulse `m`; `tau_m(x)` delay of a point at rest for
//! the **middle** of the pulse, which leaves the transmitter at `t_m + Tc/2`: exact light time, transmitter
//! at emission, receiver at reception ([`delay_s`]); `w_m` taper over the pulses. A point target of echo `a`
//! gives `I = a` at its place: amplitude in sqrt(W), phase without the carrier's.
//!
//! Two ways:
//!
//! * [`reference`](reference()): f64, written from the equation; every delay iterated, every echo evaluated
//!   exactly from its spectrum. Slow.
//! * [`fast`](fast()): f32 samples, both cores. What it leaves out, and how it is bounded, stands there.
//!
//! With a [`Gate`] each pixel takes the pulses in whose Doppler band it lies, and is divided by the weights
//! of these.
//!
//! No amplitude is corrected for gain or range; the height is one plane (or the points given). Points that a
//! window does not cover get nothing from its pulse. Only one polarisation may leave with a pulse that is
//! used: the caller chooses the pulses.

mod fast;
mod gate;
mod reference;

use glam::DVec3;
use num_complex::Complex32;

use super::range_compress::Compressor;
use crate::geometry::phase_path::{PhasePath, delay_rate, delay_s};
use crate::recording::ground::Ground;
use crate::units::SPEED_OF_LIGHT_MPS;

pub use fast::fast;
pub use gate::Gate;
pub use reference::reference;

/// One pulse of one channel.
#[derive(Clone, Copy, Debug)]
pub struct PulseEcho<'a> {
    /// Emission, s on the clock of the paths.
    pub emission_s: f64,
    /// Number of the pulse, which says which of the waveforms in turn it has.
    pub number: u64,
    /// First sample after the emission, s.
    pub window_start_s: f64,
    /// Weight in the sum.
    pub weight: f64,
    /// Samples of the window.
    pub samples: &'a [Complex32],
}

/// All pulses that make an image, and from where they were sent and received.
pub struct Aperture<'a> {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Compresses windows.
    pub compressor: &'a Compressor,
    /// Transmitter's phase centre.
    pub transmitter: &'a PhasePath,
    /// Receiver's phase centre.
    pub receiver: &'a PhasePath,
    /// The pulses.
    pub pulses: Vec<PulseEcho<'a>>,
    /// The point whose Doppler is taken out before compression, m.
    pub centre_m: [f64; 3],
    /// Pulses that a pixel takes; none: all.
    pub gate: Option<Gate>,
}

impl Aperture<'_> {
    /// When the middle of a pulse leaves, s.
    fn middle_s(&self, pulse: &PulseEcho) -> f64 {
        pulse.emission_s + self.compressor.middle_s()
    }

    /// Delay of a point in a pulse, s.
    pub fn delay_s(&self, pulse: &PulseEcho, point_m: [f64; 3]) -> f64 {
        delay_s(self.transmitter, self.receiver, self.middle_s(pulse), point_m)
    }

    /// Doppler of a point at rest in a pulse, Hz.
    pub fn doppler_hz(&self, pulse: &PulseEcho, point_m: [f64; 3]) -> f64 {
        -self.carrier_hz * delay_rate(self.transmitter, self.receiver, self.middle_s(pulse), point_m)
    }

    /// Doppler of what both antennas look at in a pulse, Hz: `f0 (v_T . b_T + v_R . b_R)/c`, `b` their
    /// boresights (unit vectors, ENU).
    pub fn aim_hz(&self, pulse: &PulseEcho, boresights: [[f64; 3]; 2]) -> f64 {
        let [out, back] = boresights.map(DVec3::from);
        let leaves_s = self.middle_s(pulse);
        let tau_s = self.delay_s(pulse, self.centre_m);
        let closing_mps =
            self.transmitter.state(leaves_s).1.dot(out) + self.receiver.state(leaves_s + tau_s).1.dot(back);
        self.carrier_hz * closing_mps / SPEED_OF_LIGHT_MPS
    }

    /// Whether a point takes a pulse (by its place in the list).
    pub fn takes(&self, place: usize, point_m: [f64; 3]) -> bool {
        let (Some(gate), Some(pulse)) = (&self.gate, self.pulses.get(place)) else { return true };
        gate.place(place, self.doppler_hz(pulse, point_m)).abs() <= 0.5
    }

    /// Weight of a pulse (by its place in the list) at a point.
    pub fn weight(&self, place: usize, pulse: &PulseEcho, point_m: [f64; 3]) -> f64 {
        let gate = self.gate.as_ref();
        pulse.weight * gate.map_or(1.0, |gate| gate.weight(place, self.doppler_hz(pulse, point_m)))
    }

    /// Sum of all weights, for points that take every pulse.
    fn weights(&self) -> f64 {
        let sum: f64 = self.pulses.iter().map(|pulse| pulse.weight).sum();
        if sum == 0.0 { 1.0 } else { sum }
    }
}

/// How far from each other two images are: rms of the difference over rms of the second, dB.
pub fn difference_db<'a>(
    found: impl IntoIterator<Item = &'a Complex32>,
    wanted: impl IntoIterator<Item = &'a num_complex::Complex64>,
) -> f64 {
    let (mut error, mut power) = (0.0, 0.0);
    for (a, b) in found.into_iter().zip(wanted) {
        error += (b - num_complex::Complex64::new(a.re.into(), a.im.into())).norm_sqr();
        power += b.norm_sqr();
    }
    10.0 * (error / power).log10()
}

/// Points of a ground, row by row.
fn points(ground: &Ground) -> impl Iterator<Item = [f64; 3]> + '_ {
    let [columns, rows] = ground.pixels;
    (0..rows).flat_map(move |j| (0..columns).map(move |i| ground.point_m(i as f64, j as f64)))
}
