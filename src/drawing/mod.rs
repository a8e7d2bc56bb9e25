//! The drawing of a tool: a section with the design's dimensions, with every key at the length that it gives.
//!
//! [`Drawing::new`] turns a design into views: shapes and annotated dimensions, in metres and independent of any page.
//! [`Sheet`] chooses a scale for each view and places the labels; `svg` renders it. Parts for which the design has no
//! key (thickness of the piston, height of the head valve, trigger valve) are schematic, see [`layout`].

mod apart;
mod label;
pub mod layout;
mod mechanism;
mod misfits;
mod network;
mod quantity_views;
mod shape;
mod sheet;
mod standing;
mod surroundings;
mod svg;
#[cfg(test)]
mod tests;
mod tool_views;

use std::collections::BTreeMap;

pub use label::Label;
use layout::Layout;
pub use misfits::Misfit;
pub(crate) use network::svg as network;
pub(crate) use shape::rectangle;
pub use shape::{
    Annotation, Bounds, Chamber, Line, LineStyle, Mark, Material, Outline, Part, Point, Side, View, corners,
};
pub use sheet::{Placed, Rectangle, Sheet};
pub use standing::Standing;
pub use surroundings::housing_parts;

use crate::design::Design;

/// Style of the drawing, both in its own file and on a page.
pub(crate) const STYLE: &str = include_str!("style.css");

/// A drawing of a design.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Name of the design.
    pub name: String,
    /// The views, with the section first.
    pub views: Vec<View>,
    /// The texts of all keys of the design.
    pub labels: BTreeMap<String, Label>,
    /// Keys that are inconsistent in the drawing.
    pub misfits: Vec<Misfit>,
}

impl Drawing {
    /// Draws a design.
    pub fn new(design: &Design) -> Self {
        let layout = Layout::new(design);
        Self {
            name: design.name().to_owned(),
            views: vec![
                tool_views::section(design, &layout),
                tool_views::head_valve(design, &layout),
                tool_views::nose(design, &layout),
                quantity_views::holes(design),
                quantity_views::volumes(design),
                surroundings::support(design),
                surroundings::housing(design),
            ],
            labels: label::labels(design),
            misfits: misfits::misfits(design, &layout),
        }
    }

    /// The labels of the keys that the views show, each once, in the order of the views.
    pub fn shown(&self) -> Vec<&Label> {
        let mut shown: Vec<&Label> = Vec::new();
        for annotation in self.views.iter().flat_map(|view| &view.annotations) {
            if let Some(label) = self.labels.get(annotation.key)
                && !shown.iter().any(|other| other.key == label.key)
            {
                shown.push(label);
            }
        }
        shown
    }

    /// Whether a value shown comes from a base.
    pub fn is_based(&self) -> bool {
        self.shown().iter().any(|label| label.inherited)
    }

    /// The views, each placed on a sheet.
    pub fn sheets(&self) -> Vec<Sheet<'_>> {
        self.views.iter().map(|view| Sheet::new(view, &self.labels)).collect()
    }
}
