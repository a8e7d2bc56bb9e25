//! Sounds of a run inside the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use crate::result::{MicrophoneLevel, MicrophoneReport};

/// A recording that belongs to a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    /// What is heard.
    pub name: String,
    /// A whole WAV file.
    pub wav: Vec<u8>,
}

/// What the microphones measure, and what is heard at one of them.
pub(super) fn section(report: &MicrophoneReport, recordings: &[Recording]) -> Markup {
    html! {
        @if !recordings.is_empty() { (players(recordings)) }
        (measured(report))
        (levels(report))
    }
}

/// Sources by the array beside what they radiate.
fn measured(report: &MicrophoneReport) -> Markup {
    let [a, b, c] = report.box_m;
    let total = &report.total;
    html! {
        p {
            "Nine microphones by EN 12549 and ISO 3744 on a parallelepiped of half sides " (format!("{a:.2} and {b:.2} m"))
            " and height " (format!("{c:.2} m")) " above the reflecting plane. Compare a measurement with the level at the \
             microphones, not with the true power: nine positions do not cover all directions of a source."
        }
        div.scroll { table {
            thead { tr { @for head in ["source", "sound carried by", "range (Hz)", "L_WA by microphones (dB)", "radiated (dB)"] { th { (head) } } } }
            tbody {
                @for source in &report.sources { tr {
                    td { (source.source) }
                    td { (source.how) }
                    td.n { (format!("{:.0} to {:.0}", source.range_hz[0], source.range_hz[1])) }
                    td.n { (decibels(source.lwa_db)) }
                    td.n { (decibels(source.true_lwa_db)) }
                } }
                tr {
                    td { "all" }
                    td { "K1 " (decibels(total.k1_db)) " dB, K2 " (format!("{:.1} dB", total.k2_db)) }
                    td {}
                    td.n { (decibels(total.lwa_db)) }
                    td.n { (decibels(total.true_lwa_db)) }
                }
            }
        } }
    }
}

/// A-weighted exposure levels, microphone by microphone.
fn levels(report: &MicrophoneReport) -> Markup {
    let columns: Vec<(&str, &[MicrophoneLevel])> = report
        .sources
        .iter()
        .map(|source| (source.source.as_str(), source.levels.as_slice()))
        .chain([("all", report.total.levels.as_slice())])
        .collect();
    html! {
        div.scroll { table {
            thead { tr {
                th { "microphone" } th { "x, y, z (m)" }
                @for (name, _) in &columns { th { (name) " L_AE (dB)" } }
            } }
            tbody { @for (number, [x, y, z]) in report.positions_m.iter().enumerate() { tr {
                td.n { (number + 1) }
                td { (format!("{x:.2}, {y:.2}, {z:.2}")) }
                @for (_, levels) in &columns { td.n { (decibels(levels.get(number).and_then(|level| level.lae_db))) } }
            } } }
        } }
    }
}

fn decibels(level: Option<f64>) -> String {
    level.map_or_else(|| "\u{2013}".to_owned(), |level| format!("{level:.1}"))
}

/// A player for each recording, and a switch between any two at the same moment.
fn players(recordings: &[Recording]) -> Markup {
    html! {
        p.quiet {
            "One shot, 1 m in front of the device. All recordings have one scale: what sounds louder is louder. A/B switches \
             between two while they play. Jets are random noise, drawn once."
        }
        div.ab {
            @for (letter, chosen) in [("A", 0), ("B", 1)] {
                label {
                    (letter) " "
                    select data-ab=(letter) { @for (index, recording) in recordings.iter().enumerate() {
                        option value=(index) selected[index == chosen.min(recordings.len() - 1)] { (recording.name) }
                    } }
                }
            }
            button type="button" data-ab="switch" { "play A/B" }
            output data-ab="now" {}
        }
        @for recording in recordings {
            figure.recording {
                figcaption { (recording.name) }
                audio controls preload="auto" src={ "data:audio/wav;base64," (STANDARD.encode(&recording.wav)) } {}
            }
        }
    }
}
