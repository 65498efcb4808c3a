use std::fs;
use std::io::Write;

use super::*;
use crate::radar::waveform::Stream;
use crate::radar::waveform::shaping::kernel;
use crate::rng::{Room, stream};
use rand::Rng;
use std::sync::Arc;

/// Values between -1 and 1, by their number.
fn drawn(count: usize) -> Vec<[f64; 2]> {
    let mut numbers = stream(3, Room::Bootstrap, 0, 9);
    let mut value = || f64::from(numbers.next_u32()) / 2f64.powi(31) - 1.0;
    (0..count).map(|_| [value(), value()]).collect()
}

/// Bytes of values, of which full scale is 0.9.
fn bytes(values: &[[f64; 2]], name: &str) -> Vec<u8> {
    let (kind, order) = name.split_once('_').unwrap_or((name, "le"));
    let of = |value: f64| -> Vec<u8> {
        let mut own = match kind {
            "cf64" => value.to_le_bytes().to_vec(),
            "cf32" => (value as f32).to_le_bytes().to_vec(),
            "ci32" => ((value * 2e9) as i32).to_le_bytes().to_vec(),
            "ci16" => ((value * 3e4) as i16).to_le_bytes().to_vec(),
            "ci8" => ((value * 120.0) as i8).to_le_bytes().to_vec(),
            "cu32" => ((value * 2e9 + 2f64.powi(31)) as u32).to_le_bytes().to_vec(),
            "cu16" => ((value * 3e4 + 32768.0) as u16).to_le_bytes().to_vec(),
            _ => vec![(value * 120.0 + 128.0) as u8],
        };
        if order == "be" {
            own.reverse();
        }
        own
    };
    values.iter().flatten().flat_map(|value| of(*value)).collect()
}

fn raw(path: &Path, name: &str, after: AfterEnd) -> IqFile {
    let datatype = Datatype::named(name).unwrap();
    IqFile { path: path.to_owned(), raw: Some(RawIq { rate_hz: 1e6, datatype }), after }
}

fn filled(of: &Recording, first: u64, count: usize) -> Vec<Complex64> {
    let mut out = vec![Complex64::new(9.0, 9.0); count];
    of.fill(first, &mut out).unwrap();
    out
}

#[test]
fn samples_are_those_of_the_file_in_every_type() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    let values = drawn(20_000);
    for (name, _) in Datatype::NAMED {
        fs::write(&path, bytes(&values, name)).unwrap();
        let own = Recording::open(&raw(&path, name, AfterEnd::Repeat)).unwrap();
        let all = filled(&own, 0, 20_000);
        let of_values: f64 = values.iter().flatten().map(|value| value * value).sum();
        let scale = (of_values / all.iter().map(Complex64::norm_sqr).sum::<f64>()).sqrt();
        // What is cut off of eight bits, and of more.
        let step = if name.contains('8') { 0.02 } else { 1e-4 };
        for (sample, [re, im]) in all.iter().zip(&values) {
            let off = (sample * scale - Complex64::new(*re, *im)).norm();
            assert!(off < step, "{name}: {off}");
        }
        let power = all.iter().map(Complex64::norm_sqr).sum::<f64>() / 20_000.0;
        // White: the interpolation takes a little.
        assert!(
            (power * crate::radar::waveform::shaping::white_power() - 1.0).abs() < 0.01,
            "{name}: {power}"
        );
        for (first, count) in [(12_345, 3000), (0, 1), (19_999, 1)] {
            assert_eq!(filled(&own, first, count), all[first as usize..][..count], "{name}");
        }
    }
}

