//! Physics against golden values, closed forms and independent computations.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

mod clutter_nrl;
mod echo_golden;
mod echo_peak;
mod echo_quadrature;
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
mod sea_contacts;
mod sea_extremes;
mod sea_golden;
mod sea_spectrum;
mod sea_surface;
mod sea_wind;
mod shadow;
mod shadow_extremes;
mod wake_extremes;
mod wake_laws;
mod wake_map;
mod wake_turbulent;
mod waveform_spectrum;
