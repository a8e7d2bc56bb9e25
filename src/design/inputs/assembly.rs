//! Inputs of a cycle given as a network: the assembly of a file and its numerical settings.

use std::collections::BTreeMap;
use std::path::Path;

use nailnoise_dynamics::network::assembly::Base;
use nailnoise_dynamics::network::{self, Assembly, AssemblyText, Numerics, Record, Resolved};
use nailnoise_penetration::{PenetrationLaw, ResistanceLaw};
use nailnoise_quantities::Group as _;

use super::cycle::fitted_law;
use crate::design::loads_housing;
use crate::design::{Assignment, Coupling, Design, LoadedAssembly, MufflerKind, Value, Warning, refused_assembly};
use crate::error::Error;
use crate::stages::bodies::tool_loads::AXIAL_SURFACES;
use crate::stages::cycle::{AssembledCycle, BlockPlaces, Engine, TOOL, WORKPIECE};

/// The design whose mean density gives the volume of a housing without dimensions.
const REFERENCE: &str = "n80cb.toml";

/// A time in which no block changes its state \[s\].
const START: f64 = 1e-6;

/// A tool that a file describes as an assembly.
#[derive(Debug)]
pub struct AssembledTool {
    /// Name of the file without folder and extension.
    pub name: String,
    /// The assembly as text.
    pub text: AssemblyText,
    /// The assembly with its literals and keys.
    pub resolved: Resolved,
    /// How the cycle is integrated and sampled.
    pub numerics: Numerics,
    /// Whether the file has a design as its base, with workpiece, support and microphones.
    pub has_design: bool,
    /// Warnings about the file for the user.
    pub warnings: Vec<Warning>,
}

impl AssembledTool {
    /// Reads the assembly of a file, with other values for some keys; `None` if neither the file nor its bases have a
    /// table `[cycle]`.
    ///
    /// # Errors
    /// [`Error::Design`] with place and remedy.
    pub fn load(path: &Path, assignments: &[Assignment]) -> Result<Option<Self>, Error> {
        let Some(loaded) = Design::load_assembly(path, assignments)? else {
            return Ok(None);
        };
        let has_design = matches!(loaded, LoadedAssembly::OfDesign(_));
        let (text, mut resolved, numerics, fit, warnings) = match loaded {
            LoadedAssembly::Alone(text) => {
                let warnings = text.unused().into_iter().map(Warning::Unused).collect();
                let resolved = text.resolve(&BTreeMap::new()).map_err(refused_assembly)?;
                (*text, resolved, Numerics::default(), None, warnings)
            }
            LoadedAssembly::OfDesign(design) => {
                let Some(text) = design.assembly().cloned() else {
                    return Ok(None);
                };
                let resolved = text.resolve(&design.assembly_keys()?).map_err(refused_assembly)?;
                if let Some((key, remedy)) = ignored(&design, &resolved) {
                    return Err(design.refuse_for_assembly(&key, remedy).into());
                }
                let (numerics, warnings) = (numerics(&design), design.warnings().to_vec());
                (text, resolved, numerics, fitted_law(&design)?, warnings)
            }
        };
        resolved.assembly.set_resistance(None, fit.as_ref());
        let name = path
            .file_stem()
            .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Some(Self {
            name,
            text,
            resolved,
            numerics,
            has_design,
            warnings,
        }))
    }

    /// Checks that the cycle can start: its bodies have a rest position, and its springs and volumes are within their
    /// limits there.
    ///
    /// # Errors
    /// Same as [`record`](Self::record).
    pub fn check_start(&self) -> Result<(), Error> {
        let mut assembly = self.resolved.assembly.clone();
        assembly.end = START;
        let numerics = Numerics {
            sample_interval: None,
            ..self.numerics
        };
        let start = network::simulate(&assembly, &numerics);
        start.map_err(|error| self.text.placed(&assembly, error))?;
        Ok(())
    }

    /// Computes the record.
    ///
    /// # Errors
    /// [`Error::Network`] with the place of the block at fault.
    pub fn record(&self) -> Result<Record, Error> {
        let assembly = &self.resolved.assembly;
        Ok(network::simulate_balanced(assembly, &self.numerics).map_err(|error| self.text.placed(assembly, error))?)
    }
}

/// The cycle of a design with its own assembly; none for the tool of the keys.
///
/// # Errors
/// [`Error::Design`] with place and remedy.
pub(crate) fn cycle(design: &Design) -> Result<Option<AssembledCycle>, Error> {
    let Some(text) = design.assembly() else {
        return Ok(None);
    };
    let mut resolved = text.resolve(&design.assembly_keys()?).map_err(refused_assembly)?;
    resolved.assembly.set_resistance(None, fitted_law(design)?.as_ref());
    let refused = unsupported(design, &resolved).or_else(|| ignored(design, &resolved));
    if let Some((key, remedy)) = refused {
        return Err(design.refuse_for_assembly(&key, remedy).into());
    }
    Ok(Some(AssembledCycle {
        assembly: resolved.assembly,
        numerics: numerics(design),
        places: BlockPlaces(design.shared_assembly()),
    }))
}