/// What is radiated between samples has mean power 1, of a narrow file as of a white one.
#[test]
fn the_mean_power_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cf32");
    let tone = |turns: f64| {
        move |j: usize| {
            let value = crate::radar::phasor::phasor((turns * j as f64).fract());
            [3.0 * value.re, 3.0 * value.im]
        }
    };
    for turns in [0.0, 0.11, -0.41, 0.47] {
        let values: Vec<[f64; 2]> = (0..8192).map(tone(turns)).collect();
        fs::write(&path, bytes(&values, "cf32_le")).unwrap();
        let own = Recording::open(&raw(&path, "cf32_le", AfterEnd::Repeat)).unwrap();
        let all = filled(&own, 0, 4096);
        let between = |at: f64| {
            let from = at as usize - 20;
            (from..from + 42).map(|j| all[j] * kernel(at - j as f64)).sum::<Complex64>().norm_sqr()
        };
        let power = (0..2900).map(|i| between(40.0 + 1.37 * f64::from(i))).sum::<f64>() / 2900.0;
        assert!((power - 1.0).abs() < 0.02, "{turns}: {power}");
        // About 0, to the tone.
        let expected = 2.0 * turns.abs() * 1e6;
        assert!((own.bandwidth_hz() - expected).abs() < 0.02e6, "{turns}: {}", own.bandwidth_hz());
    }
}

#[test]
fn the_end_is_followed_by_the_beginning_or_by_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cf32");
    fs::write(&path, bytes(&drawn(1000), "cf32_le")).unwrap();
    let own = Recording::open(&raw(&path, "cf32_le", AfterEnd::Repeat)).unwrap();
    let all = filled(&own, 0, 1000);
    let far = filled(&own, 7_000_000_000_990, 2500);
    let expected: Vec<Complex64> = (0..2500).map(|j| all[(990 + j) % 1000]).collect();
    assert_eq!(far, expected);
    assert_eq!(own.steadiness(500, 1 << 40), own.steadiness(500, 1000));
    let own = Recording::open(&raw(&path, "cf32_le", AfterEnd::Silence)).unwrap();
    let end = filled(&own, 990, 30);
    assert_eq!(end[..10], all[990..]);
    assert!(end[10..].iter().chain(&filled(&own, 1 << 50, 7)).all(|sample| *sample == Complex64::ZERO));
    let share = own.steadiness(500, 10_000) / own.steadiness(500, 1000);
    assert!((share - 0.1).abs() < 1e-12, "{share}");
}

/// Bursts are planned for: by a segment that is one, and by how far it is above the mean.
#[test]
fn bursts_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cf32");
    let mut values = vec![[0.0; 2]; 400_000];
    values[300_032..304_128].copy_from_slice(&drawn(4096));
    fs::write(&path, bytes(&values, "cf32_le")).unwrap();
    let own = Recording::open(&raw(&path, "cf32_le", AfterEnd::Repeat)).unwrap();
    assert!((300_032..304_128).contains(&own.typical()), "{}", own.typical());
    let peak = 1.0 / own.steadiness(2048, 1 << 30);
    assert!((peak / (400_000.0 / 4096.0) - 1.0).abs() < 0.05, "{peak}");
    let stream = Stream::new(Arc::new(own), 1e-3).unwrap();
    assert!(crate::radar::waveform::Waveform::spectrum(&stream, 1e5).norm() > 0.0);
}

#[test]
fn a_long_file_is_looked_at_in_stretches() {
    assert_eq!(stretches(70_000), [(0, 65_536), (65_536, 4464)]);
    let long = stretches(1 << 40);
    assert_eq!((long.len(), long[0].0), (64, 0));
    let (last, count) = long[63];
    assert_eq!(last + count, 1 << 40);
    assert!(stretches(MOST + 1).iter().all(|(first, count)| first + count <= MOST + 1));
}

