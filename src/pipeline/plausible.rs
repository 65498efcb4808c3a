//! Whether a run can be meant as it is, as far as that takes trajectories or samples.
//!
//! * A fault: an antenna below mean sea level, a pulse from a file that is longer than the pulse interval.
//! * A warning: targets whose echo never lies in the receive window, a converter that clips or that its
//!   signal never fills by one code, a recorded track with latitude and longitude swapped or yaw in radians.
//!
//! Geometry is taken at [`INSTANTS`] pulses spread over the run, without the motion during the echo. What
//! needs no trajectory is evaluated when the scenario is read (`config::resolve`).

use serde::Serialize;

use crate::frames::{Enu, Point};
use crate::nav::{FileFormat, TrackSource};
use crate::pipeline::fault::{BuildError, BuildErrors};
use crate::pipeline::prepared::{Moment, Prepared};
use crate::pulse::converter::Level;
use crate::radar::fault::mounts;
use crate::radar::window::Window;
use crate::scene::Target;
use crate::scene::radar::{Radar, Waveform};
use crate::units::SPEED_OF_LIGHT_MPS;

/// Pulses of a run at which geometry is taken.
pub const INSTANTS: u64 = 33;
/// Targets that a warning names.
const MOST_NAMED: usize = 8;
/// Depth that is rounding, m.
const ROUNDING_M: f64 = 1e-6;
/// Share of saturated samples above which a converter clips.
const CLIPPED_SHARE: f64 = 1e-4;
/// Slowest speed at which there is a course, m/s.
const LEAST_WAY_MPS: f64 = 1.0;

/// What cannot be, once the tracks are known. A live platform is left out: its trajectory is only nominal.
pub(super) fn faults(prepared: &Prepared) -> Vec<BuildError> {
    let scene = prepared.scene();
    let mut faults = Vec::new();
    for (antenna, mount) in mounts(&scene.radar) {
        if matches!(prepared.run().nav[mount.platform].truth, TrackSource::Live(_)) {
            continue;
        }
        let depth = |at: Moment<'_>| {
            // A track that ends early is reported by who needs it.
            let [x_m, y_m, z_m] = at.phase_centre(mount).ok()?.position.to_array();
            Some((-z_m - scene.frame.earth().drop_m(x_m, y_m), at.pulse))
        };
        let deepest = prepared.spread(INSTANTS).filter_map(depth).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((depth_m, pulse)) = deepest.filter(|(depth_m, _)| *depth_m > ROUNDING_M) {
            let swapped = swapped(prepared, mount.platform).is_some();
            let (antenna, platform) = (antenna.to_owned(), scene.platforms[mount.platform].clone());
            faults.push(BuildError::BelowSea { antenna, platform, depth_m, pulse, swapped });
        }
    }
    if let Ok(waveform) = prepared.waveform() {
        for (n, pulse) in scene.radar.waveform.pulses().iter().enumerate() {
            let Waveform::Samples { path, .. } = pulse.level() else { continue };
            let own = waveform.in_turn().get(n).unwrap_or(waveform);
            let (pulse_s, pri_s) = (own.duration_s(), scene.radar.sends().shortest_pri_s());
            if pulse_s > pri_s * (1.0 + 1e-9) {
                faults.push(BuildError::LongPulse {
                    path: path.clone(),
                    pulse_us: pulse_s * 1e6,
                    pri_us: pri_s * 1e6,
                });
            }
            let (band, half_hz) = (own.band(), 0.5 * scene.radar.sample_rate_hz);
            if pulse.offset_hz() != 0.0 && band.reach_hz() > half_hz {
                let (path, [from_hz, to_hz]) = (path.clone(), [band.from_hz, band.to_hz]);
                faults.push(BuildError::BeyondBand { path, from_hz, to_hz, half_hz });
            }
        }
    }
    faults
}

