//! Sounds of a run inside the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::tables::decibels;
use crate::result::MicrophoneReport;

/// A recording that belongs to a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    /// What is heard.
    pub name: String,
    /// A whole WAV file.
    pub wav: Vec<u8>,
}

/// Levels at the microphones.
fn levels(report: &MicrophoneReport) -> Markup {
    let [from, to] = report.range_hz;
    html! {
        p.quiet {
            "What microphones around the device hear of workpiece and support, " (format!("{from:.0} to {to:.0} Hz"))
            "; a level of 0 dB is 20 \u{b5}Pa over 1 s. From them the sound energy would be "
            (decibels(report.lwa_db)) " dB, and is " (decibels(report.true_lwa_db)) " dB (L" sub { "WA,1s" } ")."
        }
        div.scroll { table {
            thead { tr { th.n { "microphone" } th.n { "x, y, z above the floor in m" } th.n { "L" sub { "AE" } " dB" } th.n { "L" sub { "E" } " dB" } th.n { "peak Pa" } } }
            tbody { @for (number, m) in report.positions.iter().enumerate() { tr {
                td.n { (number + 1) }
                td.n { (m.position_m.map(|x| format!("{x:.2}")).join(", ")) }
                td.n { (decibels(m.lae_db)) } td.n { (decibels(m.le_db)) } td.n { (format!("{:.3}", m.peak_pa)) }
            } } }
        } }
    }
}

/// A player for each recording, and a switch between any two at the same moment.
pub(super) fn players(recordings: &[Recording], report: Option<&MicrophoneReport>) -> Markup {
    html! {
        @if let Some(report) = report { (levels(report)) }
        p.quiet { "All recordings have one scale: what sounds louder is louder. A/B switches between two while they play." }
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
