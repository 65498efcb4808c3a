//! What a scenario asks for, in a few rows.

use super::{Described, aim_text, described};
use crate::config::Run;
use crate::frames::Earth;
use crate::inputs::shown;
use crate::motion::PlatformNav;
use crate::nav::{AttitudeSource, FileFormat, FileSource, Place, TrackSource, VerticalDatum};
use crate::radar::dechirp::factor;
use crate::radar::filter::ReceiveFilter;
use crate::scene::radar::{AimFrom, Dechirp, Gate, Source, Sweep, Taper, TxPolarisation, Waveform};
use crate::scene::{Emitter, Radar};
use crate::sinks::Kind;
use crate::sinks::asterix::Detection;
use crate::sinks::zmq::Messages;
use crate::transport::{Pace, Policy};
use crate::units::{counted, neat};

/// What the scenario asks for, without what it costs.
pub fn rows(run: &Run) -> Vec<Described> {
    let (scene, radar) = (&run.scene, &run.scene.radar);
    let earth = match scene.frame.earth() {
        Earth::Flat => "flat earth".to_owned(),
        Earth::Curved { radius_factor } => format!("curved earth, radius factor {radius_factor}"),
    };
    let frame = match scene.frame.origin() {
        Some(origin) => format!(
            "East, North, up at latitude {:.6} deg, longitude {:.6} deg; sea level {} m above the ellipsoid; {earth}",
            origin.lat_rad.to_degrees(),
            origin.lon_rad.to_degrees(),
            origin.h_m
        ),
        None => format!("plain East, North, up; {earth}"),
    };
    let waveform = waveform_text(&radar.waveform);
    let window_us = radar.window.samples as f64 / radar.sample_rate_hz * 1e6;
    let opens = |gate: &Gate| match gate {
        Gate::Fixed { start_s } => format!("opens {} us after the emission", neat(start_s * 1e6)),
        Gate::Follow { aim, lead_s, aim_from } => format!(
            "opens {} us before the echo of {}, from {} tracks",
            neat(lead_s * 1e6),
            aim_text(aim, &scene.platforms),
            if *aim_from == AimFrom::True { "true" } else { "reported" }
        ),
    };
    let own = radar.receivers.iter().filter_map(|end| Some((&end.name, end.gate.as_ref()?)));
    let own = own.map(|(name, gate)| format!("; that of {name} {}", opens(gate)));
    let gate = match &radar.sent {
        None => own.fold(opens(&radar.window.gate), |text, own| text + &own),
        Some(sent) => format!(
            "continuous: block after block without a gap; pulses leave at a mean PRF of {} Hz",
            neat(sent.mean_prf_hz())
        ),
    };
    let polarisation = match &radar.tx_polarisation {
        TxPolarisation::Simultaneous => "simultaneous transmit polarisations".to_owned(),
        TxPolarisation::Alternating(sequence) => {
            let letters: String = sequence.iter().map(|p| p.letter()).collect();
            format!("transmit polarisations in turn: {letters}")
        }
    };
    let pace = match (run.stream.pace, run.stream.policy) {
        (Pace::Fast, _) => "as fast as pulses are made".to_owned(),
        (Pace::Realtime, policy) => {
            let policy = match policy {
                Policy::Stop => "ends when generation cannot keep up",
                Policy::Slip => "slips when generation cannot keep up",
                Policy::Drop => "drops pulses when generation cannot keep up",
                Policy::Relax => "relaxes the error when generation cannot keep up",
            };
            format!("real time, {} ms after the emission, {policy}", neat(run.stream.latency_s * 1e3))
        }
    };
    let mut rows = vec![
        described("frame", frame),
        described(
            "time",
            format!(
                "{}, {} in {:.6} s, mean {} {} Hz",
                scene.start,
                counted(scene.pulses, if radar.sent.is_some() { "block" } else { "pulse" }),
                radar.emissions.interval_s(0, scene.pulses),
                if radar.sent.is_some() { "rate" } else { "PRF" },
                radar.emissions.mean_prf_hz()
            ),
        ),
        described(
            "carrier",
            format!("{} GHz, wavelength {:.6} m", neat(radar.carrier_hz / 1e9), radar.wavelength_m()),
        ),
        described("waveform", waveform),
        described(
            "window",
            format!(
                "{} samples at {} MHz, {window_us:.3} us, {gate}",
                radar.window.samples,
                neat(radar.sample_rate_hz / 1e6)
            ),
        ),
        described("channels", format!("{}; {polarisation}", channels(run).join(" "))),
        described("targets", scene.targets.len().to_string()),
        described("release", pace),
        described("sinks", sinks(run).join("; ")),
    ];
    if let (Some(Dechirp { delay_s }), Some(bandwidth_hz)) = (radar.dechirp, radar.waveform.bandwidth_hz()) {
        rows.push(described("dechirp", dechirp_text(radar, delay_s, bandwidth_hz)));
    }
    let emitters = radar.emitters.iter().map(|emitter| described("emitter", emitter_text(emitter, radar)));
    rows.extend(emitters);
    rows
}

