//! The instrument.

use super::antenna::{self, MountKeys, mount_keys};
use super::calibration::{self, Limits};
use super::clock::Given;
use super::emitter;
use super::front_end;
use super::receiver;
use super::signal::{emissions, waveform};
use super::window::window;
use super::{Ground, Names, plausible, steps};
use crate::config::choices::TxKind;
use crate::config::error::{Problem, Warning};
use crate::config::keys::{self, Key, figure};
use crate::config::scalars::{polarisation, polarisation_pair};
use crate::config::section::Section;
use crate::radar::rain::{CARRIERS_HZ, RAYLEIGH_TO_HZ};
use crate::scene::calibration::Calibration;
use crate::scene::front_end::FrontEnd;
use crate::scene::radar::{
    Adc, Channel, Dechirp, Polarisation, Radar, RainClutter, Transmitter, TxPolarisation, Waveform,
};
use crate::time::PulseTimes;

/// Most bytes of one pulse.
const LARGEST_PULSE: u128 = 1 << 24;
/// Rate of a front end before a dechirp over the bandwidth, and most samples of it.
const LEAST_WIDER: f64 = 1.5;
const MOST_WIDER: f64 = 1.7;
const LARGEST_FRONT_END: f64 = 4e6;

/// `[radar]`, `[[transmitter]]`, `[[receiver]]`; their clocks go to `clocks`.
pub(super) fn radar(
    root: &Section<'_>,
    ground: &Ground,
    platforms: &Names,
    clocks: &mut Given,
    calibration: &mut Option<Vec<Calibration>>,
) -> Option<Radar> {
    let mut transmitter_names = Names::new("transmitter");
    let mut transmitters: Vec<Option<Transmitter>> = root
        .sections(&keys::root::TRANSMITTER)
        .into_iter()
        .map(|section| {
            transmitter_names.take(&section, &keys::transmitter::NAME, &[]);
            transmitter(section, &transmitter_names, ground, platforms, clocks)
        })
        .collect();
    let mut receiver_names = Names::new("receiver");
    let (mut receivers, mut hears) = (Vec::new(), Vec::new());
    for section in root.sections(&keys::root::RECEIVER) {
        let heard = transmitter_names.find_all(&section, &keys::receiver::HEARS);
        let names = (&mut receiver_names, &transmitter_names);
        let elements = receiver::receivers(section, names, ground, platforms, clocks);
        hears.extend(elements.iter().map(|_| heard.clone()));
        receivers.extend(elements);
    }

    use keys::radar as k;
    let section = root.section(&keys::root::RADAR)?;
    let carrier_hz = section.number(&k::CARRIER_HZ);
    let sample_rate_hz = section.number(&k::SAMPLE_RATE_HZ);
    let emissions = emissions(&section, [&k::PRF_HZ, &k::PRI_US]);
    let dechirped = section.has(&k::DECHIRP);
    let widest_hz = sample_rate_hz.filter(|_| !dechirped);
    let waveform =
        section.section(&k::WAVEFORM).and_then(|s| waveform(s, widest_hz, (emissions.as_ref(), 0)));
    let lowest_hz = waveform.as_ref().and_then(Waveform::band).map(|band| -band.from_hz);
    if let Some((carrier_hz, least_hz)) =
        carrier_hz.zip(lowest_hz).filter(|(carrier_hz, hz)| carrier_hz <= hz)
    {
        let (found, allowed) = (
            format!("{} Hz", figure(carrier_hz)),
            format!("above {} Hz: the pulses reach so far below it", figure(least_hz)),
        );
        section.fault(&k::CARRIER_HZ, Problem::Type { found, allowed });
    }
    let pulse_s = waveform.as_ref().and_then(Waveform::duration_s);
    // What a front end takes, if there is one.
    let wide_hz = waveform.as_ref().and_then(Waveform::bandwidth_hz).filter(|_| dechirped);
    let taken_hz = wide_hz.map(|hz| LEAST_WIDER * hz).into_iter().chain(sample_rate_hz).reduce(f64::max);
    let dechirp = section.section(&k::DECHIRP).and_then(dechirp);
    let shortest_s = pulse_s.filter(|_| !dechirped);
    let window =
        section.section(&k::WINDOW).and_then(|s| window(s, sample_rate_hz, shortest_s, ground, platforms));
    let (window, continuous) = window.unzip();
    let continuous = continuous.unwrap_or(false);
    let known = emitter::Known { transmitters: &transmitter_names, receivers: &receiver_names, platforms };
    let emitters = emitter::emitters(root, ground, &known, (carrier_hz, taken_hz));
    let antennas = Antennas { transmitters: &transmitter_names, receivers: &receiver_names, hears: &hears };
    let channels = channels(&section, &antennas);
    let tx_polarisation = tx_polarisation(&section, channels.as_deref());
    let losses_db = section.number(&k::LOSSES_DB);
    let atmosphere_db_per_km = section.number(&k::ATMOSPHERE_DB_PER_KM);
    let rain_mmph = section.number(&k::RAIN_MMPH);
    if let Some(carrier_hz) = carrier_hz
        && rain_mmph.is_some_and(|rain_mmph| rain_mmph > 0.0)
        && !(CARRIERS_HZ[0]..=CARRIERS_HZ[1]).contains(&carrier_hz)
    {
        let found = format!("radar.carrier_hz = {} Hz", keys::figure(carrier_hz));
        let allowed = "1e9 to 1e12 Hz, or rain_mmph = 0".to_owned();
        section.fault(&k::RAIN_MMPH, Problem::BeyondModel { model: "ITU-R P.838-3", found, allowed });
    }
    let rain_clutter = rain_clutter(&section, carrier_hz, rain_mmph);
    let noise_figure_db = section.number(&k::NOISE_FIGURE_DB);
    let has_adc = section.has(&k::ADC);
    let adc = section.section(&k::ADC).and_then(adc);
    let front_end = match section.section(&k::FRONT_END) {
        Some(table) => front_end::front_end(table, sample_rate_hz),
        None => (!section.has(&k::FRONT_END)).then(FrontEnd::default),
    };
    let gates = front_end.is_some_and(|of| of.stc.is_some() || of.blanked_s.is_some());
    let direct_path = section.flag(&k::DIRECT_PATH);
    let limits = Limits {
        channels: channels.as_deref(),
        window_s: window.as_ref().zip(sample_rate_hz).map(|(window, hz)| window.samples as f64 / hz),
        pulse_s,
        sample_rate_hz,
    };
    *calibration = calibration::calibration(&section, &transmitter_names, &receiver_names, &limits);
    if let (Some(channels), Some(window)) = (&channels, &window) {
        let known = calibration.as_ref().map_or(0, Vec::len);
        check_size(&section, channels.len() + known, window.samples, has_adc);
    }
    plausible::band(&section, waveform.as_ref());
    plausible::intervals(&section, emissions.as_ref(), pulse_s, limits.window_s.filter(|_| !continuous));
    if let (Some(Waveform::Stream { source, .. }), Some(_), false) = (&waveform, &window, continuous) {
        let found = format!("kind = \"{}\" of a radar with windows", source.name());
        let allowed = "gate = \"continuous\" in [radar.window], or an [[emitter]] of this kind".to_owned();
        section.fault(&k::WAVEFORM, Problem::Type { found, allowed });
    }
    if continuous {
        let own_windows = receivers.iter().flatten().any(|receiver| receiver.gate.is_some());
        let known = calibration.as_ref().is_some_and(|list| !list.is_empty());
        refuse_beside(
            &section,
            (&k::WINDOW, "gate = \"continuous\"", "gate = \"windowed\""),
            &[
                (own_windows, "[receiver.window]"),
                (clocks.has_any(), "clock errors of antennas"),
                (known, "[[radar.calibration]]"),
                (matches!(rain_clutter, Some(Some(_))), "rain_clutter"),
                (gates, "stc_full_us or blanking in [radar.front_end]"),
                (front_end.is_some_and(|of| of.agc.is_some()), "agc_level_dbw in [radar.front_end]"),
                (front_end.is_some_and(|of| of.instability.is_some()), "tx_level_rms_db or tx_phase_rms_deg"),
            ],
        );
    }
    let own = transmitters.iter().flatten().map(|of| &of.antenna);
    let beams_jump = own.chain(receivers.iter().flatten().map(|of| &of.antenna)).any(steps::jumps);
    let of_emitter = emitters.iter().flatten().any(|of| steps::jumps(&of.transmitter.antenna));
    refuse_beside(
        &section,
        (&k::PRF_HZ, "a beam that jumps (pointing.kind = \"steps\")", "no such beam"),
        &[
            (beams_jump && continuous, "gate = \"continuous\""),
            (beams_jump && emitters.as_ref().is_some_and(|of| !of.is_empty()), "[[emitter]]"),
            (of_emitter && !beams_jump, "[[emitter]] whose beam it is"),
        ],
    );
    if let Some(emissions) = &emissions {
        let own = transmitters.iter_mut().flatten().map(|of| (of.name.as_str(), &mut of.antenna));
        let others = receivers.iter_mut().flatten().map(|of| (of.name.as_str(), &mut of.antenna));
        steps::dwell(&section, own.chain(others), emissions);
    }
    let known = calibration.as_ref().is_some_and(|list| !list.is_empty());
    let errs = front_end.is_some_and(|of| !of.is_ideal());
    refuse_beside(
        &section,
        (&k::FRONT_END, "a front end that is not ideal", "no front_end"),
        &[(errs && known, "[[radar.calibration]]")],
    );
    if dechirped {
        if let (Some(waveform), Some(rate_hz), Some(window)) = (&waveform, sample_rate_hz, &window) {
            check_dechirp(&section, waveform, rate_hz, window.samples);
        }
        let known = calibration.as_ref().is_some_and(|list| !list.is_empty());
        refuse_beside(
            &section,
            (&k::DECHIRP, "dechirp", "no dechirp"),
            &[
                (continuous, "gate = \"continuous\""),
                (gates, "stc_full_us or blanking in [radar.front_end]"),
                (clocks.has_any(), "clock errors of antennas"),
                (known, "[[radar.calibration]]"),
            ],
        );
    }
    if let Some(channels) = &channels {
        warn_unused(&section, channels, &antennas);
        if tx_polarisation == Some(TxPolarisation::Simultaneous) {
            warn_inseparable(&section, channels, &antennas);
        }
    }
    section.finish();

    if let Some(carrier_hz) = carrier_hz {
        let of_transmitters = transmitters.iter().flatten().map(|tx| (&tx.name, &tx.antenna));
        let of_receivers = receivers.iter().flatten().map(|rx| (&rx.name, &rx.antenna));
        let of_emitters = emitters.iter().flatten().map(|of| (&of.transmitter.name, &of.transmitter.antenna));
        plausible::apertures(root, carrier_hz, of_transmitters.chain(of_receivers).chain(of_emitters));
    }
    let (window, sample_rate_hz) = (window?, sample_rate_hz?);
    let (emissions, sent) = if continuous {
        // Its length was checked.
        (PulseTimes::blocks(window.samples, sample_rate_hz).ok(), Some(emissions?))
    } else {
        (emissions, None)
    };
    Some(Radar {
        carrier_hz: carrier_hz?,
        sample_rate_hz,
        waveform: waveform?,
        dechirp: if dechirped { Some(dechirp?) } else { None },
        emissions: emissions?,
        sent,
        tx_polarisation: tx_polarisation?,
        window,
        losses_db: losses_db?,
        atmosphere_db_per_km: atmosphere_db_per_km?,
        rain_mmph: rain_mmph?,
        rain_clutter: rain_clutter?,
        noise_figure_db,
        front_end: front_end?,
        adc: if has_adc { Some(adc?) } else { None },
        direct_path: direct_path?,
        transmitters: transmitters.into_iter().collect::<Option<_>>()?,
        receivers: receivers.into_iter().collect::<Option<_>>()?,
        channels: channels?,
        emitters: emitters?,
    })
}

