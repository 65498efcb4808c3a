//! The surface at nodes, in the precision that an error asks for.
//!
//! A transform in f32 leaves some 3e-7 of the rms height: with waves of 0.6 m and the carrier at 10 GHz -83
//! dB of the echo, and as much more as the strongest pulse has over the mean. Where that is too much, what
//! moves facets, heights and horizontal displacements, is transformed in f64 and rounded at its end: 3e-8 of
//! each, 20 dB less. So are the waves of ships. Slopes, velocities and modulations stay in f32: what they
//! lose changes amplitudes by parts in a million, and no phase.

use std::mem::take;

use crate::paths::sea::SeaPlan;
use crate::scene::Patch;
use crate::sea::facet_surface::FacetSurface;
use crate::sea::land::LandSheet;
use crate::sea::surface::{Fields, Selection};
use crate::sea::wake::WakeError;

/// Makes the surface of nodes.
#[derive(Clone)]
pub(super) struct NodeSurface {
    surface: Box<FacetSurface<f32>>,
    fine: Option<Box<Finer>>,
}

/// What moves facets, in f64.
#[derive(Clone)]
struct Finer {
    surface: FacetSurface<f64>,
    /// Linear waves, then those of ships.
    waves: Fields<f64>,
}

/// Slopes of all facets at an instant.
#[derive(Clone)]
pub(super) struct Slopes(Fields<f32>);

impl Slopes {
    /// Of a facet, by its place in the patch.
    pub fn of(&self, index: usize) -> [f32; 2] {
        self.0.slope.each_ref().map(|slope| slope[index])
    }
}

impl NodeSurface {
    /// Of a sea; `fine`: what moves facets in f64. `None` where its wakes are illegal.
    pub fn of(sea: &SeaPlan, selection: Selection, fine: bool) -> Option<Self> {
        let surface = FacetSurface::new(&sea.surface, selection)
            .with_relaxation(sea.scattering.relaxation_per_s())
            .with_choppy(sea.choppy)
            .with_land(sea.land.as_ref().map(|land| &land.sheet));
        let patch = &sea.patch;
        let surface = Box::new(surface.with_wakes(&sea.wakes, patch).ok()?);
        if !fine {
            return Some(Self { surface, fine: None });
        }
        let displacement = selection.displacement || sea.choppy.is_some();
        let moving = Selection { displacement, vertical_acceleration: false, ..Selection::HEIGHT };
        let finer = FacetSurface::<f64>::new(&sea.surface, moving).with_wakes(&sea.wakes, patch).ok()?;
        let waves = finer.fields(patch);
        Some(Self { surface, fine: Some(Box::new(Finer { surface: finer, waves })) })
    }

    /// Room for the fields over a patch.
    pub fn fields(&self, patch: &Patch) -> Fields<f32> {
        self.surface.fields(patch)
    }

    /// Fields at a time, as [`FacetSurface::evaluate`] has them.
    ///
    /// # Errors
    /// Those of that.
    pub fn evaluate(&mut self, time_s: f64, patch: &Patch, out: &mut Fields<f32>) -> Result<(), WakeError> {
        let Self { surface, fine } = self;
        let Some(Finer { surface: finer, waves }) = fine.as_deref_mut() else {
            return surface.evaluate(time_s, patch, out);
        };
        // Fields without room are left out.
        let moving = |out: &mut Fields<f32>| (take(&mut out.height_m), take(&mut out.displacement_m));
        let kept = moving(out);
        surface.evaluate_linear(time_s, patch, out)?;
        (out.height_m, out.displacement_m) = kept;
        finer.evaluate_linear(time_s, patch, waves)?;
        out.round_from(waves);
        surface.make_choppy(out);
        if finer.has_wakes() {
            let kept = moving(out);
            surface.add_wakes(time_s, patch, out)?;
            (out.height_m, out.displacement_m) = kept;
            waves.clear();
            finer.add_wakes(time_s, patch, waves)?;
            out.add_rounded(waves);
        }
        surface.lay_land(patch, out);
        Ok(())
    }

    /// Room for the slopes alone.
    pub fn slopes(&self, patch: &Patch) -> Slopes {
        Slopes(self.surface.room_for_slopes(patch))
    }

    /// Slopes at a time.
    ///
    /// # Errors
    /// Those of [`FacetSurface::evaluate`].
    pub fn evaluate_slopes(&mut self, time_s: f64, patch: &Patch, out: &mut Slopes) -> Result<(), WakeError> {
        self.surface.evaluate(time_s, patch, &mut out.0)
    }

    /// The land of the patch evaluated last.
    pub fn land(&self) -> Option<&LandSheet> {
        self.surface.land()
    }
}
