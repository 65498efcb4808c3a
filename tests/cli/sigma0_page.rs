//! The tables of docs/sigma0.md beside what the program prints.

use std::fs;

use crate::program::package;
use crate::table_golden::{Table, printed};

/// Keys of the tables, as `tools/sigma0_picture.py` has them.
const SEA: &str = "--kind elfouhaily --carrier-hz 10e9";
/// Aspects of the azimuth mean: one every 15 degrees.
const ASPECTS: usize = 24;

/// One wind's table: incidences, and the eight columns (HH, then VV: upwind, azimuth mean, mars2007, NRL),
/// empty where the page has nothing.
fn page(wind: &str) -> Vec<(String, Vec<Option<f64>>)> {
    let text = fs::read_to_string(package().join("docs/sigma0.md")).unwrap();
    let (_, below) =
        text.split_once(&format!("### {wind} m/s\n\n")).unwrap_or_else(|| panic!("no {wind} m/s"));
    let mut lines = below.lines().take_while(|line| line.starts_with('|'));
    let head = lines.next().unwrap();
    assert!(
        head.starts_with(
            "| incidence | HH upwind | HH azimuth mean | HH mars2007, upwind | HH NRL | VV upwind"
        )
    );
    lines
        .skip(1)
        .map(|line| {
            let mut cells = line.trim_matches('|').split('|').map(str::trim);
            let incidence = cells.next().unwrap().to_owned();
            (incidence, cells.map(|cell| (!cell.is_empty()).then(|| cell.parse().unwrap())).collect())
        })
        .collect()
}

fn mean_db(table: &Table, incidence_deg: f64, column: &str) -> f64 {
    let such = table.rows().filter(|row| row.get("incidence_deg") == incidence_deg);
    let ratios: Vec<f64> = such.map(|row| 10f64.powf(row.get(column) / 10.0)).collect();
    assert_eq!(ratios.len(), ASPECTS);
    10.0 * (ratios.iter().sum::<f64>() / ratios.len() as f64).log10()
}

#[test]
fn the_page_has_what_the_program_prints() {
    for wind in ["5", "10", "12.9", "15"] {
        let rows = page(wind);
        assert!(rows.len() >= 9, "{wind} m/s");
        let listed: Vec<&str> = rows.iter().map(|(incidence, _)| incidence.as_str()).collect();
        let ours = format!("sigma0 {SEA} --wind-mps {wind} --incidence-deg {}", listed.join(","));
        let upwind = printed(&ours);
        let paper = printed(&format!("{ours} --splitting mars2007"));
        let aspects: Vec<String> = (0..ASPECTS).map(|i| (15 * i).to_string()).collect();
        let around = printed(&format!("{ours} --aspect-deg {}", aspects.join(",")));
        for (i, (incidence, cells)) in rows.iter().enumerate() {
            let incidence_deg: f64 = incidence.parse().unwrap();
            assert_eq!(cells.len(), 8, "{wind} m/s, {incidence}");
            let mut expected = Vec::new();
            for channel in ["hh", "vv"] {
                let column = format!("sigma0_{channel}_db");
                // The empirical model ends at 60 degrees grazing and at sea state 6.
                let nrl = (incidence_deg >= 30.0 && wind != "15").then(|| {
                    let grazing_deg = 90.0 - incidence_deg;
                    printed(&format!("sigma0-nrl --wind-mps {wind} --grazing-deg {grazing_deg}"))
                        .single()
                        .get(&column)
                });
                expected.extend([
                    Some(upwind.rows().nth(i).unwrap().get(&column)),
                    Some(mean_db(&around, incidence_deg, &column)),
                    Some(paper.rows().nth(i).unwrap().get(&column)),
                    nrl,
                ]);
            }
            for (cell, expected) in cells.iter().zip(expected) {
                match (cell, expected) {
                    (None, None) => {}
                    // Half the page's last digit.
                    (Some(cell), Some(expected)) => assert!(
                        (cell - expected).abs() <= 0.05 + 1e-9,
                        "{wind} m/s, {incidence} deg: page {cell}, program {expected}"
                    ),
                    other => panic!("{wind} m/s, {incidence} deg: {other:?}"),
                }
            }
        }
    }
}
