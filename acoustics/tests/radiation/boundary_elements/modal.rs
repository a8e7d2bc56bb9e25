//! Radiation of a block on a slab with independent volume meshes: closed surface, velocities, sampled matrix.

use std::f64::consts::TAU;
use std::sync::{Arc, LazyLock};

use nailnoise_acoustics::Air;
use nailnoise_acoustics::bem::{BemError, Boundary, BoundaryMesh, Exterior, MovingPart, Parity, Patterns, SolidBox};
use nailnoise_acoustics::radiation::boundary_elements::{
    BandFields, MeanRanges, MeshRange, ModalBem, ModalPressures, Receivers,
};
use nailnoise_acoustics::radiation::fluid_loading::Impedance;
use nailnoise_acoustics::radiation::radiator::{Detail, Loading, MovingBody, RadiatedSound, Radiator};
use nailnoise_acoustics::radiation::sound::{Directions, FieldPoints};
use nailnoise_acoustics::radiation::{ModalRadiation, ModalSpectra, Sampling, mode_energies};
use nailnoise_acoustics::signals::{Band, Weighting, energy_weights};
use nailnoise_meshes::{Block, Mesh, Surface, block};
use nalgebra::{Complex, DMatrix, Point3, Vector3};

/// Sizes of block and slab, the slab's top in the plane z = 0.
const SIZES: [[f64; 3]; 2] = [[0.2, 0.1, 0.06], [0.3, 0.24, 0.05]];
const PATCHES: [&str; 4] = ["block top", "block sides", "slab top", "slab rest"];

fn boxes() -> [SolidBox; 2] {
    [0, 1].map(|part| {
        let [x, y, z] = SIZES[part].map(|s: f64| s);
        let from = if part == 0 { 0.0 } else { -z };
        SolidBox {
            low: [-0.5 * x, -0.5 * y, from],
            high: [0.5 * x, 0.5 * y, from + z],
            part,
        }
    })
}

fn boundary(mirrors: [Option<f64>; 2], edge: f64) -> Boundary {
    let floor = Some(-0.1);
    let patches = PATCHES.map(str::to_owned).to_vec();
    let mesh = BoundaryMesh::of_boxes(&boxes(), [mirrors[0], mirrors[1], floor], edge, patches, |side| {
        2 * side.part + usize::from(!(side.axis == 2 && side.upper))
    });
    Boundary::symmetric(mesh.unwrap(), mirrors, floor).unwrap()
}

/// Displacements that volume elements of second order carry exactly: rigid motions, stretching, bending, twisting.
fn motion(at: Point3<f64>, mode: usize) -> Vector3<f64> {
    let Point3 { coords: c } = at;
    let (x, y, z) = (5.0 * c.x, 5.0 * c.y, 5.0 * c.z);
    match mode {
        0 => Vector3::z(),
        1 => Vector3::x(),
        2 => Vector3::new(0.0, -z, y),
        3 => Vector3::new(x, -0.3 * y, -0.3 * z),
        4 => Vector3::new(-2.0 * x * z, 0.0, x * x),
        5 => Vector3::new(-y * z, -x * z, x * y),
        // A combination of others, and one without symmetry.
        6 => motion(at, 0) * 0.5 - motion(at, 3),
        _ => Vector3::new(y * z, x + x * y, 0.3 * x - y * y),
    }
}

const MODES: usize = 8;

struct Solids {
    skins: [Surface; 2],
    modes: [DMatrix<f64>; 2],
}

/// Meshes whose faces match neither each other nor the panels.
fn solids() -> Solids {
    let meshes: [Mesh; 2] = [([5, 3, 2], 0), ([4, 5, 1], 1)].map(|(divisions, part)| {
        let low = boxes()[part].low;
        block(&Block {
            size: SIZES[part],
            divisions,
            origin: low,
        })
        .unwrap()
    });
    let skins = meshes.each_ref().map(Surface::of);
    let modes = |skin: &Surface| {
        DMatrix::from_fn(3 * skin.points.len(), MODES, |row, mode| {
            motion(skin.points[row / 3], mode)[row % 3]
        })
    };
    let modes = skins.each_ref().map(modes);
    Solids { skins, modes }
}