fn dechirp_text(radar: &Radar, delay_s: f64, bandwidth_hz: f64) -> String {
    let rate_hz_s = radar.waveform.steepness_hz_per_s().unwrap_or(0.0);
    let [flat_hz, _] = ReceiveFilter::new(radar.sample_rate_hz).edges_hz();
    let wide_hz = factor(bandwidth_hz, radar.sample_rate_hz) as f64 * radar.sample_rate_hz;
    format!(
        "reference delayed by {} us, beats of {} kHz/us, delays within {:.3} us of it unattenuated; front end of {} MHz",
        neat(delay_s * 1e6),
        neat(rate_hz_s / 1e9),
        1e6 * flat_hz / rate_hz_s,
        neat(wide_hz / 1e6)
    )
}

/// Pulses in turn that are described one by one.
const MOST_SHOWN: usize = 4;

fn waveform_text(waveform: &Waveform) -> String {
    match waveform {
        Waveform::Lfm { bandwidth_hz, duration_s, sweep } => format!(
            "linear FM {}, {} MHz in {} us, time-bandwidth product {:.1}",
            if *sweep == Sweep::Up { "up" } else { "down" },
            neat(bandwidth_hz / 1e6),
            neat(duration_s * 1e6),
            bandwidth_hz * duration_s
        ),
        Waveform::Triangular { bandwidth_hz, duration_s } => format!(
            "linear FM up and down, {} MHz in {} us",
            neat(bandwidth_hz / 1e6),
            neat(duration_s * 1e6)
        ),
        Waveform::Nlfm { bandwidth_hz, duration_s, sweep, taper } => format!(
            "nonlinear FM {}, {} MHz in {} us, {}",
            if *sweep == Sweep::Up { "up" } else { "down" },
            neat(bandwidth_hz / 1e6),
            neat(duration_s * 1e6),
            match taper {
                Taper::Taylor { sidelobe_db } => format!("Taylor taper of -{} dB", neat(*sidelobe_db)),
                _ => "Hamming taper".to_owned(),
            }
        ),
        Waveform::Drooping { of, droop_db } => {
            format!("{}, falling by {} dB from its begin to its end", waveform_text(of), neat(*droop_db))
        }
        Waveform::Offset { of, offset_hz } => {
            let sign = if *offset_hz < 0.0 { '-' } else { '+' };
            format!("{} at {sign}{} MHz", waveform_text(of), neat(offset_hz.abs() / 1e6))
        }
        Waveform::InTurn { of, stepped: true } => {
            let at_hz = |pulse: Option<&Waveform>| match pulse {
                Some(Waveform::Offset { offset_hz, .. }) => *offset_hz,
                _ => 0.0,
            };
            let pulse = match of.first() {
                Some(Waveform::Offset { of, .. }) => waveform_text(of),
                _ => String::new(),
            };
            let step_hz = at_hz(of.get(1)) - at_hz(of.first());
            format!("{} steps of {} MHz in turn, each a {pulse}", of.len(), neat(step_hz / 1e6))
        }
        Waveform::InTurn { of, .. } => {
            let first: Vec<String> = of.iter().take(MOST_SHOWN).map(waveform_text).collect();
            let more = of.len().saturating_sub(MOST_SHOWN);
            let more = if more > 0 { format!("; and {more} more") } else { String::new() };
            format!("{} in turn: {}{more}", of.len(), first.join("; "))
        }
        Waveform::Cw { duration_s } => format!("plain pulse of {} us", neat(duration_s * 1e6)),
        Waveform::PhaseCode { code, chip_s } => {
            format!("{} code, {} chips of {} us", code.name(), code.chips(), neat(chip_s * 1e6))
        }
        Waveform::Stream { source, interval_s } => {
            let wide = source.bandwidth_hz().map(|hz| format!(" of {} MHz", neat(hz / 1e6)));
            let wide = wide.unwrap_or_default();
            let which = match source {
                Source::GpsCa { prn, .. } => format!(" {prn}"),
                Source::IqFile(file) => format!(" {}", shown(&file.path)),
                _ => String::new(),
            };
            let name = source.name();
            format!("{name}{which}{wide}, continuous, in segments of {} us", neat(interval_s * 1e6))
        }
        Waveform::Samples { path, rate_hz } => {
            format!("samples of {} at {} MHz", shown(path), neat(rate_hz / 1e6))
        }
    }
}

