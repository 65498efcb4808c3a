//! A sea in words.

use super::{Described, FAR_SEA, LAND, described};
use crate::adequacy::Adequacy;
use crate::inputs::shown;
use crate::scene::sea::{
    Averaging, BraggWaves, Breaking, FacetScattering, FarSea, LightWinds, Modulation, PatchPlace,
    Permittivity, Phases, Realisation, Sea, Shadowing, SlickShape, Speckle, Splitting, Waves,
};
use crate::scene::water::{
    Development, SpectrumKind, Spreading, Swell, SwellShape, Water, WindProfile, WindStrength,
};
use crate::scene::{Land, Scene};
use crate::units::neat;

/// What is modelled of the sea, and what is not and why.
pub(super) fn models(scene: &Scene, with: &mut Vec<Described>, without: &mut Vec<Described>) {
    let Some(sea) = &scene.sea else {
        without.push(described("sea", "no [sea]"));
        without.push(described(LAND, "no [sea] and [land]: no echo and no shadow of coasts"));
        return;
    };
    with.push(described("sea", patch_text(sea, &scene.platforms)));
    with.push(described("waves", waves_text(sea, scene.seed)));
    for swell in &sea.water.swell {
        with.push(described("swell", swell_text(swell)));
    }
    with.push(described("water", water_text(sea)));
    with.push(described("scattering", scattering_text(&sea.scattering)));
    match &sea.shadow {
        Some(shadow) => with.push(described("shadows", shadow_text(shadow))),
        None => without.push(described("shadows", "sea.shadow.enabled = false: nothing is hidden by waves")),
    }
    for slick in &sea.slicks {
        let shape = match &slick.shape {
            SlickShape::Ellipse { half_axes_m: [a, b], .. } => {
                format!("ellipse of {} m x {} m", 2.0 * a, 2.0 * b)
            }
            SlickShape::Polygon { corners_m } => format!("polygon of {} corners", corners_m.len()),
        };
        let text = format!(
            "{}: {shape}, rim {} m, covers {} % of the water, elasticity {} N/m",
            slick.name,
            slick.rim_m,
            neat(100.0 * slick.cover),
            slick.elasticity_npm
        );
        with.push(described("slick", text));
    }
    match sea.far {
        Some(FarSea { cells, most, texture }) => {
            let waves = if texture { "of waves in common" } else { "each of waves of its own" };
            with.push(described(
                FAR_SEA,
                format!(
                    "cells {waves} beyond the patch: {cells} in a resolution cell, at most {most} at a pulse"
                ),
            ));
            without.push(described(
                "more of the far sea",
                "main lobes alone; none from beyond the pulse interval; no breakers, wakes, films or land; linear waves that do not continue those of the patch",
            ));
        }
        None => without.push(described(FAR_SEA, "sea.far.enabled = false: the sea ends with the patch")),
    }
    match &sea.land {
        Some(land) => {
            with.push(described(LAND, land_text(land)));
            without.push(described(
                "land beyond the patch",
                "[land] returns and hides facets within the patch alone; it hides targets and ships, but no direct path or rain",
            ));
        }
        None => without.push(described(LAND, "no [land]: no echo and no shadow of coasts")),
    }
    let scattering = &sea.scattering;
    let frozen = scattering.bragg == BraggWaves::Frozen;
    if frozen {
        let how = "sea.scattering.bragg = \"frozen\": echoes have the Doppler of the resolved waves alone";
        without.push(described("Doppler of Bragg waves", how));
    }
    if scattering.modulation == Modulation::Off {
        let how = "sea.scattering.modulation = \"off\": as rough on every face of a wave, the same echo upwind and downwind";
        without.push(described("modulation of Bragg waves", how));
    }
    let how = match sea.waves {
        Waves::Linear => "sea.waves = \"linear\": crests and troughs symmetric, zero skewness",
        Waves::Choppy => {
            "sea.waves = \"choppy\": waves of ships stay linear, and shadows and breakers are found on linear waves"
        }
    };
    without.push(described("steepness of waves", how));
    if frozen && scattering.decorrelation_s.is_none() {
        without.push(described(
            "decorrelation",
            "no sea.scattering.decorrelation_ms: phases of facets are frozen",
        ));
    }
    if matches!(sea.water.spectrum, SpectrumKind::Measured { tail: false, .. }) {
        let how = "sea.spectrum_tail = \"none\": no waves beyond the file, so that nothing scatters by Bragg where it ends before the radar's \
                   Bragg waves";
        without.push(described("short waves", how));
    }
    if scattering.light_wind == LightWinds::AsPublished {
        let how = "sea.scattering.light_wind = \"published\": below some 5 m/s a weaker wind may return more";
        without.push(described("threshold wind of Bragg waves", how));
    }
    if !scattering.tilt_average && scattering.splitting == Splitting::Consistent {
        let how = "sea.scattering.tilt_average = false: what the sea returns depends on the size of facets";
        without.push(described("tilts within a facet", how));
    }
    if !scattering.displacement {
        let how = "sea.scattering.displacement = false: facets move up and down only";
        without.push(described("orbital displacement", how));
    }
    if sea.slicks.is_empty() {
        without.push(described("slicks", "no [[slick]]"));
    }
    if scattering.breaking == Breaking::Off {
        let how = "sea.scattering.breaking = \"off\": no sea spikes, low HH at low grazing angles";
        without.push(described("breaking waves", how));
    }
    let how = match scattering.bragg {
        BraggWaves::Travelling { drift_share, .. } if drift_share > 0.0 => {
            "the drift of the wind moves what scatters, not waves, slicks and wakes"
        }
        _ => "the water as a whole is at rest, slicks with it",
    };
    without.push(described("currents and drift", how));
}

