//! Building blocks of acoustics and finite elements on a user's own meshes and records.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{Boundary, BoundaryMesh, Exterior, Panel};
use nailnoise_acoustics::jets::{ExhaustSettings, FlowHistory, Opening, exhaust_noise};
use nailnoise_acoustics::signals::fourier::{Transform, TransformSettings};
use nailnoise_acoustics::signals::{
    REFERENCE_PRESSURE, Weighting, energy_level, energy_weights, exposure_level, peak_level, third_octaves,
};
use nailnoise_fem::{Constraints, Material, ModalSettings, Orthotropic, assemble, modes};
use nailnoise_meshes::{ElementKind, FaceKind, Mesh};
use nalgebra::{DMatrix, Matrix3, Point3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Refused;
use crate::values::floats;
use crate::work;

/// An error of a building block as that of an argument.
fn wrong(error: impl std::fmt::Display) -> Refused {
    Refused::Value(error.to_string())
}

/// Power \[W\] that a closed surface of triangles radiates into free air at 20 degC and 101 325 Pa: points \[m\],
/// triangles (their corners counter-clockwise from outside), a normal velocity for each point \[m/s, rms\], and the
/// frequency \[Hz\].
#[pyfunction]
pub(crate) fn radiated_power(
    py: Python<'_>,
    points: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    velocity: Vec<f64>,
    hz: f64,
) -> PyResult<f64> {
    work::off_the_lock(py, None, move |_| {
        let outside = triangles.iter().flatten().any(|node| *node >= points.len());
        if outside || velocity.len() != points.len() || !(hz.is_finite() && hz > 0.0) {
            return Err(Refused::Value(
                "triangles index points, there is a velocity for each point, and the frequency is above 0".to_owned(),
            ));
        }
        let panels = triangles
            .iter()
            .filter_map(|nodes| Panel::new(FaceKind::Tri3, nodes, 0))
            .collect();
        let mesh = BoundaryMesh {
            points: points.into_iter().map(Point3::from).collect(),
            panels,
            patches: vec!["surface".to_owned()],
        };
        let boundary = Boundary::new(mesh, None).map_err(wrong)?;
        let exterior = Exterior::new(boundary, &Air::default());
        if exterior.boundary().velocity_values() != 3 * triangles.len() {
            return Err(Refused::Value("the surface has triangles without area".to_owned()));
        }
        let of_corners = triangles.iter().flatten().map(|node| velocity[*node]);
        let pattern = DMatrix::from_iterator(3 * triangles.len(), 1, of_corners);
        let resistance = exterior.resistance(hz, &pattern).map_err(wrong)?;
        Ok(resistance.far_field[(0, 0)])
    })
}

/// Kind of an element by the number of its nodes.
fn kind_of(nodes: usize) -> Result<ElementKind, Refused> {
    let kind = ElementKind::ALL.into_iter().find(|kind| kind.nodes() == nodes);
    kind.ok_or_else(|| {
        wrong(format!(
            "there is no element of {nodes} nodes; elements have 4, 8, 10, 15, 20 or 27, in the order of VTK"
        ))
    })
}

/// All modes below `top_hz` \[Hz\] of a mesh of one material. The arguments are nodes \[m\], elements by their nodes in
/// the order of VTK, Young's moduli E_1 to E_3, shear moduli G_12, G_13, G_23 \[Pa\], Poisson ratios nu_12, nu_13,
/// nu_23, density \[kg/m3\], and nodes that are fixed.
#[pyfunction]
pub(crate) fn mesh_modes<'py>(
    py: Python<'py>,
    nodes: Vec<[f64; 3]>,
    elements: Vec<Vec<usize>>,
    constants: [f64; 9],
    density: f64,
    top_hz: f64,
    held: Vec<usize>,
) -> PyResult<Bound<'py, PyDict>> {
    let basis = work::off_the_lock(py, None, move |_| {
        let count = nodes.len();
        if elements.iter().flatten().chain(&held).any(|node| *node >= count) {
            return Err(wrong("an element or a held node is not among the nodes"));
        }
        let kinds = elements.iter().map(|own| kind_of(own.len()));
        let ends = elements.iter().scan(0, |end, own| {
            *end += own.len();
            Some(*end)
        });
        let mesh = Mesh {
            kinds: kinds.collect::<Result<_, _>>()?,
            offsets: [0].into_iter().chain(ends).collect(),
            parts: vec![0; elements.len()],
            connectivity: elements.iter().flatten().copied().collect(),
            nodes: nodes.into_iter().map(Point3::from).collect(),
            part_names: vec!["body".to_owned()],
            groups: Vec::new(),
        };
        let [e1, e2, e3, g12, g13, g23, nu12, nu13, nu23] = constants;
        let orthotropic = Orthotropic {
            e1,
            e2,
            e3,
            g12,
            g13,
            g23,
            nu12,
            nu13,
            nu23,
        };
        let material = Material::orthotropic(&orthotropic, &Matrix3::identity(), density).map_err(wrong)?;
        let mut constraints = Constraints::free();
        for node in held {
            (0..3).for_each(|axis| constraints.hold(node, axis));
        }
        let system = assemble(&mesh, &[material], &constraints).map_err(wrong)?;
        modes(&system, &ModalSettings::below(top_hz), &|_, _| ()).map_err(wrong)
    })?;
    let made = PyDict::new(py);
    made.set_item("hz", floats(py, &basis.hz))?;
    made.set_item("rigid", basis.rigid.clone())?;
    made.set_item("residuals", floats(py, &basis.residuals))?;
    made.set_item("modes_there_are", basis.sturm.count)?;
    let values = basis.shapes.nrows() * basis.hz.len();
    made.set_item("shapes", floats(py, &basis.shapes.as_slice()[..values]))?;
    Ok(made)
}

