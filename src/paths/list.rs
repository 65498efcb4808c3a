//! The scatterer path list: the interface between everything that scatters and the echo.
//!
//! A scatterer path is one path transmitter - scatterer - receiver of one emission. Per transmitter-receiver
//! **pair** it has a delay `tau` (s) and its rate `r = d tau / dt`; per **channel** a complex amplitude
//! `a` (sqrt(W)) without the carrier phase. With the carrier `f0` and the baseband pulse `p`, its echo is
//!
//! `a exp(-j 2 pi f0 tau) p(t'/(1 + r)) exp(-j 2 pi f0 r t'/(1 + r))`, `t' = t - t_emission - tau`.
//!
//! Structure of arrays; `echo` knows nothing else of the scene.

use num_complex::Complex64;

/// Scatterer paths of one receive window, for every pair and channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScattererPaths {
    /// `[path]`: emission of the scatterer path minus emission of the window's own pulse, s (zero unless
    /// several pulses are in the air).
    pub emission_offset_s: Vec<f64>,
    /// `[pair][path]`: delay tau, s.
    pub delay_s: Vec<Vec<f64>>,
    /// `[pair][path]`: d tau / dt, dimensionless (negative when closing).
    pub delay_rate: Vec<Vec<f64>>,
    /// `[channel][path]`: amplitude without carrier phase, sqrt(W).
    pub amplitude: Vec<Vec<Complex64>>,
}

impl ScattererPaths {
    /// An empty list with room for `capacity` scatterer paths.
    pub fn new(pairs: usize, channels: usize, capacity: usize) -> Self {
        Self {
            emission_offset_s: Vec::with_capacity(capacity),
            delay_s: (0..pairs).map(|_| Vec::with_capacity(capacity)).collect(),
            delay_rate: (0..pairs).map(|_| Vec::with_capacity(capacity)).collect(),
            amplitude: (0..channels).map(|_| Vec::with_capacity(capacity)).collect(),
        }
    }

    /// Appends a scatterer path: delay (s) and rate for each pair, amplitudes for each channel.
    pub fn push(
        &mut self,
        emission_offset_s: f64,
        courses: impl IntoIterator<Item = (f64, f64)>,
        amplitude: &[Complex64],
    ) {
        self.emission_offset_s.push(emission_offset_s);
        for ((delays_s, rates), (delay_s, rate)) in
            self.delay_s.iter_mut().zip(&mut self.delay_rate).zip(courses)
        {
            delays_s.push(delay_s);
            rates.push(rate);
        }
        self.amplitude.iter_mut().zip(amplitude).for_each(|(column, &a)| column.push(a));
    }

    /// Ends a scatterer path whose delays and rates stand in their columns already: with its amplitudes, or,
    /// where none of them is anything, by taking those away again.
    pub(crate) fn finish(&mut self, emission_offset_s: f64, amplitude: &[Complex64]) {
        if amplitude.iter().all(|a| *a == Complex64::ZERO) {
            let before = self.len();
            self.delay_s.iter_mut().chain(&mut self.delay_rate).for_each(|column| column.truncate(before));
            return;
        }
        self.emission_offset_s.push(emission_offset_s);
        self.amplitude.iter_mut().zip(amplitude).for_each(|(column, &a)| column.push(a));
    }

    /// Turns the amplitudes of all from one on.
    pub(crate) fn turn(&mut self, first: usize, by: Complex64) {
        self.amplitude.iter_mut().for_each(|column| column[first..].iter_mut().for_each(|a| *a *= by));
    }

    /// Makes the list `len` scatterer paths long; new ones are of zero amplitude, without offset.
    pub fn resize(&mut self, len: usize) {
        self.emission_offset_s.resize(len, 0.0);
        self.delay_s.iter_mut().chain(&mut self.delay_rate).for_each(|column| column.resize(len, 0.0));
        self.amplitude.iter_mut().for_each(|column| column.resize(len, Complex64::ZERO));
    }

    /// Leaves out all but some scatterer paths, whose numbers ascend.
    pub fn keep(&mut self, kept: &[usize]) {
        fn of<T: Copy>(column: &mut Vec<T>, kept: &[usize]) {
            for (to, from) in kept.iter().enumerate() {
                column[to] = column[*from];
            }
            column.truncate(kept.len());
        }
        of(&mut self.emission_offset_s, kept);
        self.delay_s.iter_mut().chain(&mut self.delay_rate).for_each(|column| of(column, kept));
        self.amplitude.iter_mut().for_each(|column| of(column, kept));
    }

    /// Scatterer paths in the list.
    pub fn len(&self) -> usize {
        self.emission_offset_s.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.emission_offset_s.is_empty()
    }

    /// Empties the list and keeps its memory.
    pub fn clear(&mut self) {
        self.emission_offset_s.clear();
        self.delay_s.iter_mut().for_each(Vec::clear);
        self.delay_rate.iter_mut().for_each(Vec::clear);
        self.amplitude.iter_mut().for_each(Vec::clear);
    }
}
