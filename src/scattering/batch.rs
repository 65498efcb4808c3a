//! One kind of water surface, evaluated a batch of facets at a time.

use num_complex::Complex64;

use super::facets::{Facets, LengthError, Phases};
use super::kind::Kind;
use super::lanes::LaneKind;
use super::lanes::table::BraggTable;
use super::modulation::TiltBias;
use super::two_scale::{Medium, Settings, TwoScale};

/// Facets of one kind, a batch at a time.
pub(super) trait Batch: Send + Sync {
    fn scatter(&self, facets: &Facets, phases: Phases, out: [&mut [Complex64]; 4])
    -> Result<(), LengthError>;
    fn bragg_table(&self) -> BraggTable;
    fn lane_kind(&self, table: &BraggTable) -> LaneKind;
    fn lane_tilts(&self) -> Vec<[f32; 3]>;

    /// With waves besides those of the wind: facet, wave vector on the axes of the wind.
    fn scatter_beside(
        &self,
        facets: &Facets,
        phases: Phases,
        beside: &dyn Fn(usize, f64, f64) -> f64,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError>;
}

impl<K: Kind + Send + Sync, F: Fn(f64, f64) -> f64 + Send + Sync> Batch for TwoScale<K, F> {
    fn scatter(
        &self,
        facets: &Facets,
        phases: Phases,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        facets.scatter(self, phases, out)
    }

    fn bragg_table(&self) -> BraggTable {
        TwoScale::bragg_table(self)
    }

    fn lane_kind(&self, table: &BraggTable) -> LaneKind {
        TwoScale::lane_kind(self, table)
    }

    fn lane_tilts(&self) -> Vec<[f32; 3]> {
        TwoScale::lane_tilts(self)
    }

    fn scatter_beside(
        &self,
        facets: &Facets,
        phases: Phases,
        beside: &dyn Fn(usize, f64, f64) -> f64,
        out: [&mut [Complex64]; 4],
    ) -> Result<(), LengthError> {
        facets.scatter_beside(self, phases, beside, out)
    }
}

/// One kind, its sub-facets modulated or not.
pub(super) fn batch<K, F>(
    settings: Settings,
    medium: Medium,
    kind: K,
    psi: F,
    bias: Option<TiltBias>,
) -> Box<dyn Batch>
where
    K: Kind + Send + Sync + 'static,
    F: Fn(f64, f64) -> f64 + Send + Sync + 'static,
{
    Box::new(TwoScale::new(settings, medium, kind, psi).with_tilt_bias(bias))
}
