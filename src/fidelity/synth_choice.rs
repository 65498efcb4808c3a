//! Settings of the synthesis alone, apart from interpolation: kernel, envelope, Doppler within a pulse.

use std::sync::Arc;

use super::PlanError;
use super::probe::ErrorSampler;
use super::probe::points::Law;
use crate::echo::Asked;
use crate::echo::synth::doppler::{Doppler, Envelope, MeanEcho, rigid_error_power};
use crate::echo::synth::kernel::WIDTHS;
use crate::echo::synth::{Precision, PredictedError, Settings, Synth};
use crate::fidelity::budget::Budget;
use crate::fidelity::cost::Size;
use crate::paths::PathGenerator;
use crate::radar::waveform::Waveform;
use crate::scene::Scene;

/// Units of pulses over which positions on the grid move in a common block, for their rounding.
const DRIFT_PULSES: f64 = 12.0;
/// Cells a sample.
const OVERSAMPLINGS: [f64; 3] = [2.0, 3.0, 4.0];
/// Of what is spread, what transforms may take where there are more cells than need be.
const OF_SPREAD: f64 = 0.03;
/// Share of the budget that gridding may take, where a kernel allows.
const OF_GRIDDING: f64 = 0.1;
/// Share of the budget up to which envelopes are left rigid: 0.04 dB.
const OF_RIGID: f64 = 0.01;
/// Share of the budget that Doppler may leave where pulses are split into bands of it.
const OF_BANDS: f64 = 0.3;
/// Rounding of the samples to f32, those of the reference too: uniform within a unit of `2^-23` where the
/// mantissa is 1, on the whole half the power of that, `2 x 2^-46/24`.
const OF_SAMPLES: f64 = 1.2e-15;

/// Settings of the synthesis and the errors they leave.
pub(super) struct SynthChoice {
    /// For blocks of pulses.
    pub settings: Settings,
    /// For pulses made one by one.
    pub single: Settings,
    /// Error of these.
    pub single_error: PredictedError,
    gridding: PredictedError,
    /// What gridding and what rigid envelopes leave of points.
    of_points: [f64; 2],
    of_envelope: f64,
    of_doppler: DopplerError,
}

impl SynthChoice {
    /// Error in blocks of so many pulses.
    pub fn error_of(&self, block: u64) -> PredictedError {
        let in_phase = self.in_phase(self.of_doppler.of_points(block));
        let doppler = self.of_doppler.of_blocks(block) + in_phase + self.of_envelope;
        PredictedError { doppler, ..self.gridding }
    }

    /// What the sum of amplitudes adds to the sum of powers: the errors of gridding, rigid envelopes and
    /// Doppler of a point all lie at the ends of its band, and may be in phase.
    fn in_phase(&self, doppler_of_points: f64) -> f64 {
        let [gridding, envelope] = self.of_points.map(f64::sqrt);
        let doppler = doppler_of_points.sqrt();
        2.0 * (gridding * envelope + gridding * doppler + envelope * doppler)
    }
}

/// The fast echo of a scene.
pub(super) struct Echoes<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its scatterer paths.
    pub generator: &'a PathGenerator,
    /// Its pulse.
    pub waveform: &'a Arc<dyn Waveform>,
}

/// What Doppler within a pulse leaves: of facets, and of points in blocks of so many pulses.
struct DopplerError {
    of_facets: f64,
    of_points: Vec<(u64, f64)>,
}

impl DopplerError {
    /// Of points, in blocks of so many pulses.
    fn of_points(&self, pulses: u64) -> f64 {
        self.of_points.iter().find(|(block, _)| *block == pulses).map_or(0.0, |(_, of)| *of)
    }

    /// In blocks of so many pulses.
    fn of_blocks(&self, pulses: u64) -> f64 {
        self.of_facets + self.of_points(pulses)
    }
}

