//! `tools/setup` on machines that lack something, made of a PATH with chosen programs.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Command, Output};

use crate::program::package;

/// A folder of programs: those of the system that scripts need, and stand-ins.
fn machine(stand_ins: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["bash", "env", "dirname", "touch"] {
        let found = std::env::var("PATH").unwrap();
        let program = found.split(':').map(|dir| Path::new(dir).join(name)).find(|path| path.is_file());
        symlink(program.unwrap(), folder.path().join(name)).unwrap();
    }
    for (name, body) in stand_ins {
        let path = folder.path().join(name);
        fs::write(&path, format!("#!/usr/bin/env bash\n{body}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

fn setup(machine: &tempfile::TempDir) -> Output {
    Command::new(machine.path().join("bash"))
        .arg(package().join("tools/setup"))
        .env_clear()
        .env("PATH", machine.path())
        .env("HOME", machine.path())
        .env("NEREUS_SETUP_HEADERS", machine.path())
        .output()
        .unwrap()
}

fn text(output: &Output) -> String {
    assert!(output.stdout.is_empty(), "setup speaks on standard error only");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const BUILD: [(&str, &str); 2] = [("cargo", "true"), ("cc", "true")];

#[test]
fn missing_toolchains_are_named() {
    let output = setup(&machine(&[]));
    let text = text(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("https://rustup.rs") && text.contains("a C compiler"), "{text}");
}

#[test]
fn without_root_it_names_what_to_install() {
    let mut programs = BUILD.to_vec();
    programs.push(("id", "echo 1000"));
    programs.push(("apt-get", "exit 99"));
    let output = setup(&machine(&programs));
    let text = text(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("sudo apt-get install libhdf5-dev pkg-config"), "{text}");
    assert!(text.contains("--no-default-features"), "{text}");
    // A sudo that asks for a password is no better.
    programs.push(("sudo", "exit 1"));
    assert_eq!(setup(&machine(&programs)).status.code(), Some(2));
}

#[test]
fn without_apt_it_names_what_to_install() {
    let mut programs = BUILD.to_vec();
    programs.push(("id", "echo 0"));
    let output = setup(&machine(&programs));
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output).contains("dnf install hdf5-devel"));
}

#[test]
fn what_is_there_is_not_installed() {
    let mut programs = BUILD.to_vec();
    programs.push(("pkg-config", "true"));
    programs.push(("apt-get", "exit 99"));
    let output = setup(&machine(&programs));
    assert_eq!((output.status.code(), text(&output).as_str()), (Some(0), ""));
}

#[test]
fn root_installs_and_refreshes_an_empty_package_list() {
    let mut programs = BUILD.to_vec();
    programs.push(("id", "echo 0"));
    // The list is empty until `update`; the library is found once it has been installed.
    let apt = "if [ \"$1\" = update ]; then touch \"$HOME/updated\"; \
               elif [ -e \"$HOME/updated\" ]; then touch \"$HOME/installed\"; else exit 100; fi";
    programs.push(("apt-get", apt));
    programs.push(("pkg-config", "[ -e \"$HOME/installed\" ]"));
    let machine = machine(&programs);
    let output = setup(&machine);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(machine.path().join("installed").exists());
}
