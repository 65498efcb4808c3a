//! The front end of a receiver that is not ideal: what its samples are before the converter.
//!
//! Of the samples `s_j` that an ideal receiver would have (noise included), taken at `t_j` after the
//! emission:
//!
//! 1. **Jitter of the sampling clock.** The sample is taken `d_j` late, `d_j` normal of deviation `sigma`,
//!    independent from sample to sample, the same in all channels of a pulse: to first order
//!    `s_j <- (s_j + s'(t_j) d_j) e^{j 2 pi f_IF d_j}`, with `s'` from `j 2 pi f S(f)`. A tone at `f` from
//!    the carrier then has the ratio `-20 log10(2 pi |f + f_IF| sigma)` of signal to noise.
//! 2. **Blanking.** 0 while the radar transmits, and for a while after: `0 <= t - T_k < T_c + T_r` for any
//!    emission `T_k`, in channels whose transmitter and receiver are on the same platform.
//! 3. **Sensitivity time control.** `s_j <- s_j g`, `g^2 = max((t/T)^n, depth)` for `t < T` after the last
//!    emission, else 1.
//! 4. **Automatic gain control** within the window: `s_j <- s_j g_j`, `g_j^2 = min(1, max(P/p_j, depth))`,
//!    `p_j = p_{j-1} + (|s_j|^2 - p_{j-1}) (1 - e^{-1/(fs T)})`, `p_{-1} = 0`, `T` one time constant where
//!    power rises, another where it falls.
//! 5. **Imbalance and offset.** `I <- r^{1/2} I + o_I`, `Q <- r^{-1/2} (Q cos phi + I sin phi) + o_Q`, `r`
//!    the ratio of the amplitudes: `s <- alpha s + beta s* + o`,
//!
//! `alpha = (r^{1/2} + r^{-1/2} e^{j phi})/2` , `beta = (r^{1/2} - r^{-1/2} e^{-j phi})/2` ,
//!
//! so the image of a tone lies `|alpha/beta|^2 = (r + 1/r + 2 cos phi)/(r + 1/r - 2 cos phi)` below it.
//!
//! **Instability of the transmitter** multiplies the echo of pulse `n` before noise is added, by
//! `10^{l_n/20} e^{j phi_n}`, both normal: a canceller of two pulses leaves `2 (sigma_a^2 + sigma_phi^2)` of
//! what stands still, `sigma_a = sigma_l ln(10)/20`.
//!
//! Numbers of pulse `n` come from the streams (seed, sampling jitter, n) and (seed, transmitter, n) alone.
//! Limits: jitter to first order (of a relative error `(2 pi f sigma)^2/2`), and white; imbalance that does
//! not depend on frequency; the gain of sensitivity time control changes at once; emissions beyond the end
//! of the run blank as others do.
//!
//! ```
//! use nereus::radar::front_end::imbalance;
//! let [alpha, beta] = imbalance(1.0, 5f64.to_radians());
//! // 1 dB and 5 degrees: 22.8 dB.
//! let ratio_db = 20.0 * (alpha.norm() / beta.norm()).log10();
//! assert!((ratio_db - 22.8).abs() < 0.05, "{ratio_db}");
//! ```

use std::f64::consts::TAU;

use num_complex::Complex64;
use rand_distr::{Distribution, StandardNormal};

use crate::pulse::Pulse;
use crate::radar::waveform::{Waveform, pulses};
use crate::rng::{Room, stream};
use crate::scene::Radar;
use crate::scene::front_end::{Agc, Instability, Jitter, Stc};
use crate::time::PulseTimes;
use crate::units::in_turn;

/// Prepared for the channels of a radar.
#[derive(Clone, Debug)]
pub struct FrontEnd {
    seed: u64,
    sample_rate_hz: f64,
    /// What is left of a sample, and its image; `None` without imbalance.
    imbalance: Option<[Complex64; 2]>,
    offset: Complex64,
    stc: Option<Stc>,
    agc: Option<Agc>,
    instability: Option<Instability>,
    jitter: Option<Jitter>,
    /// From the begin of an emission on, s, by the pulses in turn; empty where nothing is blanked.
    blanked_s: Vec<f64>,
    emissions: PulseTimes,
    /// Of each channel, the window of its receiver, and whether its transmitter stands beside it.
    channels: Vec<(usize, bool)>,
}

