//! A pulse given by its samples, `p_j` at `t = j / rate`.
//!
//! Between the samples it is **defined** as band-limited to their rate:
//!
//! ```text
//! P(f) = (1/rate) sum_j p_j e^{-j 2 pi f j / rate}   |f| < rate/2 ,   0 elsewhere
//! p(t) = sum_j p_j sinc(rate t - j) ,   sinc x = sin(pi x)/(pi x)
//! ```
//!
//! So the samples should be those of a pulse with no energy left at `+-rate/2`; one that has (a hard edge, a
//! rate below the bandwidth) rings before and after itself as `1/t`.
//!
//! `P` is read from a table 16 times finer than the resolution `rate/L` of `L` samples, by Lagrange
//! interpolation over 12 points, after the delay of the middle of the pulse was taken out. A sample at the
//! pulse's end then turns by `h = pi/16` per cell, and the error is at most
//! `(h^12 / 12!) prod (m - 1/2)^2, m = 1..6` `= 1.8e-13` of `sum |p_j| / rate`, plus rounding of the
//! transform.

use std::f64::consts::PI;
use std::path::Path;

use num_complex::Complex64;

use super::table::{self, POINTS};
use super::{SampleFault, SampleFaults, Waveform, WaveformError};
use crate::inputs;
use crate::radar::phasor::phasor;

/// Samples a pulse may have (the table takes 256 bytes for each).
pub const MAX_SAMPLES: usize = 131_072;
/// Bytes a file may have: 96 for a sample and its comments.
const MAX_BYTES: u64 = 96 * MAX_SAMPLES as u64;
/// Characters of a faulty line that a message repeats.
const QUOTED: usize = 40;

/// A band-limited pulse given by its samples.
#[derive(Clone, Debug)]
pub struct Sampled {
    rate_hz: f64,
    bandwidth_hz: f64,
    samples: Vec<Complex64>,
    /// Delay of the middle of the samples, in samples.
    middle: f64,
    /// Cells of the table in one `rate`.
    cells: usize,
    /// `sum p_j e^{-j 2 pi (m/cells) (j - middle)} / rate` for `m = -cells/2 - POINTS/2 ..`, with
    /// `POINTS / 2` cells beyond either end.
    table: Vec<Complex64>,
}

impl Sampled {
    /// From samples in memory.
    ///
    /// # Errors
    /// No samples, too many, samples that are not finite, or a rate out of range.
    pub fn new(samples: Vec<Complex64>, rate_hz: f64) -> Result<Self, WaveformError> {
        check_rate(rate_hz)?;
        let mut faults = SampleFaults::default();
        if samples.len() > MAX_SAMPLES {
            faults.push(SampleFault::TooMany);
        }
        for (index, sample) in samples.iter().enumerate() {
            if !sample.is_finite() {
                faults.push(SampleFault::NotFinite { index });
            }
        }
        if samples.iter().all(|s| *s == Complex64::ZERO) {
            faults.push(SampleFault::Silent);
        }
        if !faults.is_empty() {
            return Err(WaveformError::Samples(faults));
        }
        let middle = 0.5 * (samples.len() as f64 - 1.0);
        let (cells, table) = table::of_sum(&samples, rate_hz);
        let bandwidth_hz = occupied_bandwidth_hz(&table[POINTS / 2..], cells, rate_hz);
        Ok(Self { rate_hz, bandwidth_hz, samples, middle, cells, table })
    }

    /// From a CSV file: a line `re,im` for each sample, blank lines and `#` comments between.
    ///
    /// # Errors
    /// A file that cannot be read, lines that are no samples, or what [`Self::new`] refuses.
    pub fn from_file(path: &Path, rate_hz: f64) -> Result<Self, WaveformError> {
        check_rate(rate_hz)?;
        let file = |source| WaveformError::File { path: path.to_owned(), source };
        let content = |faults| WaveformError::Content { path: path.to_owned(), faults };
        let bytes = inputs::read(path, MAX_BYTES).map_err(file)?;
        Self::new(parse(&bytes).map_err(content)?, rate_hz).map_err(|error| match error {
            WaveformError::Samples(faults) => content(faults),
            other => other,
        })
    }
}

fn check_rate(rate_hz: f64) -> Result<(), WaveformError> {
    if rate_hz > 0.0 && rate_hz.is_finite() { Ok(()) } else { Err(WaveformError::Rate { rate_hz }) }
}

/// Width of the band about 0 that holds 99 % of the energy of `table` (`-cells/2 ..= cells/2`).
fn occupied_bandwidth_hz(table: &[Complex64], cells: usize, rate_hz: f64) -> f64 {
    let half = cells / 2;
    let total: f64 = table.iter().take(cells).map(Complex64::norm_sqr).sum();
    let mut held = 0.0;
    for m in 0..half {
        held += table[half + m].norm_sqr();
        if m > 0 {
            held += table[half - m].norm_sqr();
        }
        if held >= 0.99 * total {
            return (2 * m) as f64 * rate_hz / cells as f64;
        }
    }
    rate_hz
}

