//! `nailnoise init`: writes a design to start from.

use std::path::{Path, PathBuf};

use clap::Args;

use nailnoise_dynamics::Outcome;
use nailnoise_quantities::dimension::{LENGTH, MASS};
use nailnoise_quantities::measure;

use super::{Status, print};
use crate::atomic_write;
use crate::error::Error;
use crate::scaling::{self, Fastener, Request, Rules, Scaled};
use crate::shipped;
use crate::wording::trimmed;

/// The base of other designs, with all its comments and sources.
const BASE: &str = "n80cb.toml";

/// Name of a design if none is given.
const OWN_NAME: &str = "my-tool.toml";

/// A design based on it.
const OWN: &str = include_str!("init.toml");

#[derive(Args)]
#[command(after_help = examples!(
    "nailnoise init my-tool.toml" => "a design over the N80CB, with the keys that differ most often",
    "nailnoise init my-tool.toml --like finish-nailer --bore 38mm --nail \"64 x 1.6 \
     mm\"" => "another tool, scaled from the N80CB",
    "nailnoise init my-tool.toml --like stapler --from sawhorses" => "another tool, on another support",
    "nailnoise init --from n80cb" => "the N80CB itself, every key with its source and range",
    "nailnoise init --from muffler quieter.toml" => "another design of the program, with its bases, under a name of \
        your own",
))]
pub(super) struct Arguments {
    /// The design file to write [default: my-tool.toml, or the name of the design given by --from]
    #[arg(value_name = "DESIGN")]
    design: Option<PathBuf>,
    /// Write this design, which comes with the program, and its bases to the same folder; with --like, scale it
    #[arg(long, value_name = "NAME", conflicts_with = "full", value_parser = shipped_design)]
    from: Option<(&'static str, &'static str)>,
    /// Write every key of the base design, instead of a few keys on top of a separate base file
    #[arg(long, conflicts_with = "like")]
    full: bool,
    /// Write a design of a tool of this class, scaled from the N80CB; the class has defaults for the four options below
    #[arg(long, value_name = "CLASS", value_parser = class)]
    like: Option<String>,
    /// Bore of the cylinder, as in 38mm
    #[arg(long, value_name = "LENGTH", requires = "like", value_parser = length)]
    bore: Option<f64>,
    /// Travel of the piston, as in 95mm
    #[arg(long, value_name = "LENGTH", requires = "like", value_parser = length)]
    stroke: Option<f64>,
    /// Mass of the whole tool without fasteners, as in 1.2kg
    #[arg(long, value_name = "MASS", requires = "like", value_parser = mass)]
    mass: Option<f64>,
    /// A name of `nailnoise list nails`, or length and diameter, as in "64 x 1.6 mm"
    #[arg(long, value_name = "FASTENER", requires = "like", value_parser = str::parse::<Fastener>)]
    nail: Option<Fastener>,
}

/// The name of a class of tools.
fn class(name: &str) -> Result<String, String> {
    let rules = Rules::load().map_err(|error| error.to_string())?;
    let known: Vec<&str> = rules.names().collect();
    match known.contains(&name) {
        true => Ok(name.to_owned()),
        false => Err(format!("there is no such class; choose from {}", known.join(", "))),
    }
}

/// A length above 5 mm and below 1 m.
fn length(text: &str) -> Result<f64, String> {
    within(measure(text, LENGTH)?, [5e-3, 1.0], "5 mm to 1 m")
}

/// A mass above 0.1 kg and below 50 kg.
fn mass(text: &str) -> Result<f64, String> {
    within(measure(text, MASS)?, [0.1, 50.0], "0.1 kg to 50 kg")
}

fn within(value: f64, [low, high]: [f64; 2], words: &str) -> Result<f64, String> {
    match (low..=high).contains(&value) {
        true => Ok(value),
        false => Err(format!("{value} in SI units is outside {words}; is the unit right?")),
    }
}

/// A design that comes with the program, and its text.
fn shipped_design(name: &str) -> Result<(&'static str, &'static str), String> {
    shipped::design(name).ok_or_else(|| {
        let names: Vec<&str> = shipped::names().collect();
        format!(
            "no design of this name comes with the program; there are {}",
            names.join(", ")
        )
    })
}

