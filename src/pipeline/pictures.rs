//! The sound of a shot as pictures, one-third octave by one-third octave: on the surfaces, in planes and all around.
//!
//! Nothing of it is kept with a run: pressures in thousands of places are a hundred times what levels need. They are
//! computed when they are asked for, and kept then.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{BandFields, MeshRange, ModalBem, SurfaceBand, WholeSurface};
use nailnoise_acoustics::levels::{Band, Weighting, third_octaves};
use nailnoise_acoustics::radiation::{LowRank, ModalSpectra, quadratic_forms, radiated_energy};
use nailnoise_acoustics::sound::{Around, BandSound, Directions, above_plane};
use nailnoise_meshes::{Surface, open_faces};
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::microphones::reflecting_plane;
use super::radiator::Radiator;
use super::told;
use super::vibration::{Bench, Moved, Vibration, moved};
use super::{Body, Driven, Options, driving};
use crate::design::inputs::radiation as inputs;
use crate::design::{Coupling, Design};
use crate::error::Error;
use crate::result::{Check, Timing};
use crate::stages::Progress;
use crate::stages::radiation::{FACE_POINTS, radiating_surface};
use crate::stages::spectra::side_by_side;
use crate::store::Store;

/// Half side of the planes \[m\].
const HALF_SIDE: f64 = 1.0;

/// How far the upright planes reach above what is nailed \[m\].
const ABOVE: f64 = 1.0;

/// Height of the level plane above what is nailed \[m\]: far enough for all meshes of its surface.
const LEVEL: f64 = 0.1;

/// Distance of neighbouring points of a plane \[m\].
const SPACING: f64 = 0.06;

/// Rings of the half sphere, and directions of each: they integrate the far field of a body of k a = 46.
const SPHERE: [usize; 2] = [24, 96];

/// Radius at which the half sphere is drawn \[m\].
const DRAWN: f64 = 1.0;

/// Reference of sound exposure, (20 uPa)² over 1 s \[Pa² s\].
const EXPOSURE: f64 = 4e-10;

/// Reference of velocity exposure, (50 nm/s)² over 1 s \[m2/s\].
const VELOCITY: f64 = 2.5e-15;

/// Levels shown below the highest of a field \[dB\].
const SHOWN: f64 = 60.0;

/// Largest difference of the energy in a picture from the source's \[dB\].
const DIFFERENCE: f64 = 0.1;

/// The sound of a shot in pictures.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Pictures {
    /// How the workpiece's sound is computed.
    pub method: String,
    /// What the pictures show and what they do not.
    pub notes: Vec<String>,
    /// Whether they hold the energy of the source.
    pub checks: Vec<Check>,
    /// The pictures.
    pub series: Vec<Series>,
}

/// One surface with fields, band by band.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// Shapes that bands refer to.
    pub shapes: Vec<Shape>,
    /// The bands, rising.
    pub bands: Vec<Picture>,
}

/// Points and polygons.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Shape {
    /// Positions \[m\].
    pub points: Vec<[f64; 3]>,
    /// Corners of every polygon.
    pub polygons: Vec<Vec<usize>>,
}

/// Fields of one band.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Picture {
    /// Nominal mid-band frequency \[Hz\].
    pub hz: f64,
    /// Number of its shape.
    pub shape: usize,
    /// Fields on the points: name with unit, values.
    pub points: Vec<(String, Vec<f64>)>,
    /// Fields on the polygons.
    pub polygons: Vec<(String, Vec<f64>)>,
}

/// Pictures of a design's shot, from the cache where a cycle drives the bodies one way and they are known.
///
/// # Errors
/// [`Error`] of the stage that could not be computed.
pub fn pictures(design: &Design, cache: &Store, progress: &Progress) -> Result<Pictures, Error> {
    let mut timing = Timing::default();
    let bench = Bench::new(design, Options::default(), cache)?;
    let lumped = match design.support.coupling {
        Coupling::OneWay => driving(design, &mut timing, progress)?,
        Coupling::TwoWay => return compute(&bench, None, progress),
    };
    let key = told::key(design, bench.options, &lumped);
    cache.get_or("sound in pictures", key, || compute(&bench, Some(lumped), progress))
}

