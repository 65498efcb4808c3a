//! The average over tilts: what a sea returns in the mean is what the table has, whatever the size of its
//! facets.

use glam::DVec3;
use nereus::scattering::kind::clean::Clean;
use nereus::scattering::permittivity::{Model, SeaWater};
use nereus::scattering::tilt::Path;
use nereus::scattering::two_scale::{Medium, Settings, TwoScale};
use nereus::scene::sea::{Averaging, FacetScattering};
use nereus::scene::water::{Development, Dispersion, SpectrumKind, WindProfile};
use nereus::sea::spectrum::{LightWind, Spectrum, WaveVector};
use nereus::sea::surface::{Evaluator, Fields, Grid, Selection, Surface};
use nereus::sea::wind::Wind;

const SIDE_M: f64 = 128.0;

/// Mean VV and HH of drawn seas of facets of a size (0: no map, as the table), dB.
fn mean_db(facet_m: f64, incidence_deg: f64, tilt_average: bool) -> [f64; 2] {
    let wind = Wind::from_speed(8.0, 10.0, WindProfile::Cardone, 0.0).unwrap();
    let kind = SpectrumKind::Elfouhaily { development: Development::default() };
    let spectrum = LightWind::new(&kind, &wind).unwrap();
    let water = SeaWater { temperature_c: 20.0, salinity_gpkg: 35.0 };
    let medium = Medium {
        carrier_hz: 10e9,
        permittivity: Model::default().permittivity(10e9, water).unwrap(),
        wind_12p5_mps: wind.u12_5_mps,
        downwind_rad: 0.0,
        resolved_radpm: if facet_m > 0.0 { std::f64::consts::PI / facet_m } else { 0.0 },
        axis: DVec3::X,
    };
    let settings = Settings { tilt_average, ..Settings::default() };
    let sea = TwoScale::new(settings, medium, Clean, |x, y| spectrum.symmetric_m4(WaveVector::new(x, y)));
    let (s, c) = incidence_deg.to_radians().sin_cos();
    let away = DVec3::new(-s, 0.0, -c);
    let path = Path::new(away, -away);
    let of = |slopes: (f64, f64)| {
        let sigma0 = sea.response(&path, slopes, 0.0).sigma0();
        let area = (1.0 + slopes.0 * slopes.0 + slopes.1 * slopes.1).sqrt();
        [sigma0[0][0] * area, sigma0[1][1] * area]
    };
    let mut sum = [0.0; 2];
    let mut count = 0.0;
    if facet_m > 0.0 {
        let n = (SIDE_M / facet_m) as usize;
        let grid = Grid::new(n, n, facet_m).unwrap();
        let published = nereus::sea::spectrum::of_kind(&kind, &wind).unwrap();
        for seed in 1..=2 {
            let surface = Surface::synthesise(
                grid,
                published.as_ref(),
                Dispersion::default(),
                seed,
                Averaging::Automatic,
            )
            .unwrap();
            let mut fields = Fields::<f64>::new(&grid, Selection { slopes: true, ..Selection::HEIGHT });
            Evaluator::new(&surface).evaluate(0.0, &mut fields).unwrap();
            // Every so many facets do: some 2000 of each sea.
            for i in (0..n * n).step_by((n * n / 2003).max(1)) {
                let found = of((fields.slope[0][i], fields.slope[1][i]));
                (sum[0], sum[1], count) = (sum[0] + found[0], sum[1] + found[1], count + 1.0);
            }
        }
    } else {
        (sum, count) = (of((0.0, 0.0)), 1.0);
    }
    sum.map(|sum| 10.0 * (sum / count).log10())
}

#[test]
fn facets_of_any_size_return_what_the_table_has() {
    assert!(FacetScattering::default().tilt_average);
    for incidence_deg in [40.0, 60.0, 75.0] {
        let table = mean_db(0.0, incidence_deg, true);
        let mut without = 0.0f64;
        for facet_m in [0.25, 0.5, 1.0, 2.0] {
            let [found, bare] = [true, false].map(|tilts| mean_db(facet_m, incidence_deg, tilts));
            println!(
                "{incidence_deg} deg, {facet_m} m: VV, HH {found:.2?} dB, table {table:.2?}, one tilt {bare:.2?}"
            );
            for (found, table) in found.iter().zip(table) {
                assert!((found - table).abs() < 1.0, "{incidence_deg} deg, {facet_m} m: {found} {table}");
            }
            without = without.max((bare[1] - table[1]).abs());
        }
        // With one tilt a facet HH lies far off: it is the tilts that return it.
        assert!(without > 1.0, "{incidence_deg} deg: {without}");
    }
}