/// The figures that follow from the wind and the geometry.
pub fn rows(adequacy: &Adequacy) -> Vec<Described> {
    let mut rows = vec![described(
        "wind",
        format!(
            "{:.2} m/s at 10 m, {:.2} at 12.5 m, {:.2} at 19.5 m; friction velocity {:.3} m/s{}",
            adequacy.u10_mps,
            adequacy.u12_5_mps,
            adequacy.u19_5_mps,
            adequacy.ustar_mps,
            if adequacy.calm { "; too weak to raise waves" } else { "" }
        ),
    )];
    rows.push(match adequacy.peak_wavelength_m {
        Some(peak_m) => described(
            "waves",
            format!(
                "significant height {:.2} m expected; peak wavelength {peak_m:.1} m; patch side at least {:.0} m",
                adequacy.significant_height_m, adequacy.least_length_m
            ),
        ),
        None => described("waves", "none: the sea is flat"),
    });
    let azimuth_m = adequacy.azimuth_resolution_m;
    rows.push(match (adequacy.ground_range_m, adequacy.facets_per_cell) {
        (Some(range_m), Some(facets)) => described(
            "resolution cell",
            format!("{range_m:.2} m ground range x {azimuth_m} m azimuth: {facets:.1} facets"),
        ),
        _ => described("resolution cell", "range does not resolve the ground at the centre of the patch"),
    });
    let part = match format!("{:.0}", 100.0 * adequacy.share_in_window).as_str() {
        "100" => "the whole patch".to_owned(),
        percent => format!("at least {percent} % of the patch"),
    };
    rows.push(described("in the window", format!("the receive window holds the full echo of {part}")));
    if let Some(edge_db) = adequacy.edge_db {
        rows.push(described(
            "edge of the patch",
            format!("facets entering and leaving contribute at most {edge_db:.0} dB of the sea echo"),
        ));
    }
    rows
}

fn patch_text(sea: &Sea, platforms: &[String]) -> String {
    let [nx, ny] = sea.patch.facets;
    let [x_m, y_m] = sea.patch.size_m().map(neat);
    let place = match &sea.place {
        PatchPlace::Fixed => {
            let middle = [0, 1].map(|axis| sea.patch.first[axis] + (sea.patch.facets[axis] / 2) as i64);
            let [e, n] = sea.patch.centre_m(middle).map(neat);
            format!("about {e} m East, {n} m North")
        }
        PatchPlace::Follow { aim, .. } => {
            format!("following {}; waves repeat with its size", super::aim_text(aim, platforms))
        }
    };
    format!("{nx} x {ny} facets of {} m, {x_m} m x {y_m} m, {place}", sea.patch.facet_m)
}

