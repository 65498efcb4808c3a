//! The link of a scene before it runs: what antennas gain, what targets return over the noise, where their
//! delays and Doppler shifts lie against the pulse interval.
//!
//! The power of a target in a channel is that of [`crate::radar::link`], with the gains of both antennas
//! where they point and the polarisations of the channel. Then
//!
//! `SNR = P / (k T0 F B_n)` , `SNR_c = P E_2^2 / (k T0 F E_4)` , `E_n = int |P(f)|^2 H^n df`
//!
//! | symbol | meaning |
//! | --- | --- |
//! | `P` | received power at the peak of the pulse, W |
//! | `B_n` | noise bandwidth of the receive filter, Hz |
//! | `P(f)`, `H` | spectrum of the pulse, s; response of the receive filter |
//! | `SNR_c` | after a filter matched to the replica, without a taper; `P Tc / (k T0 F)` for a pulse in band |
//!
//! A target folds where the magnitude of its Doppler shift exceeds half the rate at which a channel has
//! pulses: the PRF, less where transmit polarisations alternate. Pulses in the air are emissions that have
//! left before the echo of the first of them returns.
//!
//! Limits: mean cross sections (no fluctuation, the mean of a table by aspect), free space (no multipath, no
//! waves, no land; the curve of the earth hides a target). Receive antennas are taken at the emission.
//! Between the pulses that are looked at, [`FEWEST`] to [`MOST`], a narrow beam may pass unseen.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use serde::Serialize;

use super::description::{Described, described};
use super::pulse_length::seconds_of_pulse;
use crate::frames::{Earth, Vector};
use crate::geometry::bistatic::Basis;
use crate::geometry::horizon;
use crate::geometry::light_time::{LightTime, Path, bistatic};
use crate::motion::pointing::PhaseCentre;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::prepared::{Moment, Prepared};
use crate::radar::antenna::Antenna;
use crate::radar::fault::{RadarError, RadarFault, mounts};
use crate::radar::filter::ReceiveFilter;
use crate::radar::link::Link;
use crate::radar::pattern::{GridPattern, Quantity};
use crate::radar::polarisation::{PortBasis, field};
use crate::radar::receiver::thermal_noise_w;
use crate::scattering::target::Scatterer;
use crate::scene::Target;
use crate::scene::radar::{AntennaMount, Channel, Pair, Pointing, PolarisationBasis, Radar, TxPolarisation};
use crate::units::{Decibels, SPEED_OF_LIGHT_MPS};

/// Targets of a budget; those behind them are counted.
pub const MOST_TARGETS: usize = 256;
/// Pulses looked at: at least.
pub const FEWEST: u64 = 33;
/// Pulses looked at: at most.
pub const MOST: u64 = 257;
/// Paths that are evaluated, if [`FEWEST`] lets it: what the budget costs.
const PATHS: u64 = 8192;
/// Targets that the text names.
const MOST_NAMED: usize = 12;

/// The link of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkBudget {
    /// Transmitters, then receivers.
    pub antennas: Vec<AntennaBudget>,
    /// Noise of a sample, dBW; `None` without noise.
    pub noise_dbw: Option<f64>,
    /// What compression adds to the SNR of a sample, dB.
    pub compression_db: f64,
    /// Mean rate at which a channel has pulses, Hz: the least of all channels.
    pub prf_hz: f64,
    /// Pulses that leave in turn; 1 where all are alike.
    pub turns: usize,
    /// Largest Doppler shift that does not fold, Hz.
    pub doppler_limit_hz: f64,
    /// Shortest interval between pulses, us: a longer delay means several pulses in the air.
    pub interval_us: f64,
    /// Length of a path of this delay, m.
    pub unambiguous_path_m: f64,
    /// Targets, in their order.
    pub targets: Vec<TargetBudget>,
    /// Targets that are left out.
    pub more_targets: usize,
}

