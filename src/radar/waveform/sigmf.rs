//! What the metadata of a SigMF recording say of its samples.
//!
//! Read are `core:datatype`, `core:sample_rate`, `core:num_channels`, `core:dataset`, `core:metadata_only`,
//! `core:trailing_bytes`, and `core:header_bytes` of captures. Samples of all captures follow each other;
//! when and at which frequency they were taken is not looked at. Source: SigMF 1.2.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::iq_fault::IqFault;
use crate::inputs;
use crate::scene::radar::{Datatype, RawIq};

/// Bytes that metadata may have.
const MOST_BYTES: u64 = 64 << 20;
/// Rates that are allowed, Hz: those of the key `rate_hz`.
const RATES_HZ: [f64; 2] = [1e3, 1e11];
/// Characters of a value that a message repeats.
const QUOTED: usize = 40;

/// Where samples are, and what they are.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Described {
    pub samples: PathBuf,
    pub of: RawIq,
    /// Bytes before the first and behind the last.
    pub around: [u64; 2],
}

/// Metadata and samples of a recording, by the path of either.
pub(super) fn paths(path: &Path) -> [PathBuf; 2] {
    ["sigmf-meta", "sigmf-data"].map(|ending| path.with_extension(ending))
}

/// Reads the metadata of a recording.
///
/// # Errors
/// All that is wrong with them.
pub(super) fn read(path: &Path) -> Result<Described, Vec<IqFault>> {
    let [meta, samples] = paths(path);
    let unread = |source| vec![IqFault::NoMetadata { path: meta.clone(), source }];
    let bytes = inputs::read(&meta, MOST_BYTES).map_err(unread)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(vec![IqFault::Long { allowed: MOST_BYTES }]);
    }
    described(&bytes, samples)
}

fn described(bytes: &[u8], samples: PathBuf) -> Result<Described, Vec<IqFault>> {
    let json = |error: serde_json::Error| vec![IqFault::Json { message: error.to_string() }];
    let all: Value = serde_json::from_slice(bytes).map_err(json)?;
    let mut faults = Vec::new();
    let global = all.get("global").unwrap_or(&Value::Null);
    let datatype =
        field(global, "core:datatype", &names(), true, &mut faults, |value| Datatype::named(value.as_str()?));
    let [least, most] = RATES_HZ;
    let allowed = format!("{least:e} to {most:e} Hz");
    let rate_hz = field(global, "core:sample_rate", &allowed, true, &mut faults, |value| {
        value.as_f64().filter(|hz| (least..=most).contains(hz))
    });
    field(global, "core:num_channels", "1", false, &mut faults, |value| value.as_u64().filter(|n| *n == 1));
    field(global, "core:metadata_only", "false", false, &mut faults, |value| {
        value.as_bool().filter(|only| !only)
    });
    let bytes = "a whole number";
    let behind = field(global, "core:trailing_bytes", bytes, false, &mut faults, Value::as_u64);
    let name = "the name of a file beside the metadata";
    let dataset = field(global, "core:dataset", name, false, &mut faults, |value| {
        let name = value.as_str()?;
        (Path::new(name).file_name()?.to_str()? == name).then(|| name.to_owned())
    });
    let captures = all.get("captures").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let mut before = None;
    for (i, capture) in captures.iter().enumerate() {
        let allowed = if i == 0 { bytes } else { "0 of all captures but the first" };
        let own = field(capture, "core:header_bytes", allowed, false, &mut faults, |value| {
            value.as_u64().filter(|bytes| i == 0 || *bytes == 0)
        });
        before = before.or(own);
    }
    match (datatype, rate_hz, faults.is_empty()) {
        (Some(datatype), Some(rate_hz), true) => Ok(Described {
            samples: dataset.map_or_else(|| samples.clone(), |name| samples.with_file_name(name)),
            of: RawIq { rate_hz, datatype },
            around: [before, behind].map(Option::unwrap_or_default),
        }),
        _ => Err(faults),
    }
}

fn names() -> String {
    Datatype::NAMED.map(|(name, _)| name).join(", ")
}

/// What a field holds; where it holds something else, or is missing but required, that is a fault.
fn field<T>(
    of: &Value,
    field: &'static str,
    allowed: &str,
    is_required: bool,
    faults: &mut Vec<IqFault>,
    read: impl Fn(&Value) -> Option<T>,
) -> Option<T> {
    let allowed = || allowed.to_owned();
    let Some(value) = of.get(field) else {
        if is_required {
            faults.push(IqFault::Missing { field, allowed: allowed() });
        }
        return None;
    };
    let known = read(value);
    if known.is_none() {
        let found: String = value.to_string().chars().take(QUOTED).collect();
        let found = inputs::one_line(&found).into_owned();
        faults.push(IqFault::Field { field, found, allowed: allowed() });
    }
    known
}

#[cfg(test)]
mod tests {
    use super::super::iq_fault::IqFaults;
    use super::*;

    fn of(text: &str) -> Result<Described, String> {
        described(text.as_bytes(), "a/b.sigmf-data".into()).map_err(|faults| IqFaults(faults).to_string())
    }

    #[test]
    fn says_where_samples_are_and_what() {
        let plain = r#"{"global":{"core:datatype":"ci16_le","core:sample_rate":2.5e6,"core:version":"1.2.0"},
            "captures":[{"core:sample_start":0,"core:frequency":1e8}],"annotations":[]}"#;
        let datatype = Datatype::named("ci16_le").unwrap();
        let expected = Described {
            samples: "a/b.sigmf-data".into(),
            of: RawIq { rate_hz: 2.5e6, datatype },
            around: [0, 0],
        };
        assert_eq!(of(plain).unwrap(), expected);
        let other = r#"{"global":{"core:datatype":"cu8","core:sample_rate":2048000,"core:num_channels":1,
            "core:dataset":"x.bin","core:trailing_bytes":6,"core:metadata_only":false},
            "captures":[{"core:header_bytes":12},{"core:header_bytes":0}]}"#;
        let found = of(other).unwrap();
        assert_eq!((found.samples, found.around), (PathBuf::from("a/x.bin"), [12, 6]));
    }

    #[test]
    fn names_every_fault() {
        insta::assert_snapshot!(of(r#"{"global":{"core:datatype":"rf32_le","core:num_channels":2,"core:metadata_only":true,
            "core:dataset":"../x","core:trailing_bytes":-1},"captures":[{},{"core:header_bytes":4}]}"#).unwrap_err(), @r#"core:datatype = "rf32_le" is not allowed; allowed: cf32_le, cf64_le, ci32_le, ci16_le, ci8, cu32_le, cu16_le, cu8, cf32_be, cf64_be, ci32_be, ci16_be, cu32_be, cu16_be; core:sample_rate is missing; required: 1e3 to 1e11 Hz; core:num_channels = 2 is not allowed; allowed: 1; core:metadata_only = true is not allowed; allowed: false; core:trailing_bytes = -1 is not allowed; allowed: a whole number; core:dataset = "../x" is not allowed; allowed: the name of a file beside the metadata; core:header_bytes = 4 is not allowed; allowed: 0 of all captures but the first"#);
        assert!(of("{").unwrap_err().contains("its metadata are no JSON"));
        for text in ["[]", "null", "{\"global\":7,\"captures\":{}}"] {
            assert!(of(text).unwrap_err().starts_with("core:datatype is missing"), "{text}");
        }
    }
}
