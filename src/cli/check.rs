//! `nereus check`: validate, explain, predict.

mod horizon;
mod known;
mod limits;
pub(super) mod plan;
mod sea;
pub(super) mod ships;

use crate::cli::scenario::ScenarioArgs;
use clap::Args;
use std::fmt::Write as _;
use std::io::Write;

use serde::Serialize;

use super::error::CliError;
use super::escape;
use super::json;
use super::{counted, warn};
use crate::adequacy::polarisation::polarisation;
use crate::adequacy::{Adequacy, EDGE_BUDGET_DB, SeaWarning, edge_db, outlook};
use crate::bench::resources::Resources;
use crate::config::Run;
use crate::echo::Fidelity;
use crate::fidelity::cost::CostTable;
use crate::frames::Earth;
use crate::motion::PlatformNav;
use crate::nav::TrackSource;
use crate::nav::{AttitudeSource, FileFormat, FileSource, Place, VerticalDatum};
use crate::pipeline::build;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::outputs;
use crate::pipeline::plausible;
use crate::pulse::SampleFormat;
use crate::radar::filter::ReceiveFilter;
use crate::radar::receiver::thermal_noise_w;
use crate::scene::radar::{Aim, AimFrom, Gate, Sweep, TxPolarisation, Waveform};
use crate::sinks::Kind;
use crate::transport::{Pace, Policy};
use crate::units::Decibels;

/// `nereus check`
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArgs,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// What a scenario is and takes: what `nereus check` prints, as text ([`Self::text`]) or JSON.
#[derive(Debug, Serialize)]
pub struct Report {
    scenario: String,
    start_utc: String,
    duration_s: f64,
    pulses: u64,
    mean_prf_hz: f64,
    channels: Vec<String>,
    samples: usize,
    platforms: Vec<Described>,
    targets: usize,
    sinks: Vec<String>,
    modelled: Vec<Described>,
    not_modelled: Vec<Described>,
    /// Samples and records of one pulse as held in memory.
    pulse_bytes: usize,
    /// Samples alone, all channels, at the mean PRF.
    sample_rate_mb_per_s: f64,
    /// Samples of the whole run.
    samples_mb: f64,
    /// Ring and queues.
    memory_mib: f64,
    warnings: Vec<String>,
    /// How the recorded tracks were made.
    tracks: Vec<Described>,
    /// The sea in figures.
    sea: Option<Adequacy>,
    forecast: Option<Resources>,
    /// What is chosen for the error that is asked; none for the reference.
    plan: Option<plan::PlanReport>,
    #[serde(skip)]
    lines: Vec<Described>,
}

/// The row of the echo among what is modelled.
const ECHO: &str = "echo";

/// Something and what there is to say about it.
#[derive(Debug, Serialize)]
struct Described {
    what: String,
    how: String,
}

fn described(what: &str, how: impl Into<String>) -> Described {
    Described { what: what.to_owned(), how: how.into() }
}

/// Prints the report.
pub(super) fn check(args: &CheckArgs, out: &mut dyn Write) -> Result<(), CliError> {
    let run = args.scenario.load(&[])?;
    let report = assess(&run, |warnings| warn(warnings))?;
    let text = if args.json { json::json(&report)? + "\n" } else { report.text() };
    out.write_all(text.as_bytes()).map_err(CliError::Output)
}