/// `alpha` and `beta` of a ratio of the gains of I and Q, dB, and an error of phase, rad.
pub fn imbalance(gain_db: f64, phase_rad: f64) -> [Complex64; 2] {
    let root = 10f64.powf(gain_db / 40.0);
    let turned = Complex64::from_polar(root.recip(), phase_rad);
    [0.5 * (root + turned), 0.5 * (root - turned.conj())]
}

/// Gain of sensitivity time control at a time after the last emission, of amplitudes.
pub fn stc_gain(stc: &Stc, after_s: f64) -> f64 {
    if after_s >= stc.full_s {
        return 1.0;
    }
    let least = 10f64.powf(-stc.depth_db / 20.0);
    (after_s.max(0.0) / stc.full_s).powf(0.5 * stc.exponent).max(least)
}

/// Automatic gain control of the samples of a window, `scale` of which are sqrt(W).
fn control(agc: &Agc, sample_rate_hz: f64, scale: f64, samples: &mut [Complex64]) {
    let share = |constant_s: f64| -(-1.0 / (sample_rate_hz * constant_s)).exp_m1();
    let [rises, falls] = [agc.attack_s, agc.release_s].map(share);
    let least = 10f64.powf(-agc.depth_db / 10.0);
    let mut mean_w = 0.0;
    for sample in samples {
        let off_w = sample.norm_sqr() * scale * scale - mean_w;
        mean_w += off_w * if off_w > 0.0 { rises } else { falls };
        if mean_w > agc.level_w {
            *sample *= (agc.level_w / mean_w).max(least).sqrt();
        }
    }
}

impl FrontEnd {
    /// That of a radar that radiates this; `None` where it is ideal.
    pub fn new(radar: &Radar, seed: u64, waveform: &dyn Waveform) -> Option<Self> {
        let of = &radar.front_end;
        if of.is_ideal() {
            return None;
        }
        let windows = radar.window_leads().len();
        let channel = |channel: &crate::scene::radar::Channel| {
            // One switch serves all channels of a receiver.
            let own = radar.receivers.get(channel.receiver).map(|end| end.antenna.platform);
            let beside = radar.transmitters.iter().any(|end| Some(end.antenna.platform) == own);
            (if windows > 1 { channel.receiver } else { 0 }, beside)
        };
        let balanced = of.iq_gain_db == 0.0 && of.iq_phase_rad == 0.0;
        Some(Self {
            seed,
            sample_rate_hz: radar.sample_rate_hz,
            imbalance: (!balanced).then(|| imbalance(of.iq_gain_db, of.iq_phase_rad)),
            offset: Complex64::new(of.offset[0], of.offset[1]),
            stc: of.stc,
            agc: of.agc,
            instability: of.instability,
            jitter: of.jitter,
            blanked_s: of.blanked_s.map_or_else(Vec::new, |after_s| {
                pulses(waveform).iter().map(|pulse| pulse.duration_s() + after_s).collect()
            }),
            emissions: radar.emissions.clone(),
            channels: radar.channels.iter().map(channel).collect(),
        })
    }

    /// What multiplies the echo of a pulse; `None` where all are alike.
    pub fn transmitted(&self, pulse: u64) -> Option<Complex64> {
        let Instability { level_db, phase_rad } = self.instability?;
        let mut numbers = stream(self.seed, Room::Transmitter, pulse, 0);
        let [level, phase]: [f64; 2] = [level_db, phase_rad]
            .map(|deviation| deviation * Distribution::<f64>::sample(&StandardNormal, &mut numbers));
        Some(Complex64::from_polar(10f64.powf(level / 20.0), phase))
    }

    /// Whether it needs the derivative of what it samples.
    pub fn jitters(&self) -> bool {
        self.jitter.is_some()
    }

