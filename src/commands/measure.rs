//! `nailnoise measure`: levels of the sources from the recordings of a wrapping test.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::{Shown, Threads, given_or_named, message, print_json, table};
use super::{Status, progress::noted};
use crate::atomic_write::AtomicWrite;
use crate::error::Error;
use crate::measurement::processing::{CorrectedShot, Measured, process_recordings};
use crate::measurement::result::Processing;
use crate::measurement::subtraction::Reading;
use crate::measurement::{Manifest, arrangement::Arrangement};
use crate::tables::measurement as tables;
use crate::{figures, output, report};

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "measurement.json";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise measure test.toml" => "levels of the sources from the recordings that the manifest names",
    "nailnoise measure test.toml --figures --out out/march" => "charts as SVG, too, in a folder of its own",
))]
pub(super) struct Arguments {
    /// Manifest of the recordings (TOML)
    manifest: PathBuf,
    /// Which lines the subtraction of the residual sets to zero
    #[arg(long, value_parser = reading(), default_value = "margin")]
    reading: Reading,
    /// Subtract the residual of the same repeat instead of the mean of all
    #[arg(long)]
    paired: bool,
    /// Subtract the residual from the total, too
    #[arg(long)]
    total_less_residual: bool,
    /// Write the corrected signals of every repeat, not of the first alone
    #[arg(long)]
    signals: bool,
    /// Draw the charts of the page as SVG
    #[arg(long)]
    figures: bool,
    /// Print exactly one JSON value instead of tables
    #[arg(long)]
    json: bool,
    /// Folder for the output files [default: out/NAME, of the manifest]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    shown: Shown,
}

/// The words of [`Reading`].
fn reading() -> impl TypedValueParser<Value = Reading> {
    let words = [
        ("margin", "Lines less than 3 dB above the residual (ISO 3746)"),
        (
            "corrected",
            "Lines whose corrected level is less than 3 dB above the residual, 4.8 dB before correction",
        ),
        ("literal", "Lines whose corrected level is less than 3 dB re 20 uPa"),
    ];
    let words = words.map(|(word, help)| PossibleValue::new(word).help(help));
    PossibleValuesParser::new(words).try_map(|word| word.parse())
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.threads.start()?;
    let path = &arguments.manifest;
    let progress = arguments.shown.progress();
    progress.stage("manifest");
    let manifest = Manifest::load(path)?;
    manifest
        .warnings
        .iter()
        .for_each(|warning| message(&format!("warning: {warning}")));
    let folder = given_or_named(arguments.out.as_deref(), &name_of(path), path)?;
    let arrangement = Arrangement::of(&manifest)?;
    let staging = AtomicWrite::within(&folder)?;
    let processing = Processing {
        reading: arguments.reading,
        paired: arguments.paired,
        total_less_residual: arguments.total_less_residual,
    };
    let mut signals = Vec::new();
    progress.stage("shots");
    let read = |done: u64, of: u64| progress.done(done, of);
    let keep = |shot: CorrectedShot| {
        if shot.repeat > 0 && !arguments.signals {
            return Ok::<(), Error>(());
        }
        let (file, bytes, full_scale) = output::measurement::corrected_signal(&shot)?;
        staging.write_unsynced(&file, &bytes)?;
        signals.push((file, full_scale));
        Ok(())
    };
    let mut measured = process_recordings(&manifest, &arrangement, processing, read, keep)?;
    measured.result.manifest = path.display().to_string();
    progress.stage("writing files");
    for (name, bytes) in output::measurement::tables(&measured.result, &signals)? {
        staging.write(Path::new(name), &bytes)?;
    }
    let charts = figures::measurement(&measured);
    if arguments.figures {
        figures::write(&staging, Path::new("figures"), &charts)?;
    }
    staging.write(
        Path::new("measurement.html"),
        report::measurement(&measured.result, &charts, arguments.shown.units).as_bytes(),
    )?;
    let json = serde_json::to_vec_pretty(&measured.result).map_err(Error::Json)?;
    staging.write(Path::new(LAST), &json)?;
    staging.place(&[], Path::new(LAST))?;
    progress.end();
    if arguments.json {
        print_json(&measured.result)?;
    } else {
        arguments.shown.print(&text(&measured, &folder))?;
    }
    Ok(Status::SUCCESS)
}

/// Name of a test: that of its manifest, or of the manifest's folder if it has the default name.
fn name_of(path: &Path) -> String {
    let stem = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let own = stem(path).filter(|name| !name.eq_ignore_ascii_case("manifest"));
    let folder = || path.canonicalize().ok().and_then(|path| stem(path.parent()?));
    own.or_else(folder).unwrap_or_default()
}

fn text(measured: &Measured, folder: &Path) -> String {
    let result = &measured.result;
    let mut text = format!(
        "{}: A-weighted single-event sound power levels, dB re 1 pW s, {:.0} to {:.0} Hz, surface of {:.2} m2, K2 \
         {:.1} dB\n\n",
        result.manifest, result.range_hz[0], result.range_hz[1], result.area_m2, result.k2_db
    );
    text.push_str(&table::text(&tables::configurations(result)));
    if !result.sources.is_empty() {
        text.push('\n');
        text.push_str(&table::text(&tables::sources(result)));
    }
    if let Some(closure) = result.closure_db {
        let _ = writeln!(
            text,
            "\n  the total lies {closure:+.1} dB above the sum of the three sources"
        );
    }
    let _ = writeln!(text);
    text.push_str(&noted(&result.notes));
    let _ = writeln!(
        text,
        "\n  files in {}; open measurement.html for the page",
        folder.display()
    );
    text
}