/// Validates, explains and predicts a run. Warnings go to `tell` as soon as they are known, and are in the
/// report as well.
///
/// # Errors
/// What keeps the run from being built, all at once.
pub fn assess(run: &Run, mut tell: impl FnMut(&[String])) -> Result<Report, CliError> {
    let mut report = report(run);
    // An output that exists stands in the way of a run, not of a look at the scenario.
    report.warnings.extend(outputs::preflight(&run.sinks).iter().map(ToString::to_string));
    tell(&report.warnings);
    let nominal = without_trajectory(run);
    if !nominal.is_empty() {
        // What needs a trajectory is not said, rather than said of a wrong one.
        let before = report.warnings.len();
        report.warnings.extend(nominal);
        tell(&report.warnings[before..]);
        return Ok(report);
    }
    let unrecorded = Run { sinks: Vec::new(), ..run.clone() };
    let stream = build::on_nominal_tracks(&unrecorded, 0..run.scene.pulses)?;
    for note in stream.notes() {
        let what = format!("{}, {} track", note.platform, note.role);
        report.tracks.push(described(&what, note.report.to_string()));
    }
    report.sea = outlook(run)?;
    if let Some(sea) = &mut report.sea {
        sea.edge_db = edge_db(stream.factory(), stream.schedule()).map_err(BuildErrors::from)?;
        sea.warnings.extend(
            sea.edge_db.filter(|edge| *edge > EDGE_BUDGET_DB).map(|edge_db| SeaWarning::Edge { edge_db }),
        );
    }
    let told = report.warnings.len();
    report.warnings.extend(horizon::warnings(&stream).map_err(BuildErrors::from)?);
    report.warnings.extend(report.sea.iter().flat_map(|sea| &sea.warnings).map(ToString::to_string));
    report.warnings.extend(polarisation(run)?.iter().map(ToString::to_string));
    if let Some(planned) = stream.factory().plan() {
        let speed = stream.threads() as f64 / CostTable::TABLE.seconds(&planned.work);
        let factor = speed / run.scene.radar.emissions.mean_prf_hz();
        report.warnings.extend(plan::not_kept(planned));
        for row in report.modelled.iter_mut().filter(|row| row.what == ECHO) {
            row.how = plan::echo_text(planned);
        }
        report.plan = Some(plan::PlanReport::new(planned, factor, stream.predicted_bytes()));
    }
    report.warnings.extend(plausible::targets(run)?.iter().map(ToString::to_string));
    let forecast = stream.forecast(&run.scene.radar).map_err(BuildErrors::from)?;
    let levels = forecast.converter.iter().flat_map(|converter| converter.warnings());
    report.warnings.extend(levels.map(|warning| warning.to_string()));
    if forecast.real_time_factor < 1.0 && run.stream.pace == Pace::Realtime {
        let slow = format!(
            "{} times real time on this machine: a run in real time falls behind; --pace fast, or stream.pace = \"fast\"",
            digits(forecast.real_time_factor)
        );
        report.warnings.push(slow);
    }
    tell(&report.warnings[told..]);
    report.forecast = Some(forecast);
    Ok(report)
}

/// Live platforms of which nothing is known beforehand.
fn without_trajectory(run: &Run) -> Vec<String> {
    let live = |(name, nav): (&String, &PlatformNav)| match &nav.truth {
        TrackSource::Live(source) if source.nominal.is_none() => Some(format!(
            "platform '{name}' is live, and where it will be is not known: sea, window, plan and speed are not predicted; \
             a nominal trajectory (track.nominal) lets check predict them"
        )),
        _ => None,
    };
    run.scene.platforms.iter().zip(&run.nav).filter_map(live).collect()
}

impl Report {
    /// For people.
    pub fn text(&self) -> String {
        text(self)
    }
}

fn text(report: &Report) -> String {
    let mut text = String::new();
    let mut section = |title: &str, rows: &[Described]| {
        if !rows.is_empty() {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{title}");
            let width = rows.iter().map(|row| row.what.chars().count()).max().unwrap_or(0);
            for row in rows {
                let _ = writeln!(text, "  {:width$}  {}", row.what, row.how);
            }
        }
    };
    section(&report.scenario, &report.lines);
    section("platforms", &report.platforms);
    section("modelled", &report.modelled);
    section("not modelled", &report.not_modelled);
    section("sea", &report.sea.as_ref().map(sea::rows).unwrap_or_default());
    let ships = report.sea.as_ref().map_or(&[][..], |sea| &sea.ships);
    section("ships", &ships::rows(ships));
    section("recorded tracks", &report.tracks);
    section("plan, predicted", &report.plan.as_ref().map(plan::PlanReport::rows).unwrap_or_default());
    section("forecast", &report.forecast.as_ref().map(forecast_rows).unwrap_or_default());
    text
}

/// Two digits, or all before the point.
fn digits(value: f64) -> String {
    if !(value > 0.0 && value.is_finite()) {
        return format!("{value}");
    }
    let decimals = (1 - value.log10().floor() as i64).clamp(0, 12) as usize;
    format!("{value:.decimals$}")
}