/// An antenna.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AntennaBudget {
    /// The transmitter or receiver.
    pub antenna: String,
    /// The platform that carries it.
    pub platform: String,
    /// Gain on the boresight, dBi; `None` where there is none.
    pub gain_dbi: Option<f64>,
    /// Width between the points of half the power on the boresight, degrees: azimuth, elevation. `None` where
    /// it does not fall so far.
    pub beamwidth_deg: [Option<f64>; 2],
}

/// A target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TargetBudget {
    /// Its name.
    pub target: String,
    /// The most received of it, dBW; `None` where nothing is.
    pub power_dbw: Option<f64>,
    /// Channel that receives it.
    pub channel: Option<String>,
    /// Pulse at which it does.
    pub pulse: Option<u64>,
    /// Over the noise of a sample, dB.
    pub snr_db: Option<f64>,
    /// Over the noise after compression, dB.
    pub compressed_snr_db: Option<f64>,
    /// Least and greatest delay, us.
    pub delay_us: [f64; 2],
    /// Least and greatest Doppler shift, Hz.
    pub doppler_hz: [f64; 2],
    /// Whether any of it lies beyond [`LinkBudget::doppler_limit_hz`].
    pub folds: bool,
    /// Pulses in the air at its longest delay, its own among them.
    pub pulses_in_air: u64,
}

/// The link of a run.
///
/// # Errors
/// Patterns, waveforms and tables of cross sections that cannot be read; tracks that end before the run.
pub fn link_budget(prepared: &Prepared) -> Result<LinkBudget, BuildErrors> {
    let scene = prepared.scene();
    let radar = &scene.radar;
    let waveform = prepared.waveform()?;
    let antennas = open_all(radar)?;
    let noise_bandwidth_hz = ReceiveFilter::new(radar.sample_rate_hz).noise_bandwidth_hz();
    let noise_w = radar.noise_figure_db.map(|db| thermal_noise_w(noise_bandwidth_hz, Decibels(db)));
    let prf_hz = radar.sends().mean_prf_hz() * least_share(radar);
    let interval_s = radar.sends().shortest_pri_s();
    let mut budget = LinkBudget {
        antennas: mounts(radar)
            .zip(&antennas)
            .map(|((name, mount), antenna)| AntennaBudget {
                antenna: name.to_owned(),
                platform: scene.platforms[mount.platform].clone(),
                gain_dbi: decibels(power(antenna, DVec3::X)),
                beamwidth_deg: [DVec3::Y, DVec3::Z].map(|axis| beamwidth_deg(antenna, axis)),
            })
            .collect(),
        noise_dbw: noise_w.and_then(decibels),
        compression_db: Decibels::from_power_ratio(
            seconds_of_pulse(waveform.as_ref(), radar) * noise_bandwidth_hz,
        )
        .0,
        prf_hz,
        turns: radar.waveform.turns(),
        doppler_limit_hz: 0.5 * prf_hz,
        interval_us: 1e6 * interval_s,
        unambiguous_path_m: SPEED_OF_LIGHT_MPS * interval_s,
        targets: Vec::new(),
        more_targets: scene.targets.len().saturating_sub(MOST_TARGETS),
    };
    let sights = Sights { prepared, antennas: &antennas };
    for (target, seen) in scene.targets.iter().zip(sights.of_targets()?) {
        let most = seen.most.filter(|most| most.power_w > 0.0);
        let power_dbw = most.and_then(|most| decibels(most.power_w));
        let snr_db = power_dbw.zip(budget.noise_dbw).map(|(power, noise)| power - noise);
        budget.targets.push(TargetBudget {
            target: target.name.clone(),
            power_dbw,
            channel: most.map(|most| radar.channels[most.channel].name.clone()),
            pulse: most.map(|most| most.pulse),
            snr_db,
            compressed_snr_db: snr_db.map(|snr| snr + budget.compression_db),
            delay_us: seen.delay_s.map(|s| 1e6 * s),
            doppler_hz: seen.doppler_hz,
            folds: seen.doppler_hz.iter().any(|hz| hz.abs() > budget.doppler_limit_hz),
            pulses_in_air: 1 + (seen.delay_s[1] / interval_s) as u64,
        });
    }
    Ok(budget)
}

