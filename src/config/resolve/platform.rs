//! Platforms: where their trajectories come from.

use super::{Ground, errors, place};
use crate::config::choices::{AttitudeKind, DatumKind, SmoothingKind, TrackKind};
use crate::config::error::Problem;
use crate::config::keys;
use crate::config::section::Section;
use crate::frames::{Body, Enu, Rotation, Vector};
use crate::motion::PlatformNav;
use crate::nav::TrackSource;
use crate::nav::{
    AttitudeSource, FileFormat, FileSource, LiveSource, MotionBounds, Smoothing, VerticalDatum, csv,
};

/// One `[[platform]]`; its name has been read.
pub(super) fn platform(section: Section<'_>, ground: &Ground) -> Option<PlatformNav> {
    use keys::platform::{ERRORS, REPORTED, TRACK, TURBULENCE};
    let live = section.peek_choice_in(&TRACK, &keys::track::KIND) == Some(TrackKind::Live);
    let truth = section.section(&TRACK).map(|section| track(section, ground, Part::Truth));
    let has_report = section.has(&REPORTED);
    let reported = section.section(&REPORTED).map(|section| track(section, ground, Part::Report));
    let has_errors = section.has(&ERRORS);
    let errors = section.section(&ERRORS).map(|section| errors::errors(section, has_report, live));
    let has_gusts = section.has(&TURBULENCE);
    if has_gusts && live {
        let when = "the track is live: its air is real".to_owned();
        section.fault(&TURBULENCE, Problem::Idle { when });
    }
    let gusts = section.section(&TURBULENCE).map(errors::gusts);
    section.finish();
    let reported = if has_report { Some(reported??) } else { None };
    let errors = if has_errors { Some(errors??) } else { None };
    let gusts = if has_gusts { Some(gusts??) } else { None };
    Some(PlatformNav { truth: truth??, reported, errors, gusts })
}

/// What a track stands for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Truth,
    Report,
    Nominal,
}

fn track(section: Section<'_>, ground: &Ground, part: Part) -> Option<TrackSource> {
    let source = match section.choice(&keys::track::KIND) {
        Some(TrackKind::Live) => {
            let place = match part {
                Part::Truth => None,
                Part::Report => Some("as a report"),
                Part::Nominal => Some("as a nominal trajectory"),
            };
            if let Some(place) = place {
                let allowed = "a track that is known beforehand";
                section.fault(&keys::track::KIND, Problem::Live { found: "\"live\"", place, allowed });
            }
            live(&section, ground).filter(|_| place.is_none()).map(TrackSource::Live)
        }
        Some(TrackKind::Fixed) => fixed(&section, ground),
        Some(TrackKind::Straight) => straight(&section, ground),
        Some(TrackKind::Recorded(FileFormat::Sbet { .. })) => {
            let week = section.count(&keys::track::GPS_WEEK).and_then(|week| u32::try_from(week).ok());
            let source = file(&section, ground, FileFormat::Sbet { gps_week: week.unwrap_or(0) });
            source.filter(|_| week.is_some()).map(TrackSource::File)
        }
        Some(TrackKind::Recorded(format)) => file(&section, ground, format).map(TrackSource::File),
        None => None,
    };
    section.finish();
    source
}

fn fixed(section: &Section<'_>, ground: &Ground) -> Option<TrackSource> {
    let place = place::platform(section, ground);
    let attitude = attitude(section)?;
    Some(TrackSource::Fixed { place: place?, attitude })
}

fn straight(section: &Section<'_>, ground: &Ground) -> Option<TrackSource> {
    use keys::track::{PITCH_DEG, ROLL_DEG, VELOCITY_MPS, YAW_DEG};
    let place = place::platform(section, ground);
    let velocity = section.vector(&VELOCITY_MPS).map(|[e, n, u]| Vector::new(e, n, u));
    let given = [&YAW_DEG, &PITCH_DEG, &ROLL_DEG].into_iter().any(|key| section.has(key));
    let attitude = attitude(section)?;
    Some(TrackSource::Straight { place: place?, velocity: velocity?, attitude: given.then_some(attitude) })
}

/// Yaw, pitch and roll, zero where absent.
fn attitude(section: &Section<'_>) -> Option<Rotation<Body, Enu>> {
    use keys::track::{PITCH_DEG, ROLL_DEG, YAW_DEG};
    let angles = [&YAW_DEG, &PITCH_DEG, &ROLL_DEG].map(|key| {
        let angle_deg = section.number(key);
        if section.has(key) { angle_deg } else { Some(0.0) }
    });
    let [yaw, pitch, roll] = angles;
    Some(Rotation::from_yaw_pitch_roll(yaw?.to_radians(), pitch?.to_radians(), roll?.to_radians()))
}