fn land_text(land: &Land) -> String {
    let db = |ratio: f64| neat((1e3 * ratio.log10()).round() / 100.0);
    format!(
        "above {} m in {}; constant gamma of {} dB (VV), HH {} dB and cross-polarisation {} dB over it",
        land.sea_level_m,
        shown(&land.dem),
        db(land.gamma),
        db(land.hh_over_vv),
        db(land.cross_over_vv)
    )
}

fn waves_text(sea: &Sea, seed: u64) -> String {
    let Water { wind, spectrum, dispersion, .. } = &sea.water;
    let strength = match wind.strength {
        WindStrength::FrictionVelocity { ustar_mps } => format!("friction velocity {ustar_mps} m/s"),
        WindStrength::Speed { speed_mps, height_m } => format!("{speed_mps} m/s at {height_m} m"),
    };
    let profile = match wind.profile {
        WindProfile::Cardone => "Cardone's profile",
        WindProfile::Wu => "Wu's profile",
    };
    let from_deg = from_deg(wind.direction_rad);
    let growth = |development: &Development| match development {
        Development::InverseWaveAge(age) => format!("inverse wave age {age}"),
        Development::Fetch(fetch_m) => format!("fetch {} km", neat(fetch_m / 1e3)),
    };
    let spread = |spreading: &Spreading| match spreading {
        Spreading::Constant(exponent) => format!("spreading exponent {exponent}"),
        Spreading::Mitsuyasu => "Mitsuyasu's spreading".to_owned(),
        Spreading::LikeElfouhaily => "spreading like Elfouhaily's".to_owned(),
    };
    let spectrum = match spectrum {
        SpectrumKind::Elfouhaily { development } => format!("Elfouhaily, {}", growth(development)),
        SpectrumKind::FungLee => "Fung and Lee (for backscatter, not for energy)".to_owned(),
        SpectrumKind::ElfouhailyFungLee { development } => {
            format!("Elfouhaily with directions of Fung and Lee, {}", growth(development))
        }
        SpectrumKind::PiersonMoskowitz { spreading } => format!("Pierson-Moskowitz, {}", spread(spreading)),
        SpectrumKind::Jonswap { fetch_m, spreading } => {
            format!("JONSWAP, fetch {} km, {}", neat(fetch_m / 1e3), spread(spreading))
        }
        SpectrumKind::Measured { path, tail: true } => {
            format!(
                "measured, {}, with Elfouhaily's waves of the wind beyond its last wave number",
                shown(path)
            )
        }
        SpectrumKind::Measured { path, tail: false } => format!("measured, {}", shown(path)),
    };
    let drawn = match &sea.realisation {
        Realisation::Drawn { averaging } => {
            let how = match averaging {
                Averaging::Automatic => "",
                Averaging::Points => " at points",
                Averaging::Cells => " as means over cells",
            };
            format!("drawn{how} from seed {seed}")
        }
        Realisation::Saved { path } => format!("saved state {}", shown(path)),
    };
    let depth = dispersion.depth_m.map_or("deep water".to_owned(), |depth_m| format!("{depth_m} m deep"));
    let shape = match sea.waves {
        Waves::Linear => "",
        Waves::Choppy => ", choppy waves of second order",
    };
    let tension = if dispersion.capillary { ", surface tension" } else { "" };
    format!(
        "{spectrum}; wind {strength} in {profile}, from {from_deg} deg ({}); {depth}{tension}{shape}; {drawn}",
        point_of_compass(from_deg)
    )
}

/// Where something comes from, degrees clockwise from North, that goes towards an angle from East, rad.
fn from_deg(towards_rad: f64) -> f64 {
    neat((270.0 - neat(towards_rad.to_degrees())).rem_euclid(360.0))
}

