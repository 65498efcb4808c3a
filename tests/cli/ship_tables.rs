//! `nereus table hull` and `nereus table wake-resistance`.

use crate::program::{nereus, package};
use crate::table_golden::{Judge, beside, golden, groups, list, printed};

/// Rows of `table hull`: scaled_to_m, quantity, computed, stated and difference where there are such.
fn particulars(keys: &str) -> Vec<(f64, String, f64, Option<[f64; 2]>)> {
    let words: Vec<&str> = ["table", "hull"].into_iter().chain(keys.split_whitespace()).collect();
    let ended = nereus(package(), &words);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{keys}");
    let mut lines = ended.stdout.lines();
    assert_eq!(lines.next(), Some("scaled_to_m,quantity,computed,stated,difference_percent"));
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), 5, "{line}");
            let number = |i: usize| cells[i].parse::<f64>().unwrap();
            let stated = (!cells[3].is_empty()).then(|| [number(3), number(4)]);
            assert_eq!(cells[3].is_empty(), cells[4].is_empty());
            (number(0), cells[1].to_owned(), number(2), stated)
        })
        .collect()
}

#[test]
fn particulars_stand_beside_those_stated() {
    let rows = particulars("hulls/dtmb5415.toml --length-m 142,100");
    assert_eq!(rows.len(), 18);
    let of = |length_m: f64, quantity: &str| {
        rows.iter().find(|row| row.0 == length_m && row.1 == quantity).unwrap_or_else(|| panic!("{quantity}"))
    };
    let (_, _, computed, stated) = of(142.0, "volume_m3");
    // The figures of the table's own check: 8452.2 against 8424.4.
    assert!((computed - 8452.216).abs() < 1e-3);
    let [stated, difference] = stated.unwrap();
    assert!(stated == 8424.4 && (difference - 0.33).abs() < 5e-3);
    assert_eq!(of(142.0, "waterplane").3, None);
    // Printed in 13 digits.
    assert!((of(100.0, "volume_m3").2 - computed * (100.0_f64 / 142.0).powi(3)).abs() < 1e-8);
    let lcb = of(100.0, "lcb_percent");
    assert!((lcb.2 + 0.565).abs() < 5e-4 && (lcb.3.unwrap()[1] - 0.118).abs() < 5e-4);
    // A table alone states nothing.
    assert!(particulars("hulls/wigley.csv").iter().all(|row| row.3.is_none() && row.2.is_finite()));
}

#[test]
fn wave_resistance_is_the_golden_one() {
    let mut judge = Judge::new("wake-resistance");
    let table = golden("wake_resistance.csv");
    for group in groups(&table, &["L", "B", "T"]) {
        let [l, b, t] = ["L", "B", "T"].map(|column| group[0].get(column));
        let found = printed(&format!(
            "wake-resistance --length-m {l} --beam-ratio {} --draught-ratio {} --density-kg-m3 1000 --speed-mps {}",
            b / l,
            t / l,
            list(&group, "V")
        ));
        for (row, found) in beside(&group, &found) {
            // The tolerance of the golden file.
            judge.compare(row, "Rw_N_rho1000", found.get("resistance_n"), 1e-6, 0.0);
            judge.compare(row, "Fn", found.get("froude"), 1e-9, 0.0);
            // The wetted surface is that of inscribed triangles: 5.4e-4 at most
            // (tests/physics/hull_particulars.rs).
            judge.compare(row, "S_wet_m2", found.get("wetted_surface_m2"), 5.4e-4, 0.0);
            judge.compare(row, "Cw", found.get("cw"), 5.5e-4, 0.0);
        }
    }
}

#[test]
fn speeds_and_lengths_make_rows() {
    let found = printed("wake-resistance --length-m 50,100 --from-mps 4 --to-mps 6 --step-mps 1");
    let rows: Vec<[f64; 2]> = found.rows().map(|row| [row.get("length_m"), row.get("speed_mps")]).collect();
    assert_eq!(rows, [[50.0, 4.0], [50.0, 5.0], [50.0, 6.0], [100.0, 4.0], [100.0, 5.0], [100.0, 6.0]]);
    let still = printed("wake-resistance --speed-mps 0,0.09,100");
    for row in still.rows() {
        assert!(row.all(f64::is_finite));
        assert_eq!(row.get("resistance_n") > 0.0, row.get("speed_mps") > 1.0);
    }
    let hull = "wake-resistance --hull-path hulls/dtmb5415.toml --length-m 100 --speed-mps 4.5";
    let [open, capped] = ["open", "capped"].map(|transom| printed(&format!("{hull} --transom {transom}")));
    assert!(capped.single().get("cw") > 5.0 * open.single().get("cw"));
}

#[test]
fn bad_ships_are_refused_in_words() {
    for (keys, words) in [
        ("hull no/such.toml", "hull no/such.toml: cannot be read"),
        ("hull README.md", "README.md line 1: "),
        ("hull hulls/wigley.toml --length-m 0", "hull of 0 m: allowed are 0.05 to 1000 m"),
        ("hull", "FILE"),
        ("wake-resistance --speed-mps=-1", "ship's speed of -1 m/s: allowed are 0 to 100 m/s"),
        ("wake-resistance --speed-mps nan", "allowed are 0 to 100 m/s"),
        ("wake-resistance --speed-mps 4 --to-mps 5", "--speed-mps and --to-mps both say"),
        ("wake-resistance --speed-mps 4,0.1", "needs"),
        ("wake-resistance --density-kg-m3 0", "water of 0 kg/m^3"),
        ("wake-resistance --beam-ratio 2", "--beam-ratio 2 is not allowed; allowed: 0.001 to 1"),
        ("wake-resistance --length-m 2000", "hull of 2000 m"),
        ("wake-resistance --hull-path hulls/wigley.toml --beam-ratio 0.1", "cannot be used with"),
        ("wake-resistance --points 1000001", "1 to 1000000 points"),
    ] {
        let words_given: Vec<&str> = ["table"].into_iter().chain(keys.split_whitespace()).collect();
        let ended = nereus(package(), &words_given);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{keys}: {}", ended.stderr);
        assert!(ended.stderr.contains(words), "{keys}: {}", ended.stderr);
    }
}
