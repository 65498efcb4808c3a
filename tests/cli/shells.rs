//! What shells and `man` are given, and the list of scenarios to start from.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use clap::CommandFactory;
use nereus::cli::Arguments;

use crate::program::{command, nereus, package};

/// What a program answers to a script; none where it is not installed.
fn answer(program: &str, arguments: &[&str], script: &str) -> Option<String> {
    let mut child =
        Command::new(program).args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    child.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert!(ended.status.success(), "{program} {arguments:?}");
    Some(String::from_utf8(ended.stdout).unwrap())
}

#[test]
fn bash_completes_commands_options_and_words() {
    let script = nereus(package(), &["completions", "bash"]);
    assert_eq!((script.code, script.stderr.as_str()), (0, ""));
    if answer("bash", &["-n"], &script.stdout).is_none() {
        println!("skipped: bash is not installed");
        return;
    }
    for (typed, wanted) in [
        (&["doc"][..], "doctor"),
        (&["doctor", "--sec"], "--seconds"),
        (&["new", "quick"], "quickstart"),
        (&["table", "sigma0-"], "sigma0-nrl"),
        (&["completions", "z"], "zsh"),
    ] {
        let words = typed.join(" ");
        let (last, place) = (typed.last().unwrap(), typed.len());
        let before = if place == 1 { "nereus" } else { typed[place - 2] };
        let ask = format!(
            "{}\nCOMP_WORDS=(nereus {words}); COMP_CWORD={place}; _nereus nereus {last} {before}; echo \"${{COMPREPLY[@]}}\"\n",
            script.stdout
        );
        let found = answer("bash", &["--norc", "-s"], &ask).unwrap();
        assert_eq!(found.trim(), wanted, "nereus {words}");
    }
}

#[test]
fn every_shell_has_a_script_of_all_commands() {
    let program = Arguments::command();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = nereus(package(), &["completions", shell]);
        assert_eq!((script.code, script.stderr.as_str()), (0, ""), "{shell}");
        for visible in program.get_subcommands().filter(|inner| !inner.is_hide_set()) {
            assert!(script.stdout.contains(visible.get_name()), "{shell}: {}", visible.get_name());
        }
        // A shell that is here reads its own.
        if ["zsh", "fish"].contains(&shell) && answer(shell, &["-n"], &script.stdout).is_none() {
            println!("not read: {shell} is not installed");
        }
    }
    assert_eq!(nereus(package(), &["completions", "csh"]).code, 2);
}

/// A reader that stops is no failure.
#[cfg(unix)]
#[test]
fn a_script_that_nobody_reads_is_no_panic() {
    let mut child = command(package(), &["completions", "bash"]).spawn().unwrap();
    drop(child.stdout.take());
    let ended = child.wait_with_output().unwrap();
    assert_eq!((ended.status.code(), ended.stderr.as_slice()), (Some(0), &b""[..]));
}

/// The names of a command's pages and of those below it.
fn names(command: &clap::Command, name: &str, found: &mut BTreeSet<String>) {
    found.insert(format!("{name}.1"));
    for inner in command.get_subcommands().filter(|inner| !inner.is_hide_set()) {
        names(inner, &format!("{name}-{}", inner.get_name()), found);
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("share/man/man1");
    let ended = nereus(folder.path(), &["manpages", "share/man/man1", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let mut wanted = BTreeSet::new();
    names(&Arguments::command(), "nereus", &mut wanted);
    let found = fs::read_dir(&pages).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(found.collect::<BTreeSet<_>>(), wanted);
    let report: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(report["pages"].as_array().unwrap().len(), wanted.len());

    let page = fs::read_to_string(pages.join("nereus-table-sigma0.1")).unwrap();
    let title = format!(".TH nereus-table-sigma0 1 \" \" \"nereus {}\" nereus", env!("CARGO_PKG_VERSION"));
    assert!(page.contains(&title) && page.contains("\\-\\-wind\\-mps"), "{page}");
    for name in &wanted {
        let page = fs::read_to_string(pages.join(name)).unwrap();
        // What roff cannot set it reports, and nothing else.
        let mut groff = Command::new("groff");
        groff.args(["-man", "-Tutf8", "-ww", "-z"]).stdin(Stdio::piped()).stderr(Stdio::piped());
        let Ok(mut child) = groff.spawn() else { return println!("not set: groff is not installed") };
        child.stdin.take().unwrap().write_all(page.as_bytes()).unwrap();
        let ended = child.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&ended.stderr), "", "{name}");
    }
}

#[test]
fn pages_that_exist_are_replaced_by_force_only() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("nereus-run.1");
    let make = |more: &[&str]| nereus(folder.path(), &[&["manpages", "."][..], more].concat());
    fs::write(&page, "a letter").unwrap();
    for (arguments, why) in [(&[][..], "exists already"), (&["--force"], "because it is no manual page")] {
        let refused = make(arguments);
        assert!(refused.code == 2 && refused.stderr.contains(why), "{}", refused.stderr);
        // Not one page is made.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
    assert_eq!(fs::read_to_string(&page).unwrap(), "a letter");
    fs::remove_file(&page).unwrap();
    assert_eq!(make(&[]).code, 0);
    fs::write(&page, fs::read_to_string(&page).unwrap() + "older\n").unwrap();
    assert_eq!(make(&["--force"]).code, 0);
    assert!(!fs::read_to_string(&page).unwrap().ends_with("older\n"));
}

#[test]
fn kinds_of_scenarios_are_listed() {
    let list = nereus(package(), &["new", "--list"]);
    assert_eq!((list.code, list.stderr.as_str()), (0, ""));
    let kinds: Vec<&str> = list.stdout.lines().filter_map(|line| line.split("  ").next()).collect();
    assert_eq!(kinds, ["coastal", "monostatic", "spaceborne", "sea", "quickstart", "calibration", "keys"]);
    for kind in kinds {
        assert_eq!(nereus(package(), &["new", kind]).code, 0, "{kind}");
    }
    assert_eq!(nereus(package(), &["new", "sea", "--list"]).code, 2);
}
