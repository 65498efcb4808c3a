//! Random phasors of the facets of the water: at rest, forgotten, or turned by waves that travel.

use glam::DVec3;
use num_complex::Complex64;

use super::WaterScattering;
use crate::scattering::bragg::{BraggLines, Mechanism};
use crate::scattering::modes::TiltModes;
use crate::scattering::speckle::{Speckle, WAVES, Wave};
use crate::scattering::two_scale::TILTS;

impl WaterScattering {
    /// Random phasors that a facet needs.
    pub fn mechanisms(&self) -> usize {
        self.mechanisms
    }

    /// Random processes that they come from: as many, or the specular part and a few modes of the tilts.
    pub fn processes(&self) -> usize {
        self.modes.as_ref().map_or(self.mechanisms, |modes| 1 + modes.count())
    }

    /// Random processes of which each turns all tilts, where waves travel.
    pub fn travelling_modes(&self) -> usize {
        self.modes.as_ref().map_or(1, TiltModes::count)
    }

    /// What each tilt takes of a mode of facets of Gaussian amplitude; `None` of others.
    pub fn tilt_shares(&self, mode: usize) -> Option<impl Fn(usize) -> f64> {
        self.modes.as_ref().map(|modes| move |tilt: usize| modes.share(mode, tilt))
    }

    /// Whether phasors of [`Self::phasors`] change in time.
    pub fn decorrelates(&self) -> bool {
        self.speckle != Speckle::Frozen
    }

    /// Rms angular frequency of phasors that are forgotten, rad/s; 0 where none are.
    pub fn forgetting_radps(&self) -> f64 {
        self.speckle.deviation_radps()
    }

    /// The lines of Bragg waves that travel, if they do: they turn the phasors of [`Self::phasors`].
    pub fn travelling(&self) -> Option<&BraggLines> {
        self.travelling.as_ref()
    }

    /// Phasors of the facet with a global key, `t_s` after pulse 0, without what turns them where waves
    /// travel.
    pub fn phasors(&self, key: [i64; 2], t_s: f64, out: &mut [Complex64]) {
        self.phasors_of(self.speckle, key, t_s, out);
    }

    /// Phasors of the same facet were they frozen.
    pub fn phasors_at_rest(&self, key: [i64; 2], out: &mut [Complex64]) {
        self.phasors_of(Speckle::Frozen, key, 0.0, out);
    }

    fn phasors_of(&self, speckle: Speckle, key: [i64; 2], t_s: f64, out: &mut [Complex64]) {
        let facet = (key[0], key[1]);
        match &self.modes {
            None => speckle.phasors(self.seed, facet, t_s, out),
            Some(modes) => {
                let mut processes = [Complex64::ZERO; 1 + TILTS];
                let processes = &mut processes[..=modes.count().min(TILTS)];
                speckle.gaussian_phasors(self.seed, facet, t_s, processes);
                if self.travelling.is_some() {
                    processes[0] = Complex64::ONE;
                }
                modes.expand(processes, out);
            }
        }
    }

    /// Phasors where waves travel, for unit directions from the transmitter and to the receiver, `t_s` after
    /// pulse 0: turns those of random phase, and puts those of Gaussian amplitude in their place.
    pub fn travel(&self, key: [i64; 2], directions: (DVec3, DVec3), t_s: f64, phasors: &mut [Complex64]) {
        let Some(lines) = &self.travelling else { return };
        let of = |mechanism, mode| lines.phasor((mechanism, mode), key, directions, t_s);
        let specular = of(Mechanism::Specular, 0);
        if let Some(modes) = &self.modes {
            let mut processes = [specular; 1 + TILTS];
            let processes = &mut processes[..=modes.count().min(TILTS)];
            for (mode, process) in processes[1..].iter_mut().enumerate() {
                *process = of(Mechanism::Bragg, mode);
            }
            return modes.expand(processes, phasors);
        }
        let bragg = of(Mechanism::Bragg, 0);
        for (n, phasor) in phasors.iter_mut().enumerate() {
            *phasor *= if n == 0 { specular } else { bragg };
        }
    }

    /// Waves of the phasor of a mechanism of the same facet, where it decorrelates.
    pub fn waves(&self, key: [i64; 2], mechanism: usize) -> [Wave; WAVES] {
        self.speckle.waves(self.seed, (key[0], key[1]), mechanism)
    }
}
