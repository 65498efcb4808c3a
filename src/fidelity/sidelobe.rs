//! Two-way gains below which tiles may be sidelobe tiles, and sums of a sample by gain.
//!
//! Far off the beams a tile returns so little that few instants do for it
//! ([`Tier::Sidelobe`](crate::paths::block::Tier)): of the power of a line source of width `a`, whose two-way
//! pattern is `sinc^4`, `3.9e-3 / x^3` lies beyond `x = a sin(theta) / lambda`. What is left there is probed
//! at both tiers, in **bins** of gain between the candidates, which fall from candidate 0 on: a
//! tile of bin `b` has `b` candidates above it, and is a sidelobe tile at candidate `r` where `r < b`.
//!
//! ```
//! use nereus::fidelity::sidelobe::Candidates;
//! let candidates = Candidates::new(None);
//! // A tenth of the field, at most, twice: -40 dB.
//! let bin = candidates.bin(0.0099);
//! let candidate = candidates.thresholds_db().iter().position(|candidate| *candidate == Some(-40.0)).unwrap();
//! assert!(candidates.is_sidelobe(bin, candidate) && !candidates.is_sidelobe(bin, candidate + 1));
//! assert!(!candidates.is_sidelobe(candidates.bin(0.0), candidates.thresholds_db().len() - 1), "at the last candidate none is");
//! ```

use super::worst::Sum;

/// At or below this gain no tile is a sidelobe tile, dB.
pub const NONE_DB: f64 = -400.0;

/// Candidates, dB below the peak of both antennas' gains.
const SIDELOBE_DB: [f64; 7] = [-25.0, -30.0, -35.0, -40.0, -45.0, -50.0, -55.0];

/// Gains below which tiles may be sidelobe tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// Falling; the last one, `None`, makes no sidelobe tiles.
    thresholds_db: Vec<Option<f64>>,
}

impl Candidates {
    /// All candidates, or the one that was asked.
    pub fn new(asked_db: Option<f64>) -> Self {
        let thresholds_db = match asked_db {
            Some(none) if none <= NONE_DB => vec![None],
            Some(asked) => vec![Some(asked)],
            None => SIDELOBE_DB.into_iter().map(Some).chain([None]).collect(),
        };
        Self { thresholds_db }
    }

    /// From the largest gain down, dB; `None` where there are no sidelobe tiles.
    pub fn thresholds_db(&self) -> &[Option<f64>] {
        &self.thresholds_db
    }

    /// Bins that sums are kept in.
    pub fn bins(&self) -> usize {
        self.thresholds_db.len() + 1
    }

    /// The bin of wake tiles, which are no sidelobe tiles, after all others.
    pub fn wake_bin(&self) -> usize {
        self.bins()
    }

    /// Bin of a tile with such a share of the peak gain of field: candidates above it.
    pub fn bin(&self, share: f32) -> usize {
        let gain_db = 20.0 * f64::from(share).log10();
        self.thresholds_db.iter().flatten().filter(|candidate| gain_db < **candidate).count()
    }

    /// Whether tiles of a bin are sidelobe tiles at a candidate.
    pub fn is_sidelobe(&self, bin: usize, candidate: usize) -> bool {
        self.thresholds_db[candidate].is_some() && bin > candidate
    }
}

/// A sum for every bin, that of wake tiles last.
#[derive(Clone, Debug)]
pub(super) struct Binned(pub(super) Vec<Sum>);

impl Binned {
    pub(super) fn new(candidates: &Candidates) -> Self {
        Self(vec![Sum::default(); candidates.bins() + 1])
    }

    /// How many numbers it holds.
    pub(super) fn numbers(&self) -> usize {
        self.0.iter().map(Sum::numbers).sum()
    }

    /// Adds those of the sidelobe tiles at a candidate, or those of all others, to a sum.
    pub(super) fn join_into(&self, candidates: &Candidates, candidate: usize, sidelobe: bool, sum: &mut Sum) {
        let of_gains = self.0.iter().enumerate().take(candidates.bins());
        for (_, own) in of_gains.filter(|(bin, _)| candidates.is_sidelobe(*bin, candidate) == sidelobe) {
            sum.join(own);
        }
    }

    /// Adds that of wake tiles to a sum.
    pub(super) fn join_wake_into(&self, sum: &mut Sum) {
        self.0.last().into_iter().for_each(|own| sum.join(own));
    }
}
