//! Sounds of a run inside the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

/// A recording that belongs to a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    /// What is heard.
    pub name: String,
    /// A whole WAV file.
    pub wav: Vec<u8>,
}

/// A player for each recording, and a switch between any two at the same moment.
pub(super) fn players(recordings: &[Recording]) -> Markup {
    html! {
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
