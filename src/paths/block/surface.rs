//! The surface at nodes, in the precision that an error asks for.
//!
//! A transform in f32 leaves some 3e-7 of the rms height: with waves of 0.6 m and the carrier at 10 GHz -83
//! dB of the echo, and as much more as the strongest pulse has over the mean. One in f64, rounded at its
//! end, leaves 3e-8 of each height, 20 dB less, for twice the time.

use crate::paths::sea::SeaPlan;
use crate::scene::Patch;
use crate::sea::facet_surface::FacetSurface;
use crate::sea::land::LandSheet;
use crate::sea::surface::fields::Real;
use crate::sea::surface::{Fields, Selection};
use crate::sea::wake::WakeError;

/// Makes the surface of nodes.
#[derive(Clone)]
pub(super) enum NodeSurface {
    /// In f32 throughout.
    Single(Box<FacetSurface<f32>>),
    /// In f64 until its end.
    Double(Box<FacetSurface<f64>>, Box<Fields<f64>>),
}

/// Slopes of all facets at an instant.
#[derive(Clone)]
pub(super) struct Slopes {
    fields: Fields<f32>,
    fine: Option<Fields<f64>>,
}

impl Slopes {
    /// Of a facet, by its place in the patch.
    pub fn of(&self, index: usize) -> [f32; 2] {
        self.fields.slope.each_ref().map(|slope| slope[index])
    }
}

impl NodeSurface {
    /// Of a sea; `fine`: in f64. `None` where its wakes are illegal.
    pub fn of(sea: &SeaPlan, selection: Selection, fine: bool) -> Option<Self> {
        Some(if fine {
            let surface: FacetSurface<f64> = surface(sea, selection)?;
            let fields = surface.fields(&sea.patch);
            Self::Double(Box::new(surface), Box::new(fields))
        } else {
            Self::Single(Box::new(surface(sea, selection)?))
        })
    }

    /// Room for the fields over a patch.
    pub fn fields(&self, patch: &Patch) -> Fields<f32> {
        match self {
            Self::Single(surface) => surface.room(patch),
            Self::Double(surface, _) => surface.room(patch),
        }
    }

    /// Fields at a time, as [`FacetSurface::evaluate`] has them.
    ///
    /// # Errors
    /// Those of that.
    pub fn evaluate(&mut self, time_s: f64, patch: &Patch, out: &mut Fields<f32>) -> Result<(), WakeError> {
        match self {
            Self::Single(surface) => surface.evaluate(time_s, patch, out),
            Self::Double(surface, fine) => {
                surface.evaluate(time_s, patch, fine)?;
                out.round_from(fine);
                Ok(())
            }
        }
    }

    /// Room for the slopes alone.
    pub fn slopes(&self, patch: &Patch) -> Slopes {
        match self {
            Self::Single(surface) => Slopes { fields: surface.room_for_slopes(patch), fine: None },
            Self::Double(surface, _) => {
                let (fields, fine) = (surface.room_for_slopes(patch), surface.room_for_slopes(patch));
                Slopes { fields, fine: Some(fine) }
            }
        }
    }

    /// Slopes at a time.
    ///
    /// # Errors
    /// Those of [`FacetSurface::evaluate`].
    pub fn evaluate_slopes(&mut self, time_s: f64, patch: &Patch, out: &mut Slopes) -> Result<(), WakeError> {
        match (self, &mut out.fine) {
            (Self::Double(surface, _), Some(fine)) => {
                surface.evaluate(time_s, patch, fine)?;
                out.fields.round_from(fine);
                Ok(())
            }
            (own, _) => own.evaluate(time_s, patch, &mut out.fields),
        }
    }

    /// The land of the patch evaluated last.
    pub fn land(&self) -> Option<&LandSheet> {
        match self {
            Self::Single(surface) => surface.land(),
            Self::Double(surface, _) => surface.land(),
        }
    }
}

fn surface<T: Real>(sea: &SeaPlan, selection: Selection) -> Option<FacetSurface<T>> {
    let surface = FacetSurface::new(&sea.surface, selection)
        .with_relaxation(sea.scattering.relaxation_per_s())
        .with_choppy(sea.choppy)
        .with_wakes(&sea.wakes, &sea.patch)
        .ok()?;
    Some(surface.with_land(sea.land.as_ref().map(|land| &land.sheet)))
}
