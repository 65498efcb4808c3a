//! Large pages for the program's memory.
//!
//! Seas and grids are hundreds of MB that inner loops gather from everywhere. In pages of 4 kB most of these
//! loads miss the address translation too, and a pulse takes up to half as long again. Linux gives pages of
//! 2 MB to whoever asks, by default to nobody else; the C library asks where a variable of the environment
//! says so before the program starts. So the program starts once more, with that variable.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// What the C library reads.
const TUNABLES: &str = "GLIBC_TUNABLES";
const OF_PAGES: &str = "glibc.malloc.hugetlb";
/// What says that the program has started again, or is not to: the loader takes the other variable away from
/// programs with capabilities of their own.
const OWN: &str = "NEREUS_PAGES";
/// Whether the system gives large pages to nobody, to those who ask, or to all.
const SYSTEM: &str = "/sys/kernel/mm/transparent_hugepage/enabled";

/// Starts the program again with large pages, in the same process. Returns where there is nothing to gain:
/// the system gives them to all or to nobody, or a variable says already what is wanted.
pub fn with_large_pages() {
    if !cfg!(all(target_os = "linux", target_env = "gnu")) {
        return;
    }
    let system = fs::read_to_string(SYSTEM).ok();
    let Some(tunables) = asking([TUNABLES, OWN].map(env::var_os), system.as_deref()) else {
        return;
    };
    let (Ok(program), mut arguments) = (env::current_exe(), env::args_os()) else { return };
    let mut again = Command::new(program);
    arguments.next().into_iter().for_each(|name| {
        again.arg0(name);
    });
    // It returns only where it fails: then pages stay small.
    let _ = again.args(arguments).env(TUNABLES, tunables).env(OWN, "large").exec();
}

/// What asks for large pages, where neither variable says anything of them yet and asking helps.
fn asking([held, own]: [Option<OsString>; 2], system: Option<&str>) -> Option<OsString> {
    let held = held.unwrap_or_default().into_string().ok()?;
    if own.is_some() || held.contains(OF_PAGES) || !system?.contains("[madvise]") {
        return None;
    }
    let before = if held.is_empty() { held } else { held + ":" };
    Some(format!("{before}{OF_PAGES}=1").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_said_anything_of_pages_is_not_asked_again() {
        let asked = |held: Option<&str>, system| asking([held.map(OsString::from), None], system);
        let madvise = Some("always [madvise] never\n");
        assert_eq!(asked(None, madvise), Some("glibc.malloc.hugetlb=1".into()));
        let other = "glibc.malloc.arena_max=2";
        assert_eq!(asked(Some(other), madvise), Some(format!("{other}:glibc.malloc.hugetlb=1").into()));
        // Started again, it does not start a third time; and 0 stays 0.
        assert_eq!(asked(Some("glibc.malloc.hugetlb=1"), madvise), None);
        assert_eq!(asked(Some("glibc.malloc.hugetlb=0"), madvise), None);
        // Nor where the loader has taken the variable away.
        assert_eq!(asking([None, Some("large".into())], madvise), None);
        for useless in [None, Some("[always] madvise never\n"), Some("always madvise [never]\n")] {
            assert_eq!(asked(None, useless), None);
        }
    }
}
