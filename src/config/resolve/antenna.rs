//! Antennas: where they sit, what they look like, where they point; and aim points.

use std::f64::consts::TAU;

use super::place::{self, SurfaceKeys};
use super::{Ground, Names};
use crate::config::choices::{AimKind, ApertureTaperKind, PatternKind, PointingKind, ScanFrom, Servo};
use crate::config::error::Problem;
use crate::config::keys::{self, Key};
use crate::config::section::Section;
use crate::frames::Vector;
use crate::scene::radar::{
    Aim, AntennaMount, ApertureTaper, Encoder, Pattern, Pointing, PortErrors, Scan, ScanLaw,
};

/// The keys that transmitters and receivers share.
pub(super) struct MountKeys {
    pub(super) platform: &'static Key,
    pub(super) lever_arm_m: &'static Key,
    pub(super) antenna: &'static Key,
    pub(super) pointing: &'static Key,
    pub(super) cross_pol_isolation_db: &'static Key,
}

/// Those of a table of keys.
macro_rules! mount_keys {
    ($table:ident) => {
        MountKeys {
            platform: &keys::$table::PLATFORM,
            lever_arm_m: &keys::$table::LEVER_ARM_M,
            antenna: &keys::$table::ANTENNA,
            pointing: &keys::$table::POINTING,
            cross_pol_isolation_db: &keys::$table::CROSS_POL_ISOLATION_DB,
        }
    };
}
pub(super) use mount_keys;

/// The keys of an aim point.
pub(super) struct AimKeys {
    pub(super) surface: SurfaceKeys,
    pub(super) velocity_mps: &'static Key,
    pub(super) platform: &'static Key,
    pub(super) along_m: &'static Key,
    pub(super) across_m: &'static Key,
}

/// Those of a table of keys.
macro_rules! aim_keys {
    ($table:ident) => {
        AimKeys {
            surface: SurfaceKeys {
                position_m: &keys::$table::POSITION_M,
                lat_deg: &keys::$table::LAT_DEG,
                lon_deg: &keys::$table::LON_DEG,
                height_m: None,
            },
            velocity_mps: &keys::$table::VELOCITY_MPS,
            platform: &keys::$table::PLATFORM,
            along_m: &keys::$table::ALONG_M,
            across_m: &keys::$table::ACROSS_M,
        }
    };
}
pub(super) use aim_keys;

/// The antenna of a transmitter or receiver.
pub(super) fn mount(
    section: &Section<'_>,
    keys: &MountKeys,
    ground: &Ground,
    platforms: &Names,
) -> Option<AntennaMount> {
    let platform = platforms.find(section, keys.platform);
    let lever_arm = section.vector(keys.lever_arm_m);
    let pattern = section.section(keys.antenna).and_then(pattern);
    let pointing = section.section(keys.pointing).map(|section| pointing(section, ground, platforms));
    let pointing = if section.has(keys.pointing) {
        pointing.flatten()
    } else {
        Some(Pointing::Fixed { yaw_rad: 0.0, pitch_rad: 0.0, roll_rad: 0.0 })
    };
    let isolation_db = section.number(keys.cross_pol_isolation_db);
    let [forward, starboard, down] = lever_arm?;
    Some(AntennaMount {
        platform: platform?,
        lever_arm: Vector::new(forward, starboard, down),
        of_array: Vector::ZERO,
        pattern: pattern?,
        pointing: pointing?,
        ports: PortErrors { isolation_db, ..PortErrors::default() },
    })
}

