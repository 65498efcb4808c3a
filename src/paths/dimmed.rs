//! Where on a patch weights of visibility may be below one: outside of an area they are one, and stay as they are
//! from update to update.

use std::ops::Range;

/// Rows and columns of the facets of a patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::paths) struct Area {
    rows: Range<usize>,
    columns: Range<usize>,
}

impl Area {
    /// Grows about a facet of a patch so many facets wide.
    pub fn add(&mut self, index: usize, width: usize) {
        for (range, at) in [(&mut self.rows, index / width), (&mut self.columns, index % width)] {
            *range = if range.is_empty() { at..at + 1 } else { range.start.min(at)..range.end.max(at + 1) };
        }
    }

    /// Whether it has any of some neighbours in a row.
    pub fn touches(&self, first: usize, count: usize, width: usize) -> bool {
        let (row, column) = (first / width, first % width);
        self.rows.contains(&row) && column < self.columns.end && self.columns.start < column + count
    }

    /// Its facets, row by row.
    fn facets(&self, width: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let columns = self.columns.clone();
        self.rows.clone().map(move |row| row * width + columns.start..row * width + columns.end)
    }

    /// Makes all weights one that are not, and says where they were: nowhere, now.
    pub fn brighten(weights: &mut [f64], held: Option<Self>, width: usize) -> Self {
        match held {
            Some(area) => area.facets(width).for_each(|facets| weights[facets].fill(1.0)),
            None => weights.fill(1.0),
        }
        Self::default()
    }

    /// Makes weights those of others, of which and of their own those outside of the areas are one.
    pub fn copy<S: Copy, T: Copy>(
        &self,
        from: &[S],
        (held, to): (&Self, &mut [T]),
        width: usize,
        (one, convert): (T, impl Fn(S) -> T),
    ) {
        held.facets(width).for_each(|facets| to[facets].fill(one));
        for facets in self.facets(width) {
            let own = to[facets.clone()].iter_mut().zip(&from[facets]);
            own.for_each(|(to, from)| *to = convert(*from));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights that are changed where areas say are those that are written anew.
    #[test]
    fn areas_hold_what_is_not_one() {
        let (width, facets) = (7, 35);
        let (mut weights, mut held) = (vec![0.3; facets], None);
        let (mut copied, mut of_copy) = (vec![1.0f32; facets], Area::default());
        for dark in [vec![8, 16, 17], vec![], vec![34, 0], vec![10]] {
            let mut area = Area::brighten(&mut weights, held.take(), width);
            for facet in &dark {
                weights[*facet] = 0.0;
                area.add(*facet, width);
            }
            area.copy(&weights, (&of_copy, &mut copied), width, (1.0, |weight| weight as f32));
            for (n, (own, copy)) in weights.iter().zip(&copied).enumerate() {
                let wanted = if dark.contains(&n) { 0.0 } else { 1.0 };
                assert!(*own == wanted && f64::from(*copy) == wanted, "{dark:?} {n}");
                assert!(area.touches(n, 1, width) || wanted == 1.0);
            }
            assert_eq!(area.touches(0, facets.min(width), width), dark.iter().any(|n| *n < width));
            (of_copy, held) = (area.clone(), Some(area));
        }
    }
}
