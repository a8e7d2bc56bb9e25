//! `nailnoise test`: a virtual wrapping test of a design, as recordings or only in energies.

use std::path::Path;

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::Status;
use super::table::table;
use super::{Common, Keeping, given_or_named, print_json, progress};
use crate::atomic_write::AtomicWrite;
use crate::cost;
use crate::design::Design;
use crate::error::Error;
use crate::graph::Graph;
use crate::headline::{self, Headline};
use crate::measurement::wrapping::{Configuration, Role, Wrapping};
use crate::output::virtual_test::{SensorPeaks, manifest, sensors, sounds};
use crate::result::DesignId;
use crate::tables::decibels;
use crate::virtual_test::bare::{BareLevels, BareSource};
use crate::virtual_test::exact::{ExactTest, exact};
use crate::virtual_test::{VirtualTest, wrapping};

/// The file written last, whose presence shows that the folder is complete.
const LAST: &str = "manifest.toml";

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise test my-tool.toml" => "recordings as a wrapping test makes them, in out/my-tool-test/",
    "nailnoise test my-tool.toml --energies --wraps perfect" => "levels alone, with wraps that let nothing through",
))]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    keeping: Keeping,
    /// The wraps: those of the design, or such that let nothing through and hide nothing
    #[arg(long, value_enum, default_value_t)]
    wraps: Wraps,
    /// State the results of the test in terms of energies, without recordings and scatter
    #[arg(long)]
    energies: bool,
    /// Seed of scatter and noise
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
enum Wraps {
    /// Those of the design
    #[default]
    Design,
    /// Wraps that let nothing through and hide nothing
    Perfect,
}

/// Layout of `test --json`.
#[derive(Serialize)]
struct TestResult {
    schema: &'static str,
    design: DesignId,
    wraps: Wraps,
    seed: u64,
    /// How the design's shot ends, if it does not drive its nail; null otherwise.
    headline: Option<Headline>,
    /// Without scatter, for the design's own shot.
    exact: ExactTest,
    /// Keys that do not scatter from shot to shot, because no formula of the assembly reads them.
    without_scatter: Vec<&'static str>,
    /// The manifest of the recordings; null with `--energies`.
    manifest: Option<String>,
    /// The sources of the shots before wrapping; empty with `--energies`.
    recorded: Vec<BareSource>,
    /// Number of recordings written.
    shots: usize,
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let common = &arguments.common;
    let design = common.begin_with_any_tool()?;
    cost::refuse(&design, &cost::of_run(&design)?, common.options.memory.limit())?;
    let wraps = match arguments.wraps {
        Wraps::Design => wrapping(&design),
        Wraps::Perfect => Wrapping::perfect(),
    };
    let progress = progress();
    let graph = Graph::quiet(&arguments.keeping.cache()?, progress.observer());
    let test = VirtualTest::new(&graph, &design, wraps, arguments.seed)?;
    progress.stage("the design's shot, minutes where its modes and radiation are new");
    let own = test.own()?;
    let background = design.acoustics.background_level;
    let rate = design.test.sampling_rate;
    let exact = exact(&test.arrangement, rate, &wraps, &test.densities(&own), background)?;
    drop(own);
    let headline = headline::headline_of(&graph, &design)?;
    let mut result = TestResult {
        headline,
        schema: "nailnoise-test/1",
        design: DesignId::from(&design),
        wraps: arguments.wraps,
        seed: arguments.seed,
        exact,
        without_scatter: test.without_scatter(),
        manifest: None,
        recorded: Vec::new(),
        shots: 0,
    };
    if !arguments.energies {
        let name = format!("{}-test", design.name());
        let folder = given_or_named(common.options.out.as_deref(), &name, design.path())?;
        (result.shots, result.recorded) = record(&design, &test, &folder, &progress)?;
        result.manifest = Some(folder.join(LAST).display().to_string());
    }
    progress.end();
    if common.options.json {
        print_json(&result)?;
    } else {
        let lines = result.headline.as_ref().map(Headline::lines).unwrap_or_default();
        common.shown.print(&super::alarm(&lines))?;
        common.shown.print(&text(&result))?;
    }
    Ok(Status::SUCCESS)
}

