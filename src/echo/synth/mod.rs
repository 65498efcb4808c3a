//! The fast echo: scatterer paths of a block of pulses spread on oversampled delay grids, one transform per
//! channel and pulse.
//!
//! # Equation
//!
//! It makes what [`reference`](super::reference) defines,
//!
//! ```text
//! S[k] = H(f_k) sum_n a_n e^{-j 2 pi f0 tau_n} (1 + r_n) P((1 + r_n) f_k + f0 r_n) e^{-j 2 pi f_k d_n} ,  d_n = o_n + tau_n - t_w
//! ```
//!
//! as
//!
//! ```text
//! g[j]  = sum_n a_n e^{j 2 pi phi_n} phi(j - y_n)                       (1) spread: w cells for each path
//! G[k]  = sum_j g[j] e^{-j 2 pi j k / M}                                (2) one transform of M cells
//! S[k]  = H(f_k) (1 + r0) P((1 + r0) f_k + f0 r0) e^{-j 2 pi f_k t_0} G[k mod M] / phihat(k)  (3) |k| < N/2
//! ```
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `M`, `N` | cells of the grid, bins of the spectrum, `sigma = M/N`, 2 to 4 | - |
//! | `y_n` | place of scatterer path `n` on the grid, cell `M fs/N` per second | cells |
//! | `t_0` | time of cell 0 after the first sample | s |
//! | `phi`, `phihat` | spreading kernel and its transform ([`kernel`]) | - |
//! | `phi_n` | carrier phase `-f0 tau_n`, and what Doppler off the mean adds | turns |
//! | `r0` | mean rate of delays of the pair in the block ([`doppler`]) | - |
//!
//! Phase and place are polynomials over the block, held so that stepping loses nothing ([`block`]). Scatterer
//! paths farther from the window than the reference's guard go to cells that nobody reads; within a cell of
//! that limit either may happen, unless [`Synth::with_exact_reach`] keeps it.
//!
//! # Threads
//!
//! This module knows none. [`Grids::shares`] hands out pulses; each share sees all scatterer paths in one
//! order, so that the result is bit-identical however many shares there are. [`Variant`]s round
//! differently: they agree to 1e-6 or better.
//!
//! # Limits
//!
//! `S` in `f32` has a floor of rounding, about -120 dB ([`Synth::predicted_error`]).
//!
//! ```
//! use std::sync::Arc;
//! use nereus::echo::synth::{Settings, Synth, block::Node};
//! use nereus::radar::waveform::Lfm;
//! use nereus::paths::list::ScattererPaths;
//! use nereus::scene::radar::Sweep;
//! use num_complex::Complex64;
//!
//! let pulse = Arc::new(Lfm::new(60e6, 0.333e-6, Sweep::Up)?);
//! let synth = Synth::<f32>::new(pulse, 10e9, 100e6, 256, &[0], Settings::default())?;
//! let mut paths = ScattererPaths::new(1, 1, 1);
//! paths.emission_offset_s.push(0.0);
//! paths.delay_s[0].push(24.1e-6);
//! paths.delay_rate[0].push(0.0);
//! paths.amplitude[0].push(Complex64::new(1e-6, 0.0));
//! // A block of four pulses in which nothing moves: one node is enough.
//! let mut block = synth.block();
//! synth.fill(&[Node { pulse: 0, paths: &paths }], &[23.6e-6; 4], &mut block)?;
//! let mut grids = synth.grids();
//! synth.spread(&block, &mut grids);
//! let mut spectrum = vec![Complex64::ZERO; synth.fft_len()];
//! let mut scratch = synth.scratch();
//! synth.spectrum(&block, &grids, 3, &mut scratch, &mut spectrum);
//! assert!(spectrum[10].norm() > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod block;
pub mod bands;
pub mod doppler;
mod frame;
pub mod kernel;
mod grid;
pub mod lanes;
mod prediction;
mod profiles;
mod replica;
mod scalar;
mod spread;
mod variant;

use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::{Complex, Complex64};
use thiserror::Error;

use self::block::{BlockPaths, Frame};
use self::doppler::{Doppler, Envelope};
use self::kernel::{Kernel, MAX_TERMS};
use self::spread::{Emitted, Job};
use super::reference::{GUARD_SAMPLES, of_window};
use crate::paths::block::{lanes_of, layers_of};
use crate::radar::filter::{ReceiveFilter, bin_frequency_hz};
use crate::radar::phasor::phasor;
use crate::radar::waveform::Waveform;
use crate::units::fast_len;