fn compute(
    bench: &Bench<'_>,
    lumped: Option<nailnoise_dynamics::CycleRecord>,
    progress: &Progress,
) -> Result<Pictures, Error> {
    let (moved, ..) = moved(bench, lumped, &mut Timing::default(), progress)?;
    let Moved {
        vibration, radiator, ..
    } = moved;
    let (design, air) = (bench.design, &bench.air);
    progress.stage("sound in pictures");
    let mut pictures = match &radiator {
        Radiator::Bem(bem) => standing(design, air, bem, &vibration)?,
        Radiator::Rayleigh(of_top) => {
            let radiated = radiated_energy("workpiece", &of_top.sound.waves, &vibration.spectra[0])?;
            let energy = |band: &Band| radiated.energy([band.low, band.high], Weighting::Z);
            flush(design, air, &vibration, energy)?
        }
        Radiator::Erp(_) => Pictures {
            method: "equivalent radiated power".to_owned(),
            notes: vec![
                "the workpiece is radiated with efficiency 1 (acoustics.method = \"erp\"): it knows no pressure, no \
                 directions and no field, so the pictures show the velocity of its surfaces and what that would radiate; \
                 boundary elements (acoustics.method = \"bem\") know all of them"
                    .to_owned(),
            ],
            checks: Vec::new(),
            series: Vec::new(),
        },
    };
    let of_tool = vibration.tool.as_ref().zip(inputs::tool(design));
    if let Some((tool, elements, bem)) = of_tool.and_then(|(tool, elements)| Some((tool, elements, tool.bem.as_ref()?)))
    {
        let body = Solved {
            names: ["body", "sound-tool"],
            levels: vec![elements.level(&tool.body.moving_surface(), air)?],
            bem,
            spectra: &tool.spectra,
            at: inputs::nose(design),
        };
        let of_tool = solved(design, body)?;
        pictures.notes.extend(of_tool.notes);
        pictures.checks.extend(of_tool.checks);
        pictures.series.extend(of_tool.series);
    }
    for driven in vibration.driven() {
        pictures.series.push(velocities(design, air, driven)?);
    }
    Ok(pictures)
}

/// The whole bands that a source's bins hold, below a top frequency.
fn bands(spectra: &ModalSpectra, top: f64) -> Vec<Band> {
    let [low, high] = spectra.range_hz;
    let whole = |b: &Band| b.low >= low * (1.0 - 1e-9) && b.high <= high.min(top) * (1.0 + 1e-9);
    third_octaves().into_iter().filter(whole).collect()
}

/// A body that boundary elements know.
struct Solved<'a> {
    /// Its source, and the beginning of its pictures' names.
    names: [&'static str; 2],
    levels: Vec<MeshRange>,
    bem: &'a ModalBem,
    spectra: &'a ModalSpectra,
    /// Where its axes begin in those of the workpiece.
    at: Vector3<f64>,
}

/// A source by boundary elements.
fn solved(design: &Design, body: Solved<'_>) -> Result<Pictures, Error> {
    let Solved {
        names: [source, prefix],
        levels,
        bem,
        spectra,
        at,
    } = body;
    let bands = bands(spectra, bem.solved_hz()[0]);
    let radiated = radiated_energy(source, bem, spectra)?;
    let mut planes = planes(design);
    let moved = |points: &[Point3<f64>]| -> Vec<Point3<f64>> { points.iter().map(|p| p - at).collect() };
    for level in &levels {
        planes
            .iter_mut()
            .for_each(|plane| plane.keep(|points| level.problem.is_clear(&moved(points))));
    }
    let floor = levels.first().and_then(|level| level.problem.boundary().floor());
    let rings = if floor.is_some() { SPHERE[0] } else { 2 * SPHERE[0] };
    let directions = Directions::new(rings, SPHERE[1], floor.is_some());
    let points: Vec<Point3<f64>> = planes.iter().flat_map(|plane| plane.points()).collect();
    let points = moved(&points);
    let around = Around {
        points: &points,
        directions: &directions.vectors,
    };
    let foot = levels
        .first()
        .map_or_else(Point3::origin, |level| level.problem.reach().1);
    let found = BandFields::new(levels, &bands, spectra, &around)?;
    let energies: Vec<f64> = bands
        .iter()
        .map(|b| radiated.energy([b.low, b.high], Weighting::Z))
        .collect();
    let left = |surface: &SurfaceBand| {
        let areas = &found.surfaces[surface.surface].areas;
        surface
            .intensity
            .iter()
            .zip(areas)
            .map(|(i, area)| i * area)
            .sum::<f64>()
    };
    let left: Vec<f64> = found.bands.iter().map(left).collect();
    let checks = vec![
        held([source, "intensity over the surface"], &left, &energies),
        held(
            [source, "directivity over all directions"],
            &sums(&found.around, &directions),
            &energies,
        ),
    ];
    let mut series = vec![on_surface(prefix, &found, &bands, at)];
    series.extend(in_planes(prefix, &planes, &found.around, &bands));
    series.push(sphere(prefix, &directions, &found.around, &bands, foot + at));
    let reaches = bands.last().map_or(0.0, |b| b.nominal_hz());
    Ok(Pictures {
        method: "boundary elements".to_owned(),
        notes: vec![format!(
            "{source} by boundary elements at {} frequencies, in the bands up to {reaches:.0} Hz that lie below the end of single \
             frequencies; error of the field between them {:.1e} of its largest value; the pressure is that of this source \
             alone, {}",
            found.around.samples,
            found.around.error,
            if floor.is_some() {
                "above a rigid floor"
            } else {
                "in free space"
            }
        )],
        checks,
        series,
    })
}