/// The samples in the bytes of a file, or everything that is wrong with them.
fn parse(bytes: &[u8]) -> Result<Vec<Complex64>, SampleFaults> {
    let mut faults = SampleFaults::default();
    if bytes.len() as u64 > MAX_BYTES {
        faults.push(SampleFault::TooLong { allowed: MAX_BYTES });
        return Err(faults);
    }
    let text = String::from_utf8_lossy(bytes);
    let quote = |part: &str| part.chars().take(QUOTED).collect::<String>();
    let mut samples = Vec::new();
    for (index, whole) in text.lines().enumerate() {
        let line = index + 1;
        let data = whole.split('#').next().unwrap_or_default().trim();
        if data.is_empty() {
            continue;
        }
        let values: Vec<&str> = data.split(',').map(str::trim).collect();
        let &[re, im] = values.as_slice() else {
            faults.push(SampleFault::Columns { line, text: quote(data), found: values.len() });
            continue;
        };
        let mut number = |part: &str| {
            let value = part.parse::<f64>().ok().filter(|v| v.is_finite());
            if value.is_none() {
                faults.push(SampleFault::Number { line, text: quote(part) });
            }
            value
        };
        // Both are read before either is judged: a line may have two faults.
        if let (Some(re), Some(im)) = (number(re), number(im)) {
            if samples.len() == MAX_SAMPLES {
                faults.push(SampleFault::TooMany);
                break;
            }
            samples.push(Complex64::new(re, im));
        }
    }
    if faults.is_empty() { Ok(samples) } else { Err(faults) }
}

impl Waveform for Sampled {
    fn name(&self) -> &str {
        "samples"
    }

    fn duration_s(&self) -> f64 {
        self.samples.len() as f64 / self.rate_hz
    }

    /// Width of the band about 0 that holds 99 % of the energy, Hz.
    fn bandwidth_hz(&self) -> f64 {
        self.bandwidth_hz
    }

    fn spectrum(&self, f_hz: f64) -> Complex64 {
        let x = f_hz / self.rate_hz;
        if x.is_nan() || x.abs() >= 0.5 {
            return Complex64::ZERO;
        }
        // Cell of the table: at least POINTS/2, at most cells + POINTS/2.
        let place = (x + 0.5) * self.cells as f64 + (POINTS / 2) as f64;
        table::at(&self.table, place) * phasor(-x * self.middle)
    }

    fn sample(&self, t_s: f64) -> Complex64 {
        let x = t_s * self.rate_hz;
        let nearest = x.round();
        // sin(pi (x - j)) = (-1)^(j - nearest) sin(pi (x - nearest)), exact near the zeros.
        let sin = (PI * (x - nearest)).sin();
        let mut sum = Complex64::ZERO;
        for (j, sample) in self.samples.iter().enumerate() {
            let distance = x - j as f64;
            let sinc = if distance == 0.0 {
                1.0
            } else if (nearest - j as f64).rem_euclid(2.0) == 0.0 {
                sin / (PI * distance)
            } else {
                -sin / (PI * distance)
            };
            sum += sample * sinc;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn reads_samples_and_comments() {
        let text = b"# a pulse\r\n1, 0\r\n\n0.5,-0.5 # second\n -1e-3 , 2E0\n";
        let expected = [Complex64::new(1.0, 0.0), Complex64::new(0.5, -0.5), Complex64::new(-1e-3, 2.0)];
        assert_eq!(parse(text).unwrap(), expected);
    }

    #[test]
    fn names_every_fault_and_its_line() {
        let faults = parse(b"1,2\n1\n1,2,3\nx,inf\n# fine\n,2\n\xff,1").unwrap_err();
        insta::assert_snapshot!(faults.to_string(), @"line 2: '1' has 1 value(s), a sample is 're,im'; line 3: '1,2,3' has 3 value(s), a sample is 're,im'; line 4: 'x' is not a finite number; line 4: 'inf' is not a finite number; line 6: '' is not a finite number; line 7: '\u{fffd}' is not a finite number");
        let many = parse("1\n".repeat(50).as_bytes()).unwrap_err();
        assert_eq!((many.shown.len(), many.total), (SampleFaults::SHOWN, 50));
        assert!(many.to_string().ends_with("; and 30 more"));
    }

    #[test]
    fn sizes_are_bounded() {
        let lines = "1,0\n".repeat(MAX_SAMPLES);
        assert_eq!(parse(lines.as_bytes()).unwrap().len(), MAX_SAMPLES);
        let faults = parse((lines + "1,0\n").as_bytes()).unwrap_err();
        assert_eq!(faults.shown, [SampleFault::TooMany]);
        let faults = parse(&vec![b'#'; MAX_BYTES as usize + 1]).unwrap_err();
        assert_eq!(faults.shown, [SampleFault::TooLong { allowed: MAX_BYTES }]);
    }

    proptest! {
        #![proptest_config(crate::rng::cases::proptests(256))]

        #[test]
        fn never_panics_on_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = parse(&bytes);
        }

        #[test]
        fn never_panics_on_nearly_right_text(text in "([-+0-9.eEinfa ]{0,6},?){0,4}(#.{0,4})?(\r?\n[-0-9,. ]{0,9}){0,9}") {
            if let Ok(samples) = parse(text.as_bytes()) {
                prop_assert!(samples.iter().all(|s| s.is_finite()));
                if let Ok(pulse) = Sampled::new(samples, 1e6) {
                    for f_hz in [0.0, 499_999.999, -499_999.999, 5e5, -5e5, 1e9, f64::NAN] {
                        let p = pulse.spectrum(f_hz);
                        prop_assert!(p.is_finite() || pulse.samples.iter().any(|s| s.norm() > 1e150));
                    }
                }
            }
        }
    }
}
