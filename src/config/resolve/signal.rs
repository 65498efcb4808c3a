//! Trains of pulses and waveforms, of the radar and of emitters.

mod in_turn;

use std::path::Path;

use crate::config::choices::{Choice, CodeKind, SweepKind, TaperKind, WaveformKind};
use crate::config::error::Problem;
use crate::config::keys::{Key, figure};
use crate::config::section::Section;
use crate::radar::waveform::SEGMENT_SAMPLES;
use crate::scene::radar::{
    CA_CHIPS_HZ, Code, Datatype, DvbT, Fm, IqFile, RawIq, Source, Sweep, Taper, Waveform,
};
use crate::time::PulseTimes;

/// Bandwidth times length of nonlinear sweeps: the least, and the most.
const PRODUCTS: [f64; 2] = [4.0, 20_000.0];
/// Channels of television.
const CHANNELS_HZ: [f64; 3] = [6e6, 7e6, 8e6];
/// Chips of Barker codes.
const BARKER: [usize; 7] = [2, 3, 4, 5, 7, 11, 13];

/// A train, by one of the keys.
pub(super) fn emissions(section: &Section<'_>, keys: [&'static Key; 2]) -> Option<PulseTimes> {
    let written = section.exactly_one(&keys);
    let (prf_hz, pri_us) = (section.number(keys[0]), section.numbers(keys[1]));
    written?;
    // Both ranges lie within those of PulseTimes, so that neither can fail.
    match (prf_hz, pri_us) {
        (Some(prf_hz), _) => PulseTimes::uniform(prf_hz).ok(),
        (None, Some(pri_us)) => {
            let pri_s: Vec<f64> = pri_us.iter().map(|us| us / 1e6).collect();
            PulseTimes::sequence(&pri_s).ok()
        }
        (None, None) => None,
    }
}

/// A waveform, which may be no wider than a sample rate if that is given; of a train, and of the radar or an
/// emitter by its number.
pub(super) fn waveform(
    section: Section<'_>,
    sample_rate_hz: Option<f64>,
    of: (Option<&PulseTimes>, u64),
) -> Option<Waveform> {
    let found = described(&section, sample_rate_hz, of);
    section.finish();
    found
}

