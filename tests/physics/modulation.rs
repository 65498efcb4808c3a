//! Modulation of short waves by long ones: fields and facet powers against the transfer function of Alpers,
//! Ross and Rufenach (1981), upwind against downwind beside CMOD5.n.

use std::f64::consts::TAU;

use glam::DVec3;
use nereus::paths::PathGenerator;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::modulation::of_bragg_waves_per_s;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::{Medium, Settings, TwoScale};
use nereus::scene::radar::{Gate, Polarisation, Window};
use nereus::scene::sea::{Averaging, Modulation};
use nereus::scene::water::{Development, Dispersion, SpectrumKind, WindProfile};
use nereus::scene::{Scene, Sea};
use nereus::sea::realise::realise;
use nereus::sea::spectrum::{LightWind, Spectrum, WaveVector, of_kind};
use nereus::sea::surface::modulation::{Strength, look};
use nereus::sea::surface::{Evaluator, Fields, Grid, Selection, Surface};
use nereus::sea::wind::Wind;
use num_complex::Complex64;

use super::radar_scenes::{PULSE_S, buffers, channels, scene, straight};
use super::sea_paths::sea;

/// Modulation of waves along a unit direction, wave by wave, and its variance:
/// `R = 4.5 K w (w - j mu)/(w^2 + mu^2) (K_l/K)^2`, K times `coth(K d)` in finite depth.
fn modulation(surface: &Surface, rate: f64, b: [f64; 2], place_m: [f64; 2], t_s: f64) -> [f64; 2] {
    let grid = surface.grid();
    let dk = grid.wave_number_step_rad_m();
    let (mut m, mut variance) = (0.0, 0.0);
    for (i, row) in surface.amplitude_m().chunks_exact(grid.ny()).enumerate() {
        for (j, a) in row.iter().enumerate().filter(|(_, a)| a.norm() > 0.0) {
            let k =
                [grid.wave_index_x(i).unwrap() as f64 * dk[0], grid.wave_index_y(j).unwrap() as f64 * dk[1]];
            let magnitude = k[0].hypot(k[1]);
            let deep = surface.dispersion().depth_m.map_or(1.0, |d| 1.0 / (magnitude * d).tanh());
            let w = (9.81 * magnitude / deep).sqrt();
            let along = (k[0] * b[0] + k[1] * b[1]) / magnitude;
            let r =
                4.5 * magnitude * deep * along * along * w * Complex64::new(w, -rate) / (w * w + rate * rate);
            m += (2.0 * a * r * Complex64::cis(k[0] * place_m[0] + k[1] * place_m[1] - w * t_s)).re;
            variance += 2.0 * a.norm_sqr() * r.norm_sqr();
        }
    }
    [m, variance]
}

#[test]
fn fields_have_the_published_transfer_function() {
    let wind = Wind::from_speed(9.0, 10.0, WindProfile::Cardone, 0.4).unwrap();
    let kind = SpectrumKind::Elfouhaily { development: Development::default() };
    let spectrum = of_kind(&kind, &wind).unwrap();
    for (depth_m, rate) in [(None, 2.5), (Some(3.0), 0.3)] {
        let dispersion = Dispersion { depth_m, ..Dispersion::default() };
        let grid = Grid::new(24, 32, 2.0).unwrap();
        let surface =
            Surface::synthesise(grid, spectrum.as_ref(), dispersion, 5, Averaging::Automatic).unwrap();
        let strength = Strength::of(&surface, rate);
        let selection = Selection { modulation: true, ..Selection::HEIGHT };
        let mut exact = Fields::<f64>::new(&grid, selection);
        let mut single = Fields::<f32>::new(&grid, selection);
        Evaluator::new(&surface).with_relaxation(rate).evaluate(7.3, &mut exact).unwrap();
        Evaluator::new(&surface).with_relaxation(rate).evaluate(7.3, &mut single).unwrap();
        for azimuth in [0.0f64, 0.7, 2.0] {
            let b = [azimuth.cos(), azimuth.sin()];
            // Only its horizontal direction counts.
            let look = look([3.0 * b[0], 3.0 * b[1]]);
            for key in [[0, 0], [5, 9], [23, 31], [11, 2]] {
                let i = grid.index(key);
                let place_m = [key[0] as f64 * 2.0, key[1] as f64 * 2.0];
                let [m, variance] = modulation(&surface, rate, b, place_m, 7.3);
                let of = |tensor: [f64; 3]| tensor.iter().zip(look).map(|(t, l)| t * l).sum::<f64>();
                let found = of(exact.modulation.each_ref().map(|column| column[i]));
                assert!((found - m).abs() < 1e-8 * variance.sqrt(), "{found} {m}");
                let rounded = of(single.modulation.each_ref().map(|column| f64::from(column[i])));
                assert!((rounded - m).abs() < 1e-5 * variance.sqrt(), "{rounded} {m}");
                assert!((strength.variance(look) / variance - 1.0).abs() < 1e-7);
            }
        }
    }
}