fn pattern(section: Section<'_>) -> Option<Pattern> {
    use keys::antenna::{DIAMETER_M, FLOOR_DBI, GAIN_DBI, HEIGHT_M, HEIGHT_TAPER, KIND, PATH};
    use keys::antenna::{SIDELOBE_DB, TAPER, WIDTH_M};
    let pattern = match section.choice(&KIND) {
        Some(PatternKind::Isotropic) => {
            section.number(&GAIN_DBI).map(|gain_dbi| Pattern::Isotropic { gain_dbi })
        }
        Some(PatternKind::Rectangle) => {
            let given = [tapered(&section, &TAPER), tapered(&section, &HEIGHT_TAPER)];
            if !given.iter().any(|taper| matches!(taper, Some(ApertureTaper::Taylor { .. }))) {
                section.idle(&[&SIDELOBE_DB], "neither taper is \"taylor\"");
            }
            let sides = sides(&section, &WIDTH_M, &HEIGHT_M);
            sides.zip(given[0].zip(given[1])).map(|([width_m, height_m], (along, up))| match [along, up] {
                [ApertureTaper::Uniform, ApertureTaper::Uniform] => Pattern::Rectangle { width_m, height_m },
                tapers => Pattern::Tapered { width_m, height_m, tapers },
            })
        }
        Some(PatternKind::Ellipse) => sides(&section, &WIDTH_M, &HEIGHT_M)
            .map(|[width_m, height_m]| Pattern::Ellipse { width_m, height_m }),
        Some(PatternKind::Circle) => section
            .number(&DIAMETER_M)
            .map(|diameter_m| Pattern::Ellipse { width_m: diameter_m, height_m: diameter_m }),
        Some(PatternKind::File) => {
            let path = section.file(&PATH);
            let floor_dbi = section.number(&FLOOR_DBI);
            path.zip(floor_dbi).map(|(path, floor_dbi)| Pattern::File { path, floor_dbi })
        }
        None => None,
    };
    section.finish();
    pattern
}

/// A taper along a side.
fn tapered(section: &Section<'_>, key: &'static Key) -> Option<ApertureTaper> {
    Some(match section.choice(key)? {
        ApertureTaperKind::Uniform => ApertureTaper::Uniform,
        ApertureTaperKind::Cosine => ApertureTaper::Cosine,
        ApertureTaperKind::Hamming => ApertureTaper::Hamming,
        ApertureTaperKind::Taylor => {
            ApertureTaper::Taylor { sidelobe_db: section.number(&keys::antenna::SIDELOBE_DB)? }
        }
    })
}

fn sides(section: &Section<'_>, width: &'static Key, height: &'static Key) -> Option<[f64; 2]> {
    let (width_m, height_m) = (section.number(width), section.number(height));
    Some([width_m?, height_m?])
}

fn pointing(section: Section<'_>, ground: &Ground, platforms: &Names) -> Option<Pointing> {
    use keys::pointing as k;
    let pointing = match section.choice(&k::KIND) {
        Some(Servo(PointingKind::Fixed)) => {
            let [yaw, pitch, roll] =
                [&k::YAW_DEG, &k::PITCH_DEG, &k::ROLL_DEG].map(|key| section.number(key));
            yaw.zip(pitch).zip(roll).map(|((yaw, pitch), roll)| Pointing::Fixed {
                yaw_rad: yaw.to_radians(),
                pitch_rad: pitch.to_radians(),
                roll_rad: roll.to_radians(),
            })
        }
        Some(Servo(PointingKind::At(kind))) => {
            let keys = aim_keys!(pointing);
            let aim = aim(&section, kind, &keys, ground, platforms);
            let aim_from = section.choice(&k::AIM_FROM);
            let [lag_s, az, el] =
                [&k::LAG_S, &k::BIAS_AZ_DEG, &k::BIAS_EL_DEG].map(|key| section.number(key));
            aim.zip(aim_from).zip(lag_s).zip(az.zip(el)).map(|(((aim, aim_from), lag_s), (az, el))| {
                Pointing::At { aim, aim_from, lag_s, bias_rad: [az.to_radians(), el.to_radians()] }
            })
        }
        Some(Servo(PointingKind::Scan)) => {
            let [rpm, start, elevation] =
                [&k::RPM, &k::START_DEG, &k::ELEVATION_DEG].map(|key| section.number(key));
            scan(
                &section,
                rpm.zip(start).zip(elevation).map(|((rpm, start), elevation)| ScanLaw::Rotation {
                    rate_rad_per_s: rpm / 60.0 * TAU,
                    start_rad: start.to_radians(),
                    elevation_rad: elevation.to_radians(),
                }),
            )
        }
        Some(Servo(PointingKind::Sector)) => {
            let law = sector(&section);
            scan(&section, law)
        }
        Some(Servo(PointingKind::Steps)) => {
            let law = steps(&section);
            scan(&section, law)
        }
        None => None,
    };
    section.finish();
    pointing
}