#[test]
fn sigmf_says_what_samples_are() {
    let folder = tempfile::tempdir().unwrap();
    let meta = folder.path().join("a.sigmf-meta");
    let data = folder.path().join("a.sigmf-data");
    let values = drawn(3000);
    let own = bytes(&values, "ci16_le");
    fs::write(&data, [&[1; 12][..], &own, &[2; 3]].concat()).unwrap();
    let text = r#"{"global":{"core:datatype":"ci16_le","core:sample_rate":2e6,"core:trailing_bytes":3},
        "captures":[{"core:header_bytes":12}]}"#;
    fs::write(&meta, text).unwrap();
    let plain = folder.path().join("a.ci16");
    fs::write(&plain, &own).unwrap();
    let expected = filled(&Recording::open(&raw(&plain, "ci16_le", AfterEnd::Repeat)).unwrap(), 0, 3000);
    for path in [&meta, &data] {
        let of = IqFile { path: path.clone(), raw: None, after: AfterEnd::Repeat };
        let own = Recording::open(&of).unwrap();
        assert_eq!((own.rate_hz(), filled(&own, 0, 3000)), (2e6, expected.clone()));
    }
}

#[test]
fn faults_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cf32");
    let fault = |of: &IqFile| {
        let text = Recording::open(of).unwrap_err().to_string();
        text.replace(&folder.path().display().to_string(), "")
    };
    let of = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        fault(&raw(&path, "cf32_le", AfterEnd::Repeat))
    };
    insta::assert_snapshot!(of(b""), @"IQ file /a.cf32: it has no samples");
    insta::assert_snapshot!(of(&[0; 8003]), @"IQ file /a.cf32: 8003 bytes of samples are no whole number of cf32_le samples; allowed: another datatype, or the file cut by 3 bytes");
    insta::assert_snapshot!(of(&[0; 8000]), @"IQ file /a.cf32: no sample of 1000 that were looked at differs from zero");
    let mut values = drawn(500);
    values[321][1] = f64::NAN;
    insta::assert_snapshot!(of(&bytes(&values, "cf32_le")), @"IQ file /a.cf32: sample 321 (from 0) is no number, or too large; allowed: up to 1e150");
    insta::assert_snapshot!(fault(&raw(folder.path(), "ci8", AfterEnd::Repeat)), @"IQ file : is a folder; allowed: a regular file");
    let meta = folder.path().join("b.sigmf-meta");
    let described = IqFile { path: meta.clone(), raw: None, after: AfterEnd::Repeat };
    let missing = fault(&described);
    assert!(
        missing.starts_with("IQ file /b.sigmf-meta: its metadata, /b.sigmf-meta: No such file"),
        "{missing}"
    );
    fs::write(&meta, r#"{"global":{"core:datatype":"ci8","core:sample_rate":1e6}}"#).unwrap();
    let missing = fault(&described);
    assert!(
        missing.starts_with("IQ file /b.sigmf-meta: its samples, /b.sigmf-data: No such file"),
        "{missing}"
    );
    fs::write(&meta, r#"{"global":{"core:datatype":"cf16_le"}}"#).unwrap();
    let both = fault(&described);
    assert!(
        both.contains("core:datatype = \"cf16_le\"") && both.contains("core:sample_rate is missing"),
        "{both}"
    );
}

/// A file that is written to, or cut, ends what reads it with a word; one that is moved away does not.
#[test]
fn a_file_that_changes_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.cf32");
    let values = drawn(5000);
    let written = || {
        fs::write(&path, bytes(&values, "cf32_le")).unwrap();
        Recording::open(&raw(&path, "cf32_le", AfterEnd::Repeat)).unwrap()
    };
    let mut out = vec![Complex64::ZERO; 100];
    let own = written();
    fs::rename(&path, folder.path().join("b.cf32")).unwrap();
    own.fill(4990, &mut out).unwrap();
    let own = written();
    fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(16).unwrap();
    let error = own.fill(0, &mut out).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "it has changed since the run began; allowed: a file that nobody writes to, such as a copy"
        ),
        "{error}"
    );
    let own = written();
    fs::OpenOptions::new().append(true).open(&path).unwrap().write_all(&[0; 8]).unwrap();
    assert!(own.fill(0, &mut out).is_err());
}