fn emitter_text(emitter: &Emitter, radar: &Radar) -> String {
    let receivers = emitter.receivers.iter().filter_map(|place| radar.receivers.get(*place));
    let receivers: Vec<&str> = receivers.map(|receiver| receiver.name.as_str()).collect();
    let how = match (emitter.direct_path, emitter.echo) {
        (true, true) => "direct path and echoes",
        (true, false) => "direct path alone",
        (false, true) => "echoes alone",
        (false, false) => "nothing",
    };
    let from = match emitter.emissions.start_s() {
        0.0 => String::new(),
        start_s => format!(" from {} us", neat(1e6 * start_s)),
    };
    format!(
        "{}: {} GHz, {}, mean PRF {} Hz{from}, polarisation {}; {how}, received by {}",
        emitter.transmitter.name,
        neat(emitter.carrier_hz / 1e9),
        waveform_text(&emitter.waveform),
        neat(emitter.emissions.mean_prf_hz()),
        emitter.polarisation.letter(),
        receivers.join(", ")
    )
}

/// Channels, those of calibration behind the others.
pub fn channels(run: &Run) -> Vec<String> {
    let known = run.calibration.iter().map(|known| known.name.clone());
    run.scene.radar.channels.iter().map(|channel| channel.name.clone()).chain(known).collect()
}

/// Where pulses go.
pub fn sinks(run: &Run) -> Vec<String> {
    run.sinks.iter().map(|sink| sink_text(&sink.kind)).collect()
}

