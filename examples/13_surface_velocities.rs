//! Surface of block and table with its complex normal velocities in a shot, for other boundary element programs:
//! `cargo run --release --example 13_surface_velocities -- designs/n80cb.toml FOLDER 100 200 400`.
//!
//! Writes `surface.csv`, one row per corner of a panel, and `surface-power.csv`, the spectral density of the radiated
//! energy and the pressures at three points by the boundary elements of this program on the same panels. Velocities
//! and pressures are Fourier transforms over one shot, int x e^{-j 2 pi f t} dt.

use nailnoise::chain::{Chain, Options};
use nailnoise::graph::Graph;
use nailnoise::{Design, stages::spectra::BodyInMotion};
use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, MovingPart, Side, SolidBox};
use nalgebra::{Complex, DMatrix, DVector, Point3};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// Panels per wavelength at the highest frequency.
const PANELS: f64 = 8.0;

/// Longest side of a panel \[m\].
const COARSEST: f64 = 0.1;

/// Points of the pressures: origin at the centre of the block's underside, z upwards \[m\].
const POINTS: [[f64; 3]; 3] = [[1.5, 0.0, 0.5], [0.0, 1.5, 0.5], [0.0, 0.0, 1.5]];

const PATCHES: [&str; 3] = ["block", "table top", "table legs"];

/// Block, top and legs. The floor closes the legs.
fn boxes(design: &Design) -> Vec<SolidBox> {
    let (block, table) = (&design.workpiece, &design.support.worktable);
    let about_zero = |x: f64, y: f64, low: f64, high: f64, part: usize| SolidBox {
        low: [-0.5 * x, -0.5 * y, low],
        high: [0.5 * x, 0.5 * y, high],
        part,
    };
    let (x, y, leg, under) = (
        0.5 * table.length,
        0.5 * table.width,
        table.leg_width,
        -table.top_thickness,
    );
    let corners = [[-x, -y], [x - leg, -y], [-x, y - leg], [x - leg, y - leg]];
    let legs = corners.map(|[from_x, from_y]| SolidBox {
        low: [from_x, from_y, -table.height],
        high: [from_x + leg, from_y + leg, under],
        part: 2,
    });
    let top = about_zero(table.length, table.width, under, 0.0, 1);
    let block = about_zero(block.length, block.width, 0.0, block.thickness, 0);
    [vec![block, top], legs.to_vec()].concat()
}

