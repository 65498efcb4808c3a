//! What interpolation leaves of the waves: of the way a facet moves, and of its tilt.
//!
//! Waves of wave number K have the variance `S(K) dK` and turn at `w(K)`. A facet moves as far along as it
//! moves up, so a wave of amplitude A changes a path by at most `|g| A`, `|g|` the length of the path's
//! gradient (2 for one antenna, less for two). Interpolation leaves a mean square
//!
//! `path: |g|^2 integral of S E^2(w, t) dK ,   slope: integral of K^2 S E^2(w, t) dK`
//!
//! (`E` of [`super::interpolation`]). For waves that are slow against the nodes that is
//! `prod^2 (t - t_i)/(n!)^2` times the moment `integral of w^(2n) S`: the eighth for four nodes. In deep
//! water `w^8 = g^4 K^4`, so it is the shortest waves on the grid that count.
//!
//! A slope error is an error of the amplitude through `d ln a / d slope`, a number of a few units away from
//! shadows, back faces and nulls of the pattern of scattering; where facets turn away from an antenna
//! amplitudes have a kink, and this is a lower bound.
//!
//! | symbol | meaning | unit |
//! | --- | --- | --- |
//! | `S` | omnidirectional spectrum | m^3 |
//! | `w` | angular frequency | rad/s |

use super::interpolation::Nodes;
use nereus::scene::water::Dispersion;
use nereus::scene::water::WindProfile;
use nereus::sea::GRAVITY_MPS2;
use nereus::sea::spectrum::{FungLee, moments::Moments};
use nereus::sea::spectrum::{MAX_WAVE_NUMBER_RAD_M, Spectrum};
use nereus::sea::wind::Wind;

/// Points of the integrals, odd.
const POINTS: usize = 601;
/// Longest waves that count, rad/m: 6000 km.
const LONGEST_RAD_M: f64 = 1e-6;

/// A band of waves as oscillations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Waves {
    parts: Vec<Part>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    omega_rad_s: f64,
    variance_m2: f64,
    slope_variance: f64,
}

impl Waves {
    /// Waves of a spectrum in a band, rad/m: of a patch, from `2 pi / length` to `pi / facet`. None of an
    /// empty band.
    pub fn of(spectrum: &dyn Spectrum, dispersion: &Dispersion, [low_rad_m, high_rad_m]: [f64; 2]) -> Self {
        if low_rad_m.is_nan() || high_rad_m.is_nan() {
            return Self::default();
        }
        let (low_rad_m, high_rad_m) = (low_rad_m.max(LONGEST_RAD_M), high_rad_m.min(MAX_WAVE_NUMBER_RAD_M));
        if high_rad_m <= low_rad_m {
            return Self::default();
        }
        // Simpson's rule in ln K.
        let step = (high_rad_m / low_rad_m).ln() / (POINTS - 1) as f64;
        let part = |i: usize| {
            let k = low_rad_m * (i as f64 * step).exp();
            let simpson = if i == 0 || i == POINTS - 1 { 1.0 } else { [2.0, 4.0][i % 2] };
            let variance_m2 = simpson * step / 3.0 * k * spectrum.omnidirectional_m3(k);
            Part {
                omega_rad_s: dispersion.angular_frequency_rad_s(k),
                variance_m2,
                slope_variance: k * k * variance_m2,
            }
        };
        Self { parts: (0..POINTS).map(part).filter(|part| part.variance_m2 > 0.0).collect() }
    }

    /// What nodes leave of a path of gradient `|g|` at a time, m^2.
    pub fn path_power_m2(&self, gradient: f64, nodes: &Nodes, t_s: f64) -> f64 {
        let left = |part: &Part| part.variance_m2 * nodes.error(part.omega_rad_s, t_s).powi(2);
        gradient * gradient * self.parts.iter().map(left).sum::<f64>()
    }

    /// What nodes leave of the slopes at a time, along and across together.
    pub fn slope_power(&self, nodes: &Nodes, t_s: f64) -> f64 {
        self.parts.iter().map(|part| part.slope_variance * nodes.error(part.omega_rad_s, t_s).powi(2)).sum()
    }

    /// `integral of w^power S dK`, m^2 (rad/s)^power.
    pub fn moment(&self, power: i32) -> f64 {
        self.parts.iter().map(|part| part.variance_m2 * part.omega_rad_s.powi(power)).sum()
    }
}

const BAND: [f64; 2] = [std::f64::consts::TAU / 512.0, std::f64::consts::PI];

fn sea() -> FungLee {
    FungLee::new(&Wind::from_speed(10.0, 10.0, WindProfile::Cardone, 0.0).unwrap())
}

#[test]
fn moments_are_those_of_the_spectrum() {
    let waves = Waves::of(&sea(), &Dispersion::default(), BAND);
    let moments = Moments::of(&sea(), BAND);
    // Simpson's rule with 601 points against 40001.
    assert!((waves.moment(0) / moments.variance_m2 - 1.0).abs() < 1e-4);
    // In deep water w^4 = g^2 K^2.
    let fourth = GRAVITY_MPS2.powi(2) * moments.mean_square_slope;
    assert!((waves.moment(4) / fourth - 1.0).abs() < 1e-4, "{} {fourth}", waves.moment(4));
}

#[test]
fn four_nodes_leave_the_eighth_moment() {
    let waves = Waves::of(&sea(), &Dispersion::default(), BAND);
    // Waves up to 5.5 rad/s, nodes 9 ms apart: the next order is (w h)^2 = 0.3 % off.
    let (nodes, t_s) = (Nodes::evenly(4, 0.009), 0.0045);
    let product: f64 = nodes.times_s().iter().map(|node| (t_s - node).abs()).product();
    let expected = waves.moment(8) * (product / 24.0).powi(2) * 4.0;
    let found = waves.path_power_m2(2.0, &nodes, t_s);
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

#[test]
fn no_waves_no_error() {
    let nodes = Nodes::evenly(4, 1.0);
    for band in [[2.0, 1.0], [0.0, 0.0], [f64::NAN, f64::NAN]] {
        let waves = Waves::of(&sea(), &Dispersion::default(), band);
        assert_eq!((waves.path_power_m2(2.0, &nodes, 0.5), waves.slope_power(&nodes, 0.5)), (0.0, 0.0));
    }
    let all = Waves::of(&sea(), &Dispersion::default(), [0.0, f64::INFINITY]);
    assert!(all.path_power_m2(2.0, &nodes, 0.5).is_finite() && all.slope_power(&nodes, 0.5).is_finite());
    // Simpson's rule with 601 points over 32 e-folds, 0.05 each, against 40001.
    let height = Moments::of(&sea(), [1e-6, 1e8]).variance_m2;
    assert!((all.moment(0) / height - 1.0).abs() < 1e-3, "{} {height}", all.moment(0));
}