/// What is suspicious of where platforms and targets are.
///
/// # Errors
/// A waveform that cannot be read.
pub fn geometry(prepared: &Prepared) -> Result<Vec<String>, BuildErrors> {
    let mut warnings = Vec::new();
    for (platform, nav) in prepared.run().nav.iter().enumerate() {
        if let TrackSource::File(source) = &nav.truth {
            warnings.extend(swapped(prepared, platform));
            if source.format == FileFormat::Csv {
                warnings.extend(in_radians(prepared, platform));
            }
        }
    }
    warnings.extend(targets(prepared)?);
    Ok(warnings)
}

/// A track whose latitude and longitude look swapped.
fn swapped(prepared: &Prepared, platform: usize) -> Option<String> {
    let scene = prepared.scene();
    let state = prepared.tracks()[platform].truth.state(scene.start).ok()?;
    let at = scene.frame.to_geodetic(state.position)?;
    at.looks_swapped(scene.frame.origin()?).then(|| {
        format!(
            "{}: its track begins at {:.4} deg, {:.4} deg, far from the origin of the scene, and near it with latitude and \
             longitude swapped",
            scene.platforms[platform],
            at.lat_rad.to_degrees(),
            at.lon_rad.to_degrees()
        )
    })
}

/// A track whose yaw, which is read in degrees, follows its course if it is taken in radians.
fn in_radians(prepared: &Prepared, platform: usize) -> Option<String> {
    let (mut greatest, mut off_deg, mut count) = (0.0f64, [0.0; 2], 0);
    for at in prepared.spread(INSTANTS) {
        let state = prepared.tracks()[platform].truth.state(at.time).ok()?;
        let [east, north, _] = state.velocity.to_array();
        if east.hypot(north) < LEAST_WAY_MPS {
            continue;
        }
        let [yaw_rad, ..] = state.attitude.to_yaw_pitch_roll();
        let number = turn_deg(yaw_rad.to_degrees());
        let course_deg = east.atan2(north).to_degrees();
        greatest = greatest.max(number.abs());
        for (sum, yaw_deg) in off_deg.iter_mut().zip([number, number.to_degrees()]) {
            *sum += turn_deg(yaw_deg - course_deg).abs();
        }
        count += 1;
    }
    let [read_deg, radians_deg] = off_deg.map(|sum| sum / f64::from(count.max(1)));
    let odd = count > 0 && greatest <= std::f64::consts::TAU + 1e-3 && read_deg > 30.0 && radians_deg < 20.0;
    let platform = &prepared.scene().platforms[platform];
    odd.then(|| {
        format!(
            "{platform}: yaw is {read_deg:.0} deg off the course, and no more than 2 pi throughout: is yaw_deg in radians?"
        )
    })
}

/// An angle within half a turn, degrees.
fn turn_deg(angle_deg: f64) -> f64 {
    (angle_deg + 180.0).rem_euclid(360.0) - 180.0
}

/// Part of an echo that a window may cut without a word.
const CUT_SHARE: f64 = 0.02;