/// The nearest of 16 points of the compass, of degrees clockwise from North.
fn point_of_compass(deg: f64) -> &'static str {
    const POINTS: [&str; 16] = [
        "North", "NNE", "NE", "ENE", "East", "ESE", "SE", "SSE", "South", "SSW", "SW", "WSW", "West", "WNW",
        "NW", "NNW",
    ];
    POINTS[(deg.rem_euclid(360.0) / 22.5).round() as usize % 16]
}

fn swell_text(swell: &Swell) -> String {
    let shape = match swell.shape {
        SwellShape::Gaussian { relative_width } => format!("Gaussian of relative width {relative_width}"),
        SwellShape::Jonswap { peak_enhancement } => {
            format!("JONSWAP shape, peak enhancement {peak_enhancement}")
        }
    };
    let from_deg = from_deg(swell.direction_rad);
    format!(
        "significant height {} m, period {} s, from {from_deg} deg ({}), spread {} deg, {shape}",
        swell.significant_height_m,
        swell.peak_period_s,
        point_of_compass(from_deg),
        neat(swell.spread_rad.to_degrees())
    )
}

fn water_text(sea: &Sea) -> String {
    let model = match sea.scattering.permittivity {
        Permittivity::MeissnerWentz => "Meissner and Wentz 2012",
        Permittivity::KleinSwift => "Klein and Swift 1977",
        Permittivity::ItuRP527 => "ITU-R P.527-6",
    };
    format!("{} C, {} psu, permittivity of {model}", sea.water.temperature_c, sea.water.salinity_psu)
}

fn scattering_text(scattering: &FacetScattering) -> String {
    let mut text = match scattering.splitting {
        Splitting::Consistent => "Bragg and specular, no wave counted in two scales".to_owned(),
        Splitting::Mars2007 => {
            "Bragg and specular as in the MaRS paper, resolved slopes counted twice".to_owned()
        }
    };
    if let Some(cut_radpm) = scattering.cut_radpm {
        text += &format!(", divided at {cut_radpm} rad/m");
    }
    if scattering.tilt_average {
        text += ", averaged over tilts within a facet";
    }
    if scattering.gram_charlier {
        text += ", skewed and peaked slopes (Gram-Charlier)";
    }
    text += match scattering.phases {
        Phases::PolCoherent => "; independent random phases of the Bragg and the specular part",
        Phases::Single => "; one random phase",
    };
    if let Speckle::Gaussian { tilt_modes } = scattering.speckle {
        text += "; facets of Gaussian amplitude";
        if scattering.tilt_average {
            text += &format!(" in {tilt_modes} modes of tilt");
        }
    }
    if let BraggWaves::Travelling { drift_share, drift_turn_rad } = scattering.bragg {
        text += "; Bragg waves travel both ways by the spectrum";
        if drift_share > 0.0 {
            text += &format!(", with a drift of {} % of the wind", neat(100.0 * drift_share));
            if drift_turn_rad != 0.0 {
                text += &format!(" turned by {} deg", neat(drift_turn_rad.to_degrees()));
            }
        }
    }
    if scattering.breaking == Breaking::Whitecaps {
        text += "; waves break on steep crests, as many as whitecaps cover";
    }
    if let Modulation::Relaxation { rate_per_s } = scattering.modulation {
        text += "; long waves modulate them, ";
        text += &match rate_per_s {
            Some(rate_per_s) => format!("relaxing at {} 1/s", neat(rate_per_s)),
            None => "relaxing at their growth rate".to_owned(),
        };
    }
    if let Some(decorrelation_s) = scattering.decorrelation_s {
        text += &format!(", forgotten in {} ms", neat(1e3 * decorrelation_s));
    }
    text
}

fn shadow_text(shadow: &Shadowing) -> String {
    let edge = match shadow.width_rad {
        Some(0.0) => "sharp edge".to_owned(),
        Some(width_rad) => format!("soft edge of {width_rad} rad"),
        None => "soft edge, its width from the map".to_owned(),
    };
    let update_ms = (1e6 * shadow.update_s).round() / 1e3;
    let two_rays = if shadow.two_rays { "; the mean sea reflects onto facets" } else { "" };
    format!(
        "{edge}, {} rays per facet, updated every {} ms{two_rays}",
        shadow.rays_per_facet,
        neat(update_ms)
    )
}
