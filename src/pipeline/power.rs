//! Power of the samples of a pulse.

use num_complex::Complex32;

/// Rounding of f64, a ratio of powers: what a channel has below this of the strongest is no echo.
const ROUNDING: f64 = 1e-28;

/// The least mean power that is an echo, of channels with such means.
pub(crate) fn least_mean(means: &[f64]) -> f64 {
    ROUNDING * means.iter().copied().fold(0.0, f64::max)
}

pub(crate) fn power(samples: &[Complex32]) -> f64 {
    samples.iter().map(|s| f64::from(s.re).powi(2) + f64::from(s.im).powi(2)).sum()
}

/// Power of each channel of a pulse.
pub(crate) fn powers(samples: &[Complex32], channels: usize) -> Vec<f64> {
    (0..channels).map(|channel| power(&samples[of_channel(channel, channels, samples.len())])).collect()
}

pub(crate) fn of_channel(channel: usize, channels: usize, samples: usize) -> std::ops::Range<usize> {
    let len = samples / channels;
    channel * len..(channel + 1) * len
}

/// Mean power of a channel over pulses, `[pulse][channel]`.
pub(crate) fn mean_of(powers: &[Vec<f64>], channel: usize) -> f64 {
    powers.iter().map(|pulse| pulse[channel]).sum::<f64>() / powers.len().max(1) as f64
}