fn forecast_rows(forecast: &Resources) -> Vec<Described> {
    let mut rows = vec![
        described(
            "speed",
            format!(
                "{} pulses/s with {} ({} made for this forecast): {} times real time",
                digits(forecast.pulses_per_s),
                counted(forecast.threads, "thread"),
                counted(forecast.trial_pulses, "pulse"),
                digits(forecast.real_time_factor)
            ),
        ),
        described(
            "memory of the sea",
            format!("about {} MiB with {}", forecast.sea_bytes >> 20, counted(forecast.threads, "thread")),
        ),
        described("in the window", format!("up to {}", counted(forecast.targets_in_window, "target"))),
        described(
            "at pace fast",
            format!("about {} s", digits(forecast.pulses as f64 / forecast.pulses_per_s)),
        ),
        described(
            "recording",
            format!(
                "{:.2} MB/s, {:.1} MB in all, records included",
                forecast.bytes_per_s / 1e6,
                forecast.recording_bytes as f64 / 1e6
            ),
        ),
    ];
    if let Some(converter) = &forecast.converter {
        let level = |of: &plausible::ChannelReport| {
            format!("{} {} LSB rms, {} peak", of.channel, digits(of.rms_lsb), digits(of.peak_lsb))
        };
        let levels: Vec<String> = converter.channels.iter().map(level).collect();
        rows.push(described("ADC", levels.join("; ")));
    }
    rows
}

/// Everything that the scenario says by itself, without opening the files it names.
pub(super) fn report(run: &Run) -> Report {
    let (scene, radar) = (&run.scene, &run.scene.radar);
    let mut layout = radar.layout(scene.platforms.len(), scene.targets.len());
    layout.channels += run.calibration.len();
    let sample_bytes = match layout.format {
        SampleFormat::Cf32 => 8,
        SampleFormat::Ci16 => 4,
    };
    let pulse_mb = (layout.channels * layout.samples * sample_bytes) as f64 / 1e6;
    let prf_hz = radar.emissions.mean_prf_hz();
    let slots = run.stream.ring_slots + run.sinks.iter().map(|sink| sink.queue_pulses).sum::<usize>();
    let duration_s = radar.emissions.interval_s(0, scene.pulses);
    let sinks: Vec<String> = run.sinks.iter().map(|sink| sink_text(&sink.kind)).collect();
    let (modelled, not_modelled) = models(run);
    let mut report = Report {
        scenario: run.path.display().to_string(),
        start_utc: scene.start.to_string(),
        duration_s,
        pulses: scene.pulses,
        mean_prf_hz: prf_hz,
        channels: radar
            .channels
            .iter()
            .map(|channel| channel.name.clone())
            .chain(run.calibration.iter().map(|known| known.name.clone()))
            .collect(),
        samples: layout.samples,
        platforms: platforms(run),
        targets: scene.targets.len(),
        sinks,
        modelled,
        not_modelled,
        pulse_bytes: layout.slot_bytes(),
        sample_rate_mb_per_s: pulse_mb * prf_hz,
        samples_mb: pulse_mb * scene.pulses as f64,
        memory_mib: slots as f64 * layout.slot_bytes() as f64 / f64::from(1 << 20),
        warnings: run.warnings.iter().map(ToString::to_string).collect(),
        tracks: Vec::new(),
        sea: None,
        forecast: None,
        plan: None,
        lines: Vec::new(),
    };
    report.lines = lines(run, &report);
    report
}

