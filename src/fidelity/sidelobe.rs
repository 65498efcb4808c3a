//! Two-way gains below which tiles may be faint, and sums of a sample by gain.
//!
//! Far off the beams a tile returns so little that few instants do for it ([`Tier::Sidelobe`](crate::paths::block::Tier)): of the power of
//! a line source of width `a`, whose two-way pattern is `sinc^4`, `3.9e-3 / x^3` lies beyond `x = a sin(theta) / lambda`. What is left there is
//! sounded at both tiers, in **bins** of gain between the rungs of a ladder, which fall from rung 0 on: a tile of bin `b` has `b` rungs above it,
//! and is faint at rung `r` where `r < b`.
//!
//! ```
//! use nereus::fidelity::sidelobe::Ladder;
//! let ladder = Ladder::new(None);
//! // A tenth of the field, at most, twice: -40 dB.
//! let bin = ladder.bin(0.0099);
//! let rung = ladder.rungs().iter().position(|rung| *rung == Some(-40.0)).unwrap();
//! assert!(ladder.is_faint(bin, rung) && !ladder.is_faint(bin, rung + 1));
//! assert!(!ladder.is_faint(ladder.bin(0.0), ladder.rungs().len() - 1), "at the last rung none is");
//! ```

use super::worst::Sum;

/// A gain from which down nothing is faint, dB.
pub const NONE_DB: f64 = -400.0;

/// Rungs, dB below the peak of both antennas' gains.
const FAINT_DB: [f64; 7] = [-25.0, -30.0, -35.0, -40.0, -45.0, -50.0, -55.0];

/// Gains below which tiles may be faint.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// Falling; the last one, `None`, makes nothing faint.
    candidates_of: Vec<Option<f64>>,
}

impl Candidates {
    /// All rungs, or the one that was asked.
    pub fn new(asked_db: Option<f64>) -> Self {
        let candidates_of = match asked_db {
            Some(none) if none <= NONE_DB => vec![None],
            Some(asked) => vec![Some(asked)],
            None => FAINT_DB.into_iter().map(Some).chain([None]).collect(),
        };
        Self { candidates_of }
    }

    /// From the largest gain down, dB; `None` where nothing is faint.
    pub fn candidates_of(&self) -> &[Option<f64>] {
        &self.candidates_of
    }

    /// Bins that sums are kept in.
    pub fn bins(&self) -> usize {
        self.candidates_of.len() + 1
    }

    /// Bin of a tile with such a share of the peak gain of field: rungs above it.
    pub fn bin(&self, share: f32) -> usize {
        let gain_db = 20.0 * f64::from(share).log10();
        self.candidates_of.iter().flatten().filter(|candidate| gain_db < **candidate).count()
    }

    /// Whether tiles of a bin are faint at a rung.
    pub fn is_faint(&self, bin: usize, candidate: usize) -> bool {
        self.candidates_of[candidate].is_some() && bin > candidate
    }
}

/// A sum for every bin.
#[derive(Clone, Debug)]
pub(super) struct Binned(pub(super) Vec<Sum>);

impl Binned {
    pub(super) fn new(candidates: &Candidates) -> Self {
        Self(vec![Sum::default(); candidates.bins()])
    }

    /// Adds those of the tiles that are faint at a rung, or those of all others, to a sum.
    pub(super) fn join_into(&self, candidates: &Candidates, candidate: usize, faint: bool, sum: &mut Sum) {
        for (_, own) in
            self.0.iter().enumerate().filter(|(bin, _)| candidates.is_faint(*bin, candidate) == faint)
        {
            sum.join(own);
        }
    }
}
