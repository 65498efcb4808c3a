//! Numbers and words of a foreign document: faults and what is left out, all of them, with their lines.

use super::tree::Element;

/// What reading a document brings to light.
#[derive(Default)]
pub(super) struct Reading {
    /// What is wrong with it.
    pub faults: Vec<String>,
    /// What has no place in a scenario, or is approximated.
    pub left_out: Vec<String>,
}

impl Reading {
    pub fn fault(&mut self, at: &Element, what: impl std::fmt::Display) {
        self.faults.push(format!("line {}: <{}>: {what}", at.line, at.name));
    }

    pub fn leave_out(&mut self, at: &Element, what: impl std::fmt::Display) {
        self.left_out.push(format!("line {}: {what}", at.line));
    }

    /// The number in a child, which must be there and within a range.
    pub fn number(&mut self, of: &Element, name: &str, range: [f64; 2]) -> f64 {
        self.optional(of, name, range).unwrap_or_else(|| {
            if of.child(name).is_none() {
                self.fault(of, format_args!("<{name}> is missing; allowed: {}", words(range)));
            }
            range[0].max(1.0).min(range[1])
        })
    }

    /// The same where it may be missing.
    pub fn optional(&mut self, of: &Element, name: &str, range: [f64; 2]) -> Option<f64> {
        let child = of.child(name)?;
        let value = child.text().parse().ok().filter(|value: &f64| (range[0]..=range[1]).contains(value));
        if value.is_none() {
            self.fault(child, format_args!("'{}' is not allowed; allowed: {}", child.text(), words(range)));
        }
        value
    }

    /// The element of a name that an attribute refers to.
    pub fn named<'a>(&mut self, of: &Element, attribute: &str, all: &[&'a Element]) -> Option<&'a Element> {
        let name = of.attribute(attribute).unwrap_or_default();
        let found = all.iter().copied().find(|own| own.attribute("name") == Some(name));
        if found.is_none() {
            let known: Vec<&str> = all.iter().filter_map(|own| own.attribute("name")).collect();
            self.fault(of, format_args!("{attribute} '{name}' is not known; allowed: {}", known.join(", ")));
        }
        found
    }
}

fn words([least, most]: [f64; 2]) -> String {
    format!("a number from {least:e} to {most:e}")
}

/// Names of a scenario, each given once.
#[derive(Default)]
pub(super) struct Names(Vec<String>);

impl Names {
    /// A name like one of the document.
    pub fn give(&mut self, of: &Element) -> String {
        let wanted = of.attribute("name").unwrap_or(&of.name);
        let legal = |c: char| if c.is_ascii_alphanumeric() || "_-.".contains(c) { c } else { '_' };
        let base: String = wanted.trim_start_matches('.').chars().map(legal).take(56).collect();
        let base = if base.is_empty() { of.name.clone() } else { base };
        let mut name = base.clone();
        let mut again = 2;
        while self.0.contains(&name) {
            name = format!("{base}-{again}");
            again += 1;
        }
        self.0.push(name.clone());
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_legal_and_each_is_given_once() {
        let root = Element::parse("<a><b name='Oslo ø 1'/><b name='Oslo ø 1'/><b/></a>".as_bytes()).unwrap();
        let mut names = Names::default();
        let given: Vec<String> = root.all("b").map(|b| names.give(b)).collect();
        assert_eq!(given, ["Oslo___1", "Oslo___1-2", "b"]);
    }
}