/// Faults what cannot be received beside a key: that, what it says, and what it should say instead.
fn refuse_beside(
    section: &Section<'_>,
    (key, says, instead): (&'static Key, &str, &str),
    given: &[(bool, &str)],
) {
    for (_, what) in given.iter().filter(|(given, _)| *given) {
        let (found, allowed) = (format!("{says} beside {what}"), format!("{instead}, or no {what}"));
        section.fault(key, Problem::Type { found, allowed });
    }
}

/// Faults what cannot be dechirped: another waveform than a linear sweep, or more samples of the front end
/// than a transform may have.
fn check_dechirp(section: &Section<'_>, waveform: &Waveform, sample_rate_hz: f64, samples: usize) {
    let (Waveform::Lfm { bandwidth_hz, duration_s, .. } | Waveform::Triangular { bandwidth_hz, duration_s }) =
        waveform
    else {
        let (found, allowed) = match waveform {
            Waveform::Drooping { .. } => ("dechirp of a pulse that droops".to_owned(), "droop_db = 0"),
            _ => (format!("dechirp of waveform.kind = \"{}\"", waveform.kind()), "waveform.kind = \"lfm\""),
        };
        let allowed = allowed.to_owned();
        return section.fault(&keys::radar::DECHIRP, Problem::Type { found, allowed });
    };
    let rate_hz = MOST_WIDER * bandwidth_hz + 4.0 * sample_rate_hz;
    let wide = rate_hz * (duration_s + samples as f64 / sample_rate_hz);
    if wide > LARGEST_FRONT_END {
        let found =
            format!("a pulse and a window of {} samples at the rate of the bandwidth", keys::figure(wide));
        let allowed =
            format!("up to {}: less bandwidth, a shorter pulse or window", keys::figure(LARGEST_FRONT_END));
        section.fault(&keys::radar::DECHIRP, Problem::Type { found, allowed });
    }
}

fn dechirp(section: Section<'_>) -> Option<Dechirp> {
    let delay_us = section.number(&keys::dechirp::DELAY_US);
    section.finish();
    Some(Dechirp { delay_s: delay_us? / 1e6 })
}

/// The echo of rain: `Some(None)` where none is asked for.
fn rain_clutter(
    section: &Section<'_>,
    carrier_hz: Option<f64>,
    rain_mmph: Option<f64>,
) -> Option<Option<RainClutter>> {
    use keys::radar::{RAIN_CLUTTER, RAIN_SPREAD_MPS, RAIN_TOP_M};
    let asked = section.flag(&RAIN_CLUTTER);
    let (top_m, spread_mps) = (section.number(&RAIN_TOP_M), section.number(&RAIN_SPREAD_MPS));
    if !asked? {
        section.idle(&[&RAIN_TOP_M, &RAIN_SPREAD_MPS], "rain_clutter = false");
        return Some(None);
    }
    if rain_mmph == Some(0.0) {
        section.fault(&RAIN_CLUTTER, Problem::Idle { when: "rain_mmph = 0".to_owned() });
    }
    if let Some(carrier_hz) = carrier_hz.filter(|carrier_hz| *carrier_hz > RAYLEIGH_TO_HZ) {
        let found = format!("radar.carrier_hz = {} Hz", keys::figure(carrier_hz));
        let allowed = "up to 20e9 Hz, or rain_clutter = false".to_owned();
        section.fault(&RAIN_CLUTTER, Problem::BeyondModel { model: "Rayleigh scattering", found, allowed });
    }
    Some(Some(RainClutter { top_m: top_m?, spread_mps: spread_mps? }))
}

fn transmitter(
    section: Section<'_>,
    names: &Names,
    ground: &Ground,
    platforms: &Names,
    clocks: &mut Given,
) -> Option<Transmitter> {
    use keys::transmitter as k;
    clocks.take(&section, &k::CLOCK, names.last(), false);
    let power_w = section.number(&k::POWER_W);
    let antenna = antenna::mount(&section, &mount_keys!(transmitter), ground, platforms);
    section.finish();
    Some(Transmitter { name: names.last()?, power_w: power_w?, antenna: antenna? })
}

fn adc(section: Section<'_>) -> Option<Adc> {
    use keys::adc::{BITS, FULL_SCALE_DBW};
    let (bits, full_scale_dbw) = (section.count(&BITS), section.number(&FULL_SCALE_DBW));
    section.finish();
    let full_scale = crate::units::Decibels(full_scale_dbw?).amplitude_ratio();
    Some(Adc { bits: u32::try_from(bits?).ok()?, full_scale })
}

struct Antennas<'n> {
    transmitters: &'n Names,
    receivers: &'n Names,
    /// Transmitters that each receiver hears; `None` where that is faulty.
    hears: &'n [Option<Vec<usize>>],
}