fn described(
    section: &Section<'_>,
    sample_rate_hz: Option<f64>,
    (train, number): (Option<&PulseTimes>, u64),
) -> Option<Waveform> {
    use crate::config::keys::waveform::{
        BANDWIDTH_HZ, CHIP_S, DEVIATION_HZ, DROOP_DB, KIND, PATH, PRN, PULSE_S, RATE_HZ, SWEEP,
    };
    let too_wide = |key: &'static Key, bandwidth_hz: f64| {
        if let Some(sample_rate_hz) = sample_rate_hz.filter(|rate_hz| bandwidth_hz > *rate_hz) {
            section.fault(key, Problem::Bandwidth { bandwidth_hz, sample_rate_hz });
        }
    };
    let swept = || {
        let bandwidth_hz = section.number(&BANDWIDTH_HZ);
        bandwidth_hz.into_iter().for_each(|bandwidth_hz| too_wide(&BANDWIDTH_HZ, bandwidth_hz));
        let (duration_s, sweep) = (section.number(&PULSE_S), section.choice(&SWEEP));
        Some((bandwidth_hz?, duration_s?, sweep?))
    };
    let waveform = match section.choice(&KIND) {
        Some(WaveformKind::Lfm) => swept().map(|(bandwidth_hz, duration_s, kind)| match direction(kind) {
            Some(sweep) => Waveform::Lfm { bandwidth_hz, duration_s, sweep },
            None => Waveform::Triangular { bandwidth_hz, duration_s },
        }),
        Some(WaveformKind::Nlfm) => {
            let (swept, taper) = (swept(), taper(section));
            let product = swept.map(|(bandwidth_hz, duration_s, _)| bandwidth_hz * duration_s);
            let [least, most] = PRODUCTS;
            if let Some(product) = product.filter(|product| !(least..=most).contains(product)) {
                let found = format!("bandwidth_hz times pulse_s = {}", figure(product));
                let allowed =
                    format!("a product of {} to {} for kind = \"nlfm\"", figure(least), figure(most));
                section.fault(&PULSE_S, Problem::Type { found, allowed });
            }
            let sweep = swept.map(|(.., kind)| direction(kind));
            if sweep == Some(None) {
                let found = "sweep = \"triangular\" of kind = \"nlfm\"".to_owned();
                section.fault(&SWEEP, Problem::Type { found, allowed: "\"up\", \"down\"".to_owned() });
            }
            swept.zip(taper).zip(sweep.flatten()).map(|(((bandwidth_hz, duration_s, _), taper), sweep)| {
                Waveform::Nlfm { bandwidth_hz, duration_s, sweep, taper }
            })
        }
        Some(WaveformKind::Cw) => section.number(&PULSE_S).map(|duration_s| Waveform::Cw { duration_s }),
        Some(WaveformKind::PhaseCode) => {
            let (code, chip_s) = (code(section), section.number(&CHIP_S));
            if let Some(hz) = chip_s.map(f64::recip) {
                // A chip of one sample must pass although its reciprocal is rounded.
                let fits = sample_rate_hz.is_none_or(|rate_hz| hz * (1.0 - 4.0 * f64::EPSILON) <= rate_hz);
                if !fits {
                    too_wide(&CHIP_S, hz);
                }
            }
            code.zip(chip_s).map(|(code, chip_s)| Waveform::PhaseCode { code, chip_s })
        }
        Some(WaveformKind::File) => {
            let (path, rate_hz) = (section.file(&PATH), section.number(&RATE_HZ));
            path.zip(rate_hz).map(|(path, rate_hz)| Waveform::Samples { path, rate_hz })
        }
        Some(WaveformKind::Noise) => {
            let (bandwidth_hz, seed) = (section.number(&BANDWIDTH_HZ), seed(section, number));
            bandwidth_hz.into_iter().for_each(|bandwidth_hz| too_wide(&BANDWIDTH_HZ, bandwidth_hz));
            let source = bandwidth_hz.zip(seed).map(|(hz, seed)| Source::Noise { bandwidth_hz: hz, seed });
            source.and_then(|source| stream(section, source, train))
        }
        Some(WaveformKind::DvbT) => {
            let (of, seed) = (television(section), seed(section, number));
            of.iter().for_each(|of| too_wide(&BANDWIDTH_HZ, of.occupied_hz()));
            let source = of.zip(seed).map(|(of, seed)| Source::DvbT { of, seed });
            source.and_then(|source| stream(section, source, train))
        }
        Some(WaveformKind::Fm) => {
            let (deviation_hz, seed) = (section.number(&DEVIATION_HZ), seed(section, number));
            let of = deviation_hz.map(|deviation_hz| Fm { deviation_hz });
            of.iter().for_each(|of| too_wide(&DEVIATION_HZ, of.occupied_hz()));
            let source = of.zip(seed).map(|(of, seed)| Source::Fm { of, seed });
            source.and_then(|source| stream(section, source, train))
        }
        Some(WaveformKind::GpsCa) => {
            let prn = section.count(&PRN).and_then(|prn| u8::try_from(prn).ok());
            too_wide(&KIND, CA_CHIPS_HZ);
            let source = prn.zip(seed(section, number)).map(|(prn, seed)| Source::GpsCa { prn, seed });
            source.and_then(|source| stream(section, source, train))
        }
        Some(WaveformKind::IqFile) => {
            let source = recording(section).map(Source::IqFile);
            source.and_then(|source| stream(section, source, train))
        }
        Some(WaveformKind::Stepped) => in_turn::stepped(section, sample_rate_hz),
        Some(WaveformKind::InTurn) => in_turn::pulses(section, (sample_rate_hz, number)),
        None => None,
    };
    let droop_db = section.number(&DROOP_DB);
    let droops = droop_db.is_some_and(|droop_db| droop_db > 0.0);
    if let (Some(Waveform::Stream { source, .. }), true) = (&waveform, droops) {
        let found = format!("droop of kind = \"{}\"", source.name());
        let allowed = "droop_db = 0, or a waveform of pulses".to_owned();
        section.fault(&DROOP_DB, Problem::Type { found, allowed });
    }
    let each = droops && matches!(&waveform, Some(Waveform::InTurn { stepped: false, .. }));
    if each {
        let found = "droop of kind = \"in-turn\"".to_owned();
        section
            .fault(&DROOP_DB, Problem::Type { found, allowed: "droop_db of each of waveforms".to_owned() });
    }
    let (waveform, droop_db) = (waveform?, droop_db?);
    Some(if droops && !each { drooping(waveform, droop_db) } else { waveform })
}

