//! From fixes to the nodes of a smooth track.
//!
//! [`Smoothing::Off`] takes the fixes as exact; velocity and acceleration at a node are those of the
//! polynomial through its seven nearest fixes ([`crate::scene::hermite`]).
//!
//! [`Smoothing::Rts`] runs the smoother of [`crate::motion::smoother`] on East, North and up of the middle
//! fix, without the outliers ([`crate::motion::outliers`]; a wrong height does not cost the position, nor the
//! other way round). The jerk densities, one horizontal and one vertical, are the most likely ones for the
//! stated standard deviations. Where the path would then exceed the acceleration bound, they are lowered to
//! the largest values (to 2 %) that keep it below: the vertical one until the vertical alone keeps half the
//! bound, then the horizontal one until the whole does. The bound holds between the nodes as well: the
//! acceleration of a segment stays inside the hull of its Bernstein control values, and those are what is
//! compared. The [`FitReport`] states which of the two decided, and the residuals, which show the cost; a
//! track that misses its fixes by more than [`MAX_MISFIT_SIGMAS`] standard deviations (rms) is refused, since
//! a bound below what was really flown cuts corners.

use super::fault::MAX_MISFIT_SIGMAS;
use std::fmt;

use glam::DVec3;
use serde::Serialize;

use crate::frames::SceneFrame;
use crate::motion::gate::Refusals;
use crate::motion::outliers;
use crate::motion::place::{position, to_local_axes};
use crate::motion::smoother::{Series, likeliest_density, smooth};
use crate::motion::track::TrackError;
use crate::nav::{FileSource, Fix, Smoothing};
use crate::scene::hermite::{acceleration_controls, derivative_weights, stencil};
use crate::time::TimeTag;

/// Rounds of outlier rejection at most.
const ROUNDS: usize = 4;
/// Decades of the jerk density that are tried to meet the acceleration bound.
const DECADES: f64 = 20.0;
/// Share of the acceleration bound that the vertical may have for itself.
const VERTICAL_SHARE: f64 = 0.5;

/// How well a smooth track fits its fixes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FitReport {
    /// Fixes given.
    pub fixes: usize,
    /// Fixes whose horizontal position was rejected.
    pub rejected_horizontal: usize,
    /// Fixes whose height was rejected.
    pub rejected_vertical: usize,
    /// Root mean square of the horizontal residuals (vector length) of the fixes used, m.
    pub horizontal_rms_m: f64,
    /// The largest of them, m.
    pub horizontal_max_m: f64,
    /// Root mean square of the vertical residuals of the fixes used, m.
    pub vertical_rms_m: f64,
    /// The largest of them, m.
    pub vertical_max_m: f64,
    /// Upper bound on the acceleration of the track, at and between nodes, m/s^2.
    pub max_acceleration_mps2: f64,
    /// The bound that was asked for, m/s^2; `None` without smoothing.
    pub allowed_acceleration_mps2: Option<f64>,
    /// Whether that bound, and not the likelihood, decided.
    pub bound_active: bool,
    /// Whether the fixes have no attitude and it is derived from the motion, though nobody asked for that.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub attitude_derived: bool,
    /// Horizontal jerk density, m^2/s^5; `None` without smoothing.
    pub horizontal_jerk_density: Option<f64>,
    /// Vertical jerk density, m^2/s^5; `None` without smoothing.
    pub vertical_jerk_density: Option<f64>,
    /// Slowest and fastest speed at a node, m/s.
    pub speed_mps: [f64; 2],
    /// Fixes that the plausibility gate refused, before the others were taken as exact.
    pub refused: Refusals,
    /// Acceleration that the platform can have, m/s^2; `None` with smoothing, which has its own bound.
    pub possible_acceleration_mps2: Option<f64>,
}

