//! The two-scale sea: specular points of the large waves, Bragg scattering of the small ones.
//!
//! Waves are split by wave number: those below `K_max` are the height map itself (facet tilts); between
//! `K_max` and `K_cut` they are slopes within a facet ([`kirchhoff`](super::kirchhoff)); above `K_cut` they
//! scatter by Bragg ([`spm`]), in the spectrum `Psi_B = Psi H(|K|)`, `H` a raised cosine in
//! `log K` over the octave centred on `K_cut` ([`high_pass`]).
//!
//! | [`Splitting`] | slope density | Bragg spectrum | small waves on specular points |
//! | --- | --- | --- | --- |
//! | `Consistent` | `s_u^2 = integral of K_u^2 Psi, K_max < K < K_cut` (and `s_c^2`) | `K > K_cut` | `exp(-4 k^2 cos^2 th_l s^2)`, `s^2` of all `K > K_cut` |
//! | `Mars2007` | Cox-Munk, all waves | all | not applied |
//!
//! `K_cut = max(K_max, k/3)` unless set by hand; `k` is the radar wave number. `Mars2007` counts the waves of
//! the height map twice, as the paper does.
//!
//! Optionally (`tilt_average`) the Bragg part is a sum over nine sub-facets, tilted by the nodes of a 3 x 3
//! Gauss-Hermite rule of the slope density, each with its own random phase: its covariance is the average
//! over tilts (of `sigma0` times the true area of the tilted sub-facet), cross-polarisation included.
//!
//! Amplitudes are per square root of facet area. The two mechanisms are independent; a facet of area `A`
//! has `S = sqrt(A) (spm e^{j phi_1} + go e^{j phi_2})` ([`facets`](super::facets)).
//!
//! ```
//! use glam::DVec3;
//! use nereus::scattering::kind::clean::Clean;
//! use nereus::scattering::tilt::Path;
//! use nereus::scattering::two_scale::{Medium, Settings, TwoScale};
//! use num_complex::Complex64;
//! let medium = Medium {
//!     carrier_hz: 10e9,
//!     permittivity: Complex64::new(55.062, -37.514),
//!     wind_12p5_mps: 10.0,
//!     downwind_rad: 0.0,
//!     resolved_radpm: std::f64::consts::PI,
//!     axis: DVec3::X,
//! };
//! // Phillips' saturation range stands for a spectrum here.
//! let psi = |kx: f64, ky: f64| 1e-3 / (kx * kx + ky * ky).powi(2);
//! let sea = TwoScale::new(Settings::default(), medium, Clean, psi);
//! let down = DVec3::new(0.5f64.sqrt(), 0.0, -0.5f64.sqrt());
//! let sigma0 = sea.response(&Path::new(down, -down), (0.0, 0.0), 0.0).sigma0();
//! assert!(sigma0[0][0] > sigma0[1][1] && sigma0[1][1] > 0.0);
//! ```

use super::splitting::high_pass;
use std::f64::consts::TAU;

use glam::DVec3;
use num_complex::Complex64;

use super::kind::Kind;
use super::kind::clean::Clean;
use super::kirchhoff::Bend;
use super::lanes::LaneKind;
use super::lanes::table::BraggTable;
use super::modulation::{TiltBias, weight};
use super::slope_pdf::{GramCharlier, MeanSquareSlope, SlopePdf};
use super::spm;
use super::tilt::{NO_ECHO, Path, ScatterMatrix, Tangent};
use crate::scene::water::Dispersion;
use crate::sea::surface::modulation::look;
use crate::units::SPEED_OF_LIGHT_MPS;

pub use crate::scene::sea::Splitting;

/// Sub-facet tilts of the Gauss-Hermite average.
pub const TILTS: usize = 9;

/// Nodes (in standard deviations) and weights of the three-point Gauss-Hermite rule.
const NODES: [(f64, f64); 3] = [(0.0, 2.0 / 3.0), (-SQRT_3, 1.0 / 6.0), (SQRT_3, 1.0 / 6.0)];
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// Longest wave that the moment integrals count, rad/m (peak of a 40 m/s sea: 4e-3).
const LONGEST_RADPM: f64 = 1e-4;
/// Shortest wave that the moment integrals count, rad/m: viscosity has ended the spectrum.
const SHORTEST_RADPM: f64 = 2e4;

/// Specular amplitude (root of `sigma0`) too small to be worth its reflection coefficients: -240 dB.
const LEAST_SPECULAR: f64 = 1e-12;

