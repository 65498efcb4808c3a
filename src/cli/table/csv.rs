//! Rows of a table.

use std::fmt::{self, Display};
use std::io::Write;

use super::MOST_ROWS;
use super::error::TableError;
use crate::cli::error::CliError;
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

/// Prints the row of names.
pub(super) fn header<S: AsRef<str>>(out: &mut dyn Write, columns: &[S]) -> Result<(), CliError> {
    let columns: Vec<&str> = columns.iter().map(S::as_ref).collect();
    writeln!(out, "{}", columns.join(",")).map_err(CliError::Output)
}

/// Prints a row.
pub(super) fn row(out: &mut dyn Write, cells: &[Cell]) -> Result<(), CliError> {
    let mut print = || {
        for (i, cell) in cells.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            write!(out, "{comma}{cell}")?;
        }
        writeln!(out)
    };
    print().map_err(CliError::Output)
}

/// A table whose rows name their columns; the names are printed before the first row.
pub(super) struct Table<'a> {
    out: &'a mut dyn Write,
    begun: bool,
}

impl<'a> Table<'a> {
    pub fn new(out: &'a mut dyn Write) -> Self {
        Self { out, begun: false }
    }

    /// Prints a row.
    pub fn row<const N: usize>(&mut self, cells: &[(&str, Cell); N]) -> Result<(), CliError> {
        if !std::mem::replace(&mut self.begun, true) {
            header(self.out, &cells.map(|(name, _)| name))?;
        }
        row(self.out, &cells.map(|(_, cell)| cell))
    }
}

/// Refuses a table of too many rows, given how many values each of its keys has.
pub(super) fn bound(values: &[usize]) -> Result<(), TableError> {
    let rows = combinations(values);
    if rows <= MOST_ROWS { Ok(()) } else { Err(TableError::Rows { rows, most: MOST_ROWS }) }
}

/// How many combinations the values of several keys have.
pub(super) fn combinations(values: &[usize]) -> usize {
    values.iter().fold(1, |product, n| product.saturating_mul(*n))
}