fn parts(solids: &Solids) -> [MovingPart<'_>; 2] {
    [0, 1].map(|part| MovingPart {
        skin: &solids.skins[part],
        modes: &solids.modes[part],
        patches: 2 * part..2 * part + 2,
    })
}

/// The parts' modes as one motion of the whole body.
fn together(patterns: &Patterns) -> DMatrix<f64> {
    let v = &patterns.velocities;
    v.columns(0, MODES) + v.columns(MODES, MODES)
}

#[test]
fn boxes_make_one_closed_surface() {
    let whole = boundary([None; 2], 0.06);
    let [block, slab] = SIZES;
    let sides = |s: [f64; 3]| 2.0 * (s[0] + s[1]) * s[2];
    let area = sides(block) + sides(slab) + 2.0 * slab[0] * slab[1];
    assert!((whole.mesh().area() / area - 1.0).abs() < 1e-12);
    assert_eq!(whole.repairs().flipped, 0);
    let quarter = boundary([Some(0.0); 2], 0.06);
    assert!((4.0 * quarter.mesh().area() / area - 1.0).abs() < 1e-12);
    assert!(whole.mesh().longest_edge() <= 0.06 + 1e-12);
}

#[test]
fn velocities_of_second_order_are_transferred_exactly_to_any_mesh() {
    let solids = solids();
    for edge in [0.15, 0.04, 0.011] {
        let whole = boundary([None; 2], edge);
        let [found] = <[Patterns; 1]>::try_from(whole.transfer(&parts(&solids)).unwrap()).unwrap();
        // The best fit to the same fields, taken at the panels' own points.
        let exact = whole.project(MODES, |_, _, point, values| {
            let normal = point.area_vector().normalize();
            for (mode, value) in values.iter_mut().enumerate() {
                *value = motion(point.position, mode).dot(&normal);
            }
        });
        let difference = (together(&found) - &exact).amax() / exact.amax();
        assert!(difference < 1e-12, "{edge} m: {difference:e}");
    }
}

#[test]
fn parities_sum_to_the_whole() {
    let solids = solids();
    let quarter = boundary([Some(0.0); 2], 0.04);
    let found = quarter.transfer(&parts(&solids)).unwrap();
    assert_eq!(found.len(), 4);
    let sum = found
        .iter()
        .fold(DMatrix::zeros(quarter.velocity_values(), MODES), |sum, p| {
            sum + together(p)
        });
    let exact = quarter.project(MODES, |_, _, point, values| {
        let normal = point.area_vector().normalize();
        for (mode, value) in values.iter_mut().enumerate() {
            *value = motion(point.position, mode).dot(&normal);
        }
    });
    assert!((sum - &exact).amax() < 1e-12 * exact.amax());
}

#[test]
fn heave_is_even_and_sway_is_odd() {
    let quarter = boundary([Some(0.0); 2], 0.04);
    let found = quarter.transfer(&parts(&solids())).unwrap();
    // Sway along x is odd in x.
    let size = |mode: usize| {
        found
            .iter()
            .map(|p| together(p).column(mode).amax())
            .collect::<Vec<_>>()
    };
    let parity: Vec<Parity> = found.iter().map(|p| p.parity).collect();
    let odd_x = parity.iter().position(|p| p.odd_x && !p.odd_y).unwrap();
    for (mode, class) in [(0, 0), (1, odd_x)] {
        for (c, amplitude) in size(mode).into_iter().enumerate() {
            assert!(
                (amplitude > 1e-12) == (c == class),
                "mode {mode}, parity {:?}",
                parity[c]
            );
        }
    }
}

#[test]
fn a_surface_that_the_volumes_do_not_cover_is_refused() {
    let solids = solids();
    let quarter = boundary([Some(0.0); 2], 0.06);
    let [block, _] = parts(&solids);
    let wrong = MovingPart { patches: 0..4, ..block };
    let error = quarter.transfer(&[wrong]).unwrap_err();
    assert!(matches!(error, BemError::Uncovered { .. }), "{error}");
}

