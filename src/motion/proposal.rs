//! The `track` of a scenario that takes a recording as it is, with the smoothing that its noise asks for.

use std::fmt::Write as _;
use std::path::Path;

use super::Track;
use crate::frames::{Earth, Geodetic, SceneFrame};
use crate::nav::inspection::{Encoding, Reading};
use crate::nav::{
    AttitudeSource, FileFormat, FileSource, Fix, MotionBounds, Place, Smoothing, VerticalDatum,
};
use crate::time::TimeTag;

/// Acceleration that the noise of the fixes may pretend, m/s^2, before smoothing is proposed.
const PRETENDED_MPS2: f64 = 0.5;
/// Least deviation that is smoothed, and that is stated of a fix, m.
const LEAST_SIGMA_M: f64 = 0.1;
/// Bounds on the acceleration that are tried, m/s^2.
const BOUNDS_MPS2: [f64; 6] = [1.0, 2.0, 3.0, 5.0, 10.0, 20.0];
/// Settings that reject more than one fix in so many are too tight.
const REJECTED_ONE_IN: usize = 100;
/// Fixes on which settings are tried at most.
const TRIED: usize = 20_000;

/// Whether a scenario must state what heights of such a recording are measured from.
fn takes_datum(encoding: Encoding, fixes: &[Fix]) -> bool {
    let is_local = fixes.first().is_some_and(|fix| matches!(fix.place, Place::Local(_)));
    matches!(encoding, Encoding::Csv | Encoding::Nmea | Encoding::Gpx | Encoding::Kml) && !is_local
}

/// Whether the block lacks a datum, which the scenario must add: a wrong one moves the platform by tens of
/// metres.
pub fn lacks_datum(encoding: Encoding, how: &Reading, fixes: &[Fix]) -> bool {
    how.datum.is_none() && takes_datum(encoding, fixes)
}

/// The block, on one line; none of a capture, which no scenario reads. Paths in a scenario are relative to
/// its file.
pub fn block(file: &Path, encoding: Encoding, how: &Reading, fixes: &[Fix]) -> Option<String> {
    let gps_week = how.gps_week.unwrap_or_default();
    let of = match encoding {
        Encoding::Csv => FileFormat::Csv,
        Encoding::Nmea => FileFormat::Nmea,
        Encoding::Inspvax => FileFormat::Inspvax,
        Encoding::Sbet => FileFormat::Sbet { gps_week },
        Encoding::Gpx => FileFormat::Gpx,
        Encoding::Kml => FileFormat::Kml,
        Encoding::Pcap => return None,
    };
    let path = toml::Value::from(file.to_str()?);
    let mut text = format!("track = {{ kind = \"{}\", path = {path}", encoding.name());
    fixes.first()?;
    // Writing to a String cannot fail.
    let _ = match how.datum {
        _ if encoding == Encoding::Sbet => write!(text, ", gps_week = {gps_week}"),
        _ if !takes_datum(encoding, fixes) => Ok(()),
        Some(VerticalDatum::Ellipsoid) => write!(text, ", datum = \"ellipsoid\""),
        Some(VerticalDatum::MeanSeaLevel) => write!(text, ", datum = \"msl\""),
        _ => Ok(()),
    };
    if let Some(day) = how.first_day.filter(|_| encoding == Encoding::Nmea) {
        // The day alone.
        let midnight = TimeTag::new(day * 86_400, 0.0).to_string();
        let _ = write!(text, ", date = \"{}\"", &midnight[..10]);
    }
    let intervals: Vec<f64> = fixes.windows(2).map(|pair| pair[1].time.since(pair[0].time)).collect();
    let longest_s = intervals.iter().copied().fold(0.0, f64::max);
    // Millimetres of a second, so that what is printed is not below what is meant.
    let max_gap_s = (longest_s * 1e3).ceil() / 1e3;
    let _ = write!(text, ", max_gap_s = {max_gap_s}");
    let source = FileSource {
        path: file.to_owned(),
        format: of,
        datum: VerticalDatum::Ellipsoid,
        undulation_m: 0.0,
        // With it, as rejecting outliers leaves gaps.
        max_gap_s,
        smoothing: Smoothing::Off,
        attitude: AttitudeSource::Automatic,
        first_day: how.first_day,
        bounds: MotionBounds::SPACECRAFT,
    };
    if let Some(Smoothing::Rts { horizontal_sigma_m, vertical_sigma_m, max_acceleration_mps2 }) =
        smoothing(fixes, &intervals, &source)
    {
        let _ = write!(
            text,
            ", smoothing = {{ kind = \"rts\", horizontal_sigma_m = {horizontal_sigma_m}, \
             vertical_sigma_m = {vertical_sigma_m}, max_acceleration_mps2 = {max_acceleration_mps2} }}"
        );
    }
    Some(text + " }")
}

