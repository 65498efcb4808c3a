//! Weights of the shadows of a block, update by update.

use std::ops::RangeInclusive;
use std::sync::Arc;

use super::instants::Instants;
use super::runs::Run;
use super::timing::GainInstant;
use super::{NodeWork, TileWork};
use crate::cpu::{Task, Variant};
use crate::frames::{Enu, Point};
use crate::geometry::shadow::Shadow;
use crate::paths::PathGenerator;
use crate::paths::sea::{SeaFailure, SeaPlan};
use crate::paths::visibility::{Area, Borders, MOST_ENDS, ShareBorders, Update, Updates, Visibility};
use crate::radar::fault::SeaFault;
use crate::scene::Patch;
use crate::sea::surface::Fields;
use crate::sea::surface::fields::Real;

/// Facets of a patch up to which its shadows may be those of the reference: on larger ones the heights
/// between nodes always do, in f32.
const FEW_FACETS: usize = 1 << 14;

/// Weights of one update of the shadows over the patch.
#[derive(Clone, Default)]
pub(super) struct ShadowWeights {
    /// `[antenna]`; empty where all is illuminated.
    pub weights: Vec<Vec<f32>>,
    /// `[antenna]`: outside of it they are one; `None` where nothing is known of them.
    pub dimmed: Vec<Option<Area>>,
}

/// What makes updates of the shadows.
#[derive(Clone)]
pub(super) enum Maker {
    /// Of few facets: those of the reference, since single ones count.
    Few(Box<Updates<f64>>),
    /// Of a patch that stays, whose heights are known from the nodes, or found anew where these lie too far
    /// away.
    Here { shadow: Box<Shadow<f64>>, update: Box<Update>, heights_m: Vec<f64> },
    /// Of one that moves; heights in f32, as those of the nodes.
    Along(Box<Updates<f32>>, Option<Arc<dyn ShareBorders>>),
}

impl Maker {
    /// What a sea needs: none without shadows. `None` where it cannot be made. `exact`: where single facets
    /// count for the error that is asked; at sharp edges they always do.
    pub fn of(sea: &SeaPlan, borders: Option<Arc<dyn ShareBorders>>, exact: bool) -> Option<Option<Self>> {
        let of_reference = |visibility: &Visibility| {
            sea.patch.len() <= FEW_FACETS && (exact || visibility.settings.width_rad == 0.0)
        };
        Some(match &sea.visibility {
            None => None,
            Some(visibility) if of_reference(visibility) => {
                let updates = visibility.updates::<f64, SeaFault>(&sea.surface, &sea.wakes, &sea.patch);
                Some(Maker::Few(Box::new(updates.ok()?)))
            }
            // Choppy waves have other heights here than those that hide.
            Some(visibility) if visibility.margin == 0 && sea.choppy.is_none() => Some(Maker::Here {
                shadow: Box::new(visibility.shadow(&sea.patch).ok()?),
                update: Box::new(visibility.empty(&sea.patch)),
                heights_m: vec![0.0; sea.patch.len()],
            }),
            Some(visibility) => {
                let updates = visibility.updates::<f32, SeaFault>(&sea.surface, &sea.wakes, &sea.patch);
                if let Some(borders) = &borders {
                    borders.with(&mut Borders::join);
                }
                Some(Maker::Along(Box::new(updates.ok()?), borders))
            }
        })
    }
}

impl ShadowWeights {
    fn take_from<T: Real>(&mut self, update: &Update<T>, patch: &Patch) {
        for (antenna, (weights, dimmed)) in self.weights.iter_mut().zip(&mut self.dimmed).enumerate() {
            if update.sees_all(antenna) {
                weights.clear();
                *dimmed = None;
            } else {
                update.copy_over(antenna, patch, (weights, dimmed));
            }
        }
    }

    /// Whether facets of some runs may be hidden from an antenna.
    pub fn dims(&self, antenna: usize, runs: &[Run], width: usize) -> bool {
        let touches = |area: &Area| runs.iter().any(|run| area.touches(run.first, run.count, width));
        !self.weights[antenna].is_empty() && self.dimmed[antenna].as_ref().is_none_or(touches)
    }
}

/// Visibility of facets from an antenna at an instant: 1 where nothing is hidden.
#[derive(Clone, Copy, Default)]
pub(in crate::paths) struct Seen<'a> {
    before: &'a [f32],
    next: &'a [f32],
    share: f64,
}

impl Seen<'_> {
    /// Whether nothing is hidden.
    pub fn is_whole(&self) -> bool {
        self.before.is_empty() && self.next.is_empty()
    }

    /// Of a facet of the patch.
    pub fn of(&self, facet: usize) -> f64 {
        let at = |weights: &[f32]| weights.get(facet).map_or(1.0, |weight| f64::from(*weight));
        let from = at(self.before);
        from + self.share * (at(self.next) - from)
    }
}

