//! An XML document in memory, as far as scenarios of other programs need it.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Elements within elements, at most.
const DEEPEST: usize = 64;

/// An element.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    /// Without prefix.
    pub name: String,
    /// Where it begins.
    pub line: usize,
    pub children: Vec<Element>,
    attributes: Vec<(String, String)>,
    text: String,
}

/// Why a document cannot be read.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct NoDocument {
    pub line: usize,
    pub error: String,
}

impl Element {
    /// The root of a document.
    ///
    /// # Errors
    /// What is no XML.
    pub fn parse(bytes: &[u8]) -> Result<Self, NoDocument> {
        let line_at = |at: u64| {
            let at = usize::try_from(at).unwrap_or(usize::MAX).min(bytes.len());
            1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count()
        };
        let mut reader = Reader::from_reader(bytes);
        reader.config_mut().expand_empty_elements = true;
        // What is open, from the document inwards.
        let mut open = vec![Self::default()];
        loop {
            let line = line_at(reader.buffer_position());
            let fault = |error: String| NoDocument { line, error };
            match reader.read_event() {
                Ok(Event::Start(start)) => {
                    if open.len() > DEEPEST {
                        return Err(fault(format!("more than {DEEPEST} elements within each other")));
                    }
                    open.push(Self::begun(&start, line).map_err(fault)?);
                }
                Ok(Event::Text(part)) => {
                    if let Some(inner) = open.last_mut() {
                        inner.text.push_str(&part.xml10_content());
                    }
                }
                Ok(Event::End(_)) => {
                    if let (Some(inner), true) = (open.pop(), !open.is_empty()) {
                        open.last_mut().into_iter().for_each(|outer| outer.children.push(inner.clone()));
                    }
                }
                Ok(Event::Eof) => {
                    let root =
                        open.into_iter().next().and_then(|document| document.children.into_iter().next());
                    return root.ok_or_else(|| fault("it ends before its first element does".to_owned()));
                }
                Ok(_) => {}
                Err(error) => {
                    return Err(NoDocument {
                        line: line_at(reader.error_position()),
                        error: error.to_string(),
                    });
                }
            }
        }
    }

    fn begun(start: &BytesStart<'_>, line: usize) -> Result<Self, String> {
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| error.to_string())?;
            attributes.push((attribute.key.as_ref().to_owned(), attribute.value.into_owned()));
        }
        Ok(Self { name: start.local_name().as_ref().to_owned(), line, attributes, ..Self::default() })
    }

    /// An attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.trim())
    }

    /// Its text, without blanks about it.
    pub fn text(&self) -> &str {
        self.text.trim()
    }

    /// The first child of a name.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The children of a name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documents_are_read_and_faults_have_their_line() {
        let text =
            b"<?xml version='1.0'?>\n<!DOCTYPE a SYSTEM 'a.dtd'>\n<a n='1'>\n <b> x </b><c/>\n<b>y</b></a>";
        let root = Element::parse(text).unwrap();
        assert_eq!((root.name.as_str(), root.line, root.attribute("n")), ("a", 3, Some("1")));
        assert_eq!(root.all("b").map(Element::text).collect::<Vec<_>>(), ["x", "y"]);
        assert_eq!(root.child("c").map(|c| c.line), Some(4));
        assert_eq!(Element::parse(b"<a>\n<b></a>").unwrap_err().line, 2);
        assert!(Element::parse(b"").is_err() && Element::parse(b"<a>").is_err());
        assert!(Element::parse("<a>".repeat(100).as_bytes()).unwrap_err().error.contains("64"));
    }
}
