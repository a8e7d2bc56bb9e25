//! Meshes of every element kind, mapped from the unit cube.
#![allow(dead_code, unreachable_pub, reason = "each test file uses some of them")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::HashMap;

use nailnoise_meshes::{ElementKind, Mesh, gauss_legendre};
use nalgebra::{DMatrix, Point3};
use nalgebra_sparse::CscMatrix;

/// Corners, as corners of the cell, of the elements into which one cell is cut; conforming from cell to cell.
fn pieces(kind: ElementKind) -> Vec<Vec<[usize; 3]>> {
    let hex = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
    ];
    match kind.corners() {
        8 => vec![hex.to_vec()],
        6 => [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
            .iter()
            .map(|w| w.iter().map(|&c| hex[c]).collect())
            .collect(),
        // Kuhn's six tetrahedra around the diagonal from 0 to 6.
        _ => [
            [0, 1, 2, 6],
            [0, 2, 3, 6],
            [0, 3, 7, 6],
            [0, 7, 4, 6],
            [0, 4, 5, 6],
            [0, 5, 1, 6],
        ]
        .iter()
        .map(|t| t.iter().map(|&c| hex[c]).collect())
        .collect(),
    }
}

/// The unit cube in cells, its nodes, mid-sides included, moved by `map`.
pub fn structured(kind: ElementKind, divisions: [usize; 3], map: impl Fn([f64; 3]) -> Point3<f64>) -> Mesh {
    let mut mesh = Mesh {
        nodes: Vec::new(),
        kinds: Vec::new(),
        offsets: vec![0],
        connectivity: Vec::new(),
        parts: Vec::new(),
        part_names: vec!["body".to_owned()],
        groups: Vec::new(),
    };
    let mut index: HashMap<[usize; 3], usize> = HashMap::new();
    let [nx, ny, nz] = divisions;
    for cell in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k]))) {
        for corners in pieces(kind) {
            // Positions on the lattice of twice the resolution.
            let mut lattice: Vec<[usize; 3]> = corners
                .iter()
                .map(|c| [0, 1, 2].map(|k| 2 * (cell[k] + c[k])))
                .collect();
            if kind.order() == 2 {
                for &[a, b] in kind.edges() {
                    lattice.push([0, 1, 2].map(|k| (lattice[a][k] + lattice[b][k]) / 2));
                }
            }
            for natural in kind.natural_nodes().iter().skip(lattice.len()) {
                lattice.push([0, 1, 2].map(|k| 2 * cell[k] + (natural[k] + 1.0) as usize));
            }
            for l in lattice {
                let node = *index.entry(l).or_insert_with(|| {
                    let x = [0, 1, 2].map(|k| l[k] as f64 / (2 * divisions[k]) as f64);
                    mesh.nodes.push(map(x));
                    mesh.nodes.len() - 1
                });
                mesh.connectivity.push(node);
            }
            mesh.offsets.push(mesh.connectivity.len());
            mesh.kinds.push(kind);
            mesh.parts.push(0);
        }
    }
    mesh
}

/// One mesh of several whose common nodes coincide.
pub fn merged(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh {
        nodes: Vec::new(),
        kinds: Vec::new(),
        offsets: vec![0],
        connectivity: Vec::new(),
        parts: Vec::new(),
        part_names: vec!["body".to_owned()],
        groups: Vec::new(),
    };
    let mut index: HashMap<[i64; 3], usize> = HashMap::new();
    for mesh in meshes {
        for element in mesh.elements() {
            for &node in element.nodes {
                let p = mesh.nodes[node];
                let key = [p.x, p.y, p.z].map(|v| (v * 1e7).round() as i64);
                let node = *index.entry(key).or_insert_with(|| {
                    all.nodes.push(p);
                    all.nodes.len() - 1
                });
                all.connectivity.push(node);
            }
            all.offsets.push(all.connectivity.len());
            all.kinds.push(element.kind);
            all.parts.push(0);
        }
    }
    all
}

/// Six Gauss points a direction collapsed onto the shape: more than any rule of the assembly has.
pub fn fine_rule(kind: ElementKind) -> Vec<([f64; 3], f64)> {
    let gauss = gauss_legendre(5);
    let mut points = Vec::new();
    for &(u, wu) in &gauss {
        for &(v, wv) in &gauss {
            for &(t, wt) in &gauss {
                let w = wu * wv * wt;
                let (p, q, r) = ((1.0 + u) / 2.0, (1.0 + v) / 2.0, (1.0 + t) / 2.0);
                points.push(match kind.corners() {
                    8 => ([u, v, t], w),
                    6 => ([p, (1.0 - p) * q, t], w * (1.0 - p) / 4.0),
                    _ => (
                        [p, (1.0 - p) * q, (1.0 - p) * (1.0 - q) * r],
                        w * (1.0 - p).powi(2) * (1.0 - q) / 8.0,
                    ),
                });
            }
        }
    }
    points
}

/// A x of a symmetric matrix stored as its lower triangle.
pub fn times(a: &CscMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut y = DMatrix::zeros(x.nrows(), x.ncols());
    for (j, column) in a.col_iter().enumerate() {
        for (&i, &value) in column.row_indices().iter().zip(column.values()) {
            for c in 0..x.ncols() {
                y[(i, c)] += value * x[(j, c)];
                if i != j {
                    y[(j, c)] += value * x[(i, c)];
                }
            }
        }
    }
    y
}

/// Solves A x = b by conjugate gradients with the diagonal as preconditioner.
pub fn conjugate_gradients(a: &CscMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut diagonal = DMatrix::zeros(b.nrows(), 1);
    a.triplet_iter()
        .filter(|t| t.0 == t.1)
        .for_each(|(i, _, &v)| diagonal[i] = v);
    let (mut x, mut r) = (DMatrix::zeros(b.nrows(), 1), b.clone());
    let mut z = r.component_div(&diagonal);
    let mut p = z.clone();
    let mut rz = r.dot(&z);
    for _ in 0..4000 {
        if r.norm() < 1e-11 * b.norm() {
            return x;
        }
        let ap = times(a, &p);
        let alpha = rz / p.dot(&ap);
        x += &p * alpha;
        r -= ap * alpha;
        z = r.component_div(&diagonal);
        let next = r.dot(&z);
        p = &z + p * (next / rz);
        rz = next;
    }
    panic!("not converged: {:e}", r.norm() / b.norm());
}
