//! `nailnoise watch`: reruns a design whenever it is saved, and shows the result on a live page.

use std::net::{IpAddr, SocketAddr};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::Args;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};

use super::effects::Effects;
use super::stage_words::in_words;
use super::{Changes, Keeping, Memory, Shown, Threads, print};
use super::{Status, progress::note};
use crate::artifacts::ReportedRun;
use crate::cost;
use crate::design::{Assignment, Design};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::{Observer, Progress, Task};
use crate::store::Store;
use crate::study::StudySource;
use crate::tables::decibels;
use crate::watch::{Board, Differences, FinishedRun, Server, Slider, Sound, Watched};
use crate::wording::change;

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise watch my-tool.toml" => "then open the address that it prints, and edit my-tool.toml",
    "nailnoise watch my-tool.toml --set exhaust.holes=12" => "with another value for one key",
    "nailnoise watch my-tool.toml --listen 192.168.1.7:8080" => "for others on the network who have the address \
        that it prints",
))]
pub(super) struct Arguments {
    /// Design file (TOML)
    design: PathBuf,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    memory: Memory,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    keeping: Keeping,
    #[command(flatten)]
    shown: Shown,
    /// Serve the page at this address of the machine, for others on the network who have the address that is printed,
    /// with its token [default: this machine only]
    #[arg(long, value_name = "ADDRESS", value_parser = parse_address)]
    listen: Option<SocketAddr>,
}

/// An address with a port, or without one, which the system then chooses.
fn parse_address(text: &str) -> Result<SocketAddr, String> {
    let alone = || text.parse().map(|ip: IpAddr| SocketAddr::new(ip, 0));
    let found = text.parse().or_else(|_| alone());
    found.map_err(|_| "give an address of this machine, as 192.168.1.7 or 192.168.1.7:8080".to_owned())
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    arguments.threads.start()?;
    let board = Arc::new(Board::new(&arguments.design, &arguments.changes.set));
    let server = Server::start(Arc::clone(&board), arguments.listen).map_err(|source| Error::Serve { source })?;
    print(&format!("{}\n", server.address()))?;
    note(match arguments.listen {
        None => "open this address in a browser on this machine; Ctrl-C ends the command and the page",
        Some(_) => {
            "whoever has this address sees the design, moves its sliders and saves designs beside it; 0.0.0.0 stands \
             for any address of this machine; the connection is not encrypted; Ctrl-C ends the command and the page"
        }
    });
    let mut watching = Watching {
        arguments,
        store: arguments.keeping.cache()?,
        board,
        runs: 0,
    };
    // An interrupt ends the process and with it the server.
    loop {
        watching.follow()?;
    }
}

/// A watched design.
struct Watching<'a> {
    arguments: &'a Arguments,
    store: Store,
    board: Arc<Board>,
    /// Number of successful runs.
    runs: u32,
}

impl Watching<'_> {
    /// Runs the current design, and waits until it changes.
    fn follow(&mut self) -> Result<(), Error> {
        let (moves, values) = self.board.moved();
        let watched = Arc::new(Watched::new(&self.arguments.design, &values));
        let progress = Progress::to(Arc::new(Interested {
            terminal: self.arguments.shown.progress().observer(),
            board: Arc::clone(&self.board),
            watched: Arc::clone(&watched),
            moves,
            looked: Mutex::new(Instant::now()),
        }));
        self.board.begin("the design");
        // A fault in one run need not prevent the next; outputs of that run are lost.
        let outcome = catch_unwind(AssertUnwindSafe(|| self.run(&values, &progress)));
        progress.end();
        match outcome {
            Ok(Ok(())) => {}
            Ok(Err(error @ Error::Output { .. })) => return Err(error),
            Ok(Err(error)) => {
                self.board.fail(shown(&error));
                super::report(error);
            }
            Err(panic) if panic.is::<Abandoned>() => {
                // The files may have returned to their old state, but there is still no result for them.
                self.renew(&watched, moves);
                return Ok(());
            }
            Err(_) => self
                .board
                .fail("nailnoise has a fault; the terminal says what to report".to_owned()),
        }
        self.board.rest();
        watched.wait(|| self.board.moves() != moves);
        self.renew(&watched, moves);
        Ok(())
    }

    /// Prepares the next run: saving a file discards the values set on the page.
    fn renew(&self, watched: &Watched, moves: u64) {
        if self.board.moves() == moves {
            watched.settle();
            self.board.reset();
        }
    }

    /// Runs the design and shows the result, followed by the uncertainty of its levels.
    fn run(&mut self, values: &[Assignment], progress: &Progress) -> Result<(), Error> {
        let begin = Instant::now();
        let design = Design::load_with(&self.arguments.design, values)?;
        let moved = values.len() > self.arguments.changes.set.len();
        let mut warnings = Vec::new();
        for warning in design.warnings() {
            warnings.push(shown(warning));
            super::report(warning.clone());
        }
        cost::refuse(&design, &cost::of_run(&design)?, self.arguments.memory.limit())?;
        let graph = Graph::new(Arc::new(self.store.clone()), progress.observer());
        // Intermediate positions of a slider are not worth draws.
        let source = StudySource::find(&self.store, &design, !moved);
        let mut reported = ReportedRun::new(&graph, &design, &source)?;
        self.runs += 1;
        let mut shot = FinishedRun::new(self.runs, begin.elapsed().as_secs_f64(), &design, &reported.run.result);
        let units = self.arguments.shown.units;
        for (_, value) in &mut shot.values {
            *value = units.text(value).into_owned();
        }
        shot.sound = reported.sound_of_all().map(|own| {
            Arc::new(Sound {
                wav: own.wav.clone(),
                full_scale_pa: reported.run.microphones.report.full_scale_pa,
            })
        });
        let [before, pinned] = self.board.show(shot.clone(), warnings, reported.page(&design, units));
        let mut text = shot
            .headline
            .as_ref()
            .map_or_else(String::new, |own| super::alarm(&own.lines()));
        text.push_str(&line(&shot));
        let other = pinned.filter(|own| own.from != shot.number && before.as_ref().is_none_or(|b| b.from != own.from));
        text.extend(before.iter().map(|own| changed(own, "")));
        text.extend(other.iter().map(|own| changed(own, ", pinned")));
        self.arguments.shown.print(&text)?;
        if !self.board.has_sliders() {
            self.board.begin("which inputs matter");
            let ordered = Effects::ordered_keys(&graph, &design)?;
            let keys = ordered.keys.into_iter();
            self.board.offer(Slider::of(&design, keys, units), &ordered.basis);
        }
        if source.awaits_screening(&design, &reported.run.result) {
            self.board.begin("how sure the levels are");
            let source = source.screened(&self.store, &design, progress);
            reported.state(&design, &source);
            self.board.complete(reported.page(&design, units));
        }
        Ok(())
    }
}