impl fmt::Display for FitReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} fixes", self.fixes)?;
        if let (Some(allowed), Some(horizontal), Some(vertical)) =
            (self.allowed_acceleration_mps2, self.horizontal_jerk_density, self.vertical_jerk_density)
        {
            write!(
                f,
                " smoothed ({} positions and {} heights rejected): residual {:.2} m rms, {:.2} m max horizontal; \
                 {:.2} m rms, {:.2} m max vertical; acceleration up to {:.3} of {allowed} m/s^2 ({}); \
                 jerk density {horizontal:.2e} horizontal, {vertical:.2e} vertical m^2/s^5",
                self.rejected_horizontal,
                self.rejected_vertical,
                self.horizontal_rms_m,
                self.horizontal_max_m,
                self.vertical_rms_m,
                self.vertical_max_m,
                self.max_acceleration_mps2,
                if self.bound_active {
                    "process noise limited by that bound"
                } else {
                    "process noise by maximum likelihood"
                },
            )?;
        } else {
            write!(f, " taken as exact: acceleration up to {:.3} m/s^2", self.max_acceleration_mps2)?;
        }
        write!(f, "; speed {:.1} to {:.1} m/s", self.speed_mps[0], self.speed_mps[1])?;
        let Refusals { implausible, jumps } = self.refused;
        if implausible > 0 {
            write!(
                f,
                "; {implausible} implausible fixes refused (track.vehicle, max_speed_mps, max_acceleration_mps2)"
            )?;
        }
        if jumps > 0 {
            write!(f, "; {jumps} jumps to where the platform cannot have got")?;
        }
        if let Some(possible) =
            self.possible_acceleration_mps2.filter(|most| self.max_acceleration_mps2 > *most)
        {
            write!(f, "; more than the {possible} m/s^2 of the vehicle: noisy fixes want track.smoothing")?;
        }
        if self.attitude_derived {
            f.write_str("; no attitude among the fixes: derived from the motion (coordinated turn)")?;
        }
        Ok(())
    }
}

/// Position, velocity and acceleration at a fix, along ENU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    pub time: TimeTag,
    pub p: DVec3,
    pub v: DVec3,
    pub a: DVec3,
}

/// The nodes of the track through these fixes.
pub(crate) fn nodes(
    fixes: &[Fix],
    frame: &SceneFrame,
    source: &FileSource,
) -> Result<(Vec<Node>, FitReport), TrackError> {
    let needed = match source.smoothing {
        Smoothing::Off => 2,
        Smoothing::Rts { .. } => 4,
    };
    if fixes.len() < needed {
        let path = source.path.clone();
        return Err(TrackError::TooFewFixes { path, found: fixes.len(), needed });
    }
    let mut positions = Vec::with_capacity(fixes.len());
    for (index, fix) in fixes.iter().enumerate() {
        let position =
            position(fix, frame).ok_or_else(|| TrackError::NoOrigin { path: source.path.clone() })?;
        let in_order = index == 0 || fix.time.since(fixes[index - 1].time) > 0.0;
        if !(in_order && position.is_finite()) {
            return Err(TrackError::BadFix { path: source.path.clone(), index, time: fix.time });
        }
        positions.push(position);
    }
    let (mut nodes, mut report) = match source.smoothing {
        Smoothing::Off => (exact(fixes, &positions), FitReport::default()),
        Smoothing::Rts { horizontal_sigma_m, vertical_sigma_m, max_acceleration_mps2 } => {
            let wanted = Wanted { horizontal_sigma_m, vertical_sigma_m, max_acceleration_mps2 };
            let middle = fixes.len() / 2;
            let axes = to_local_axes(&fixes[middle].place, frame);
            let local: Vec<DVec3> = positions.iter().map(|p| axes * (*p - positions[middle])).collect();
            let (mut nodes, report) = smoothed(fixes, &local, wanted, source)?;
            for node in &mut nodes {
                node.p = positions[middle] + axes.transpose() * node.p;
                node.v = axes.transpose() * node.v;
                node.a = axes.transpose() * node.a;
            }
            (nodes, report)
        }
    };
    nodes.shrink_to_fit();
    report.fixes = fixes.len();
    if !nodes.iter().all(|node| node.v.is_finite() && node.a.is_finite()) {
        // Fixes nanoseconds apart and far from each other.
        return Err(TrackError::BadFix { path: source.path.clone(), index: 0, time: fixes[0].time });
    }
    report.max_acceleration_mps2 = max_acceleration(&nodes);
    report.speed_mps = nodes
        .iter()
        .map(|node| node.v.length())
        .fold([f64::INFINITY, 0.0], |[low, high], v| [low.min(v), high.max(v)]);
    Ok((nodes, report))
}

