//! What a subscriber gets of the run and of a pulse, as JSON: for sinks whose messages hold the samples as
//! they are.
//!
//! Platforms appear with what they **report**; the truth stays in the recording. Every key is in
//! `docs/formats.md`.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use crate::pulse::{AntennaRecord, PlatformRecord, Pulse, SampleFormat};
use crate::recording::header::Header;

/// How samples are held, as texts name it.
pub fn format_name(format: SampleFormat) -> &'static str {
    match format {
        SampleFormat::Cf32 => "cf32",
        SampleFormat::Ci16 => "ci16",
    }
}

/// What holds for every pulse of a run; `source` is the number of the run ([`source`]).
pub fn of_run(header: &Header, source: u64) -> Value {
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    json!({
        "format": "nereus-pulses",
        "version": header.version(),
        "source": source,
        "software": header.software,
        "carrier_hz": header.carrier_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "bandwidth_hz": header.bandwidth_hz,
        "pulse_s": header.pulse_s,
        "prf_hz": header.prf_hz,
        "channels": header.channels,
        "samples": header.layout.samples,
        "sample_format": format_name(header.layout.format),
        "adc_bits": header.adc.map(|adc| adc.bits),
        "adc_step": header.adc.map(|adc| adc.step),
        "platforms": header.platforms,
        "transmitters": header.transmitters,
        "receivers": header.receivers,
        "origin_lat_deg": header.origin.map(|origin| origin.lat_deg),
        "origin_lon_deg": header.origin.map(|origin| origin.lon_deg),
        "origin_h_m": header.origin.map(|origin| origin.h_m),
        "start_time_ns": start_ns,
        "start_time_frac_ns": start_frac_ns,
        "first_pulse": header.first_pulse,
        "pulses": header.pulses,
        "instrument": header.instrument,
        "replica": header.replica.iter().map(|sample| [sample.re, sample.im]).collect::<Vec<_>>(),
    })
}

/// A number that no other run has: microseconds since 1970 when it began. JSON's numbers hold it.
pub fn source() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(now.as_micros()).unwrap_or_default()
}

/// A pulse without its samples.
#[derive(Debug, Serialize)]
struct PulseText<'a> {
    sequence: u64,
    index: u64,
    time_ns: i64,
    time_frac_ns: f64,
    window_start_s: f64,
    #[serde(skip_serializing_if = "<[f64]>::is_empty")]
    receiver_window_start_s: &'a [f64],
    flags: u32,
    tx_pol: u8,
    channels: usize,
    samples: usize,
    sample_format: &'static str,
    adc_step: Option<f64>,
    source: u64,
    platforms: States<'a>,
    #[serde(skip_serializing_if = "Readings::is_empty")]
    encoder_deg: Readings<'a>,
}

/// What the encoder of every antenna that scans reads, `[azimuth, elevation]`, in the order of the run.
#[derive(Debug)]
struct Readings<'a>(&'a [AntennaRecord]);

impl Readings<'_> {
    fn of(&self) -> impl Iterator<Item = [f64; 2]> {
        self.0.iter().filter_map(|antenna| antenna.encoder_deg)
    }

    fn is_empty(&self) -> bool {
        self.of().next().is_none()
    }
}

impl Serialize for Readings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.of())
    }
}

/// What every platform reports.
#[derive(Debug)]
struct States<'a> {
    names: &'a [String],
    records: &'a [PlatformRecord],
}

impl Serialize for States<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.names.iter().zip(self.records).map(|(name, record)| PlatformText {
            name,
            position_m: record.position_m,
            velocity_mps: record.velocity_mps,
            attitude_quat: record.attitude_quat,
            age_s: record.age_s,
            flags: record.flags,
        }))
    }
}

/// What a platform reports.
#[derive(Debug, Serialize)]
struct PlatformText<'a> {
    name: &'a str,
    position_m: [f64; 3],
    velocity_mps: [f64; 3],
    attitude_quat: [f64; 4],
    age_s: f64,
    flags: u32,
}

/// Appends the text of a pulse, the `sequence`-th that was published. Allocates only to grow `out`.
pub fn write_pulse(out: &mut Vec<u8>, header: &Header, source: u64, pulse: &Pulse, sequence: u64) {
    let (time_ns, time_frac_ns) = pulse.time.to_unix_ns();
    let text = PulseText {
        sequence,
        index: pulse.index,
        time_ns,
        time_frac_ns,
        window_start_s: pulse.window_start_s,
        receiver_window_start_s: &pulse.receiver_window_start_s,
        flags: pulse.flags,
        tx_pol: pulse.tx_pol,
        channels: header.layout.channels,
        samples: header.layout.samples,
        sample_format: format_name(header.layout.format),
        adc_step: header.adc.map(|adc| adc.step),
        source,
        platforms: States { names: &header.platforms, records: &pulse.nav_reported },
        encoder_deg: Readings(&pulse.antennas),
    };
    // Numbers and texts into memory: nothing of it can fail.
    let _ = serde_json::to_writer(out, &text);
}
