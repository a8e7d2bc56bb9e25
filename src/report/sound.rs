//! Sounds of a run in the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};

use super::table;
use crate::result::{MicrophoneLevel, MicrophoneReport, RunResult};
use crate::tables::{self, Cell, Column, Table, dash};
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

/// Sources measured by the array next to their radiated sound.
fn by_source(report: &MicrophoneReport) -> Markup {
    let [a, b, c] = report.box_m;
    let rows = report.sources.iter().map(|source| {
        let cells = [
            source.source.clone(),
            source.how.to_string(),
            format!("{:.0} to {:.0}", source.range_hz[0], source.range_hz[1]),
            tables::decibels(source.lwa_db),
            tables::decibels(source.true_lwa_db),
            tables::fixed(source.synthetic_from_hz, 0),
        ];
        cells.map(Cell::from).to_vec()
    });
    let numbers = ["range, Hz", "by microphones, dB", "radiated, dB", "synthetic above, Hz"].map(Column::number);
    let columns = ["source", "sound carried by"]
        .map(Column::words)
        .into_iter()
        .chain(numbers);
    let by_source = Table::new(columns, rows);
    html! {
        p {
            "Nine microphones by EN 12549 and ISO 3744 on a parallelepiped of half sides "
                (format!("{a:.2} and {b:.2} m"))
            " and height " (format!("{c:.2} m")) " above the reflecting plane. Compare a measurement with the level \
                at the \
             microphones, not with the true power: nine positions do not cover all directions of a source."
        }
        (table::markup(&by_source))
        p.quiet {
            "Above the frequency in the last column the phases of a source are not the model's: its sound there is \
             noise with the \
             energy and the power over time of the model, or phases are chosen. Jets are random, and their sound is \
             one draw."
        }
    }
}

/// The three levels of all sources together, and the reasons why they differ.
fn totals(result: &RunResult) -> Markup {
    let array = &result.microphones.total;
    let step = array.lwa_db.zip(array.true_lwa_db);
    let step = dash(step, |(measured, radiated)| wording::change(measured - radiated));
    let because = "nine positions do not cover all directions; energies of sources add";
    let radiated = "radiated, all bands of the ranking: the total of this report";
    let level = |level| Cell::from(tables::decibels(level)).strong();
    let rows = [
        vec![radiated.into(), level(result.total.lwa_db)],
        vec![
            "by the nine microphones".into(),
            level(array.lwa_db),
            step.into(),
            because.into(),
        ],
    ];
    let columns = [
        Column::words("level"),
        Column::number("L_{WA,1s} dB"),
        Column::number("step dB"),
        Column::words("because"),
    ];
    html! {
        h3 { "The level of all sources together" }
        (table::markup(&Table::new(columns, rows)))
        p.quiet { "The level by the microphones includes K1 " (tables::decibels(array.k1_db)) " dB and K2 "
            (format!("{:.1} dB", array.k2_db)) "." }
    }
}

/// A-weighted exposure levels for each microphone.
fn levels(report: &MicrophoneReport) -> Markup {
    let sources = report
        .sources
        .iter()
        .map(|source| (source.source.as_str(), source.levels.as_slice()));
    let sources: Vec<(&str, &[MicrophoneLevel])> = sources.chain([("all", report.total.levels.as_slice())]).collect();
    let columns = [Column::number("microphone"), Column::words("x, y, z")];
    let of_source = sources
        .iter()
        .map(|(name, _)| Column::number(format!("{name}, L_{{AE}} dB")));
    let rows = report.positions_m.iter().enumerate().map(|(number, [x, y, z])| {
        let place = [(number + 1).to_string(), format!("{x:.2}, {y:.2}, {z:.2} m")];
        let level = |levels: &[MicrophoneLevel]| tables::decibels(levels.get(number).and_then(|level| level.lae_db));
        let levels = sources.iter().map(|(_, levels)| level(levels));
        place.into_iter().chain(levels).map(Cell::from).collect()
    });
    html! {
        h3 { "Exposure levels at each microphone" }
        (table::markup(&Table::new(columns.into_iter().chain(of_source), rows)))
    }
}

/// A player for each recording, and one that switches between two of them in a synchronous loop; empty without
/// recordings.
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