/// Modal velocities of the bodies at the bin nearest to a frequency, body after body \[m/s per Hz, kg^(1/2)\].
fn velocities(bodies: &[BodyInMotion], hz: f64) -> (f64, DVector<Complex<f64>>) {
    let frequency = &bodies[0].motion.spectra.frequency;
    let bin = frequency.partition_point(|f| *f < hz).min(frequency.len() - 1);
    let hz = frequency[bin];
    let of_body = |body: &BodyInMotion| {
        let accelerations = body.motion.spectra.accelerations.column(bin).into_owned();
        accelerations / Complex::new(0.0, TAU * hz)
    };
    let all: Vec<Complex<f64>> = bodies
        .iter()
        .flat_map(|body| of_body(body).data.as_vec().clone())
        .collect();
    (hz, DVector::from_vec(all))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "designs/n80cb.toml".to_owned());
    let folder = arguments.next().unwrap_or_else(|| "out/surface".to_owned());
    let mut wanted: Vec<f64> = arguments.map(|hz| hz.parse()).collect::<Result<_, _>>()?;
    if wanted.is_empty() {
        wanted = vec![100.0, 200.0];
    }
    let design = Design::load(file)?;
    let graph = Graph::default();
    let chain = Chain::new(&graph, &design, Options::default())?;
    let bodies: Vec<BodyInMotion> = chain.moving[..2]
        .iter()
        .map(|body| body.get())
        .collect::<Result<_, _>>()?;

    let ambient = &design.ambient;
    let air = Air::at(ambient.temperature, ambient.pressure)?;
    let air = air.of_gas(ambient.gas_constant, ambient.heat_capacity_ratio)?;
    let floor = -design.support.worktable.height;
    let highest = wanted.iter().copied().fold(0.0, f64::max);
    let edge = (air.sound_speed / (PANELS * highest)).min(COARSEST);
    let names = PATCHES.map(str::to_owned).to_vec();
    let planes = [None, None, Some(floor)];
    let mesh = BoundaryMesh::of_boxes(&boxes(&design), planes, edge, names, |side: Side| side.part)?;
    let boundary = Boundary::new(mesh, Some(floor))?;
    let modes: Vec<DMatrix<f64>> = bodies.iter().map(|moving| moving.body.skin.map(f64::from)).collect();
    let parts: Vec<MovingPart<'_>> = bodies
        .iter()
        .zip(&modes)
        .zip([0..1, 1..3])
        .map(|((moving, modes), patches)| MovingPart {
            skin: &moving.body.surface,
            modes,
            patches,
        })
        .collect();
    let patterns = boundary.transfer(&parts)?.swap_remove(0).velocities;
    let exterior = Exterior::new(boundary, &air);

    let mut columns = Vec::new();
    let mut powers = String::from("Hz,energy by the surface [J/Hz],energy by the far field [J/Hz]");
    for point in 1..=POINTS.len() {
        write!(powers, ",Re p_{point} [Pa/Hz],Im p_{point} [Pa/Hz]")?;
    }
    for hz in wanted {
        let (hz, modal) = velocities(&bodies, hz);
        let [re, im] = [modal.map(|v| v.re), modal.map(|v| v.im)].map(|part| &patterns * part);
        let velocity = DMatrix::from_columns(&[re, im]);
        let solution = exterior.solve(hz, &velocity)?;
        let impedance: DMatrix<Complex<f64>> = exterior.impedance(&velocity, &solution)?.into_iter().sum();
        let resistance = exterior.far_field_resistance(&velocity, &solution)?;
        // One-sided: negative frequencies contain the same energy.
        let [surface, far] = [2.0 * impedance.trace().re, 2.0 * resistance.trace()];
        assert!(
            (10.0 * (surface / far).log10()).abs() < 0.1,
            "{hz} Hz: {surface} and {far} J/Hz"
        );
        let [direct, by_floor] = exterior.pressure_at(&POINTS.map(Point3::from), &velocity, &solution)?;
        let pressure = direct + by_floor;
        write!(powers, "\n{hz:.4},{surface:.5e},{far:.5e}")?;
        for row in pressure.row_iter() {
            let p = row[0] + Complex::<f64>::i() * row[1];
            write!(powers, ",{:.5e},{:.5e}", p.re, p.im)?;
        }
        println!("{hz:.2} Hz: {surface:.3e} J/Hz by the surface, {far:.3e} J/Hz by the far field");
        columns.push((hz, velocity));
    }
    powers.push('\n');

    let mesh = exterior.boundary().mesh();
    let mut table = String::from("panel,patch,x [m],y [m],z [m]");
    for (hz, _) in &columns {
        write!(table, ",Re v {hz:.4} Hz [m],Im v {hz:.4} Hz [m]")?;
    }
    let mut row = 0;
    for (number, panel) in mesh.panels.iter().enumerate() {
        for &corner in panel.corners() {
            let p = mesh.points[corner];
            write!(
                table,
                "\n{number},{},{:.6},{:.6},{:.6}",
                mesh.patches[panel.patch], p.x, p.y, p.z
            )?;
            for (_, velocity) in &columns {
                write!(table, ",{:.5e},{:.5e}", velocity[(row, 0)], velocity[(row, 1)])?;
            }
            row += 1;
        }
    }
    table.push('\n');
    std::fs::create_dir_all(&folder)?;
    std::fs::write(Path::new(&folder).join("surface.csv"), table)?;
    std::fs::write(Path::new(&folder).join("surface-power.csv"), powers)?;
    Ok(())
}
