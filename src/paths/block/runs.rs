//! Which facets of a patch are handled together.
//!
//! A patch is cut into strips of [`RUN`] columns, and a strip into tiles of as many rows as fit into
//! [`LANES`]: 16 x 16 facets. So a beam illuminates few tiles or all of one, and what lies beside it can be
//! kept apart. A row of a strip is a **run**, facets one after the other in memory. Samples take runs
//! from all over the patch, since whole tiles would be too few to meet a narrow beam.

use crate::cpu::Task;
use crate::geometry::lanes::{LANES, Row};

/// Most facets of a run.
pub const RUN: usize = 16;

/// Facets of a row, one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Index of the first in the patch.
    pub first: usize,
    /// Facets.
    pub count: usize,
}

/// How a patch is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    columns: usize,
    rows: usize,
}

impl Cut {
    /// Of a patch of so many columns and rows.
    pub fn of([columns, rows]: [usize; 2]) -> Self {
        Self { columns, rows }
    }

    /// Runs of all strips.
    pub fn runs(&self) -> usize {
        self.columns.div_ceil(RUN) * self.rows
    }

    /// A run by its number: strip by strip, row by row.
    pub fn run(&self, number: usize) -> Run {
        let (strip, row) = (number / self.rows.max(1), number % self.rows.max(1));
        let column = strip * RUN;
        Run { first: row * self.columns + column, count: RUN.min(self.columns.saturating_sub(column)) }
    }

    /// Tiles of the patch, each as its runs: strip by strip, or across the strips.
    pub fn tiles(self, across: bool) -> impl Iterator<Item = impl Iterator<Item = Run>> {
        let (strips, of_strip) =
            (self.columns.div_ceil(RUN), move |strip| self.rows.div_ceil(self.height(strip)));
        // The last strip may be narrow, and its tiles high.
        let most = [0, strips.saturating_sub(1)].map(of_strip).into_iter().fold(0, usize::max);
        let [outer, inner] = if across { [most, strips] } else { [strips, most] };
        (0..outer).flat_map(move |a| {
            (0..inner).filter_map(move |b| {
                let (strip, place) = if across { (b, a) } else { (a, b) };
                let (from, height) = (strip * self.rows, self.height(strip));
                let rows = place * height..self.rows.min((place + 1) * height);
                (rows.start < self.rows).then(|| rows.map(move |row| self.run(from + row)))
            })
        })
    }

    /// Rows of the tiles of a strip.
    fn height(&self, strip: usize) -> usize {
        LANES / self.run(strip * self.rows).count.max(1)
    }

    /// Whole runs that fill a tile.
    fn together(&self) -> usize {
        LANES / RUN.min(self.columns).max(1)
    }

    /// Distance of the runs of a sample of about so many tiles. It shares no factor with the rows, so that
    /// strips are met at rows of their own.
    fn step(&self, tiles: usize) -> usize {
        let least = (self.runs() / (tiles.max(1) * self.together())).max(1);
        let divisor = |mut a: usize, mut b: usize| {
            while b > 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        (least..).find(|step| divisor(*step, self.rows) <= 1).unwrap_or(least)
    }

    /// A sample of about so many tiles, runs spread over the patch.
    pub fn sample(self, tiles: usize) -> impl Iterator<Item = impl Iterator<Item = Run>> {
        let (step, together) = (self.step(tiles), self.together());
        (0..self.runs()).step_by(step * together).map(move |from| {
            (from..self.runs().min(from + step * together)).step_by(step).map(move |number| self.run(number))
        })
    }

    /// Share of the facets in such a sample; 1 of no facets.
    pub fn sampled(&self, tiles: usize) -> f64 {
        match self.runs() {
            0 => 1.0,
            runs => runs.div_ceil(self.step(tiles)) as f64 / runs as f64,
        }
    }
}

/// Copies what facets of some runs have from a row of the patch, one run after the other.
pub(super) struct Gather<'a> {
    pub runs: &'a [Run],
    pub from: &'a [f32],
    pub to: &'a mut Row,
}

impl Task for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { runs, from, to } = self;
        // Whole runs apart: so they become moves of a register, and no calls.
        if runs.iter().all(|run| run.count == RUN) {
            for (run, to) in runs.iter().zip(to.as_chunks_mut::<RUN>().0) {
                if let Some(from) = from[run.first..].first_chunk::<RUN>() {
                    *to = *from;
                }
            }
            return;
        }
        let mut at = 0;
        for run in runs {
            to[at..at + run.count].copy_from_slice(&from[run.first..run.first + run.count]);
            at += run.count;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_facet_is_in_one_tile() {
        for facets in
            [[512, 512], [64, 64], [1, 1], [1, 700], [700, 1], [17, 33], [100, 30], [15, 40], [0, 0]]
        {
            let cut = Cut::of(facets);
            for across in [false, true] {
                let mut seen = vec![0; facets[0] * facets[1]];
                for tile in cut.tiles(across) {
                    let runs: Vec<Run> = tile.collect();
                    assert!(runs.iter().map(|run| run.count).sum::<usize>() <= LANES, "{facets:?}");
                    for run in runs {
                        seen[run.first..run.first + run.count].iter_mut().for_each(|n| *n += 1);
                    }
                }
                assert!(seen.iter().all(|n| *n == 1), "{facets:?}");
            }
        }
        // Squares, where the patch has room for them.
        let first: Vec<Run> = Cut::of([512, 512]).tiles(false).next().unwrap().collect();
        assert_eq!((first.len(), first[1]), (16, Run { first: 512, count: 16 }));
        assert_eq!(Cut::of([512, 512]).tiles(false).count(), 1024);
        // The next tile is that to the North, or that to the East.
        let second = |across: bool| Cut::of([512, 512]).tiles(across).nth(1).unwrap().next().unwrap().first;
        assert_eq!([second(false), second(true)], [16 * 512, 16]);
    }

    #[test]
    fn samples_are_spread() {
        let cut = Cut::of([512, 512]);
        let runs: Vec<Vec<Run>> = cut.sample(64).map(Iterator::collect).collect();
        let facets: usize = runs.iter().flatten().map(|run| run.count).sum();
        assert!((facets as f64 / (512.0 * 512.0) - cut.sampled(64)).abs() < 1e-9);
        assert!((60..=64).contains(&runs.len()) && runs.iter().all(|tile| tile.len() <= 16));
        // Every strip and every row modulo 16.
        for strip in 0..32 {
            assert!(runs.iter().flatten().filter(|run| run.first % 512 / 16 == strip).count() >= 30);
        }
        // Every strip has rows of its own, and narrow patches their share.
        let first_rows = |n: usize| {
            let first = |strip: usize| {
                Cut::of([n, n]).sample(64).flatten().find(|run| run.first % n / 16 == strip).unwrap().first
                    / n
            };
            (0..4).map(first).collect::<std::collections::BTreeSet<_>>().len()
        };
        assert_eq!([480, 510, 820].map(first_rows), [4, 4, 4]);
        assert!((0.05..0.07).contains(&Cut::of([4, 65_536]).sampled(64)));
        // A small patch is taken whole.
        assert_eq!((Cut::of([64, 64]).sampled(64), Cut::of([0, 0]).sampled(3)), (1.0, 1.0));
        let all: usize = Cut::of([100, 30]).sample(64).flatten().map(|run| run.count).sum();
        assert_eq!(all, 3000);
    }
}
