//! Waypoints in time, as places of a scenario.

use std::fmt::Write as _;

/// When imported scenarios begin, 2000-01-01T00:00:00Z, ns since 1970.
const START_UNIX_NS: i64 = 946_684_800 * SECOND_NS;
const SECOND_NS: i64 = 1_000_000_000;

/// A place at a time: s, then East, North and up, m.
pub(super) type Waypoint = [f64; 4];

/// Times from waypoint to waypoint at which a path that bends is written down, at most and together.
const POINTS: usize = 2000;

/// How something moves.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Motion {
    /// It stays.
    Fixed([f64; 3]),
    /// Place at the start and velocity, m/s.
    Straight([f64; 3], [f64; 3]),
    /// Places in time, and the longest time between two of them, s.
    Track(Vec<Waypoint>, f64),
}

/// How places follow from waypoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    Static,
    Linear,
    Cubic,
}

impl Motion {
    /// From waypoints whose times rise, over a run from `begin_s` to `end_s`: before the first and after the
    /// last it stays. Times of what comes out count from `begin_s`.
    pub fn of(waypoints: &[Waypoint], how: Interpolation, [begin_s, end_s]: [f64; 2]) -> Self {
        let first = waypoints.first().copied().unwrap_or_default();
        let last = waypoints.last().copied().unwrap_or_default();
        let place = |waypoint: Waypoint| [waypoint[1], waypoint[2], waypoint[3]];
        if how == Interpolation::Static || waypoints.iter().all(|own| place(*own) == place(first)) {
            return Self::Fixed(place(first));
        }
        if waypoints.len() == 2 && first[0] <= begin_s && last[0] >= end_s {
            let velocity_mps = [1, 2, 3].map(|axis| (last[axis] - first[axis]) / (last[0] - first[0]));
            let ahead_s = begin_s - first[0];
            let start_m = [0, 1, 2].map(|axis| first[axis + 1] + ahead_s * velocity_mps[axis]);
            return Self::Straight(start_m, velocity_mps);
        }
        let bends =
            if how == Interpolation::Cubic { bends(waypoints) } else { vec![[0.0; 3]; waypoints.len()] };
        let step_s = ((end_s - begin_s) / POINTS as f64).max(1e-6);
        // A step more on either side: tracks must cover the run.
        let times = (0..=POINTS + 2).map(|n| begin_s + (n as f64 - 1.0) * step_s);
        let track = times.map(|time_s| {
            let [x, y, z] = at(waypoints, &bends, time_s);
            [time_s - begin_s, x, y, z]
        });
        Self::Track(track.collect(), step_s)
    }
}

/// Place at a time.
fn at(waypoints: &[Waypoint], bends: &[[f64; 3]], time_s: f64) -> [f64; 3] {
    let after = waypoints.partition_point(|own| own[0] <= time_s);
    if after == 0 || after == waypoints.len() {
        let end = waypoints[after.min(waypoints.len() - 1)];
        return [end[1], end[2], end[3]];
    }
    let (from, to) = (waypoints[after - 1], waypoints[after]);
    let step_s = to[0] - from[0];
    let b = (time_s - from[0]) / step_s;
    let a = 1.0 - b;
    let [c, d] = [a, b].map(|share| (share.powi(3) - share) * step_s * step_s / 6.0);
    [0, 1, 2].map(|axis| {
        a * from[axis + 1] + b * to[axis + 1] + c * bends[after - 1][axis] + d * bends[after][axis]
    })
}