/// Of steps of frequency, each of them.
fn drooping(of: Waveform, droop_db: f64) -> Waveform {
    match of {
        Waveform::InTurn { of, stepped } => {
            let of = of.into_iter().map(|pulse| drooping(pulse, droop_db)).collect();
            Waveform::InTurn { of, stepped }
        }
        Waveform::Offset { of, offset_hz } => {
            Waveform::Offset { of: Box::new(drooping(*of, droop_db)), offset_hz }
        }
        of => Waveform::Drooping { of: Box::new(of), droop_db },
    }
}

/// What a random signal is drawn by: its place, unless it is given.
fn seed(section: &Section<'_>, number: u64) -> Option<u64> {
    use crate::config::keys::waveform::SEED;
    if section.has(&SEED) { section.count(&SEED) } else { Some(number) }
}

/// A recording, and what its samples are.
fn recording(section: &Section<'_>) -> Option<IqFile> {
    use crate::config::keys::waveform::{AFTER, DATATYPE, PATH, RATE_HZ};
    let (path, after) = (section.file(&PATH), section.choice(&AFTER));
    // By the name, also where there is no such file.
    let ending = section.peek_text(&PATH).and_then(|path| Path::new(path).extension()?.to_str());
    let ending = ending.map(str::to_ascii_lowercase);
    let known = Datatype::ENDINGS.iter().find(|(known, _)| ending.as_deref() == Some(known));
    let refused = |key, found: &str, allowed: &str| {
        section.fault(key, Problem::Type { found: found.to_owned(), allowed: allowed.to_owned() });
    };
    if let Some(own @ ("sigmf-meta" | "sigmf-data" | "sigmf" | "sigmf-collection")) = ending.as_deref() {
        section.idle(&[&RATE_HZ, &DATATYPE], "the metadata of a SigMF recording have it");
        match own {
            "sigmf" => refused(&PATH, "an archive of SigMF", "the .sigmf-meta in it (tar xf)"),
            "sigmf-collection" => {
                refused(&PATH, "a collection of SigMF", "the .sigmf-meta of one recording");
            }
            _ => return Some(IqFile { path: path?, raw: None, after: after? }),
        }
        return None;
    }
    let rate_hz = section.number(&RATE_HZ);
    let written = section.has(&DATATYPE);
    let datatype: Option<Datatype> = section.choice(&DATATYPE);
    let datatype = if written { datatype } else { known.map(|(_, of)| *of) };
    if datatype.is_none() && !written && path.is_some() {
        let found = match &ending {
            Some(ending) => format!("a file of samples that ends in .{ending}"),
            None => "a file of samples without an ending".to_owned(),
        };
        let known: Vec<&str> = Datatype::ENDINGS.iter().map(|(known, _)| *known).collect();
        refused(&PATH, &found, &format!("datatype beside it, or one of the endings {}", known.join(", ")));
    }
    Some(IqFile { path: path?, raw: Some(RawIq { rate_hz: rate_hz?, datatype: datatype? }), after: after? })
}

/// A continuous signal in segments as long as the pulse interval.
fn stream(section: &Section<'_>, source: Source, train: Option<&PulseTimes>) -> Option<Waveform> {
    use crate::config::keys::waveform::KIND;
    let (train, kind) = (train?, source.name());
    let refused = |found: String, allowed: String| {
        section.fault(&KIND, Problem::Type { found, allowed });
        None
    };
    if !train.is_uniform() {
        let found = format!("kind = \"{kind}\" with pri_us");
        return refused(found, "prf_hz: segments of a continuous signal are equally long".to_owned());
    }
    let interval_s = train.mean_pri_s();
    let [least, most] = SEGMENT_SAMPLES;
    let samples = source.rate_hz().map(|rate_hz| rate_hz * interval_s);
    if let Some(samples) = samples.filter(|samples| !(least..=most).contains(samples)) {
        let found = format!("kind = \"{kind}\" with segments of {} samples", figure(samples));
        let allowed =
            format!("{} to {} samples in an interval, by prf_hz and its rate", figure(least), figure(most));
        return refused(found, allowed);
    }
    Some(Waveform::Stream { source, interval_s })
}