/// Choices of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Settings {
    /// How waves are shared.
    pub splitting: Splitting,
    /// `K_cut`, rad/m; `None` for `max(K_max, k/3)` (`Consistent`) or no cutoff at all (`Mars2007`).
    pub cut_radpm: Option<f64>,
    /// Whether the Bragg part averages over nine sub-facet tilts (`Consistent` only: the paper's slope
    /// density already holds the tilts of the height map).
    pub tilt_average: bool,
    /// Whether the slope density has the Gram-Charlier terms.
    pub gram_charlier: bool,
}

/// What the waves are looked at with, and where from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Relative permittivity of the water, `Im <= 0`.
    pub permittivity: Complex64,
    /// Wind at 12.5 m, m/s.
    pub wind_12p5_mps: f64,
    /// Direction the wind blows towards, from `axis`, counter-clockwise, rad.
    pub downwind_rad: f64,
    /// `K_max`: highest wave number the height map resolves, `pi/dx`, rad/m; 0 for a flat map.
    pub resolved_radpm: f64,
    /// Horizontal unit axis from which local axes, spectrum and wind are counted: x of the scene. (When wind
    /// and spectrum are given from the wind's own direction, results do not change as the whole scene turns.)
    pub axis: DVec3,
}

impl Medium {
    /// Radar wave number `2 pi f / c`, rad/m.
    pub fn wavenumber_radpm(&self) -> f64 {
        TAU * self.carrier_hz / SPEED_OF_LIGHT_MPS
    }
}

/// Integrals over the unresolved waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Slope variances of `K_max < K < K_cut`.
    pub slopes: MeanSquareSlope,
    /// Height variance of `K > K_cut`, m^2.
    pub roughness_m2: f64,
}

/// What one facet returns, per square root of its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    bragg: [ScatterMatrix; TILTS],
    tilts: usize,
    /// Specular part.
    pub specular: ScatterMatrix,
}

impl Response {
    /// The response of nothing.
    pub const NONE: Self = Self { bragg: [NO_ECHO; TILTS], tilts: 1, specular: NO_ECHO };

    /// Bragg part: one matrix, or one for each sub-facet tilt (its weight included).
    #[inline]
    pub fn bragg(&self) -> &[ScatterMatrix] {
        &self.bragg[..self.tilts]
    }

    /// Mean `sigma0_pq` of the Bragg part, order (v, h).
    pub fn bragg_sigma0(&self) -> [[f64; 2]; 2] {
        let power = |p: usize, q: usize| self.bragg().iter().map(|m| m[p][q].norm_sqr()).sum();
        [[power(0, 0), power(0, 1)], [power(1, 0), power(1, 1)]]
    }

    /// Mean `sigma0_pq` of the specular part, order (v, h).
    pub fn specular_sigma0(&self) -> [[f64; 2]; 2] {
        self.specular.map(|row| row.map(|s| s.norm_sqr()))
    }

    /// Mean `sigma0_pq` of both, per unit facet area.
    pub fn sigma0(&self) -> [[f64; 2]; 2] {
        let (b, s) = (self.bragg_sigma0(), self.specular_sigma0());
        [[b[0][0] + s[0][0], b[0][1] + s[0][1]], [b[1][0] + s[1][0], b[1][1] + s[1][1]]]
    }
}

/// The sea of one surface kind, ready to be asked facet by facet. `F(kx, ky)` is the symmetrised spectrum of
/// the clean sea, m^4, on the axes of [`Medium::axis`].
#[derive(Clone, Copy, Debug)]
pub struct TwoScale<K, F> {
    settings: Settings,
    medium: Medium,
    wavenumber_radpm: f64,
    cut_radpm: Option<f64>,
    kind: K,
    psi: F,
    clean: Moments,
    covered: Moments,
    skew: Option<[GramCharlier; 2]>,
    downwind: (f64, f64),
    clean_pdf: SlopePdf,
    bias: Option<TiltBias>,
}

