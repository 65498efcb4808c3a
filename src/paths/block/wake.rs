//! Wake tiles: those that short waves of ships may cross.
//!
//! The V of a ship's short waves is some metres wide and sails, and what a facet sees of it changes as the
//! wave vector by which the facet scatters moves across the few rad/m of the waves: in C band within three
//! pulses where the sea takes sixteen. Few tiles are near a V, and these alone have scattering epochs as
//! close as that ([`Tiers::wake`](super::Tiers)). A tile is one of them where any of its facets may have such
//! waves at the first pulse of the block or at the last, by the least wave number by which its mean surface
//! scatters ([`WaterScattering::short_waves_within`](crate::scattering::water::WaterScattering)).

use std::ops::Range;

use super::TileWork;
use crate::geometry::lanes::Paths;
use crate::paths::PathGenerator;
use crate::paths::sea::SeaPlan;

/// Square of the horizontal part of the difference of both unit directions, least of some lanes.
fn least_square(paths: &Paths, lanes: Range<usize>) -> f32 {
    let ([ux, uy, _], [vx, vy, _]) = (&paths.scattered, &paths.incident);
    lanes.fold(f32::INFINITY, |least, i| {
        let [x, y] = [ux[i] - vx[i], uy[i] - vy[i]];
        least.min(x * x + y * y)
    })
}

impl PathGenerator {
    /// Whether ships have short waves that scatter within facets.
    pub fn has_short_waves(&self) -> bool {
        self.sea.as_ref().is_some_and(|sea| sea.scattering.has_short_waves())
    }

    /// Whether the tile at hand, whose paths at both ends of the block are known, is a wake tile.
    pub(super) fn is_wake(&self, sea: &SeaPlan, work: &TileWork) -> bool {
        work.wakes && self.are_crossed(sea, work, 0..work.tile.count)
    }

    /// Whether short waves of a ship may cross some of its facets.
    pub(super) fn are_crossed(&self, sea: &SeaPlan, work: &TileWork, lanes: Range<usize>) -> bool {
        let TileWork { timings, places_m, tile, .. } = work;
        let bounds_m = places_m.each_ref().map(|row| {
            let of = row[lanes.clone()].iter();
            of.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)])
        });
        let ends = tile.pairs.iter().flat_map(|pair| [pair.nodes().first(), pair.nodes().last()]).flatten();
        let squares = ends.map(|node| least_square(&node.paths, lanes.clone()));
        let least = f64::from(squares.fold(f32::INFINITY, f32::min)).sqrt();
        let least_radpm = sea.scattering.wavenumber_radpm() * least;
        let epochs = &timings.mainlobe.epochs[..timings.mainlobe.instants.epoch_count];
        [epochs.first(), epochs.last()]
            .into_iter()
            .flatten()
            .any(|epoch| sea.scattering.short_waves_within(bounds_m, &epoch.poses, least_radpm))
    }
}
