//! Sounds of a run inside the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use crate::result::{MicrophoneLevel, MicrophoneReport, RunResult};
use crate::wording;

/// A recording that belongs to a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    /// Name of the sound.
    pub name: String,
    /// A complete WAV file.
    pub wav: Vec<u8>,
}

/// Measured values of the microphones next to the radiated ones.
pub(super) fn measured(result: &RunResult) -> Markup {
    html! { (by_source(&result.microphones)) (totals(result)) (levels(&result.microphones)) }
}

/// Sources by the array next to their radiated sound.
fn by_source(report: &MicrophoneReport) -> Markup {
    let [a, b, c] = report.box_m;
    html! {
        p {
            "Nine microphones by EN 12549 and ISO 3744 on a parallelepiped of half sides "
                (format!("{a:.2} and {b:.2} m"))
            " and height " (format!("{c:.2} m")) " above the reflecting plane. Compare a measurement with the level \
                at the \
             microphones, not with the true power: nine positions do not cover all directions of a source."
        }
        div.scroll { table {
            thead { tr { th { "source" } th { "sound carried by" } th.n { "range, Hz" } th.n { "by microphones, dB" }
                th.n { "radiated, dB" } th.n { "synthetic above, Hz" } } }
            tbody { @for source in &report.sources { tr {
                th scope="row" { (source.source) }
                td { (source.how) }
                td.n { (format!("{:.0} to {:.0}", source.range_hz[0], source.range_hz[1])) }
                td.n { (decibels(source.lwa_db)) }
                td.n { (decibels(source.true_lwa_db)) }
                td.n { (source.synthetic_from_hz.map_or_else(|| "\u{2013}".to_owned(), |hz| format!("{hz:.0}"))) }
            } } }
        } }
        p.quiet {
            "Above the frequency in the last column the phases of a source are not the model's: its sound there is \
             noise with the \
             energy and the power over time of the model, or phases are chosen. Jets are random, and their sound is \
             one draw."
        }
    }
}

/// The three levels of all sources together, and why they differ.
fn totals(result: &RunResult) -> Markup {
    let array = &result.microphones.total;
    let step = |from: Option<f64>, to: Option<f64>| {
        to.zip(from).map_or_else(
            || "\u{2013}".to_owned(),
            |(to, from)| wording::change(to - from).replace('-', "\u{2212}"),
        )
    };
    let rows = [
        (
            "radiated, all bands of the ranking: the total of this report",
            result.total.lwa_db,
            String::new(),
            "",
        ),
        (
            "by the nine microphones",
            array.lwa_db,
            step(array.true_lwa_db, array.lwa_db),
            "nine positions do not cover all directions; energies of sources add",
        ),
    ];
    html! {
        h3 { "The level of all sources together" }
        div.scroll { table {
            thead { tr { th { "level" } th.n { "L" sub { "WA,1s" } " dB" } th.n { "step, dB" } th { "because" } } }
            tbody { @for (what, level, step, why) in rows { tr {
                th scope="row" { (what) } td.n { b { (decibels(level)) } } td.n { (step) } td { (why) }
            } } }
        } }
        p.quiet { "The level by the microphones holds K1 " (decibels(array.k1_db)) " dB and K2 "
            (format!("{:.1} dB", array.k2_db)) "." }
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
        h3 { "Exposure levels at each microphone" }
        div.scroll { table {
            thead { tr {
                th.n { "microphone" } th { "x, y, z, m" }
                @for (name, _) in &columns { th.n { (name) ", L" sub { "AE" } " dB" } }
            } }
            tbody { @for (number, [x, y, z]) in report.positions_m.iter().enumerate() { tr {
                th.n scope="row" { (number + 1) }
                td { (format!("{x:.2}, {y:.2}, {z:.2}")) }
                @for (_, levels) in &columns { td.n { (decibels(levels.get(number).and_then(|level| level.lae_db))) } }
            } } }
        } }
    }
}

fn decibels(level: Option<f64>) -> String {
    level.map_or_else(|| "\u{2013}".to_owned(), |level| format!("{level:.1}"))
}

/// A player for each recording, and two of them in a loop and in step; nothing without recordings.
pub(super) fn players(recordings: &[Recording]) -> Markup {
    html! { @if !recordings.is_empty() {
        p.quiet {
            "One shot, 1 m in front of the device. All recordings have one scale: what sounds louder is louder. A and \
             B run in a \
             loop and in step; the switch changes which one is heard. Jets are random noise, drawn once."
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
            button type="button" data-ab="play" { "play A and B in a loop" }
            button type="button" data-ab="switch" disabled { "switch" }
            output data-ab="now" {}
        }
        @for recording in recordings {
            figure.recording data-name=(recording.name) {
                figcaption { (recording.name) " " span.quiet.duration { (duration(&recording.wav)) } }
                audio controls preload="auto" aria-label=(recording.name)
                    src={ "data:audio/wav;base64," (STANDARD.encode(&recording.wav)) } {}
            }
        }
    } }
}

/// Duration of a recording, if it can be read.
fn duration(wav: &[u8]) -> String {
    let reader = hound::WavReader::new(wav).ok();
    reader.map_or_else(String::new, |reader| {
        format!(
            "{:.2} s",
            f64::from(reader.duration()) / f64::from(reader.spec().sample_rate)
        )
    })
}
