//! Names are unique, written or by default, and found without looking at all of them.

use std::time::Instant;

use super::*;

/// A scenario of a sea, with overrides.
fn faults_at_sea(list: &[(&str, &str)]) -> String {
    let sea = include_str!("../../../configs/sea.toml");
    let error = parse(sea, &in_configs(), &settings(list)).unwrap_err();
    error.faults().iter().map(|fault| format!("{fault}\n")).collect()
}

#[test]
fn a_default_name_is_a_name_like_any_other() {
    let target = "position_m = [0, 0, 0], rcs_m2 = 1";
    let of_targets = |first: &str, second: &str| {
        faults_of(&[("target", &format!("[{{ {first}{target} }}, {{ {second}{target} }}]"))])
    };
    insta::assert_snapshot!(of_targets("", "name = 'target-0', "), @r#"target.1.name: "target-0" is already the name of another target; allowed: unique names"#);
    insta::assert_snapshot!(of_targets("name = 'target-1', ", ""), @r#"target.1.name: "target-1" is already the name of another target; allowed: unique names"#);
    let grid = "position_m = [0, 0, 0], count = [1, 1], spacing_m = [1, 1], rcs_m2 = 1";
    insta::assert_snapshot!(faults_of(&[("target_grid", &format!("[{{ {grid} }}, {{ name = 'grid-0', {grid} }}]"))]), @r#"target_grid.1.name: "grid-0" is already the name of another target_grid; allowed: unique names"#);
    insta::assert_snapshot!(faults_of(&[("target.0.name", "grid-0-0-0"), ("target_grid", &format!("[{{ {grid} }}]"))]), @r#"target_grid: "grid-0-0-0" is already the name of another target; allowed: unique names"#);
    let ship = "hull = 'wigley', length_m = 20, beam_m = 2, draught_m = 1, position_m = [0, 0], heading_deg = 0, speed_mps = 3";
    insta::assert_snapshot!(faults_at_sea(&[("ship", &format!("[{{ {ship} }}, {{ name = 'ship-0', {ship} }}]"))]), @r#"ship.1.name: "ship-0" is already the name of another ship; allowed: unique names"#);
    let slick = "centre_m = [0, 0], half_axes_m = [5, 5]";
    insta::assert_snapshot!(faults_at_sea(&[("slick", &format!("[{{ {slick} }}, {{ name = 'slick-0', {slick} }}]"))]), @r#"slick.1.name: "slick-0" is already the name of another slick; allowed: unique names"#);
}

#[test]
fn channels_by_default_are_not_named_twice() {
    let channels = |rows: &str| {
        let text = COASTAL.replace("channels = ", "# channels = ");
        let list = settings(&[("radar.channel", rows)]);
        let error = parse(&text, &in_configs(), &list).unwrap_err();
        error.faults().iter().map(|fault| format!("{fault}\n")).collect::<String>()
    };
    insta::assert_snapshot!(channels("[{ polarisation = 'HH' }, { polarisation = 'HH' }]"), @r#"radar.channel.1.name: "HH" is already the name of another channel; allowed: unique names"#);
    insta::assert_snapshot!(channels("[{ polarisation = 'HH' }, { polarisation = 'VV', name = 'HH' }]"), @r#"radar.channel.1.name: "HH" is already the name of another channel; allowed: unique names"#);
    insta::assert_snapshot!(channels("[{ polarisation = 'VV', name = 'HH' }, { polarisation = 'HH' }]"), @r#"radar.channel.1.name: "HH" is already the name of another channel; allowed: unique names"#);
}

/// Default names take as long as written ones: looking at all names for each would take several times as
/// long.
#[test]
fn default_names_of_many_targets_are_found_like_written_ones() {
    const COUNT: usize = 60_000;
    let before = COASTAL.split("[[target]]").next().unwrap();
    let read_s = |written: bool| {
        let mut text = before.to_owned();
        for n in 0..COUNT {
            let name = if written { format!("name = 'buoy-{n}'\n") } else { String::new() };
            text += &format!("\n[[target]]\n{name}position_m = [0, 0, 0]\nrcs_m2 = 1\n");
        }
        let begun = Instant::now();
        let read = read(&text, &in_configs(), &[], Files::Required);
        assert!(read.asked.len() > 10);
        begun.elapsed().as_secs_f64()
    };
    // In turn, so that a machine that is busy is so for both.
    let [mut default_s, mut written_s] = [f64::INFINITY; 2];
    for _ in 0..2 {
        default_s = default_s.min(read_s(false));
        written_s = written_s.min(read_s(true));
    }
    println!("default names {default_s:.3} s, written ones {written_s:.3} s");
    assert!(default_s < 2.5 * written_s, "{default_s} {written_s}");
}
