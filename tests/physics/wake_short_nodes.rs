//! Short waves of ships on nodes, held to the integral of which they are the fast form.

use std::f64::consts::TAU;
use std::path::Path;

use nereus::cpu::Variant;
use nereus::scene::Hull;
use nereus::sea::GRAVITY_MPS2;
use nereus::sea::wake::kochin::{Kochin, Transom};
use nereus::sea::wake::short_waves::Losses;
use nereus::sea::wake::{Course, Reach, Settings, ShortWaveNodes, ShortWaves};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cases::cases;

/// Largest Bragg wave number of a carrier.
fn most_radpm(carrier_hz: f64) -> f64 {
    2.0 * TAU * carrier_hz / 299_792_458.0
}

/// The waves of the DTMB 5415 of a length at a speed, on facets of a side, for a carrier.
fn ship([length_m, speed_mps, facet_m]: [f64; 3], carrier_hz: f64) -> ShortWaves {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("hulls/dtmb5415.toml");
    let hull = Hull::load(&path).unwrap().scaled_to_length(length_m).unwrap();
    let kochin = Kochin::new(&hull, speed_mps, Transom::Open).unwrap();
    let settings = Settings {
        fade_m: Some([30.0 * length_m, 40.0 * length_m]),
        ..Settings::new(facet_m, Reach::disc(0.0))
    };
    let course = Course::straight([0.0, 0.0], 0.0, speed_mps);
    ShortWaves::new(course, length_m, &settings, most_radpm(carrier_hz), |t| kochin.amplitude_m(t)).unwrap()
}

/// A wave vector near those of a ship, and a place near its rays.
fn draw(rng: &mut impl Rng, [length_m, speed_mps, facet_m]: [f64; 3], most_radpm: f64) -> [[f64; 2]; 2] {
    let mut either = || rng.random_range(-1.0..1.0f64);
    let k0 = GRAVITY_MPS2 / (speed_mps * speed_mps);
    let k = most_radpm * (0.525 + 0.475 * either());
    let t = (k / k0 - 1.0).max(0.0).sqrt();
    let (sec, c) = (t.hypot(1.0), t / (1.0 + 2.0 * t * t));
    let spread = 2.0 * 3f64.sqrt() / facet_m;
    let wave = [k0 * sec, -k0 * sec * t].map(|k| k + spread * either());
    let astern_m = length_m * (10f64.powf(0.3 + 1.3 * either()) - 0.5);
    let aside_m = c * (astern_m - 0.7 * length_m * either()) + 4.0 * facet_m * either().powi(3);
    let [side, sign] = [either(), either()].map(f64::signum);
    [[astern_m, side * aside_m], [sign * wave[0], sign * side * wave[1]]]
}

/// Fewer would not show how large amplitudes get at each wave number and distance.
const DRAWN: usize = 800;

/// Amplitudes, the roots of spectra, of the nodes against those of the integral, over the largest that was
/// drawn with a wave number and a distance like it.
#[test]
fn nodes_have_the_spectrum_of_the_integral() {
    let ships =
        [[100.0, 4.5, 1.0], [100.0, 9.0, 1.0], [20.0, 5.0, 0.5], [300.0, 8.0, 2.0], [100.0, 12.0, 0.25]];
    let losses = Losses { steepest: f64::INFINITY, ..Losses::default() };
    for (shape, carrier_hz) in ships.into_iter().flat_map(|shape| [1.3e9, 5.4e9, 10e9].map(|f| (shape, f))) {
        let waves = ship(shape, carrier_hz).with_losses(losses);
        let nodes = ShortWaveNodes::new(waves.clone());
        let mut rng = ChaCha8Rng::seed_from_u64(17);
        let drawn: Vec<[[f64; 2]; 2]> =
            (0..DRAWN).map(|_| draw(&mut rng, shape, most_radpm(carrier_hz))).collect();
        let exact: Vec<f64> = drawn.iter().map(|[place, k]| waves.psi_m4(*place, *k).sqrt()).collect();
        let size = |[place, k]: &[[f64; 2]; 2]| [k[0].hypot(k[1]), place[0] + 0.6 * shape[0]];
        let (mut worst, mut squares) = (0.0f64, 0.0);
        for (own, exact_here) in drawn.iter().zip(&exact) {
            let [place, k] = own;
            assert!(*exact_here == 0.0 || nodes.wedge(size(own)[0]).holds(*place), "{own:?}");
            let alike = drawn.iter().zip(&exact).filter(|(other, _)| {
                let ratios = size(own).into_iter().zip(size(other)).map(|(a, b)| a / b);
                ratios.into_iter().all(|ratio| (0.5..2.0).contains(&ratio))
            });
            let largest = alike.map(|(_, exact)| *exact).fold(f64::MIN_POSITIVE, f64::max);
            let error = (nodes.psi_m4(Variant::fastest(), *place, *k).sqrt() - exact_here).abs() / largest;
            worst = worst.max(error);
            squares += error * error;
        }
        let rms = (squares / drawn.len() as f64).sqrt();
        println!("{shape:?}, {:.1} GHz: worst {worst:.1e}, rms {rms:.1e}", carrier_hz / 1e9);
        // The integral ends at six deviations of a wave vector, exp(-9) = 1.2e-4 of an amplitude, more where
        // the longer waves there are higher; the nodes go on to the end of their group.
        assert!(worst < 5e-4 && rms < 3e-5);
    }
}

/// Every variant of the instructions has the same spectrum to the rounding of some hundred terms in f32.
#[test]
fn variants_agree() {
    let shape = [100.0, 9.0, 1.0];
    let nodes = ShortWaveNodes::new(ship(shape, 1.3e9));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let drawn: Vec<[[f64; 2]; 2]> = (0..cases(400)).map(|_| draw(&mut rng, shape, 54.5)).collect();
    let (nodes, drawn) = (&nodes, &drawn);
    let of = |variant: Variant| drawn.iter().map(move |[place, k]| nodes.psi_m4(variant, *place, *k).sqrt());
    let first: Vec<f64> = of(Variant::Portable).collect();
    let largest = first.iter().copied().fold(0.0, f64::max);
    for variant in Variant::ALL {
        let worst = of(variant).zip(&first).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f64::max);
        assert!(worst < 100.0 * f64::from(f32::EPSILON), "{variant}: {worst:e}");
    }
}

/// Ships without waves, and nonsense.
#[test]
fn nothing_where_nothing_is() {
    let course = Course::straight([0.0, 0.0], 0.0, 0.0);
    let settings = Settings::new(1.0, Reach::disc(0.0));
    let still = ShortWaves::new(course, 20.0, &settings, 50.0, |_| num_complex::Complex64::ONE).unwrap();
    let nodes = ShortWaveNodes::new(still);
    assert_eq!(nodes.psi_m4(Variant::fastest(), [30.0, 0.0], [3.0, 20.0]), 0.0);
    assert!(!nodes.wedge(0.0).holds([30.0, 0.0]));
    let nodes = ShortWaveNodes::new(ship([100.0, 4.5, 1.0], 1.3e9));
    for place in [[f64::NAN, 0.0], [30.0, f64::NAN], [f64::INFINITY, 0.0], [-51.0, 0.0], [4100.0, 100.0]] {
        assert_eq!(nodes.psi_m4(Variant::fastest(), place, [3.0, 38.0]), 0.0, "{place:?}");
    }
}
