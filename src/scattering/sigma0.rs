//! Normalised radar cross section of the sea, all of it or one facet, by the two-scale model.
//!
//! `sigma0 = 4 pi r^2 <|E_s|^2> / (|E_i|^2 A)` of a channel is `sigma0_Bragg + sigma0_specular
//! (+ sigma0_breaking)`, power ratios:
//!
//! | symbol | is | unit |
//! | --- | --- | --- |
//! | `E_i`, `E_s` | incident field, and that scattered to the distance `r` (m), of a channel | V/m |
//! | `A` | area of the facet's plane; without a facet of the mean sea surface | m^2 |
//! | `sigma0_Bragg` | small perturbations by waves above the cut, mean over unresolved slopes | 1 |
//! | `sigma0_specular` | geometrical optics of the unresolved slopes | 1 |
//! | `sigma0_breaking` | breaking waves ([`super::breaking`]), if asked | 1 |
//!
//! The path's direction of incidence is that of +x, angles from the vertical; the wind blows towards the
//! aspect from there, counter-clockwise. Without a facet no wave is resolved. Channels are those of
//! [`two_scale`](super::two_scale): `[[vv, vh], [hv, hh]]`, the receiver first.
//!
//! Sources and limits: docs/physics.md section 10; [`two_scale`](super::two_scale) has the terms.
//!
//! ```
//! use nereus::scattering::kind::clean::Clean;
//! use nereus::scattering::permittivity::{Model, SeaWater};
//! use nereus::scattering::sigma0::{SeaView, path};
//! use nereus::scene::water::{SpectrumKind, WindProfile};
//! use nereus::sea::{spectrum::of_kind, wind::Wind};
//! let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
//! let wind = Wind::from_speed(10.0, 10.0, WindProfile::Cardone, 0.0)?;
//! let spectrum = of_kind(&SpectrumKind::FungLee, &wind)?;
//! let sea = SeaView {
//!     carrier_hz: 10e9,
//!     permittivity: Model::default().permittivity(10e9, water)?,
//!     wind: &wind,
//!     spectrum: spectrum.as_ref(),
//!     kind: &Clean,
//!     // Upwind: cosine and sine of 180 degrees.
//!     aspect: (-1.0, 0.0),
//!     facet_m: None,
//!     relaxation: None,
//!     breaking: false,
//!     settings: Default::default(),
//! };
//! let (forward, monostatic) = (0.5_f64.sqrt(), (-1.0, 0.0));
//! let path = path([(forward, forward), (forward, forward), monostatic]);
//! let [[vv, _], [_, hh]] = sea.sigma0()(&path, [0.0, 0.0]).sum;
//! assert!(vv > hh && hh > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::f64::consts::PI;

use glam::DVec3;
use num_complex::Complex64;

use super::breaking;
use super::kind::Kind;
use super::modulation::of_bragg_waves_per_s;
use super::tilt::Path;
use super::two_scale::{Medium, Settings, TwoScale};
use crate::scene::water::Dispersion;
use crate::sea::spectrum::{Spectrum, WaveVector};
use crate::sea::wind::Wind;

/// How modulated Bragg waves relax.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relaxation {
    /// At the growth rate of the Bragg waves seen at 45 degrees.
    Growth,
    /// At this rate, 1/s.
    Rate(f64),
}

/// A sea as a radar sees it from one direction.
#[derive(Clone, Copy)]
pub struct SeaView<'a> {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Relative permittivity of the water, `Im <= 0`.
    pub permittivity: Complex64,
    /// The wind.
    pub wind: &'a Wind,
    /// The spectrum, whose +x is downwind.
    pub spectrum: &'a dyn Spectrum,
    /// What covers the water.
    pub kind: &'a dyn Kind,
    /// Direction the wind blows towards, from the direction of incidence: its cosine and sine.
    pub aspect: (f64, f64),
    /// Side of a facet, whose own slopes are resolved, m; `None`: the whole sea.
    pub facet_m: Option<f64>,
    /// How Bragg waves of unresolved tilts are modulated, if they are.
    pub relaxation: Option<Relaxation>,
    /// Whether breaking waves are added.
    pub breaking: bool,
    /// Choices of the two-scale model.
    pub settings: Settings,
}

/// A cross section per area of the facet, and its parts: power ratios.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigma0 {
    /// All of it.
    pub sum: [[f64; 2]; 2],
    /// The Bragg part.
    pub bragg: [[f64; 2]; 2],
    /// The specular part.
    pub specular: [[f64; 2]; 2],
    /// Breaking waves, where they are added.
    pub breaking: Option<[[f64; 2]; 2]>,
}

impl<'a> SeaView<'a> {
    /// Its cross section on a path, of a facet of such slopes along x and y. The integrals over the spectrum
    /// are done once.
    pub fn sigma0(&self) -> impl Fn(&Path, [f64; 2]) -> Sigma0 + use<'a> {
        let SeaView { carrier_hz, permittivity, wind, spectrum, breaking, .. } = *self;
        let (cos, sin) = self.aspect;
        let medium = Medium {
            carrier_hz,
            permittivity,
            wind_12p5_mps: wind.u12_5_mps,
            downwind_rad: sin.atan2(cos),
            resolved_radpm: self.facet_m.map_or(0.0, |facet_m| PI / facet_m),
            axis: DVec3::X,
        };
        let turned = move |kx: f64, ky: f64| WaveVector::new(cos * kx + sin * ky, cos * ky - sin * kx);
        let psi = move |kx: f64, ky: f64| spectrum.symmetric_m4(turned(kx, ky));
        let mut sea = TwoScale::new(self.settings, medium, self.kind, psi);
        if let Some(relaxation) = self.relaxation {
            let rate_per_s = match relaxation {
                Relaxation::Rate(rate_per_s) => rate_per_s,
                Relaxation::Growth => of_bragg_waves_per_s(medium.wavenumber_radpm(), wind.ustar_wu_mps),
            };
            let wave_psi = |kx: f64, ky: f64| spectrum.wave_m4(turned(kx, ky));
            sea = sea.modulated(wave_psi, Dispersion::default(), rate_per_s);
        }
        move |path, [slope_x, slope_y]| {
            // Under a film the whole facet is.
            let response = sea.response(path, (slope_x, slope_y), 1.0);
            let breaking =
                breaking.then(|| breaking::sigma0(permittivity, path, medium.downwind_rad, wind.u10_mps));
            let mut sum = response.sigma0();
            let added = breaking.iter().flatten().flatten();
            sum.as_flattened_mut().iter_mut().zip(added).for_each(|(sum, breaking)| *sum += breaking);
            Sigma0 { sum, bragg: response.bragg_sigma0(), specular: response.specular_sigma0(), breaking }
        }
    }
}

/// The path of such an incidence, scattering angle and azimuth of the receiver (0 forward), each by its
/// cosine and sine.
pub fn path([(cos_i, sin_i), (cos_s, sin_s), (cos_d, sin_d)]: [(f64, f64); 3]) -> Path {
    Path::new(DVec3::new(sin_i, 0.0, -cos_i), DVec3::new(sin_s * cos_d, sin_s * sin_d, cos_s))
}
