//! What receivers get of emitters straight, before a run: the level of the direct path in the middle of it.
//!
//! `J = P g_t^2 g_r^2 (lambda / (4 pi R))^2 / L  |e_r . e_t|^2  E_f / T` ,
//! `E_f = int |P(f)|^2 H(f + df)^2 df`
//!
//! | symbol | meaning |
//! | --- | --- |
//! | `J` | mean power in a channel while a pulse lasts, W; losses `L`, air and rain as in [`crate::radar::link`] |
//! | `P(f)`, `T` | spectrum (s) and length (s) of the pulse |
//! | `H`, `df` | response of the receive filter; carrier of the emitter above that of the radar, Hz |
//!
//! Limits: those of [`super::link_budget`]; one instant, whether a pulse leaves then or not. A waveform that
//! varies has samples above its mean power.

use glam::DVec3;
use serde::Serialize;

use super::description::{Described, described};
use super::link_budget::{MOST_TARGETS, Sights, decibels, open_all, power, stand, with_mean_of_table};
use crate::frames::Earth;
use crate::geometry::bistatic::Basis;
use crate::geometry::horizon;
use crate::geometry::light_time::{LightTime, direct};
use crate::paths::scene_of;
use crate::pipeline::fault::BuildErrors;
use crate::pipeline::prepared::{Moment, Prepared};
use crate::radar::filter::ReceiveFilter;
use crate::radar::link::Link;
use crate::radar::polarisation::field;
use crate::radar::receiver::thermal_noise_w;
use crate::radar::waveform::{self, Waveform, pulses};
use crate::scattering::target::Scatterer;
use crate::units::{Decibels, SPEED_OF_LIGHT_MPS};

/// Lobes of the spectrum of a plain pulse that are looked at, beyond its band: without 0.01 % of its energy.
const LOBES: f64 = 1024.0;
/// Frequencies at which it is taken, at most.
const MOST_FREQUENCIES: f64 = 1e6;

/// An emitter at a receiver that takes its direct path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EmitterBudget {
    /// Its name.
    pub emitter: String,
    /// The receiver.
    pub receiver: String,
    /// The channel of that receiver that has most of it.
    pub channel: String,
    /// Its level there while a pulse lasts, dBW; `None` where nothing is received.
    pub power_dbw: Option<f64>,
    /// Over the noise of a sample, dB.
    pub over_noise_db: Option<f64>,
    /// Over the echo of the target that the receiver gets most of at the same instant, dB.
    pub over_echo_db: Option<f64>,
    /// Over the amplitude that fills the converter, dB.
    pub over_full_scale_db: Option<f64>,
}