/// Seen in L band, VV, from the East at 60 degrees incidence: power of each facet at a pulse.
pub fn powers(sea: Sea, pulse: u64) -> Vec<f64> {
    let mut scene = Scene { sea: Some(sea), targets: Vec::new(), ..scene() };
    scene.radar.carrier_hz = 1.3e9;
    scene.radar.window = Window { samples: 1000, gate: Gate::Fixed { start_s: 130e-6 } };
    scene.radar.channels = channels(&[(Polarisation::V, Polarisation::V)]);
    let (sin, cos) = 60f64.to_radians().sin_cos();
    let place = straight(&scene, [20_000.0 * sin, 0.0, 20_000.0 * cos], [0.0; 3]);
    let generator = PathGenerator::new(&scene, PULSE_S, vec![place.clone(), place]).unwrap();
    let mut workspace = generator.workspace();
    let (mut list, mut record) = buffers(&scene);
    generator.pulse(pulse, &mut workspace, &mut list, &mut record).unwrap();
    list.amplitude[0].iter().map(|a| a.norm_sqr()).collect()
}

#[test]
fn facets_have_the_power_of_their_place_on_the_waves() {
    let rate_per_s = 1.5;
    let mut water = sea(24, 2.0, 2.6);
    let seed = scene().seed;
    let surface = realise(&water, seed).unwrap().surface;
    let still = powers(water.clone(), 40);
    water.scattering.modulation = Modulation::Relaxation { rate_per_s: Some(rate_per_s) };
    let patch = water.patch;
    let modulated = powers(water, 40);
    assert_eq!((still.len(), modulated.len()), (576, 576));
    let t_s = 40.0 / scene().radar.emissions.mean_prf_hz();
    for i in (0..576).step_by(13) {
        let place_m = patch.centre_m(patch.key(i));
        // The radar stands 17 km in the East: the direction of the Bragg wave is that to a place of the
        // patch.
        let b = [17_320.5 - place_m[0], -place_m[1]];
        let b = b.map(|c| c / b[0].hypot(b[1]));
        let [m, variance] = modulation(&surface, rate_per_s, b, place_m, t_s);
        let found = (modulated[i] / still[i]).ln();
        assert!((found - (m - 0.5 * variance)).abs() < 1e-5, "facet {i}: {found} {m}");
    }
}

/// A fully developed sea of a wind along +x seen in C band.
struct CBand {
    wind: Wind,
    drawn: Box<dyn Spectrum>,
    scatters: LightWind,
    rate_per_s: f64,
}

impl CBand {
    const CARRIER_HZ: f64 = 5.3e9;