/// Targets of whose echo nothing, or never all, lies in a window: at none of the pulses evaluated and in no
/// pair of antennas.
fn targets(prepared: &Prepared) -> Result<Vec<String>, BuildErrors> {
    let scene = prepared.scene();
    // Received without a gap, nothing is outside.
    if scene.targets.is_empty() || scene.radar.sent.is_some() {
        return Ok(Vec::new());
    }
    let pulse_s = prepared.waveform()?.duration_s();
    let radar = &scene.radar;
    let window_s = radar.window.samples as f64 / radar.sample_rate_hz;
    let interval_s = 1.0 / radar.emissions.mean_prf_hz();
    let pairs = radar.pairs();
    // Distance from the window, or how much of the echo it cuts; echo and window: of the nearest approach.
    let mut nearest: Vec<Option<(f64, f64, f64)>> = vec![None; scene.targets.len()];
    let mut least_cut: Vec<Option<(f64, f64, f64)>> = nearest.clone();
    for at in prepared.spread(INSTANTS) {
        let Ok(starts_s) = at.open_s(&pairs) else { continue };
        let ends =
            pairs.iter().zip(starts_s).filter_map(|(pair, opens_s)| Some((at.ends(*pair).ok()?, opens_s)));
        let ends: Vec<([Point<Enu>; 2], f64)> = ends.collect();
        let since_s = at.time.since(scene.start);
        for ((target, nearest), least_cut) in scene.targets.iter().zip(&mut nearest).zip(&mut least_cut) {
            let (place, _) = target.at(since_s);
            for (ends, opens_s) in &ends {
                let opens_s = *opens_s;
                let path_m: f64 = ends.iter().map(|end| (*end - place).norm()).sum();
                let delay_s = path_m / SPEED_OF_LIGHT_MPS;
                // The window may hold the echo of another emission: the one nearest to its middle.
                let middle_s = opens_s + 0.5 * (window_s - pulse_s);
                let delay_s = delay_s + ((middle_s - delay_s) / interval_s).round() * interval_s;
                let window = Window { open_s: opens_s, close_s: opens_s + window_s, guard_s: 0.0, pulse_s };
                let cut_s = (opens_s - delay_s).max(delay_s + pulse_s - opens_s - window_s);
                let off_s = if window.receives(delay_s, interval_s) { 0.0 } else { cut_s };
                for (known, own_s) in [(&mut *nearest, off_s), (&mut *least_cut, cut_s)] {
                    if known.is_none_or(|(known_s, ..)| own_s < known_s) {
                        *known = Some((own_s, delay_s, opens_s));
                    }
                }
            }
        }
    }
    let us = |from_s: f64, to_s: f64| format!("{:.2} to {:.2} us", from_s * 1e6, to_s * 1e6);
    let named = |of: &[Option<(f64, f64, f64)>], from_s: f64| -> Vec<String> {
        let row = |(target, found): (&Target, &Option<(f64, f64, f64)>)| {
            let (_, delay_s, opens_s) = found.filter(|(off_s, ..)| *off_s > from_s)?;
            let (echo, window) = (us(delay_s, delay_s + pulse_s), us(opens_s, opens_s + window_s));
            Some(format!("{} (echo {echo} after the emission, window {window})", target.name))
        };
        scene.targets.iter().zip(of).filter_map(row).collect()
    };
    let count = scene.targets.len();
    let missed = named(&nearest, 0.0);
    let words = match missed.len() {
        all if all == count => "no target lies in the receive window".to_owned(),
        some => format!("{some} of {count} targets never lie in the receive window"),
    };
    let mut warnings: Vec<String> = shortened(&words, missed).into_iter().collect();
    // Of a pulse longer than the window there is always something outside.
    if warnings.is_empty() && pulse_s <= window_s {
        let cut = named(&least_cut, CUT_SHARE * pulse_s);
        let words =
            format!("the receive window cuts the echo of {} of {count} targets at all times", cut.len());
        warnings.extend(shortened(&words, cut));
    }
    Ok(warnings)
}

/// A warning that names what it is of, the first of many; none of none.
fn shortened(words: &str, mut named: Vec<String>) -> Option<String> {
    let count = named.len();
    named.truncate(MOST_NAMED);
    named.extend((count > MOST_NAMED).then(|| format!("{} more", count - MOST_NAMED)));
    (count > 0).then(|| format!("{words}: {}", named.join(", ")))
}

/// What the converter was fed with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConverterReport {
    /// Bits.
    pub bits: u32,
    /// Full scale of I and of Q, dBW.
    pub full_scale_dbw: f64,
    /// Complex samples.
    pub samples: u64,
    /// Those whose I or Q lay beyond full scale.
    pub saturated: u64,
    /// By channel.
    pub channels: Vec<ChannelReport>,
}

