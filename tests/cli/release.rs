//! What a release is made with, as far as it needs no build: `tools/test --all` makes one and tries it.

use std::fs;
use std::process::{Command, Output};

use crate::program::package;

fn run(program: &str, arguments: &[&str]) -> Option<Output> {
    let program = if program.contains('/') { package().join(program) } else { program.into() };
    Command::new(program).args(arguments).current_dir(package()).output().ok()
}

#[test]
fn a_folder_that_holds_something_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().display().to_string();
    fs::write(folder.path().join("letter"), "mine").unwrap();
    for (arguments, why) in
        [(&[name.as_str()][..], "is not empty; allowed: an empty folder"), (&[], "usage:")]
    {
        let refused = run("tools/release", arguments).unwrap();
        let text = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && text.contains(why), "{text}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("letter")).unwrap(), "mine");
}

#[test]
fn every_crate_that_is_linked_has_a_licence() {
    let Some(listed) =
        run("python3", &["tools/licences.py", "--no-default-features", "--features", "serial,monitor"])
    else {
        println!("skipped: python3 is not installed");
        return;
    };
    assert!(listed.status.success(), "{}", String::from_utf8_lossy(&listed.stderr));
    let page = String::from_utf8(listed.stdout).unwrap();
    let rows: Vec<&str> =
        page.lines().filter(|line| line.starts_with("| ") && line.contains("://")).collect();
    assert!(rows.len() > 80, "{} crates", rows.len());
    for name in ["clap ", "rustfft ", "hifitime ", "tokio "] {
        assert!(rows.iter().any(|row| row.starts_with(&format!("| {name}"))), "{name}");
    }
    // Linked, not what tests or builds are made with.
    assert!(!rows.iter().any(|row| row.starts_with("| proptest ") || row.starts_with("| cc ")), "{rows:#?}");
    assert!(page.contains("Mozilla Public License Version 2.0"));
}

/// The service names what the program has, and systemd reads it.
#[test]
fn the_service_is_read_by_systemd() {
    let unit = fs::read_to_string(package().join("packaging/nereus@.service")).unwrap();
    for line in ["LimitRTPRIO=50", "LimitMEMLOCK=infinity", "DynamicUser=yes", "KillSignal=SIGINT"] {
        assert!(unit.lines().any(|found| found == line), "{line}");
    }
    assert!(!unit.contains("RestrictRealtime"));
    let start = unit.lines().find_map(|line| line.strip_prefix("ExecStart=/usr/bin/")).unwrap();
    let words = start.split_whitespace();
    assert!(<nereus::cli::Arguments as clap::Parser>::try_parse_from(words).is_ok(), "{start}");

    let folder = tempfile::tempdir().unwrap();
    let here = folder.path().join("nereus@try.service");
    fs::write(&here, unit.replace("/usr/bin/nereus", env!("CARGO_BIN_EXE_nereus"))).unwrap();
    match run("systemd-analyze", &["verify", "--man=no", &here.display().to_string()]) {
        Some(read) => assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr)),
        None => println!("not read: systemd-analyze is not installed"),
    }
}

#[test]
fn the_container_does_not_run_as_root() {
    let file = fs::read_to_string(package().join("packaging/Containerfile")).unwrap();
    let users: Vec<&str> = file.lines().filter_map(|line| line.strip_prefix("USER ")).collect();
    assert_eq!(users, ["1000:1000"]);
    let (before, _) = file.split_once("ENTRYPOINT").unwrap();
    assert!(before.contains("USER "), "the user comes before the program");
}
