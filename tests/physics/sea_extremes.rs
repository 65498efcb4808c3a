//! The sea at the ends of what is legal: no panic, NaN or infinity.

use nereus::scene::patch::{Patch, PatchError};
use nereus::scene::water::{
    Development, Dispersion, SpectrumKind, Swell, SwellShape, Water, WindGiven, WindProfile, WindStrength,
};
use nereus::sea::dispersion::CAPILLARY_PEAK_RAD_M;
use nereus::sea::spectrum::measured::Measured;
use nereus::sea::spectrum::moments::Moments;
use nereus::sea::spectrum::sampling::{self, FacetDensity};
use nereus::sea::spectrum::{Elfouhaily, FungLee, WaveVector, of_water};
use nereus::sea::surface::{Averaging, Evaluator, Fields, Grid, Selection, Surface};
use nereus::sea::wind::Wind;
use proptest::prelude::*;

use crate::sea_spectrum::every_spectrum;

const DEEP: Dispersion = Dispersion { capillary: false, depth_m: None };

fn calm_or(u10_mps: f64) -> Wind {
    Wind::from_speed(u10_mps, 10.0, WindProfile::Cardone, 0.3).unwrap()
}

#[test]
fn under_a_third_of_a_metre_per_second_the_sea_is_flat() {
    for u10_mps in [0.0, 1e-300, 0.1, 0.2999] {
        for (name, sea) in every_spectrum(&calm_or(u10_mps)) {
            if name.contains("swell") || name == "combined" {
                continue; // Swell does not need wind.
            }
            assert_eq!(sea.peak_rad_m(), 0.0, "{name}");
            assert_eq!(sampling::least_length_m(sea.as_ref(), 0.25), 0.0);
            assert_eq!(Moments::of(sea.as_ref(), [1e-3, 1e4]), Moments::default());
            let grid = Grid::new(16, 16, 1.0).unwrap();
            let surface = Surface::synthesise(grid, sea.as_ref(), DEEP, 1, Averaging::Automatic).unwrap();
            assert!(surface.is_flat());
            let mut fields = Fields::<f64>::new(&grid, Selection::ALL);
            fields.height_m.fill(7.0);
            Evaluator::new(&surface).evaluate(1e4, &mut fields).unwrap();
            assert_eq!(fields, Fields::new(&grid, Selection::ALL), "{name} at {u10_mps} m/s");
        }
    }
    // And just above it is not.
    let grid = Grid::new(64, 64, 0.01).unwrap();
    let sea = Elfouhaily::new(&calm_or(0.3), Development::default()).unwrap();
    assert!(!Surface::synthesise(grid, &sea, DEEP, 1, Averaging::Automatic).unwrap().is_flat());
}

#[test]
fn swell_runs_under_a_calm() {
    let swell = Swell {
        significant_height_m: 1.0,
        peak_period_s: 10.0,
        direction_rad: 0.0,
        spread_rad: 0.2,
        shape: SwellShape::Gaussian { relative_width: 0.05 },
    };
    let wind = WindGiven {
        strength: WindStrength::FrictionVelocity { ustar_mps: 0.0 },
        profile: WindProfile::Cardone,
        direction_rad: 0.0,
    };
    let elfouhaily = SpectrumKind::Elfouhaily { development: Development::default() };
    let water = Water { swell: vec![swell], dispersion: DEEP, ..Water::new(wind, elfouhaily) };
    let spectrum = of_water(&water, &Wind::resolve(&water.wind).unwrap()).unwrap();
    let height_m = Moments::of(spectrum.as_ref(), [1e-3, 10.0]).significant_height_m();
    // Simpson over 300 points of the peak: far better than 1e-6.
    assert!((height_m - 1.0).abs() < 1e-6, "{height_m}");
}

#[test]
fn at_25_metres_per_second() {
    let wind = Wind::from_speed(25.0, 19.5, WindProfile::Cardone, 0.0).unwrap();
    // docs/physics.md section 19: Lmin 2.05 km, Hs about 16 m at U10 = 25.
    assert!((sampling::least_length_m(&FungLee::new(&wind), 0.25) - 2053.0).abs() < 1.0);
    let wind = calm_or(25.1);
    assert!(wind.is_extrapolated());
    let grid = Grid::new(256, 256, 2.0).unwrap();
    let sea = Elfouhaily::new(&wind, Development::default()).unwrap();
    let surface = Surface::synthesise(grid, &sea, DEEP, 1, Averaging::Automatic).unwrap();
    let height_m = 4.0 * surface.expected().variance_m2.sqrt();
    println!("Hs held by 512 m at 25 m/s: {height_m:.2} m");
    assert!((15.0..16.6).contains(&height_m));
}