/// The parameters of a television signal.
fn television(section: &Section<'_>) -> Option<DvbT> {
    use crate::config::keys::waveform::{BANDWIDTH_HZ, CARRIERS, CONSTELLATION, GUARD};
    let channel_hz = section.number(&BANDWIDTH_HZ);
    let (mode, guard) = (section.choice(&CARRIERS), section.choice(&GUARD));
    let constellation = section.choice(&CONSTELLATION);
    let channel_hz = channel_hz.filter(|hz| {
        let is_channel = CHANNELS_HZ.contains(hz);
        if !is_channel {
            let found = format!("a channel of {} Hz", figure(*hz));
            section.fault(&BANDWIDTH_HZ, Problem::Type { found, allowed: "6e6, 7e6 or 8e6 Hz".to_owned() });
        }
        is_channel
    });
    Some(DvbT { channel_hz: channel_hz?, mode: mode?, guard: guard?, constellation: constellation? })
}

/// Of a sweep that has one.
fn direction(kind: SweepKind) -> Option<Sweep> {
    match kind {
        SweepKind::Up => Some(Sweep::Up),
        SweepKind::Down => Some(Sweep::Down),
        SweepKind::Triangular => None,
    }
}

/// The taper of a nonlinear sweep.
fn taper(section: &Section<'_>) -> Option<Taper> {
    use crate::config::keys::waveform::{SIDELOBE_DB, TAPER};
    match section.choice(&TAPER)? {
        TaperKind::Taylor => Some(Taper::Taylor { sidelobe_db: section.number(&SIDELOBE_DB)? }),
        TaperKind::Hamming => {
            section.idle(&[&SIDELOBE_DB], "taper = \"hamming\"");
            Some(Taper::Hamming)
        }
    }
}

/// A phase code of as many chips as are written.
fn code(section: &Section<'_>) -> Option<Code> {
    use crate::config::keys::waveform::{CHIPS, CODE, REGISTER};
    let Some(kind): Option<CodeKind> = section.choice(&CODE) else {
        // Which of these belong to it is unknown.
        let written = [&CHIPS, &REGISTER].into_iter().filter(|key| section.has(key));
        written.for_each(|key| {
            section.count(key);
        });
        return None;
    };
    if kind == CodeKind::MSequence {
        section.idle(&[&CHIPS], "code = \"m-sequence\"");
        return Some(Code::MSequence { register: u32::try_from(section.count(&REGISTER)?).ok()? });
    }
    section.idle(&[&REGISTER], &format!("code = \"{}\"", kind.word()));
    let chips = usize::try_from(section.count(&CHIPS)?).ok()?;
    let refused = |allowed: &str| {
        let found = format!("{chips} chips of code = \"{}\"", kind.word());
        section.fault(&CHIPS, Problem::Type { found, allowed: allowed.to_owned() });
        None
    };
    match kind {
        CodeKind::Barker if !BARKER.contains(&chips) => refused("2, 3, 4, 5, 7, 11 or 13"),
        CodeKind::Barker => Some(Code::Barker { chips }),
        CodeKind::Frank if chips.isqrt().pow(2) != chips => {
            refused("the square of a whole number from 2 to 256")
        }
        CodeKind::Frank => Some(Code::Frank { phases: chips.isqrt() }),
        CodeKind::GolayA | CodeKind::GolayB if !chips.is_power_of_two() => refused("a power of two"),
        CodeKind::GolayA | CodeKind::GolayB => Some(Code::Golay { chips, second: kind == CodeKind::GolayB }),
        CodeKind::P3 => Some(Code::P3 { chips }),
        CodeKind::P4 => Some(Code::P4 { chips }),
        // Told by its register.
        CodeKind::MSequence => None,
    }
}
