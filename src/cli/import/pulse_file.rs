//! Waveforms in the files of FERS.

use std::fmt::Write as _;
use std::path::Path;

use num_complex::Complex64;

/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 1 << 30;

/// Samples and their rate, Hz, where the file knows it.
#[derive(Debug, PartialEq)]
pub(super) struct Pulse {
    pub samples: Vec<Complex64>,
    pub rate_hz: Option<f64>,
}

/// Reads a waveform: HDF5 with `I/value` and `Q/value`, or text of the number of samples, their rate and as
/// many complex numbers `(re,im)`.
///
/// # Errors
/// What is wrong with the file, in words.
pub(super) fn read(path: &Path) -> Result<Pulse, String> {
    let bytes = std::fs::metadata(path).map_err(|error| error.to_string())?.len();
    if bytes > MOST_BYTES {
        return Err(format!("{bytes} bytes; allowed: at most {MOST_BYTES}"));
    }
    let is_hdf5 = path.extension().is_some_and(|own| own.eq_ignore_ascii_case("h5"));
    let pulse = if is_hdf5 {
        of_hdf5(path)?
    } else {
        of_text(&std::fs::read_to_string(path).map_err(|e| e.to_string())?)?
    };
    if pulse.samples.is_empty() || pulse.samples.iter().any(|sample| !sample.is_finite()) {
        return Err("allowed: one sample at least, all of them finite".to_owned());
    }
    Ok(pulse)
}

fn of_text(text: &str) -> Result<Pulse, String> {
    let mut words = text.split_whitespace();
    let mut number = |what: &str| -> Result<f64, String> {
        let word = words.next().unwrap_or_default().trim_end_matches(',');
        word.parse().map_err(|_| format!("{what}: '{word}'; allowed: a number"))
    };
    let (count, rate_hz) = (number("number of samples")?, number("sample rate")?);
    let samples = words.map(|word| complex(word).ok_or_else(|| format!("'{word}'; allowed: (re,im), or re")));
    let samples = samples.collect::<Result<Vec<_>, _>>()?;
    if samples.len() as f64 != count || !(rate_hz > 0.0 && rate_hz.is_finite()) {
        let found = samples.len();
        return Err(format!("{count} samples at {rate_hz} Hz announced, {found} found"));
    }
    Ok(Pulse { samples, rate_hz: Some(rate_hz) })
}

/// `(re,im)`, `(re)` or `re`.
fn complex(word: &str) -> Option<Complex64> {
    let inner = word.strip_prefix('(').and_then(|word| word.strip_suffix(')')).unwrap_or(word);
    let (re, im) = inner.split_once(',').unwrap_or((inner, "0"));
    Some(Complex64::new(re.parse().ok()?, im.parse().ok()?))
}

#[cfg(feature = "hdf5")]
fn of_hdf5(path: &Path) -> Result<Pulse, String> {
    let read = || -> hdf5::Result<[Vec<f64>; 2]> {
        let file = hdf5::File::open(path)?;
        let of = |part: &str| file.dataset(&format!("{part}/value"))?.read_raw::<f64>();
        Ok([of("I")?, of("Q")?])
    };
    let [re, im] = read().map_err(|error| format!("{error}; allowed: datasets I/value and Q/value"))?;
    if re.len() != im.len() {
        return Err(format!("I/value has {} samples, Q/value {}", re.len(), im.len()));
    }
    let samples = re.into_iter().zip(im).map(|(re, im)| Complex64::new(re, im)).collect();
    Ok(Pulse { samples, rate_hz: None })
}

#[cfg(not(feature = "hdf5"))]
fn of_hdf5(_: &Path) -> Result<Pulse, String> {
    Err("this build has no HDF5 (feature `hdf5`); allowed: text".to_owned())
}

/// As a waveform of a scenario: lines `re,im`.
pub(super) fn csv(samples: &[Complex64]) -> String {
    let mut text = String::new();
    for sample in samples {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{:e},{:e}", sample.re, sample.im);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_and_refused() {
        let pulse = of_text("2 1e6\n(1,0)\n(0.5,-0.5)\n").unwrap();
        assert_eq!(pulse.rate_hz, Some(1e6));
        assert_eq!(pulse.samples, [Complex64::new(1.0, 0.0), Complex64::new(0.5, -0.5)]);
        assert_eq!(csv(&pulse.samples), "1e0,0e0\n5e-1,-5e-1\n");
        for (wrong, named) in [("3 1e6 (1,0)", "1 found"), ("x", "number of samples"), ("1 1 (1;0)", "(1;0)")]
        {
            assert!(of_text(wrong).unwrap_err().contains(named), "{wrong}");
        }
    }
}
