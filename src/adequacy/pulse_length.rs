//! How long a pulse is to a matched filter behind the receive filter.

use crate::radar::filter::ReceiveFilter;
use crate::radar::waveform::{Waveform, pulses};
use crate::scene::Radar;

/// Lobes of the spectrum of a plain pulse that are looked at, beyond its band.
const LOBES: f64 = 64.0;
/// Frequencies at which the spectrum of the pulse is taken: at least, at most.
const FREQUENCIES: [usize; 2] = [256, 16_384];

/// `E_2^2 / E_4`, s: the length of a pulse in band; of pulses in turn, the mean.
pub(super) fn seconds_of_pulse(waveform: &dyn Waveform, radar: &Radar) -> f64 {
    if radar.dechirp.is_some() {
        // A tone.
        return waveform.duration_s().min(radar.window.samples as f64 / radar.sample_rate_hz);
    }
    let all = pulses(waveform);
    all.iter().map(|pulse| seconds_of_one(*pulse, radar)).sum::<f64>() / all.len() as f64
}

/// The same of one pulse.
fn seconds_of_one(waveform: &dyn Waveform, radar: &Radar) -> f64 {
    let filter = ReceiveFilter::new(radar.sample_rate_hz);
    // Beyond the band by many lobes there is next to nothing, and the squared spectrum is that of an
    // autocorrelation of length 2 Tc: a long sweep, which needs more frequencies, is smooth within its band.
    let duration_s = waveform.duration_s();
    let (band, half_lobes_hz) = (waveform.band(), 0.5 * LOBES * waveform.lobe_hz());
    let from_hz = (band.from_hz - half_lobes_hz).max(-0.5 * radar.sample_rate_hz);
    let band_hz = (band.to_hz + half_lobes_hz).min(0.5 * radar.sample_rate_hz) - from_hz;
    let count = ((2.0 * duration_s * band_hz).ceil() as usize).clamp(FREQUENCIES[0], FREQUENCIES[1]);
    let step_hz = band_hz / count as f64;
    let [mut first, mut second] = [0.0; 2];
    for k in 0..count {
        let f_hz = from_hz + (k as f64 + 0.5) * step_hz;
        let passed = filter.response(f_hz).powi(2);
        let density = waveform.spectrum(f_hz).norm_sqr() * passed;
        first += density * step_hz;
        second += density * passed * step_hz;
    }
    if second > 0.0 { first * first / second } else { 0.0 }
}