impl<K: Kind, F: Fn(f64, f64) -> f64> TwoScale<K, F> {
    /// Prepares a sea: integrates the spectrum where the splitting asks for it.
    pub fn new(settings: Settings, medium: Medium, kind: K, psi: F) -> Self {
        let k = medium.wavenumber_radpm();
        let cut_radpm = match settings.splitting {
            Splitting::Consistent => Some(settings.cut_radpm.unwrap_or(medium.resolved_radpm.max(k / 3.0))),
            Splitting::Mars2007 => settings.cut_radpm,
        };
        let wind = medium.wind_12p5_mps;
        let (clean, covered) = match (settings.splitting, cut_radpm) {
            (Splitting::Consistent, Some(cut)) => (
                moments(&psi, &|_| 1.0, medium.resolved_radpm, cut, medium.downwind_rad),
                moments(&psi, &|k| kind.spectrum_factor(k), medium.resolved_radpm, cut, medium.downwind_rad),
            ),
            _ => (
                Moments { slopes: Clean.slopes(wind), roughness_m2: 0.0 },
                Moments { slopes: kind.slopes(wind), roughness_m2: 0.0 },
            ),
        };
        let skew = settings.gram_charlier.then(|| [Clean.gram_charlier(wind), kind.gram_charlier(wind)]);
        let (sin, cos) = medium.downwind_rad.sin_cos();
        let clean_pdf = SlopePdf::along(clean.slopes, skew.map(|[clean, _]| clean), cos, sin);
        Self {
            settings,
            medium,
            wavenumber_radpm: k,
            cut_radpm,
            kind,
            psi,
            clean,
            covered,
            skew,
            downwind: (cos, sin),
            clean_pdf,
            bias: None,
        }
    }

    /// The same with the roughness of sub-facets modulated by the waves that tilt them
    /// ([`modulation`](super::modulation)); `wave_psi` is the spectrum in the wave convention.
    pub fn modulated(
        mut self,
        wave_psi: impl Fn(f64, f64) -> f64,
        dispersion: Dispersion,
        relaxation_per_s: f64,
    ) -> Self {
        if let Some(cut_radpm) = self.cut_radpm.filter(|_| self.averages_tilts()) {
            let mut bias = TiltBias::default();
            let from_radpm = self.medium.resolved_radpm.max(LONGEST_RADPM);
            integrate(&wave_psi, &|_| 1.0, from_radpm, cut_radpm, &mut |k, azimuth, power| {
                let (sin, cos) = azimuth.sin_cos();
                let off_wind_rad = azimuth - self.medium.downwind_rad;
                bias.add([k * cos, k * sin], off_wind_rad, power, dispersion, relaxation_per_s);
            });
            self.bias = Some(bias.over(self.clean.slopes));
        }
        self
    }

    /// The same with a modulation of its sub-facets found before.
    pub(super) fn with_tilt_bias(mut self, bias: Option<TiltBias>) -> Self {
        self.bias = bias.filter(|_| self.averages_tilts());
        self
    }

    /// The modulation of its sub-facets, if there is one.
    pub fn tilt_bias(&self) -> Option<TiltBias> {
        self.bias
    }

    /// The spectrum that scatters from clean water, as a table.
    pub(super) fn bragg_table(&self) -> BraggTable {
        let pass = |k: f64| self.cut_radpm.map_or(1.0, |cut| high_pass(k, cut));
        BraggTable::new(&self.psi, pass, self.wavenumber_radpm)
    }

    /// The kind for facets side by side.
    pub(super) fn lane_kind(&self, table: &BraggTable) -> LaneKind {
        let damped =
            (0..=8).any(|i| self.kind.spectrum_factor(self.wavenumber_radpm * f64::from(i) / 4.0) != 1.0);
        LaneKind {
            slopes: [self.clean.slopes, self.covered.slopes],
            roughness_m2: [self.clean.roughness_m2, self.covered.roughness_m2],
            skew: self.skew,
            downwind: [self.downwind.0, self.downwind.1],
            damping: damped.then(|| table.damping(|k| self.kind.spectrum_factor(k))),
        }
    }

    /// Sub-facet tilts in standard deviations along and across the wind, with their weights.
    pub(super) fn lane_tilts(&self) -> Vec<[f32; 3]> {
        if !self.averages_tilts() {
            return vec![[0.0, 0.0, 1.0]];
        }
        let nodes = NODES.iter().flat_map(|u| NODES.iter().map(move |c| (u, c)));
        nodes.map(|(u, c)| [u.0 as f32, c.0 as f32, (u.1 * c.1) as f32]).collect()
    }

    /// Variances of the slopes of the sub-facets of clean water, along and across the wind.
    pub(super) fn tilt_variances(&self) -> [f64; 2] {
        let s = self.moments(0.0).slopes;
        if self.averages_tilts() { [s.up, s.cross] } else { [0.0; 2] }
    }

