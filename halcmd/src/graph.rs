//! `graph`: a machine as a picture, for Graphviz, for Mermaid, or by itself.

mod dot;
mod drawing;
mod layers;
mod layout;
mod mermaid;
mod plan;
mod row;
mod size;
mod svg;
mod wires;

pub use drawing::{Boxed, Drawing, Pin, Section, Signal, Thread, Wanted};

/// How the picture is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// For Graphviz.
    Dot,
    /// For Mermaid, as in the pages of code hosts.
    Mermaid,
    /// A picture.
    #[default]
    Svg,
}

impl Format {
    /// What a file of this name holds.
    #[must_use]
    pub fn of(file: &str) -> Option<Self> {
        match file.rsplit_once('.')?.1 {
            "dot" | "gv" => Some(Self::Dot),
            "mmd" | "mermaid" => Some(Self::Mermaid),
            "svg" => Some(Self::Svg),
            _ => None,
        }
    }
}

/// The picture as text.
#[must_use]
pub fn text(drawing: &Drawing, format: Format) -> String {
    match format {
        Format::Dot => dot::dot(drawing),
        Format::Mermaid => mermaid::mermaid(drawing),
        Format::Svg => svg::svg(drawing),
    }
}

#[cfg(test)]
mod tests;
