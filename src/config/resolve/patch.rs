//! The patch of sea: its facets, and whether it stays.

use std::f64::consts::TAU;

use super::antenna::{self, AimKeys, aim_keys};
use super::place::SurfaceKeys;
use super::{Ground, Names};
use crate::config::choices::{Followed, PatchKind, SpeckleKind};
use crate::config::error::Problem;
use crate::config::keys::{self, MOST_FACETS};
use crate::config::section::Section;
use crate::scene::Patch;
use crate::scene::patch::{MAX_SIDE, PatchError};
use crate::scene::radar::{Aim, AimFrom, Pointing, Radar};
use crate::scene::sea::{PatchPlace, Speckle};
use crate::units::{SPEED_OF_LIGHT_MPS, common_divisor, is_product_of};

/// The patch by `[scene]`.
pub(super) struct PatchGiven {
    patch: Option<Patch>,
    /// `None` where it is faulty.
    place: Option<PlaceGiven>,
    /// Resolution in azimuth that facets are judged by, m.
    pub azimuth_m: Option<f64>,
}

enum PlaceGiven {
    Fixed,
    Follow(Aim, AimFrom),
    /// Wherever the first receiver aims.
    FollowReceiver,
}

/// Waves that so long a facet does not resolve are left to the tilts within it, m.
const FINEST_FOR_WAVES_M: f64 = 1.0;
/// Wind at 10 m over the friction velocity, about.
const WIND_PER_USTAR: f64 = 28.0;

/// The longest facet that will do, m, by what is written of radar and sea.
pub(super) fn longest_facet_m(root: &Section<'_>, azimuth_m: f64) -> Option<f64> {
    use crate::sea::GRAVITY_MPS2;
    use crate::sea::spectrum::sampling::{FACETS_PER_PEAK_WAVE, longest_facet_m};
    let of_radar = |radar: Section<'_>| {
        let of_waveform = |key| radar.peek_in(&keys::radar::WAVEFORM, key);
        let own_hz = of_waveform(&keys::waveform::BANDWIDTH_HZ);
        let chip_hz = || of_waveform(&keys::waveform::CHIP_S).map(f64::recip);
        own_hz.or_else(chip_hz).or_else(|| radar.peek(&keys::radar::SAMPLE_RATE_HZ))
    };
    let bandwidth_hz = root.within(&keys::root::RADAR).and_then(of_radar)?;
    let of_sea = |sea: Section<'_>| sea.peek_choice_in(&keys::sea::SCATTERING, &keys::scattering::SPECKLE);
    let speckle = match root.within(&keys::root::SEA).and_then(of_sea) {
        Some(SpeckleKind::Gaussian) => Speckle::Gaussian { tilt_modes: 1 },
        Some(SpeckleKind::RandomPhase) | None => Speckle::RandomPhase,
    };
    let range_m = 0.5 * SPEED_OF_LIGHT_MPS / bandwidth_hz;
    let of_sea = |key| root.peek_in(&keys::root::SEA, key);
    let wind_mps = of_sea(&keys::sea::WIND_MPS)
        .or_else(|| of_sea(&keys::sea::WIND_USTAR_MPS).map(|mps| WIND_PER_USTAR * mps))?;
    // Length of the wave at Elfouhaily's peak, m.
    let wave_m = TAU * (wind_mps / of_sea(&keys::sea::INVERSE_WAVE_AGE)?).powi(2) / GRAVITY_MPS2;
    let of_waves_m = (wave_m / FACETS_PER_PEAK_WAVE).max(FINEST_FOR_WAVES_M);
    Some(longest_facet_m([range_m, azimuth_m], speckle).min(of_waves_m))
}

/// The largest facet of at most a length that divides both sides, without large primes, of which transforms
/// are slow; sides count in millimetres.
fn dividing_m(size_m: [f64; 2], at_most_m: f64) -> f64 {
    let [x_mm, y_mm] = size_m.map(|side_m| (side_m * 1e3).round().clamp(1.0, 1e12) as usize);
    let common_m = common_divisor(x_mm, y_mm) as f64 / 1e3;
    let least = (common_m / at_most_m).ceil().clamp(1.0, 1e12) as usize;
    // More are refused in any case.
    let mut counts = least..=least.max(MAX_SIDE);
    common_m / counts.find(|n| is_product_of(&[2, 3, 5, 7], *n)).unwrap_or(least) as f64
}