/// A key of the support that a run cannot follow, and what to do instead. The cycle alone does not use the support's
/// structure.
fn unsupported(design: &Design, resolved: &Resolved) -> Option<(String, &'static str)> {
    let coupled = design.support.coupling == Coupling::TwoWay;
    let remedy = if body(&resolved.assembly, WORKPIECE).is_none() {
        "set `support.coupling = \"one-way\"`: the assembly has no body `workpiece` on which the support could act"
    } else if !resolved.assembly.blows.is_empty() {
        "set `support.coupling = \"one-way\"`: a block `[cycle.blow]` of the assembly needs a cycle that is complete \
         before the structures respond"
    } else {
        return None;
    };
    coupled.then(|| ("support.coupling".to_owned(), remedy))
}

/// A key of the cycle with a value that the assembly does not follow, and what to do instead.
fn ignored(design: &Design, resolved: &Resolved) -> Option<(String, &'static str)> {
    let muffler = "exhaust.muffler.kind";
    if design.exhaust.muffler.kind == MufflerKind::Chamber && !resolved.keys.contains(muffler) {
        let remedy = "describe the chamber as a volume of the assembly, between two passages, with the opening behind \
                      the second, as in the assembly n80cb_chamber";
        return Some((muffler.to_owned(), remedy));
    }
    let own_law = design.wood.penetration_law != ResistanceLaw::Published(PenetrationLaw::SolidWood);
    let mut found = None;
    design.visit("", &mut |key, _, value| {
        let remedy = match (key, value) {
            (_, Value::Choice("published")) if key.starts_with("model.") => {
                "remove it: no formula of the assembly reads the switch, as those of the assembly n80cb do"
            }
            ("wood.penetration_law", _) if own_law => {
                "give the law of the fastener in the assembly: `law = { kind = \"constant\", force = .. }` or \
                 `law = { kind = \"table\", .. }`"
            }
            ("model.blow", Value::Choice("elastic")) if resolved.assembly.blows.is_empty() => {
                "describe the bars of driver and fastener in the assembly: `[cycle.blow.FASTENER]` with `rod`, `shank` \
                 and `wood`, as in the assembly stapler"
            }
            ("wood.rate", Value::Choice("speed")) | ("wood.head_law", Value::Choice("yields")) => {
                "remove it: no formula of the assembly reads the key, as those of the assembly n80cb do"
            }
            _ => return,
        };
        if !resolved.keys.contains(key) {
            found.get_or_insert_with(|| (key.to_owned(), remedy));
        }
    });
    found
}

/// How the cycle of a design's assembly is integrated and sampled.
fn numerics(design: &Design) -> Numerics {
    Numerics {
        relative_tolerance: design.analysis.cycle_tolerance,
        sample_interval: Some(design.analysis.time_step),
        ..Numerics::default()
    }
}

/// Length of the fastener that an assembly drives into the workpiece \[m\]; none for the nail of the keys.
pub(crate) fn fastener_length(design: &Design) -> Option<f64> {
    let cycle = cycle(design).ok()??;
    let workpiece = body(&cycle.assembly, WORKPIECE)?;
    let mut fasteners = cycle.assembly.fasteners.iter();
    fasteners
        .find(|own| own.into == Base::Body(workpiece))
        .map(|own| own.length)
}

/// Whether a design's tool has a body of this name. The tool of the keys has a housing and a workpiece. So does a tool
/// whose assembly has an error; a run reports that error.
fn design_has(design: &Design, name: &str) -> bool {
    match cycle(design) {
        Ok(Some(cycle)) => body(&cycle.assembly, name).is_some(),
        Ok(None) | Err(_) => true,
    }
}

/// Whether a design's tool works on a workpiece.
pub(crate) fn has_workpiece(design: &Design) -> bool {
    design_has(design, WORKPIECE)
}

/// Whether a design's tool has a housing.
pub(crate) fn has_housing(design: &Design) -> bool {
    design_has(design, TOOL)
}

/// Statements of an assembly about its shot, for the head of a report.
pub(crate) struct AssemblyFacts {
    /// Whether it uses the supply pressure of the design.
    pub(crate) supplied: bool,
    /// Whether it has a workpiece.
    pub(crate) has_workpiece: bool,
    /// Name, length \[m\] and mass \[kg\] of each fastener.
    pub(crate) fasteners: Vec<(String, f64, f64)>,
}

/// The facts of a design's assembly; none for the tool of the keys.
pub(crate) fn facts(design: &Design) -> Option<AssemblyFacts> {
    let resolved = design.assembly()?.resolve(&design.assembly_keys().ok()?).ok()?;
    let fasteners = resolved.assembly.fasteners.iter();
    Some(AssemblyFacts {
        supplied: resolved.keys.contains("supply.pressure"),
        has_workpiece: body(&resolved.assembly, WORKPIECE).is_some(),
        fasteners: fasteners.map(|own| (own.name.clone(), own.length, own.mass)).collect(),
    })
}