impl Antennas<'_> {
    /// Transmitters that a receiver hears; all where that is faulty, so that nothing else is at fault.
    fn heard_by(&self, receiver: usize) -> Option<&[usize]> {
        self.hears.get(receiver).and_then(Option::as_deref)
    }

    /// Whether a receiver hears a transmitter.
    fn hears(&self, receiver: usize, transmitter: usize) -> bool {
        self.heard_by(receiver).is_none_or(|heard| heard.contains(&transmitter))
    }

    /// Faults a channel of a receiver and a transmitter that it does not hear.
    fn check_heard(&self, section: &Section<'_>, receiver: usize, transmitter: usize) {
        let name = |names: &Names, place: usize| names.names.get(place).cloned().flatten();
        let ends = name(self.receivers, receiver).zip(name(self.transmitters, transmitter));
        if let (false, Some((receiver_name, transmitter))) = (self.hears(receiver, transmitter), ends) {
            let heard = self.heard_by(receiver).unwrap_or_default().iter();
            let heard: Vec<String> = heard.filter_map(|place| name(self.transmitters, *place)).collect();
            let problem = Problem::Unheard { receiver: receiver_name, transmitter, heard: heard.join(", ") };
            section.fault(&keys::channel::TRANSMITTER, problem);
        }
    }

    /// The default name of a channel: `HV`, or `HV-coast-aircraft` where there are several antennas.
    fn channel_name(
        &self,
        rx: Polarisation,
        tx: Polarisation,
        transmitter: usize,
        receiver: usize,
    ) -> String {
        let pair = format!("{}{}", rx.letter(), tx.letter());
        if self.transmitters.names.len() == 1 && self.receivers.names.len() == 1 {
            return pair;
        }
        let name =
            |names: &Names, index: usize| names.names.get(index).cloned().flatten().unwrap_or_default();
        format!("{pair}-{}-{}", name(self.transmitters, transmitter), name(self.receivers, receiver))
    }
}

