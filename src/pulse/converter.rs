//! What the converter of a receiver is fed with: levels of a channel in steps of its codes.
//!
//! Each worker has its own levels, and [`Level::add`] sums them, as with [`super::costs`].

/// Levels of one channel, over many pulses. One step is one code of I or of Q (LSB).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Level {
    /// Complex samples.
    pub samples: u64,
    /// Those whose I or Q lay beyond full scale.
    pub saturated: u64,
    /// Sum of I^2 + Q^2 before the converter, steps^2.
    pub squares: f64,
    /// The largest |I| or |Q| before the converter, steps.
    pub peak: f64,
}

impl Level {
    /// Counts a sample, I and Q in steps.
    #[inline]
    pub fn take(&mut self, [re, im]: [f64; 2], saturated: bool) {
        self.samples += 1;
        self.saturated += u64::from(saturated);
        self.squares += re * re + im * im;
        self.peak = self.peak.max(re.abs()).max(im.abs());
    }

    /// Takes in what another worker has counted.
    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.saturated += other.saturated;
        self.squares += other.squares;
        self.peak = self.peak.max(other.peak);
    }

    /// Root mean square of I and of Q, steps; 0 without samples.
    pub fn rms(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { (0.5 * self.squares / self.samples as f64).sqrt() }
    }
}