/// Second derivatives at the waypoints of the cubic spline that has none at its ends.
fn bends(waypoints: &[Waypoint]) -> Vec<[f64; 3]> {
    let n = waypoints.len();
    let (mut ratio, mut bends) = (vec![0.0; n], vec![[0.0; 3]; n]);
    for i in 1..n - 1 {
        let [before_s, here_s, after_s] = [i - 1, i, i + 1].map(|n| waypoints[n][0]);
        let (left_s, right_s) = (here_s - before_s, after_s - here_s);
        let pivot = 2.0 * (left_s + right_s) - left_s * ratio[i - 1];
        ratio[i] = right_s / pivot;
        let (of, before) = (|n: usize, axis: usize| waypoints[n][axis + 1], bends[i - 1]);
        bends[i] = [0, 1, 2].map(|axis| {
            let [left, right] = [i - 1, i].map(|n| of(n + 1, axis) - of(n, axis));
            (6.0 * (right / right_s - left / left_s) - left_s * before[axis]) / pivot
        });
    }
    for i in (1..n - 1).rev() {
        let after = bends[i + 1];
        bends[i].iter_mut().zip(after).for_each(|(own, after)| *own -= ratio[i] * after);
    }
    bends
}

/// A track as a file: CSV, whose times count from 2000-01-01 on.
pub(super) fn csv(track: &[Waypoint]) -> String {
    let mut text = "unix_s,x_m,y_m,z_m\n".to_owned();
    for [time_s, x, y, z] in track {
        // Counted in whole nanoseconds: f64 has a tenth of a microsecond left beside so many seconds.
        let unix_ns = START_UNIX_NS + (time_s * 1e9).round() as i64;
        let (seconds, rest_ns) = (unix_ns.div_euclid(SECOND_NS), unix_ns.rem_euclid(SECOND_NS));
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{seconds}.{rest_ns:09},{x:.6},{y:.6},{z:.6}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A spline through a straight line is that line; through a parabola it has its values at the waypoints,
    /// and between them what the closed form of three waypoints says.
    #[test]
    fn paths_go_through_their_waypoints() {
        let line: Vec<Waypoint> =
            (0..4).map(|n| [f64::from(n), 2.0 * f64::from(n), 1.0, -f64::from(n)]).collect();
        assert!(bends(&line).iter().flatten().all(|bend| bend.abs() < 1e-12));
        // Waypoints 0, 1, 0 at 0, 1, 2 s: second derivative -3 in the middle, 11/16 half-way.
        let hill = [[0.0, 0.0, 0.0, 5.0], [1.0, 1.0, 0.0, 5.0], [2.0, 0.0, 0.0, 5.0]];
        let bends = bends(&hill);
        assert!((bends[1][0] + 3.0).abs() < 1e-12, "{bends:?}");
        assert!((at(&hill, &bends, 0.5)[0] - 11.0 / 16.0).abs() < 1e-12);
        assert_eq!(at(&hill, &bends, 9.0), [0.0, 0.0, 5.0]);
    }

    #[test]
    fn tracks_keep_their_nanoseconds() {
        let text = csv(&[[-1e-9, 1.0, 2.0, 3.0], [0.25, 1.5, 2.0, 3.0]]);
        assert!(
            text.contains("\n946684799.999999999,1.000000,2") && text.contains("\n946684800.250000000,1.5")
        );
    }

    #[test]
    fn two_waypoints_about_the_run_are_a_straight_course() {
        let two = [[0.0, 0.0, 0.0, 5.0], [10.0, 100.0, -50.0, 5.0]];
        let motion = Motion::of(&two, Interpolation::Linear, [2.0, 4.0]);
        assert_eq!(motion, Motion::Straight([20.0, -10.0, 5.0], [10.0, -5.0, 0.0]));
        assert_eq!(Motion::of(&two, Interpolation::Static, [2.0, 4.0]), Motion::Fixed([0.0, 0.0, 5.0]));
        // It stops within the run.
        let Motion::Track(track, step_s) = Motion::of(&two, Interpolation::Linear, [8.0, 12.0]) else {
            panic!()
        };
        assert!(track[0][0] < 0.0 && track[track.len() - 1][0] > 4.0 && (step_s - 0.002).abs() < 1e-12);
        assert_eq!(track[track.len() - 1][1..], [100.0, -50.0, 5.0]);
    }
}