fn level(solids: &Solids, edge: f64, per_wavelength: f64) -> MeshRange {
    let boundary = boundary([Some(0.0); 2], edge);
    let patterns = boundary.transfer(&parts(solids)).unwrap();
    let problem = Exterior::new(boundary, &Air::default())
        .with_panels_per_wavelength(per_wavelength)
        .unwrap();
    MeshRange {
        top_hz: problem.estimate().highest_hz,
        problem,
        patterns,
    }
}

/// The radiation matrix of both solids, sampled on two meshes, and a single mesh of the whole body.
struct Sampled {
    bem: ModalBem,
    /// Highest frequency of the finer mesh \[Hz\].
    top_hz: f64,
    /// Modal velocities on the whole body.
    velocities: DMatrix<f64>,
    /// Points of the receivers.
    points: Vec<Point3<f64>>,
}

/// The radiation matrix on meshes, with the pressures at receivers.
fn with_pressures(levels: impl Fn() -> Vec<MeshRange>, sampling: &Sampling, receivers: &Receivers) -> ModalBem {
    let (bem, surface) = ModalBem::solve(levels(), MeanRanges::default(), sampling, &|| ()).unwrap();
    bem.with_pressures(Arc::new(surface.at(receivers, &levels()).unwrap()))
        .unwrap()
}

static SAMPLED: LazyLock<Sampled> = LazyLock::new(|| {
    let solids = solids();
    let levels = || vec![level(&solids, 0.05, 6.0), level(&solids, 0.036, 6.0)];
    let top_hz = levels()[1].top_hz;
    let sampling = Sampling {
        range_hz: [40.0, top_hz],
        tolerance: 1e-2,
        floor: 1e-4,
        most_samples: 200,
    };
    let points = vec![Point3::new(0.7, 0.2, 0.5), Point3::new(-0.5, -0.6, 0.1)];
    let receivers = Receivers {
        points: points.clone(),
        origin: Point3::origin(),
    };
    Sampled {
        bem: with_pressures(levels, &sampling, &receivers),
        top_hz,
        velocities: whole().transfer(&parts(&solids)).unwrap().remove(0).velocities,
        points,
    }
});

/// Cold air at low pressure.
static COLD: LazyLock<Air> = LazyLock::new(|| Air::at(253.0, 80e3).unwrap());

/// The matrix of [`SAMPLED`] carried over to cold air.
static IN_COLD: LazyLock<ModalBem> = LazyLock::new(|| SAMPLED.bem.clone().in_air(&Air::default(), &COLD));

/// The whole body without symmetry, as fine as the finer mesh of [`SAMPLED`].
fn whole() -> Boundary {
    boundary([None; 2], 0.036)
}

