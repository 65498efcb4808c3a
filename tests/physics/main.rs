//! Physics against golden values, closed forms and independent computations.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

#[path = "../support/cases.rs"]
mod cases;
#[path = "../support/dem.rs"]
mod dem;
mod bragg_doppler;
mod breaking;
mod calibration;
mod choppy;
mod clocks;
mod clutter_nrl;
mod echo_golden;
mod echo_peak;
mod echo_quadrature;
mod hull_particulars;
mod hull_tables;
mod land_raster;
mod light_wind;
mod measured_tail;
mod modulation;
mod polarisation;
mod quadrature;
mod radar_extremes;
mod radar_golden;
mod radar_link;
mod radar_pattern;
mod radar_pointing;
mod radar_scenes;
mod radar_windows;
mod receiver_converter;
mod receiver_noise;
mod scatter_batch;
mod scatter_composite;
mod scatter_extremes;
mod scatter_golden;
mod scatter_laws;
mod scatter_options;
mod scatter_oracle;
mod sea_paths;
mod sea_extremes;
mod sea_golden;
mod sea_ships;
mod sea_spectrum;
mod sea_surface;
mod sea_wind;
mod shadow;
mod shadow_extremes;
mod ship_panels;
mod target_aspect;
mod target_fluctuation;
mod target_heave;
mod target_multipath;
mod tilt_mean;
mod wake_extremes;
mod wake_laws;
mod wake_map;
mod wake_short;
mod wake_turbulent;
mod wake_kochin;
mod waveform_spectrum;

use nereus::scattering::kind::Kind;
use nereus::scattering::two_scale::{Medium, Settings, TwoScale};

/// A spectrum by wavenumbers, rad/m: `psi(kx, ky)`, m^4.
type Psi<'a> = Box<dyn Fn(f64, f64) -> f64 + Send + Sync + 'a>;

/// A sea over any spectrum, compiled once for all of them.
fn two_scale<'a, K: Kind>(
    settings: Settings,
    medium: Medium,
    kind: K,
    psi: impl Fn(f64, f64) -> f64 + Send + Sync + 'a,
) -> TwoScale<K, Psi<'a>> {
    TwoScale::new(settings, medium, kind, Box::new(psi))
}