fn sector(section: &Section<'_>) -> Option<ScanLaw> {
    use keys::pointing as k;
    let [from, to, rate, turn] =
        [&k::FROM_DEG, &k::TO_DEG, &k::RATE_DEG_S, &k::TURN_MS].map(|key| section.number(key));
    let elevations =
        if section.has(&k::ELEVATIONS_DEG) { section.numbers(&k::ELEVATIONS_DEG) } else { Some(vec![0.0]) };
    if from.is_some() && from == to {
        let found = format!("{:?}", to.unwrap_or_default());
        section.fault(
            &k::TO_DEG,
            Problem::Range { found, allowed: "an azimuth other than from_deg".to_owned() },
        );
        return None;
    }
    Some(ScanLaw::Sector {
        from_rad: from?.to_radians(),
        to_rad: to?.to_radians(),
        rate_rad_per_s: rate?.to_radians(),
        turn_s: turn? / 1e3,
        elevations_rad: elevations?.into_iter().map(f64::to_radians).collect(),
    })
}

/// A beam that jumps; how long it stays is not known before the intervals of the radar are.
fn steps(section: &Section<'_>) -> Option<ScanLaw> {
    use keys::pointing as k;
    let azimuths = section.numbers(&k::AZIMUTHS_DEG);
    let elevations =
        if section.has(&k::ELEVATIONS_DEG) { section.numbers(&k::ELEVATIONS_DEG) } else { Some(vec![0.0]) };
    let dwell_pulses = section.count(&k::DWELL_PULSES);
    let (azimuths, mut elevations) = azimuths.zip(elevations)?;
    if elevations.len() == 1 {
        elevations.resize(azimuths.len(), elevations[0]);
    }
    if elevations.len() != azimuths.len() {
        let (found, allowed) = (
            format!("{} elevations", elevations.len()),
            format!("{}, one for each azimuth, or one for all", azimuths.len()),
        );
        section.fault(&k::ELEVATIONS_DEG, Problem::Type { found, allowed });
        return None;
    }
    let directions = azimuths.into_iter().zip(elevations);
    Some(ScanLaw::Steps {
        directions_rad: directions.map(|(az, el)| [az.to_radians(), el.to_radians()]).collect(),
        dwell_pulses: dwell_pulses?,
        dwell_s: 0.0,
    })
}

/// What scans of all kinds have in common.
fn scan(section: &Section<'_>, law: Option<ScanLaw>) -> Option<Pointing> {
    use keys::pointing as k;
    let north = section.choice(&k::ABOUT).map(|ScanFrom(north)| north);
    // A pedestal that goes with the deck knows no track.
    let level_by = if north == Some(true) { section.choice(&k::AIM_FROM).map(Some) } else { Some(None) };
    let [bias, noise] = [&k::ENCODER_BIAS_DEG, &k::ENCODER_NOISE_DEG].map(|key| section.number(key));
    let bits = if section.has(&k::ENCODER_BITS) {
        section.count(&k::ENCODER_BITS).map(|bits| u32::try_from(bits).ok())
    } else {
        Some(None)
    };
    north?;
    Some(Pointing::Scan(Scan {
        law: law?,
        level_by: level_by?,
        encoder: Encoder { bias_rad: bias?.to_radians(), noise_rad: noise?.to_radians(), bits: bits? },
    }))
}

/// An aim point of kind `at` or `beside`.
pub(super) fn aim(
    section: &Section<'_>,
    kind: AimKind,
    keys: &AimKeys,
    ground: &Ground,
    platforms: &Names,
) -> Option<Aim> {
    match kind {
        AimKind::At => {
            let position = place::above_sea(section, &keys.surface, ground);
            let [e, n, u] = section.vector(keys.velocity_mps)?;
            Some(Aim::Point { position: position?, velocity: Vector::new(e, n, u) })
        }
        AimKind::Beside => {
            let platform = platforms.find(section, keys.platform);
            let (along_m, across_m) = (section.number(keys.along_m), section.number(keys.across_m));
            Some(Aim::Beside { platform: platform?, along_m: along_m?, across_m: across_m? })
        }
    }
}
