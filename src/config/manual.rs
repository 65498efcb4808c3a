//! The manual of scenario keys, written from [`keys`](super::keys).

use std::fmt::Write as _;

use super::keys::TABLES;

/// `docs/scenario.md`: every key with unit, default and range.
///
/// ```
/// let page = nereus::config::manual::page();
/// assert!(page.contains("| `carrier_hz` | required | a number from 1e6 to 1e12 Hz |"));
/// ```
pub fn page() -> String {
    let mut page = String::from(
        "# Scenario files\n\n\
         A scenario is a TOML file. Units are part of the keys; angles are in degrees; unknown keys are refused. This page is\n\
         written by `nereus new keys` from the list that the reader itself follows.\n\n\
         Files to be read are looked for beside the scenario file; files to be made are relative to the working directory.\n\
         Any key can be set on the command line: `--set radar.prf_hz=500`, `--set target.0.rcs_m2=10`.\n\
         In the place of a number `+` appends an entry: `--set 'sink.+={ kind = \"plain\", path = \"pulses\" }'`.\n\n\
         `position_m` of a platform is East, North, up in the scene frame (the plane that touches the sea at the origin);\n\
         `position_m` of a target or an aim point is East, North, height above the sea. On a flat earth they are the same.\n",
    );
    for table in TABLES {
        // Writing to a String cannot fail.
        let _ = writeln!(page, "\n## {}\n\n{}\n", table.heading, table.about);
        page.push_str("| key | default | allowed | meaning |\n| --- | --- | --- | --- |\n");
        for key in table.keys {
            let (absent, allowed) = (key.absent.text(), key.kind.allowed());
            let cell = |text: &str| text.replace('|', "\\|");
            let _ = writeln!(
                page,
                "| `{}` | {} | {} | {} |",
                key.name,
                cell(&absent),
                cell(&allowed),
                cell(key.about)
            );
        }
    }
    page
}