/// Both airs, with the frequencies \[Hz\] at which the sampled matrix is compared with the whole body.
fn compared() -> [(&'static ModalBem, Exterior, Vec<f64>); 2] {
    let top = SAMPLED.top_hz;
    [
        (
            &SAMPLED.bem,
            Exterior::new(whole(), &Air::default()),
            vec![60.0, 333.0, 0.7 * top],
        ),
        (&IN_COLD, Exterior::new(whole(), &COLD), vec![333.0]),
    ]
}

/// Frequencies \[Hz\] and amplitudes of all modes.
static MOTION: LazyLock<(Vec<f64>, DMatrix<Complex<f64>>)> = LazyLock::new(|| {
    let frequency: Vec<f64> = (0..60).map(|i| 20.0 * 1.1f64.powi(i)).collect();
    let amplitudes = DMatrix::from_fn(2 * MODES, frequency.len(), |i, j| {
        Complex::new(
            (1.0 + i as f64 * 0.7 + j as f64).sin(),
            (i as f64 - 0.3 * j as f64).cos(),
        )
    });
    (frequency, amplitudes)
});

/// Asserts, bin by bin, that `value` over v^H R v / omega^2 is 1 within `tolerance`.
fn equals_the_form(of: &dyn ModalRadiation, tolerance: f64, value: impl Fn(usize) -> f64) {
    let (frequency, a) = &*MOTION;
    for (bin, hz) in frequency.iter().enumerate() {
        let form = of.resistance(*hz).form(a.column(bin).as_slice()) / (TAU * hz).powi(2);
        let value = value(bin);
        assert!((value / form - 1.0).abs() < tolerance, "{hz} Hz: {value:e} {form:e}");
    }
}

/// What levels need is the same without a report; sums of patches round differently in single precision.
#[test]
fn levels_without_a_report_are_those_of_a_report() {
    let accelerations = &MOTION.1;
    let frequency: Vec<f64> = (1..=accelerations.ncols()).map(|bin| 50.0 * bin as f64).collect();
    let spectra = ModalSpectra {
        frequency: frequency.clone(),
        accelerations: accelerations.clone(),
        range_hz: [frequency[0], frequency[frequency.len() - 1]],
    };
    let body = MovingBody {
        name: "both",
        omega: &[1000.0; 2 * MODES],
        modes: 2 * MODES,
        zeta: 0.01,
        loads: None,
        acts: Loading::Damping,
        spectra: &spectra,
    };
    let [levels, reported] =
        [Detail::Levels, Detail::Report].map(|detail| SAMPLED.bem.sound("both", &[body], detail).unwrap());
    assert!(levels.report.is_none() && reported.report.is_some());
    assert!(levels.spectrum.contributions.len() == 1 && reported.spectrum.contributions.len() > 1);
    let density = |sound: &RadiatedSound| sound.spectrum.energy_density.clone();
    for (hz, (found, expected)) in frequency
        .iter()
        .zip(density(&levels).into_iter().zip(density(&reported)))
    {
        assert!((found / expected - 1.0).abs() < 1e-5, "{hz} Hz: {found:e} {expected:e}");
    }
    let bounds = |sound: &RadiatedSound| [sound.uncertainty.minus, sound.uncertainty.plus].map(Option::unwrap);
    for (found, expected) in bounds(&levels).into_iter().zip(bounds(&reported)) {
        assert!((found - expected).abs() < 1e-3, "{found} dB, {expected} dB");
    }
}

#[test]
fn meshes_of_two_finenesses_agree_and_the_matrix_is_symmetric() {
    // For single modes, at six panels a wavelength of the coarser mesh.
    let summary = &SAMPLED.bem.summary;
    assert!(summary.difference_db < 0.7 && summary.asymmetry < 1e-2, "{summary:?}");
}

#[test]
fn the_sampled_matrix_equals_that_of_the_whole_body_in_any_air() {
    for (bem, exterior, frequencies) in compared() {
        for hz in frequencies {
            let found = bem.resistance(hz).real;
            let exact = exterior.resistance(hz, &SAMPLED.velocities).unwrap().far_field;
            let mut worst: f64 = 0.0;
            for i in 0..2 * MODES {
                for j in 0..2 * MODES {
                    let scale = (exact[(i, i)] * exact[(j, j)]).sqrt().max(1e-3 * exact.amax());
                    worst = worst.max((found[(i, j)] - exact[(i, j)]).abs() / scale);
                }
            }
            // The coarser mesh at its top frequency, 1144 Hz, has six panels a wavelength.
            assert!(worst < 5e-2, "{hz} Hz: {worst:e}");
        }
    }
}

#[test]
fn the_sampled_pressures_equal_those_of_the_whole_body_in_any_air() {
    for (bem, exterior, frequencies) in compared() {
        for hz in frequencies {
            let solution = exterior.solve(hz, &SAMPLED.velocities).unwrap();
            let [direct, by_floor] = exterior
                .pressure_at(&SAMPLED.points, &SAMPLED.velocities, &solution)
                .unwrap();
            let exact = (direct + by_floor) / Complex::new(0.0, TAU * hz);
            let largest = |m: DMatrix<Complex<f64>>| m.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let scale = largest(exact.clone());
            for mode in 0..2 * MODES {
                let a = DMatrix::from_fn(2 * MODES, 1, |i, _| Complex::from(f64::from(u8::from(i == mode))));
                let found = bem.pressures(&[hz], &a).unwrap();
                let off = largest(found - exact.columns(mode, 1)) / scale;
                assert!(off < 3e-2, "{hz} Hz, mode {mode}: {off:e}");
            }
        }
    }
}

#[test]
fn frequencies_scale_with_the_speed_of_sound() {
    let scale = IN_COLD.transition_hz()[1] / SAMPLED.bem.transition_hz()[1];
    assert!((scale - (253.0f64 / 293.15).sqrt()).abs() < 1e-9);
}

#[test]
fn heave_has_radiation_efficiency_1_at_high_frequencies() {
    // Radiation efficiency 1 is rho c int v_i v_j dS over all that faces up or down. Half an octave above the range the
    // resistance of flat faces oscillates around it.
    let top = SAMPLED.top_hz;
    for (bem, air) in [(&SAMPLED.bem, Air::default()), (&*IN_COLD, *COLD)] {
        let heave = |of: &dyn ModalRadiation, hz: f64| -> f64 {
            let r = of.resistance(hz).real;
            let pairs = [(0, 0), (0, MODES), (MODES, 0), (MODES, MODES)];
            pairs.iter().map(|&ij| r[ij]).sum()
        };
        let exact = air.impedance() * 2.0 * SIZES[1][0] * SIZES[1][1];
        assert!((heave(&bem.reference(), 2.0 * top) / exact - 1.0).abs() < 1e-9);
        for (hz, within) in [(2.0 * top, 0.05), (10e3, 0.01)] {
            let limit = heave(bem, hz);
            assert!((limit / exact - 1.0).abs() < within, "{hz} Hz: {limit:e} {exact:e}");
        }
    }
}

#[test]
fn solution_and_high_frequency_limit_are_compared_where_both_are_known() {
    let bem = &SAMPLED.bem;
    let compared = bem.compared_hz();
    assert!(compared[0] < bem.solved_hz()[0] && bem.solved_hz()[1] < bem.transition_hz()[0]);
    assert!(bem.transition_hz()[0] < compared[1] && compared[1] < bem.transition_hz()[1]);
    let hz = bem.transition_hz()[0];
    let unit = DMatrix::<Complex<f64>>::identity(2 * MODES, 2 * MODES);
    let limit: f64 = bem.limit_forms(&[hz; 2 * MODES], &unit).iter().sum();
    let mean = bem.energy_forms(&[hz; 2 * MODES], &unit).sum();
    // The gap under the slab is a third of a wavelength high, too narrow for the limit.
    let decibels = 10.0 * (limit / mean).log10();
    assert!(decibels.abs() < 3.0, "{decibels} dB");
}

#[test]
fn a_mean_over_frequency_is_close_to_single_frequencies() {
    let finer = Exterior::new(whole(), &Air::default());
    let finer = finer.with_panels_per_wavelength(5.0).unwrap();
    let hz = 1.06 * SAMPLED.top_hz;
    let single = finer.resistance(hz, &SAMPLED.velocities).unwrap().far_field.trace();
    let decibels = 10.0 * (SAMPLED.bem.resistance(hz).real.trace() / single).log10();
    assert!(decibels.abs() < 0.5, "{decibels} dB");
}

#[test]
fn energy_forms_equal_the_form_of_the_resistance() {
    let (frequency, a) = &*MOTION;
    for bem in [&SAMPLED.bem, &*IN_COLD] {
        let forms = bem.energy_forms(frequency, a);
        equals_the_form(bem, 1e-5, |bin| forms.column(bin).sum());
    }
}

#[test]
fn energy_forms_of_radiation_efficiency_1_equal_the_form_of_its_resistance() {
    let (frequency, a) = &*MOTION;
    let reference = IN_COLD.reference();
    let forms = reference.energy_forms(frequency, a);
    equals_the_form(&reference, 1e-5, |bin| forms.column(bin).sum());
}

#[test]
fn root_signals_carry_the_energy_of_the_resistance() {
    let (frequency, a) = &*MOTION;
    for bem in [&SAMPLED.bem, &*IN_COLD] {
        let signals = bem.root_signals(frequency, a);
        equals_the_form(bem, 3e-2, |bin| signals.column(bin).iter().map(Complex::norm_sqr).sum());
    }
}

#[test]
fn images_times_the_motion_equal_the_form_of_the_resistance() {
    let (frequency, a) = &*MOTION;
    let images = IN_COLD.images(frequency, a);
    equals_the_form(&*IN_COLD, 1e-10, |bin| a.column(bin).dotc(&images.column(bin)).re);
}

#[test]
fn the_impedance_times_the_motion_is_that_of_resistance_and_added_mass_in_any_air() {
    for bem in [&SAMPLED.bem, &*IN_COLD] {
        let modes = ModalRadiation::modes(bem);
        let hz = [30.0, 250.0, 250.0, 700.0];
        let v = DMatrix::from_fn(modes, hz.len(), |i, k| {
            Complex::new((i + k) as f64 - 3.0, (2 * i) as f64 - k as f64)
        });
        let found = bem.product(&hz, &v);
        for (k, &hz) in hz.iter().enumerate() {
            let resistance = bem.resistance(hz).real;
            let mass: Vec<_> = (0..modes).map(|column| bem.added_mass(column, hz)).collect();
            let z = DMatrix::from_fn(modes, modes, |i, j| {
                Complex::new(resistance[(i, j)], TAU * hz * mass[j][i])
            });
            let expected = z * v.column(k);
            let error = (found.column(k) - &expected).norm() / expected.norm();
            // In double precision: coefficients of fitted modes, up to 200, multiply any rounding twice.
            assert!(error < 1e-12, "{hz} Hz: {error:.1e}");
        }
    }
}

#[test]
fn energies_of_the_modes_sum_to_the_whole() {
    let (frequency, a) = &*MOTION;
    let spectra = ModalSpectra {
        range_hz: [frequency[0], frequency[frequency.len() - 1]],
        accelerations: a.clone(),
        frequency: frequency.clone(),
    };
    let weights: Vec<f64> = (0..frequency.len()).map(|bin| 1.0 + bin as f64).collect();
    let modes = mode_energies(&SAMPLED.bem, &spectra, &weights).unwrap();
    let forms = SAMPLED.bem.energy_forms(frequency, a);
    let whole: f64 = weights
        .iter()
        .zip(forms.column_iter())
        .map(|(w, form)| 2.0 * w * form.sum())
        .sum();
    assert!((modes.iter().sum::<f64>() / whole - 1.0).abs() < 1e-6);
}

#[test]
fn a_matrix_is_read_back_bit_by_bit() {
    let (frequency, a) = &*MOTION;
    let bem = &SAMPLED.bem;
    let back: ModalBem = postcard::from_bytes(&postcard::to_stdvec(bem).unwrap()).unwrap();
    assert_eq!(back.energy_forms(frequency, a), bem.energy_forms(frequency, a));
    assert_eq!(back.root_signals(frequency, a), bem.root_signals(frequency, a));
    assert_eq!(back.summary, bem.summary);
    assert_eq!(
        back.pressures(frequency, a).unwrap(),
        bem.pressures(frequency, a).unwrap()
    );
}

#[test]
fn pressures_of_another_solution_are_refused() {
    let other = Arc::new(ModalPressures::default());
    assert!(SAMPLED.bem.with_pressures(other).is_none());
}

#[test]
fn a_matrix_that_is_cut_short_is_refused() {
    let bytes = postcard::to_stdvec(&SAMPLED.bem).unwrap();
    for end in [0, 7, bytes.len() / 2, bytes.len() - 1] {
        assert!(postcard::from_bytes::<ModalBem>(&bytes[..end]).is_err());
    }
}

/// Band fields of a shot, with the same energies from the sampled radiation matrix.
struct Shot {
    bands: Vec<Band>,
    spectra: ModalSpectra,
    directions: Directions,
    fields: BandFields,
    bem: ModalBem,
}

/// Two meshes whose ranges meet at a band edge.
fn two_meshes(bands: &[Band]) -> Vec<MeshRange> {
    let solids = solids();
    let coarse = MeshRange {
        top_hz: bands[1].high,
        ..level(&solids, 0.08, 6.0)
    };
    vec![coarse, level(&solids, 0.05, 6.0)]
}

fn points_around() -> Vec<Point3<f64>> {
    vec![
        Point3::new(0.7, 0.2, 0.5),
        Point3::new(-0.5, -0.6, -0.1),
        Point3::new(0.0, 0.0, 0.16),
    ]
}

static SHOT: LazyLock<Shot> = LazyLock::new(|| {
    // From 350 Hz to 1122 Hz.
    let bands: Vec<Band> = (-4..=0).map(Band::new).collect();
    let points = points_around();
    let directions = Directions::new(12, 32, true);
    let frequency: Vec<f64> = (0..100).map(|i| 340.0 + 8.0 * f64::from(i)).collect();
    let accelerations = DMatrix::from_fn(2 * MODES, frequency.len(), |i, j| {
        Complex::from_polar(1.0 + (i as f64).sin(), (0.3 * i as f64 + 0.07) * j as f64)
    });
    let spectra = ModalSpectra {
        range_hz: [frequency[0], frequency[99]],
        frequency,
        accelerations,
    };
    let around = FieldPoints {
        points: &points,
        directions: &directions.vectors,
    };
    let fields = BandFields::new(two_meshes(&bands), &bands, &spectra, &around).unwrap();
    let sampling = Sampling {
        range_hz: [200.0, 1144.0],
        tolerance: 1e-3,
        floor: 1e-4,
        most_samples: 200,
    };
    let receivers = Receivers {
        points,
        origin: Point3::origin(),
    };
    let bem = with_pressures(|| two_meshes(&bands), &sampling, &receivers);
    Shot {
        bands,
        spectra,
        directions,
        fields,
        bem,
    }
});

/// Asserts for each band that `found` is the energy of `bin` over the band.
fn equals_band_energies(found: impl Fn(usize) -> f64, bin: impl Fn(usize) -> f64) {
    for (number, band) in SHOT.bands.iter().enumerate() {
        // Means over frequency begin a twelfth of an octave below the top of the last mesh.
        if band.high > SHOT.bem.solved_hz()[0] {
            continue;
        }
        let weights = energy_weights(&SHOT.spectra.frequency, [band.low, band.high], Weighting::Z);
        let exact: f64 = weights.iter().enumerate().map(|(b, w)| 2.0 * w * bin(b)).sum();
        let decibels = 10.0 * (found(number) / exact).log10();
        assert!(decibels.abs() < 0.01, "{:.0} Hz: {decibels} dB", band.hz);
    }
}

fn shot_forms() -> DMatrix<f64> {
    SHOT.bem
        .energy_forms(&SHOT.spectra.frequency, &SHOT.spectra.accelerations)
}

#[test]
fn band_fields_are_sampled_within_their_tolerance() {
    let around = &SHOT.fields.around;
    assert!(around.error < 1e-2, "{}", around.error);
}

#[test]
fn the_intensity_over_the_surface_sums_to_the_energy_of_each_band() {
    let forms = shot_forms();
    let left = |number: usize| {
        let surface = &SHOT.fields.bands[number];
        let mesh = &SHOT.fields.surfaces[surface.surface];
        surface.intensity.iter().zip(&mesh.areas).map(|(i, a)| i * a).sum()
    };
    equals_band_energies(left, |bin| forms.column(bin).rows(0, PATCHES.len()).sum());
}

#[test]
fn the_directivity_sums_to_the_energy_of_each_band() {
    let forms = shot_forms();
    let far = |number: usize| {
        let directivity = SHOT.fields.around.directivity.column(number);
        directivity
            .iter()
            .zip(&SHOT.directions.weights)
            .map(|(e, w)| e * w)
            .sum()
    };
    equals_band_energies(far, |bin| forms.column(bin).sum());
}

#[test]
fn the_exposure_at_a_point_is_that_of_the_sampled_pressure() {
    let pressures = SHOT
        .bem
        .pressures(&SHOT.spectra.frequency, &SHOT.spectra.accelerations)
        .unwrap();
    for point in 0..points_around().len() {
        equals_band_energies(
            |number| SHOT.fields.around.exposure[(point, number)],
            |bin| pressures[(point, bin)].norm_sqr(),
        );
    }
}

#[test]
fn a_point_inside_below_the_floor_or_too_close_is_not_clear() {
    let exterior = level(&solids(), 0.05, 6.0).problem;
    let points = [
        Point3::new(0.0, 0.0, 0.02),
        Point3::new(0.5, 0.0, -0.11),
        Point3::new(0.1, 0.0, 0.09),
        points_around()[0],
    ];
    assert_eq!(exterior.is_clear(&points), [false, false, false, true]);
}
