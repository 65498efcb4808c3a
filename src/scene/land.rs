//! Land of a scene: where its heights come from, and what it returns.

use std::path::PathBuf;

/// Land on the patch of sea: whatever a height raster has above the sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Land {
    /// GeoTIFF of heights, m.
    pub dem: PathBuf,
    /// Height of the mean sea surface in the raster's vertical datum, m.
    pub sea_level_m: f64,
    /// Normalised cross section at normal incidence of the constant-gamma law, vertical polarisation, a
    /// ratio.
    pub gamma: f64,
    /// HH over VV, a ratio of powers.
    pub hh_over_vv: f64,
    /// HV and VH over VV, a ratio of powers.
    pub cross_over_vv: f64,
}
