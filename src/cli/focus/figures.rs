//! What wrong navigation makes of images: predicted and measured figures, as they are printed.

use super::forecast::Law;
use crate::processor::degradation::{Lobe, PhaseTerms};
use serde::Serialize;
use std::path::PathBuf;

/// What `--json` prints.
#[derive(Debug, Serialize)]
pub(super) struct Comparison {
    pub recording: String,
    pub against: Option<String>,
    pub nav: &'static str,
    pub pulses: usize,
    pub first_pulse: u64,
    pub last_pulse: u64,
    pub centre_m: [f64; 3],
    pub pixels: [usize; 2],
    pub pixel_m: f64,
    pub channels: Vec<Channel>,
    pub out: Vec<PathBuf>,
}

#[derive(Debug, Serialize)]
pub(super) struct Channel {
    pub name: String,
    pub pulses: usize,
    /// Length of a cell in range and in cross-range in the middle of the image, m, by theory.
    pub cell_m: Option<[f64; 2]>,
    /// Directions in which shifts in range and in cross-range count, East and North, in the middle of the
    /// image.
    pub directions: Option<[[f64; 2]; 2]>,
    pub pixels: Pixels,
    pub targets: Vec<Target>,
}

/// Both images, pixel by pixel, points left out.
#[derive(Debug, Default, PartialEq, Serialize)]
pub(super) struct Pixels {
    pub count: usize,
    /// Mean power by true over mean power by reported navigation, dB.
    pub mean_loss_db: Option<f64>,
    /// `<I^2>/<I>^2` by true and by reported navigation.
    pub contrast: Option<[f64; 2]>,
    /// `|<I_r I_t*>| / sqrt(<|I_r|^2> <|I_t|^2>)`.
    pub coherence: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct Target {
    pub name: String,
    /// Where it should be, ENU, m.
    pub expected_m: [f64; 3],
    /// What the scenario says of the errors, in closed form.
    pub laws: Vec<Law>,
    /// The error of the path over the aperture.
    pub terms: Option<PhaseTerms>,
    /// Loss by aim that differs from that of the recording compared with, two-way, dB; part of the loss
    /// predicted.
    pub aim_loss_db: Option<f64>,
    pub predicted: Option<Figures>,
    pub measured: Option<Figures>,
    /// Cuts in cross-range by true navigation, by reported navigation and as predicted: power over the peak
    /// without error.
    #[serde(skip)]
    pub curves: [Vec<[f64; 2]>; 3],
}

/// How a point looks by reported navigation beside true navigation.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Figures {
    /// Loss of the peak, dB.
    pub loss_db: f64,
    /// Shift in range and cross-range, cells.
    pub shift_cells: [f64; 2],
    /// The same, m along the cuts.
    pub shift_m: [f64; 2],
    /// Half-power widths over those by true navigation.
    pub width_ratio: [f64; 2],
    /// Highest lobes before and behind, of the cut in range.
    pub range_lobes: [Option<Lobe>; 2],
    /// The same of the cut in cross-range: side lobes or paired echoes.
    pub cross_range_lobes: [Option<Lobe>; 2],
    /// Phase at the place predicted, less that by true navigation at the place expected, rad.
    pub phase_rad: f64,
}

impl Figures {
    /// The side (before or behind the peak in cross-range) on which the highest lobe stands.
    pub fn highest_side(&self) -> usize {
        let level = |lobe: &Option<Lobe>| lobe.map_or(f64::NEG_INFINITY, |lobe| lobe.level_db);
        let [before, behind] = &self.cross_range_lobes;
        usize::from(level(behind) > level(before))
    }
}