pub use self::grid::{Grids, Share};
pub use self::prediction::PredictedError;
pub use self::scalar::Scalar;
pub use crate::cpu::Variant;

/// Word length of the fast echo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Precision {
    /// f32.
    Single,
    /// f64.
    Double,
}

/// The settings of the fast echo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Cells that each scatterer path is spread over, 2 to 8.
    pub width: usize,
    /// Least number of cells per sample, 1.5 to 8.
    pub oversampling: f64,
    /// Doppler within a pulse.
    pub doppler: Doppler,
    /// Stretch of the pulse by the motion.
    pub envelope: Envelope,
    /// Width of the bands of Doppler that a pulse by itself is split into, Hz ([`bands`]); `None`: one for
    /// all.
    pub band_hz: Option<f64>,
    /// Samples between the window and the image of a pulse, on either side; [`GUARD_SAMPLES`] at least.
    pub guard_samples: usize,
    /// Which instructions; `None` takes the fastest that this CPU has.
    pub variant: Option<Variant>,
}

impl Default for Settings {
    /// Width 5 on twice as many cells as samples, Doppler by its mean, envelopes stretched.
    fn default() -> Self {
        Self {
            width: 5,
            oversampling: 2.0,
            doppler: Doppler::Mean,
            envelope: Envelope::Stretched,
            band_hz: None,
            guard_samples: GUARD_SAMPLES,
            variant: None,
        }
    }
}

/// Why there is no fast echo, or no block.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum SynthError {
    /// Width of the kernel out of range.
    #[error("kernel width {width} is not allowed: 2 to 8 cells")]
    Width {
        /// What was asked.
        width: usize,
    },
    /// Oversampling out of range.
    #[error("oversampling {oversampling} is not allowed: 1.5 to 8")]
    Oversampling {
        /// What was asked.
        oversampling: f64,
    },
    /// The instructions are not there.
    #[error("variant {variant} is not available on this CPU")]
    Variant {
        /// What was asked.
        variant: Variant,
    },
    /// Doppler by a shift needs a linear sweep.
    #[error(
        "fidelity.doppler: a shift is not allowed with waveform {waveform}, only with a linear sweep; allowed: \"mean\", \"taylor\""
    )]
    Shift {
        /// The waveform there is.
        waveform: String,
    },
    /// Grid too long.
    #[error("a grid of {cells} cells is not allowed: at most {max}", max = MAX_CELLS)]
    Cells {
        /// What the radar needs.
        cells: usize,
    },
    /// Pulses of a block out of range.
    #[error("a block of {pulses} pulses is not allowed: 1 to {max}", max = block::MAX_PULSES)]
    Pulses {
        /// What was asked.
        pulses: usize,
    },
    /// Nodes of a block out of range.
    #[error("{nodes} nodes of a block are not allowed: 1 to {max}", max = block::MAX_NODES)]
    Nodes {
        /// What was asked.
        nodes: usize,
    },
    /// A node lies outside of the block, or twice at one pulse.
    #[error("node at pulse {pulse} is not allowed: once each, below {pulses}")]
    NodePulse {
        /// Where.
        pulse: usize,
        /// Pulses of the block.
        pulses: usize,
    },
    /// Scatterer paths of a node are not those of the first, or lack pairs or channels.
    #[error("paths of the node at pulse {pulse} differ from those of the first in number, pairs or channels")]
    ScattererPaths {
        /// Where.
        pulse: usize,
    },
    /// A window starts at no time.
    #[error("window start {start_s} s is not finite")]
    Window {
        /// What was asked.
        start_s: f64,
    },
}

/// Most cells of a grid.
pub const MAX_CELLS: usize = 1 << 26;

/// Channels of one pair that are spread together.
#[derive(Clone, Debug)]
struct Layer {
    pair: usize,
    /// Place among the layers of the pair's tiles.
    of_pair: usize,
    channels: Vec<usize>,
    /// Group of the pulses that fill it.
    group: u8,
    /// 2, 4 or 8.
    lanes: usize,
    /// Whether it holds a second term ([`Doppler::has_moments`]).
    moment: bool,
}

/// One bin that the receive filter passes.
#[derive(Clone, Copy, Debug)]
struct Bin {
    k: usize,
    /// The same frequency on the grid's transform.
    grid_k: usize,
    f_hz: f64,
    /// `H / phihat`.
    gain: f64,
    /// `e^{-j 2 pi f t_0}`.
    origin: Complex64,
}