    /// `K_cut`, rad/m, if there is a cutoff.
    pub fn cut_radpm(&self) -> Option<f64> {
        self.cut_radpm
    }

    /// The medium this sea was prepared for.
    pub fn medium(&self) -> &Medium {
        &self.medium
    }

    /// Number of Bragg matrices of a response.
    pub fn tilts(&self) -> usize {
        if self.averages_tilts() { TILTS } else { 1 }
    }

    fn averages_tilts(&self) -> bool {
        self.settings.tilt_average && self.settings.splitting == Splitting::Consistent
    }

    /// Moments of the unresolved waves on a facet covered to `cover` (0 to 1).
    #[inline]
    pub fn moments(&self, cover: f64) -> Moments {
        let (a, b) = (&self.clean, &self.covered);
        Moments {
            slopes: a.slopes.blend(b.slopes, cover).floored(),
            roughness_m2: a.roughness_m2 + cover * (b.roughness_m2 - a.roughness_m2),
        }
    }

    /// Slope density of the unresolved waves on a facet covered to `cover`.
    #[inline]
    pub fn slope_pdf(&self, cover: f64) -> SlopePdf {
        if cover == 0.0 {
            return self.clean_pdf;
        }
        let skew = self.skew.map(|[clean, covered]| clean.blend(covered, cover));
        SlopePdf::along(self.moments(cover).slopes, skew, self.downwind.0, self.downwind.1)
    }

    /// Spectrum that scatters by Bragg, at a wave vector on the local axes, on a facet covered to `cover`,
    /// m^4, with waves besides those of the wind, of a spectrum of their own; the kind of cover damps both.
    #[inline]
    fn raised_spectrum(&self, kx: f64, ky: f64, cover: f64, beside: impl Fn(f64, f64) -> f64) -> f64 {
        let magnitude = (kx * kx + ky * ky).sqrt();
        let pass = match self.cut_radpm {
            Some(cut) => high_pass(magnitude, cut),
            None => 1.0,
        };
        if pass == 0.0 {
            return 0.0;
        }
        let damped =
            if cover == 0.0 { 1.0 } else { 1.0 + cover * (self.kind.spectrum_factor(magnitude) - 1.0) };
        ((self.psi)(kx, ky) + beside(kx, ky)) * pass * damped
    }

    /// What a facet with the given slopes of the height map returns, covered by the kind to `cover` (0 to 1).
    pub fn response(&self, path: &Path, slopes: (f64, f64), cover: f64) -> Response {
        self.response_beside(path, slopes, cover, |_, _| 0.0)
    }

    /// [`Self::response`] with waves besides those of the wind, as [`Self::visit_beside`] has them.
    pub fn response_beside(
        &self,
        path: &Path,
        slopes: (f64, f64),
        cover: f64,
        beside: impl Fn(f64, f64) -> f64,
    ) -> Response {
        let mut response = Response { tilts: self.tilts(), ..Response::NONE };
        self.visit_beside(path, slopes, cover, beside, |mechanism, matrix| match mechanism {
            0 => response.specular = *matrix,
            tilt => response.bragg[tilt - 1] = *matrix,
        });
        response
    }

    /// Hands over the matrices of [`Self::response`] one by one with their mechanism (0 specular, 1 onwards
    /// Bragg), leaving out what is not there.
    #[inline]
    pub fn visit(
        &self,
        path: &Path,
        slopes: (f64, f64),
        cover: f64,
        each: impl FnMut(usize, &ScatterMatrix),
    ) {
        self.visit_beside(path, slopes, cover, |_, _| 0.0, each);
    }