#[test]
fn short_waves_fall_off_as_elfouhaily_has_them() {
    // docs/physics.md section 19: at K = 2000 rad/m Bh has fallen by exp(-(2000/370 - 1)^2/4) = e^-4.9.
    let sea = Elfouhaily::new(&calm_or(10.0), Development::default()).unwrap();
    let level =
        |k: f64| sea.curvature(k)[1] * (k * (1.0 + (k / CAPILLARY_PEAK_RAD_M).powi(2)) / k / k).sqrt();
    let fall = (level(2000.0) / level(CAPILLARY_PEAK_RAD_M)).ln();
    assert!((fall + 4.9).abs() < 0.1, "{fall}");
}

#[test]
fn grids_and_patches_out_of_range_are_refused_in_words() {
    let grid = |nx, ny, facet_m| Grid::new(nx, ny, facet_m).unwrap_err().to_string();
    let too_many = "facets: allowed are 1 to 65536 a side, 67108864 in all";
    assert_eq!(grid(0, 5, 1.0), format!("sea map of 0 x 5 {too_many}"));
    assert_eq!(grid(usize::MAX, 2, 1.0), format!("sea map of {} x 2 {too_many}", usize::MAX));
    assert_eq!(grid(65536, 65536, 1.0), format!("sea map of 65536 x 65536 {too_many}"));
    assert_eq!(grid(4, 4, 0.0), "facet of 0 m: allowed are 0.0001 to 100000 m");
    assert_eq!(grid(4, 4, f64::NAN), "facet of NaN m: allowed are 0.0001 to 100000 m");
    let patch = |size_m, facet_m| Patch::new(size_m, facet_m, [0.0; 2]).unwrap_err().to_string();
    assert_eq!(patch([5.0, 1.0], 2.0), "patch of 5 m along x is not a multiple of the facet of 2 m");
    assert_eq!(patch([4.0, 1.0], 2.0), "facet of 2 m is larger than the patch of 1 m along y");
    assert_eq!(
        patch([4.0, f64::INFINITY], 2.0),
        "patch of inf m along y: it must be a finite length above 0"
    );
    assert_eq!(patch([4.0, 4.0], -1.0), "facet of -1 m: it must be a finite length above 0");
    assert_eq!(patch([1e9, 4.0], 1.0), "patch of 1000000000 facets along x: at most 1048576 are allowed");
    let far = Patch::new([4.0, 4.0], 1.0, [f64::NAN, 0.0]).unwrap_err();
    assert!(matches!(far, PatchError::Centre { axis: 'x', .. }));
    // A tenth is not a binary number; thirty of them are still three metres.
    assert_eq!(Patch::new([3.0, 0.3], 0.1, [0.0; 2]).unwrap().facets, [30, 3]);
    let depth = Dispersion { capillary: false, depth_m: Some(0.0) };
    let flat = Elfouhaily::new(&calm_or(0.0), Development::default()).unwrap();
    let unit = Grid::new(1, 1, 1.0).unwrap();
    let error = Surface::synthesise(unit, &flat, depth, 0, Averaging::Points).unwrap_err();
    assert_eq!(error.to_string(), "water depth of 0 m: allowed are 0.1 to 100000 m, or none for deep water");
}

fn wave_numbers() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-7.0..6.0f64).prop_map(|power| 10f64.powf(power)),
        1 => prop::sample::select(vec![0.0, 5e-324, 1e-300, 1e-100, 1e8, 1e9, 1e200, f64::MAX, f64::INFINITY]),
    ]
}