pub(super) fn execute(arguments: &Arguments) -> Result<Status, Error> {
    let mut shot = String::new();
    let mut driven = true;
    let (path, files) = match &arguments.like {
        Some(class) => {
            let path = arguments.design.clone().unwrap_or_else(|| PathBuf::from(OWN_NAME));
            if path.exists() {
                return Err(Error::Exists { path });
            }
            let scaled = of_class(arguments, class, &path)?;
            (shot, driven) = (told(&scaled), scaled.settled.shot.drives());
            let mut files = vec![(
                path.clone(),
                scaled.text,
                format!("a {}, scaled from the N80CB", scaled.what),
            )];
            if let Some((name, text)) = arguments.from.or_else(|| shipped::design(BASE)) {
                files.extend(with_bases(&path.with_file_name(shipped::file_name(name)), name, text));
            }
            (path, files)
        }
        None => plan(arguments),
    };
    if path.exists() {
        return Err(Error::Exists { path });
    }
    if files.iter().skip(1).any(|(base, ..)| *base == path) {
        return Err(Error::NameOfBase { path });
    }
    let mut text = String::new();
    // The design is written last, because it is useless without its bases.
    for (path, content, what) in files.iter().rev() {
        // An existing file may have been changed by its owner.
        let kept = path.exists();
        if !kept {
            atomic_write::write(path, content.as_bytes())?;
        }
        let present = if kept { " (already present)" } else { "" };
        text.insert_str(0, &format!("{}: {what}{present}\n", path.display()));
    }
    text.push_str(&shot);
    text.push_str(&format!(
        "\n  nailnoise check {0}   lists estimates and the cost of a run\n  nailnoise run {0}     ranks its sources\n",
        path.display()
    ));
    print(&text)?;
    Ok(Status::from(u8::from(!driven)))
}

/// The scaled design for a class.
fn of_class(arguments: &Arguments, class: &str, path: &Path) -> Result<Scaled, Error> {
    let request = Request {
        class: class.to_owned(),
        base: arguments.from.map_or(scaling::BASE, |(name, _)| name),
        bore: arguments.bore,
        stroke: arguments.stroke,
        mass: arguments.mass,
        fastener: arguments.nail.clone(),
    };
    scaling::scaled(&request, &path.to_string_lossy())
}

/// Describes the shot of a scaled design.
fn told(scaled: &Scaled) -> String {
    let settled = &scaled.settled;
    let shot = &settled.shot;
    let psi = |pressure: f64| format!("{:.0} psig", pressure / scaling::PSI);
    let joules = |energy: f64| format!("{} J", trimmed(energy, 1));
    let mm = |length: f64| format!("{} mm", trimmed(1e3 * length.abs(), 1));
    let pressure = psi(settled.setting.pressure);
    let rated = format!("{:.0} to {}", scaling::RATED[0] / scaling::PSI, psi(scaling::RATED[1]));
    let nail = &scaled.fastener;
    let mut text = format!("\n  {nail} in pine, ");
    text.push_str(&match shot.outcome {
        _ if shot.drives() => format!("driven at {pressure}: head {} below the surface", mm(shot.head_depth)),
        Outcome::Overdriven => format!(
            "OVERDRIVEN from {rated} with every depth adjustment: at {pressure} the head ends {} below the surface\n  \
             the tool is too strong for it: give a smaller --bore or --stroke, or a longer or thicker --nail",
            mm(shot.head_depth)
        ),
        Outcome::DoesNotOpen => {
            format!("NOT DRIVEN from {rated}: the head valve does not open\n  give a larger --bore")
        }
        _ => format!(
            "NOT DRIVEN from {rated}: at {pressure} the head stands {} out of the wood\n  the tool is too weak for it: \
             give a larger --bore or --stroke, or a shorter or thinner --nail",
            mm(shot.head_depth)
        ),
    });
    if settled.setting.depth != 1.0 {
        text.push_str(&format!("; depth adjustment at {:.0} %", 100.0 * settled.setting.depth));
    }
    text.push_str(&format!(
        "\n  energy of the shot: {} on the nail, whose penetration law takes {} over its full length\n  \
         energy of the tool at 100 psig, on the nail and left in the piston when the head is flush: {}\n",
        joules(shot.energy_at_nail),
        joules(settled.needed),
        settled.tool_energy.map_or_else(|| "-".to_owned(), joules)
    ));
    text.push_str(&match &scaled.published {
        Some((energy, source)) => format!("  published for the class: {}, {source}\n", joules(*energy)),
        None => "  no published energy of a tool of this class was found\n".to_owned(),
    });
    if shot.outcome == Outcome::StrikesBumper {
        text.push_str("  the bumper takes the energy that the nail does not, as in a tool set to drive flush\n");
    }
    if settled.setting.by_hand {
        text.push_str(
            "  the recoil does not lift the tool far enough: a finger releases the trigger, trigger.release_after\n",
        );
    }
    text.push_str("  a run needs gmsh where the housing has other dimensions than that of the N80CB\n");
    text
}