fn lines(run: &Run, report: &Report) -> Vec<Described> {
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
    let waveform = match &radar.waveform {
        Waveform::Lfm { bandwidth_hz, duration_s, sweep } => format!(
            "linear FM {}, {} MHz in {} us, time-bandwidth product {:.1}",
            if *sweep == Sweep::Up { "up" } else { "down" },
            neat(bandwidth_hz / 1e6),
            neat(duration_s * 1e6),
            bandwidth_hz * duration_s
        ),
        Waveform::Samples { path, rate_hz } => {
            format!("samples of {} at {} MHz", escape::path(path), neat(rate_hz / 1e6))
        }
    };
    let window_us = radar.window.samples as f64 / radar.sample_rate_hz * 1e6;
    let gate = match &radar.window.gate {
        Gate::Fixed { start_s } => format!("opens {} us after the emission", neat(start_s * 1e6)),
        Gate::Follow { aim, lead_s, aim_from } => format!(
            "opens {} us before the echo of {}, from {} tracks",
            neat(lead_s * 1e6),
            aim_text(aim, &scene.platforms),
            if *aim_from == AimFrom::True { "true" } else { "reported" }
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
            };
            format!("real time, {} ms after the emission, {policy}", neat(run.stream.latency_s * 1e3))
        }
    };
    vec![
        described("frame", frame),
        described(
            "time",
            format!(
                "{}, {} in {:.6} s, mean PRF {} Hz",
                report.start_utc,
                counted(report.pulses, "pulse"),
                report.duration_s,
                report.mean_prf_hz
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
        described("channels", format!("{}; {polarisation}", report.channels.join(" "))),
        described("targets", report.targets.to_string()),
        described("release", pace),
        described("sinks", report.sinks.join("; ")),
        described(
            "data",
            format!(
                "{:.3} MB/s of samples, {:.3} MB in all; {} bytes a pulse in memory, {:.1} MiB of ring and queues",
                report.sample_rate_mb_per_s, report.samples_mb, report.pulse_bytes, report.memory_mib
            ),
        ),
    ]
}

/// A scaled figure without the last digits that scaling made up.
fn neat(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

fn aim_text(aim: &Aim, platforms: &[String]) -> String {
    match aim {
        Aim::Point { position, .. } => {
            let [e, n, u] = position.to_array();
            format!("the point {e:.1} m East, {n:.1} m North, {u:.1} m up")
        }
        Aim::Beside { platform, along_m, across_m } => {
            let name = platforms.get(*platform).map_or("", String::as_str);
            let side = if *across_m < 0.0 { "port" } else { "starboard" };
            format!("the sea {} m to {side} and {along_m} m ahead of {name}", across_m.abs())
        }
    }
}

fn sink_text(kind: &Kind) -> String {
    match kind {
        Kind::Hdf5 { path, segment_s: None, .. } => format!("HDF5 recording {}", escape::path(path)),
        Kind::Hdf5 { path, segment_s: Some(segment_s), .. } => {
            format!("HDF5 recordings {} of {segment_s} s each", escape::path(path))
        }
        Kind::Plain { path, .. } => format!("plain folder {}", escape::path(path)),
        Kind::Vita49(settings) => {
            format!("VITA 49.2 over UDP to {}, packets of {} bytes", settings.address, settings.mtu_bytes)
        }
        Kind::Nav(nav) => format!("navigation to {}, {} a second", nav.device, nav.rate_hz),
        Kind::Null => "none (pulses are counted)".to_owned(),
    }
}

fn platforms(run: &Run) -> Vec<Described> {
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
    format!("{format} recording {}, heights {datum}, attitude {attitude}", escape::path(&source.path))
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

/// What is modelled, and what is not and why.
fn models(run: &Run) -> (Vec<Described>, Vec<Described>) {
    let radar = &run.scene.radar;
    let (mut with, mut without) = (Vec::new(), Vec::new());
    with.push(described(
        "propagation",
        "exact light time of every pulse; Doppler within the pulse, carrier and envelope stretched alike",
    ));
    horizon::models(&run.scene, &mut with, &mut without);
    with.push(described(
        ECHO,
        match run.fidelity {
            Fidelity::Reference => "the reference: every pulse from its own paths, f64".to_owned(),
            Fidelity::Fast(asked) => {
                // What is predicted takes its place where the run can be planned.
                format!("fast: error against the reference {} dB asked", asked.error_db)
            }
        },
    ));
    if run.scene.targets.is_empty() {
        without.push(described("point targets", "no [[target]]"));
    } else {
        with.push(described("point targets", run.scene.targets.len().to_string()));
    }
    if radar.direct_path {
        with.push(described("direct path", "transmitter to receiver"));
    } else {
        without.push(described("direct path", "radar.direct_path = false"));
    }
    match radar.noise_figure_db {
        Some(figure_db) => {
            let bandwidth_hz = ReceiveFilter::new(radar.sample_rate_hz).noise_bandwidth_hz();
            let noise_w = thermal_noise_w(bandwidth_hz, Decibels(figure_db));
            with.push(described(
                "thermal noise",
                format!(
                    "noise figure {figure_db} dB: k T0 F B = {:.1} dBW a sample, in the noise bandwidth of the receive filter, \
                     {} MHz (0.875 of the sample rate)",
                    Decibels::from_power_ratio(noise_w).0,
                    neat(bandwidth_hz / 1e6)
                ),
            ));
        }
        None => without.push(described("thermal noise", "no radar.noise_figure_db")),
    }
    match radar.adc {
        Some(adc) => with.push(described("ADC", format!("{} bits", adc.bits))),
        None => without.push(described("ADC", "no [radar.adc]: floating-point samples")),
    }
    known::models(run, &mut with, &mut without);
    sea::models(&run.scene, &mut with, &mut without);
    ships::models(&run.scene, &mut with, &mut without);
    limits::models(run, &mut without);
    (with, without)
}