fn exact(fixes: &[Fix], positions: &[DVec3]) -> Vec<Node> {
    let near = |i: usize| (fixes[i].time, positions[i]);
    (0..fixes.len()).map(|i| exact_node(i, stencil(i, fixes.len()), near)).collect()
}

/// The node of a fix that is taken as exact, from the fixes of its stencil.
pub(crate) fn exact_node(
    index: usize,
    stencil: std::ops::Range<usize>,
    fix: impl Fn(usize) -> (TimeTag, DVec3),
) -> Node {
    let (time, p) = fix(index);
    let mut t_s = [0.0; crate::scene::hermite::STENCIL];
    for (t_s, near) in t_s.iter_mut().zip(stencil.clone()) {
        *t_s = fix(near).0.since(time);
    }
    let [w1, w2] = derivative_weights(&t_s[..stencil.len()]);
    // Differences from the node itself: the weights sum to zero, large coordinates do not.
    let sum = |w: &[f64]| {
        w.iter().zip(stencil.clone()).fold(DVec3::ZERO, |s, (w, near)| s + (fix(near).1 - p) * *w)
    };
    Node { time, p, v: sum(&w1), a: sum(&w2) }
}

/// Settings of the smoother.
#[derive(Clone, Copy)]
struct Wanted {
    horizontal_sigma_m: f64,
    vertical_sigma_m: f64,
    max_acceleration_mps2: f64,
}

fn smoothed(
    fixes: &[Fix],
    local: &[DVec3],
    wanted: Wanted,
    source: &FileSource,
) -> Result<(Vec<Node>, FitReport), TrackError> {
    for (name, value) in [
        ("horizontal_sigma_m", wanted.horizontal_sigma_m),
        ("vertical_sigma_m", wanted.vertical_sigma_m),
        ("max_acceleration_mps2", wanted.max_acceleration_mps2),
    ] {
        if !(1e-4..=1e4).contains(&value) {
            return Err(TrackError::SmoothingSetting { path: source.path.clone(), name, value });
        }
    }
    let t_s: Vec<f64> = fixes.iter().map(|fix| fix.time.since(fixes[0].time)).collect();
    let step_s: Vec<f64> = fixes.windows(2).map(|w| w[1].time.since(w[0].time)).collect();
    let z_m: [Vec<f64>; 3] = std::array::from_fn(|k| local.iter().map(|p| p[k]).collect());
    let distance: [Vec<f64>; 3] = std::array::from_fn(|k| outliers::deviations(&t_s, &z_m[k]));
    let across: Vec<f64> = distance[0].iter().zip(&distance[1]).map(|(x, y)| x.hypot(*y)).collect();
    let heights: Vec<f64> = distance[2].iter().map(|z| z.abs()).collect();
    let mut used = [
        outliers::gate(&across, wanted.horizontal_sigma_m),
        outliers::gate(&heights, wanted.vertical_sigma_m),
    ];

    let mut round = 0;
    loop {
        check_support(&t_s, &used, fixes, source)?;
        let fit = bounded(fixes, &step_s, &z_m, &used, wanted, source)?;
        let across: Vec<f64> =
            fit.nodes.iter().zip(local).map(|(node, p)| (*p - node.p).truncate().length()).collect();
        let heights: Vec<f64> = fit.nodes.iter().zip(local).map(|(node, p)| (p.z - node.p.z).abs()).collect();
        let again = [
            outliers::regate(&across, &used[0], wanted.horizontal_sigma_m),
            outliers::regate(&heights, &used[1], wanted.vertical_sigma_m),
        ];
        round += 1;
        if again != used && round < ROUNDS {
            used = again;
            continue;
        }
        let (horizontal_rms_m, horizontal_max_m) = rms_and_max(&across, &used[0]);
        let (vertical_rms_m, vertical_max_m) = rms_and_max(&heights, &used[1]);
        for (axis, rms_m, sigma_m) in [
            ("horizontal", horizontal_rms_m, wanted.horizontal_sigma_m),
            ("vertical", vertical_rms_m, wanted.vertical_sigma_m),
        ] {
            if rms_m > MAX_MISFIT_SIGMAS * sigma_m {
                let (path, allowed_mps2) = (source.path.clone(), wanted.max_acceleration_mps2);
                return Err(TrackError::Misfit { path, axis, rms_m, sigma_m, allowed_mps2 });
            }
        }
        let rejected = |used: &[bool]| used.iter().filter(|used| !**used).count();
        let report = FitReport {
            rejected_horizontal: rejected(&used[0]),
            rejected_vertical: rejected(&used[1]),
            horizontal_rms_m,
            horizontal_max_m,
            vertical_rms_m,
            vertical_max_m,
            allowed_acceleration_mps2: Some(wanted.max_acceleration_mps2),
            bound_active: fit.bound_active,
            horizontal_jerk_density: Some(fit.density[0]),
            vertical_jerk_density: Some(fit.density[1]),
            ..FitReport::default()
        };
        let mut nodes = fit.nodes;
        // Beyond the last position used there is nothing to hold the path.
        let first = used[0].iter().position(|used| *used).unwrap_or(0);
        let last = used[0].iter().rposition(|used| *used).unwrap_or(nodes.len() - 1);
        nodes.truncate(last + 1);
        nodes.drain(..first);
        return Ok((nodes, report));
    }
}