impl TileWork {
    /// Visibility of the facets of the patch at hand from an antenna, at a pulse of the block.
    pub(in crate::paths) fn seen_from(&self, antenna: usize, pulse: usize) -> Seen<'_> {
        let Some(&(before, share)) = self.shares.get(pulse) else { return Seen::default() };
        let of = |update: usize| -> &[f32] {
            let weights = self.shadow_updates.get(update).and_then(|update| update.weights.get(antenna));
            weights.map_or(&[], |weights| weights)
        };
        // Where the next update adds nothing it may not be there.
        let next = (before + 1).min(self.shadow_updates.len().saturating_sub(1));
        Seen {
            before: of(before),
            next: if share == 0.0 { of(before) } else { of(next) },
            share: f64::from(share),
        }
    }

    /// Weights of the shadows at every update about the block.
    pub(super) fn weigh_shadows(
        &mut self,
        of: &PathGenerator,
        sea: &SeaPlan,
        instants: &Instants,
        patch: &Patch,
        heights: Heights,
    ) -> Result<(), SeaFailure> {
        self.shares.clear();
        let (Some(visibility), true) = (&sea.visibility, self.maker.is_some()) else {
            self.shadow_updates.clear();
            self.shares.resize(instants.pulses, (0, 0.0));
            return Ok(());
        };
        let emissions = &of.radar.emissions;
        let at = |pulse: usize| visibility.share(emissions.elapsed_s(instants.first + pulse as u64));
        let span = span_of(at(0), at(instants.pulses - 1));
        let lasts_s = emissions.interval_s(instants.first, instants.first + instants.pulses as u64 - 1);
        let updates = (span.end() - span.start() + 1) as usize;
        self.room_for_updates(updates, visibility.most_updates(lasts_s), visibility.ends, patch);
        let mut shadow_updates = std::mem::take(&mut self.shadow_updates);
        let weighed =
            self.weigh_updates(of, sea, (instants.first, span.clone()), patch, heights, &mut shadow_updates);
        self.shadow_updates = shadow_updates;
        weighed?;
        for pulse in 0..instants.pulses {
            let (number, share) = at(pulse);
            self.shares.push(((number - span.start()) as usize, share as f32));
        }
        Ok(())
    }

    /// Makes room for so many updates. Another block as long may have more, up to `most`: room for them is
    /// made with the first one.
    fn room_for_updates(&mut self, updates: usize, most: usize, ends: usize, patch: &Patch) {
        // Those not in use keep their room for the next block.
        while self.shadow_updates.len() > updates {
            self.spare.extend(self.shadow_updates.pop());
        }
        let most = most.max(updates);
        self.shadow_updates.reserve(most.saturating_sub(self.shadow_updates.len()));
        self.spare.reserve(most.saturating_sub(self.spare.len()));
        self.seen.reserve((most * ends).saturating_sub(self.seen.len()));
        self.dims.reserve((most * ends).saturating_sub(self.dims.len()));
        while self.shadow_updates.len() + self.spare.len() < most {
            let room = || Vec::with_capacity(patch.len());
            let weights = std::iter::repeat_with(room).take(ends).collect();
            self.spare.push(ShadowWeights { weights, dimmed: vec![None; ends] });
        }
        while self.shadow_updates.len() < updates {
            self.shadow_updates.push(self.spare.pop().unwrap_or_default());
        }
    }

    /// Weights of the updates of a span, of a block with the given first pulse.
    fn weigh_updates(
        &mut self,
        of: &PathGenerator,
        sea: &SeaPlan,
        (first, span): (u64, RangeInclusive<u64>),
        patch: &Patch,
        heights: Heights,
        shadow_updates: &mut [ShadowWeights],
    ) -> Result<(), SeaFailure> {
        let (Some(visibility), Some(maker)) = (&sea.visibility, &mut self.maker) else { return Ok(()) };
        let earth = of.frame.earth();
        // Of the first pulse, which is a node and a gain instant.
        let Some(GainInstant { emission, .. }) = self.timings.mainlobe.gains.first() else { return Ok(()) };
        let reception = of.reception(first, first, emission, &[]);
        let scenery = |elapsed_s: f64, places: &mut [Point<Enu>]| sea.scenery(&reception, elapsed_s, places);
        for (update_weights, number) in shadow_updates.iter_mut().zip(span.clone()) {
            update_weights.weights.resize_with(visibility.ends, Vec::new);
            update_weights.dimmed.resize(visibility.ends, None);
            match maker {
                Maker::Few(updates) => {
                    update_weights.take_from(visibility.update(updates, number, scenery, earth)?, patch);
                }
                Maker::Here { shadow, update, heights_m } => {
                    let time_s = visibility.time_s(number);
                    let mut places = [Point::new(0.0, 0.0, 0.0); MOST_ENDS];
                    let places = &mut places[..visibility.ends];
                    scenery(time_s, places)?;
                    if is_near(&self.nodes, time_s) {
                        heights_at(self.variant, &self.nodes, time_s, heights_m);
                    } else if heights == Heights::Near {
                        heights_at(self.variant, &self.nodes[..1], time_s, heights_m);
                    } else {
                        // Few blocks need it: the room of a node does, which is made ready again.
                        let NodeWork { elapsed_s, fields, .. } = &mut self.nodes[0];
                        self.facet_surface.evaluate(time_s, patch, fields)?;
                        let from = fields.height_m.iter().copied().map(f64::from);
                        heights_m.iter_mut().zip(from).for_each(|(to, from)| *to = from);
                        self.facet_surface.evaluate(*elapsed_s, patch, fields)?;
                    }
                    visibility.weigh_heights::<SeaFailure>(
                        shadow,
                        (time_s, patch),
                        heights_m,
                        places,
                        earth,
                        update,
                    )?;
                    update_weights.take_from(update, patch);
                }
                Maker::Along(updates, borders) => {
                    let at_border =
                        number < span.start() + Borders::COMMON || number + Borders::COMMON > *span.end();
                    let borders = borders.as_deref().filter(|_| at_border);
                    let mut found = false;
                    if let Some(borders) = borders {
                        borders.with(&mut |kept| {
                            found =
                                kept.find(number).map(|own| update_weights.take_from(own, patch)).is_some();
                        });
                    }
                    if found {
                        continue;
                    }
                    let update = visibility.update(updates, number, scenery, earth)?;
                    update_weights.take_from(update, patch);
                    if let Some(borders) = borders {
                        borders.with(&mut |kept| kept.keep(update));
                    }
                }
            }
        }
        Ok(())
    }
}

