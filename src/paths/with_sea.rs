//! What a sea brings into the generator: its patch, what it lifts, hides and reflects.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::PathGenerator;
use super::multipath::{self, Mirror};
use super::patch_run::{self, PatchRun};
use super::sea::{Drawn, SeaPlan};
use crate::radar::fault::{RadarError, RadarFault};
use crate::scene::Scene;
use crate::scene::sea::Sea;

impl PathGenerator {
    /// Plans the sea of a scene with `counts` transmitters and receivers, and finds what of the scene depends
    /// on it.
    ///
    /// # Errors
    /// Where the patch cannot be followed; other faults are added to those found before.
    pub(super) fn plan_sea(
        &mut self,
        scene: &Scene,
        sea: &Sea,
        drawn: Drawn<'_>,
        counts: [usize; 2],
        faults: &mut Vec<RadarFault>,
    ) -> Result<(), RadarError> {
        let patch_mps = self.patch_speed_mps(sea)?;
        let interval_s = 1.0 / self.radar.emissions.mean_prf_hz();
        self.hold_pulses = patch_run::hold_pulses(patch_mps, sea.patch.facet_m, interval_s);
        let hold_s = self.hold_pulses.map_or(f64::INFINITY, |pulses| pulses as f64 * interval_s);
        let (patches, nears_horizon) = (self.patches(sea)?, self.nears_horizon(sea)?);
        let hulls = scene.ships.iter().any(|ship| !ship.panels.is_empty());
        let run = PatchRun { patches, patch_mps, hold_s, nears_horizon, hulls };
        let plan = SeaPlan::new(scene, sea, drawn, &run, faults);
        if let Some((plan, ships)) = plan.map(|plan| plan.with_ships(&scene.ships, counts, self.frame)) {
            (self.sea, self.ships) = (Some(Arc::new(plan)), ships);
        }
        self.heaves = Arc::new(self.lifted_by(self.sea.as_deref()));
        self.hills = self.hidden_by(self.sea.as_deref()).map(Arc::new);
        self.mirror = self.sea.as_ref().map(|sea| Mirror {
            earth: self.frame.earth(),
            permittivity: sea.scattering.permittivity(),
            height_rms_m: sea.surface.expected().variance_m2.sqrt(),
            wave_number_rad_m: TAU / self.radar.wavelength_m(),
        });
        self.images = self.mirror.map_or_else(Vec::new, |_| multipath::images(&self.targets));
        Ok(())
    }
}
