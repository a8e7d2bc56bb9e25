//! Radiation in closed form: spheres, polar caps, a free disc, a baffled piston.

use std::f64::consts::{PI, TAU};

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, Exterior, Parity, Patterns, Plate, WetSides};
use nailnoise_acoustics::radiation::RadiatingSurface;
use nailnoise_acoustics::radiation::flush_with_sand::Rayleigh;
use nailnoise_meshes::gauss_legendre;
use nalgebra::{Complex, DMatrix, Point3, Vector3};

use super::panels::{quarter_disc, sphere};
use super::row::{Case, Row};
use crate::error::Error;

const PULSATING: Case = Case {
    name: "pulsating sphere",
    source: "z_0 = j x/(1 + j x), closed form",
};
const OSCILLATING: Case = Case {
    name: "oscillating sphere",
    source: "z_1 = j x (1 + j x)/(2 - x² + 2 j x), closed form",
};
const CAP: Case = Case {
    name: "polar cap on a sphere",
    source: "series of Legendre polynomials (Morse and Ingard, Theoretical Acoustics, 7.2)",
};
const DISC: Case = Case {
    name: "free rigid disc",
    source: "dipole of the force on Lamb's mass 8/3 rho a³ (Hydrodynamics, sec. 102): 16/(27 pi²) (ka)⁴ of both sides",
};
const PISTON: Case = Case {
    name: "baffled piston",
    source: "1 - J_1(2 ka)/ka, closed form",
};

/// Number of latitudes and longitudes of the panelled sphere; the cap ends at a latitude.
const RINGS: usize = 15;
const AROUND: usize = 20;

/// Number of panel rings in the cap.
const CAP_RINGS: usize = 3;

/// Specific resistances Re(-j h_n/h_n') = 1/(x² |h_n'|²) of a sphere, orders 0 to `highest`, with the spherical Hankel
/// functions of the second kind by upward recurrence: h_{n+1} = (2n+1)/x h_n - h_{n-1}, h_n' = h_{n-1} - (n+1)/x h_n.
fn resistances(x: f64, highest: usize) -> Vec<f64> {
    let j = Complex::<f64>::i();
    // h_{-1} = e^{-jx}/x and h_0 = j e^{-jx}/x.
    let first = Complex::from_polar(1.0 / x, -x);
    let (mut before, mut own) = (first, j * first);
    let mut resistances = Vec::with_capacity(highest + 1);
    for n in 0..=highest {
        let slope = before - own * ((n as f64 + 1.0) / x);
        resistances.push(1.0 / (x * x * slope.norm_sqr()));
        (before, own) = (own, own * ((2.0 * n as f64 + 1.0) / x) - before);
    }
    resistances
}

/// Legendre polynomials P_0 to P_highest at c.
fn legendre(c: f64, highest: usize) -> Vec<f64> {
    let mut p = vec![1.0, c];
    for n in 1..highest {
        let n = n as f64;
        let [.., before, own] = p[..] else { break };
        p.push(((2.0 * n + 1.0) * c * own - n * before) / (n + 1.0));
    }
    p
}

/// Radiation resistance, divided by rho c 4 pi a², of a cap that moves radially up to the colatitude `edge`: sum U_n²
/// Re z_n/(2n + 1), U_0 = (1 - cos)/2, U_n = (P_{n-1} - P_{n+1})/2 at the edge.
fn cap_series(x: f64, edge: f64) -> f64 {
    // Above x, the resistance decreases faster than any power of the order.
    let highest = 40;
    let p = legendre(edge.cos(), highest + 1);
    let u = |n: usize| {
        if n == 0 {
            0.5 * (1.0 - p[1])
        } else {
            0.5 * (p[n - 1] - p[n + 1])
        }
    };
    let r = resistances(x, highest);
    (0..=highest)
        .map(|n| u(n).powi(2) * r[n] / (2.0 * n as f64 + 1.0))
        .sum()
}

