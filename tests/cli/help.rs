//! Texts of `--help`, so that a change of them is seen.

use crate::program::{nereus, package};

fn help(arguments: &[&str]) -> String {
    let ended = nereus(package(), arguments);
    assert_eq!((ended.code, ended.stderr.as_str()), (0, ""), "{arguments:?}");
    ended.stdout
}

/// What a command says of itself, before its usage.
fn about(command: &[&str]) -> String {
    let text = help(&[&["table"], command, &["--help"]].concat());
    // Lines are as wide as the terminal.
    let about = text.split("Usage:").next().unwrap();
    about.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn export_names_its_formats() {
    insta::assert_snapshot!(help(&["export", "-h"]), @r"
    Export a recording to CRSD 1.0 or SigMF

    Usage: nereus export <COMMAND>

    Commands:
      crsd   CRSD 1.0 (NGA.STND.0080): pulses, reported positions, antennas and errors in one file
      sigmf  SigMF 1.2: samples of each channel, and an annotation per pulse

    Options:
      -h, --help  Print help
    ");
}

/// Of what area a cross section is, what is measured and what computed, and whose sea it is.
#[test]
fn tables_state_what_they_suppose() {
    insta::assert_snapshot!(about(&["sigma0"]), @"Normalised radar cross section of the sea, mono- and bistatic, all channels Channels are named receiver first. sigma0 is the sum of the Bragg part (spm) and the specular part (go), per unit area of the facet's plane; without --facet-m per unit area of the mean sea surface: no wave is resolved then. Without --scattering-deg the scattering angle is the incidence; with the default azimuth of 180 that is monostatic. Sweep: the angle named by --vary; incidence or scattering 0 to 80 degrees by 5, azimuth or aspect 0 to 360 by 10 unless given.");
    insta::assert_snapshot!(about(&["sigma0-nrl"]), @"Measured cross section of the sea, by the empirical NRL clutter model For comparison only: no echo is computed with it. Mean over the wind's directions, by sea state; with --wind-mps that of the fully developed sea. Sweep: grazing angle, 0.1 to 60 degrees, 28 points in log spacing unless given.");
    let usual = help(&["table", "--help"]);
    let (_, usual) = usual.split_once("-h, --help").unwrap();
    let usual: Vec<&str> = usual.split_whitespace().skip(2).collect();
    insta::assert_snapshot!(usual.join(" "), @"The default sea is that of the paper (--kind elfouhaily-fung-lee, --ustar-mps 0.36), not that of scenarios: for theirs give --kind elfouhaily and --wind-mps, the sea.wind_mps of yours.");
}
