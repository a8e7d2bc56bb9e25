//! A block on a slab, meshed apart as volumes: one closed surface, its velocities and its radiation matrix.
#![allow(clippy::unwrap_used)]

use nailnoise_acoustics::bem::{
    BandFields, Boundary, BoundaryMesh, Exterior, MeshRange, ModalBem, MovingPart, Parity, Patterns, Receivers,
    SolidBox,
};
use nailnoise_acoustics::levels::{Band, Weighting, energy_weights};
use nailnoise_acoustics::radiation::{ModalRadiation, ModalSpectra, Sampling, mode_energies};
use nailnoise_acoustics::sound::{Around, Directions};
use nailnoise_acoustics::{AcousticsError, Air};
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
    assert_eq!(whole.mended().flipped, 0);
    let quarter = boundary([Some(0.0); 2], 0.06);
    assert!((4.0 * quarter.mesh().area() / area - 1.0).abs() < 1e-12);
    assert!(whole.mesh().longest_edge() <= 0.06 + 1e-12);
}

#[test]
fn velocities_keep_their_flow_on_meshes_of_any_fineness() {
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
fn parities_add_up_to_the_whole() {
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
    // Heave is even, sway along x odd in x.
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
    assert!(matches!(error, AcousticsError::Uncovered { .. }), "{error}");
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

#[test]
fn the_sampled_matrix_is_that_of_the_whole_body() {
    let solids = solids();
    let levels = vec![level(&solids, 0.05, 6.0), level(&solids, 0.036, 6.0)];
    let top = levels[1].top_hz;
    let sampling = Sampling {
        range_hz: [40.0, top],
        tolerance: 1e-2,
        floor: 1e-4,
        most_samples: 200,
    };
    let receivers = Receivers {
        points: vec![Point3::new(0.7, 0.2, 0.5), Point3::new(-0.5, -0.6, 0.1)],
        origin: Point3::origin(),
    };
    let bem = ModalBem::new(levels, &sampling, &receivers, &|| ()).unwrap();
    println!("{:?}, to {top:.0} Hz", bem.summary);
    // Of single modes, at six panels a wavelength of the coarser mesh.
    assert!(bem.summary.difference_db < 0.7 && bem.summary.asymmetry < 1e-2);

    let whole = boundary([None; 2], 0.036);
    let v = whole.transfer(&parts(&solids)).unwrap().remove(0).velocities;
    let exterior = Exterior::new(whole, &Air::default());
    // What was computed in one air holds in any other.
    let cold = Air::at(253.0, 80e3).unwrap();
    let in_cold = bem.clone().in_air(&Air::default(), &cold);
    let exterior_in_cold = Exterior::new(boundary([None; 2], 0.036), &cold);
    assert!((in_cold.blend_hz()[1] / bem.blend_hz()[1] - (253.0f64 / 293.15).sqrt()).abs() < 1e-9);
    for (hz, bem, exterior) in [
        (60.0, &bem, &exterior),
        (333.0, &bem, &exterior),
        (0.7 * top, &bem, &exterior),
        (333.0, &in_cold, &exterior_in_cold),
    ] {
        let found = bem.resistance(hz).real;
        let exact = exterior.resistance(hz, &v).unwrap().far_field;
        let mut worst: f64 = 0.0;
        for i in 0..2 * MODES {
            for j in 0..2 * MODES {
                let scale = (exact[(i, i)] * exact[(j, j)]).sqrt().max(1e-3 * exact.amax());
                worst = worst.max((found[(i, j)] - exact[(i, j)]).abs() / scale);
            }
        }
        println!("{hz:.0} Hz: {worst:.1e}");
        // One mode at a time: what receivers hear of it, beside the field of the whole body.
        let solution = exterior.solve(hz, &v).unwrap();
        let [direct, by_floor] = exterior.pressure_at(&receivers.points, &v, &solution).unwrap();
        let exact = (direct + by_floor) / Complex::new(0.0, std::f64::consts::TAU * hz);
        let scale = exact.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let mut off: f64 = 0.0;
        for mode in 0..2 * MODES {
            let a = DMatrix::from_fn(2 * MODES, 1, |i, _| Complex::from(f64::from(u8::from(i == mode))));
            let found = bem.pressures(&[hz], &a).unwrap();
            off = off.max(
                (found - exact.columns(mode, 1))
                    .iter()
                    .map(|z| z.norm())
                    .fold(0.0, f64::max)
                    / scale,
            );
        }
        println!("{hz:.0} Hz, at receivers: {off:.1e}");
        assert!(off < 3e-2, "{hz} Hz: {off:e}");
        // The coarser mesh at its top frequency, 1144 Hz, has six panels a wavelength.
        assert!(worst < 5e-2, "{hz} Hz: {worst:e}");
    }
    // Radiation efficiency 1 is rho c int v_i v_j dS: heave of all that faces up or down. The limit above the range tends
    // to it; half an octave above, flat faces ripple around it.
    for (bem, air) in [(&bem, Air::default()), (&in_cold, cold)] {
        let heave = |of: &dyn ModalRadiation, hz: f64| -> f64 {
            let r = of.resistance(hz).real;
            let pairs = [(0, 0), (0, MODES), (MODES, 0), (MODES, MODES)];
            pairs.iter().map(|&ij| r[ij]).sum()
        };
        let exact = air.impedance() * 2.0 * SIZES[1][0] * SIZES[1][1];
        assert!((heave(&bem.reference(), 2.0 * top) / exact - 1.0).abs() < 1e-9);
        for (hz, within) in [(2.0 * top, 0.05), (10e3, 0.01)] {
            let limit = heave(bem, hz);
            println!("{hz:.0} Hz: heave {:.4} of radiation efficiency 1", limit / exact);
            assert!((limit / exact - 1.0).abs() < within, "{limit:e} {exact:e}");
        }
    }
    // Where both are known the limit is what it is above, and means are those of single frequencies nearby.
    let compared = bem.compared_hz();
    assert!(compared[0] < bem.solved_hz()[0] && bem.solved_hz()[1] < bem.blend_hz()[0]);
    assert!(bem.blend_hz()[0] < compared[1] && compared[1] < bem.blend_hz()[1]);
    let hz = bem.blend_hz()[0];
    let unit = DMatrix::<Complex<f64>>::identity(2 * MODES, 2 * MODES);
    let limit: f64 = bem.limit_forms(&[hz; 2 * MODES], &unit).iter().sum();
    let mean = bem.energy_forms(&[hz; 2 * MODES], &unit).sum();
    println!("limit over mean, all modes {:+.2} dB", 10.0 * (limit / mean).log10());
    // The gap under the slab is a third of a wave high, too narrow for the limit.
    assert!((10.0 * (limit / mean).log10()).abs() < 3.0);
    let finer = Exterior::new(boundary([None; 2], 0.036), &Air::default());
    let finer = finer.with_panels_per_wavelength(5.0).unwrap();
    let next = finer.resistance(1.06 * top, &v).unwrap().far_field.trace();
    let mean = bem.resistance(1.06 * top).real.trace();
    println!("mean over single frequency {:+.2} dB", 10.0 * (mean / next).log10());
    assert!((10.0 * (mean / next).log10()).abs() < 0.5);

    let frequency: Vec<f64> = (0..60).map(|i| 20.0 * 1.1f64.powi(i)).collect();
    let a = DMatrix::from_fn(2 * MODES, frequency.len(), |i, j| {
        Complex::new(
            (1.0 + i as f64 * 0.7 + j as f64).sin(),
            (i as f64 - 0.3 * j as f64).cos(),
        )
    });
    let forms = bem.energy_forms(&frequency, &a);
    let signals = bem.root_signals(&frequency, &a);
    for (bin, hz) in frequency.iter().enumerate() {
        let direct = bem.resistance(*hz).form(a.column(bin).as_slice()) / (std::f64::consts::TAU * hz).powi(2);
        let sum = forms.column(bin).sum();
        assert!((sum / direct - 1.0).abs() < 1e-5, "{hz} Hz: {sum:e} {direct:e}");
        let root: f64 = signals.column(bin).iter().map(Complex::norm_sqr).sum();
        assert!((root / direct - 1.0).abs() < 3e-2, "{hz} Hz: {root:e} {direct:e}");
    }
    let forms_in_cold = in_cold.energy_forms(&frequency, &a);
    let signals_in_cold = in_cold.root_signals(&frequency, &a);
    let images = in_cold.images(&frequency, &a);
    let erp = in_cold.reference();
    let erp_forms = erp.energy_forms(&frequency, &a);
    for (bin, hz) in frequency.iter().enumerate() {
        let omega2 = (std::f64::consts::TAU * hz).powi(2);
        let a = a.column(bin);
        let direct = in_cold.resistance(*hz).form(a.as_slice()) / omega2;
        let root: f64 = signals_in_cold.column(bin).iter().map(Complex::norm_sqr).sum();
        let image = a.dotc(&images.column(bin)).re;
        let of_erp = erp.resistance(*hz).form(a.as_slice()) / omega2;
        assert!((forms_in_cold.column(bin).sum() / direct - 1.0).abs() < 1e-5, "{hz} Hz");
        assert!((root / direct - 1.0).abs() < 3e-2, "{hz} Hz: {root:e} {direct:e}");
        assert!((image / direct - 1.0).abs() < 1e-5, "{hz} Hz: {image:e} {direct:e}");
        assert!((erp_forms.column(bin).sum() / of_erp - 1.0).abs() < 1e-5, "{hz} Hz");
    }

    // Modes sum to the whole.
    let spectra = ModalSpectra {
        range_hz: [frequency[0], frequency[frequency.len() - 1]],
        accelerations: a.clone(),
        frequency: frequency.clone(),
    };
    let weights: Vec<f64> = (0..frequency.len()).map(|bin| 1.0 + bin as f64).collect();
    let modes = mode_energies(&bem, &spectra, &weights).unwrap();
    let whole: f64 = weights
        .iter()
        .zip(forms.column_iter())
        .map(|(w, form)| 2.0 * w * form.sum())
        .sum();
    assert!((modes.iter().sum::<f64>() / whole - 1.0).abs() < 1e-6);

    // Kept and read back it is the same to the bit; anything else is refused.
    let bytes = postcard::to_stdvec(&bem).unwrap();
    let back: ModalBem = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(back.energy_forms(&frequency, &a), forms);
    assert_eq!(back.root_signals(&frequency, &a), signals);
    assert_eq!(back.summary, bem.summary);
    assert_eq!(
        back.pressures(&frequency, &a).unwrap(),
        bem.pressures(&frequency, &a).unwrap()
    );
    for end in [0, 7, bytes.len() / 2, bytes.len() - 1] {
        assert!(postcard::from_bytes::<ModalBem>(&bytes[..end]).is_err());
    }
}

/// Energies of a shot on the surface, around the body and in the far field, beside those of its radiation matrix.
#[test]
fn pictures_of_bands_hold_the_power_of_the_matrix() {
    let solids = solids();
    // From 350 Hz to 1122 Hz, on two meshes that meet where two bands do.
    let bands: Vec<Band> = (-4..=0).map(Band::new).collect();
    let levels = || {
        let coarse = MeshRange {
            top_hz: bands[1].high,
            ..level(&solids, 0.08, 6.0)
        };
        vec![coarse, level(&solids, 0.05, 6.0)]
    };
    let points = vec![
        Point3::new(0.7, 0.2, 0.5),
        Point3::new(-0.5, -0.6, -0.1),
        Point3::new(0.0, 0.0, 0.16),
    ];
    let directions = Directions::new(12, 32, true);
    let around = Around {
        points: &points,
        directions: &directions.vectors,
    };
    let frequency: Vec<f64> = (0..100).map(|i| 340.0 + 8.0 * f64::from(i)).collect();
    let accelerations = DMatrix::from_fn(2 * MODES, frequency.len(), |i, j| {
        Complex::from_polar(1.0 + (i as f64).sin(), (0.3 * i as f64 + 0.07) * j as f64)
    });
    let spectra = ModalSpectra {
        range_hz: [frequency[0], frequency[99]],
        frequency,
        accelerations,
    };
    let found = BandFields::new(levels(), &bands, &spectra, &around).unwrap();
    println!("{} frequencies, error {:.1e}", found.around.samples, found.around.error);
    assert!(found.around.error < 1e-2);

    let sampling = Sampling {
        range_hz: [200.0, 1144.0],
        tolerance: 1e-3,
        floor: 1e-4,
        most_samples: 200,
    };
    let receivers = Receivers {
        points: points.clone(),
        origin: Point3::origin(),
    };
    let bem = ModalBem::new(levels(), &sampling, &receivers, &|| ()).unwrap();
    let forms = bem.energy_forms(&spectra.frequency, &spectra.accelerations);
    let heard = bem.pressures(&spectra.frequency, &spectra.accelerations).unwrap();
    for (number, (band, surface)) in bands.iter().zip(&found.bands).enumerate() {
        // Means are part of the matrix from a twelfth of an octave below its last mesh's top on.
        if band.high > bem.solved_hz()[0] {
            continue;
        }
        let weights = energy_weights(&spectra.frequency, [band.low, band.high], Weighting::Z);
        let energy =
            |bin: &dyn Fn(usize) -> f64| weights.iter().enumerate().map(|(b, w)| 2.0 * w * bin(b)).sum::<f64>();
        let near = |found: f64, exact: f64, what: &str| {
            let decibels = 10.0 * (found / exact).log10();
            println!("{:.0} Hz, {what}: {decibels:+.4} dB", band.hz);
            assert!(decibels.abs() < 0.01, "{:.0} Hz, {what}: {decibels} dB", band.hz);
        };
        let mesh = &found.surfaces[surface.surface];
        let left: f64 = surface.intensity.iter().zip(&mesh.areas).map(|(i, a)| i * a).sum();
        near(
            left,
            energy(&|b| forms.column(b).rows(0, PATCHES.len()).sum()),
            "intensity over the surface",
        );
        let far: f64 = found
            .around
            .directivity
            .column(number)
            .iter()
            .zip(&directions.weights)
            .map(|(e, w)| e * w)
            .sum();
        near(
            far,
            energy(&|b| forms.column(b).sum()),
            "directivity over the half sphere",
        );
        for point in 0..points.len() {
            let exact = energy(&|b| heard[(point, b)].norm_sqr());
            near(found.around.exposure[(point, number)], exact, "pressure at a point");
        }
    }

    // A point inside, one below the floor, one too close to a corner.
    let exterior = &levels()[1].problem;
    let near = [
        Point3::new(0.0, 0.0, 0.02),
        Point3::new(0.5, 0.0, -0.11),
        Point3::new(0.1, 0.0, 0.09),
        points[0],
    ];
    assert_eq!(exterior.is_clear(&near), [false, false, false, true]);
}
