//! Video of a pulse: powers of range cells, as fast as pulses come.
//!
//! The window is compressed with the replica as by [`super::range_compress`] (matched filter, Taylor taper,
//! without Doppler), twice as finely as it is sampled, in `f32`. Cell `k` of length `T` (s, there and back)
//! holds the delays from `(k - 1/2) T` to `(k + 1/2) T`, both included: the greatest power of the compressed
//! window within, or the mean. A cell between two of its values has the nearer one. The scale is that of the
//! echo before compression, W.
//!
//! Cells are those of one grid, wherever a window opens. All windows give as many, those that are wholly
//! within: `floor(L / T)` of a window of length `L`, but one at least, and fewer where a window opens before
//! the emission.
//!
//! ```
//! use nereus::processor::range_compress::PulseShape;
//! use nereus::processor::video::Detector;
//! use nereus::scene::radar::Band;
//! use num_complex::Complex32;
//! // A plain pulse of 4 samples, echoed after 10 us.
//! let replica = vec![Complex32::ONE; 4];
//! let shape = PulseShape { replica: &replica, turns: 1, sample_rate_hz: 1e6, band: Band::about(0.0, 1e6), pulse_s: 4e-6 };
//! let mut detector = Detector::new(shape, 32, 1e-6, false)?;
//! let window = (0..32).map(|i| if (6..10).contains(&i) { Complex32::ONE } else { Complex32::ZERO });
//! let mut powers_w = Vec::new();
//! let first = detector.detect(window, (0, 4e-6), &mut powers_w);
//! let peak = (0..powers_w.len()).max_by(|a, b| powers_w[*a].total_cmp(&powers_w[*b])).unwrap();
//! assert_eq!((first, first as usize + peak), (4, 10));
//! assert!((powers_w[peak] - 1.0).abs() < 0.01);
//! # Ok::<(), nereus::processor::range_compress::CompressError>(())
//! ```

use std::sync::Arc;

use nereus_fft::Fft;
use num_complex::{Complex32, Complex64};

use super::range_compress::{CompressError, Compressor, PulseShape, RangeFilter};
use super::taper::Taper;
use crate::units::in_turn;

/// Values of a compressed window in a sample.
const OVERSAMPLING: usize = 2;

/// Rounding of the place of an edge, in values.
const EDGE: f64 = 1e-6;

/// Makes powers of windows of one length; allocates nothing after its first.
pub struct Detector {
    /// Of the pulses in turn.
    filters: Vec<Vec<Complex32>>,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    bins: Vec<Complex32>,
    fine: Vec<Complex32>,
    scratch: Vec<Complex32>,
    samples: usize,
    /// Values of a compressed window, and of a second.
    values: usize,
    rate_hz: f64,
    cell_s: f64,
    mean: bool,
    cells: usize,
}

impl Detector {
    /// For windows of so many samples, in cells of a length, s; `mean` takes that of a cell, not its peak.
    ///
    /// # Errors
    /// A replica, a rate, a band or a window that is none.
    pub fn new(pulse: PulseShape, samples: usize, cell_s: f64, mean: bool) -> Result<Self, CompressError> {
        let compressor = Compressor::new(pulse, samples, RangeFilter::Matched, Taper::Taylor, OVERSAMPLING)?;
        let narrow = |z: &Complex64| Complex32::new(z.re as f32, z.im as f32);
        let filters = compressor.filters().iter().map(|filter| filter.iter().map(narrow).collect()).collect();
        let (len, fine) = (compressor.len(), compressor.len() * OVERSAMPLING);
        let (forward, inverse) = (nereus_fft::forward::<f32>(len), nereus_fft::inverse::<f32>(fine));
        let scratch = forward.get_inplace_scratch_len().max(inverse.get_inplace_scratch_len());
        let length_s = (samples - 1) as f64 / pulse.sample_rate_hz;
        Ok(Self {
            filters,
            forward,
            inverse,
            bins: vec![Complex32::ZERO; len],
            fine: vec![Complex32::ZERO; fine],
            scratch: vec![Complex32::ZERO; scratch],
            samples,
            values: compressor.cells(),
            rate_hz: compressor.cell_rate_hz(),
            cell_s,
            mean,
            // Rounding of the length of a window of whole cells.
            cells: ((length_s / cell_s + 1e-9) as usize).max(1),
        })
    }

    /// Cells of a window, at most.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Puts the powers of the cells of the window of a pulse, by its number, that opens so long after the
    /// emission, s, in place of those in `powers_w`; the number of the first.
    pub fn detect(
        &mut self,
        window: impl Iterator<Item = Complex32>,
        (number, start_s): (u64, f64),
        powers_w: &mut Vec<f32>,
    ) -> u32 {
        self.compress(window, number);
        let first = (start_s / self.cell_s - 1e-9).ceil();
        let skipped = (-first).max(0.0) as usize;
        let (first, cells) = (first.max(0.0), self.cells.saturating_sub(skipped));
        // Of the first value, in cells.
        let start = start_s / self.cell_s;
        let per_cell = self.rate_hz * self.cell_s;
        let last = self.values - 1;
        let at = |cell: f64| (cell - start) * per_cell;
        powers_w.clear();
        for cell in 0..cells {
            let cell = first + cell as f64;
            // A value on an edge belongs to both cells, so that neither side is preferred.
            let from = (at(cell - 0.5) - EDGE).ceil().max(0.0) as usize;
            let to = ((at(cell + 0.5) + EDGE).floor().max(-1.0) as isize + 1) as usize;
            let to = to.min(self.values);
            let near = (at(cell).round().max(0.0) as usize).min(last);
            let within = if from < to { &self.fine[from..to] } else { &self.fine[near..=near] };
            let powers = within.iter().map(|z| z.norm_sqr());
            powers_w.push(match self.mean {
                true => powers.sum::<f32>() / within.len() as f32,
                false => powers.fold(0.0, f32::max),
            });
        }
        first as u32
    }

