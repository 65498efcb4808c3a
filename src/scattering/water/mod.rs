//! The water of a scene: which kind of surface a facet is, and what facets of each kind return.
//!
//! Kinds are numbered: 0 clean, then the slicks in the order of the scene, then the water stirred by its
//! ships. A facet belongs to the slick or strip that covers most of its centre (the first of equals), to the
//! share it covers; where none does, it is clean.
//!
//! Besides the waves of the wind those of ships may scatter that the map leaves out
//! ([`short_waves`](crate::sea::wake::short_waves)): where the facet is, which way its Bragg wave runs,
//! decides.
//!
//! Spectrum, slope variances and the local axes of facets are counted from the direction the wind blows
//! towards, so that turning scene, wind and radar together changes nothing.
//!
//! ```
//! use nereus::scattering::water::{Sight, WaterScattering};
//! use nereus::scene::water::{Development, SpectrumKind, WindGiven, WindProfile, WindStrength};
//! use nereus::scene::{Patch, Sea, Water};
//! use nereus::sea::realise::realise;
//! let wind = WindGiven {
//!     strength: WindStrength::Speed { speed_mps: 8.0, height_m: 10.0 },
//!     profile: WindProfile::Cardone,
//!     direction_rad: 0.5,
//! };
//! let water = Water::new(wind, SpectrumKind::Elfouhaily { development: Development::default() });
//! let sea = Sea::new(water, Patch::new([16.0, 16.0], 1.0, [0.0, 0.0])?);
//! let realised = realise(&sea, 1)?;
//! let sight = Sight { carrier_hz: 10e9, seed: 1 };
//! let water = WaterScattering::new(&sea, &realised.wind, realised.spectrum.into(), &[], sight)?;
//! // The specular part, and the Bragg part of nine tilts.
//! assert_eq!((water.kinds(), water.mechanisms()), (1, 10));
//! assert_eq!(water.kind_at([10.0, 20.0], &[]), (0, 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod phasors;

use std::sync::Arc;

use glam::DVec3;
use num_complex::{Complex32, Complex64};

use crate::cpu::Variant;
use crate::geometry::lanes::{Row, WideRow};
use crate::scattering::batch::{Batch, batch};
use crate::scattering::bragg::{BraggLines, Setting};
use crate::scattering::facets::{Facets, LengthError, Phases};
use crate::scattering::kind::clean::Clean;
use crate::scattering::kind::slick::Slick;
use crate::scattering::kind::turbulent_wake::{RatioError, TurbulentWake};
use crate::scattering::lanes::table::{BraggTable, Density, MOST_RELATIVE_ERROR};
use crate::scattering::lanes::{LaneModulation, LaneWater};
use crate::scattering::modes::TiltModes;
use crate::scattering::modulation::{self, TiltBias};
use crate::scattering::permittivity::{Model, PermittivityError, SeaWater};
use crate::scattering::speckle::Speckle;
use crate::scattering::splitting::high_pass;
use crate::scattering::two_rays::TwoRays;
use crate::scattering::two_scale::{Medium, Settings, TwoScale};
use crate::scene::sea::{self, BraggWaves, LightWinds, Permittivity, SlickRegion};
use crate::scene::water::{Development, SpectrumKind, WindGiven, WindStrength};
use crate::scene::{Sea, Water};
use crate::sea::fleet::Strip;
use crate::sea::spectrum::{LightWind, Spectrum, SpectrumError, WaveVector, of_kind};
use crate::sea::surface::modulation::Strength;
use crate::sea::wake::course::Pose;
use crate::sea::wake::{ShortWaveNodes, ShortWaves};
use crate::sea::wind::{Wind, WindError};

