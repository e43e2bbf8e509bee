//! `graph`: a picture of a machine as SVG, or as text for Graphviz or Mermaid.

mod by_index;
mod dot;
mod drawing;
mod layers;
mod layout;
mod mermaid;
mod plan;
mod size;
mod svg;
mod wires;

pub use drawing::{Boxed, Drawing, Pin, Section, Signal, Thread, Wanted};

/// Format of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Input of Graphviz.
    Dot,
    /// Text for Mermaid, which the pages of code hosts show as a picture.
    Mermaid,
    /// An SVG picture.
    #[default]
    Svg,
}

impl Format {
    /// Returns the format for a file name, by its extension.
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

/// Returns the picture as text.
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