/// Bands as rows: nominal frequency \[Hz\], unweighted and A-weighted level \[dB\], none for silence.
type Bands = Vec<(f64, Option<f64>, Option<f64>)>;

/// Levels of the noise of round holes from the flow through them. The arguments are mass flow \[kg/s\], absolute
/// stagnation pressure \[Pa\] and temperature \[K\] before them at intervals of `sample_interval` \[s\]; number,
/// diameter \[m\], discharge coefficient and pitch \[m\] of the holes; temperature \[K\] and pressure \[Pa\] of the
/// air. The A-weighted level, that of each part, and the bands \[dB re 1 pW s\].
#[pyfunction]
#[allow(clippy::too_many_arguments)] // they are those of the Python function
pub(crate) fn exhaust_levels<'py>(
    py: Python<'py>,
    sample_interval: f64,
    mass_flow: Vec<f64>,
    pressure: Vec<f64>,
    temperature: Vec<f64>,
    holes: (usize, f64, f64, Option<f64>),
    air: (f64, f64),
    range_hz: [f64; 2],
) -> PyResult<Bound<'py, PyDict>> {
    let noise = work::off_the_lock(py, None, move |_| {
        let flow = FlowHistory {
            sample_interval,
            mass_flow,
            pressure,
            temperature,
            back_pressure: None,
        };
        let (count, diameter, discharge_coefficient, pitch) = holes;
        let opening = Opening {
            count,
            diameter,
            discharge_coefficient,
            pitch,
        };
        let settings = ExhaustSettings {
            transform: TransformSettings {
                range_hz,
                ..TransformSettings::default()
            },
            ..ExhaustSettings::default()
        };
        let air = Air::at(air.0, air.1).map_err(wrong)?;
        exhaust_noise("exhaust", &flow, &opening.merged(), &air, &settings).map_err(wrong)
    })?;
    let spectrum = &noise.spectrum;
    let parts = spectrum.contribution_energies(range_hz, Weighting::A).into_iter();
    let parts: Vec<(String, Option<f64>)> = parts.map(|(name, energy)| (name, energy_level(energy))).collect();
    let bands = spectrum.band_levels(range_hz).into_iter();
    let bands: Bands = bands.map(|own| (own.band.nominal_hz(), own.lw, own.lwa)).collect();
    let made = PyDict::new(py);
    made.set_item("lwa", spectrum.level(range_hz, Weighting::A))?;
    made.set_item("lw", spectrum.level(range_hz, Weighting::Z))?;
    made.set_item("parts", parts)?;
    made.set_item("bands", bands)?;
    made.set_item("mass", noise.mass)?;
    made.set_item("jet_mass", noise.jet_mass)?;
    made.set_item("frequency", floats(py, &spectrum.frequency))?;
    made.set_item("energy_density", floats(py, &spectrum.energy_density))?;
    Ok(made)
}

/// Levels of a record of sound pressure \[Pa\]: sound exposure levels A, C and Z, peak levels C and Z \[dB re 20 uPa\],
/// and one-third-octave bands of the sound exposure level.
#[pyfunction]
pub(crate) fn signal_levels<'py>(
    py: Python<'py>,
    pressure: Vec<f64>,
    sample_rate: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let (exposures, peaks, bands) = work::off_the_lock(py, None, move |_| {
        let dt = 1.0 / sample_rate;
        let exposure = |weighting| exposure_level(&pressure, dt, weighting).map_err(wrong);
        let peak = |weighting| peak_level(&pressure, dt, weighting).map_err(wrong);
        let exposures = [
            exposure(Weighting::A)?,
            exposure(Weighting::C)?,
            exposure(Weighting::Z)?,
        ];
        let peaks = [peak(Weighting::C)?, peak(Weighting::Z)?];
        Ok((exposures, peaks, bands_of(&pressure, dt)?))
    })?;
    let made = PyDict::new(py);
    let [a, c, z] = exposures;
    made.set_item("exposure", [("A", a), ("C", c), ("Z", z)].to_vec())?;
    let [c, z] = peaks;
    made.set_item("peak", [("C", c), ("Z", z)].to_vec())?;
    made.set_item("bands", bands)?;
    Ok(made)
}

/// Bands of the sound exposure of a record, up to half its sampling frequency.
///
/// ```text
/// E(f) = 2 |P(f)|^2      L_E = 10 lg( integral E df / ((20 uPa)^2 x 1 s) )
/// ```
fn bands_of(pressure: &[f64], dt: f64) -> Result<Bands, Refused> {
    let top = (0.5 / dt).min(22_500.0);
    let settings = TransformSettings {
        range_hz: [20.0, top * (1.0 - 1e-9)],
        taper: 0.0,
        ..TransformSettings::default()
    };
    let transform = Transform::new(pressure.len(), dt, &settings).map_err(wrong)?;
    let frequency = transform.frequencies();
    let lines = transform.apply(pressure).map_err(wrong)?;
    let density: Vec<f64> = lines.iter().map(|line| 2.0 * line.norm_sqr()).collect();
    let bands = third_octaves().into_iter().filter(|band| band.high <= top);
    let level = |range: [f64; 2], weighting| {
        let weights = energy_weights(&frequency, range, weighting);
        let exposure: f64 = density.iter().zip(weights).map(|(e, w)| e * w).sum();
        (exposure > 0.0).then(|| 10.0 * (exposure / REFERENCE_PRESSURE.powi(2)).log10())
    };
    let row = |band: nailnoise_acoustics::signals::Band| {
        let range = [band.low, band.high];
        (
            band.nominal_hz(),
            level(range, Weighting::Z),
            level(range, Weighting::A),
        )
    };
    Ok(bands.map(row).collect())
}