    fn new(u10_mps: f64) -> Self {
        let wind = Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, 0.0).unwrap();
        let kind = SpectrumKind::Elfouhaily { development: Development::default() };
        let rate_per_s = of_bragg_waves_per_s(TAU * Self::CARRIER_HZ / 299_792_458.0, wind.ustar_wu_mps);
        let (drawn, scatters) = (of_kind(&kind, &wind).unwrap(), LightWind::new(&kind, &wind).unwrap());
        Self { wind, drawn, scatters, rate_per_s }
    }

    /// Mean VV and HH upwind, crosswind, downwind on facets of a size, of drawn seas (0: of none, as a
    /// table), and the same of facets that are not modulated.
    fn means(&self, facet_m: f64, incidence_deg: f64) -> [[[f64; 2]; 3]; 2] {
        let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
        let medium = Medium {
            carrier_hz: Self::CARRIER_HZ,
            permittivity: Model::default().permittivity(Self::CARRIER_HZ, water).unwrap(),
            wind_12p5_mps: self.wind.u12_5_mps,
            downwind_rad: 0.0,
            resolved_radpm: if facet_m > 0.0 { std::f64::consts::PI / facet_m } else { 0.0 },
            axis: DVec3::X,
        };
        let psi = |x: f64, y: f64| self.scatters.symmetric_m4(WaveVector::new(x, y));
        let settings = Settings { tilt_average: true, ..Settings::default() };
        let still = TwoScale::new(settings, medium, Clean, psi);
        let wave_psi = |x: f64, y: f64| self.scatters.wave_m4(WaveVector::new(x, y));
        let sea = TwoScale::new(settings, medium, Clean, psi).modulated(
            wave_psi,
            Dispersion::default(),
            self.rate_per_s,
        );
        let (s, c) = incidence_deg.to_radians().sin_cos();
        let looks = [[-s, 0.0], [0.0, s], [s, 0.0]];
        // Facets: slopes and factors of the looks.
        let mut facets = vec![([0.0; 2], [1.0; 3])];
        if facet_m > 0.0 {
            facets.clear();
            let n = (128.0 / facet_m) as usize;
            let grid = Grid::new(n, n, facet_m).unwrap();
            for seed in 1..=4 {
                let surface = Surface::synthesise(
                    grid,
                    self.drawn.as_ref(),
                    Dispersion::default(),
                    seed,
                    Averaging::Automatic,
                )
                .unwrap();
                let selection = Selection { slopes: true, modulation: true, ..Selection::HEIGHT };
                let mut fields = Fields::<f64>::new(&grid, selection);
                Evaluator::new(&surface).with_relaxation(self.rate_per_s).evaluate(0.0, &mut fields).unwrap();
                let strength = Strength::of(&surface, self.rate_per_s);
                for i in (0..n * n).step_by((n * n / 3001) | 1) {
                    let tensor = fields.modulation.each_ref().map(|column| column[i]);
                    let factors = looks.map(|q| strength.factor(tensor, look(q)));
                    facets.push((fields.slope.each_ref().map(|column| column[i]), factors));
                }
            }
        }
        let of = |modulated: bool| {
            [0, 1, 2].map(|at| {
                let away = DVec3::new(looks[at][0], looks[at][1], -c);
                let path = Path::new(away, -away);
                let mut sum = [0.0; 2];
                for (slope, factors) in &facets {
                    let response =
                        if modulated { &sea } else { &still }.response(&path, (slope[0], slope[1]), 0.0);
                    let (bragg, specular) = (response.bragg_sigma0(), response.specular_sigma0());
                    let area = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
                    let factor = if modulated { factors[at] } else { 1.0 };
                    for p in 0..2 {
                        sum[p] += area * (bragg[p][p] * factor + specular[p][p]) / facets.len() as f64;
                    }
                }
                sum
            })
        };
        [of(true), of(false)]
    }
}