proptest! {
    #![proptest_config(crate::cases::proptests(48))]

    #[test]
    fn any_spectrum_of_any_wind_is_finite(
        u10 in prop_oneof![0.0..40.0f64, 0.0..1.0f64],
        direction in -7.0..7.0f64,
        waves in prop::collection::vec((wave_numbers(), -4.0..4.0f64), 12),
        step in 1e-4..1.0f64,
    ) {
        let wind = Wind::from_speed(u10, 10.0, WindProfile::Cardone, direction).unwrap();
        for (name, sea) in every_spectrum(&wind) {
            let [low, high] = sea.half_power_band_rad_m();
            prop_assert!(low.is_finite() && high.is_finite() && low <= high, "{} {} {}", name, low, high);
            prop_assert!(sampling::least_length_m(sea.as_ref(), 0.25).is_finite());
            for (k, azimuth) in &waves {
                let at = WaveVector::polar(*k, *azimuth);
                let mut values = vec![
                    sea.omnidirectional_m3(*k),
                    sea.wave_m4(at),
                    sea.symmetric_m4(at),
                    sea.cell_mean_m4(at, [step, 1.3 * step]),
                ];
                if k.is_finite() && *k < 1e100 {
                    values.extend([sea.spreading_per_rad(at), sea.symmetric_spreading_per_rad(at)]);
                }
                for value in values {
                    prop_assert!(value.is_finite() && value >= 0.0, "{} at {}: {}", name, k, value);
                }
            }
        }
    }

    #[test]
    fn any_surface_is_finite(
        u10 in 0.0..40.0f64,
        direction in -7.0..7.0f64,
        nx in 1usize..24,
        ny in 1usize..24,
        facet in prop_oneof![1e-4..1.0f64, 1.0..1e5f64],
        depth in prop_oneof![Just(None), (0.1..1e5f64).prop_map(Some)],
        capillary in any::<bool>(),
        seed in any::<u64>(),
        time in -1e9..1e9f64,
        which in 0usize..11,
    ) {
        let wind = Wind::from_speed(u10, 10.0, WindProfile::Cardone, direction).unwrap();
        let (name, sea) = every_spectrum(&wind).swap_remove(which);
        let dispersion = Dispersion { capillary, depth_m: depth };
        let grid = Grid::new(nx, ny, facet).unwrap();
        let surface = Surface::synthesise(grid, sea.as_ref(), dispersion, seed, Averaging::Automatic).unwrap();
        prop_assert!(surface.expected().variance_m2.is_finite());
        let mut fields = Fields::<f32>::new(&grid, Selection::ALL);
        Evaluator::new(&surface).evaluate(time, &mut fields).unwrap();
        let columns = [vec![fields.height_m], fields.slope.into(), fields.velocity_mps.into(),
            fields.acceleration_mps2.into(), fields.displacement_m.into(), fields.slope_rate_per_s.into()];
        for value in columns.iter().flatten().flatten() {
            prop_assert!(value.is_finite(), "{}", name);
        }
    }

    #[test]
    fn any_facet_density_is_finite(ustar in 1e-3..3.0f64, carrier in 1e8..1e11f64, incidence in 0.0..1.7f64) {
        let density = FacetDensity::rayleigh(ustar, carrier, incidence);
        prop_assert!(density.facets_per_m.is_finite() && density.facets_per_m >= 0.0);
        prop_assert!(density.wave_number_rad_m.is_finite());
    }

    #[test]
    fn any_frequency_has_its_wave_number(power in -3.0..3.0f64, depth in prop_oneof![Just(None), (0.1..1e4f64).prop_map(Some)], capillary in any::<bool>()) {
        let dispersion = Dispersion { capillary, depth_m: depth };
        let omega = 10f64.powf(power);
        let k = dispersion.wave_number_rad_m(omega);
        prop_assert!((dispersion.angular_frequency_rad_s(k) / omega - 1.0).abs() < 1e-12);
        // The group speed is the slope of the frequency.
        let step = 1e-5 * k;
        let slope = (dispersion.angular_frequency_rad_s(k + step) - dispersion.angular_frequency_rad_s(k - step)) / (2.0 * step);
        prop_assert!((dispersion.group_speed_mps(k) / slope - 1.0).abs() < 1e-8);
    }

    #[test]
    fn no_bytes_break_the_readers(bytes in prop::collection::vec(any::<u8>(), 0..300), text in "[0-9eE.,\n# -]{0,200}") {
        let _ = Measured::parse(&bytes);
        let _ = Measured::parse(text.as_bytes());
        let _ = Measured::parse(format!("kx_rad_m,ky_rad_m,psi_m4\n{text}").as_bytes());
        let mut state = b"NEREUSEA\x01\0\0\0".to_vec();
        state.extend(&bytes);
        prop_assert!(Surface::load(&mut state.as_slice()).is_err());
        prop_assert!(Surface::load(&mut bytes.as_slice()).is_err());
    }
}
