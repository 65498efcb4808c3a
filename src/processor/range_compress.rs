//! Range compression with the recorded replica.
//!
//! The echo of a scatterer path, mid-pulse at `t_m + Tc/2 + tau`, is
//! `a e^{-j 2 pi f0 tau} q(u) e^{+j 2 pi f_D (u - Tc/2)}`, `u` after its start. Its correlation with the
//! replica, turned by the Doppler `f_D` that the middle of the image has in this pulse,
//!
//! ```text
//! C(tau) = sum_i s(t_i) conj( q(t_i - tau) e^{j 2 pi f_D (t_i - tau - Tc/2)} ) / sum_i |q_i|^2
//! ```
//!
//! peaks at `tau`, the delay of the **middle** of the pulse, with `a e^{-j 2 pi f0 tau}`: the phase at
//! mid-pulse has no first-order term in the Doppler that is left. That leaves `delta f_D Tc / B` of range (5
//! mm of path for 1 kHz, 1 us, 60 MHz).
//!
//! * In the frequency domain: `S(f) conj(Q(f)) w(f/B)`, or flat `S(f) / Q(f) w(f/B)` within the band, see
//!   [`RangeFilter`]. Divided by what the replica itself makes of that at its place, `sum |Q|^2 w` or `sum w`
//!   over the bins: the peak is `a` whatever the taper.
//! * Zeros beyond the band interleave `oversampling` cells in a sample; between cells the image interpolates
//!   linearly. Relative rms error of that for a flat band `B`, cells of `h = 1/(fs oversampling)`:
//!   `sqrt(1/30)/2 sqrt(1/5) (pi B h)^2 = 0.0408 (pi B h)^2`: [`interpolation_error_db`]. Asked for an error,
//!   [`oversampling`] finds the cells.
//! * The transform is longer than window and replica together: nothing wraps. Delays are kept from the first
//!   sample to the last; near the last the echo is cut by the window, and weaker.
//!
//! ```
//! use nereus::processor::range_compress::{interpolation_error_db, oversampling};
//! // 60 MHz at 100 MHz: 16 cells per sample reach -60 dB.
//! assert_eq!(oversampling(60e6, 100e6, -60.0), 16);
//! assert!(interpolation_error_db(60e6, 16.0 * 100e6) < -64.9);
//! ```

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::{Complex32, Complex64};

use super::taper::Taper;
use crate::recording::header::Header;
use crate::scene::radar::Band;
use crate::units::in_turn;

/// Most cells in a sample.
const MOST_OVERSAMPLING: usize = 64;

/// What becomes of the spectrum of the pulse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum RangeFilter {
    /// The matched filter: best against noise. Side lobes are those of the pulse (of a sweep of `B Tc = 20`
    /// behind the receive filter: -13.7 dB).
    #[default]
    Matched,
    /// The spectrum of the pulse is divided out within the band: the response is that of the taper, whatever
    /// the pulse.
    Flat,
}

/// What cannot be compressed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CompressError {
    /// A pulse, a rate or a band that is none.
    #[error(
        "replica of {replica} samples at {sample_rate_hz} Hz, bandwidth {bandwidth_hz} Hz, window of {samples} samples: positive numbers and a replica that is not zero are needed"
    )]
    Pulse {
        /// Samples of the replica.
        replica: usize,
        /// Sample rate, Hz.
        sample_rate_hz: f64,
        /// Bandwidth, Hz.
        bandwidth_hz: f64,
        /// Samples of the window.
        samples: usize,
    },
    /// Pulses in turn whose spectra cannot be divided out within one band.
    #[error("pulses of waveforms in turn cannot be compressed by a flat filter; allowed: the matched filter")]
    FlatInTurn,
    /// A band in which the replica has nothing.
    #[error("the replica has no power within its bandwidth of {bandwidth_hz} Hz")]
    Band {
        /// Bandwidth, Hz.
        bandwidth_hz: f64,
    },
}