/// Reads the keys of the patch; without a sea they are faults. `longest_m` is the longest facet that will do
/// for a resolution in azimuth.
pub(super) fn given(
    section: &Section<'_>,
    longest_m: impl FnOnce(f64) -> Option<f64>,
    has_sea: bool,
    ground: &Ground,
    platforms: &Names,
) -> PatchGiven {
    use keys::scene::{AZIMUTH_RESOLUTION_M, FACET_M, PATCH, PATCH_CENTRE_M, PATCH_FOLLOW, PATCH_SIZE_M};
    let follows = section.choice(&PATCH);
    let size_m = section.vector(&PATCH_SIZE_M);
    let azimuth_m = section.number(&AZIMUTH_RESOLUTION_M);
    let facet_m = if section.is_word(&FACET_M, "auto") {
        let longest_m = azimuth_m.and_then(longest_m);
        size_m.zip(longest_m).map(|(size_m, longest_m)| dividing_m(size_m, longest_m))
    } else {
        section.number(&FACET_M)
    };
    let centre_m = section.vector(&PATCH_CENTRE_M);
    let follow = section.section(&PATCH_FOLLOW).map(|section| follow(section, ground, platforms));
    let all = [&PATCH, &PATCH_SIZE_M, &FACET_M, &AZIMUTH_RESOLUTION_M, &PATCH_CENTRE_M, &PATCH_FOLLOW];
    if !has_sea {
        section.idle(&all, "there is no [sea]");
        return PatchGiven { patch: None, place: None, azimuth_m: None };
    }
    for key in [&PATCH_SIZE_M, &FACET_M].into_iter().filter(|key| !section.has(key)) {
        section.fault(key, Problem::Missing { allowed: key.kind.allowed() });
    }
    let (place, centre_m) = match follows {
        Some(PatchKind::Follow) => {
            section.idle(&[&PATCH_CENTRE_M], "patch = \"follow\"");
            let place = match (section.has(&PATCH_FOLLOW), follow.flatten()) {
                (false, _) => Some(PlaceGiven::FollowReceiver),
                (true, follow) => follow.map(|(aim, aim_from)| PlaceGiven::Follow(aim, aim_from)),
            };
            (place, Some([0.0, 0.0]))
        }
        Some(PatchKind::Fixed) => {
            section.idle(&[&PATCH_FOLLOW], "patch = \"fixed\"");
            (Some(PlaceGiven::Fixed), centre_m)
        }
        None => (None, centre_m),
    };
    let patch = match (size_m, facet_m, centre_m) {
        (Some(size_m), Some(facet_m), Some(centre_m)) => facets(section, size_m, facet_m, centre_m),
        _ => None,
    };
    PatchGiven { patch, place, azimuth_m }
}

fn facets(section: &Section<'_>, size_m: [f64; 2], facet_m: f64, centre_m: [f64; 2]) -> Option<Patch> {
    let report = |fault: PatchError| {
        use keys::scene::{FACET_M, PATCH_CENTRE_M, PATCH_SIZE_M};
        let (key, allowed) = match fault {
            PatchError::TooMany { axis, facets } => {
                let what = if axis == 'x' { "facets along x" } else { "facets along y" };
                // Rounded, and saturating beyond any memory.
                let problem = Problem::TooMany { count: facets as u64, what, allowed: MAX_SIDE as u64 };
                section.fault(&PATCH_SIZE_M, problem);
                return;
            }
            PatchError::Facet { .. } => (&FACET_M, "a length above 0"),
            PatchError::FacetLargerThanPatch { .. } => (&FACET_M, "a facet that fits into both sides"),
            PatchError::Size { .. } | PatchError::NotAMultiple { .. } => {
                (&PATCH_SIZE_M, "whole facets along both sides")
            }
            PatchError::Centre { .. } => (&PATCH_CENTRE_M, "a centre nearer to the origin"),
        };
        section.fault(key, Problem::Patch { fault, allowed });
    };
    // Each side by itself first, beside one that is right, so that both may be reported.
    let [x_m, y_m] = size_m;
    let sides = [[x_m, facet_m], [facet_m, y_m]].map(|side| Patch::new(side, facet_m, [0.0; 2]).err());
    if sides.iter().any(Option::is_some) {
        sides.into_iter().flatten().for_each(report);
        return None;
    }
    let patch = Patch::new(size_m, facet_m, centre_m).map_err(report).ok()?;
    let count = patch.facets[0] as u64 * patch.facets[1] as u64;
    if count > MOST_FACETS {
        let problem = Problem::TooMany { count, what: "facets", allowed: MOST_FACETS };
        section.fault(&keys::scene::PATCH_SIZE_M, problem);
        return None;
    }
    Some(patch)
}

fn follow(section: Section<'_>, ground: &Ground, platforms: &Names) -> Option<(Aim, AimFrom)> {
    use keys::patch_follow as k;
    let keys = aim_keys!(patch_follow);
    let aim = section
        .choice(&k::KIND)
        .and_then(|Followed(kind)| antenna::aim(&section, kind, &keys, ground, platforms));
    let aim_from = section.choice(&k::AIM_FROM);
    section.finish();
    Some((aim?, aim_from?))
}

impl PatchGiven {
    /// The patch and its place; `radar` is `None` where it is faulty.
    pub(super) fn place(
        self,
        section: &Section<'_>,
        radar: Option<&Radar>,
    ) -> (Option<Patch>, Option<PatchPlace>) {
        let place = match self.place {
            Some(PlaceGiven::Fixed) => Some(PatchPlace::Fixed),
            Some(PlaceGiven::Follow(aim, aim_from)) => Some(PatchPlace::Follow { aim, aim_from }),
            Some(PlaceGiven::FollowReceiver) => radar.and_then(|radar| {
                let first = radar.receivers.first().map(|receiver| &receiver.antenna.pointing);
                if let Some(Pointing::At { aim, aim_from, .. }) = first {
                    return Some(PatchPlace::Follow { aim: aim.clone(), aim_from: *aim_from });
                }
                let key = &keys::scene::PATCH_FOLLOW;
                let allowed = format!("{}, as the first receiver aims at no point", key.kind.allowed());
                section.fault(key, Problem::Missing { allowed });
                None
            }),
            None => None,
        };
        (self.patch, place)
    }
}