/// The direct paths of a run's emitters.
///
/// # Errors
/// Patterns and waveforms that cannot be read, tracks that do not reach to the middle of the run.
pub fn emitter_budgets(prepared: &Prepared) -> Result<Vec<EmitterBudget>, BuildErrors> {
    let scene = prepared.scene();
    let radar = &scene.radar;
    let mut budgets = Vec::new();
    if radar.emitters.is_empty() || scene.pulses == 0 {
        return Ok(budgets);
    }
    let moment = prepared.at(scene.pulses / 2);
    let antennas = open_all(radar)?;
    let echoes_w = strongest_echoes(&Sights { prepared, antennas: &antennas }, moment)?;
    let filter = ReceiveFilter::new(radar.sample_rate_hz);
    let noise_w = radar.noise_figure_db.map(|db| thermal_noise_w(filter.noise_bandwidth_hz(), Decibels(db)));
    for emitter in radar.emitters.iter().filter(|emitter| emitter.direct_path) {
        let own = scene_of(scene, emitter, [0.0; 2]).radar;
        let waveform = waveform::from_description(&emitter.waveform)?;
        let offset_hz = emitter.carrier_hz - radar.carrier_hz;
        let passes = passing(waveform.as_ref(), offset_hz, &filter, radar.sample_rate_hz);
        let (antennas, stood) = (open_all(&own)?, stand(moment, &own)?);
        let sender = radar.transmitters.len();
        let link = Link::of(&own, sender);
        for (place, receiver) in emitter.receivers.iter().filter_map(|n| Some((*n, own.receivers.get(*n)?))) {
            let ends = [sender, own.transmitters.len() + place];
            let [tx, rx] = ends.map(|end| &stood[end]);
            let path = direct(LightTime::Exact, &tx.centre, &rx.centre);
            let (sent, back) = (path.incident, -path.scattered);
            let gain = |end: usize, d: DVec3| power(&antennas[end], stood[end].axes.transpose() * d);
            let earth = scene.frame.hiding_earth();
            let hidden = earth != Earth::Flat
                && horizon::clearance_m(earth, tx.centre.position, rx.centre.position) < 0.0;
            let lit = if hidden { 0.0 } else { link.direct(path.delay_s * SPEED_OF_LIGHT_MPS).powi(2) };
            let scale = lit * passes * gain(ends[0], sent) * gain(ends[1], back);
            let basis = Basis::of(sent);
            let level_w = |rx_port| {
                let ends = [&emitter.transmitter.antenna, &receiver.antenna];
                let [errors_t, errors_r] = ends.map(|of| of.ports);
                let e_t = field(&tx.basis, emitter.polarisation, errors_t, sent, &basis);
                let e_r = field(&rx.basis, rx_port, errors_r, back, &basis);
                let rain = link.in_rain_direct([emitter.polarisation, rx_port], &path);
                scale * (e_r[0] * e_t[0] + e_r[1] * e_t[1]).norm_sqr() * (rain * rain)
            };
            let channels = own.channels.iter().filter(|channel| channel.receiver == place);
            let levels = channels.map(|channel| (level_w(channel.rx), channel));
            let Some((most_w, channel)) = levels.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
            let over = |reference_w: f64| decibels(most_w / reference_w);
            budgets.push(EmitterBudget {
                emitter: emitter.transmitter.name.clone(),
                receiver: receiver.name.clone(),
                channel: channel.name.clone(),
                power_dbw: decibels(most_w),
                over_noise_db: noise_w.and_then(over),
                over_echo_db: echoes_w.get(place).copied().and_then(over),
                over_full_scale_db: radar.adc.and_then(|adc| over(adc.full_scale.powi(2))),
            });
        }
    }
    Ok(budgets)
}

/// What every receiver gets of the target that it gets most of, W.
fn strongest_echoes(sights: &Sights<'_>, at: Moment<'_>) -> Result<Vec<f64>, BuildErrors> {
    let (scene, radar) = (at.scene(), &at.scene().radar);
    let (stood, pairs) = (stand(at, radar)?, radar.pairs());
    let mut most_w = vec![0.0f64; radar.receivers.len()];
    for target in scene.targets.iter().take(MOST_TARGETS) {
        let target = with_mean_of_table(target)?;
        let scatterer = Scatterer::at(&target, at.elapsed_s);
        for pair in &pairs {
            for (_, power_w) in sights.of_pair(&stood, *pair, &scatterer).1 {
                most_w[pair.receiver] = most_w[pair.receiver].max(power_w);
            }
        }
    }
    Ok(most_w)
}

/// `E_f / T`: what the receive filter leaves of the power of a pulse; of pulses in turn, the mean.
fn passing(waveform: &dyn Waveform, offset_hz: f64, filter: &ReceiveFilter, sample_rate_hz: f64) -> f64 {
    let all = pulses(waveform);
    let of = |pulse: &&dyn Waveform| one_passing(*pulse, offset_hz, filter, sample_rate_hz);
    all.iter().map(of).sum::<f64>() / all.len() as f64
}

/// The same of one pulse.
fn one_passing(waveform: &dyn Waveform, offset_hz: f64, filter: &ReceiveFilter, sample_rate_hz: f64) -> f64 {
    let (duration_s, band, lobes_hz) = (waveform.duration_s(), waveform.band(), LOBES * waveform.lobe_hz());
    let from_hz = (band.from_hz - lobes_hz).max(-0.5 * sample_rate_hz - offset_hz);
    let band_hz = (band.to_hz + lobes_hz).min(0.5 * sample_rate_hz - offset_hz) - from_hz;
    if band_hz <= 0.0 {
        return 0.0;
    }
    // The squared spectrum is that of an autocorrelation of length 2 T.
    let count = (4.0 * duration_s * band_hz).clamp(4096.0, MOST_FREQUENCIES).ceil();
    let step_hz = band_hz / count;
    let density = |k: usize| {
        let f_hz = from_hz + (k as f64 + 0.5) * step_hz;
        waveform.spectrum(f_hz).norm_sqr() * filter.response(f_hz + offset_hz).powi(2)
    };
    (0..count as usize).map(density).sum::<f64>() * step_hz / duration_s
}