/// Block and table, or a block alone.
fn standing(design: &Design, air: &Air, bem: &ModalBem, vibration: &Vibration) -> Result<Pictures, Error> {
    let surfaces: Vec<_> = vibration.structure.bodies().map(Body::moving_surface).collect();
    let body = Solved {
        names: ["workpiece", "sound"],
        levels: inputs::workpiece_boundary_elements(design).levels(&surfaces, air)?,
        bem,
        spectra: &side_by_side(&vibration.spectra),
        at: Vector3::zeros(),
    };
    solved(design, body)
}

/// The block's top and the sand around it by Rayleigh's integral.
fn flush(design: &Design, air: &Air, vibration: &Vibration, energy: impl Fn(&Band) -> f64) -> Result<Pictures, Error> {
    let top = inputs::flush_top(design)?;
    let surface = top.rayleigh(&top.surface(&vibration.structure.workpiece.moving_surface())?, air)?;
    let spectra = &vibration.spectra[0];
    let bands = bands(spectra, f64::INFINITY);
    let mut planes = planes(design);
    planes
        .iter_mut()
        .for_each(|plane| plane.keep(|points| surface.is_clear(points)));
    let directions = Directions::new(SPHERE[0], SPHERE[1], true);
    let points: Vec<Point3<f64>> = planes.iter().flat_map(|plane| plane.points()).collect();
    let around = Around {
        points: &points,
        directions: &directions.vectors,
    };
    let found = above_plane(&surface, &bands, spectra, &around)?;
    let energies: Vec<f64> = bands.iter().map(energy).collect();
    let foot = Point3::new(0.0, 0.0, design.workpiece.thickness);
    let mut series = in_planes("sound", &planes, &found, &bands);
    series.push(sphere("sound", &directions, &found, &bands, foot));
    Ok(Pictures {
        method: "Rayleigh's integral".to_owned(),
        notes: vec![
            format!(
                "workpiece in sand by Rayleigh's integral at {} frequencies; error of the field between them {:.1e} of its \
                 largest value; absorbing sand takes the same share of the sound in every direction",
                found.samples, found.error
            ),
            "the pressure is that of the workpiece and the sand that moves with it alone: no exhaust, no tool; on the surface \
             itself Rayleigh's integral is not evaluated"
                .to_owned(),
        ],
        checks: vec![held(["workpiece", "directivity over all directions"], &sums(&found, &directions), &energies)],
        series,
    })
}

/// Energy in a picture of all bands beside the source's.
fn held([source, what]: [&str; 2], found: &[f64], radiated: &[f64]) -> Check {
    let decibels = 10.0 * (found.iter().sum::<f64>() / radiated.iter().sum::<f64>()).log10();
    Check::at_most(
        format!("pictures: {what} less the energy of the {source} in these bands [dB]"),
        decibels,
        DIFFERENCE,
    )
}

fn sums(found: &BandSound, directions: &Directions) -> Vec<f64> {
    let of_band =
        |column: nalgebra::DVectorView<'_, f64>| column.iter().zip(&directions.weights).map(|(e, w)| e * w).sum();
    found.directivity.column_iter().map(of_band).collect()
}

/// 10 lg of values over a reference, no lower than a floor below the highest.
fn decibels(values: impl Iterator<Item = f64> + Clone, reference: f64) -> Vec<f64> {
    let floor = values.clone().fold(f64::MIN_POSITIVE, f64::max) * 10f64.powf(-0.1 * SHOWN);
    values.map(|v| 10.0 * (v.max(floor) / reference).log10()).collect()
}

const PRESSURE: &str = "sound exposure level [dB re (20 uPa)2 s]";
const MOTION: &str = "velocity exposure level [dB re (50 nm/s)2 s]";