/// Refuses when too few fixes are left, or when rejecting some has opened a gap.
fn check_support(
    t_s: &[f64],
    used: &[Vec<bool>; 2],
    fixes: &[Fix],
    source: &FileSource,
) -> Result<(), TrackError> {
    let path = || source.path.clone();
    for used in used {
        let kept: Vec<usize> = (0..used.len()).filter(|&i| used[i]).collect();
        if kept.len() < 4 {
            return Err(TrackError::TooFewFixes { path: path(), found: kept.len(), needed: 4 });
        }
        for pair in kept.windows(2).filter(|pair| pair[1] > pair[0] + 1) {
            let gap_s = t_s[pair[1]] - t_s[pair[0]];
            if gap_s > source.max_gap_s {
                let (time, allowed_s) = (fixes[pair[1]].time, source.max_gap_s);
                return Err(TrackError::RejectedGap { path: path(), gap_s, time, allowed_s });
            }
        }
    }
    Ok(())
}

struct Fit {
    nodes: Vec<Node>,
    density: [f64; 2],
    bound_active: bool,
}

/// The likeliest track whose acceleration stays below the bound.
fn bounded(
    fixes: &[Fix],
    step_s: &[f64],
    z_m: &[Vec<f64>; 3],
    used: &[Vec<bool>; 2],
    wanted: Wanted,
    source: &FileSource,
) -> Result<Fit, TrackError> {
    let series: [Series; 3] = std::array::from_fn(|k| Series {
        step_s,
        z_m: &z_m[k],
        used: &used[k / 2],
        sigma_m: if k < 2 { wanted.horizontal_sigma_m } else { wanted.vertical_sigma_m },
    });
    let likeliest = [likeliest_density(&series[..2]), likeliest_density(&series[2..])];
    let attempt = |density: [f64; 2]| {
        let [x, y, z] = std::array::from_fn(|k| smooth(&series[k], density[k / 2]));
        let nodes: Vec<Node> = (0..fixes.len())
            .map(|i| {
                let at = |k: usize| DVec3::new(x[i][k], y[i][k], z[i][k]);
                Node { time: fixes[i].time, p: at(0), v: at(1), a: at(2) }
            })
            .collect();
        nodes
    };
    let bound = wanted.max_acceleration_mps2;
    // Heights first, so that a steep turn does not cost them; then the sum of both.
    let vertical = |density: f64| {
        let mut nodes = attempt([likeliest[0], density]);
        for node in &mut nodes {
            (node.v, node.a) = (node.v * DVec3::Z, node.a * DVec3::Z);
            node.p = DVec3::new(0.0, 0.0, node.p.z);
        }
        max_acceleration(&nodes)
    };
    let refused = |reached: f64| TrackError::AccelerationBound {
        path: source.path.clone(),
        reached,
        allowed_mps2: bound,
    };
    let vertical_density = loosest(likeliest[1], VERTICAL_SHARE * bound, vertical).map_err(refused)?;
    let both = |density: f64| max_acceleration(&attempt([density, vertical_density]));
    let horizontal_density = loosest(likeliest[0], bound, both).map_err(refused)?;
    let density = [horizontal_density, vertical_density];
    Ok(Fit { nodes: attempt(density), density, bound_active: density != likeliest })
}

