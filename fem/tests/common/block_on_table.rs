#![allow(missing_docs, unreachable_pub)]

//! A block on a table with the size of the real case, from closed-form plate shapes: enough modes, points and loads to
//! measure work and time without a mesh.

use std::f64::consts::{PI, TAU};

use nailnoise_fem::vibration::supports::{ContactGrid, GridRule, contact_dashpot};
use nailnoise_fem::vibration::{Loads, ModalBody, Support, SupportLaw};
use nalgebra::DMatrix;

pub struct Case {
    pub bodies: Vec<ModalBody>,
    pub supports: Vec<Support>,
    pub loads: Loads,
}

/// Modes cos(m pi x/lx) cos(n pi y/ly) of a free plate-like body (x, y from its corner), sorted by frequency.
struct Plate {
    size: [f64; 2],
    mass: f64,
    modes: Vec<(f64, usize, usize)>,
}

impl Plate {
    fn new(size: [f64; 2], mass: f64, count: usize, highest: f64, rigid: bool) -> Self {
        let mut modes: Vec<(f64, usize, usize)> = (0..60usize)
            .flat_map(|m| (0..60usize).map(move |n| (m, n)))
            .map(|(m, n)| ((m as f64 / size[0]).powi(2) + (n as f64 / size[1]).powi(2), m, n))
            .collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0));
        modes.truncate(count);
        let top = modes.last().map_or(1.0, |m| m.0).sqrt();
        let floor = if rigid { 0.0 } else { 115.0 };
        // Frequencies spread like those of a thick block; (0,0), (1,0) and (0,1) are rigid if the body is free.
        for mode in &mut modes {
            let free = rigid && mode.1 + mode.2 <= 1;
            mode.0 = if free {
                0.0
            } else {
                TAU * (floor + (highest - floor) * mode.0.sqrt() / top)
            };
        }
        Self { size, mass, modes }
    }

    fn shape(&self, mode: (f64, usize, usize), x: f64, y: f64) -> f64 {
        let (_, m, n) = mode;
        let (x, y) = (x / self.size[0], y / self.size[1]);
        if mode.0 == 0.0 && m + n == 1 {
            let s = if m == 1 { x } else { y };
            return (12.0 / self.mass).sqrt() * (s - 0.5);
        }
        let norm = if m > 0 { 2.0f64.sqrt() } else { 1.0 } * if n > 0 { 2.0f64.sqrt() } else { 1.0 };
        norm / self.mass.sqrt() * (m as f64 * PI * x).cos() * (n as f64 * PI * y).cos()
    }

    fn omega(&self) -> Vec<f64> {
        self.modes.iter().map(|m| m.0).collect()
    }
}

/// Block of 2.534 kg on a table top of 450 x 400 mm, 13 x 5 points; gravity, a push and a blow of 3 ms.
pub fn block_on_table(block_modes: usize, table_modes: usize, law: SupportLaw) -> Case {
    let (k, c) = (8e9, contact_dashpot(8e9, 0.1, 500.0));
    let block = Plate::new([0.4064, 0.1524], 2.534, block_modes, 12e3, true);
    let table = Plate::new([0.45, 0.40], 4.0, table_modes, 5e3, false);
    let grid = ContactGrid::new(0.4064, 0.1524, 13, 5, GridRule::GaussLegendre);
    let supports: Vec<Support> = grid
        .areas
        .iter()
        .map(|a| Support {
            stiffness: k * a,
            damping: c * a,
            gap: 0.0,
            law,
        })
        .collect();
    let at_block = |p: &[f64; 2]| (p[0] + 0.2032, p[1] + 0.0762);
    let at_table = |p: &[f64; 2]| (p[0] + 0.225, p[1] + 0.20);
    let shapes = |plate: &Plate, place: &dyn Fn(&[f64; 2]) -> (f64, f64), sign: f64| {
        DMatrix::from_fn(plate.modes.len(), grid.points.len(), |j, i| {
            let (x, y) = place(&grid.points[i]);
            sign * plate.shape(plate.modes[j], x, y)
        })
    };
    // Loads: weight of the block, weight of the table, push of tool and hand, and 12 shares of the blow. Modes count
    // downwards in both bodies: along the block's outward normal, against the table's.
    let loads = 15;
    let points: Vec<[f64; 2]> = (0..loads - 2)
        .map(|l| [0.01 + 0.004 * l as f64, 0.003 * l as f64])
        .collect();
    let block_loads = DMatrix::from_fn(block.modes.len(), loads, |j, l| match l {
        0 => {
            let (_, m, n) = block.modes[j];
            if m + n == 0 { block.mass.sqrt() } else { 0.0 }
        }
        1 => 0.0,
        l => {
            let (x, y) = at_block(&points[l - 2]);
            block.shape(block.modes[j], x, y)
        }
    });
    let table_loads = DMatrix::from_fn(table.modes.len(), loads, |j, l| {
        let (_, m, n) = table.modes[j];
        if l == 1 && m + n == 0 { table.mass.sqrt() } else { 0.0 }
    });
    let samples = 15_001;
    let interval = 4e-6;
    let history = DMatrix::from_fn(loads, samples, |l, n| {
        let t = n as f64 * interval;
        match l {
            0 | 1 => 9.81,
            2 => 60.0 * (1.0 - t / 0.06),
            _ if (0.01..0.013).contains(&t) => {
                4000.0 / 12.0 * (PI * (t - 0.01) / 0.003).sin().powi(2) * (1.0 + 0.2 * (TAU * 4e3 * t).sin())
            }
            _ => 0.0,
        }
    });
    let mut final_values = vec![0.0; loads];
    final_values[..2].fill(9.81);
    let body = |name: &str, plate: &Plate, eta: f64, loads, supports| ModalBody {
        name: name.into(),
        omega: plate.omega(),
        zeta: vec![0.5 * eta; plate.modes.len()],
        loads,
        supports,
    };
    let bodies = vec![
        body("workpiece", &block, 0.02, block_loads, shapes(&block, &at_block, 1.0)),
        body("worktable", &table, 0.03, table_loads, shapes(&table, &at_table, -1.0)),
    ];
    Case {
        bodies,
        supports,
        loads: Loads {
            interval,
            history,
            final_values,
        },
    }
}
