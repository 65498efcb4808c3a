//! Scenarios that cost more than they hold.

use std::fs;
use std::path::Path;
use std::time::Instant;

use crate::config::parse;
use crate::rng::cases::sized;

fn seconds(text: &str) -> f64 {
    let begun = (Instant::now(), processor_s());
    let _ = parse(text, Path::new("hostile.toml"), &[]);
    match (begun.1, processor_s()) {
        (Some(from), Some(to)) => to - from,
        _ => begun.0.elapsed().as_secs_f64(),
    }
}

/// What this thread has had of a processor, s, where the system says: other work does not count.
fn processor_s() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split(' ').next()?.parse::<f64>().ok()? * 1e-9)
}

/// Before: the columns of a line were counted from its beginning for each value, 24 s.
#[test]
fn a_line_of_many_numbers_is_read_once() {
    let took = seconds(&format!("[sea]\nx = [{}]\n", "1.5,".repeat(400_000)));
    assert!(took < 5.0, "{took} s");
    // Keys of tables that come back to the beginning of the line.
    let keys = |part: &str| (0..20_000).map(|k| format!("k{k}.{part} = 1, ")).collect::<String>();
    let took = seconds(&format!("t = {{ {}{}z = 1 }}\n", keys("x"), keys("y")));
    assert!(took < 5.0, "{took} s");
}

/// Before: every name was compared with every other, and every fault with every line that could not be read.
#[test]
fn many_names_and_many_faults_are_read_once() {
    let many = sized(50_000, 20_000);
    let targets = |many: usize| (0..many).map(|n| format!("[[target]]\nname = \"t{n}\"\n")).collect();
    let lines = |many: usize| (0..many).map(|n| format!("k{n} = 1\nx{n} = = 2\n")).collect();
    let kinds: [&dyn Fn(usize) -> String; 2] = [&targets, &lines];
    for text in kinds {
        // In proportion ten times as long, were each read again a hundred times.
        let (few_s, all_s) = (seconds(&text(many / 10)), seconds(&text(many)));
        assert!(all_s < 40.0 * few_s.max(0.05), "{few_s} s, {all_s} s");
    }
}

#[test]
fn columns_count_characters() {
    let text = format!("x = \"{}\"\ny = [\"ä\", {}bad]\n", "é".repeat(300), "1, ".repeat(200));
    let faults = parse(&text, Path::new("s.toml"), &[]).unwrap_err().to_string();
    // Ten characters before the numbers, three for each.
    assert!(faults.contains("s.toml:2:611"), "{faults}");
}
