//! Bistatic time-domain back-projection.
//!
//! ```text
//! I(x) = sum_m w_m C_m(tau_m(x)) e^{+j 2 pi f0 tau_m(x)} / sum_m w_m
//! ```
//!
//! `C_m` the [compressed](super::range_compress) echo of pulse `m`; `tau_m(x)` delay of a point at rest for the **middle** of the pulse, which
//! leaves the transmitter at `t_m + Tc/2`: exact light time, transmitter at emission, receiver at reception
//! ([`delay_s`]); `w_m` taper over the pulses. A point target of echo `a` gives `I = a` at its place: amplitude in sqrt(W), phase
//! without the carrier's.
//!
//! Two ways:
//!
//! * [`reference`](reference()): f64, written from the equation; every delay iterated, every echo evaluated exactly from its spectrum. Slow.
//! * [`fast`](fast()): f32 samples, both cores. What it leaves out, and how it is bounded, stands there.
//!
//! No amplitude is corrected for gain or range; the height is one plane (or the points given). Points that a window does not cover get nothing
//! from its pulse. Only one polarisation may leave with a pulse that is used: the caller chooses the pulses.

mod fast;
mod reference;

use num_complex::Complex32;

use super::ground::Ground;
use super::phase_path::{PhasePath, delay_rate, delay_s};
use super::range_compress::Compressor;

pub use fast::fast;
pub use reference::reference;

/// One pulse of one channel.
#[derive(Clone, Copy, Debug)]
pub struct PulseEcho<'a> {
    /// Emission, s on the clock of the paths.
    pub emission_s: f64,
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

    /// Doppler of the centre in a pulse, Hz.
    fn doppler_hz(&self, pulse: &PulseEcho) -> f64 {
        -self.carrier_hz * delay_rate(self.transmitter, self.receiver, self.middle_s(pulse), self.centre_m)
    }

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