/// The antennas of a radar, transmitters first.
pub(super) fn open_all(radar: &Radar) -> Result<Vec<Antenna>, RadarError> {
    let open = |(name, mount): (&str, &AntennaMount)| {
        Antenna::open(&mount.pattern, radar.wavelength_m()).map_err(|source| {
            RadarError::Faults(vec![RadarFault::Pattern { antenna: name.to_owned(), source }])
        })
    };
    mounts(radar).map(open).collect()
}

pub(super) fn decibels(ratio: f64) -> Option<f64> {
    (ratio > 0.0 && ratio.is_finite()).then(|| Decibels::from_power_ratio(ratio).0)
}

pub(super) fn power(antenna: &Antenna, direction: DVec3) -> f64 {
    antenna.field_gain(Vector::from_raw(direction)).norm_sqr()
}

/// Least share of the pulses that a channel has; where several leave in turn, of one of these.
fn least_share(radar: &Radar) -> f64 {
    let (cycle, turns) = (radar.cycle(), radar.waveform.turns());
    let TxPolarisation::Alternating(sequence) = &radar.tx_polarisation else { return 1.0 / turns as f64 };
    // Place i of the sequence and waveform k meet once in a cycle where both leave the same rest, else never.
    let common = (sequence.len() * turns / cycle.max(1) as usize).max(1);
    let share = |channel: &Channel| {
        let mut places = vec![0u64; common];
        for (place, _) in sequence.iter().enumerate().filter(|(_, port)| **port == channel.tx) {
            places[place % common] += 1;
        }
        places.into_iter().filter(|count| *count > 0).min().unwrap_or(0) as f64 / cycle as f64
    };
    radar.channels.iter().map(share).fold(1.0, f64::min)
}

/// Width of the main lobe between half of the power on the boresight, towards an axis and away from it.
fn beamwidth_deg(antenna: &Antenna, axis: DVec3) -> Option<f64> {
    let half = 0.5 * power(antenna, DVec3::X);
    if half == 0.0 || matches!(antenna, Antenna::Isotropic { .. }) {
        return None;
    }
    let falls_at = |axis: DVec3| {
        let above = |rad: f64| power(antenna, DVec3::X * rad.cos() + axis * rad.sin()) > half;
        let mut low = 1e-6;
        while above(low) {
            let high = 1.05 * low;
            if high > PI {
                return None;
            }
            if !above(high) {
                let [mut inside, mut outside] = [low, high];
                for _ in 0..40 {
                    let middle = 0.5 * (inside + outside);
                    if above(middle) { inside = middle } else { outside = middle }
                }
                return Some(inside);
            }
            low = high;
        }
        None
    };
    Some((falls_at(axis)? + falls_at(-axis)?).to_degrees())
}

/// What is received most of a target.
#[derive(Clone, Copy)]
struct Strongest {
    power_w: f64,
    channel: usize,
    pulse: u64,
}

/// A target over the run.
struct Seen {
    most: Option<Strongest>,
    delay_s: [f64; 2],
    doppler_hz: [f64; 2],
}

/// An antenna at a pulse.
pub(super) struct Stood {
    pub(super) centre: PhaseCentre,
    pub(super) axes: DMat3,
    pub(super) basis: PortBasis,
}

pub(super) struct Sights<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) antennas: &'a [Antenna],
}

