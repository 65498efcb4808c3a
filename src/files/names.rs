//! Names change hands: never over something, or for something in one step.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Renames, unless something has the new name.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    use nix::errno::Errno;
    use nix::fcntl::{AT_FDCWD, RenameFlags, renameat2};
    match renameat2(AT_FDCWD, from, AT_FDCWD, to, RenameFlags::RENAME_NOREPLACE) {
        Err(Errno::EINVAL | Errno::ENOSYS | Errno::EOPNOTSUPP) => claim(from, to),
        done => Ok(done?),
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn rename_new(from: &Path, to: &Path) -> io::Result<()> {
    claim(from, to)
}

/// Lets two names change their places. `aside` gives a free name, where the system cannot do so in one step.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn exchange(a: &Path, b: &Path, aside: impl Fn() -> PathBuf) -> io::Result<()> {
    use nix::errno::Errno;
    use nix::fcntl::{AT_FDCWD, RenameFlags, renameat2};
    match renameat2(AT_FDCWD, a, AT_FDCWD, b, RenameFlags::RENAME_EXCHANGE) {
        Err(Errno::EINVAL | Errno::ENOSYS | Errno::EOPNOTSUPP) => by_three_renames(a, b, &aside()),
        done => Ok(done?),
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn exchange(a: &Path, b: &Path, aside: impl Fn() -> PathBuf) -> io::Result<()> {
    by_three_renames(a, b, &aside())
}

/// Takes the new name by making something empty there, which fails if anything has it.
fn claim(from: &Path, to: &Path) -> io::Result<()> {
    if fs::symlink_metadata(from)?.is_dir() {
        fs::create_dir(to)?;
        // A folder replaces an empty one only.
        return fs::rename(from, to).inspect_err(|_| drop(fs::remove_dir(to)));
    }
    match fs::hard_link(from, to) {
        Ok(()) => fs::remove_file(from),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        Err(_) => {
            fs::File::create_new(to)?;
            fs::rename(from, to)
        }
    }
}

fn by_three_renames(a: &Path, b: &Path, aside: &Path) -> io::Result<()> {
    rename_new(b, aside)?;
    if let Err(error) = rename_new(a, b) {
        rename_new(aside, b)?;
        return Err(error);
    }
    rename_new(aside, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the system has no `renameat2`.
    #[test]
    fn names_are_claimed_and_exchanged_without_replacing() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        for (name, text) in [("a", "1"), ("b", "2")] {
            fs::write(at(name), text).unwrap();
        }
        assert_eq!(claim(&at("a"), &at("b")).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        by_three_renames(&at("a"), &at("b"), &at("c")).unwrap();
        assert_eq!((fs::read(at("a")).unwrap(), fs::read(at("b")).unwrap()), (b"2".into(), b"1".into()));
        claim(&at("a"), &at("d")).unwrap();
        assert_eq!((fs::read(at("d")).unwrap(), at("a").exists()), (b"2".into(), false));
        fs::create_dir_all(at("f/inner")).unwrap();
        fs::create_dir_all(at("g/other")).unwrap();
        assert!(claim(&at("f"), &at("g")).is_err() && at("f/inner").exists() && at("g/other").exists());
        claim(&at("f"), &at("h")).unwrap();
        assert!(at("h/inner").exists() && !at("f").exists());
    }
}