/// The levels of a run in one line.
fn line(shot: &FinishedRun) -> String {
    let levels = shot
        .levels
        .iter()
        .map(|(name, level)| format!("{name} {}", decibels(*level)));
    let failed = match shot.failed.as_slice() {
        [] => String::new(),
        failed => format!("; do not rely on it, check failed: {}", failed.join(", ")),
    };
    let levels: Vec<String> = levels.collect();
    format!(
        "run {}: {} dB ({:.1} s){failed}\n",
        shot.number,
        levels.join(", "),
        shot.seconds
    )
}

/// The changes in one line.
fn changed(differences: &Differences, behind: &str) -> String {
    let levels = differences.levels.iter();
    let levels = levels.filter_map(|(name, db)| Some(format!("{name} {}", change((*db)?))));
    let values = differences
        .values
        .iter()
        .map(|(key, before, now)| format!("{key} {before} -> {now}"));
    let (levels, values): (Vec<String>, Vec<String>) = (levels.collect(), values.take(NAMED).collect());
    let more = match differences.values.len() {
        0 => "no value changed".to_owned(),
        all if all > NAMED => format!("{} and {} more", values.join(", "), all - NAMED),
        _ => values.join(", "),
    };
    let unlike = differences.unlike.as_ref();
    let unlike = unlike.map_or_else(String::new, |unlike| format!("  {}\n", super::red(unlike)));
    format!(
        "{unlike}  from run {}{behind}: {} dB; {more}\n",
        differences.from,
        levels.join(", ")
    )
}

/// Number of changed values named in a line.
const NAMED: usize = 4;

/// Formats an error or warning as in the terminal, for the page.
fn shown(diagnostic: &dyn Diagnostic) -> String {
    let mut text = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::none())
        .with_links(false)
        .with_width(100)
        .with_context_lines(1);
    // A diagnostic that cannot be rendered is written as plain text.
    if handler.render_report(&mut text, diagnostic).is_err() {
        text = diagnostic.to_string();
    }
    text.trim_matches('\n').to_owned()
}

/// Interval between checks of the files during a run.
const LOOK: Duration = Duration::from_millis(50);

/// Payload of the unwinding that ends work on files that have changed. It does not trigger a panic hook.
struct Abandoned;

/// Shows progress in the terminal and on the page, and aborts the work at its next report if the files have changed.
struct Interested {
    terminal: Arc<dyn Observer>,
    board: Arc<Board>,
    watched: Arc<Watched>,
    /// How often the page had given a value when the run began.
    moves: u64,
    looked: Mutex<Instant>,
}

impl Interested {
    fn look(&self) {
        // One thread checks, while the others continue.
        let Ok(mut looked) = self.looked.try_lock() else { return };
        if looked.elapsed() < LOOK {
            return;
        }
        *looked = Instant::now();
        drop(looked);
        if self.board.moves() != self.moves || self.watched.changed() {
            resume_unwind(Box::new(Abandoned));
        }
    }
}

impl Observer for Interested {
    fn stage(&self, name: &str) {
        self.look();
        self.board.begin(in_words(name));
        self.terminal.stage(name);
    }

    fn note(&self, text: &str) {
        self.terminal.note(text);
    }

    fn done(&self, items: u64, of: u64) {
        self.look();
        self.terminal.done(items, of);
    }

    fn task(&self, task: &Task) {
        self.look();
        self.terminal.task(task);
    }

    fn step(&self) {
        self.look();
    }

    fn end(&self) {
        self.terminal.end();
    }
}