fn channels(section: &Section<'_>, antennas: &Antennas<'_>) -> Option<Vec<Channel>> {
    use keys::radar::{CHANNEL, CHANNELS};
    let written = section.exactly_one(&[&CHANNELS, &CHANNEL]);
    let pairs = section.words(&CHANNELS, polarisation_pair);
    let rows = section.sections(&CHANNEL);
    if section.has(&CHANNEL) {
        let empty = rows.is_empty();
        let mut names = Names::new("channel");
        let rows: Vec<Option<Channel>> =
            rows.into_iter().map(|row| channel(row, antennas, &mut names)).collect();
        if empty {
            section.fault(&CHANNEL, Problem::NoneOf { keys: "channels, [[radar.channel]]".to_owned() });
            return None;
        }
        written?;
        return rows.into_iter().collect();
    }
    let pairs = pairs?;
    let (mut channels, mut names) = (Vec::new(), Names::new("channel"));
    for transmitter in 0..antennas.transmitters.names.len() {
        let receivers = 0..antennas.receivers.names.len();
        for receiver in receivers.filter(|receiver| antennas.hears(*receiver, transmitter)) {
            for &[rx, tx] in &pairs {
                let name = antennas.channel_name(rx, tx, transmitter, receiver);
                names.enter(section, &CHANNELS, Some(name.clone()), &[]);
                channels.push(Channel { name, transmitter, receiver, tx, rx });
                if channels.len() > 4096 {
                    let count = channels.len() as u64;
                    section.fault(&CHANNELS, Problem::TooMany { count, what: "channels", allowed: 4096 });
                    return None;
                }
            }
        }
    }
    Some(channels)
}

