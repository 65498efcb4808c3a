//! What waves and land do to the targets of a scene: which of them float, and what may hide them.

use std::collections::HashMap;
use std::sync::Arc;

use super::PathGenerator;
use super::heave::{self, Crests, Heave, Wave};
use super::hidden::Hills;
use super::sea::SeaPlan;
use crate::scene::Target;
use crate::sea::land::Dem;

impl PathGenerator {
    /// Heights of the land; `None` without any.
    pub fn dem(&self) -> Option<Arc<Dem>> {
        Some(self.sea.as_ref()?.land.as_ref()?.sheet.dem())
    }

    /// What lifts the targets that float on a sea, and hides them; empty where none floats.
    pub(super) fn lifted_by(&self, sea: Option<&SeaPlan>) -> Vec<Option<Heave>> {
        let Some(sea) = sea else { return Vec::new() };
        if self.targets.iter().all(|target| target.floating.is_none()) {
            return Vec::new();
        }
        let last_s = self.last_emission_s();
        let crests = sea.visibility.as_ref().filter(|visibility| visibility.waves).map(|visibility| Crests {
            width_rad: visibility.settings.width_rad,
            facet_m: sea.patch.facet_m,
            reach_m: sea.reach_m,
            antennas: visibility.ends,
        });
        let mut known: HashMap<u64, Arc<[Wave]>> = HashMap::new();
        let of = |target: &Target| {
            let waterline_m = target.floating?.waterline_m;
            let known = known.entry(waterline_m.to_bits());
            let waves = known.or_insert_with(|| heave::waves(&sea.surface, waterline_m));
            Some(Heave::new(target, &self.frame, Arc::clone(waves), crests, last_s))
        };
        self.targets.iter().map(of).collect()
    }

    /// The land that hides targets and ships, where it hides facets.
    pub(super) fn hidden_by(&self, sea: Option<&SeaPlan>) -> Option<Hills> {
        let sea = sea.filter(|_| !(self.targets.is_empty() && self.ships.is_empty()))?;
        let (land, visibility) = (sea.land.as_ref()?, sea.visibility.as_ref()?);
        if !visibility.waves || land.top_m == 0.0 {
            return None;
        }
        let ends = visibility.ends;
        let (width_rad, facet_m) = (visibility.settings.width_rad, sea.patch.facet_m);
        let land = (land.sheet.dem(), self.frame.earth());
        Some(Hills::new(land, (width_rad, facet_m), ends, &self.targets, self.last_emission_s()))
    }

    fn last_emission_s(&self) -> f64 {
        self.radar.emissions.elapsed_s(self.pulses.saturating_sub(1))
    }
}
