//! How the system is set, and what it grants this process.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::Finding;
use crate::receive::listener::RECEIVE_BUFFER;
use crate::sinks::link::SEND_BUFFER;
use crate::transport::rights::{self, Right};

const MIB: f64 = (1_u64 << 20) as f64;
/// A reading of the clock that takes longer, ns, goes through the kernel: the pacer spins on the clock.
const SLOW_CLOCK_NS: f64 = 200.0;
/// Free memory of a comfortable run, MiB: docs/speed.md.
const LEAST_MEMORY_MIB: f64 = 1024.0;

/// All that is read without changing or loading anything.
pub(super) fn examine() -> Vec<Finding> {
    let system = System { root: PathBuf::from("/") };
    vec![
        priority(asked_apart(rights::run_ahead)),
        locked_memory(asked_apart(rights::lock_memory)),
        processors(std::thread::available_parallelism().map_or(1, std::num::NonZero::get)),
        system.governor(),
        system.clock_source(clock_ns()),
        system.buffer("receive buffer", "rmem_max", RECEIVE_BUFFER),
        system.buffer("send buffer", "wmem_max", SEND_BUFFER),
        system.memory(),
        system.large_pages(),
        hdf5(),
    ]
}

/// Asks for a right in a thread that ends with it.
fn asked_apart(ask: fn() -> Right) -> Option<Right> {
    std::thread::spawn(ask).join().ok()
}

fn priority(right: Option<Right>) -> Finding {
    let check = "real-time priority";
    match right {
        Some(Right { granted: true, .. }) => Finding::new(check, true, "SCHED_FIFO is granted", ""),
        Some(Right { reason, .. }) => Finding::new(
            check,
            false,
            format!("SCHED_FIFO is refused: {}", reason.unwrap_or_default()),
            "a file in /etc/security/limits.d with \"NAME - rtprio 50\", then log in again; in a service \
             LimitRTPRIO=50; in a container --ulimit rtprio=50",
        ),
        None => Finding::unknown(check, "it could not be asked for"),
    }
}

fn locked_memory(right: Option<Right>) -> Finding {
    let check = "locked memory";
    release_memory();
    match right {
        Some(Right { granted: true, .. }) => Finding::new(check, true, "granted (stream.lock_memory)", ""),
        Some(Right { reason, .. }) => Finding::new(
            check,
            false,
            format!("refused (stream.lock_memory): {}", reason.unwrap_or_default()),
            "\"NAME - memlock unlimited\" in the same file; LimitMEMLOCK=infinity; --ulimit memlock=-1",
        ),
        None => Finding::unknown(check, "it could not be asked for"),
    }
}

/// What the question has locked.
fn release_memory() {
    #[cfg(target_os = "linux")]
    let _ = nix::sys::mman::munlockall();
}

fn processors(threads: usize) -> Finding {
    Finding::new(
        "processors",
        threads > 1,
        crate::units::counted(threads as u64, "thread"),
        "with a single one the thread that releases pulses waits for those that make them",
    )
    .of(threads as f64, "threads")
}

/// Mean time of a reading of the monotonic clock, ns.
fn clock_ns() -> f64 {
    const READINGS: u32 = 20_000;
    let begun = Instant::now();
    for _ in 0..READINGS {
        std::hint::black_box(Instant::now());
    }
    begun.elapsed().as_secs_f64() * 1e9 / f64::from(READINGS)
}

fn hdf5() -> Finding {
    let remedy = "recordings become folders of plain files; for HDF5 install libhdf5-dev and build again";
    let found = library().unwrap_or_else(|| "not in this build".to_owned());
    Finding::new("HDF5", cfg!(feature = "hdf5"), found, remedy)
}

#[cfg(feature = "hdf5")]
fn library() -> Option<String> {
    let (major, minor, patch) = hdf5::library_version();
    let how = if cfg!(feature = "hdf5-static") { "part of the program" } else { "of the system" };
    Some(format!("version {major}.{minor}.{patch}, {how}"))
}