/// Keys of the N80CB on which the blow of its landing depends.
const LANDING: [&str; 3] = ["hand.mass", "hand.force", "contacts.nose_stiffness"];

/// Keys and literals on which the blow of a landing tool depends: the force on the housing, and the stiffness of its
/// contacts with the workpiece.
///
/// # Errors
/// [`Error::Design`] with place and remedy.
pub(crate) fn landing_keys(design: &Design) -> Result<Vec<String>, Error> {
    let Some(text) = design.assembly() else {
        return Ok(LANDING.map(str::to_owned).to_vec());
    };
    let resolved = text.resolve(&design.assembly_keys()?).map_err(refused_assembly)?;
    let assembly = &resolved.assembly;
    let (Some(tool), Some(workpiece)) = (body(assembly, TOOL), body(assembly, WORKPIECE)) else {
        return Ok(Vec::new());
    };
    let pair = |on: usize, against: Base| {
        (on == tool && against == Base::Body(workpiece)) || (on == workpiece && against == Base::Body(tool))
    };
    let contacts = assembly.contacts.iter().filter(|own| pair(own.on, own.against));
    let stiffnesses = contacts.map(|own| format!("cycle.contact.{}.stiffness", own.name));
    let forces = assembly.forces.iter().filter(|own| own.on == tool);
    let forces = forces.map(|own| format!("cycle.force.{}.force", own.name));
    let is_literal = |path: &String| resolved.literals.iter().any(|own| own.path == *path);
    let of_keys = LANDING.into_iter().filter(|key| resolved.keys.contains(*key));
    Ok(of_keys
        .map(str::to_owned)
        .chain(forces.chain(stiffnesses).filter(is_literal))
        .collect())
}

/// Index of a body of an assembly.
pub(crate) fn body(assembly: &Assembly, name: &str) -> Option<usize> {
    assembly.bodies.iter().position(|body| body.name == name)
}

/// Whether a tool has a body. The tool of the keys has a housing and a workpiece.
pub(crate) fn has_body(engine: &Engine, name: &str) -> bool {
    match engine {
        Engine::Keys(_) => true,
        Engine::Assembly(cycle) => body(&cycle.assembly, name).is_some(),
    }
}

/// Mass of the housing in the cycle \[kg\]; zero for a tool without one.
pub(crate) fn tool_mass(engine: &Engine) -> f64 {
    match engine {
        Engine::Keys(cycle) => cycle.parameters.tool.mass,
        Engine::Assembly(cycle) => body(&cycle.assembly, TOOL).map_or(0.0, |index| cycle.assembly.bodies[index].mass),
    }
}

/// Volume of the housing as a rigid body \[m3\]: that of its dimensions or, for an assembly whose housing has no
/// surfaces, that of its mass at the mean density of the N80CB.
pub(crate) fn tool_volume(design: &Design, engine: &Engine) -> f64 {
    let own = design.body.volume(design.piston.bore);
    match mean_density(design) {
        Some(density) => tool_mass(engine) / density,
        None => own,
    }
}

/// Mean density of the N80CB \[kg/m3\], where the volume of a housing follows from its mass.
fn mean_density(design: &Design) -> Option<f64> {
    design.assembly().filter(|text| !loads_housing(text))?;
    let reference = Design::shipped(REFERENCE)?;
    Some(reference.tool.mass / reference.body.volume(reference.piston.bore))
}

/// Why a housing of an assembly is rigid, in words.
pub(crate) fn rigid_housing(design: &Design, engine: &Engine) -> Option<String> {
    let density = mean_density(design)?;
    let given = design.assembly().map_or_else(Vec::new, |text| text.surfaces(TOOL));
    let missing = AXIAL_SURFACES.iter().filter(|own| !given.contains(own));
    let missing: Vec<&str> = missing.copied().collect();
    let surfaces = if given.is_empty() {
        format!("the assembly gives no forces on the surfaces of `{TOOL}`")
    } else {
        format!(
            "the assembly gives no force on the surfaces {} of `{TOOL}`",
            missing.join(", ")
        )
    };
    Some(format!(
        "{surfaces}: it radiates as a rigid sphere of its mass, {:.2} kg, at the mean density of the N80CB, \
         {density:.0} kg/m3, which is a volume of {:.2} l",
        tool_mass(engine),
        1e3 * tool_volume(design, engine)
    ))
}

/// Sources that a tool does not have because its assembly has no such body or no opening, in words.
pub(crate) fn absent_sources(engine: &Engine) -> Vec<String> {
    let Engine::Assembly(cycle) = engine else {
        return Vec::new();
    };
    let absent = |name| body(&cycle.assembly, name).is_none();
    let mut notes = Vec::new();
    for (name, what) in [(WORKPIECE, "workpiece"), (TOOL, "housing")] {
        if absent(name) {
            notes.push(format!(
                "the assembly has no body `{name}`: its {what} is not among the sources"
            ));
        }
    }
    if cycle.assembly.openings.is_empty() {
        notes.push("the assembly has no opening: the exhaust is not among the sources".to_owned());
    }
    notes
}