impl Sights<'_> {
    fn of_targets(&self) -> Result<Vec<Seen>, BuildErrors> {
        let (scene, radar) = (self.prepared.scene(), &self.prepared.scene().radar);
        let targets = scene
            .targets
            .iter()
            .take(MOST_TARGETS)
            .map(with_mean_of_table)
            .collect::<Result<Vec<Target>, _>>()?;
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let mut seen: Vec<Seen> =
            targets.iter().map(|_| Seen { most: None, delay_s: none, doppler_hz: none }).collect();
        let pairs = radar.pairs();
        let paths = (targets.len() * pairs.len()) as u64;
        if paths == 0 || scene.pulses == 0 {
            return Ok(Vec::new());
        }
        for moment in self.prepared.spread((PATHS / paths).clamp(FEWEST, MOST)) {
            let stood = stand(moment, radar)?;
            for (target, seen) in targets.iter().zip(&mut seen) {
                let at = Scatterer::at(target, moment.elapsed_s);
                for pair in &pairs {
                    let (path, powers) = self.of_pair(&stood, *pair, &at);
                    widen(&mut seen.delay_s, path.delay_s);
                    widen(&mut seen.doppler_hz, path.doppler_hz(radar.carrier_hz));
                    for (channel, power_w) in powers {
                        if seen.most.is_none_or(|most| power_w > most.power_w) {
                            seen.most = Some(Strongest { power_w, channel, pulse: moment.pulse });
                        }
                    }
                }
            }
        }
        Ok(seen)
    }

    /// The path of a pair over a scatterer, and its powers in channels, W; none where the earth hides it.
    pub(super) fn of_pair(
        &self,
        stood: &[Stood],
        pair: Pair,
        at: &Scatterer<'_>,
    ) -> (Path, Vec<(usize, f64)>) {
        let scene = self.prepared.scene();
        let ends = [pair.transmitter, scene.radar.transmitters.len() + pair.receiver];
        let [tx, rx] = ends.map(|end| &stood[end]);
        let path = bistatic(LightTime::Exact, &tx.centre, at.position, at.velocity, &rx.centre);
        let earth = scene.frame.hiding_earth();
        let hidden = |end: &Stood| horizon::clearance_m(earth, end.centre.position, at.position) < 0.0;
        if earth != Earth::Flat && (hidden(tx) || hidden(rx)) {
            return (path, Vec::new());
        }
        (path, self.powers(pair, ends, [tx, rx], &path, at))
    }

    /// Powers of a path in the channels of its pair, W.
    fn powers(
        &self,
        pair: Pair,
        ends: [usize; 2],
        [tx, rx]: [&Stood; 2],
        path: &Path,
        at: &Scatterer<'_>,
    ) -> Vec<(usize, f64)> {
        let radar = &self.prepared.scene().radar;
        let (transmitter, receiver) =
            (&radar.transmitters[pair.transmitter], &radar.receivers[pair.receiver]);
        let link = Link::of(radar, pair.transmitter);
        let (sent, back) = (path.incident, -path.scattered);
        let gain = |end: usize, of: &Stood, d: DVec3| power(&self.antennas[end], of.axes.transpose() * d);
        let scale = link.scattered_over(path).powi(2) * gain(ends[0], tx, sent) * gain(ends[1], rx, back);
        let [basis_in, basis_out] = [sent, path.scattered].map(Basis::of);
        let s = at.matrix;
        let of = |(_, channel): &(usize, &Channel)| {
            channel.transmitter == pair.transmitter && channel.receiver == pair.receiver
        };
        let channels = radar.channels.iter().enumerate().filter(of);
        channels
            .map(|(place, channel)| {
                let errors = [&transmitter.antenna, &receiver.antenna].map(|of| of.ports);
                let e_t = field(&tx.basis, channel.tx, errors[0], sent, &basis_in);
                let e_r = field(&rx.basis, channel.rx, errors[1], back, &basis_out);
                let returned = e_r[0] * (s[0][0] * e_t[0] + s[0][1] * e_t[1])
                    + e_r[1] * (s[1][0] * e_t[0] + s[1][1] * e_t[1]);
                let rain = link.in_rain_over([channel.tx, channel.rx], path);
                (place, scale * returned.norm_sqr() * (rain * rain))
            })
            .collect()
    }
}

/// All antennas of a radar at a pulse, transmitters first.
pub(super) fn stand(at: Moment<'_>, radar: &Radar) -> Result<Vec<Stood>, BuildErrors> {
    let of = |(_, mount): (&str, &AntennaMount)| {
        let (centre, frame) = at.antenna(mount)?;
        let axes = DMat3::from_quat(frame.raw());
        let up = at.scene().frame.earth().up(centre.position).raw();
        let basis = PortBasis::of(PolarisationBasis::of(&mount.pattern), axes, up);
        Ok(Stood { centre, axes, basis })
    };
    mounts(radar).map(of).collect()
}

