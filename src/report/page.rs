//! The page around the sections: head, navigation, style, scripts.

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("report.js");

/// A part of a page.
pub(super) struct Section {
    id: &'static str,
    title: &'static str,
    content: Markup,
}

impl Section {
    pub(super) fn new(id: &'static str, title: &'static str, content: Markup) -> Self {
        Self { id, title, content }
    }
}

/// A page.
pub(super) struct Page {
    /// What the window is called.
    pub(super) title: String,
    /// Which files a comparison is of.
    pub(super) compared: Option<String>,
    /// What it is of.
    pub(super) heading: String,
    /// What stands before all sections.
    pub(super) lead: Markup,
    pub(super) sections: Vec<Section>,
}

/// What the head of a page says of the files that it compares.
pub(crate) fn compared_by(identity: &str) -> Markup {
    html! { meta name="compared" content=(identity); }
}

impl Page {
    /// The file.
    pub(super) fn html(self) -> String {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="generator" content={ "nailnoise " (env!("CARGO_PKG_VERSION")) };
                    // A browser asks for an icon unless it is given one.
                    link rel="icon" href="data:,";
                    @if let Some(identity) = &self.compared { (compared_by(identity)) }
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    header {
                        p.brand { "nailnoise" }
                        h1 { (self.heading) }
                        (self.lead)
                    }
                    nav { @for section in &self.sections { a href={ "#" (section.id) } { (section.title) } } }
                    main {
                        @for section in &self.sections {
                            section id=(section.id) {
                                h2 { (section.title) }
                                (section.content)
                            }
                        }
                    }
                    footer { "nailnoise " (env!("CARGO_PKG_VERSION")) ". This file needs no network." }
                    (plotly())
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        }
        .into_string()
    }
}

/// The script of plotly.js (MIT licence) as the plotly crate carries it, without the formula typesetter that follows it there.
fn plotly() -> PreEscaped<String> {
    let sources = plotly::Plot::offline_js_sources();
    let end = "</script>";
    PreEscaped(
        sources
            .split_once(end)
            .map_or(sources.clone(), |(script, _)| format!("{script}{end}")),
    )
}