/// The largest density up to `likeliest` (to 2 %) whose track stays below a bound, or what the stiffest
/// reaches.
fn loosest(likeliest: f64, bound: f64, reached: impl Fn(f64) -> f64) -> Result<f64, f64> {
    if reached(likeliest) <= bound {
        return Ok(likeliest);
    }
    let at = |log10_scale: f64| likeliest * 10f64.powf(log10_scale);
    let (mut stiff, mut loose) = (-0.5, 0.0);
    loop {
        let here = reached(at(stiff));
        if here <= bound {
            break;
        }
        if stiff <= -DECADES {
            return Err(here);
        }
        loose = stiff;
        stiff -= 0.5;
    }
    // Half a decade in six halvings: 2 % of the density.
    for _ in 0..6 {
        let middle = 0.5 * (stiff + loose);
        if reached(at(middle)) <= bound { stiff = middle } else { loose = middle }
    }
    Ok(at(stiff))
}

fn rms_and_max(residual_m: &[f64], used: &[bool]) -> (f64, f64) {
    let (mut sum, mut count, mut max) = (0.0, 0usize, 0.0f64);
    for (residual, _) in residual_m.iter().zip(used).filter(|(_, used)| **used) {
        sum += residual * residual;
        count += 1;
        max = max.max(*residual);
    }
    ((sum / count.max(1) as f64).sqrt(), max)
}

/// An upper bound on the acceleration of the interpolated track, tight to a few percent.
fn max_acceleration(nodes: &[Node]) -> f64 {
    nodes.windows(2).map(|pair| segment_acceleration(&pair[0], &pair[1])).fold(0.0, f64::max)
}

fn segment_acceleration(from: &Node, to: &Node) -> f64 {
    let h = to.time.since(from.time);
    let (rise, mut controls) = (to.p - from.p, [DVec3::ZERO; 4]);
    for axis in 0..3 {
        let c = acceleration_controls(rise[axis], [from.v[axis], to.v[axis]], [from.a[axis], to.a[axis]], h);
        for (control, c) in controls.iter_mut().zip(c) {
            control[axis] = c;
        }
    }
    // Two rounds of de Casteljau at the middle: a quarter of the segment has a hull a sixteenth as slack.
    let (a, b) = halves(controls);
    let quarters = [halves(a), halves(b)];
    quarters.iter().flat_map(|(a, b)| a.iter().chain(b)).map(|control| control.length()).fold(0.0, f64::max)
}

fn halves([c0, c1, c2, c3]: [DVec3; 4]) -> ([DVec3; 4], [DVec3; 4]) {
    let (m0, m1, m2) = ((c0 + c1) * 0.5, (c1 + c2) * 0.5, (c2 + c3) * 0.5);
    let (n0, n1) = ((m0 + m1) * 0.5, (m1 + m2) * 0.5);
    let middle = (n0 + n1) * 0.5;
    ([c0, m0, n0, middle], [middle, n1, m2, c3])
}
