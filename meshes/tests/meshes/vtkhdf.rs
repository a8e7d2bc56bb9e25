//! Films in one file are read back by hdf5-pure; tests/peers/meshes.py reads those of a run with VTK.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use hdf5_pure::File;
use nailnoise_meshes::vtkhdf::{FilmFrame, FilmSurface};
use nailnoise_meshes::vtu::Array;
use nailnoise_meshes::{Block, MeshError, Surface, block};

fn surface() -> Surface {
    let brick = Block {
        size: [0.4, 0.3, 0.1],
        divisions: [3, 2, 1],
        origin: [0.0; 3],
    };
    Surface::of(&block(&brick).unwrap())
}

#[test]
fn the_surface_is_in_the_file_once_and_each_frame_refers_to_its_own_values() {
    let surface = surface();
    let points = surface.points.len();
    let frame = |start: f32| {
        let values: Vec<f32> = (0..3 * points).map(|index| start + index as f32).collect();
        vec![
            Array::new("velocity [m/s]", 3, &values),
            Array::new("level [dB]", 1, &values[..points]),
        ]
    };
    let fields = [frame(0.0), frame(0.5), frame(0.25)];
    let frames = [0.0, 0.01, 0.02].into_iter().zip(&fields);
    let frames: Vec<FilmFrame<'_>> = frames.map(|(time, fields)| FilmFrame { time, fields }).collect();
    let bytes = FilmSurface::of(&surface).film(&frames).unwrap();
    let file = File::from_bytes(bytes).unwrap();
    let read = |name: &str| file.dataset(&format!("VTKHDF/{name}")).unwrap();
    assert_eq!(read("Steps/Values").read_f64().unwrap(), [0.0, 0.01, 0.02]);
    for (name, shape) in [
        ("velocity [m per s]", vec![3 * points as u64, 3]),
        ("level [dB]", vec![3 * points as u64]),
    ] {
        let offsets = read(&format!("Steps/PointDataOffsets/{name}")).read_i64().unwrap();
        assert_eq!(offsets, [0, points as i64, 2 * points as i64]);
        assert_eq!(read(&format!("PointData/{name}")).shape().unwrap(), shape);
    }
    let velocities = read("PointData/velocity [m per s]").read_f32().unwrap();
    assert_eq!(velocities[3 * points..][..2], [0.5, 1.5]);
    let coordinates = read("Points").read_f32().unwrap();
    let expected = surface.points.iter().flat_map(|p| [p.x as f32, p.y as f32, p.z as f32]);
    assert_eq!(coordinates, expected.collect::<Vec<_>>());
    let ends = read("Offsets").read_i64().unwrap();
    let connectivity = read("Connectivity").read_i64().unwrap();
    for (place, face) in surface.faces.iter().enumerate() {
        let nodes: Vec<usize> = connectivity[ends[place] as usize..ends[place + 1] as usize]
            .iter()
            .map(|&node| node as usize)
            .collect();
        assert_eq!(nodes[..], face.nodes[..]);
    }
}

#[test]
fn a_field_of_another_length_is_refused() {
    let fields = [Array::new("level [dB]", 1, &[1.0])];
    let frame = FilmFrame {
        time: 0.0,
        fields: &fields,
    };
    let error = FilmSurface::of(&surface()).film(&[frame]).unwrap_err();
    assert!(matches!(error, MeshError::FieldLength { found: 1, .. }), "{error}");
}