fn channel(section: Section<'_>, antennas: &Antennas<'_>, names: &mut Names) -> Option<Channel> {
    use keys::channel::{NAME, POLARISATION, RECEIVER, TRANSMITTER};
    let polarisations = section.polarisations(&POLARISATION);
    let transmitter = antennas.transmitters.find_among(&section, &TRANSMITTER);
    let receiver = antennas.receivers.find_among(&section, &RECEIVER);
    if let Some((receiver, transmitter)) = receiver.zip(transmitter) {
        antennas.check_heard(&section, receiver, transmitter);
    }
    let default = match (polarisations, transmitter, receiver) {
        (Some([rx, tx]), Some(transmitter), Some(receiver)) => {
            Some(antennas.channel_name(rx, tx, transmitter, receiver))
        }
        _ => None,
    };
    names.take_or(&section, &NAME, default);
    section.finish();
    let [rx, tx] = polarisations?;
    Some(Channel { name: names.last()?, transmitter: transmitter?, receiver: receiver?, tx, rx })
}

fn tx_polarisation(section: &Section<'_>, channels: Option<&[Channel]>) -> Option<TxPolarisation> {
    use keys::radar::{TX_POLARISATION, TX_SEQUENCE};
    let kind = section.choice(&TX_POLARISATION)?;
    let given = section.words(&TX_SEQUENCE, polarisation);
    match kind {
        TxKind::Simultaneous => {
            if section.has(&TX_SEQUENCE) {
                let when = "tx_polarisation = \"simultaneous\"".to_owned();
                section.fault(&TX_SEQUENCE, Problem::Idle { when });
            }
            return Some(TxPolarisation::Simultaneous);
        }
        TxKind::Alternating => {}
    }
    let channels = channels?;
    if !section.has(&TX_SEQUENCE) {
        let mut sequence = Vec::new();
        for channel in channels {
            if !sequence.contains(&channel.tx) {
                sequence.push(channel.tx);
            }
        }
        // No channels means no antennas, which has been reported.
        return (!sequence.is_empty()).then_some(TxPolarisation::Alternating(sequence));
    }
    let sequence = given?;
    for channel in channels.iter().filter(|channel| !sequence.contains(&channel.tx)) {
        let (channel, letter) = (channel.name.clone(), channel.tx.letter());
        section.fault(&TX_SEQUENCE, Problem::NeverSent { channel, letter });
    }
    Some(TxPolarisation::Alternating(sequence))
}

