//! The page, its script and its style, embedded in the program. Nothing else is ever served.

/// Parts of the page: name, type, content.
const PARTS: [(&str, &str, &str); 19] = [
    ("", HTML, include_str!("page/index.html")),
    ("style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("panels.css", "text/css; charset=utf-8", include_str!("page/panels.css")),
    ("icon.svg", "image/svg+xml", include_str!("page/icon.svg")),
    ("main.js", SCRIPT, include_str!("page/main.js")),
    ("socket.js", SCRIPT, include_str!("page/socket.js")),
    ("frames.js", SCRIPT, include_str!("page/frames.js")),
    ("format.js", SCRIPT, include_str!("page/format.js")),
    ("plot.js", SCRIPT, include_str!("page/plot.js")),
    ("colours.js", SCRIPT, include_str!("page/colours.js")),
    ("health.js", SCRIPT, include_str!("page/health.js")),
    ("ranges.js", SCRIPT, include_str!("page/ranges.js")),
    ("doppler.js", SCRIPT, include_str!("page/doppler.js")),
    ("ppi.js", SCRIPT, include_str!("page/ppi.js")),
    ("plan.js", SCRIPT, include_str!("page/plan.js")),
    ("errors.js", SCRIPT, include_str!("page/errors.js")),
    ("control.js", SCRIPT, include_str!("page/control.js")),
    ("save.js", SCRIPT, include_str!("page/save.js")),
    ("keys.js", SCRIPT, include_str!("page/keys.js")),
];

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Type and content of a part of the page.
pub fn part(name: &str) -> Option<(&'static str, &'static str)> {
    PARTS.iter().find(|(known, ..)| *known == name).map(|(_, kind, content)| (*kind, *content))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every script and style that a part names is one of the parts, and nothing comes from elsewhere.
    #[test]
    fn the_page_needs_nothing_else() {
        let mut named = std::collections::BTreeSet::from([String::new()]);
        for (_, _, content) in PARTS {
            for quoted in content.split(['"', '\'']) {
                let name = quoted.strip_prefix("./").unwrap_or(quoted);
                let is_part =
                    [".js", ".css", ".svg"].iter().any(|end| name.ends_with(end)) && !name.contains(' ');
                if is_part {
                    assert!(part(name).is_some(), "{name} is no part of the page");
                    named.insert(name.to_owned());
                }
            }
            let own = content.replace("http://www.w3.org/", "");
            assert!(!own.contains("http://") && !own.contains("https://"), "something comes from elsewhere");
        }
        let all: std::collections::BTreeSet<String> =
            PARTS.iter().map(|(name, ..)| (*name).to_owned()).collect();
        assert_eq!(named, all, "parts that nothing names");
        assert!(part("../mod.rs").is_none() && part("/etc/passwd").is_none());
    }
}