/// The fast echo of one radar.
pub struct Synth<T: Scalar> {
    waveform: Arc<dyn Waveform>,
    carrier_hz: f64,
    sample_rate_hz: f64,
    fft_len: usize,
    pairs: usize,
    channels: usize,
    /// Window of each pair; empty where all have the first.
    windows: Vec<usize>,
    settings: Settings,
    variant: Variant,
    kernel: Kernel,
    /// `[tap][part][term]`.
    coefficients: Vec<[[T; MAX_TERMS]; 2]>,
    cells_per_s: f64,
    /// Reach before the window, s.
    lead_s: f64,
    /// Reach beyond the window, cells.
    reach: f64,
    /// Last first cell within reach.
    last_cell: i32,
    /// Where paths beyond the reach by less than a cell are left out: [`Job::exact`].
    exact: Option<T>,
    layers: Vec<Layer>,
    shape: grid::Shape,
    bodies: Vec<variant::Body<T>>,
    bins: Vec<Bin>,
    transform: Arc<dyn Fft<T>>,
}

/// What a thread needs to turn grids into spectra without allocating.
#[derive(Clone, Debug)]
pub struct SynthScratch<T> {
    cells: Vec<Complex<T>>,
    transform: Vec<Complex<T>>,
}

impl<T: Scalar> Synth<T> {
    /// For windows of `window_samples`; `channel_pairs[c]` is the pair of channel `c`.
    ///
    /// # Errors
    /// Settings out of range, a variant that this CPU lacks, Doppler by a shift without a linear sweep, a
    /// grid of more than [`MAX_CELLS`].
    pub fn new(
        waveform: Arc<dyn Waveform>,
        carrier_hz: f64,
        sample_rate_hz: f64,
        window_samples: usize,
        channel_pairs: &[usize],
        settings: Settings,
    ) -> Result<Self, SynthError> {
        if settings.doppler.needs_sweep() && waveform.sweep_rate_hz_per_s().is_none() {
            return Err(SynthError::Shift { waveform: waveform.name().to_owned() });
        }
        let variant = variant::choose(settings.variant)?;
        // Checks width and oversampling, before they size a grid.
        Kernel::new(settings.width, settings.oversampling)?;
        let pulse_samples = waveform.span_samples(sample_rate_hz);
        let reach = window_samples + pulse_samples + 2 * settings.guard_samples.max(GUARD_SAMPLES);
        let fft_len = fast_len(reach);
        let period = fast_len((fft_len as f64 * settings.oversampling).ceil() as usize);
        if period > MAX_CELLS {
            return Err(SynthError::Cells { cells: period });
        }
        let oversampling = period as f64 / fft_len as f64;
        let cells_per_s = oversampling * sample_rate_hz;
        let kernel = Kernel::new(settings.width, oversampling)?;
        let lead_s = waveform.duration_s() + GUARD_SAMPLES as f64 / sample_rate_hz;
        let reach_s = lead_s + (window_samples + GUARD_SAMPLES) as f64 / sample_rate_hz;
        let reach = reach_s * cells_per_s;
        let last_cell = (reach.ceil() as usize).min(period - 1) as i32;
        let pairs = channel_pairs.iter().map(|p| p + 1).max().unwrap_or(0);
        let groups = vec![0; channel_pairs.len()];
        let layers = layers(channel_pairs, &groups, pairs, settings.doppler.has_moments());
        let shape = grid::Shape {
            period,
            width: settings.width,
            lanes: layers.iter().map(|layer| layer.lanes).collect(),
        };
        let filter = ReceiveFilter::new(sample_rate_hz);
        // A scatterer path at y = 0 has its middle w/2 cells on.
        let origin_s = -lead_s - 0.5 * settings.width as f64 / cells_per_s;
        let bins = (0..fft_len)
            .map(|k| {
                let f_hz = bin_frequency_hz(k, fft_len, sample_rate_hz);
                let grid_k = if f_hz < 0.0 { period + k - fft_len } else { k };
                (k, grid_k, f_hz, filter.response(f_hz))
            })
            .filter(|(.., response)| *response != 0.0)
            .map(|(k, grid_k, f_hz, response)| Bin {
                k,
                grid_k,
                f_hz,
                gain: response / kernel.transform(f_hz / cells_per_s),
                origin: phasor(-f_hz * origin_s),
            })
            .collect();
        let coefficients =
            kernel.coefficients().map(|parts| parts.map(|part| part.map(T::round_from))).collect();
        let bodies = layers.iter().map(|layer| T::body(variant, settings.width, layer.lanes)).collect();
        Ok(Self {
            waveform,
            carrier_hz,
            sample_rate_hz,
            fft_len,
            pairs,
            channels: channel_pairs.len(),
            windows: Vec::new(),
            settings,
            variant,
            kernel,
            coefficients,
            cells_per_s,
            lead_s,
            reach,
            last_cell,
            exact: None,
            layers,
            shape,
            bodies,
            bins,
            transform: nereus_fft::forward(period),
        })
    }