/// Pressure, intensity and velocity on the surface.
fn on_surface(prefix: &str, found: &BandFields, bands: &[Band], at: Vector3<f64>) -> Series {
    let shape = |surface: &WholeSurface| Shape {
        points: surface.points.iter().map(|p| (p + at).into()).collect(),
        polygons: surface.panels.clone(),
    };
    let picture = |(band, surface): (&Band, &SurfaceBand)| Picture {
        hz: band.nominal_hz(),
        shape: surface.surface,
        points: vec![(
            PRESSURE.to_owned(),
            decibels(surface.exposure.iter().copied(), EXPOSURE),
        )],
        polygons: vec![
            ("normal intensity [J/m2]".to_owned(), surface.intensity.clone()),
            (
                format!("normal {MOTION}"),
                decibels(surface.velocity.iter().copied(), VELOCITY),
            ),
        ],
    };
    Series {
        name: format!("{prefix}-surface"),
        shapes: found.surfaces.iter().map(shape).collect(),
        bands: bands.iter().zip(&found.bands).map(picture).collect(),
    }
}

fn in_planes(prefix: &str, planes: &[Plane], found: &BandSound, bands: &[Band]) -> Vec<Series> {
    let mut first = 0;
    let of_plane = |plane: &Plane| {
        let (shape, count) = (plane.shape(), plane.points().count());
        let rows = first..first + count;
        first += count;
        let picture = |(number, band): (usize, &Band)| Picture {
            hz: band.nominal_hz(),
            shape: 0,
            points: vec![(
                PRESSURE.to_owned(),
                decibels(
                    found.exposure.column(number).rows_range(rows.clone()).iter().copied(),
                    EXPOSURE,
                ),
            )],
            polygons: Vec::new(),
        };
        Series {
            name: format!("{prefix}-plane-{}", plane.name),
            shapes: vec![shape],
            bands: bands.iter().enumerate().map(picture).collect(),
        }
    };
    planes.iter().map(of_plane).collect()
}

/// The sphere of directions or its upper half, around a point.
fn sphere(prefix: &str, directions: &Directions, found: &BandSound, bands: &[Band], centre: Point3<f64>) -> Series {
    let (around, count) = (directions.around, directions.vectors.len());
    let mut polygons = Vec::new();
    for ring in (0..count - around).step_by(around) {
        for i in 0..around {
            let next = (i + 1) % around;
            polygons.push(vec![ring + i, ring + next, ring + around + next, ring + around + i]);
        }
    }
    polygons.push((count - around..count).collect());
    let whole: f64 = directions.weights.iter().sum();
    let picture = |(number, band): (usize, &Band)| {
        let energy = found.directivity.column(number);
        let mean = energy.iter().zip(&directions.weights).map(|(e, w)| e * w).sum::<f64>() / whole;
        Picture {
            hz: band.nominal_hz(),
            shape: 0,
            points: vec![
                (
                    "energy per solid angle [J/sr]".to_owned(),
                    energy.iter().copied().collect(),
                ),
                (
                    "directivity index [dB]".to_owned(),
                    decibels(energy.iter().copied(), mean.max(f64::MIN_POSITIVE)),
                ),
            ],
            polygons: Vec::new(),
        }
    };
    Series {
        name: format!("{prefix}-sphere"),
        shapes: vec![Shape {
            points: directions.vectors.iter().map(|d| (centre + d * DRAWN).into()).collect(),
            polygons,
        }],
        bands: bands.iter().enumerate().map(picture).collect(),
    }
}