fn file(section: &Section<'_>, ground: &Ground, format: FileFormat) -> Option<FileSource> {
    let (mut source, attitude) = (read(section, ground, format, None), attitude_source(section));
    if let (Some(source), Some(attitude)) = (&mut source, attitude) {
        source.attitude = attitude;
    }
    source.filter(|_| attitude.is_some())
}

/// A recording of what has no attitude; on the sea its heights do not count.
pub(super) fn recording(
    section: &Section<'_>,
    ground: &Ground,
    format: FileFormat,
    on_sea: bool,
) -> Option<FileSource> {
    read(section, ground, format, on_sea.then_some(VerticalDatum::MeanSeaLevel))
}

/// A recording with a constant attitude.
fn read(
    section: &Section<'_>,
    ground: &Ground,
    format: FileFormat,
    given: Option<VerticalDatum>,
) -> Option<FileSource> {
    use keys::track::{DATE, MAX_GAP_S, PATH, SMOOTHING};
    let path = section.file(&PATH);
    // The format defines what its heights are measured from.
    let known = matches!(format, FileFormat::Inspvax | FileFormat::Sbet { .. });
    // All formats but CSV hold latitudes and longitudes. What cannot be read is reported where the fixes are.
    let geodetic = match (&path, format) {
        (Some(path), FileFormat::Csv) => csv::is_geodetic(path),
        (path, _) => path.is_some(),
    };
    if geodetic && !ground.geodetic_allowed() {
        section.fault(&PATH, Problem::TrackNeedsOrigin);
    }
    let datum = match given {
        _ if known => Some(VerticalDatum::Ellipsoid),
        Some(given) => Some(given),
        None => datum(section, ground, geodetic),
    };
    let max_gap_s = section.number(&MAX_GAP_S);
    let smoothing = match section.has(&SMOOTHING) {
        true => section.section(&SMOOTHING).and_then(smoothing),
        false => {
            section.section(&SMOOTHING);
            Some(Smoothing::Off)
        }
    };
    let first_day = if format == FileFormat::Nmea { section.date(&DATE) } else { None };
    // What is smoothed has its own rejection of outliers.
    let is_exact = matches!(smoothing, Some(Smoothing::Off));
    let bounds =
        if is_exact { bounds(section, MotionBounds::SPACECRAFT) } else { Some(MotionBounds::SPACECRAFT) };
    let has_date = format == FileFormat::Nmea && section.has(&DATE);
    Some(FileSource {
        path: path?,
        format,
        datum: datum?,
        undulation_m: ground.origin_h_m.unwrap_or(0.0),
        max_gap_s: max_gap_s?,
        smoothing: smoothing?,
        attitude: AttitudeSource::Constant(Rotation::from_yaw_pitch_roll(0.0, 0.0, 0.0)),
        first_day: if has_date { Some(first_day?) } else { None },
        bounds: bounds?,
    })
}

fn live(section: &Section<'_>, ground: &Ground) -> Option<LiveSource> {
    use keys::track::{BAUD, DATE, DATUM, MAX_EXTRAPOLATION_S, MAX_GAP_S, NOMINAL, SOURCE, TIMEOUT_S};
    if ground.sound && ground.origin_h_m.is_none() {
        section.fault(&SOURCE, Problem::LiveNeedsOrigin);
    }
    let baud = section.count(&BAUD).and_then(|baud| u32::try_from(baud).ok());
    let origin = section.origin(&SOURCE, baud.unwrap_or_default());
    // What sentences call altitude is above mean sea level; INSPVAX states it.
    let datum = if section.has(&DATUM) {
        datum(section, ground, true)
    } else {
        section.choice::<DatumKind>(&DATUM);
        Some(VerticalDatum::MeanSeaLevel)
    };
    let attitude = attitude_source(section);
    let (max_gap_s, max_extrapolation_s) = (section.number(&MAX_GAP_S), section.number(&MAX_EXTRAPOLATION_S));
    let timeout_s = section.number(&TIMEOUT_S);
    let bounds = bounds(section, MotionBounds::AIRCRAFT);
    let (has_date, first_day) = (section.has(&DATE), section.date(&DATE));
    let has_nominal = section.has(&NOMINAL);
    let nominal = section.section(&NOMINAL).and_then(|section| track(section, ground, Part::Nominal));
    Some(LiveSource {
        origin: origin.filter(|_| baud.is_some())?,
        datum: datum?,
        undulation_m: ground.origin_h_m.unwrap_or(0.0),
        attitude: attitude?,
        first_day: if has_date { Some(first_day?) } else { None },
        max_gap_s: max_gap_s?,
        max_extrapolation_s: max_extrapolation_s?,
        timeout_s: timeout_s?,
        bounds: bounds?,
        nominal: if has_nominal { Some(Box::new(nominal?)) } else { None },
    })
}