fn widen(span: &mut [f64; 2], value: f64) {
    *span = [span[0].min(value), span[1].max(value)];
}

/// A target with the mean cross section of its table, if it has one.
pub(super) fn with_mean_of_table(target: &Target) -> Result<Target, RadarError> {
    let mut target = target.clone();
    if let Some(aspect) = target.aspect.take() {
        let table = GridPattern::open_as(Quantity::CrossSection, &aspect.path, aspect.floor_dbsm);
        let table = table.map_err(|source| {
            RadarError::Faults(vec![RadarFault::Aspect { target: target.name.clone(), source }])
        })?;
        target.scattering = Target::sphere(table.mean_power());
    }
    Ok(target)
}

impl LinkBudget {
    /// A warning where no target returns anything.
    pub fn warning(&self, radar: &Radar) -> Option<String> {
        let scans = |mount: &AntennaMount| matches!(mount.pointing, Pointing::Scan(_));
        let dark = !self.targets.is_empty() && self.targets.iter().all(|target| target.power_dbw.is_none());
        // One that scans may pass over them between the instants that are looked at.
        (dark && !mounts(radar).any(|(_, mount)| scans(mount))).then(|| {
            "no target returns anything: none lies in front of both antennas with a cross section and power".to_owned()
        })
    }
}

/// The same in words.
pub fn rows(budget: &LinkBudget) -> Vec<Described> {
    let mut rows: Vec<Described> =
        budget.antennas.iter().map(|of| described(&of.antenna, antenna_text(of))).collect();
    if let Some(noise_dbw) = budget.noise_dbw {
        rows.push(described("noise", format!("{noise_dbw:.1} dBW per sample")));
    }
    rows.push(described(
        "pulses",
        format!(
            "Doppler folds beyond +-{} Hz (a channel has {} pulses/s{}); ranges are ambiguous beyond a delay of {} us, a path of {} km",
            figure(budget.doppler_limit_hz),
            figure(budget.prf_hz),
            if budget.turns > 1 { " of each waveform" } else { "" },
            figure(budget.interval_us),
            figure(1e-3 * budget.unambiguous_path_m)
        ),
    ));
    rows.extend(
        budget.targets.iter().take(MOST_NAMED).map(|of| described(&of.target, target_text(of, budget))),
    );
    let more = budget.targets.len().saturating_sub(MOST_NAMED) + budget.more_targets;
    if more > 0 {
        let folding = budget.targets.iter().skip(MOST_NAMED).filter(|of| of.folds).count();
        let some = if folding > 0 { format!(", {folding} of which fold") } else { String::new() };
        rows.push(described("more targets", format!("{more}{some}; --json has up to {MOST_TARGETS}")));
    }
    rows
}

fn antenna_text(of: &AntennaBudget) -> String {
    let gain = of.gain_dbi.map_or_else(
        || "no gain on the boresight".to_owned(),
        |gain_dbi| format!("{gain_dbi:.1} dBi on the boresight"),
    );
    let width = |deg: f64| format!("{} deg", figure(deg));
    let beam = match of.beamwidth_deg {
        [None, None] => ", no 3 dB beamwidth".to_owned(),
        of => {
            let [az, el] = of.map(|deg| deg.map_or_else(|| "all around".to_owned(), width));
            format!(", 3 dB beamwidth {az} in azimuth, {el} in elevation")
        }
    };
    format!("{gain}{beam}; on {}", of.platform)
}

