//! Heights in blocks: one of a single value takes the memory of one.
//!
//! A raster of a coast is mostly sea without data, and a file that unpacks to a thousand times its size is of
//! few values throughout.

/// Side of a block, cells.
const SIDE: usize = 64;

/// Heights of the cells of a raster, m; NaN where there are no data.
#[derive(Debug)]
pub struct Heights {
    across: usize,
    blocks: Vec<Block>,
    /// Blocks that may still be of many values.
    left: usize,
}

#[derive(Clone, Debug)]
enum Block {
    /// Of one value, as far as it has been set.
    Even(Option<f32>),
    /// Cell by cell, row after row.
    Cells(Box<[f32]>),
}

impl Heights {
    /// Room for so many columns and rows, of which blocks of many values take at most so many bytes.
    pub(super) fn new([columns, rows]: [usize; 2], most_bytes: usize) -> Self {
        let [across, down] = [columns, rows].map(|cells| cells.div_ceil(SIDE));
        let left = most_bytes / (SIDE * SIDE * size_of::<f32>());
        Self { across, blocks: vec![Block::Even(None); across * down], left }
    }

    /// Sets a cell; `None` if it takes more memory than is allowed.
    pub(super) fn set(&mut self, [column, row]: [usize; 2], height_m: f32) -> Option<()> {
        let block = &mut self.blocks[row / SIDE * self.across + column / SIDE];
        match block {
            Block::Even(None) => *block = Block::Even(Some(height_m)),
            Block::Even(Some(known)) if known.to_bits() == height_m.to_bits() => {}
            Block::Even(Some(known)) => {
                self.left = self.left.checked_sub(1)?;
                let mut cells = vec![*known; SIDE * SIDE].into_boxed_slice();
                cells[row % SIDE * SIDE + column % SIDE] = height_m;
                *block = Block::Cells(cells);
            }
            Block::Cells(cells) => cells[row % SIDE * SIDE + column % SIDE] = height_m,
        }
        Some(())
    }

    /// Height of a cell, m; NaN where there are no data.
    pub fn at(&self, [column, row]: [usize; 2]) -> f32 {
        match &self.blocks[row / SIDE * self.across + column / SIDE] {
            Block::Even(height_m) => height_m.unwrap_or(f32::NAN),
            Block::Cells(cells) => cells[row % SIDE * SIDE + column % SIDE],
        }
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        let held = |block: &Block| match block {
            Block::Even(_) => 0,
            Block::Cells(cells) => size_of_val(&**cells),
        };
        self.blocks.iter().map(|block| size_of::<Block>() + held(block)).sum()
    }

    /// Lowest and highest, m; `None` without any data.
    pub fn range_m(&self) -> Option<[f32; 2]> {
        // Cells beyond the raster have a value of their block.
        let values = self.blocks.iter().flat_map(|block| match block {
            Block::Even(height_m) => height_m.as_slice(),
            Block::Cells(cells) => cells,
        });
        let wide = |[low, high]: [f32; 2], value: &f32| [low.min(*value), high.max(*value)];
        let range = values.fold([f32::INFINITY, f32::NEG_INFINITY], wide);
        (range[0] <= range[1]).then_some(range)
    }
}