pub(super) fn spheres() -> Result<Vec<Row>, Error> {
    let air = Air::default();
    let edge = PI * CAP_RINGS as f64 / RINGS as f64;
    let boundary = Boundary::new(sphere(RINGS, AROUND), None)?;
    // Panels are numbered ring by ring, starting at the pole.
    let velocities = boundary.project(3, |panel, _, point, v| {
        let cap = f64::from(u8::from(panel < CAP_RINGS * AROUND));
        v.copy_from_slice(&[1.0, point.area_vector().normalize().z, cap]);
    });
    let exterior = Exterior::new(boundary, &air).with_panels_per_wavelength(1.0)?;
    let whole = air.impedance() * 4.0 * PI;
    let mut rows = Vec::new();
    // pi is a resonance of the interior.
    for (x, name) in [(0.2, "0.2"), (1.0, "1"), (PI, "pi"), (5.0, "5")] {
        let found = exterior.resistance(x * air.sound_speed / TAU, &velocities)?.far_field;
        let exact = resistances(x, 1);
        let row = |case: Case, i: usize, reference: f64, part: f64| {
            let computed = found[(i, i)] / whole;
            let row = case.row(format!("resistance at ka {name}"), reference, computed);
            row.within_part(part).decimals(6)
        };
        rows.push(row(PULSATING, 0, exact[0], 1e-3));
        rows.push(row(OSCILLATING, 1, exact[1] / 3.0, 1e-3));
        rows.push(row(CAP, 2, cap_series(x, edge), 5e-3));
    }
    rows.sort_by_key(|row| [PULSATING, OSCILLATING, CAP].iter().position(|case| *case == row.case));
    Ok(rows)
}

/// Resistance of a free rigid disc, divided by rho c pi a².
fn disc_resistance(plate: &Plate, patterns: &Patterns, ka: f64, air: &Air) -> Result<f64, Error> {
    let z = plate.impedance(ka * air.sound_speed / TAU, patterns)?;
    Ok(z[(0, 0)].re / (air.impedance() * PI))
}

pub(super) fn flat() -> Result<Vec<Row>, Error> {
    let air = Air::default();
    let mut rows = Vec::new();
    let midplane = Boundary::flat(quarter_disc(6), [Some(0.0); 2])?;
    let patterns = Patterns {
        parity: Parity::default(),
        velocities: midplane.project(1, |_, _, _, v| v.fill(1.0)),
    };
    let plate = Plate::new(midplane, &air, WetSides::Both);
    let [low, high] = [0.05, 0.1];
    let found = [
        disc_resistance(&plate, &patterns, low, &air)?,
        disc_resistance(&plate, &patterns, high, &air)?,
    ];
    let exact = 16.0 / (27.0 * PI * PI) * low.powi(4);
    rows.push(
        DISC.row("resistance at ka 0.05, 1e-7", 1e7 * exact, 1e7 * found[0])
            .within_part(0.01)
            .decimals(4),
    );
    let slope = (found[1] / found[0]).log2();
    rows.push(
        DISC.row("power of ka, 0.05 to 0.1", 4.0, slope)
            .within(0.02)
            .decimals(4),
    );

    let rayleigh = Rayleigh::new(&piston(12, 40)?, &air)?;
    for ka in [0.5, 1.0, 2.0, 5.0] {
        let resistance: f64 = rayleigh
            .resistance(ka * air.sound_speed / TAU)
            .iter()
            .map(|patch| patch.real[(0, 0)])
            .sum();
        let exact = 1.0 - libm::j1(2.0 * ka) / ka;
        let computed = resistance / (air.impedance() * PI);
        rows.push(
            PISTON
                .row(format!("resistance at ka {ka}"), exact, computed)
                .within_part(1e-6)
                .decimals(7),
        );
    }
    Ok(rows)
}

/// A unit disc in the plane z = 0: Gauss points along the radius, equal steps in azimuth.
fn piston(rings: usize, around: usize) -> Result<RadiatingSurface, Error> {
    let (mut points, mut areas) = (Vec::new(), Vec::new());
    for (x, weight) in gauss_legendre(rings) {
        let radius = 0.5 * (1.0 + x);
        for i in 0..around {
            let (sine, cosine) = (TAU * (i as f64 + 0.5) / around as f64).sin_cos();
            points.push(Point3::new(radius * cosine, radius * sine, 0.0));
            areas.push(0.5 * weight * radius * TAU / around as f64);
        }
    }
    let count = points.len();
    let (normals, patches) = (vec![Vector3::z(); count], vec!["piston".to_owned()]);
    Ok(RadiatingSurface::new(
        points,
        normals,
        areas,
        vec![0; count],
        patches,
        DMatrix::from_element(count, 1, 1.0),
    )?)
}