/// How the platform can move; `usual` where the vehicle is not given.
fn bounds(section: &Section<'_>, usual: MotionBounds) -> Option<MotionBounds> {
    use keys::track::{MAX_ACCELERATION_MPS2, MAX_SPEED_MPS, RESET_FIXES, VEHICLE};
    let usual = section.choice_or(&VEHICLE, usual);
    let (speed, acceleration) = (section.number(&MAX_SPEED_MPS), section.number(&MAX_ACCELERATION_MPS2));
    let reset_fixes = section.count(&RESET_FIXES).and_then(|fixes| usize::try_from(fixes).ok());
    let usual = usual?;
    let given = |key, value: Option<f64>, usual| if section.has(key) { value } else { Some(usual) };
    Some(MotionBounds {
        max_speed_mps: given(&MAX_SPEED_MPS, speed, usual.max_speed_mps)?,
        max_acceleration_mps2: given(&MAX_ACCELERATION_MPS2, acceleration, usual.max_acceleration_mps2)?,
        reset_fixes: reset_fixes?,
    })
}

fn attitude_source(section: &Section<'_>) -> Option<AttitudeSource> {
    Some(match section.choice(&keys::track::ATTITUDE) {
        Some(AttitudeKind::Recorded) => AttitudeSource::Recorded,
        Some(AttitudeKind::CoordinatedTurn) => AttitudeSource::CoordinatedTurn,
        Some(AttitudeKind::Level) => AttitudeSource::Level,
        Some(AttitudeKind::Constant) => AttitudeSource::Constant(attitude(section)?),
        None if section.has(&keys::track::ATTITUDE) => return None,
        None => AttitudeSource::Automatic,
    })
}

/// What heights are measured from; `geodetic`: of positions that have a latitude and a longitude.
fn datum(section: &Section<'_>, ground: &Ground, geodetic: bool) -> Option<VerticalDatum> {
    use keys::track::{BAROMETRIC_OFFSET_M, DATUM};
    match section.choice(&DATUM) {
        Some(DatumKind::Ellipsoid) => Some(VerticalDatum::Ellipsoid),
        Some(DatumKind::MeanSeaLevel) => Some(VerticalDatum::MeanSeaLevel),
        Some(DatumKind::Barometric) => {
            section.number(&BAROMETRIC_OFFSET_M).map(|offset_m| VerticalDatum::Barometric { offset_m })
        }
        // Local coordinates have no datum.
        None if !section.has(&DATUM) && ground.origin_h_m.is_none() && !geodetic => {
            Some(VerticalDatum::Ellipsoid)
        }
        None => {
            if !section.has(&DATUM) {
                section.fault(&DATUM, Problem::Missing { allowed: DATUM.kind.allowed() });
            }
            None
        }
    }
}

fn smoothing(section: Section<'_>) -> Option<Smoothing> {
    use keys::smoothing::{HORIZONTAL_SIGMA_M, KIND, MAX_ACCELERATION_MPS2, VERTICAL_SIGMA_M};
    let smoothing = match section.choice(&KIND) {
        Some(SmoothingKind::Rts) => {
            let horizontal = section.number(&HORIZONTAL_SIGMA_M);
            let vertical = section.number(&VERTICAL_SIGMA_M);
            let acceleration = section.number(&MAX_ACCELERATION_MPS2);
            horizontal.zip(vertical).zip(acceleration).map(
                |((horizontal_sigma_m, vertical_sigma_m), bound)| Smoothing::Rts {
                    horizontal_sigma_m,
                    vertical_sigma_m,
                    max_acceleration_mps2: bound,
                },
            )
        }
        Some(SmoothingKind::Off) => Some(Smoothing::Off),
        None => None,
    };
    section.finish();
    smoothing
}