    /// [`Self::visit`] with waves besides those of the wind that scatter by Bragg: their symmetrised spectrum
    /// at a wave vector on the local axes, m^4.
    #[inline]
    pub fn visit_beside(
        &self,
        path: &Path,
        slopes: (f64, f64),
        cover: f64,
        beside: impl Fn(f64, f64) -> f64,
        mut each: impl FnMut(usize, &ScatterMatrix),
    ) {
        let axis = self.medium.axis;
        let tangent = Tangent::from_slopes(slopes.0, slopes.1, axis);
        if path.local_cosines(tangent.normal).is_none() {
            return;
        }
        let eps = self.medium.permittivity;
        if let Some(bend) = Bend::new(path) {
            let weight = bend.weight(&tangent, path, &self.slope_pdf(cover));
            if weight > LEAST_SPECULAR {
                let calm = bend.roughness(self.wavenumber_radpm, self.moments(cover).roughness_m2);
                each(0, &scaled(bend.reflection(eps, path), weight * calm));
            }
        }
        let bragg = |plane: &Tangent| {
            spm::amplitude(eps, self.wavenumber_radpm, plane, path, |kx, ky| {
                self.raised_spectrum(kx, ky, cover, &beside)
            })
        };
        if !self.averages_tilts() {
            each(1, &bragg(&tangent));
            return;
        }
        let s = self.moments(cover).slopes;
        let (s_up, s_cross) = (s.up.sqrt(), s.cross.sqrt());
        let (cos, sin) = self.downwind;
        let bias = self.bias.map_or([0.0; 2], |bias| {
            let q = path.ks - path.ki;
            bias.at(look([q.dot(axis), axis.x * q.y - axis.y * q.x]))
        });
        let nodes = NODES.iter().flat_map(|u| NODES.iter().map(move |c| (u, c)));
        for (tilt, (u, c)) in nodes.enumerate() {
            let (up, cross) = (u.0 * s_up, c.0 * s_cross);
            let plane = tangent.tilted(cos * up - sin * cross, sin * up + cos * cross, axis);
            // sigma0 is per true area: the tilted sub-facet is larger than the facet beneath it.
            let area = (1.0 + up * up + cross * cross).sqrt();
            let share = if self.bias.is_some() { weight(bias, [u.0, c.0]) } else { 1.0 };
            each(1 + tilt, &scaled(bragg(&plane), (u.1 * c.1 * share * area).sqrt()));
        }
    }
}

#[inline]
fn scaled(matrix: ScatterMatrix, factor: f64) -> ScatterMatrix {
    matrix.map(|row| row.map(|s| s * factor))
}

/// Slope variances of `resolved < K < cut` and height variance of `K > cut`, of `psi * factor`.
fn moments(
    psi: &dyn Fn(f64, f64) -> f64,
    factor: &dyn Fn(f64) -> f64,
    resolved_radpm: f64,
    cut_radpm: f64,
    downwind_rad: f64,
) -> Moments {
    let (mut up, mut cross) = (0.0, 0.0);
    integrate(psi, factor, resolved_radpm.max(LONGEST_RADPM), cut_radpm, &mut |k, azimuth, power| {
        let (sin, cos) = (azimuth - downwind_rad).sin_cos();
        up += k * k * cos * cos * power;
        cross += k * k * sin * sin * power;
    });
    let mut roughness_m2 = 0.0;
    integrate(psi, factor, cut_radpm.max(LONGEST_RADPM), SHORTEST_RADPM, &mut |_, _, power| {
        roughness_m2 += power;
    });
    Moments { slopes: MeanSquareSlope { up, cross }, roughness_m2 }
}

/// Visits the nodes of a polar rule (Simpson in `log K`, trapezoid in azimuth) with the power of each.
fn integrate(
    psi: &dyn Fn(f64, f64) -> f64,
    factor: &dyn Fn(f64) -> f64,
    from_radpm: f64,
    to_radpm: f64,
    visit: &mut dyn FnMut(f64, f64, f64),
) {
    const AZIMUTHS: u32 = 64;
    const STEPS_PER_DECADE: f64 = 150.0;
    if !(to_radpm > from_radpm && to_radpm.is_finite()) {
        return;
    }
    let decades = (to_radpm / from_radpm).log10();
    // Bounded whatever the cut: 300 decades are all that doubles have above `LONGEST_RADPM`.
    let steps = 2 * (0.5 * decades * STEPS_PER_DECADE).ceil().max(4.0) as u32;
    let step = (to_radpm / from_radpm).ln() / f64::from(steps);
    for i in 0..=steps {
        let k = from_radpm * (step * f64::from(i)).exp();
        let simpson = match i {
            _ if i == 0 || i == steps => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        // Psi dKx dKy = Psi K^2 d(ln K) d(azimuth).
        let weight = factor(k) * k * k * simpson * step / 3.0 * TAU / f64::from(AZIMUTHS);
        for j in 0..AZIMUTHS {
            let azimuth = TAU * f64::from(j) / f64::from(AZIMUTHS);
            let (sin, cos) = azimuth.sin_cos();
            let power = psi(k * cos, k * sin).max(0.0) * weight;
            visit(k, azimuth, power);
        }
    }
}