    /// The same for channels of some groups: where a pulse fills one group alone, only that is spread.
    pub fn grouped(mut self, groups: &[u8]) -> Self {
        let mut channel_pairs = vec![0; self.channels];
        for layer in &self.layers {
            layer.channels.iter().for_each(|channel| channel_pairs[*channel] = layer.pair);
        }
        let moments = self.settings.doppler.has_moments();
        self.layers = layers(&channel_pairs, groups, self.pairs, moments);
        self.shape.lanes = self.layers.iter().map(|layer| layer.lanes).collect();
        let (variant, width) = (self.variant, self.settings.width);
        self.bodies = self.layers.iter().map(|layer| T::body(variant, width, layer.lanes)).collect();
        self
    }

    /// The same for pairs whose windows are these of several.
    pub fn in_windows(self, of_pairs: Vec<usize>) -> Self {
        Self { windows: of_pairs, ..self }
    }

    /// The same where paths farther from the window than the reference's guard are left out to a fraction of
    /// a cell, but for what Doppler off the mean shifts them. For echoes that may be far louder than what the
    /// window holds: an emitter's.
    pub fn with_exact_reach(self) -> Self {
        // Up to the period, whose cell is folded to the first.
        let last = self.reach.ceil();
        let exact = Some(T::round_from(last - self.reach - 0.5));
        Self { last_cell: last as i32, exact, ..self }
    }

    /// Whether it has an exact reach.
    pub fn has_exact_reach(&self) -> bool {
        self.exact.is_some()
    }

    /// Length N of the spectra, bins: that of the reference echo.
    pub fn fft_len(&self) -> usize {
        self.fft_len
    }

    /// Carrier, Hz.
    pub fn carrier_hz(&self) -> f64 {
        self.carrier_hz
    }

    /// What it was built with.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// What the grids of a pulse take, bytes.
    pub fn pulse_bytes(&self) -> u64 {
        (self.shape.pulse_len() * size_of::<T>()) as u64
    }

    /// Empty grids.
    pub fn grids(&self) -> Grids<T> {
        Grids::new(self.shape.clone())
    }

    /// Scratch memory for [`Synth::spectrum`].
    pub fn scratch(&self) -> SynthScratch<T> {
        let zero = Complex::new(T::default(), T::default());
        SynthScratch {
            cells: vec![zero; self.shape.period],
            transform: vec![zero; self.transform.get_inplace_scratch_len()],
        }
    }

    /// Spreads all scatterer paths of a block on `grids`, which are emptied before, in this thread.
    pub fn spread(&self, block: &BlockPaths<T>, grids: &mut Grids<T>) {
        self.clear(block, grids);
        for mut share in grids.shares(1) {
            self.spread_share(block, &mut share);
        }
    }

    /// Makes room in `grids` for a block, and empties them.
    pub fn clear(&self, block: &BlockPaths<T>, grids: &mut Grids<T>) {
        grids.reset(block.pulses());
    }

    /// Empties `grids` and makes room for the pulses of a block.
    pub fn clear_for(&self, frame: &Frame, grids: &mut Grids<T>) {
        grids.reset(frame.pulses());
    }

    /// Adds the scatterer paths of a block that was filled as a part ([`Synth::fill_part`]) to the grids of
    /// its pulses.
    pub fn spread_part(&self, block: &BlockPaths<T>, grids: &mut Grids<T>) {
        let stride = grids.shape.pulse_len();
        for index in 0..self.layers.len() {
            let Layer { pair, group, .. } = self.layers[index];
            let emitted = of_window(&block.emitted, &self.windows, pair).map_or(&[][..], Vec::as_slice);
            let emitted = of_group(emitted, &block.groups, group);
            if !emitted.is_empty() {
                self.spread_layer(block, index, emitted, (0, stride), grids.all());
            }
        }
    }

