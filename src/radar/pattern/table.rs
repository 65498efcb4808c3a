//! Pattern files of our own: CSV.

use std::collections::HashMap;

use num_complex::Complex64;

use super::axis::{Axis, Gridded, OFF_GRID_STEPS};
use super::columns::{Column, MOST_POINTS, Quantity};
use super::fault::{Faults, PatternFault};
use crate::units::Decibels;

struct Row {
    line: u64,
    az_deg: f64,
    el_deg: f64,
    field: Complex64,
}

/// Reads the text of a file of gains, or of radar cross sections.
pub(super) fn read(quantity: Quantity, bytes: &[u8]) -> Result<Gridded, Vec<PatternFault>> {
    let mut faults = Faults::default();
    let rows = read_rows(quantity, bytes, &mut faults);
    if rows.is_empty() && !faults.list.is_empty() {
        return Err(faults.finish());
    }
    match on_grid(&rows, &mut faults) {
        Some(found) if faults.list.is_empty() => Ok(found),
        _ => Err(faults.finish()),
    }
}

fn on_grid(rows: &[Row], faults: &mut Faults) -> Option<Gridded> {
    let azimuth = Axis::through(rows.iter().map(|row| row.az_deg));
    let elevation = Axis::through(rows.iter().map(|row| row.el_deg));
    let mut whole = true;
    for (column, axis) in [(Column::Azimuth, &azimuth), (Column::Elevation, &elevation)] {
        if axis.len < 2 {
            whole = false;
            faults.push(PatternFault::TooFew { column, found: axis.len });
        }
    }
    let span_deg = azimuth.step_deg * azimuth.len.saturating_sub(1) as f64;
    if span_deg > 360.0 + OFF_GRID_STEPS * azimuth.step_deg {
        whole = false;
        faults.push(PatternFault::Span { span_deg });
    }
    let points = azimuth.len.saturating_mul(elevation.len);
    if points > MOST_POINTS {
        whole = false;
        faults.push(PatternFault::TooMany);
    }
    if !whole {
        return None;
    }
    let mut field = vec![None; points];
    let mut lines = HashMap::with_capacity(rows.len());
    for row in rows {
        let line = row.line;
        let mut places = [0; 2];
        let axes = [(Column::Azimuth, &azimuth, row.az_deg), (Column::Elevation, &elevation, row.el_deg)];
        let mut on = true;
        for (place, (column, axis, value)) in places.iter_mut().zip(axes) {
            match axis.place(value) {
                Some(at) => *place = at,
                None => {
                    on = false;
                    let (first, step) = (axis.first_deg, axis.step_deg);
                    faults.push(PatternFault::OffGrid { line, column, value, first, step });
                }
            }
        }
        let cell = places[1] * azimuth.len + places[0];
        if !on {
            continue;
        }
        if let Some(before) = lines.insert(cell, line) {
            let (az_deg, el_deg) = (row.az_deg, row.el_deg);
            faults.push(PatternFault::Twice { line, before, az_deg, el_deg });
        }
        field[cell] = Some(row.field);
    }
    let missing = field.iter().filter(|point| point.is_none()).count();
    if let Some(hole) = field.iter().position(Option::is_none) {
        faults.push(PatternFault::Holes {
            missing,
            wanted: points,
            az_deg: azimuth.value_deg(hole % azimuth.len),
            el_deg: elevation.value_deg(hole / azimuth.len),
        });
    }
    Some(Gridded { azimuth, elevation, field })
}

fn read_rows(quantity: Quantity, bytes: &[u8], faults: &mut Faults) -> Vec<Row> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut rows = Vec::new();
    let (columns, optional) = quantity.columns();
    let mut wanted = 0;
    for record in reader.records() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                faults.push(PatternFault::Csv { what: error.to_string() });
                continue;
            }
        };
        let line = record.position().map_or(0, csv::Position::line);
        if wanted == 0 {
            let header: Vec<&str> = record.iter().map(|name| name.trim_start_matches('\u{feff}')).collect();
            let names: Vec<String> = columns.iter().map(Column::to_string).collect();
            if header == names || header == names[..names.len() - optional] {
                wanted = header.len();
                continue;
            }
            let found = header.join(",").chars().take(80).collect();
            faults.push(PatternFault::Header { line, found, wanted: quantity.headers() });
            return rows;
        }
        if record.len() != wanted {
            faults.push(PatternFault::Fields { line, found: record.len(), wanted });
            continue;
        }
        if rows.len() >= MOST_POINTS {
            faults.push(PatternFault::TooMany);
            return rows;
        }
        let mut values = [0.0; 4];
        let mut good = true;
        for ((value, column), text) in values.iter_mut().zip(columns).zip(&record) {
            match column.read(text) {
                Ok(number) => *value = number,
                Err(allowed) => {
                    good = false;
                    let found = text.chars().take(40).collect();
                    faults.push(PatternFault::Value { line, column: *column, found, allowed });
                }
            }
        }
        if good {
            let [az_deg, el_deg, level_db, phase_deg] = values;
            let field = Complex64::from_polar(Decibels(level_db).amplitude_ratio(), phase_deg.to_radians());
            rows.push(Row { line, az_deg, el_deg, field });
        }
    }
    rows
}