/// How heights are found that lie beyond the nodes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Heights {
    /// As at the nodes.
    Exact,
    /// On straight lines from the first node: for an estimate.
    Near,
}

/// Whether heights at a time follow from the nodes: from one interval before the first to one after the last.
fn is_near(nodes: &[NodeWork], time_s: f64) -> bool {
    let times_s = |n: usize| nodes[n.min(nodes.len() - 1)].elapsed_s;
    let last = nodes.len().saturating_sub(1);
    let [first_s, last_s] = [times_s(0), times_s(last)];
    let (before_s, after_s) = (times_s(1) - first_s, last_s - times_s(last.saturating_sub(1)));
    (first_s - before_s..=last_s + after_s).contains(&time_s)
}

/// Heights at a time by the Hermite cubic of the two nodes about it, or nearest to it, m. One interval beyond
/// the last node the waves of the shortest periods lose some 1e-6 m.
fn heights_at(variant: Variant, nodes: &[NodeWork], time_s: f64, out: &mut [f64]) {
    let after = nodes.iter().position(|node| node.elapsed_s >= time_s).unwrap_or(nodes.len() - 1);
    let (first, second) = (&nodes[after.max(1) - 1], &nodes[after.max(1).min(nodes.len() - 1)]);
    let span_s = second.elapsed_s - first.elapsed_s;
    let from = time_s - first.elapsed_s;
    let s = if span_s > 0.0 { from / span_s } else { 0.0 };
    // Weights of both heights and both speeds; one node alone: a straight line.
    let (heights, speeds) = if span_s > 0.0 {
        let (s2, s3) = (s * s, s * s * s);
        ([1.0 - 3.0 * s2 + 2.0 * s3, 3.0 * s2 - 2.0 * s3], [(s - 2.0 * s2 + s3) * span_s, (s3 - s2) * span_s])
    } else {
        ([1.0, 0.0], [from, 0.0])
    };
    variant.run(Cubic { fields: [&first.fields, &second.fields], heights, speeds, out });
}

/// A sum of the heights and vertical speeds of two nodes.
struct Cubic<'a> {
    fields: [&'a Fields<f32>; 2],
    heights: [f64; 2],
    speeds: [f64; 2],
    out: &'a mut [f64],
}

impl Task for Cubic<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { fields: [a, b], heights: w, speeds: v, out } = self;
        let count = out.len();
        let [z0, z1] = [&a.height_m[..count], &b.height_m[..count]];
        let [v0, v1] = [&a.velocity_mps[2][..count], &b.velocity_mps[2][..count]];
        for (i, out) in out.iter_mut().enumerate() {
            let of_heights = w[0] * f64::from(z0[i]) + w[1] * f64::from(z1[i]);
            *out = of_heights + v[0] * f64::from(v0[i]) + v[1] * f64::from(v1[i]);
        }
    }
}

fn span_of((first, _): (u64, f64), (last, share): (u64, f64)) -> RangeInclusive<u64> {
    first..=if share > 0.0 { last + 1 } else { last }
}
