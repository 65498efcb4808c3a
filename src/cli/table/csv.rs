//! Rows of a table.

use std::fmt::{self, Display};
use std::io::{self, Write};

use super::MOST_ROWS;
use crate::cli::error::{CliError, Refused};
use crate::units::Decibels;

/// A number (or name) of a row, as it is printed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cell {
    /// A parameter of the row: the shortest text that reads back as the same number.
    Given(f64),
    /// A result of any size: scientific, 13 digits.
    Value(f64),
    /// A power ratio, in decibels.
    Decibels(f64),
    /// A name.
    Name(&'static str),
    /// Nothing is known.
    Empty,
}

impl Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Given(value) => write!(f, "{value}"),
            Self::Value(value) => write!(f, "{value:.12e}"),
            Self::Decibels(ratio) => write!(f, "{:.9}", Decibels::from_power_ratio(*ratio).0),
            Self::Name(name) => f.write_str(name),
            Self::Empty => Ok(()),
        }
    }
}

/// A table whose rows name their columns; the names are printed before the first row.
pub(super) struct Table<'a> {
    out: &'a mut dyn Write,
    /// Columns, once their names are printed.
    width: Option<usize>,
}

impl<'a> Table<'a> {
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, width: None }
    }

    /// Prints a row, which has the columns of the first one.
    pub fn row(&mut self, cells: &[(&str, Cell)]) -> Result<(), CliError> {
        let mut print = || {
            match self.width.replace(cells.len()) {
                Some(width) => debug_assert_eq!(width, cells.len()),
                None => line(self.out, cells.iter().map(|(name, _)| name))?,
            }
            line(self.out, cells.iter().map(|(_, cell)| cell))
        };
        print().map_err(CliError::Output)
    }
}

fn line(out: &mut dyn Write, texts: impl Iterator<Item = impl Display>) -> io::Result<()> {
    for (i, text) in texts.enumerate() {
        let comma = if i == 0 { "" } else { "," };
        write!(out, "{comma}{text}")?;
    }
    writeln!(out)
}

/// Refuses a table of too many rows, given how many values each of its keys has.
pub(super) fn bound(values: &[usize]) -> Result<(), Refused> {
    let rows = combinations(values);
    if rows <= MOST_ROWS { Ok(()) } else { Err(Refused::Rows { rows, most: MOST_ROWS }) }
}

/// How many combinations the values of several keys have.
pub(super) fn combinations(values: &[usize]) -> usize {
    values.iter().fold(1, |product, n| product.saturating_mul(*n))
}
