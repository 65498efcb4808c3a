//! Elements of XML, one inside the other.

use std::io;

use glam::DVec3;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// XML under way.
pub(super) struct Xml(Writer<Vec<u8>>);

impl Xml {
    /// Begins a document.
    pub fn new() -> io::Result<Self> {
        let mut writer = Writer::new(Vec::new());
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        Ok(Self(writer))
    }

    /// The document.
    pub fn into_bytes(self) -> Vec<u8> {
        self.0.into_inner()
    }

    /// An element with others inside.
    pub fn within(&mut self, name: &str, fill: impl FnOnce(&mut Self) -> io::Result<()>) -> io::Result<()> {
        self.with(name, &[], fill)
    }

    /// The same with attributes.
    pub fn with(
        &mut self,
        name: &str,
        attributes: &[(&str, &str)],
        fill: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> io::Result<()> {
        let start = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.0.write_event(Event::Start(start))?;
        fill(self)?;
        self.0.write_event(Event::End(BytesEnd::new(name)))
    }

    /// An element that holds a text; what XML cannot hold becomes a question mark.
    pub fn text(&mut self, name: &str, text: impl ToString) -> io::Result<()> {
        self.text_with(name, &[], text)
    }

    /// The same with attributes.
    pub fn text_with(
        &mut self,
        name: &str,
        attributes: &[(&str, &str)],
        text: impl ToString,
    ) -> io::Result<()> {
        let legal = |c: char| if c.is_control() || ('\u{fffe}'..='\u{ffff}').contains(&c) { '?' } else { c };
        let text: String = text.to_string().chars().map(legal).collect();
        self.with(name, attributes, |xml| xml.0.write_event(Event::Text(BytesText::new(&text))))
    }

    /// A number, in as many digits as it has.
    pub fn real(&mut self, name: &str, value: f64) -> io::Result<()> {
        self.text(name, format!("{value:?}"))
    }

    /// A vector.
    pub fn vector(&mut self, name: &str, value: DVec3) -> io::Result<()> {
        self.within(name, |xml| {
            xml.real("X", value.x)?;
            xml.real("Y", value.y)?;
            xml.real("Z", value.z)
        })
    }

    /// A point of the image area.
    pub fn point(&mut self, name: &str, attributes: &[(&str, &str)], [x, y]: [f64; 2]) -> io::Result<()> {
        self.with(name, attributes, |xml| {
            xml.real("X", x)?;
            xml.real("Y", y)
        })
    }

    /// A matrix.
    pub fn matrix<const N: usize>(&mut self, name: &str, values: &[[f64; N]; N]) -> io::Result<()> {
        let size = N.to_string();
        self.with(name, &[("size1", size.as_str()), ("size2", size.as_str())], |xml| {
            for (row, values) in (1..).zip(values) {
                for (column, value) in (1..).zip(values).filter(|(_, value)| **value != 0.0) {
                    let [row, column] = [row, column].map(|n: usize| n.to_string());
                    let place = [("index1", row.as_str()), ("index2", column.as_str())];
                    xml.text_with("Entry", &place, format!("{value:?}"))?;
                }
            }
            Ok(())
        })
    }
}