/// Smoothing that makes a track, where fixes are so noisy that the platform would seem to shake.
fn smoothing(fixes: &[Fix], intervals: &[f64], source: &FileSource) -> Option<Smoothing> {
    let fixes = &fixes[..fixes.len().min(TRIED)];
    let intervals = &intervals[..fixes.len().saturating_sub(1)];
    let frame = frame(fixes.first()?);
    let points: Option<Vec<[f64; 3]>> = fixes.iter().map(|fix| position(fix, &frame)).collect();
    let [east, north, up] = noise_m(&points?, intervals)?;
    let noise = [east.max(north), up];
    let mut sorted = intervals.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median_s = sorted[sorted.len() / 2];
    // A second difference of white noise is sqrt(6) times the noise.
    let noisy =
        |sigma_m: f64| sigma_m >= LEAST_SIGMA_M && 6f64.sqrt() * sigma_m / median_s.powi(2) > PRETENDED_MPS2;
    if !noise.into_iter().any(noisy) {
        return None;
    }
    [1.0, 2.0, 4.0].into_iter().find_map(|times| {
        let [horizontal_sigma_m, vertical_sigma_m] =
            noise.map(|sigma_m| two_digits((times * sigma_m).max(LEAST_SIGMA_M)));
        BOUNDS_MPS2.into_iter().find_map(|max_acceleration_mps2| {
            let smoothing = Smoothing::Rts { horizontal_sigma_m, vertical_sigma_m, max_acceleration_mps2 };
            let source = FileSource { smoothing, ..source.clone() };
            let (_, fit) = Track::recorded(fixes, &frame, &source).ok()?;
            let rejected = fit.rejected_horizontal.max(fit.rejected_vertical);
            (rejected * REJECTED_ONE_IN <= fit.fixes).then_some(smoothing)
        })
    })
}

/// A frame in which the fixes are upright.
fn frame(first: &Fix) -> SceneFrame {
    match first.place {
        Place::Geodetic(at) => SceneFrame::at(Geodetic { h_m: 0.0, ..at }, Earth::Flat),
        Place::Local(_) => SceneFrame::plain(Earth::Flat),
    }
}

fn position(fix: &Fix, frame: &SceneFrame) -> Option<[f64; 3]> {
    match fix.place {
        Place::Geodetic(at) => {
            let [east, north, _] = frame.from_geodetic(at)?.to_array();
            Some([east, north, at.h_m])
        }
        Place::Local(at) => Some(at.to_array()),
    }
}

/// Standard deviation of white noise by axis, from fourth differences, which a smooth motion hardly has. Of
/// white noise they have sqrt(70) times its deviation; the upper quartile leaves manoeuvres out, and steps of
/// a coarse height not.
fn noise_m(points: &[[f64; 3]], intervals: &[f64]) -> Option<[f64; 3]> {
    /// Of a normal distribution, in deviations.
    const QUARTILE: f64 = 1.1503;
    let even = |w: &[f64]| w.iter().all(|h| (h / w[0] - 1.0).abs() < 0.01);
    let ends: Vec<usize> =
        (0..points.len().saturating_sub(4)).filter(|i| even(&intervals[*i..i + 4])).collect();
    if ends.len() < 8 {
        return None;
    }
    Some(std::array::from_fn(|axis| {
        let fourth = |i: &usize| {
            let p = |k: usize| points[i + k][axis];
            (p(0) - 4.0 * p(1) + 6.0 * p(2) - 4.0 * p(3) + p(4)).abs()
        };
        let mut all: Vec<f64> = ends.iter().map(fourth).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() * 3 / 4] / (QUARTILE * 70f64.sqrt())
    }))
}

/// Rounded up to two digits.
fn two_digits(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    let text = format!("{:.6}", (value / unit).ceil() * unit);
    text.parse().unwrap_or(value)
}