/// Predicted relative rms error of linear interpolation, dB.
pub fn interpolation_error_db(bandwidth_hz: f64, cell_rate_hz: f64) -> f64 {
    20.0 * (0.0408 * (PI * bandwidth_hz / cell_rate_hz).powi(2)).log10()
}

/// Cells in a sample, a power of two, that keep the error of interpolation below `error_db`; 64 at most.
pub fn oversampling(bandwidth_hz: f64, sample_rate_hz: f64, error_db: f64) -> usize {
    let mut cells = 1;
    while cells < MOST_OVERSAMPLING
        && interpolation_error_db(bandwidth_hz.min(sample_rate_hz), sample_rate_hz * cells as f64) > error_db
    {
        cells *= 2;
    }
    cells
}

/// Compresses windows of one length.
pub struct Compressor {
    /// Of every pulse in turn: its replica, and one over what the filter makes of that at no delay.
    replicas: Vec<(Vec<Complex64>, f64)>,
    samples: usize,
    sample_rate_hz: f64,
    band: Band,
    pulse_s: f64,
    filter: RangeFilter,
    taper: Taper,
    oversampling: usize,
    len: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f32>>,
}

/// What a pulse looks like.
#[derive(Clone, Copy, Debug)]
pub struct PulseShape<'a> {
    /// As transmitted and filtered by the receiver, from its start, one entry per sample; of pulses in turn
    /// one after the other.
    pub replica: &'a [Complex32],
    /// Pulses in turn; 1 of a radar whose pulses are alike.
    pub turns: usize,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Its band about the carrier; that of all pulses in turn.
    pub band: Band,
    /// Length, s.
    pub pulse_s: f64,
}

impl<'a> PulseShape<'a> {
    /// That of a recording or a stream.
    pub fn of(header: &'a Header) -> Self {
        Self {
            replica: &header.replica,
            turns: header.turns(),
            sample_rate_hz: header.sample_rate_hz,
            band: header.band(),
            pulse_s: header.pulse_s,
        }
    }
}

impl Compressor {
    /// For windows of so many samples.
    ///
    /// # Errors
    /// A replica, a rate, a band or a window that is none.
    pub fn new(
        pulse: PulseShape,
        samples: usize,
        filter: RangeFilter,
        taper: Taper,
        oversampling: usize,
    ) -> Result<Self, CompressError> {
        let wide = |z: &Complex32| Complex64::new(z.re.into(), z.im.into());
        let length = pulse.replica.len() / pulse.turns.max(1);
        let replicas = pulse.replica.chunks_exact(length.max(1)).map(|own| own.iter().map(wide).collect());
        let replicas: Vec<Vec<Complex64>> = replicas.collect();
        let energy = |own: &Vec<Complex64>| own.iter().map(Complex64::norm_sqr).sum();
        let least = replicas.iter().map(energy).reduce(f64::min).unwrap_or(0.0);
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let legal = [least, pulse.sample_rate_hz, pulse.band.width_hz()].into_iter().all(positive)
            && pulse.pulse_s.is_finite()
            && samples > 0;
        if !legal {
            return Err(CompressError::Pulse {
                replica: pulse.replica.len(),
                sample_rate_hz: pulse.sample_rate_hz,
                bandwidth_hz: pulse.band.width_hz(),
                samples,
            });
        }
        if pulse.turns > 1 && filter == RangeFilter::Flat {
            return Err(CompressError::FlatInTurn);
        }
        let len = (samples + length).next_power_of_two();
        let oversampling = oversampling.clamp(1, MOST_OVERSAMPLING).next_power_of_two();
        let mut made = Self {
            replicas: replicas.into_iter().map(|replica| (replica, 1.0)).collect(),
            samples,
            sample_rate_hz: pulse.sample_rate_hz,
            band: pulse.band,
            pulse_s: pulse.pulse_s,
            filter,
            taper,
            oversampling,
            len,
            forward: nereus_fft::forward(len),
            inverse: nereus_fft::inverse(len * oversampling),
        };
        // Once, without Doppler: that moves the pulse under the taper by f_D/B and the level by less, 2.5e-4
        // for 15 kHz in 60 MHz.
        let level = |(replica, _): &(Vec<Complex64>, f64)| {
            let own = made.transform(&mut replica.iter().copied());
            let tapered = own.iter().enumerate().map(|(k, q)| (q * made.weight(k, *q)).re).sum::<f64>();
            match made.filter {
                RangeFilter::Matched => (own.iter().map(Complex64::norm_sqr).sum(), tapered),
                RangeFilter::Flat => (tapered, tapered),
            }
        };
        let levels: Vec<(f64, f64)> = made.replicas.iter().map(level).collect();
        // A taper weighs pulses in turn by where they lie in the band of all: their mean is of level 1.
        let kept = levels.iter().map(|(all, tapered)| tapered / all).sum::<f64>() / levels.len() as f64;
        for ((_, scale), (all, _)) in made.replicas.iter_mut().zip(levels) {
            *scale = (all * kept).recip();
            if !positive(*scale) {
                return Err(CompressError::Band { bandwidth_hz: pulse.band.width_hz() });
            }
        }
        Ok(made)
    }