/// What the converter of a channel was fed with. One LSB is one code of I or of Q.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelReport {
    /// The channel.
    pub channel: String,
    /// Complex samples.
    pub samples: u64,
    /// Those whose I or Q lay beyond full scale.
    pub saturated: u64,
    /// Root mean square of I and of Q before the converter, LSB.
    pub rms_lsb: f64,
    /// The largest |I| or |Q| before the converter, LSB.
    pub peak_lsb: f64,
}

impl ConverterReport {
    /// The report of a radar's converter; `None` of one that has none, or without a sample.
    pub fn of(radar: &Radar, levels: &[Level]) -> Option<Self> {
        let adc = radar.adc?;
        let channels: Vec<ChannelReport> = radar
            .channels
            .iter()
            .zip(levels)
            .filter(|(_, level)| level.samples > 0)
            .map(|(channel, level)| ChannelReport {
                channel: channel.name.clone(),
                samples: level.samples,
                saturated: level.saturated,
                rms_lsb: level.rms(),
                peak_lsb: level.peak,
            })
            .collect();
        (!channels.is_empty()).then(|| Self {
            bits: adc.bits,
            full_scale_dbw: 20.0 * adc.full_scale.log10(),
            samples: channels.iter().map(|channel| channel.samples).sum(),
            saturated: channels.iter().map(|channel| channel.saturated).sum(),
            channels,
        })
    }

    /// Where its full scale does not fit the signal.
    pub fn warnings(&self) -> Vec<String> {
        let full_lsb = 2f64.powi(self.bits as i32 - 1);
        let holds_dbw = |peak_lsb: f64| self.full_scale_dbw + 20.0 * (peak_lsb / full_lsb).log10();
        let mut warnings: Vec<String> = self
            .channels
            .iter()
            .filter(|channel| channel.saturated as f64 > CLIPPED_SHARE * channel.samples as f64)
            .map(|of| {
                format!(
                    "channel {}: {} of {} samples exceed the full scale of radar.adc, by up to {:.1} dB: a full_scale_dbw of {:.1} \
                     would hold all of them",
                    of.channel,
                    of.saturated,
                    of.samples,
                    20.0 * (of.peak_lsb / full_lsb).log10(),
                    holds_dbw(of.peak_lsb)
                )
            })
            .collect();
        let peak_lsb = self.channels.iter().map(|channel| channel.peak_lsb).fold(0.0, f64::max);
        // One bit codes signs, whatever the scale.
        if peak_lsb > 0.0 && peak_lsb < 1.0 && self.bits > 1 {
            warnings.push(format!(
                "the strongest sample is {peak_lsb:.2} of a code: the full scale of radar.adc is above the signal by more than its \
                 {} bits hold; a full_scale_dbw of {:.1} would fill them",
                self.bits,
                holds_dbw(peak_lsb)
            ));
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_scales_that_do_not_fit() {
        let of = |peak_lsb: f64, saturated: u64| ConverterReport {
            bits: 8,
            full_scale_dbw: -100.0,
            samples: 1000,
            saturated,
            channels: vec![ChannelReport {
                channel: "VV".to_owned(),
                samples: 1000,
                saturated,
                rms_lsb: 0.3 * peak_lsb,
                peak_lsb,
            }],
        };
        let shown = |report: ConverterReport| {
            report.warnings().iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
        };
        assert_eq!(shown(of(100.0, 0)), "");
        insta::assert_snapshot!(shown(of(1280.0, 50)), @"channel VV: 50 of 1000 samples exceed the full scale of radar.adc, by up to 20.0 dB: a full_scale_dbw of -80.0 would hold all of them");
        insta::assert_snapshot!(shown(of(0.128, 0)), @"the strongest sample is 0.13 of a code: the full scale of radar.adc is above the signal by more than its 8 bits hold; a full_scale_dbw of -160.0 would fill them");
    }
}