fn check_size(section: &Section<'_>, channels: usize, samples: usize, has_adc: bool) {
    let sample_bytes = if has_adc { 4 } else { 8 };
    let bytes = channels as u128 * samples as u128 * sample_bytes;
    if bytes > LARGEST_PULSE {
        let problem = Problem::PulseSize { bytes, channels, samples: samples as u64, allowed: LARGEST_PULSE };
        section.fault(&keys::radar::WINDOW, problem);
    }
}

/// Transmit polarisations that leave together are H and V, or R and L.
fn warn_inseparable(section: &Section<'_>, channels: &[Channel], antennas: &Antennas<'_>) {
    for (transmitter, name) in antennas.transmitters.names.iter().enumerate() {
        let used = |port: &Polarisation| {
            channels.iter().any(|channel| channel.transmitter == transmitter && channel.tx == *port)
        };
        let linear = [Polarisation::H, Polarisation::V].into_iter().filter(used);
        let circular = [Polarisation::R, Polarisation::L].into_iter().filter(used);
        let (linear, circular): (Vec<_>, Vec<_>) = (linear.collect(), circular.collect());
        if let (false, false, Some(transmitter)) = (linear.is_empty(), circular.is_empty(), name.clone()) {
            let letters = linear.iter().chain(&circular).map(|port| port.letter().to_string());
            let ports = letters.collect::<Vec<_>>().join(", ");
            section.reader().warn(Warning::NotOrthogonal { transmitter, ports });
        }
    }
}

fn warn_unused(section: &Section<'_>, channels: &[Channel], antennas: &Antennas<'_>) {
    let unused = |names: &Names, used: &dyn Fn(&Channel) -> usize| {
        let spare = |index: &usize| !channels.iter().any(|channel| used(channel) == *index);
        let spare: Vec<usize> = (0..names.names.len()).filter(spare).collect();
        spare.into_iter().filter_map(|index| names.names[index].clone()).collect::<Vec<String>>()
    };
    for name in unused(antennas.transmitters, &|channel| channel.transmitter) {
        section.reader().warn(Warning::Unused { what: "transmitter", name });
    }
    for name in unused(antennas.receivers, &|channel| channel.receiver) {
        section.reader().warn(Warning::Unused { what: "receiver", name });
    }
}
