//! What each thing that scatters returns, as one flat list of scatterer paths.

mod batch;
pub mod bragg;
pub mod breaking;
pub mod clutter_nrl;
pub mod target;
pub mod facets;
pub mod fresnel;
pub mod kind;
pub mod kirchhoff;
pub mod land;
pub mod lanes;
pub mod modes;
pub mod modulation;
pub mod permittivity;
pub mod physical_optics;
pub mod roughness;
pub mod sigma0;
pub mod slope_pdf;
pub mod speckle;
pub mod splitting;
pub mod spm;
pub mod tilt;
pub mod two_rays;
pub mod two_scale;
pub mod water;