/// A file to write, its content, and its description.
type Planned = (PathBuf, String, String);

/// The design and the files to write, the design first.
fn plan(arguments: &Arguments) -> (PathBuf, Vec<Planned>) {
    let path = |default: &str| arguments.design.clone().unwrap_or_else(|| PathBuf::from(default));
    let base_of = |path: &Path| path.with_file_name(BASE);
    if let Some((name, text)) = arguments.from {
        let path = path(shipped::file_name(name));
        let files = with_bases(&path, name, text);
        return (path, files);
    }
    let path = path(OWN_NAME);
    let base = shipped::design(BASE).map_or("", |(_, text)| text);
    let base_path = base_of(&path);
    let files = if arguments.full || base_path == path {
        let what = "the N80CB with every key, its source and range";
        vec![(path.clone(), base.to_owned(), what.to_owned())]
    } else {
        let what = "your design; remove the # from the lines that differ";
        vec![
            (path.clone(), OWN.to_owned(), what.to_owned()),
            (base_path, base.to_owned(), "its base".to_owned()),
        ]
    };
    (path, files)
}

/// A design of the program and its bases, all in one folder.
fn with_bases(path: &Path, name: &str, text: &str) -> Vec<Planned> {
    let mut files = vec![(
        path.to_owned(),
        in_one_folder(text),
        format!("the design {name} of the program"),
    )];
    let mut next = base(text);
    while let Some((name, text)) = next.and_then(|(_, file)| shipped::design(file)) {
        let what = if files.len() == 1 {
            "its base"
        } else {
            "the base of that"
        };
        let path = path.with_file_name(shipped::file_name(name));
        files.push((path, in_one_folder(text), what.to_owned()));
        next = base(text);
    }
    files
}

/// The name of a design's base as written, and the name of its file.
fn base(text: &str) -> Option<(&str, &str)> {
    let line = text.lines().find_map(|line| line.strip_prefix("base = \""))?;
    let (name, _) = line.split_once('"')?;
    Some((name, shipped::file_name(name)))
}

/// The text with its base in the same folder.
fn in_one_folder(text: &str) -> String {
    match base(text) {
        Some((name, file)) => text.replacen(&format!("base = \"{name}\""), &format!("base = \"{file}\""), 1),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;

    /// Every design of the program, written to a folder of its own, has the same values as in the repository.
    #[test]
    fn every_design_of_the_program_is_written_with_its_bases() -> Result<(), Error> {
        let folder = std::env::temp_dir().join(format!("nailnoise-init-{}", std::process::id()));
        for (name, text) in shipped::DESIGNS {
            let _ = std::fs::remove_dir_all(&folder);
            let path = folder.join("own.toml");
            for (path, content, _) in with_bases(&path, name, text) {
                atomic_write::write(&path, content.as_bytes())?;
            }
            let designs = Path::new(env!("CARGO_MANIFEST_DIR")).join("designs");
            let (own, original) = (Design::load(&path)?, Design::load(designs.join(name))?);
            assert_eq!(own.digest(), original.digest(), "{name}");
            assert_eq!(own.entries().len(), original.entries().len(), "{name}");
        }
        let _ = std::fs::remove_dir_all(folder);
        Ok(())
    }
}
