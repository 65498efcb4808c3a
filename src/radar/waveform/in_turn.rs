//! Pulses in turn: emission `k` radiates pulse `k mod m` of `m`.
//!
//! What asks for one pulse gets the first of them; lengths and bands are those that hold all.
//!
//! ```
//! use nereus::radar::waveform::{InTurn, Lfm, Waveform};
//! use nereus::scene::radar::Sweep;
//! use std::sync::Arc;
//! let sweep = |direction| Ok::<_, nereus::radar::waveform::WaveformError>(Arc::new(Lfm::new(20e6, 2e-6, direction)?));
//! let pulses = InTurn::new(vec![sweep(Sweep::Up)?, sweep(Sweep::Down)?]);
//! let rate = |emission| pulses.of_emission(emission).unwrap().unwrap().sweep_rate_hz_per_s();
//! assert_eq!((rate(6), rate(7)), (Some(1e13), Some(-1e13)));
//! # Ok::<(), nereus::radar::waveform::WaveformError>(())
//! ```

use std::collections::BTreeSet;
use std::sync::Arc;

use num_complex::Complex64;

use super::{Waveform, WaveformError};
use crate::scene::radar::Band;
use crate::units::in_turn;

/// Instants at which the power of a pulse is looked at.
const INSTANTS: usize = 4096;
/// Pulses up to which errors are predicted of each.
const EACH: usize = 8;

/// Pulses in turn.
#[derive(Clone)]
pub struct InTurn {
    of: Vec<Arc<dyn Waveform>>,
    band: Band,
    extremes: Vec<usize>,
    /// Mean energy over the greatest.
    steadiness: f64,
}

impl InTurn {
    /// Some pulses, one at least.
    pub fn new(of: Vec<Arc<dyn Waveform>>) -> Self {
        let bands = of.iter().map(|pulse| pulse.band());
        let band = bands.reduce(Band::with).unwrap_or(Band::about(0.0, 0.0));
        let energies: Vec<f64> = of.iter().map(|pulse| energy_s(pulse.as_ref())).collect();
        let most = energies.iter().copied().fold(0.0, f64::max);
        let mean = energies.iter().sum::<f64>() / energies.len().max(1) as f64;
        let extremes = extremes(&of);
        Self { of, band, extremes, steadiness: if most > 0.0 { mean / most } else { 1.0 } }
    }

    fn at(&self, emission: u64) -> Option<&Arc<dyn Waveform>> {
        in_turn(&self.of, emission)
    }

    fn most(&self, of: impl Fn(&dyn Waveform) -> f64) -> f64 {
        self.of.iter().map(|pulse| of(pulse.as_ref())).fold(0.0, f64::max)
    }
}

/// Places of all, up to [`EACH`]; of more, of those of each kind with the least and the largest length,
/// bandwidth and product of both, and of the outermost.
fn extremes(of: &[Arc<dyn Waveform>]) -> Vec<usize> {
    if of.len() <= EACH {
        return (0..of.len()).collect();
    }
    let figures: [fn(&dyn Waveform) -> f64; 5] = [
        |pulse| pulse.duration_s(),
        |pulse| pulse.bandwidth_hz(),
        |pulse| pulse.duration_s() * pulse.bandwidth_hz(),
        |pulse| pulse.band().from_hz,
        |pulse| pulse.band().to_hz,
    ];
    let mut places = BTreeSet::new();
    for kind in of.iter().map(|pulse| pulse.name()).collect::<BTreeSet<_>>() {
        for figure in figures {
            let of_kind = || (0..of.len()).filter(|n| of[*n].name() == kind);
            let by = |a: &usize, b: &usize| figure(of[*a].as_ref()).total_cmp(&figure(of[*b].as_ref()));
            places.extend(of_kind().min_by(by).into_iter().chain(of_kind().max_by(by)));
        }
    }
    places.into_iter().collect()
}

/// Integral of `|p|^2`, s.
fn energy_s(pulse: &dyn Waveform) -> f64 {
    let step_s = pulse.duration_s() / INSTANTS as f64;
    (0..INSTANTS).map(|n| pulse.sample((n as f64 + 0.5) * step_s).norm_sqr()).sum::<f64>() * step_s
}

impl Waveform for InTurn {
    fn name(&self) -> &str {
        "in-turn"
    }

    fn duration_s(&self) -> f64 {
        self.most(|pulse| pulse.duration_s())
    }

    fn bandwidth_hz(&self) -> f64 {
        self.band.width_hz()
    }

    fn band(&self) -> Band {
        self.band
    }

    fn lobe_hz(&self) -> f64 {
        self.most(|pulse| pulse.lobe_hz())
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        self.of.first().map_or(Complex64::ZERO, |pulse| pulse.spectrum(f_hz))
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        self.of.first().map_or(Complex64::ZERO, |pulse| pulse.sample(t_s))
    }

    fn moment_spectrum(&self, f_hz: f64) -> Complex64 {
        self.of.first().map_or(Complex64::ZERO, |pulse| pulse.moment_spectrum(f_hz))
    }

    fn of_emission(&self, emission: u64) -> Result<Option<Arc<dyn Waveform>>, WaveformError> {
        Ok(self.at(emission).cloned())
    }

    fn in_turn(&self) -> &[Arc<dyn Waveform>] {
        &self.of
    }

    fn extremes(&self) -> &[usize] {
        &self.extremes
    }

    fn steadiness(&self, _emissions: u64) -> f64 {
        self.steadiness
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::waveform::Coded;
    use crate::scene::radar::Code;

    #[test]
    fn energies_weigh_the_strongest() {
        let pulse = |us: f64| Arc::new(Coded::plain(us * 1e-6).unwrap()) as Arc<dyn Waveform>;
        let pulses = InTurn::new(vec![pulse(1.0), pulse(3.0)]);
        assert!((pulses.steadiness(2) - 2.0 / 3.0).abs() < 1e-9);
        assert_eq!(pulses.duration_s(), 3e-6);
    }

    /// Autocorrelations of a Golay pair add up to that of one chip: their power spectra to `2 N |P_chip|^2`.
    #[test]
    fn golay_pairs_have_no_side_lobes() {
        for chips in [2usize, 8, 64, 4096] {
            let pulse = |second| Coded::new(Code::Golay { chips, second }, 1e-7).unwrap();
            let (a, b, chip) = (pulse(false), pulse(true), Coded::plain(1e-7).unwrap());
            for n in -40..=40 {
                let f_hz = 0.171e6 * f64::from(n);
                let both = a.spectrum(f_hz).norm_sqr() + b.spectrum(f_hz).norm_sqr();
                let wanted = 2.0 * chips as f64 * chip.spectrum(f_hz).norm_sqr();
                assert!((both - wanted).abs() < 1e-9 * chips as f64 * 1e-14, "{chips} {f_hz}");
            }
        }
    }
}