/// CMOD5.n (Hersbach 2010, J. Atmos. Oceanic Technol. 27, 721): what VV in C band returns upwind, crosswind
/// and downwind over its mean, from its coefficients.
fn cmod5n(v: f64, incidence_deg: f64) -> [f64; 3] {
    let x = (incidence_deg - 40.0) / 25.0;
    let b1 = 0.0066 * v * (0.5 + x - (4.0 * (x + 0.3222 + 0.0120 * v)).tanh());
    let b1 = (0.0450 * (1.0 + x) - b1) / ((0.34 * (v - 22.7)).exp() + 1.0);
    let v0 = 8.3659 - 3.3428 * x + 1.3236 * x * x;
    let d1 = 6.2437 + 2.3893 * x + 0.3249 * x * x;
    let d2 = 4.1590 + 1.6930 * x;
    let (y0, n) = (2.0813, 3.0);
    let (a, b) = (y0 - (y0 - 1.0) / n, 1.0 / (n * (y0 - 1.0f64).powf(n - 1.0)));
    let v2 = v / v0 + 1.0;
    let v2 = if v2 < y0 { a + b * (v2 - 1.0).powf(n) } else { v2 };
    let b2 = (-d1 + d2 * v2) * (-v2).exp();
    [1.0, 0.0, -1.0].map(|cos: f64| (1.0 + b1 * cos + b2 * (2.0 * cos * cos - 1.0)).powf(1.6))
}

fn db(ratio: f64) -> f64 {
    10.0 * ratio.log10()
}

#[test]
fn upwind_returns_more_than_downwind_as_measured() {
    for (u10_mps, incidence_deg) in [(7.0, 35.0), (10.0, 35.0), (10.0, 45.0), (15.0, 45.0)] {
        let sea = CBand::new(u10_mps);
        let [found, still] = sea.means(0.0, incidence_deg);
        let measured = cmod5n(u10_mps, incidence_deg);
        let [vv, hh] = [0, 1].map(|p| db(found[0][p] / found[2][p]));
        let wanted = db(measured[0] / measured[2]);
        println!(
            "{u10_mps} m/s, {incidence_deg} deg: VV {vv:.2}, HH {hh:.2} dB, CMOD5.n {wanted:.2}; relaxation {:.2} 1/s",
            sea.rate_per_s
        );
        for p in 0..2 {
            assert!(db(still[0][p] / still[2][p]).abs() < 1e-9);
            // The mean of both looks stays: what modulates is of second order in it.
            let mean = db((found[0][p] + found[2][p]) / (still[0][p] + still[2][p]));
            println!("mean {mean:.3} dB");
            assert!(mean.abs() < 0.1, "{mean}");
        }
        assert!(vv > 0.3 && hh > vv && (vv - wanted).abs() < 1.0, "{vv} {hh} {wanted}");
    }
}

#[test]
fn upwind_and_downwind_do_not_depend_on_the_size_of_facets() {
    let sea = CBand::new(8.0);
    let [table, _] = sea.means(0.0, 45.0);
    let of = |means: &[[f64; 2]; 3], p: usize| db(means[0][p] / means[2][p]);
    for facet_m in [0.25, 0.5, 1.0, 2.0] {
        let [found, still] = sea.means(facet_m, 45.0);
        for (p, name) in ["VV", "HH"].into_iter().enumerate() {
            let (own, bare, wanted) = (of(&found, p), of(&still, p), of(&table, p));
            let mean = db((found[0][p] + found[2][p]) / (still[0][p] + still[2][p]));
            println!(
                "{facet_m} m, {name}: {own:.2} dB, not modulated {bare:.2}, table {wanted:.2}; mean {mean:.2}"
            );
            // What the drawn slopes themselves differ by, some 12000 of them, is not the modulation's.
            assert!((own - bare - wanted).abs() < 0.2, "{facet_m} m, {name}: {own} {bare} {wanted}");
            assert!(mean.abs() < 0.15, "{facet_m} m, {name}: {mean}");
        }
    }
}
