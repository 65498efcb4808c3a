//! How the patch of a sea moves in a run, and what it asks of its shadows.

use crate::radar::fault::SeaFault;
use crate::scene::Patch;
use crate::scene::sea::{PatchPlace, Sea, Shadowing};

/// Rows that a patch may always move between updates of its shadows, however small it is.
const LEAST_MARGIN: usize = 64;
/// How the patch moves in a run.
pub(super) struct PatchRun {
    /// Where it lies at some times, s after pulse 0: the first and the last emission, and some between.
    pub patches: Vec<(f64, Patch)>,
    /// A bound on its speed, m/s.
    pub patch_mps: f64,
    /// How long a patch that follows stays where it is, s.
    pub hold_s: f64,
    /// Whether the patch comes near the horizon of an antenna.
    pub nears_horizon: bool,
    /// Whether ships stand in the way.
    pub hulls: bool,
}

/// Longest time for which a patch that follows stays, s, and facets that it may jump then.
const LONGEST_HOLD_S: f64 = 0.5;
const FACETS_A_JUMP: f64 = 16.0;

/// How many pulses a patch that follows at a speed stays where it is: a choice of the model, which knows no
/// blocks, but a number with many divisors, so that blocks fit. `None` where it stays for good.
pub(super) fn hold_pulses(patch_mps: f64, facet_m: f64, interval_s: f64) -> Option<u64> {
    const ROUND: [u64; 9] = [24, 18, 12, 9, 6, 4, 3, 2, 1];
    if patch_mps == 0.0 {
        return None;
    }
    let longest_s = LONGEST_HOLD_S.min(FACETS_A_JUMP * facet_m / patch_mps);
    let most = (longest_s / interval_s).floor() as u64;
    let held = if most >= 36 { most / 36 * 36 } else { ROUND.into_iter().find(|n| *n <= most).unwrap_or(1) };
    Some(held)
}

impl PatchRun {
    /// How visibility is found: where waves hide nothing, the earth may.
    pub fn shadowing(&self, sea: &Sea) -> Option<Shadowing> {
        let of_earth = || {
            (self.nears_horizon || self.hulls)
                .then_some(Shadowing { width_rad: Some(0.0), ..Shadowing::default() })
        };
        sea.shadow.or_else(of_earth)
    }

    /// Rows by which an update of the shadows must exceed the patch on each side, so that it has every facet
    /// asked for until the next: what the patch moves between the two, and while it is held.
    pub fn margin(&self, sea: &Sea) -> Result<usize, SeaFault> {
        let (PatchPlace::Follow { .. }, Some(shadow)) = (&sea.place, self.shadowing(sea)) else {
            return Ok(0);
        };
        let facet_m = sea.patch.facet_m;
        let rows = (self.patch_mps * (shadow.update_s + self.hold_s) / facet_m).ceil() as usize + 1;
        let most = sea.patch.facets[0].max(sea.patch.facets[1]).max(LEAST_MARGIN);
        if rows > most {
            let update_ms = 1e3 * ((most - 1) as f64 * facet_m / self.patch_mps - self.hold_s).max(0.0);
            return Err(SeaFault::SlowUpdates { rows, most, update_ms });
        }
        Ok(rows)
    }
}