fn sink_text(kind: &Kind) -> String {
    match kind {
        Kind::Hdf5 { path, segment_s: None, .. } => format!("HDF5 recording {}", shown(path)),
        Kind::Hdf5 { path, segment_s: Some(segment_s), .. } => {
            format!("HDF5 recordings {} of {segment_s} s each", shown(path))
        }
        Kind::Plain { path, .. } => format!("plain folder {}", shown(path)),
        Kind::Crsd { path, .. } => format!("CRSD file {}", shown(path)),
        Kind::Vita49(settings) => {
            format!("VITA 49.2 over UDP to {}, packets of {} bytes", settings.address, settings.mtu_bytes)
        }
        Kind::Shm(settings) => format!(
            "shared memory, service {}, up to {}",
            settings.service,
            counted(settings.subscribers as u64, "subscriber")
        ),
        Kind::Zmq(settings) => {
            let to = settings.bind.rsplit_once(':').and_then(|(_, port)| port.parse::<u32>().ok());
            let last = to.map_or(0, |port| port + u32::from(settings.ports) - 1);
            match settings.messages {
                Messages::Samples if settings.ports > 1 => {
                    format!("ZeroMQ, samples at {} to port {last}, one per channel", settings.bind)
                }
                Messages::Samples => format!("ZeroMQ, samples at {}", settings.bind),
                Messages::Multipart => format!("ZeroMQ, multipart messages at {}", settings.bind),
            }
        }
        Kind::Asterix(settings) => format!(
            "ASTERIX video over UDP to {}, {} bits, {}",
            settings.address,
            settings.bits.count(),
            match settings.detection {
                Detection::Logarithmic { dynamic_db } => format!("logarithmic over {} dB", neat(dynamic_db)),
                Detection::Linear => "linear".to_owned(),
            }
        ),
        Kind::Nav(nav) => format!("navigation to {}, {} per second", nav.device, nav.rate_hz),
        Kind::Targets(targets) => format!("targets to {}, {} per second", targets.device, targets.rate_hz),
        Kind::Null => "none (pulses are counted)".to_owned(),
    }
}

/// Where platforms are, and what they report.
pub fn platforms(run: &Run) -> Vec<Described> {
    let text = |nav: &PlatformNav| {
        let truth = source_text(&nav.truth);
        match &nav.reported {
            Some(reported) => format!("{truth}; reports: {}", source_text(reported)),
            None if nav.errors.is_some() => format!("{truth}; reports with errors"),
            None => format!("{truth}; reported = true track"),
        }
    };
    let rows = run.scene.platforms.iter().zip(&run.nav);
    rows.map(|(name, nav)| described(name, text(nav))).collect()
}

fn source_text(source: &TrackSource) -> String {
    match source {
        TrackSource::Fixed { place, .. } => format!("fixed at {}", place_text(place)),
        TrackSource::Straight { place, velocity, .. } => {
            format!("straight from {} at {:.1} m/s", place_text(place), velocity.norm())
        }
        TrackSource::File(source) => file_text(source),
        TrackSource::Live(live) => format!("live from {}", live.origin),
    }
}

fn file_text(source: &FileSource) -> String {
    let format = match source.format {
        FileFormat::Csv => "CSV",
        FileFormat::Nmea => "NMEA",
        FileFormat::Inspvax => "INSPVAX",
        FileFormat::Sbet { .. } => "SBET",
        FileFormat::Gpx => "GPX",
        FileFormat::Kml => "KML",
    };
    let datum = match source.datum {
        VerticalDatum::Ellipsoid => "above the ellipsoid".to_owned(),
        VerticalDatum::MeanSeaLevel => "above mean sea level".to_owned(),
        VerticalDatum::Barometric { offset_m } => format!("barometric, offset {offset_m} m"),
    };
    let attitude = match source.attitude {
        AttitudeSource::Automatic => "as recorded, or derived from the motion where the fixes have none",
        AttitudeSource::Recorded => "as recorded",
        AttitudeSource::CoordinatedTurn => "of a coordinated turn (derived)",
        AttitudeSource::Level => "level along the track (derived)",
        AttitudeSource::Constant(_) => "constant",
    };
    format!("{format} recording {}, heights {datum}, attitude {attitude}", shown(&source.path))
}

fn place_text(place: &Place) -> String {
    match place {
        Place::Geodetic(at) => format!(
            "latitude {:.6} deg, longitude {:.6} deg, {:.1} m above the ellipsoid",
            at.lat_rad.to_degrees(),
            at.lon_rad.to_degrees(),
            at.h_m
        ),
        Place::Local(at) => {
            let [e, n, u] = at.to_array();
            format!("{e} m East, {n} m North, {u} m up")
        }
    }
}