/// Why water cannot scatter.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WaterError {
    /// Water or carrier out of range.
    #[error(transparent)]
    Permittivity(#[from] PermittivityError),
    /// The wind in a strip.
    #[error("wake of a ship: {0}")]
    Wind(#[from] WindError),
    /// The spectrum in a strip.
    #[error("wake of a ship: {0}")]
    Spectrum(#[from] SpectrumError),
    /// Its ratio to that outside.
    #[error("wake of a ship: {0}")]
    Ratio(#[from] RatioError),
}

/// What the water is looked at with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Seed of the facets' phases.
    pub seed: u64,
}

/// Every kind of water of a scene.
pub struct WaterScattering {
    kinds: Vec<Box<dyn Batch>>,
    /// Regions of kinds 1 onwards, with their bounds.
    regions: Vec<(SlickRegion, [[f64; 2]; 2])>,
    /// Strips of the kinds after these.
    strips: Vec<Strip>,
    /// Ships whose short waves scatter beside those of the wind.
    short_waves: Vec<ShortWaveNodes>,
    /// Direction the wind blows towards.
    downwind: [f64; 2],
    phases: Phases,
    speckle: Speckle,
    /// Of facets of Gaussian amplitude.
    modes: Option<TiltModes>,
    travelling: Option<BraggLines>,
    relaxation_per_s: Option<f64>,
    /// Of the waves of the map.
    strength: Strength,
    bias: TiltBias,
    seed: u64,
    mechanisms: usize,
    tilt_variances: [f64; 2],
    permittivity: Complex64,
    wavenumber_radpm: f64,
    pub(in crate::scattering) cut_radpm: Option<f64>,
    spectrum: Arc<dyn Spectrum>,
}

/// The furthest astern of a ship and the nearest to its track that a rectangle reaches, m.
fn nearest([[x0, x1], [y0, y1]]: [[f64; 2]; 2], pose: &Pose) -> [f64; 2] {
    let corners = [[x0, y0], [x0, y1], [x1, y0], [x1, y1]].map(|corner| pose.astern_starboard_m(corner));
    let [mut astern_m, mut port_m, mut starboard_m] = [f64::NEG_INFINITY; 3];
    for [x, y] in corners {
        astern_m = astern_m.max(x);
        port_m = port_m.max(-y);
        starboard_m = starboard_m.max(y);
    }
    // On both sides of the track, or on one.
    [astern_m, (-port_m.min(starboard_m)).max(0.0)]
}

/// Least wave number by which a tilted facet scatters over that of the mean sea: wedges of short waves are
/// drawn so much wider.
const OF_TILTED: f64 = 0.5;
/// Longest wave of which a strip knows the damping, rad/m.
const LONGEST_STIRRED_RADPM: f64 = 0.5;

/// Water in which only a part of the wind at 10 m raises the short waves. A measured spectrum does not show
/// what less wind would do; the ratio is then that of Elfouhaily's.
fn stirred(
    water: &Water,
    light_wind: LightWinds,
    wind: &Wind,
    wind_ratio: f64,
    shortest_radpm: f64,
) -> Result<TurbulentWake, WaterError> {
    let strength = WindStrength::Speed { speed_mps: wind.u10_mps * wind_ratio, height_m: 10.0 };
    let weaker = Wind::resolve(&WindGiven { strength, ..water.wind })?;
    let kind = match &water.spectrum {
        SpectrumKind::Measured { .. } => SpectrumKind::Elfouhaily { development: Development::default() },
        kind => kind.clone(),
    };
    let of_wind = |wind: &Wind| -> Result<Box<dyn Spectrum>, SpectrumError> {
        match light_wind {
            LightWinds::Threshold => Ok(Box::new(LightWind::new(&kind, wind)?)),
            LightWinds::AsPublished => of_kind(&kind, wind),
        }
    };
    let (inside, outside) = (of_wind(&weaker)?, of_wind(wind)?);
    let range = [LONGEST_STIRRED_RADPM, shortest_radpm.max(2.0 * LONGEST_STIRRED_RADPM)];
    let ratio = |k: f64| {
        let clean = outside.omnidirectional_m3(k);
        if clean > 0.0 { inside.omnidirectional_m3(k) / clean } else { 1.0 }
    };
    Ok(TurbulentWake::new(range, ratio)?)
}

/// Clean water at a carrier, with the wind's direction as its axis.
fn medium(sea: &Sea, wind: &Wind, carrier_hz: f64) -> Result<Medium, WaterError> {
    let Water { temperature_c, salinity_psu, .. } = sea.water;
    let model = match sea.scattering.permittivity {
        Permittivity::MeissnerWentz => Model::MeissnerWentz2012,
        Permittivity::KleinSwift => Model::KleinSwift1977,
        Permittivity::ItuRP527 => Model::ItuRP527,
    };
    let sea_water = SeaWater { temperature_c, salinity_gpkg: salinity_psu };
    let (sin, cos) = wind.direction_rad.sin_cos();
    Ok(Medium {
        carrier_hz,
        permittivity: model.permittivity(carrier_hz, sea_water)?,
        wind_12p5_mps: wind.u12_5_mps,
        downwind_rad: 0.0,
        resolved_radpm: std::f64::consts::PI / sea.patch.facet_m,
        axis: DVec3::new(cos, sin, 0.0),
    })
}

/// The lines of travelling Bragg waves; `None` where they are frozen.
fn bragg_lines<F: Fn(f64, f64) -> f64>(
    sea: &Sea,
    wind: &Wind,
    spectrum: &dyn Spectrum,
    clean: &TwoScale<Clean, F>,
    seed: u64,
) -> Option<BraggLines> {
    let BraggWaves::Travelling { drift_share, drift_turn_rad } = sea.scattering.bragg else { return None };
    let (north, east) = (wind.direction_rad + drift_turn_rad).sin_cos();
    let (sin, cos) = wind.direction_rad.sin_cos();
    let medium = clean.medium();
    let setting = Setting {
        spectrum,
        dispersion: sea.water.dispersion,
        downwind: [cos, sin],
        drift_mps: [east, north].map(|c| drift_share * wind.u10_mps * c),
        wavenumber_radpm: medium.wavenumber_radpm(),
        resolved_radpm: medium.resolved_radpm,
        cut_radpm: clean.cut_radpm(),
        decorrelation_s: sea.scattering.decorrelation_s,
        gaussian: sea.scattering.speckle != sea::Speckle::RandomPhase,
        seed,
    };
    Some(BraggLines::new(&setting, clean.tilt_variances()))
}

impl WaterScattering {
    /// Prepares every kind: permittivity, moments of the unresolved waves.
    ///
    /// # Errors
    /// Water or carrier outside the range of the permittivity model; a strip whose wind raises no spectrum.
    pub fn new(
        sea: &Sea,
        wind: &Wind,
        spectrum: Arc<dyn Spectrum>,
        strips: &[Strip],
        sight: Sight,
    ) -> Result<Self, WaterError> {
        let Sea { scattering: settings, slicks, .. } = sea;
        let (sin, cos) = wind.direction_rad.sin_cos();
        let medium = medium(sea, wind, sight.carrier_hz)?;
        let two_scale = Settings {
            splitting: settings.splitting,
            cut_radpm: settings.cut_radpm,
            tilt_average: settings.tilt_average,
            gram_charlier: settings.gram_charlier,
        };
        let psi = || {
            let spectrum = Arc::clone(&spectrum);
            move |along: f64, across: f64| {
                spectrum.symmetric_m4(WaveVector::new(cos * along - sin * across, sin * along + cos * across))
            }
        };
        let mut clean = TwoScale::new(two_scale, medium, Clean, psi());
        let relaxation_per_s =
            modulation::rate_per_s(settings.modulation, medium.wavenumber_radpm(), wind.ustar_wu_mps);
        if let Some(relaxation_per_s) = relaxation_per_s {
            let wave_psi = |along: f64, across: f64| {
                spectrum.wave_m4(WaveVector::new(cos * along - sin * across, sin * along + cos * across))
            };
            clean = clean.modulated(wave_psi, sea.water.dispersion, relaxation_per_s);
        }
        let bias = clean.tilt_bias();
        let (mechanisms, cut_radpm) = (1 + clean.tilts(), clean.cut_radpm());
        let modes = match settings.speckle {
            sea::Speckle::RandomPhase => None,
            sea::Speckle::Gaussian { tilt_modes } => {
                let tilts: Vec<_> = clean.lane_tilts().iter().map(|tilt| tilt.map(f64::from)).collect();
                Some(TiltModes::new(&tilts, tilt_modes))
            }
        };
        let tilt_variances = clean.tilt_variances();
        let travelling = bragg_lines(sea, wind, spectrum.as_ref(), &clean, sight.seed);
        let mut kinds = vec![batch(two_scale, medium, Clean, psi(), bias)];
        let mut regions = Vec::with_capacity(slicks.len());
        for slick in slicks {
            let kind = Slick { elasticity_npm: slick.elasticity_npm };
            kinds.push(batch(two_scale, medium, kind, psi(), bias));
            let rim_m = 0.5 * slick.rim_m;
            let bounds = slick.shape.bounds_m().map(|[from, to]| [from - rim_m, to + rim_m]);
            regions.push((slick.clone(), bounds));
        }
        for strip in strips {
            let kind = stirred(
                &sea.water,
                settings.light_wind,
                wind,
                strip.wind_ratio,
                2.0 * medium.wavenumber_radpm(),
            )?;
            kinds.push(batch(two_scale, medium, kind, psi(), bias));
        }
        let speckle = match settings.decorrelation_s {
            Some(time_s) if travelling.is_none() => Speckle::Decorrelating { time_s },
            _ => Speckle::Frozen,
        };
        Ok(Self {
            kinds,
            regions,
            strips: strips.to_vec(),
            short_waves: Vec::new(),
            downwind: [cos, sin],
            phases: settings.phases,
            speckle,
            modes,
            travelling,
            relaxation_per_s,
            strength: Strength::default(),
            bias: bias.unwrap_or_default(),
            seed: sight.seed,
            mechanisms,
            tilt_variances,
            permittivity: medium.permittivity,
            wavenumber_radpm: medium.wavenumber_radpm(),
            cut_radpm,
            spectrum,
        })
    }

    /// The spectrum that scatters from clean water, as facets side by side ask it: a table where one holds
    /// it.
    fn bragg_table(&self) -> BraggTable {
        let table = self.kinds[0].bragg_table();
        // Half an octave below the cutoff the high pass is closed.
        let lowest_radpm = self.cut_radpm.map_or(0.0, |cut| cut * std::f64::consts::FRAC_1_SQRT_2);
        if self.spectrum.smooth_from_rad_m() <= lowest_radpm
            && table.worst_relative_error() <= MOST_RELATIVE_ERROR
        {
            return table;
        }
        table.with_spectrum(self.bragg_density())
    }

    /// The spectrum that scatters from clean water, high pass included, at a wave vector on the axes of the
    /// wind, m^4.
    pub(in crate::scattering) fn bragg_density(&self) -> Density {
        let (spectrum, cut_radpm) = (Arc::clone(&self.spectrum), self.cut_radpm);
        let [cos, sin] = self.downwind;
        Arc::new(move |along, across| {
            let pass = cut_radpm.map_or(1.0, |cut| high_pass(along.hypot(across), cut));
            if pass == 0.0 {
                return 0.0;
            }
            let k = WaveVector::new(cos * along - sin * across, sin * along + cos * across);
            pass * spectrum.symmetric_m4(k)
        })
    }

    /// The same water for facets side by side.
    pub fn lanes(&self) -> LaneWater {
        let table = self.bragg_table();
        let contrast = self.permittivity - 1.0;
        LaneWater {
            wavenumber_radpm: self.wavenumber_radpm as f32,
            contrast: Complex32::new(contrast.re as f32, contrast.im as f32),
            axis: self.downwind.map(|c| c as f32),
            phases: self.phases,
            tilts: self.kinds[0].lane_tilts(),
            cut_radpm: self.cut_radpm,
            kinds: self.kinds.iter().map(|kind| kind.lane_kind(&table)).collect(),
            modulation: self.relaxation_per_s.map(|_| LaneModulation::new(&self.strength, &self.bias)),
            table: Arc::new(table),
        }
    }

    /// The same beside the short waves of ships ([`short_waves`](crate::sea::wake::short_waves)):
    /// [`Self::scatter_at`] has them.
    pub fn with_short_waves(self, short_waves: Vec<ShortWaves>) -> Self {
        Self { short_waves: short_waves.into_iter().map(ShortWaveNodes::new).collect(), ..self }
    }

    /// The same modulated by the waves of a map, of which it is the [`Strength`].
    pub fn with_strength(self, strength: Strength) -> Self {
        Self { strength, ..self }
    }

    /// Rate at which the modulated waves relax, 1/s, if they are.
    pub fn relaxation_per_s(&self) -> Option<f64> {
        self.relaxation_per_s
    }

    /// Modulation by the waves of the map.
    pub fn strength(&self) -> &Strength {
        &self.strength
    }

    /// The spectrum that scatters, and whose waves are resolved.
    pub fn spectrum(&self) -> &dyn Spectrum {
        self.spectrum.as_ref()
    }

    /// Variances of the slopes within a facet, along and across the wind.
    pub fn tilt_variances(&self) -> [f64; 2] {
        self.tilt_variances
    }

    /// The sea as its own mirror, of waves of a standard deviation, m.
    pub fn two_rays(&self, height_rms_m: f64) -> TwoRays {
        let [up, across] = self.tilt_variances;
        let slope_rms = (0.5 * (up + across)).sqrt();
        TwoRays { wavenumber_radpm: self.wavenumber_radpm, height_rms_m, slope_rms }
    }

    /// Kinds of surface, the clean one included.
    pub fn kinds(&self) -> usize {
        self.kinds.len()
    }

    /// Relative permittivity of the water.
    pub fn permittivity(&self) -> Complex64 {
        self.permittivity
    }

    /// Where the ships of the strips and those of the short waves are, `t_s` after pulse 0: for
    /// [`Self::kind_at`] and [`Self::scatter_at`].
    pub fn poses(&self, t_s: f64, out: &mut Vec<Pose>) {
        out.clear();
        out.extend(self.strips.iter().map(|strip| strip.pose(t_s)));
        out.extend(self.short_waves.iter().map(|waves| waves.course().pose(t_s)));
    }

    /// Symmetrised spectrum of the short waves of all ships at a place, for a wave vector East and North,
    /// with ships at these poses, m^4. Ships' spectra add: their waves have no phase in common that lasts.
    pub fn short_wave_psi_m4(&self, place_m: [f64; 2], [kx, ky]: [f64; 2], poses: &[Pose]) -> f64 {
        let poses = poses.get(self.strips.len()..).unwrap_or(&[]);
        let of_ship = |(nodes, pose): (&ShortWaveNodes, &Pose)| {
            let [cos, sin] = pose.ahead;
            nodes.waves().psi_m4(pose.astern_starboard_m(place_m), [kx * cos + ky * sin, ky * cos - kx * sin])
        };
        self.short_waves.iter().zip(poses).map(of_ship).sum()
    }

    /// Kind of the facet centred on a place, and the share of it that the kind covers, with ships at these
    /// poses.
    pub fn kind_at(&self, place_m: [f64; 2], poses: &[Pose]) -> (usize, f64) {
        let mut most = (0, 0.0);
        for (kind, (region, bounds)) in (1..).zip(&self.regions) {
            let near = [0, 1].into_iter().all(|i| (bounds[i][0]..=bounds[i][1]).contains(&place_m[i]));
            if near {
                let cover = region.cover_at(place_m);
                if cover > most.1 {
                    most = (kind, cover);
                }
            }
        }
        for (kind, (strip, pose)) in (1 + self.regions.len()..).zip(self.strips.iter().zip(poses)) {
            let cover = strip.cover(place_m, pose);
            if cover > most.1 {
                most = (kind, cover);
            }
        }
        most
    }

    /// Whether any facet centred in a rectangle (least and largest x, and y) may be of another kind than
    /// clean water.
    pub fn kinds_within(&self, bounds_m: [[f64; 2]; 2], poses: &[Pose]) -> bool {
        let [[x0, x1], [y0, y1]] = bounds_m;
        let of_slicks = self
            .regions
            .iter()
            .any(|(_, [[u0, u1], [v0, v1]])| *u0 <= x1 && x0 <= *u1 && *v0 <= y1 && y0 <= *v1);
        of_slicks || self.strips.iter().zip(poses).any(|(strip, pose)| strip.is_near(bounds_m, pose))
    }

    /// Scattering matrices of a batch of one kind, sqrt(m^2), in the order `vv, vh, hv, hh`.
    ///
    /// # Errors
    /// An array whose length does not fit the number of facets.
    pub fn scatter(
        &self,
        kind: usize,
        facets: &Facets,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        self.kinds[kind].scatter(facets, self.phases, out)
    }

    /// The same at places, with the short waves of ships at these poses.
    ///
    /// # Errors
    /// An array whose length does not fit the number of facets.
    pub fn scatter_at(
        &self,
        kind: usize,
        facets: &Facets,
        place_m: impl Fn(usize) -> [f64; 2],
        poses: &[Pose],
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        if self.short_waves.is_empty() {
            return self.scatter(kind, facets, out);
        }
        let beside = |i: usize, along: f64, across: f64| self.beside_m4(place_m(i), [along, across], poses);
        self.kinds[kind].scatter_beside(facets, self.phases, &beside, out)
    }

    /// Whether ships have short waves that scatter.
    pub fn has_short_waves(&self) -> bool {
        !self.short_waves.is_empty()
    }

    /// Whether short waves of a ship may scatter within a rectangle (least and largest x, and y), where the
    /// mean sea scatters by wave numbers of `least_radpm` and more.
    pub fn short_waves_within(&self, bounds_m: [[f64; 2]; 2], poses: &[Pose], least_radpm: f64) -> bool {
        let poses = poses.get(self.strips.len()..).unwrap_or(&[]);
        let within = |(nodes, pose): (&ShortWaveNodes, &Pose)| {
            nodes.wedge(OF_TILTED * least_radpm).holds(nearest(bounds_m, pose))
        };
        self.short_waves.iter().zip(poses).any(within)
    }

    /// Wave number of the carrier, rad/m.
    pub fn wavenumber_radpm(&self) -> f64 {
        self.wavenumber_radpm
    }

    /// Spectrum of the short waves of ships at a place and a wave vector on the axes of the wind, m^4.
    fn beside_m4(&self, place_m: [f64; 2], [along, across]: [f64; 2], poses: &[Pose]) -> f64 {
        let [cos, sin] = self.downwind;
        let k = [cos * along - sin * across, sin * along + cos * across];
        self.short_wave_psi_m4(place_m, k, poses)
    }

    /// The same of the first facets side by side, by nodes ([`ShortWaveNodes`]); returns whether any may have
    /// such waves. All facets lie in a rectangle (least and largest x, and y).
    pub fn beside_lanes(
        &self,
        variant: Variant,
        (places_m, bounds_m): (&[WideRow; 2], [[f64; 2]; 2]),
        poses: &[Pose],
        (count, bragg): (usize, &[Row; 2]),
        out: &mut Row,
    ) -> bool {
        let poses = poses.get(self.strips.len()..).unwrap_or(&[]);
        let square = |i: usize| bragg[0][i] * bragg[0][i] + bragg[1][i] * bragg[1][i];
        let magnitude = |i: usize| f64::from(square(i)).sqrt();
        // Less the rounding of squares.
        let least_radpm =
            f64::from((0..count).map(square).fold(f32::INFINITY, f32::min)).sqrt() * (1.0 - 1e-6);
        let mut any = false;
        for (nodes, pose) in self.short_waves.iter().zip(poses) {
            let wedge = nodes.wedge(least_radpm);
            if !wedge.holds(nearest(bounds_m, pose)) {
                continue;
            }
            // From the axes of the wind to those of the ship.
            let [[cos, sin], [x, y]] = [self.downwind, pose.ahead];
            let turn = [cos * x + sin * y, cos * y - sin * x];
            for i in 0..count {
                let place = pose.astern_starboard_m([places_m[0][i], places_m[1][i]]);
                if !wedge.holds(place)
                    || self.cut_radpm.is_some_and(|cut| high_pass(magnitude(i), cut) == 0.0)
                {
                    continue;
                }
                let [along, across] = [bragg[0][i], bragg[1][i]].map(f64::from);
                let k = [along * turn[0] + across * turn[1], across * turn[0] - along * turn[1]];
                out[i] += nodes.psi_m4(variant, place, k) as f32;
                any = true;
            }
        }
        any
    }
}