/// Velocity of a body's surface, and what it would radiate with efficiency 1 where it meets the open air.
fn velocities(design: &Design, air: &Air, driven: Driven<'_>) -> Result<Series, Error> {
    let Driven { body, spectra, .. } = driven;
    let at = if body.name == "tool" {
        inputs::nose(design)
    } else {
        Vector3::zeros()
    };
    let open = open_faces(&body.surface, None)?;
    let radiating = radiating_surface(&body.surface, body.skin.as_view(), |point| open[point.face])?;
    let points: Vec<_> = body
        .surface
        .quadrature(FACE_POINTS)?
        .into_iter()
        .filter(|p| open[p.face])
        .collect();
    let faces: Vec<usize> = (0..open.len()).filter(|&face| open[face]).collect();
    let mut areas = vec![0.0; open.len()];
    points.iter().for_each(|point| areas[point.face] += point.weight);
    let mut pictures = Vec::new();
    for band in bands(spectra, f64::INFINITY) {
        let Some(covariance) = spectra.velocity_covariance([band.low, band.high], |_| 1.0) else {
            continue;
        };
        let mut normal = vec![0.0; open.len()];
        let forms = quadratic_forms(radiating.normal_modes(), &covariance);
        for (point, form) in points.iter().zip(forms) {
            normal[point.face] += form * point.weight / areas[point.face];
        }
        let nodal = LowRank::forms(&[LowRank::of(&covariance)], &body.skin).swap_remove(0);
        let vectors = nodal.chunks_exact(3).map(|axes| axes.iter().sum::<f64>());
        let of_faces = faces.iter().map(|&face| normal[face]);
        pictures.push(Picture {
            hz: band.nominal_hz(),
            shape: 0,
            points: vec![(MOTION.to_owned(), decibels(vectors, VELOCITY))],
            polygons: vec![
                (format!("normal {MOTION}"), decibels(of_faces.clone(), VELOCITY)),
                (
                    "energy per area with radiation efficiency 1 [J/m2]".to_owned(),
                    of_faces.map(|v| air.impedance() * v).collect(),
                ),
            ],
        });
    }
    Ok(Series {
        name: format!("velocity-{}", body.name),
        shapes: vec![shape_of(&body.surface, &faces, at)],
        bands: pictures,
    })
}

fn shape_of(surface: &Surface, faces: &[usize], at: Vector3<f64>) -> Shape {
    let corners = |&face: &usize| {
        let face = &surface.faces[face];
        face.nodes[..face.kind.corners()].to_vec()
    };
    Shape {
        points: surface.points.iter().map(|p| (p + at).into()).collect(),
        polygons: faces.iter().map(corners).collect(),
    }
}

/// A plane of points on a grid, of which some are left out.
struct Plane {
    name: &'static str,
    /// Columns of the grid, and its points row by row.
    columns: usize,
    grid: Vec<Point3<f64>>,
    shown: Vec<bool>,
}

impl Plane {
    fn new(name: &'static str, corner: Point3<f64>, sides: [Vector3<f64>; 2]) -> Self {
        let [columns, rows] = sides.map(|side| (side.norm() / SPACING).round() as usize + 1);
        let at = |row: usize, column: usize| {
            let share = |i: usize, n: usize| i as f64 / (n - 1) as f64;
            corner + sides[0] * share(column, columns) + sides[1] * share(row, rows)
        };
        let grid: Vec<Point3<f64>> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| at(row, column)))
            .collect();
        Self {
            name,
            columns,
            shown: vec![true; grid.len()],
            grid,
        }
    }

    /// Leaves out what does not pass.
    fn keep(&mut self, test: impl Fn(&[Point3<f64>]) -> Vec<bool>) {
        for (shown, passes) in self.shown.iter_mut().zip(test(&self.grid)) {
            *shown &= passes;
        }
    }

    /// The points that are left.
    fn points(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        self.grid
            .iter()
            .zip(&self.shown)
            .filter(|(_, shown)| **shown)
            .map(|(point, _)| *point)
    }

    fn shape(&self) -> Shape {
        let mut number = vec![usize::MAX; self.grid.len()];
        let left = (0..self.grid.len()).filter(|&i| self.shown[i]);
        left.enumerate().for_each(|(place, i)| number[i] = place);
        let corner = |i: usize| {
            let corners = [i, i + 1, i + self.columns + 1, i + self.columns];
            (!(i + 1).is_multiple_of(self.columns)).then_some(corners)
        };
        let squares = (0..self.grid.len() - self.columns - 1).filter_map(corner);
        Shape {
            points: self.points().map(Into::into).collect(),
            polygons: squares
                .filter(|corners| corners.iter().all(|&i| self.shown[i]))
                .map(|corners| corners.map(|i| number[i]).to_vec())
                .collect(),
        }
    }
}

/// Two upright planes through the axis of driving, and a level one above what is nailed.
fn planes(design: &Design) -> [Plane; 3] {
    let (x, y) = (design.nail.offset_along, design.nail.offset_across);
    let (low, top) = (reflecting_plane(design), design.workpiece.thickness);
    let side = 2.0 * HALF_SIDE;
    let up = Vector3::z() * (top + ABOVE - low);
    [
        Plane::new("xz", Point3::new(x - HALF_SIDE, y, low), [Vector3::x() * side, up]),
        Plane::new("yz", Point3::new(x, y - HALF_SIDE, low), [Vector3::y() * side, up]),
        Plane::new(
            "xy",
            Point3::new(x - HALF_SIDE, y - HALF_SIDE, top + LEVEL),
            [Vector3::x() * side, Vector3::y() * side],
        ),
    ]
}