    /// Cells of a compressed window: from the first sample to the last.
    pub fn cells(&self) -> usize {
        (self.samples - 1) * self.oversampling + 1
    }

    /// Cells in a second.
    pub fn cell_rate_hz(&self) -> f64 {
        self.sample_rate_hz * self.oversampling as f64
    }

    /// Sample rate, Hz.
    pub fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }

    /// Bins of a transform.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Samples of a window.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Middle of the pulse after its emission, s.
    pub fn middle_s(&self) -> f64 {
        0.5 * self.pulse_s
    }

    /// Bandwidth of the pulse, Hz.
    pub fn bandwidth_hz(&self) -> f64 {
        self.band.width_hz()
    }

    fn transform(&self, values: &mut dyn Iterator<Item = Complex64>) -> Vec<Complex64> {
        let mut bins: Vec<Complex64> = values.take(self.len).collect();
        bins.resize(self.len, Complex64::ZERO);
        self.forward.process(&mut bins);
        bins
    }

    /// What was radiated by a pulse of this number, and its scale.
    fn replica_of(&self, number: u64) -> (&[Complex64], f64) {
        in_turn(&self.replicas, number).map_or((&[], 1.0), |(replica, scale)| (replica, *scale))
    }

    /// What a bin of the echo is multiplied by where the pulse has `q`, without the scale.
    fn weight(&self, k: usize, q: Complex64) -> Complex64 {
        let len = self.len as f64;
        let signed = if k < self.len / 2 { k as f64 } else { k as f64 - len };
        let x = (signed / len * self.sample_rate_hz - self.band.middle_hz()) / self.band.width_hz();
        match (self.filter, self.taper) {
            // The whole spectrum of the pulse, what leaks over the edges of its band too.
            (RangeFilter::Matched, Taper::Uniform) => q.conj(),
            (RangeFilter::Matched, taper) => q.conj() * taper.weight(x),
            (RangeFilter::Flat, taper) if x.abs() <= 0.5 && q.norm_sqr() > 0.0 => q.inv() * taper.weight(x),
            (RangeFilter::Flat, _) => Complex64::ZERO,
        }
    }

    /// Spectrum of the compressed window of pulse `number`: bin `k` belongs to the frequency `k fs/N`, the
    /// upper half negative, and `C(lag) = sum_k spectrum[k] e^{j 2 pi f_k lag / fs}`.
    pub fn spectrum(&self, window: &[Complex32], number: u64, doppler_hz: f64) -> Vec<Complex64> {
        let (replica, scale) = self.replica_of(number);
        let mut echo = window.iter().take(self.samples).map(|z| Complex64::new(z.re.into(), z.im.into()));
        let mut bins = self.transform(&mut echo);
        let mut turned = replica.iter().enumerate().map(|(i, q)| {
            q * Complex64::cis(TAU * doppler_hz * (i as f64 / self.sample_rate_hz - self.middle_s()))
        });
        let pulse = self.transform(&mut turned);
        for (k, (bin, q)) in bins.iter_mut().zip(&pulse).enumerate() {
            *bin *= self.weight(k, *q) * scale;
        }
        bins
    }

    /// What a bin of the echo is multiplied by without Doppler, by the pulses in turn.
    pub(super) fn filters(&self) -> Vec<Vec<Complex64>> {
        let of = |(replica, scale): &(Vec<Complex64>, f64)| {
            let own = self.transform(&mut replica.iter().copied());
            own.iter().enumerate().map(|(k, q)| self.weight(k, *q) * scale).collect()
        };
        self.replicas.iter().map(of).collect()
    }

    /// Compresses the window of pulse `number` into [`Self::cells`] cells.
    pub fn compress(&self, window: &[Complex32], number: u64, doppler_hz: f64) -> Vec<Complex32> {
        let spectrum = self.spectrum(window, number, doppler_hz);
        let mut fine = vec![Complex32::ZERO; self.len * self.oversampling];
        let half = self.len / 2;
        let narrow = |z: &Complex64| Complex32::new(z.re as f32, z.im as f32);
        let upper = fine.len() - half;
        for (to, from) in fine[..half].iter_mut().zip(&spectrum[..half]) {
            *to = narrow(from);
        }
        for (to, from) in fine[upper..].iter_mut().zip(&spectrum[half..]) {
            *to = narrow(from);
        }
        self.inverse.process(&mut fine);
        fine.truncate(self.cells());
        // What is cut off is given back: many compressed windows are held at a time.
        fine.shrink_to_fit();
        fine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 100e6;
    const BAND_HZ: f64 = 60e6;

    /// A sweep, sampled; narrow enough in its band that what folds back is below -30 dB.
    fn sweep(pulse_s: f64, at_s: f64, doppler_hz: f64, samples: usize) -> Vec<Complex32> {
        (0..samples)
            .map(|i| {
                let u = i as f64 / RATE_HZ - at_s;
                let v = u - 0.5 * pulse_s;
                if !(0.0..pulse_s).contains(&u) {
                    return Complex32::ZERO;
                }
                let turns = 0.5 * BAND_HZ / pulse_s * v * v + doppler_hz * v;
                let z = Complex64::cis(TAU * turns);
                Complex32::new(z.re as f32, z.im as f32)
            })
            .collect()
    }

    fn compressor(pulse_s: f64, filter: RangeFilter, taper: Taper, oversampling: usize) -> Compressor {
        let replica = sweep(pulse_s, 0.0, 0.0, (pulse_s * RATE_HZ).ceil() as usize);
        let shape = PulseShape {
            replica: &replica,
            turns: 1,
            sample_rate_hz: RATE_HZ,
            band: Band::about(0.0, BAND_HZ),
            pulse_s,
        };
        Compressor::new(shape, 1024, filter, taper, oversampling).unwrap()
    }

    #[test]
    fn a_pulse_of_known_delay_and_doppler_is_found() {
        let pulse_s = 4e-6;
        let compressor = compressor(pulse_s, RangeFilter::Matched, Taper::Uniform, 16);
        // On a sample: between samples a cut sweep is not band limited and the peak is known to some 1e-2
        // only.
        for doppler_hz in [0.0, 15e3, -500e3] {
            let window = sweep(pulse_s, 300.0 / RATE_HZ, doppler_hz, 1024);
            let cells = compressor.compress(&window, 0, doppler_hz);
            let peak = (0..cells.len()).max_by(|a, b| cells[*a].norm().total_cmp(&cells[*b].norm())).unwrap();
            assert_eq!(peak, 300 * 16, "{doppler_hz}");
            // The same sums on both sides: rounding of f32 over 14 stages.
            assert!((cells[peak] - Complex32::ONE).norm() < 2e-5, "{}", cells[peak]);
        }
    }

    #[test]
    fn a_pulse_has_its_own_level_behind_every_filter_and_taper() {
        for filter in [RangeFilter::Matched, RangeFilter::Flat] {
            for taper in [Taper::Uniform, Taper::Hann, Taper::Taylor, Taper::Kaiser] {
                let compressor = compressor(4e-6, filter, taper, 16);
                let window = sweep(4e-6, 300.0 / RATE_HZ, 0.0, 1024);
                let cells = compressor.compress(&window, 0, 0.0);
                // The same sums on both sides: rounding of f32 over 14 stages.
                assert!((cells[300 * 16] - Complex32::ONE).norm() < 2e-5, "{filter:?} {taper:?}");
            }
        }
        // A replica that has nothing where the taper is: two samples that cancel, a band of one bin.
        let replica = [Complex32::ONE, -Complex32::ONE];
        let shape = PulseShape {
            replica: &replica,
            turns: 1,
            sample_rate_hz: RATE_HZ,
            band: Band::about(0.0, 1.0),
            pulse_s: 2e-8,
        };
        for filter in [RangeFilter::Matched, RangeFilter::Flat] {
            let refused = Compressor::new(shape, 64, filter, Taper::Hann, 1);
            assert_eq!(refused.err(), Some(CompressError::Band { bandwidth_hz: 1.0 }));
        }
    }

    #[test]
    fn interpolation_errs_as_predicted() {
        let compressor = compressor(4e-6, RangeFilter::Flat, Taper::Uniform, 16);
        let window = sweep(4e-6, 200.0 / RATE_HZ, 0.0, 1024);
        let cells = compressor.compress(&window, 0, 0.0);
        let spectrum = compressor.spectrum(&window, 0, 0.0);
        let exact = |lag: f64| -> Complex64 {
            let len = spectrum.len();
            let signed = |k: usize| if k < len / 2 { k as f64 } else { k as f64 - len as f64 };
            (0..len).map(|k| spectrum[k] * Complex64::cis(TAU * signed(k) * lag / len as f64)).sum()
        };
        let (mut error, mut power) = (0.0, 0.0);
        for i in 0..2000 {
            let cell = 2400.0 + 1600.0 * f64::from(i) / 2000.0 + 0.013 * f64::from(i % 7);
            let (at, part) = (cell as usize, cell.fract() as f32);
            let found = cells[at] + (cells[at + 1] - cells[at]) * part;
            let wanted = exact(cell / 16.0);
            error += (Complex64::new(found.re.into(), found.im.into()) - wanted).norm_sqr();
            power += wanted.norm_sqr();
        }
        let (found, predicted) =
            (10.0 * (error / power).log10(), interpolation_error_db(BAND_HZ, 16.0 * RATE_HZ));
        println!("linear interpolation {found:.1} dB, predicted {predicted:.1} dB");
        // The main lobe holds 90 % of the power in one place: half a decibel of it.
        assert!((found - predicted).abs() < 1.0);
    }

    /// Sweeps of 4 MHz up and down, 30 MHz off the carrier: each has its own level behind every taper, which
    /// lies about their band; interpolation is as good as predicted from what is farthest off the carrier.
    #[test]
    fn pulses_in_turn_have_their_own_levels_off_the_carrier() {
        let (samples, off_hz, wide_hz, pulse_s) = (400, 30e6, 4e6, 4e-6);
        let pulse = |sign: f64| -> Vec<Complex32> {
            let at = |i: usize| {
                let v = i as f64 / RATE_HZ - 0.5 * pulse_s;
                Complex64::cis(TAU * (off_hz * (v + 0.5 * pulse_s) + sign * 0.5 * wide_hz / pulse_s * v * v))
            };
            (0..samples).map(|i| Complex32::new(at(i).re as f32, at(i).im as f32)).collect()
        };
        let pulses = [pulse(1.0), pulse(-1.0)];
        let replica = pulses.concat();
        let band = Band::about(off_hz, wide_hz);
        let shape = PulseShape { replica: &replica, turns: 2, sample_rate_hz: RATE_HZ, band, pulse_s };
        let cells = oversampling(2.0 * band.reach_hz(), RATE_HZ, -60.0);
        for taper in [Taper::Uniform, Taper::Hann, Taper::Taylor] {
            let compressor = Compressor::new(shape, 1024, RangeFilter::Matched, taper, cells).unwrap();
            for number in 0..4 {
                let mut window = vec![Complex32::ZERO; 1024];
                window[300..300 + samples].copy_from_slice(&pulses[number as usize % 2]);
                let found = compressor.compress(&window, number, 0.0);
                assert!((found[300 * cells] - Complex32::ONE).norm() < 2e-5, "{taper:?} {number}");
                // Compressed as the pulse before it, it has no peak.
                let other = compressor.compress(&window, number + 1, 0.0);
                let most = other.iter().map(|z| z.norm()).fold(0.0, f32::max);
                assert!(most < 0.5, "{taper:?} {number}: {most}");
            }
        }
    }

    /// 16 steps of 5 MHz over a band of 80 MHz: their sum has the side lobes of the taper.
    #[test]
    fn steps_are_weighed_by_the_taper() {
        let (steps, step_hz, samples) = (16, 5e6, 20);
        let pulse = |k: usize| -> Vec<Complex32> {
            let hz = (k as f64 - 7.5) * step_hz;
            let of = |i: usize| Complex64::cis(TAU * hz * i as f64 / RATE_HZ);
            (0..samples).map(|i| Complex32::new(of(i).re as f32, of(i).im as f32)).collect()
        };
        let pulses: Vec<Vec<Complex32>> = (0..steps).map(pulse).collect();
        let replica = pulses.concat();
        let band = Band::about(0.0, 80e6);
        let shape =
            PulseShape { replica: &replica, turns: steps, sample_rate_hz: RATE_HZ, band, pulse_s: 2e-7 };
        let lobe_db = |taper| {
            let compressor = Compressor::new(shape, 512, RangeFilter::Matched, taper, 16).unwrap();
            let mut sum = vec![Complex32::ZERO; compressor.cells()];
            for (number, pulse) in pulses.iter().enumerate() {
                let mut window = vec![Complex32::ZERO; 512];
                window[200..200 + samples].copy_from_slice(pulse);
                let found = compressor.compress(&window, number as u64, 0.0);
                sum.iter_mut().zip(found).for_each(|(sum, own)| *sum += own);
            }
            let peak = 200 * 16;
            assert!((sum[peak] / steps as f32 - Complex32::ONE).norm() < 1e-4, "{taper:?}: {}", sum[peak]);
            // Beyond the main lobe, which is twice as wide behind the taper: cells in resolution cells.
            let beyond = 2.2 * RATE_HZ * 16.0 / 80e6;
            let off = |i: usize| (i as f64 - peak as f64).abs();
            let lobes = (0..sum.len()).filter(|i| (beyond..beyond * 3.0).contains(&off(*i)));
            let most = lobes.map(|i| sum[i].norm()).fold(0.0, f32::max);
            20.0 * (most / sum[peak].norm()).log10()
        };
        let [plain, hann] = [Taper::Uniform, Taper::Hann].map(lobe_db);
        println!("side lobes {plain:.1} dB, behind Hann's taper {hann:.1} dB");
        // A periodic sinc of 16 steps (times the triangle of a pulse), -17.8 dB beyond two cells; Hann's
        // -31.5 dB.
        assert!(plain > -20.0 && hann < -30.0);
    }

    #[test]
    fn a_flat_filter_leaves_a_sinc_of_any_pulse() {
        for pulse_s in [0.333e-6, 4e-6] {
            let compressor = compressor(pulse_s, RangeFilter::Flat, Taper::Uniform, 16);
            let cells = compressor.compress(&sweep(pulse_s, 200.0 / RATE_HZ, 0.0, 1024), 0, 0.0);
            for lag in -40..=40i32 {
                let x = PI * BAND_HZ * f64::from(lag) / (16.0 * RATE_HZ);
                let sinc = if lag == 0 { 1.0 } else { x.sin() / x };
                let found = cells[(3200 + lag) as usize];
                // The width of the band is known to a bin: 1/(N B/fs), one part in 600 at N = 1024 and 2048.
                assert!((f64::from(found.re) - sinc).abs() < 4e-3, "{lag}: {found} {sinc}");
            }
        }
    }
}