/// The same in words.
pub fn rows(budgets: &[EmitterBudget]) -> Vec<Described> {
    let row = |of: &EmitterBudget| {
        let how = match of.power_dbw {
            None => "nothing is received".to_owned(),
            Some(power_dbw) => {
                let over = [
                    (of.over_noise_db, "the noise of a sample"),
                    (of.over_echo_db, "the strongest target"),
                    (of.over_full_scale_db, "full scale"),
                ];
                let over =
                    over.into_iter().filter_map(|(db, what)| Some(format!(", {:.1} dB over {what}", db?)));
                format!("{power_dbw:.1} dBW in {}{}", of.channel, over.collect::<String>())
            }
        };
        described(&format!("{} at {}", of.emitter, of.receiver), how)
    };
    budgets.iter().map(row).collect()
}

/// Emitters that saturate the converter.
pub fn warnings(budgets: &[EmitterBudget]) -> impl Iterator<Item = String> {
    budgets.iter().filter_map(|of| {
        let over_db = of.over_full_scale_db.filter(|db| *db > 0.0)?;
        Some(format!(
            "emitter \"{}\" reaches channel {} of \"{}\" {over_db:.1} dB above the full scale of radar.adc at mid-run: samples that \
             receive it saturate; a full_scale_dbw of {:.1} would hold it",
            of.emitter,
            of.channel,
            of.receiver,
            of.power_dbw?
        ))
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::path::Path;

    use super::*;
    use crate::config;

    /// A mast that listens, another that jams it, a buoy between.
    const MASTS: &str = r#"
        scene = { duration_s = 1.0 }
        target = [{ name = "buoy", position_m = [0, 2000, 0], rcs_m2 = 10 }]
        radar = { carrier_hz = 10e9, sample_rate_hz = 40e6, prf_hz = 200.0, channels = ["HH", "VV"], noise_figure_db = 3.0, losses_db = 2.0, waveform = { kind = "lfm", bandwidth_hz = 25e6, pulse_s = 1e-6 }, window = { samples = 128, start_us = 10 }, adc = { bits = 12, full_scale_dbw = -60 } }
        [[platform]]
        name = "mast"
        track = { kind = "fixed", position_m = [0, 0, 0] }
        [[platform]]
        name = "other"
        track = { kind = "fixed", position_m = [3000, 0, 0] }
        [[transmitter]]
        name = "tx"
        platform = "mast"
        power_w = 1000.0
        antenna = { kind = "isotropic", gain_dbi = 20 }
        [[receiver]]
        name = "rx"
        platform = "mast"
        antenna = { kind = "isotropic", gain_dbi = 10 }
        [[emitter]]
        name = "jammer"
        platform = "other"
        power_w = 50.0
        prf_hz = 1000.0
        polarisation = "V"
        antenna = { kind = "isotropic", gain_dbi = 3 }
        waveform = { kind = "lfm", bandwidth_hz = 10.0, pulse_s = 200e-6 }
    "#;

    fn budgets(settings: &[(&str, &str)]) -> Vec<EmitterBudget> {
        let settings: Vec<_> = settings.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        let run = config::parse(MASTS, Path::new("scene.toml"), &settings).unwrap();
        emitter_budgets(&Prepared::of(&run).unwrap()).unwrap()
    }

    fn db(ratio: f64) -> f64 {
        10.0 * ratio.log10()
    }

    #[test]
    fn levels_are_those_of_the_radar_equation() {
        let (c, k_t0) = (299_792_458.0, 1.380_649e-23 * 290.0);
        let noise_dbw = db(k_t0 * 0.875 * 40e6) + 3.0;
        // P G_t G_r lambda^2 sigma / ((4 pi)^3 R^4) / L.
        let lambda = c / 10e9;
        let echo_w = 1e3 * 1e3 * lambda * lambda * 10.0 / ((4.0 * PI).powi(3) * 2000f64.powi(4));
        let near = |found: Option<f64>, expected: f64, off: f64| {
            assert!((found.unwrap() - expected).abs() < off, "{found:?} {expected}");
        };
        for (carrier_hz, filtered_db) in [
            (10e9, 0.0),
            // Half-way down the edge of the filter, `(1 + cos)/2 = 1/2` of the amplitude at 0.45 fs.
            (10e9 + 18e6, -20.0 * 2f64.log10()),
        ] {
            let found = budgets(&[("emitter.0.carrier_hz", &format!("{carrier_hz:e}"))]);
            let [budget] = &found[..] else { panic!("{found:?}") };
            let lambda = c / carrier_hz;
            let power_dbw =
                db(50.0 * 10f64.powf(1.3) * (lambda / (4.0 * PI * 3000.0)).powi(2)) - 2.0 + filtered_db;
            // Lobes, `1/(2 pi^2 T f^2)` of the power per Hz, over the slope of the edge: 0.003 dB.
            near(budget.power_dbw, power_dbw, 0.005);
            near(budget.over_noise_db, power_dbw - noise_dbw, 0.005);
            near(budget.over_full_scale_db, power_dbw + 60.0, 0.005);
            near(budget.over_echo_db, power_dbw - (db(echo_w) - 2.0), 0.005);
            assert_eq!((budget.channel.as_str(), budget.receiver.as_str()), ("VV", "rx"));
            assert!(warnings(&found).next().is_none());
        }
        // A sweep of 80 MHz: all passes of 16 MHz on either side, and 3/8 of the power in either edge of
        // 4 MHz: the mean of `(1 + cos)^2 / 4`.
        let wide = budgets(&[("emitter.0.waveform.bandwidth_hz", "80e6")]);
        let still = budgets(&[]);
        near(wide[0].power_dbw, still[0].power_dbw.unwrap() + db((32.0 + 8.0 * 0.375) / 80.0), 0.01);
    }

    /// Sweeps in turn 15 MHz off an emitter's carrier are the same sweep of a carrier 15 MHz off.
    #[test]
    fn pulses_off_the_carrier_pass_where_they_are() {
        let sweep = "kind = 'lfm', bandwidth_hz = 4e6, pulse_s = 100e-6";
        let up = format!("{{ {sweep}, offset_hz = 15e6 }}");
        let down = format!("{{ {sweep}, sweep = 'down', offset_hz = 15e6 }}");
        let waveform = format!("{{ kind = 'in-turn', waveforms = [{up}, {down}] }}");
        let in_turn = budgets(&[("emitter.0.waveform", &waveform)]);
        let plain = format!("{{ {sweep} }}");
        let alone = budgets(&[("emitter.0.waveform", &plain), ("emitter.0.carrier_hz", "10.015e9")]);
        let [a, b] = [in_turn, alone].map(|found| found[0].power_dbw.unwrap());
        // 15 MHz of 10 GHz of wavelength: 0.013 dB.
        assert!((a - b).abs() < 0.05, "{a} {b}");
    }

    #[test]
    fn what_fills_the_converter_is_warned_of() {
        let near = budgets(&[("radar.adc.full_scale_dbw", "-100")]);
        let words: Vec<String> = warnings(&near).collect();
        let [warning] = &words[..] else { panic!("{words:?}") };
        // -94.0 dBW by the equation above.
        let begins =
            "emitter \"jammer\" reaches channel VV of \"rx\" 6.0 dB above the full scale of radar.adc";
        assert!(warning.starts_with(begins), "{warning}");
        let text: Vec<String> =
            rows(&budgets(&[])).iter().map(|row| format!("{}: {}", row.what, row.how)).collect();
        assert!(text[0].starts_with("jammer at rx: -") && text[0].contains(" dB over the noise"), "{text:?}");
        assert!(budgets(&[("emitter.0.direct_path", "false")]).is_empty());
    }
}
