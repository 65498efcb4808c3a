//! Reads the golden tables of wind and spectra, and keeps the worst error of each column.

use std::collections::BTreeMap;
use std::path::PathBuf;

/// One row: column name to value.
pub struct Row {
    line: usize,
    values: BTreeMap<String, f64>,
}

impl Row {
    pub fn get(&self, column: &str) -> f64 {
        *self.values.get(column).unwrap_or_else(|| panic!("line {}: no column {column}", self.line))
    }
}

/// All rows of a table of the chosen golden set.
pub fn rows(name: &str) -> Vec<Row> {
    let folder = std::env::var_os("NEREUS_GOLDEN")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/golden"), PathBuf::from);
    let path = folder.join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Row> = lines
        .enumerate()
        .filter(|(_, content)| !content.trim().is_empty())
        .map(|(i, content)| {
            let values = header.iter().zip(content.split(','));
            let values = values.map(|(name, value)| (name.to_string(), value.trim().parse().unwrap()));
            Row { line: i + 2, values: values.collect() }
        })
        .collect();
    assert!(!rows.is_empty(), "{} has no rows", path.display());
    rows
}

/// Worst relative error per column, checked at the end.
pub struct Judge {
    table: &'static str,
    tolerance: f64,
    checked: usize,
    worst: BTreeMap<String, (f64, usize)>,
}

impl Judge {
    pub fn new(table: &'static str, tolerance: f64) -> Self {
        Self { table, tolerance, checked: 0, worst: BTreeMap::new() }
    }

    /// Compares a value with a column of a row, relative to the golden value.
    pub fn compare(&mut self, row: &Row, column: &str, value: f64) {
        self.compare_at(row, column, value, row.get(column).abs());
    }

    /// Compares relative to a scale of the caller's.
    pub fn compare_at(&mut self, row: &Row, column: &str, value: f64, scale: f64) {
        let golden = row.get(column);
        let error = if value == golden { 0.0 } else { (value - golden).abs() / scale };
        self.checked += 1;
        let worst = self.worst.entry(column.to_string()).or_insert((0.0, row.line));
        // A NaN must not pass as small.
        if error.is_nan() || error > worst.0 {
            *worst = (if error.is_nan() { f64::INFINITY } else { error }, row.line);
        }
    }

    pub fn verdict(self) {
        for (column, (error, line)) in &self.worst {
            println!("{} {column}: worst {error:.2e} (line {line})", self.table);
        }
        println!("{}: {} values, tolerance {:.0e}", self.table, self.checked, self.tolerance);
        for (column, (error, line)) in &self.worst {
            assert!(error <= &self.tolerance, "{} line {line}, {column}: {error:e}", self.table);
        }
    }
}