/// Writes the recordings of all configurations with their manifest; returns the number of shots, and the unwrapped
/// sources.
fn record(
    design: &Design,
    test: &VirtualTest<'_>,
    folder: &Path,
    progress: &crate::stages::Progress,
) -> Result<(usize, Vec<BareSource>), Error> {
    let staging = AtomicWrite::within(folder)?;
    let repeats = design.test.repeats as usize;
    let shots = repeats * Configuration::ALL.len();
    progress.stage("shots");
    let mut full_scale = 0.0_f64;
    let mut bare_levels = BareLevels::new(test)?;
    let mut peaks = SensorPeaks::default();
    for (place, configuration) in Configuration::ALL.into_iter().enumerate() {
        let name = test.arrangement.setup.configuration(configuration.number());
        for repeat in 0..repeats {
            let bare = test.bare(configuration, repeat)?;
            bare_levels.add(configuration, &bare);
            let shot = test.record(&bare, configuration, repeat);
            peaks.add(&shot);
            // A common full scale for all: that of the first configuration, which is the loudest, with room for
            // scatter.
            if place == 0 && repeat == 0 {
                full_scale = crate::stages::microphones::full_scale(4.0 * test.peak(&bare));
            }
            let stem = format!("{name}-{}", repeat + 1);
            staging.write_unsynced(Path::new(&format!("{stem}.wav")), &sounds(&shot, full_scale, &stem)?)?;
            staging.write_unsynced(
                Path::new(&format!("{stem}.uff")),
                &sensors(
                    &test.arrangement,
                    &shot,
                    &format!("nailnoise design {}", design.digest()),
                ),
            )?;
            progress.done((place * repeats + repeat + 1) as u64, shots as u64);
        }
    }
    let text = manifest(design, &test.arrangement, (full_scale, &peaks), repeats);
    staging.write(Path::new(LAST), text.as_bytes())?;
    staging.place(&[], Path::new(LAST))?;
    Ok((shots, bare_levels.sources()))
}

fn text(result: &TestResult) -> String {
    let exact = &result.exact;
    let mut text = format!(
        "{}: virtual wrapping test, A-weighted single-event sound power levels, dB re 1 pW s\n\n",
        result.design.name
    );
    let configurations = Configuration::ALL.into_iter().zip(exact.configurations_db);
    let configurations: Vec<Vec<String>> = configurations
        .map(|(own, level)| vec![own.number().to_string(), own.measures().to_owned(), decibels(level)])
        .collect();
    text.push_str(&table(&["configuration", "measures", "dB"], &configurations));
    text.push('\n');
    let recorded = !result.recorded.is_empty();
    let mut titles = vec!["source", "bare dB", "less residual dB", "least squares dB", "bound dB"];
    let mut rows: Vec<Vec<String>> = (Role::ALL.into_iter().enumerate())
        .map(|(place, role)| {
            vec![
                role.name().to_owned(),
                decibels(exact.sources_db[place]),
                decibels(exact.separated_db[place]),
                decibels(exact.unmixed_db[place]),
                if role == Role::Workpiece {
                    decibels(exact.bound_db)
                } else {
                    String::new()
                },
            ]
        })
        .collect();
    if recorded {
        titles.push("recorded, bare dB");
        rows.iter_mut()
            .zip(&result.recorded)
            .for_each(|(row, own)| row.push(decibels(own.lwa_db)));
    }
    text.push_str(&table(&titles, &rows));
    text.push_str(
        "\n  bare: as the nine microphones measure it alone, 1 to 2.5 dB above the power of `nailnoise run`:\n  waves \
         that cross the box obliquely count in full\n  less residual: the result of the test; least squares: from \
         all five, given the losses of the wraps;\n  bound: the total less exhaust and body\n",
    );
    if recorded {
        text.push_str("  recorded, bare: mean of the shots that measure the source, with their scatter\n");
    }
    if let Some(closure) = exact.closure_db {
        text.push_str(&format!(
            "  closure: the total lies {closure:+.1} dB above the sum of the three\n"
        ));
    }
    text.push_str(
        "  energies of the design's own shot, without scatter; the losses of the wraps are estimated ([test.wraps])\n",
    );
    if recorded && !result.without_scatter.is_empty() {
        text.push_str(&format!(
            "  the shots do not scatter in {}: no formula of the assembly reads it\n",
            result.without_scatter.join(" and ")
        ));
    }
    if let Some(manifest) = &result.manifest {
        text.push_str(&format!(
            "\n  {} shots in {}; next: nailnoise measure {manifest}\n",
            result.shots,
            Path::new(manifest).parent().unwrap_or_else(|| Path::new(".")).display()
        ));
    }
    text
}
