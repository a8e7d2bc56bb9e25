//! The GARTEUR SM-AG19 testbed: an aluminium model of an aeroplane whose two measured wing torsion modes are 0.4 Hz
//! apart.

use nailnoise_fem::{Attachments, Constraints, Coupling, LumpedMass, Material, ModalSettings, assemble_with, modes};
use nailnoise_meshes::{Grid, Mesh};
use nalgebra::{Matrix3, Point3};

use super::plates::frequencies;
use super::row::{Case, Row};
use crate::error::Error;

const LOOSE: Case = Case {
    name: "GARTEUR SM-AG19, layer without stiffness",
    source: SOURCE,
};
const BONDED: Case = Case {
    name: "GARTEUR SM-AG19, layer bonded to the wing",
    source: SOURCE,
};
const SOURCE: &str = "measured (participant C), Balmes and Wright, DETC 1997, and TP-115 (1999); geometry and masses \
    by \
                      P. Krysl, FinEtoolsFlexStructuresTutorials.jl";

/// Differences \[Hz\] between the models with a loose and a bonded layer, see `docs/limits.md`.
const SOFTER: [f64; 2] = [-0.7, 0.0];
const STIFFER: [f64; 2] = [0.0, 5.5];

/// Measured frequencies \[Hz\]: wing bending, roll of the fuselage, antisymmetric and symmetric torsion of the wing.
const MEASURED: [f64; 4] = [6.37, 16.10, 33.13, 33.53];

/// Parts given by two corners \[m\]: fuselage, wing, drums, vertical and horizontal tail, constraining layer. Wing and
/// drums are 0.5 and 1 mm lower than published, so that they touch the parts that carry them. The viscoelastic tape
/// below the layer, 0.05 mm thick, is omitted, because its modulus is not published. The model is stiffer than the
/// aeroplane with the layer bonded to the wing, and softer with the layer's mass alone.
const PARTS: [[[f64; 2]; 3]; 7] = [
    [[-0.9, 0.6], [-0.025, 0.025], [-0.075, 0.075]],
    [[-0.05, 0.05], [-1.0, 1.0], [0.075, 0.085]],
    [[-0.2, 0.2], [-1.0, -0.9], [0.085, 0.095]],
    [[-0.2, 0.2], [0.9, 1.0], [0.085, 0.095]],
    [[-0.85, -0.75], [-0.005, 0.005], [0.075, 0.375]],
    [[-0.85, -0.75], [-0.2, 0.2], [0.375, 0.385]],
    [[-0.05, 0.0262], [-0.85, 0.85], [0.085, 0.0861]],
];

/// Footprints \[m\] and values \[kg\] of the masses on the drums and on the tail.
const MASSES: [(&str, [[f64; 2]; 2], f64); 3] = [
    ("left mass", [[0.16, 0.2], [0.9, 0.94]], 0.2),
    ("right mass", [[0.16, 0.2], [-0.94, -0.9]], 0.2),
    ("tail mass", [[-0.85, -0.75], [-0.025, 0.025]], 0.432),
];

/// Heights of the masses' centres \[m\].
const MASS_HEIGHTS: [f64; 3] = [0.096, 0.096, 0.38];

/// Young's modulus of the aluminium \[Pa\].
const E: f64 = 70e9;

/// Fraction of its stiffness that the soft layer retains.
const SOFT: f64 = 1e-6;

/// Longest element edge \[m\].
const LONGEST: f64 = 0.06;

/// Grid lines along an axis: the sides of all parts and footprints, with the intervals between them divided.
fn lines(axis: usize) -> Vec<f64> {
    let mut sides: Vec<f64> = PARTS.iter().flat_map(|part| part[axis]).collect();
    if axis < 2 {
        sides.extend(MASSES.iter().flat_map(|(_, footprint, _)| footprint[axis]));
    }
    sides.sort_by(f64::total_cmp);
    sides.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    let mut lines = sides[..1].to_vec();
    for stretch in sides.windows(2) {
        let length = stretch[1] - stretch[0];
        let count = (length / LONGEST).ceil();
        lines.extend((1..=count as usize).map(|i| stretch[0] + length * i as f64 / count));
    }
    lines
}

/// Whether a coordinate is between two others.
fn between(x: f64, [low, high]: [f64; 2]) -> bool {
    low < x && x < high
}

fn mesh() -> Result<Mesh, Error> {
    let grid = Grid::new(lines(0), lines(1), lines(2))?;
    let part = |cell: [usize; 3]| {
        let centre = grid.centre(cell);
        let holds = |part: &[[f64; 2]; 3]| (0..3).all(|axis| between(centre[axis], part[axis]));
        let part = PARTS.iter().position(holds)?;
        Some(usize::from(part == PARTS.len() - 1))
    };
    // A mass is on the highest face above its footprint that is open upwards.
    let name = |_: usize, axis: usize, upper: bool, centre: Point3<f64>| {
        let on = |(_, footprint, _): &&(&str, [[f64; 2]; 2], f64)| {
            (0..2).all(|own| between(centre[own], footprint[own])) && centre.z > 0.09
        };
        match MASSES.iter().find(on) {
            Some((name, ..)) if axis == 2 && upper => name,
            _ => "rest",
        }
    };
    Ok(grid.mesh(&["aeroplane", "layer"], part, name))
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let mass = |((group, [x, y], mass), z): (&(&str, [[f64; 2]; 2], f64), f64)| LumpedMass {
        group: (*group).to_owned(),
        mass: *mass,
        inertia: Matrix3::zeros(),
        centre: Point3::new(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]), z),
        coupling: Coupling::Distributed,
    };
    let attachments = Attachments {
        masses: MASSES.iter().zip(MASS_HEIGHTS).map(mass).collect(),
        ..Attachments::default()
    };
    let (nu, rho) = (0.31, 2700.0);
    let mesh = mesh()?;
    let solve = |case: Case, layer: f64| -> Result<Vec<Row>, Error> {
        let materials = [
            Material::isotropic(E, nu, rho)?,
            Material::isotropic(layer * E, nu, rho)?,
        ];
        let system = assemble_with(&mesh, &materials, &Constraints::free(), &attachments)?;
        let basis = modes(&system, &ModalSettings::below(45.0), &|_, _| ())?;
        let rigid = basis.rigid.iter().filter(|rigid| **rigid).count() as f64;
        let mut rows = vec![case.row("rigid modes", 6.0, rigid).within(0.5).decimals(0)];
        rows.extend(frequencies(case, &basis, &MEASURED, 5e-2));
        Ok(rows)
    };
    let loose = solve(LOOSE, SOFT)?.into_iter().map(|row| row.documented(SOFTER));
    let bonded = solve(BONDED, 1.0)?.into_iter().map(|row| row.documented(STIFFER));
    Ok(loose.chain(bonded).collect())
}