#[cfg(not(feature = "hdf5"))]
fn library() -> Option<String> {
    None
}

/// Files of a system.
struct System {
    root: PathBuf,
}

impl System {
    /// The first line of a file.
    fn line(&self, path: impl AsRef<Path>) -> Option<String> {
        let text = fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.lines().next()?.trim().to_owned())
    }

    fn governor(&self) -> Finding {
        let check = "frequency governor";
        let folder = self.root.join("sys/devices/system/cpu");
        let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut governors: Vec<String> =
            entries.filter_map(|cpu| self.line(cpu.join("cpufreq/scaling_governor"))).collect();
        governors.sort();
        let all = governors.len();
        governors.dedup();
        if all == 0 {
            return Finding::unknown(check, "the system shows none (a virtual machine, a container)");
        }
        let is_fine = governors == ["performance"];
        let found = format!("{} ({})", governors.join(", "), crate::units::counted(all as u64, "processor"));
        Finding::new(check, is_fine, found, "cpupower frequency-set --governor performance")
    }

    fn clock_source(&self, ns: f64) -> Finding {
        let folder = Path::new("sys/devices/system/clocksource/clocksource0");
        let check = "clock source";
        let Some(source) = self.line(folder.join("current_clocksource")) else {
            return Finding::unknown(check, format!("not shown; {ns:.0} ns a reading")).of(ns, "ns");
        };
        let others = self.line(folder.join("available_clocksource")).unwrap_or_default();
        let better = others.split_whitespace().find(|other| *other == "tsc" && source != "tsc");
        let remedy = match better {
            Some(other) => format!("boot with clocksource={other}, if the kernel did not call it unstable"),
            None => "every reading goes through the kernel, and the machine has no other clock".to_owned(),
        };
        let found = format!("{source}, {ns:.0} ns a reading");
        Finding::new(check, ns <= SLOW_CLOCK_NS, found, remedy).of(ns, "ns")
    }

    /// Half of a limit's double: the kernel books twice what is asked.
    fn buffer(&self, check: &'static str, name: &'static str, wanted: usize) -> Finding {
        let path = format!("proc/sys/net/core/{name}");
        let Some(limit) = self.line(path).and_then(|line| line.parse::<f64>().ok()) else {
            return Finding::unknown(check, format!("net.core.{name} is not shown"));
        };
        let found = format!(
            "net.core.{name} is {:.2} MiB, {:.0} MiB are asked for",
            limit / MIB,
            wanted as f64 / MIB
        );
        let remedy = format!("sysctl -w net.core.{name}={wanted}, and a file in /etc/sysctl.d to keep it");
        Finding::new(check, limit >= wanted as f64, found, remedy).of(limit, "bytes")
    }

    fn memory(&self) -> Finding {
        let check = "memory";
        let kib = |key: &str| {
            let text = fs::read_to_string(self.root.join("proc/meminfo")).ok()?;
            let line = text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'))?;
            line.trim().strip_suffix(" kB")?.trim().parse::<f64>().ok()
        };
        let (Some(free), Some(total)) = (kib("MemAvailable"), kib("MemTotal")) else {
            return Finding::unknown(check, "not shown");
        };
        let (free, total) = (free / 1024.0, total / 1024.0);
        let found = format!("{free:.0} MiB of {total:.0} are available");
        let remedy = "end other programs; `nereus check` says what a scenario takes";
        Finding::new(check, free >= LEAST_MEMORY_MIB, found, remedy).of(free, "MiB")
    }

    fn large_pages(&self) -> Finding {
        let check = "large pages";
        let Some(line) = self.line("sys/kernel/mm/transparent_hugepage/enabled") else {
            return Finding::unknown(check, "not shown");
        };
        let word = line.split(['[', ']']).nth(1).unwrap_or_default().to_owned();
        let remedy = "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled";
        Finding::new(check, ["madvise", "always"].contains(&word.as_str()), word, remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Verdict;
    use super::*;

    /// A system of some files.
    fn system(files: &[(&str, &str)]) -> (tempfile::TempDir, System) {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let root = folder.path().to_owned();
        (folder, System { root })
    }

    #[test]
    fn a_laptop_that_saves_power_has_a_remedy() {
        let (_folder, system) = system(&[
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"),
            ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"),
            ("sys/devices/system/clocksource/clocksource0/available_clocksource", "hpet tsc acpi_pm\n"),
            ("proc/sys/net/core/rmem_max", "212992\n"),
            ("proc/meminfo", "MemTotal:  2048000 kB\nMemFree: 1 kB\nMemAvailable:   512000 kB\n"),
            ("sys/kernel/mm/transparent_hugepage/enabled", "always madvise [never]\n"),
        ]);
        let governor = system.governor();
        assert_eq!(
            (governor.verdict, governor.found.as_str()),
            (Verdict::Improve, "performance, powersave (2 processors)")
        );
        let clock = system.clock_source(1500.0);
        assert_eq!(clock.found, "hpet, 1500 ns a reading");
        assert!(clock.remedy.unwrap().starts_with("boot with clocksource=tsc"));
        let buffer = system.buffer("receive buffer", "rmem_max", 16 << 20);
        assert_eq!(buffer.found, "net.core.rmem_max is 0.20 MiB, 16 MiB are asked for");
        assert_eq!((buffer.value, buffer.unit), (Some(212_992.0), Some("bytes")));
        assert!(buffer.remedy.unwrap().starts_with("sysctl -w net.core.rmem_max=16777216,"));
        assert_eq!(system.memory().found, "500 MiB of 2000 are available");
        let pages = system.large_pages();
        assert_eq!((pages.verdict, pages.found.as_str()), (Verdict::Improve, "never"));
    }

    #[test]
    fn a_machine_of_a_lab_is_fine() {
        let (_folder, system) = system(&[
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n"),
            ("proc/sys/net/core/rmem_max", "33554432\n"),
            ("proc/meminfo", "MemTotal: 32768000 kB\nMemAvailable: 16384000 kB\n"),
            ("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never\n"),
        ]);
        let buffer = system.buffer("receive buffer", "rmem_max", 16 << 20);
        for finding in
            [system.governor(), system.clock_source(25.0), buffer, system.memory(), system.large_pages()]
        {
            assert_eq!((finding.verdict, finding.remedy), (Verdict::Fine, None), "{}", finding.check);
        }
        assert_eq!(processors(1).verdict, Verdict::Improve);
    }

    #[test]
    fn what_a_system_does_not_show_is_unknown() {
        let (_folder, system) = system(&[("proc/meminfo", "nothing\n"), ("proc/sys/net/core/wmem_max", "x")]);
        let buffer = system.buffer("send buffer", "wmem_max", 1);
        for finding in
            [system.governor(), system.clock_source(9.0), buffer, system.memory(), system.large_pages()]
        {
            assert_eq!(finding.verdict, Verdict::Unknown, "{}", finding.check);
        }
    }

    #[test]
    fn a_refused_right_names_its_remedy() {
        let refused = Right { asked: "pacer_priority", granted: false, reason: Some("EPERM".to_owned()) };
        let finding = priority(Some(refused.clone()));
        assert!(finding.found.ends_with("EPERM") && finding.remedy.unwrap().contains("LimitRTPRIO=50"));
        assert!(locked_memory(Some(refused)).remedy.unwrap().contains("LimitMEMLOCK"));
        let granted = Right { asked: "pacer_priority", granted: true, reason: None };
        assert_eq!(priority(Some(granted)).verdict, Verdict::Fine);
        assert_eq!(priority(None).verdict, Verdict::Unknown);
    }
}
