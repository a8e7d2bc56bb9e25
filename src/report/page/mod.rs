//! The page around the sections: head, navigation, style, scripts.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::chart;
use crate::drawing;
use crate::units::Units;

const STYLE: &str = include_str!("style.css");

/// Additions to charts, scene, sounds and drawing for browsers that run scripts.
const SCRIPTS: [&str; 9] = [
    include_str!("charts.js"),
    include_str!("scene/geometry.js"),
    include_str!("scene/camera.js"),
    include_str!("scene/painter.js"),
    include_str!("scene/gestures.js"),
    include_str!("scene/modes.js"),
    include_str!("scene/scene.js"),
    include_str!("sound.js"),
    include_str!("drawing.js"),
];

/// A part of a page.
pub(super) struct Section {
    id: &'static str,
    title: &'static str,
    content: Markup,
    /// Whether it starts a new page in print.
    page: bool,
    /// Whether it is placed after the summary in print.
    appendix: bool,
}

impl Section {
    pub(super) fn new(id: &'static str, title: &'static str, content: Markup) -> Self {
        Self {
            id,
            title,
            content,
            page: false,
            appendix: false,
        }
    }

    /// Places the section on a separate page in print.
    pub(super) fn on_a_page(self) -> Self {
        Self { page: true, ..self }
    }

    /// Makes the section part of the appendix in print.
    pub(super) fn in_the_appendix(self) -> Self {
        Self { appendix: true, ..self }
    }
}

/// A page.
pub(super) struct Page {
    /// The title of the window.
    pub(super) title: String,
    /// Identity of the files of a comparison.
    pub(super) compared: Option<String>,
    /// The subject of the page.
    pub(super) heading: String,
    /// Content above all sections.
    pub(super) lead: Markup,
    pub(super) sections: Vec<Section>,
}

/// Element in the head of a page that states which files it compares.
pub(crate) fn compared_by(identity: &str) -> Markup {
    html! { meta name="compared" content=(identity); }
}

impl Page {
    /// The HTML file with its texts in these units.
    pub(super) fn html(self, units: Units) -> String {
        let first_of_appendix = self.sections.iter().position(|section| section.appendix);
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content={ "nailnoise " (env!("CARGO_PKG_VERSION")) };
                    // Browsers request an icon unless the page provides one.
                    link rel="icon" href="data:,";
                    @if let Some(identity) = &self.compared { (compared_by(identity)) }
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) (PreEscaped(drawing::STYLE)) (PreEscaped(chart::colours())) }
                }
                body {
                    header {
                        p.brand { "nailnoise" }
                        h1 { (self.heading) }
                        (self.lead)
                    }
                    nav aria-label="Sections" { @for section in &self.sections { a href={ "#"
                        (section.id) } { (section.title) } } }
                    main {
                        @for (place, section) in self.sections.iter().enumerate() {
                            @if Some(place) == first_of_appendix { p.appendix-begins { "Appendix" } }
                            section.page[section.page] id=(section.id) {
                                h2 { (section.title) }
                                (section.content)
                            }
                        }
                    }
                    footer { "nailnoise " (env!("CARGO_PKG_VERSION")) ". This file needs no network." }
                    @for script in SCRIPTS { script { (PreEscaped("\"use strict\";\n")) (PreEscaped(script)) } }
                }
            }
        }
        .into_string();
        units.page(page)
    }
}