    /// Leaves the compressed window in `fine`.
    fn compress(&mut self, window: impl Iterator<Item = Complex32>, number: u64) {
        self.bins.fill(Complex32::ZERO);
        self.bins.iter_mut().zip(window.take(self.samples)).for_each(|(bin, sample)| *bin = sample);
        self.forward.process_with_scratch(&mut self.bins, &mut self.scratch);
        let filter = in_turn(&self.filters, number).map_or(&[][..], Vec::as_slice);
        self.bins.iter_mut().zip(filter).for_each(|(bin, weight)| *bin *= weight);
        let half = self.bins.len() / 2;
        let upper = self.fine.len() - half;
        self.fine.fill(Complex32::ZERO);
        self.fine[..half].copy_from_slice(&self.bins[..half]);
        self.fine[upper..].copy_from_slice(&self.bins[half..]);
        self.inverse.process_with_scratch(&mut self.fine, &mut self.scratch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::radar::Band;

    const RATE_HZ: f64 = 25e6;

    fn sweep() -> Vec<Complex32> {
        let turns = |i: usize| {
            let u = i as f64 / RATE_HZ - 0.5e-6;
            0.5 * 20e6 / 1e-6 * u * u
        };
        (0..25).map(|i| Complex32::cis((std::f64::consts::TAU * turns(i)) as f32)).collect()
    }

    fn shape(replica: &[Complex32]) -> PulseShape<'_> {
        PulseShape { replica, turns: 1, sample_rate_hz: RATE_HZ, band: Band::about(0.0, 20e6), pulse_s: 1e-6 }
    }

    /// An echo of 0.01 at sample 100, one of 1 at sample 300.
    fn window() -> Vec<Complex32> {
        let mut window = vec![Complex32::ZERO; 400];
        for (i, q) in sweep().iter().enumerate() {
            window[100 + i] += q * 0.01;
            window[300 + i] += q;
        }
        window
    }

    /// The same values as the compressor of images has: f32 over 20 stages against f64, 1e-6 of the peak.
    #[test]
    fn values_are_those_of_the_compressor() {
        let (replica, window) = (sweep(), window());
        let pulse = shape(&replica);
        let compressor =
            Compressor::new(pulse, 400, RangeFilter::Matched, Taper::Taylor, OVERSAMPLING).unwrap();
        let wanted = compressor.compress(&window, 0, 0.0);
        let mut detector = Detector::new(pulse, 400, 1.0 / RATE_HZ, false).unwrap();
        detector.compress(window.iter().copied(), 0);
        let worst = wanted.iter().zip(&detector.fine).map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
        println!("worst {worst:.1e}");
        assert!(worst < 1e-6);
    }

    #[test]
    fn echoes_stand_in_their_cells_wherever_the_window_opens() {
        let (replica, window) = (sweep(), window());
        for samples_a_cell in [0.5, 1.0, 2.0, 3.7, 50.0] {
            let cell_s = samples_a_cell / RATE_HZ;
            let mut peaks = Detector::new(shape(&replica), 400, cell_s, false).unwrap();
            let mut means = Detector::new(shape(&replica), 400, cell_s, true).unwrap();
            for start in [0.0, 37.0, 37.3, 1e4] {
                let start_s = start / RATE_HZ;
                let (mut powers, mut mean) = (Vec::new(), Vec::new());
                let first = peaks.detect(window.iter().copied(), (0, start_s), &mut powers);
                assert_eq!(means.detect(window.iter().copied(), (0, start_s), &mut mean), first);
                assert_eq!((powers.len(), mean.len()), (peaks.cells(), peaks.cells()));
                assert!((f64::from(first) - start / samples_a_cell).rem_euclid(1.0) < 1.0);
                let cell =
                    |sample: f64| ((start + sample) / samples_a_cell).round() as usize - first as usize;
                assert!((powers[cell(300.0)] - 1.0).abs() < 0.03, "{samples_a_cell} {start}");
                // Its level is 1e-4; side lobes of the strong one are 35 dB below that and fall.
                assert!((powers[cell(100.0)] / 1e-4 - 1.0).abs() < 0.1, "{}", powers[cell(100.0)]);
                assert!(mean.iter().zip(&powers).all(|(mean, peak)| *mean <= *peak * 1.000_01));
            }
        }
    }

    #[test]
    fn a_window_that_opens_before_the_emission_has_fewer_cells() {
        let replica = sweep();
        let mut detector = Detector::new(shape(&replica), 400, 1.0 / RATE_HZ, false).unwrap();
        let mut powers = Vec::new();
        assert_eq!(detector.detect(window().into_iter(), (0, -10.0 / RATE_HZ), &mut powers), 0);
        assert_eq!(powers.len(), 399 - 10);
        let peak = (0..389).max_by(|a, b| powers[*a].total_cmp(&powers[*b])).unwrap();
        assert_eq!(peak, 290);
    }
}