impl Echoes<'_> {
    /// Chooses what is not given, for blocks of each of these lengths, pulses.
    ///
    /// # Errors
    /// Settings that the fast echo refuses, or tracks that end early.
    pub fn choose(
        &self,
        sampler: &mut ErrorSampler<'_>,
        budget: &Budget,
        blocks: &[u64],
    ) -> Result<SynthChoice, PlanError> {
        let asked = &budget.asked;
        let (mut settings, gridding, fft_len) = self.kernel(sampler, budget)?;
        let of_rigid = self.rigid_error(sampler, fft_len);
        if !budget.exact && of_rigid <= OF_RIGID * budget.power {
            settings.envelope = Envelope::Rigid;
        }
        let of_envelope = if settings.envelope == Envelope::Rigid { of_rigid } else { 0.0 };

        let longest = blocks.iter().copied().max().unwrap_or(1);
        let of = |doppler: Doppler| (doppler, settings.envelope);
        let mut of_doppler = self.doppler_error(sampler, of(settings.doppler), fft_len, blocks)?;
        let of_one_layer = of_doppler.of_blocks(longest);
        let free = asked.doppler.is_none() && !settings.doppler.has_moments();
        if free && of_one_layer > OF_BANDS * budget.power {
            // A second layer costs as much as the first.
            let mut most = 0.5 * of_one_layer;
            let swept = self.waveform.sweep_rate_hz_per_s().is_some();
            let others = [Doppler::Taylor, Doppler::ShiftTaylor];
            for doppler in others.into_iter().filter(|doppler| swept || !doppler.needs_sweep()) {
                let other = self.doppler_error(sampler, of(doppler), fft_len, blocks)?;
                if other.of_blocks(longest) < most {
                    settings.doppler = doppler;
                    most = other.of_blocks(longest);
                    of_doppler = other;
                }
            }
        }
        let (mut single, single_error) = (settings, gridding);
        // What points have of an error in which each counts with so many images.
        let share = |images: f64| sampler.peak([0.0, images]) / sampler.peak([1.0, images]).max(1.0);
        let of_points = [gridding.gridding * share(2.0), of_envelope * share(1.0)];
        let mut choice =
            SynthChoice { settings, single, single_error, gridding, of_points, of_envelope, of_doppler };
        choice.single_error = choice.error_of(1);
        // Pulses by themselves can be split into bands of Doppler.
        let most = OF_BANDS * budget.power;
        if asked.doppler.is_none() && choice.of_doppler.of_blocks(1) + of_envelope > most {
            let of = (settings.doppler, settings.envelope);
            if let Some((band_hz, left)) = self.band(sampler, of, fft_len, most) {
                let doppler = left + choice.in_phase(left * share(1.0)) + of_envelope;
                if doppler < choice.single_error.doppler {
                    single.band_hz = Some(band_hz);
                    choice.single = single;
                    choice.single_error = PredictedError { doppler, ..gridding };
                }
            }
        }
        Ok(choice)
    }

    /// The narrowest kernel whose gridding takes a tenth of the budget, or the widest there is, on as many
    /// cells as pay; its error, and the samples of a transform.
    fn kernel(
        &self,
        sampler: &ErrorSampler<'_>,
        budget: &Budget,
    ) -> Result<(Settings, PredictedError, usize), PlanError> {
        let Asked { kernel_width, doppler, variant, .. } = budget.asked;
        let doppler = doppler.unwrap_or(match self.waveform.sweep_rate_hz_per_s() {
            Some(_) => Doppler::Shift,
            // Pulses and segments are often so short that one layer does.
            None => Doppler::Mean,
        });
        let guard_samples = self.generator.guard_samples();
        let of = |width: usize, oversampling: f64| {
            let settings =
                Settings { width, oversampling, doppler, guard_samples, variant, ..Settings::default() };
            let (error, fft_len) = self.error(sampler, settings, budget.precision)?;
            Ok::<_, PlanError>((settings, error, fft_len))
        };
        let most = OF_GRIDDING * budget.power;
        let mut chosen = of(kernel_width.unwrap_or(*WIDTHS.start()), OVERSAMPLINGS[0])?;
        while kernel_width.is_none() && chosen.1.gridding > most && chosen.0.width < *WIDTHS.end() {
            chosen = of(chosen.0.width + 1, OVERSAMPLINGS[0])?;
        }
        // More cells take fewer taps; where tiles have supports, what is spread is little.
        let spread_at_all = sampler.between(budget.power).is_none();
        for oversampling in OVERSAMPLINGS.into_iter().skip(1).filter(|_| spread_at_all) {
            let width = kernel_width.unwrap_or(chosen.0.width.saturating_sub(1));
            let known = kernel_width.is_some() && chosen.1.gridding <= most;
            if known || width < *WIDTHS.start() || !self.is_short(&chosen.0, oversampling) {
                break;
            }
            let finer = of(width, oversampling)?;
            if finer.1.gridding <= most {
                chosen = finer;
            }
        }
        Ok(chosen)
    }

    /// Whether transforms of so many cells a sample take next to nothing beside what is spread.
    fn is_short(&self, settings: &Settings, oversampling: f64) -> bool {
        let settings = Settings { oversampling, ..*settings };
        let size = Size::of(self.scene, self.generator, &settings, self.waveform.as_ref(), 1.0);
        let [spread, transform] = size.grid_seconds(settings.width);
        transform < OF_SPREAD * spread
    }

    /// Gridding and rounding, the worst pair, and the samples of a transform.
    fn error(
        &self,
        sampler: &ErrorSampler<'_>,
        settings: Settings,
        precision: Precision,
    ) -> Result<(PredictedError, usize), PlanError> {
        let radar = &self.scene.radar;
        let of_channels = self.generator.channel_pairs();
        let (waveform, samples) = (Arc::clone(self.waveform), radar.window.samples);
        let (carrier_hz, rate_hz) = (radar.carrier_hz, radar.sample_rate_hz);
        let cells_per_s = settings.oversampling * rate_hz;
        let unit = sampler.unit() as f64;
        let half_s = 0.5 * DRIFT_PULSES * unit * radar.emissions.mean_pri_s();
        let drift_cells =
            if precision == Precision::Double { 0.0 } else { sampler.fastest() * half_s * cells_per_s };
        let (fft_len, of): (usize, Box<dyn Fn(f64) -> PredictedError>) = match precision {
            Precision::Single => {
                let synth = Synth::<f32>::new(waveform, carrier_hz, rate_hz, samples, of_channels, settings)?;
                (synth.fft_len(), Box::new(move |mean| synth.predicted_error_of(mean, 0.0, drift_cells)))
            }
            Precision::Double => {
                let synth = Synth::<f64>::new(waveform, carrier_hz, rate_hz, samples, of_channels, settings)?;
                (synth.fft_len(), Box::new(move |mean| synth.predicted_error_of(mean, 0.0, drift_cells)))
            }
        };
        let means = sampler.dopplers().into_iter().map(|(mean_hz, _)| mean_hz);
        let errors = [0.0].into_iter().chain(means).map(of);
        let worst = errors.max_by(|a, b| a.total_db().total_cmp(&b.total_db())).unwrap_or_default();
        // What is in proportion to a pulse weighs as the strongest one. The first two images of a point may
        // be in phase.
        let peak = sampler.peak([1.0, 2.0]).max(1.0);
        let rounding = peak * (worst.rounding + OF_SAMPLES);
        Ok((PredictedError { gridding: peak * worst.gridding, rounding, doppler: 0.0 }, fft_len))
    }

    /// What rigid envelopes leave where everything has the largest rate of a delay.
    fn rigid_error(&self, sampler: &ErrorSampler<'_>, fft_len: usize) -> f64 {
        let radar = &self.scene.radar;
        let of = |rate: f64| {
            let waveform = self.waveform.as_ref();
            rigid_error_power(waveform, radar.carrier_hz, radar.sample_rate_hz, fft_len, rate)
        };
        let fastest = sampler.fastest();
        sampler.peak([1.0, 1.0]).max(1.0) * of(fastest).max(of(-fastest))
    }

    /// Widest bands of Doppler that leave no more than `most`, Hz, and what they leave; `None` where none do.
    fn band(
        &self,
        sampler: &ErrorSampler<'_>,
        doppler: (Doppler, Envelope),
        fft_len: usize,
        most: f64,
    ) -> Option<(f64, f64)> {
        let radar = &self.scene.radar;
        let (waveform, rate_hz) = (self.waveform.as_ref(), radar.sample_rate_hz);
        let of = |(mean_hz, _)| MeanEcho::new(doppler, waveform, radar.carrier_hz, rate_hz, fft_len, mean_hz);
        let means: Vec<MeanEcho<'_>> = sampler.dopplers().into_iter().map(of).collect();
        let peak = sampler.peak([1.0, 1.0]).max(1.0);
        // The strongest scatterer path of a band may lie at one end of it, and another at the other.
        let left = |band_hz: f64| {
            let both = means.iter().map(|mean| mean.error_power(band_hz).max(mean.error_power(-band_hz)));
            peak * both.fold(0.0, f64::max)
        };
        let widest_hz = 2.0 * radar.carrier_hz * sampler.fastest();
        let (mut low, mut high) = (1e-7 * widest_hz, widest_hz);
        if !(low > 0.0 && left(low) <= most) {
            return None;
        }
        while high > 1.1 * low {
            let middle = (low * high).sqrt();
            *(if left(middle) <= most { &mut low } else { &mut high }) = middle;
        }
        Some((low, left(low)))
    }

    /// Doppler, the worst pair, in blocks of so many pulses each.
    fn doppler_error(
        &self,
        sampler: &mut ErrorSampler<'_>,
        doppler: (Doppler, Envelope),
        fft_len: usize,
        blocks: &[u64],
    ) -> Result<DopplerError, PlanError> {
        let radar = &self.scene.radar;
        let (waveform, rate_hz) = (self.waveform.as_ref(), radar.sample_rate_hz);
        let about =
            |mean_hz: f64| MeanEcho::new(doppler, waveform, radar.carrier_hz, rate_hz, fft_len, mean_hz);
        let dopplers = sampler.dopplers();
        let of_pair = |(mean_hz, groups): &(f64, Vec<f64>)| {
            let mean = about(*mean_hz);
            let sum: f64 = groups.iter().map(|off_hz| mean.error_power(*off_hz)).sum();
            sum / groups.len().max(1) as f64
        };
        let of_facets = sampler.peak([1.0, 0.0]) * dopplers.iter().map(of_pair).fold(0.0, f64::max);
        let law = |mean_hz: f64| {
            let mean = about(mean_hz);
            Law::new(2.0 * radar.carrier_hz * sampler.fastest(), |off_hz| mean.error_power(off_hz))
        };
        let mean_hz = dopplers.first().map_or(0.0, |(mean_hz, _)| *mean_hz);
        let of_facets = of_facets + sampler.doppler_of_exact(&law(mean_hz));
        if self.generator.point_count() == 0 {
            return Ok(DopplerError { of_facets, of_points: Vec::new() });
        }
        let law = law(0.0);
        Ok(DopplerError { of_facets, of_points: sampler.doppler_of_points(&law, blocks)? })
    }
}