    /// Samples of a channel of a pulse before the converter, `scale` of which are sqrt(W); their derivatives,
    /// 1/s, are asked for where it jitters.
    pub fn apply(
        &self,
        pulse: &Pulse,
        channel: usize,
        scale: f64,
        samples: &mut [Complex64],
        derivatives: &[Complex64],
    ) {
        if let Some(Jitter { rms_s, intermediate_hz }) = self.jitter {
            let mut numbers = stream(self.seed, Room::SamplingJitter, pulse.index, 0);
            for (sample, derivative) in samples.iter_mut().zip(derivatives) {
                let normal: f64 = StandardNormal.sample(&mut numbers);
                let late_s = rms_s * normal;
                *sample = (*sample + derivative * late_s) * Complex64::cis(TAU * intermediate_hz * late_s);
            }
        }
        if !self.blanked_s.is_empty() || self.stc.is_some() {
            self.gate(pulse, channel, samples);
        }
        if let Some(agc) = &self.agc {
            control(agc, self.sample_rate_hz, scale, samples);
        }
        if let Some([alpha, beta]) = self.imbalance {
            for sample in samples.iter_mut() {
                *sample = alpha * *sample + beta * sample.conj();
            }
        }
        if self.offset != Complex64::ZERO {
            let offset = self.offset / scale;
            samples.iter_mut().for_each(|sample| *sample += offset);
        }
    }

    /// Blanking and sensitivity time control.
    fn gate(&self, pulse: &Pulse, channel: usize, samples: &mut [Complex64]) {
        let (window, beside) = self.channels.get(channel).copied().unwrap_or((0, true));
        let starts = pulse.window_starts_s();
        let open_s = starts.get(window).or(starts.first()).copied().unwrap_or(0.0);
        let blanked_s = |emission| in_turn(&self.blanked_s, emission).filter(|_| beside);
        // The last emission before a sample; the window may open after the next one.
        let (mut last_s, mut next) = (0.0, 1);
        let mut next_s = self.emissions.interval_s(pulse.index, pulse.index.saturating_add(1));
        for (j, sample) in samples.iter_mut().enumerate() {
            let t_s = open_s + j as f64 / self.sample_rate_hz;
            while t_s >= next_s {
                last_s = next_s;
                next += 1;
                next_s = self.emissions.interval_s(pulse.index, pulse.index.saturating_add(next));
            }
            let after_s = t_s - last_s;
            let emission = pulse.index.saturating_add(next - 1);
            if blanked_s(emission).is_some_and(|blanked_s| (0.0..*blanked_s).contains(&after_s)) {
                *sample = Complex64::ZERO;
            } else if let Some(stc) = &self.stc {
                *sample *= stc_gain(stc, after_s);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strong_samples_are_brought_to_the_level() {
        let agc = Agc { level_w: 1e-6, attack_s: 1e-6, release_s: 10e-6, depth_db: 40.0 };
        // 20 MHz: 1000 samples of -40 dBW, then of -80 dBW; a unit of samples is 0.1 sqrt(W).
        let mut samples =
            [vec![Complex64::new(0.0, 0.1); 1000], vec![Complex64::new(1e-3, 0.0); 2000]].concat();
        control(&agc, 20e6, 0.1, &mut samples);
        let db = |n: usize| 20.0 * (0.1 * samples[n].norm()).log10();
        // At first as it was; after three time constants within 0.3 dB; then held down, let go in time.
        let first_w = 1e-4 * -(-1.0f64 / 20.0).exp_m1();
        assert!((db(0) + 40.0 - 10.0 * (1e-6 / first_w).log10()).abs() < 1e-9, "{}", db(0));
        assert!((db(60) + 60.0 - 0.2).abs() < 0.1 && (db(999) + 60.0).abs() < 1e-6, "{}", db(60));
        assert!((db(1000) + 100.0).abs() < 0.1, "{}", db(1000));
        // The mean falls by e in 200 samples: 20 dB in 921.
        assert!(db(1900) < -80.0 - 0.1 && (db(1960) + 80.0).abs() < 1e-6, "{} {}", db(1900), db(1960));
        // No gain is below the depth.
        let mut strong = vec![Complex64::new(1e3, 0.0); 400];
        control(&agc, 20e6, 1.0, &mut strong);
        assert!((strong[399].norm() - 10.0).abs() < 1e-6);
    }

    #[test]
    fn the_gain_grows_by_its_law() {
        let stc = Stc { full_s: 40e-6, exponent: 4.0, depth_db: 60.0 };
        let db = |after_s: f64| 20.0 * stc_gain(&stc, after_s).log10();
        assert_eq!((db(40e-6), db(1.0), db(0.0), db(-1.0)), (0.0, 0.0, -60.0, -60.0));
        // R^4: 12 dB an octave.
        assert!((db(20e-6) + 40.0 * 2f64.log10()).abs() < 1e-12);
        assert!((db(4e-6) + 40.0).abs() < 1e-12 && db(1e-6) == -60.0);
    }
}
