//! Printed tables beside golden ones.

use std::path::{Path, PathBuf};

use crate::program::{nereus, package};

/// A CSV text of numbers.
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// One row of it.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    columns: &'a [String],
    cells: &'a [f64],
    /// Line of the text.
    pub line: usize,
}

impl Table {
    fn parse(text: &str, what: &str) -> Self {
        let mut lines = text.lines();
        let columns: Vec<String> = lines.next().unwrap().split(',').map(str::to_owned).collect();
        let rows: Vec<Vec<f64>> = lines
            .map(|line| {
                line.split(',').map(|x| x.parse().unwrap_or_else(|e| panic!("{what}: {x}: {e}"))).collect()
            })
            .collect();
        assert!(rows.iter().all(|row| row.len() == columns.len()), "{what}: ragged");
        Self { columns, rows }
    }

    pub fn rows(&self) -> impl ExactSizeIterator<Item = Row<'_>> {
        self.rows.iter().enumerate().map(|(i, cells)| Row { columns: &self.columns, cells, line: i + 2 })
    }

    /// The only row.
    pub fn single(&self) -> Row<'_> {
        assert_eq!(self.rows.len(), 1);
        self.rows().next().unwrap()
    }

    pub fn columns(&self) -> &[String] {
        &self.columns
    }
}

impl Row<'_> {
    /// The number in a column.
    pub fn get(&self, column: &str) -> f64 {
        let found = self.columns.iter().position(|name| name == column);
        self.cells[found.unwrap_or_else(|| panic!("no column {column} in {:?}", self.columns))]
    }

    /// Whether all its numbers are such.
    pub fn all(&self, such: impl Fn(f64) -> bool) -> bool {
        self.cells.iter().all(|&cell| such(cell))
    }
}

/// What `nereus table` prints for keys written as on a command line.
pub fn printed(keys: &str) -> Table {
    let words: Vec<&str> = ["table"].into_iter().chain(keys.split_whitespace()).collect();
    let ended = nereus(package(), &words);
    assert_eq!(ended.code, 0, "{keys}: {}", ended.stderr);
    assert!(ended.stderr.is_empty(), "{keys}: {}", ended.stderr);
    Table::parse(&ended.stdout, keys)
}

/// A file of the chosen golden set.
pub fn golden(name: &str) -> Table {
    let folder = std::env::var_os("NEREUS_GOLDEN")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden"), PathBuf::from);
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let table = Table::parse(&text, name);
    assert!(!table.rows.is_empty(), "{name} has no rows");
    table
}

/// Rows that follow one another with the same values in some columns, so that one command serves all of them.
pub fn groups<'a>(table: &'a Table, same: &[&str]) -> Vec<Vec<Row<'a>>> {
    let mut groups: Vec<Vec<Row>> = Vec::new();
    for row in table.rows() {
        match groups.last_mut() {
            Some(group) if same.iter().all(|column| group[0].get(column) == row.get(column)) => {
                group.push(row)
            }
            _ => groups.push(vec![row]),
        }
    }
    groups
}

/// Golden rows with the printed ones, of which there must be as many.
pub fn beside<'a>(golden: &[Row<'a>], printed: &'a Table) -> Vec<(Row<'a>, Row<'a>)> {
    assert_eq!(golden.len(), printed.rows().len());
    golden.iter().copied().zip(printed.rows()).collect()
}

/// The values of a column as a list on the command line.
pub fn list(rows: &[Row], column: &str) -> String {
    rows.iter().map(|row| row.get(column).to_string()).collect::<Vec<_>>().join(",")
}

/// Keeps the worst error of a table.
pub struct Judge {
    name: &'static str,
    checked: usize,
    worst: f64,
}

impl Judge {
    pub fn new(name: &'static str) -> Self {
        Self { name, checked: 0, worst: 0.0 }
    }

    /// Compares a printed value with a golden one: within `tolerance` of it, and `absolute` beside.
    pub fn compare(&mut self, row: Row, column: &str, found: f64, tolerance: f64, absolute: f64) {
        let expected = row.get(column);
        let error = (found - expected).abs();
        self.checked += 1;
        assert!(
            error <= tolerance * expected.abs() + absolute,
            "{} line {}, {column}: {found:e}, golden {expected:e}",
            self.name,
            row.line
        );
        if expected != 0.0 && error > absolute {
            self.worst = self.worst.max(error / expected.abs());
        }
    }
}

impl Drop for Judge {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            assert!(self.checked > 0, "{}: nothing was compared", self.name);
            println!("{}: {} values, worst {:.1e}", self.name, self.checked, self.worst);
        }
    }
}