    /// Adds all scatterer paths of a block to the grids of some of its pulses.
    pub fn spread_share(&self, block: &BlockPaths<T>, share: &mut Share<'_, T>) {
        let pulses = share.cells.len() / share.pulse_len;
        for index in 0..self.layers.len() {
            let emitted = of_window(&block.emitted, &self.windows, self.layers[index].pair);
            let emitted = emitted.and_then(|emitted| emitted.get(share.first..share.first + pulses));
            let Some(emitted) = emitted else { return };
            self.spread_layer(block, index, emitted, (share.first, share.pulse_len), share.cells);
        }
    }

    fn spread_layer(
        &self,
        block: &BlockPaths<T>,
        index: usize,
        pulses: &[Emitted<T>],
        (first, stride): (usize, usize),
        cells: &mut [T],
    ) {
        let pair = self.layers[index].pair;
        let powers: [&[T]; 4] =
            std::array::from_fn(|power| block.amplitude[index].get(power).map_or(&[][..], |a| a.as_slice()));
        let job = Job {
            polynomials: &block.polynomials[pair],
            amplitude: &powers[..block.powers],
            pulses,
            first,
            factors: &block.factors[pair],
            turned: &[],
            turned_stride: 0,
            factor_stride: block.len(),
            coefficients: &self.coefficients,
            last_cell: self.last_cell,
            exact: self.exact,
            outside: self.shape.outside() as i32,
            stride,
            offset: self.shape.offset(index),
        };
        (self.bodies[index])(&job, cells);
    }

    /// `S[k]` of every channel of one pulse, `[channel][bin]`, overwritten; `sqrt(W) s`.
    pub fn spectrum(
        &self,
        block: &BlockPaths<T>,
        grids: &Grids<T>,
        pulse: usize,
        scratch: &mut SynthScratch<T>,
        out: &mut [Complex64],
    ) {
        self.spectrum_in(&block.frame, grids, pulse, scratch, out);
    }

    /// The same for grids that were filled part by part.
    pub fn spectrum_in(
        &self,
        frame: &Frame,
        grids: &Grids<T>,
        pulse: usize,
        scratch: &mut SynthScratch<T>,
        out: &mut [Complex64],
    ) {
        self.spectrum_by(&frame.replicas, (frame, pulse), grids, scratch, out);
    }

    /// The same where something else was radiated ([`Synth::replicas_of`]).
    pub fn spectrum_by(
        &self,
        replicas: &[Vec<Complex64>],
        (frame, pulse): (&Frame, usize),
        grids: &Grids<T>,
        scratch: &mut SynthScratch<T>,
        out: &mut [Complex64],
    ) {
        out.fill(Complex64::ZERO);
        for (index, layer) in self.layers.iter().enumerate() {
            if !frame.fills(pulse, layer.group) || grids.is_empty(pulse, index) {
                continue;
            }
            for (at, channel) in layer.channels.iter().enumerate() {
                grids.fold(pulse, index, at, &mut scratch.cells);
                self.transform.process_with_scratch(&mut scratch.cells, &mut scratch.transform);
                let bins = &mut out[channel * self.fft_len..][..self.fft_len];
                for (bin, replica) in self.bins.iter().zip(&replicas[index]) {
                    let value = scratch.cells[bin.grid_k];
                    bins[bin.k] += Complex64::new(value.re.into(), value.im.into()) * replica;
                }
            }
        }
    }
}

/// Emissions of a group, which stand together; all where there are no groups.
fn of_group<'a, T: Scalar>(emitted: &'a [Emitted<T>], groups: &[u8], group: u8) -> &'a [Emitted<T>] {
    if groups.is_empty() {
        return emitted;
    }
    let of = |own: &Emitted<T>| groups.get(own.row).copied().unwrap_or_default();
    let (from, to) =
        (emitted.partition_point(|own| of(own) < group), emitted.partition_point(|own| of(own) <= group));
    &emitted[from..to]
}

/// Channels by pair and group, four together.
fn layers(channel_pairs: &[usize], groups: &[u8], pairs: usize, moments: bool) -> Vec<Layer> {
    let mut layers = Vec::new();
    for pair in 0..pairs {
        let channels: Vec<usize> = (0..channel_pairs.len()).filter(|c| channel_pairs[*c] == pair).collect();
        let own: Vec<u8> = channels.iter().map(|channel| groups[*channel]).collect();
        for (of_pair, places) in layers_of(&own).into_iter().enumerate() {
            let (lanes, group) = (lanes_of(places.len()), own[places[0]]);
            let channels: Vec<usize> = places.iter().map(|place| channels[*place]).collect();
            for moment in [false, true] {
                if moments || !moment {
                    layers.push(Layer { pair, of_pair, channels: channels.clone(), group, lanes, moment });
                }
            }
        }
    }
    layers
}