fn target_text(of: &TargetBudget, budget: &LinkBudget) -> String {
    let level = match (of.power_dbw, &of.channel, of.pulse) {
        (Some(power_dbw), Some(channel), Some(pulse)) => {
            let snr = of.snr_db.zip(of.compressed_snr_db).map_or_else(String::new, |(sample, compressed)| {
                format!(": SNR {sample:.1} dB per sample, {compressed:.1} dB compressed")
            });
            format!("{power_dbw:.1} dBW at most (in {channel}, pulse {pulse}){snr}")
        }
        _ => "nothing is received".to_owned(),
    };
    let span = |[from, to]: [f64; 2]| {
        let [from, to] = [from, to].map(figure);
        if from == to { from } else { format!("{from} to {to}") }
    };
    let mut text = format!("{level}; delay {} us; Doppler {} Hz", span(of.delay_us), span(of.doppler_hz));
    if of.folds {
        text += &format!(", folds at +-{} Hz", figure(budget.doppler_limit_hz));
    }
    if of.pulses_in_air > 1 {
        text += &format!("; {} pulses in the air", of.pulses_in_air);
    }
    text
}

/// Four digits, or all before the point.
fn figure(value: f64) -> String {
    let size = value.abs();
    let decimals = if size > 0.0 { (3 - size.log10().floor() as i64).clamp(0, 3) as usize } else { 0 };
    // Without the sign of a zero.
    let text = format!("{:.decimals$}", if size < 5e-4 { 0.0 } else { value });
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use std::path::Path as FilePath;

    use super::*;
    use crate::config;

    /// A cliff and an aircraft that passes a buoy of 10 m^2.
    const BUOY: &str = r#"
        scene = { duration_s = 2.0 }
        target = [{ name = "buoy", position_m = [0, 0, 2], rcs_m2 = 10 }]
        radar = { carrier_hz = 10e9, sample_rate_hz = 40e6, prf_hz = 222.0, channels = ["HH", "VV"], noise_figure_db = 3.0, waveform = { kind = "lfm", bandwidth_hz = 25e6, pulse_s = 1e-6 }, window = { samples = 128, start_us = 18.8 } }
        [[platform]]
        name = "cliff"
        track = { kind = "fixed", position_m = [3000, 0, 100] }
        [[platform]]
        name = "aircraft"
        track = { kind = "straight", position_m = [2000, -100, 2000], velocity_mps = [0, 100, 0] }
        [[transmitter]]
        name = "tx"
        platform = "cliff"
        power_w = 1000.0
        antenna = { kind = "rectangle", width_m = 1.0, height_m = 0.1 }
        pointing = { kind = "at", position_m = [0, 0, 2] }
        [[receiver]]
        name = "rx"
        platform = "aircraft"
        antenna = { kind = "rectangle", width_m = 0.5, height_m = 0.1 }
        pointing = { kind = "at", position_m = [0, 0, 2] }
    "#;

    fn budget(overrides: &[(&str, &str)]) -> LinkBudget {
        let overrides: Vec<_> =
            overrides.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        link_budget(
            &Prepared::of(&config::parse(BUOY, FilePath::new("buoy.toml"), &overrides).unwrap()).unwrap(),
        )
        .unwrap()
    }

    #[test]
    fn the_radar_equation_by_hand() {
        let found = budget(&[]);
        let (c, lambda) = (299_792_458.0, 299_792_458.0 / 10e9);
        // Abeam, at pulse 222: R_t from the cliff, R_r to the aircraft; at the first pulse 100 m before.
        let (r_t, r_r) = (3000f64.hypot(98.0), 2000f64.hypot(1998.0));
        let first_r = r_r.hypot(100.0);
        // G = 4 pi a b / lambda^2 on both boresights.
        let gains = (4.0 * PI / (lambda * lambda)).powi(2) * (1.0 * 0.1) * (0.5 * 0.1);
        let power_w = 1000.0 * lambda * lambda * gains * 10.0 / ((4.0 * PI).powi(3) * (r_t * r_r).powi(2));
        let per_hz = 1.380_649e-23 * 290.0 * 10f64.powf(0.3);
        let db = |ratio: f64| 10.0 * ratio.log10();
        let buoy = &found.targets[0];
        let near =
            |found: f64, hand: f64, within: f64| assert!((found - hand).abs() < within, "{found} {hand}");
        // A pulse beside the one abeam: less than 1e-4 dB.
        near(buoy.power_dbw.unwrap(), db(power_w), 1e-3);
        near(found.noise_dbw.unwrap(), db(per_hz * 35e6), 1e-9);
        near(buoy.snr_db.unwrap(), db(power_w / (per_hz * 35e6)), 1e-3);
        // The filter takes 0.06 dB from the edges of a spectrum of 25 MHz and 1 us.
        near(buoy.compressed_snr_db.unwrap(), db(power_w * 1e-6 / per_hz), 0.1);
        // Light time moves the aircraft by 1 mm.
        near(buoy.delay_us[0], 1e6 * (r_t + r_r) / c, 1e-5);
        near(buoy.delay_us[1], 1e6 * (r_t + first_r) / c, 1e-5);
        near(buoy.doppler_hz[1], 100.0 * 100.0 / first_r / lambda, 1e-2);
        assert!(buoy.doppler_hz[0] < -115.0 && buoy.folds && buoy.pulses_in_air == 1);
        assert_eq!((found.doppler_limit_hz, buoy.channel.as_deref()), (111.0, Some("HH")));
        // Half power of a uniform aperture: sin x / x = 1/sqrt 2 at x = 1.391557, u = x lambda / (pi a).
        for (of, sides_m) in found.antennas.iter().zip([[1.0, 0.1], [0.5, 0.1]]) {
            near(of.gain_dbi.unwrap(), db(4.0 * PI * sides_m[0] * sides_m[1] / (lambda * lambda)), 1e-9);
            for (deg, side_m) in of.beamwidth_deg.iter().zip(sides_m) {
                near(deg.unwrap(), 2.0 * (1.391_557 * lambda / (PI * side_m)).asin().to_degrees(), 1e-4);
            }
        }
    }

    #[test]
    fn rates_that_fold_and_pulses_in_the_air() {
        // 12.5 us between pulses, and delays of 19.4 us.
        let fast =
            budget(&[("radar.prf_hz", "80e3"), ("radar.window.samples", "48"), ("scene.duration_s", "0.1")]);
        assert!(!fast.targets[0].folds && fast.targets[0].pulses_in_air == 2);
        assert!((fast.unambiguous_path_m - 3_747.405_725).abs() < 1e-6);
        let quick = budget(&[("radar.prf_hz", "300")]);
        assert!(!quick.targets[0].folds);
        // Each polarisation has every other pulse.
        let turns = budget(&[("radar.prf_hz", "300"), ("radar.tx_polarisation", "alternating")]);
        assert!(turns.targets[0].folds && turns.doppler_limit_hz == 75.0);
    }

    #[test]
    fn what_is_not_received_and_a_receiver_without_noise() {
        let isotropic = [("receiver.0.antenna", "{ kind = 'isotropic' }")];
        let found = budget(&isotropic);
        assert_eq!((found.antennas[1].gain_dbi, found.antennas[1].beamwidth_deg), (Some(0.0), [None, None]));
        let away = ("receiver.0.pointing", "{ kind = 'fixed', pitch_deg = 60 }");
        let dark = budget(&[away]);
        assert_eq!((dark.targets[0].power_dbw, dark.targets[0].snr_db), (None, None));
        let text = |budget: &LinkBudget| {
            rows(budget).iter().map(|row| format!("{}: {}", row.what, row.how)).collect::<Vec<_>>().join("\n")
        };
        assert!(text(&found).contains("rx: 0.0 dBi on the boresight, no 3 dB beamwidth; on aircraft"));
        let course = "delay 19.44 to 19.45 us; Doppler -117.4 to 117.9 Hz, folds at +-111 Hz";
        assert!(text(&dark).ends_with(&format!("buoy: nothing is received; {course}")), "{}", text(&dark));
        let level = "-102.1 dBW at most (in HH, pulse 221): SNR 23.4 dB per sample, 38.8 dB compressed";
        assert!(text(&budget(&[])).ends_with(&format!("buoy: {level}; {course}")), "{}", text(&budget(&[])));
    }
}
