//! `.msh` files as gmsh writes them, and damaged ones.
#![allow(clippy::unwrap_used)] // a test may panic, in its helpers too

use std::path::{Path, PathBuf};

use nailnoise_meshes::msh::{self, Format, Imported};
use nailnoise_meshes::{Mesh, MeshError, MshError};
use proptest::prelude::*;

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn read(name: &str) -> Imported {
    msh::read(&sample(name), 1.0).unwrap_or_else(|error| panic!("{error}"))
}

fn parse(bytes: &[u8]) -> Result<Imported, MshError> {
    msh::parse(bytes, 1.0, Path::new("sample.msh")).map_err(|error| match error {
        MeshError::Msh { problem, .. } => problem,
        other => panic!("{other}"),
    })
}

/// Asserts that the mesh is a unit cube: volume, area, flat sides, closed skin, and a constant Jacobian in each
/// element, which shows that every mid-side node has its place.
fn is_a_cube(mesh: &Mesh, name: &str) {
    let quality = mesh.quality().unwrap();
    assert!((quality.volume - 1.0).abs() < 1e-12, "{name}: {quality:?}");
    assert!((quality.skin_volume - 1.0).abs() < 1e-12, "{name}: {quality:?}");
    assert!((quality.skin_area - 6.0).abs() < 1e-12, "{name}: {quality:?}");
    assert!(quality.worst.ratio > 1.0 - 1e-9, "{name}: {quality:?}");
    assert_eq!(
        (
            quality.open_edges,
            quality.pieces,
            quality.coincident_nodes,
            quality.inverted
        ),
        (0, 1, 0, 0),
        "{name}"
    );
    for (group, height) in [("floor", 0.0), ("top", 1.0)] {
        let nodes = mesh.group_nodes(group).unwrap();
        assert!(nodes.iter().all(|&n| mesh.nodes[n].z == height), "{name}: {group}");
        let area: f64 = {
            let surface = nailnoise_meshes::Surface::of(mesh);
            surface.patch_area(surface.patch(group).unwrap())
        };
        assert!((area - 1.0).abs() < 1e-12, "{name}: {group} has the area {area}");
    }
}

#[test]
fn every_kind_of_element_is_read_in_the_node_order_of_vtk() {
    for name in ["tet4", "hex8", "hex20", "hex27", "wedge15"] {
        is_a_cube(&read(&format!("{name}.msh")).mesh, name);
    }
}

#[test]
fn named_volume_groups_become_parts() {
    let mesh = read("tet10-41-text.msh").mesh;
    is_a_cube(&mesh, "tet10");
    assert_eq!(mesh.part_names, ["lower", "upper"]);
    let volumes = mesh.part_volumes().unwrap();
    assert!(volumes.iter().all(|volume| (volume - 0.5).abs() < 1e-12), "{volumes:?}");
}

#[test]
fn every_version_and_encoding_gives_the_same_mesh() {
    let first = read("tet10-41-text.msh");
    for name in ["tet10-41-binary.msh", "tet10-22-text.msh", "tet10-22-binary.msh"] {
        let other = read(name).mesh;
        // Text has 16 digits.
        let off = other.nodes.iter().zip(&first.mesh.nodes).map(|(a, b)| (a - b).norm());
        assert!(off.fold(0.0, f64::max) < 1e-15, "{name}");
        assert!(other.connectivity == first.mesh.connectivity, "{name}");
        assert_eq!(other.groups, first.mesh.groups, "{name}");
        assert_eq!(other.part_names, first.mesh.part_names, "{name}");
    }
}

#[test]
fn what_is_written_is_read_back_exactly() {
    for name in ["tet4", "hex8", "hex20", "hex27", "wedge15", "tet10-41-binary"] {
        let mesh = read(&format!("{name}.msh")).mesh;
        for format in [Format::Text22, Format::Binary22, Format::Text41, Format::Binary41] {
            let again = parse(&msh::to_bytes(&mesh, format, "")).unwrap().mesh;
            assert!(again == mesh, "{name} as {format:?}");
        }
    }
}

#[test]
fn a_compressed_file_is_read_as_well() {
    let mesh = read("hex20.msh").mesh;
    let bytes = msh::compressed(&msh::to_bytes(&mesh, Format::Binary22, "made by hand"));
    let again = parse(&bytes).unwrap();
    assert!(again.mesh == mesh);
    assert_eq!(again.comment, "made by hand");
}

#[test]
fn lengths_are_taken_in_the_unit_given() {
    let mesh = msh::read(&sample("hex20.msh"), 1e-3).unwrap().mesh;
    assert!((mesh.quality().unwrap().volume - 1e-9).abs() < 1e-20);
}

#[test]
fn the_other_byte_order_is_read_as_well() {
    let text = "$MeshFormat\n2.2 1 8\n";
    let mut bytes = text.as_bytes().to_vec();
    bytes.extend(1i32.to_be_bytes());
    bytes.extend(b"\n$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"one\"\n$EndPhysicalNames\n$Nodes\n4\n");
    for (k, p) in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .iter()
        .enumerate()
    {
        bytes.extend((k as i32 + 1).to_be_bytes());
        p.iter().for_each(|x: &f64| bytes.extend(x.to_be_bytes()));
    }
    bytes.extend(b"\n$EndNodes\n$Elements\n1\n");
    for word in [4, 1, 2, 1, 7, 1, 1, 2, 3, 4i32] {
        bytes.extend(word.to_be_bytes());
    }
    bytes.extend(b"\n$EndElements\n");
    let mesh = parse(&bytes).unwrap().mesh;
    assert_eq!(mesh.part_names, ["one"]);
    assert!((mesh.part_volumes().unwrap()[0] - 1.0 / 6.0).abs() < 1e-15);
}

/// A tetrahedron as text, with one thing changed.
fn text(change: impl FnOnce(String) -> String) -> Result<Imported, MshError> {
    let good = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
                $PhysicalNames\n2\n2 9 \"base\"\n3 7 \"one\"\n$EndPhysicalNames\n\
                $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
                $Elements\n3\n11 4 2 7 1 1 2 3 4\n12 4 2 7 1 2 3 4 5\n13 2 2 9 1 1 3 2\n$EndElements\n";
    parse(change(good.to_owned()).as_bytes())
}

/// Asserts for each case (text, replacement, message) that the file with the replacement is refused with the message.
fn refused(cases: &[(&str, &str, &str)]) {
    for (from, to, expected) in cases {
        let error = text(|t| {
            assert!(t.contains(from), "{from}");
            t.replacen(from, to, 1)
        })
        .expect_err(to)
        .to_string();
        assert!(error.contains(expected), "{from} -> {to}: {error}");
    }
}

#[test]
fn the_correct_file_is_read_with_its_element_numbers() {
    assert_eq!(text(|t| t).unwrap().element_numbers, [11, 12]);
}

#[test]
fn an_unknown_header_is_refused() {
    refused(&[
        ("2.2 0 8", "3.1 0 8", "format version 3.1"),
        ("2.2 0 8", "4.2 0 8", "format version 4.2;"),
        ("2.2 0 8", "2.2 0 4", "data size 4"),
        ("2.2 0 8", "2.2 2 8", "file type 2"),
        ("$MeshFormat\n", "ply\n", "not a .msh file"),
    ]);
}

#[test]
fn a_wrong_element_is_named_by_its_number() {
    refused(&[
        (
            "12 4 2 7 1 2 3 4 5",
            "12 4 2 7 1 2 3 4 6",
            "element 12 refers to node 6",
        ),
        (
            "12 4 2 7 1 2 3 4 5",
            "12 4 2 7 1 2 3 1 4",
            "element 12 has the same nodes as element 11",
        ),
        (
            "12 4 2 7 1 2 3 4 5",
            "11 4 2 7 1 2 3 4 5",
            "element number 11 is given twice",
        ),
        (
            "12 4 2 7 1 2 3 4 5",
            "12 4 2 7 1 2 3 4 2",
            "element 12 uses node 2 twice",
        ),
        (
            "13 2 2 9 1 1 3 2",
            "13 2 2 9 1 1 3 5",
            "element 13 of the surface group \"base\" lies on no volume",
        ),
        ("11 4 2 7 1", "11 4 99 7 1", "tags"),
    ]);
}

#[test]
fn an_unsupported_kind_of_element_is_named() {
    refused(&[
        ("12 4 2 7 1 2 3 4 5", "12 7 2 7 1 2 3 4 5 1", "pyramid of 5 nodes"),
        ("12 4 2 7 1 2 3 4 5", "12 99 2 7 1 2 3 4 5", "gmsh type 99"),
    ]);
}

#[test]
fn an_element_without_a_named_volume_group_is_refused() {
    refused(&[
        (
            "12 4 2 7 1 2 3 4 5",
            "12 4 2 8 1 2 3 4 5",
            "element 12 belongs to no named volume group; the named \
          groups are: surface \"base\", volume \"one\", volume 8 without a name",
        ),
        (
            "3 7 \"one\"",
            "2 7 \"one\"",
            "element 11 belongs to no named volume group",
        ),
    ]);
}

#[test]
fn a_wrong_node_is_named_by_its_number_or_line() {
    refused(&[
        ("5 1 1 1\n", "5 1 nan 1\n", "node 5 lies at (1, NaN, 1)"),
        ("5 1 1 1\n", "5 1 inf 1\n", "node 5 lies at (1, inf, 1)"),
        ("5 1 1 1\n", "4 1 1 1\n", "node 4 is given twice"),
        (
            "5 1 1 1\n",
            "5 1 one 1\n",
            "line 15, in $Nodes: found \"one\", expected a number",
        ),
    ]);
}

#[test]
fn a_count_that_does_not_match_its_section_is_refused() {
    refused(&[
        ("$Nodes\n5\n", "$Nodes\n6\n", "$EndNodes"),
        (
            "$Nodes\n5\n",
            "$Nodes\n4\n",
            "$Nodes continues beyond the end given by its counts",
        ),
        ("$Nodes\n5\n", "$Nodes\n999999999999\n", "announces 999999999999 nodes"),
        ("$Nodes\n5\n", "$Nodes\n-5\n", "announces"),
        (
            "$Elements\n3\n",
            "$Elements\n4000000000\n",
            "announces 4000000000 elements",
        ),
    ]);
}

#[test]
fn a_group_name_needs_quotes() {
    refused(&[("3 7 \"one\"", "3 7 one", "a name in double quotes")]);
}

#[test]
fn a_section_without_its_end_is_refused() {
    refused(&[("$EndElements\n", "", "ends within $Elements")]);
}

#[test]
fn a_file_without_elements_is_refused() {
    let error = text(|t| t.split("$Elements").next().unwrap().to_owned()).unwrap_err();
    assert!(error.to_string().contains("no $Elements"), "{error}");
}

#[test]
fn groups_without_a_name_are_listed() {
    let error = text(|t| {
        t.replace("2 9 \"base\"", "2 8 \"base\"")
            .replace("3 7 \"one\"", "3 8 \"one\"")
    });
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("surface 9 without a name, volume 7 without a name"),
        "{error}"
    );
}

/// The nodes of [`text`] as lines.
const NODES: &str = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n";

/// The two tetrahedra and the triangle of [`text`] in blocks of version 4.1, by the numbers of their entities.
fn blocks(first: u32, second: u32, surface: u32) -> String {
    let numbers = "1\n2\n3\n4\n5\n";
    let positions = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1\n";
    format!(
        "$Nodes\n1 5 1 5\n3 {first} 0 5\n{numbers}{positions}$EndNodes\n\
         $Elements\n3 3 11 13\n3 {first} 4 1\n11 1 2 3 4\n3 {second} 4 1\n12 2 3 4 5\n2 {surface} 2 1\n13 1 3 2\n\
         $EndElements\n"
    )
}

const NAMES: &str = "$PhysicalNames\n2\n2 9 \"base\"\n3 7 \"one\"\n$EndPhysicalNames\n";

/// Asserts that a file shows the two tetrahedra of [`text`], 1/6 and 1/3, with one part and, if it has names, the
/// triangle.
fn is_the_pair(what: &str, file: &str, part: &str) {
    let read = parse(file.as_bytes()).unwrap_or_else(|error| panic!("{what}: {error}"));
    let mesh = &read.mesh;
    assert_eq!(
        (mesh.nodes.len(), &read.element_numbers[..]),
        (5, &[11, 12][..]),
        "{what}"
    );
    assert_eq!(mesh.part_names, [part], "{what}");
    assert!((mesh.part_volumes().unwrap()[0] - 0.5).abs() < 1e-15, "{what}");
    let groups: Vec<&str> = mesh.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(groups, if part == "one" { &["base"][..] } else { &[] }, "{what}");
}

#[test]
fn partitions_have_the_groups_of_their_own_or_of_their_parent() {
    // Volume 1 in pieces 2 and 3 with an interface between them, and a ghost entity; surface 1 in the piece 4.
    let box_ = "0 0 0 1 1 1";
    let pieces = |own: &str| {
        format!(
            "$PartitionedEntities\n2\n1\n5 1\n0 0 2 2\n4 2 1 1 1 {box_} {own} 0\n5 3 1 2 1 2 {box_} 0 0\n\
             2 3 1 1 1 {box_} 1 7 0\n3 3 1 1 2 {box_} 0 0\n$EndPartitionedEntities\n"
        )
    };
    let entities = format!("$Entities\n0 0 1 1\n1 {box_} 1 9 0\n1 {box_} 1 7 0\n$EndEntities\n");
    for own in ["1 9", "0"] {
        let file = format!(
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{NAMES}{entities}{}{}",
            pieces(own),
            blocks(2, 3, 4)
        );
        is_the_pair("4.1 in partitions", &file, "one");
    }
    // Version 2.2 gives the partitions of each element as further tags.
    let tags = "$Elements\n3\n11 4 4 7 1 1 1 1 2 3 4\n12 4 5 7 1 2 2 -1 2 3 4 5\n13 2 4 9 1 1 1 1 3 2\n$EndElements\n";
    let file = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{NAMES}$Nodes\n5\n{NODES}$EndNodes\n{tags}");
    is_the_pair("2.2 in partitions", &file, "one");
}

#[test]
fn nodes_with_the_parameters_of_their_entities_are_read() {
    let nodes = "1 0 0 0 0 1\n2 1 0 0 1 3 0.5\n3 0 1 0 2 1 0.25 0.75\n4 0 0 1 3 1\n5 1 1 1 3 1\n";
    let elements = "$Elements\n3\n11 4 2 7 1 1 2 3 4\n12 4 2 7 1 2 3 4 5\n13 2 2 9 1 1 3 2\n$EndElements\n";
    let file = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{NAMES}$ParametricNodes\n5\n{nodes}$EndParametricNodes\n{elements}"
    );
    is_the_pair("2.2 with parameters", &file, "one");
}

#[test]
fn versions_1_and_4_0_are_read() {
    let elements = "3\n11 4 7 1 4 1 2 3 4\n12 4 7 1 4 2 3 4 5\n13 2 9 1 3 1 3 2\n";
    let first = format!("$NOD\n5\n{NODES}$ENDNOD\n$ELM\n{elements}$ENDELM\n");
    // Version 1 has no names.
    is_the_pair("1", &first, "volume group 7");
    let box_ = "0 0 0 1 1 1";
    let fourth = format!(
        "$MeshFormat\n4 0 8\n$EndMeshFormat\n{NAMES}$Entities\n0 0 1 1\n1 {box_} 1 9 0\n1 {box_} 1 7 0\n$EndEntities\n\
         $Nodes\n1 5\n1 3 0 5\n{NODES}$EndNodes\n\
         $Elements\n2 3\n1 3 4 2\n11 1 2 3 4\n12 2 3 4 5\n1 2 2 1\n13 1 3 2\n$EndElements\n"
    );
    is_the_pair("4.0", &fourth, "one");
    let wrong = first.replace("11 4 7 1 4 ", "11 4 7 1 5 ");
    let error = parse(wrong.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("number of its nodes is 5"), "{error}");
    let cut = first.replace("$ENDELM", "");
    assert!(
        parse(cut.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("ends within $ELM")
    );
}

#[test]
fn a_file_without_any_name_has_its_volume_groups_or_its_volumes_as_parts() {
    let header = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    is_the_pair("without $Entities", &format!("{header}{}", blocks(1, 1, 1)), "volume 1");
    let box_ = "0 0 0 1 1 1";
    let entities = format!("$Entities\n0 0 1 1\n1 {box_} 1 9 0\n1 {box_} 1 7 0\n$EndEntities\n");
    let file = format!("{header}{entities}{}", blocks(1, 1, 1));
    is_the_pair("without names", &file, "volume group 7");
    let two = parse(format!("{header}{}", blocks(1, 2, 1)).as_bytes()).unwrap().mesh;
    assert_eq!(two.part_names, ["volume 1", "volume 2"]);
}

#[test]
fn elements_that_overlap_are_refused() {
    // A third element behind the face that the first two share.
    let three = text(|t| {
        t.replace("$Nodes\n5\n", "$Nodes\n6\n6 2 2 2\n")
            .replace("$Elements\n3\n", "$Elements\n4\n14 4 2 7 1 2 3 4 6\n")
    })
    .unwrap();
    let error = three.validate().unwrap_err();
    assert!(matches!(error, MeshError::OpenSkin { .. }), "{error}");
    assert!(text(|t| t).unwrap().validate().is_ok());
}

#[test]
fn a_prism_with_face_nodes_is_refused_with_the_option_of_gmsh_that_avoids_it() {
    let error = msh::read(&sample("wedge18.msh"), 1.0).unwrap_err().to_string();
    assert!(
        error.contains("prism of 18 nodes") && error.contains("SecondOrderIncomplete"),
        "{error}"
    );
}

#[test]
fn a_missing_file_is_an_error() {
    let absent = msh::read(&sample("absent.msh"), 1.0).unwrap_err();
    assert!(matches!(absent, MeshError::Read { .. }), "{absent}");
}

#[test]
fn an_element_of_two_parts_is_refused() {
    let two = text(|t| {
        t.replace("$PhysicalNames\n2\n", "$PhysicalNames\n3\n3 8 \"two\"\n")
            .replace("12 4 2 7 1 2 3 4 5", "12 4 2 8 1 1 2 3 4")
    });
    assert!(matches!(two, Err(MshError::TwoGroups { element: 12, .. })), "{two:?}");
}

#[test]
fn nodes_without_an_element_are_left_out_and_counted() {
    let mesh = text(|t| t.replace("$Nodes\n5\n", "$Nodes\n6\n8 7 7 7\n")).unwrap();
    assert_eq!((mesh.unused_nodes, mesh.mesh.nodes.len()), (1, 5));
    assert_eq!(mesh.node_numbers, [1, 2, 3, 4, 5]);
}

#[test]
fn an_inverted_element_is_named_by_its_number_in_the_file() {
    let built = text(|t| t.replace("11 4 2 7 1 1 2 3 4", "11 4 2 7 1 1 3 2 4")).unwrap();
    let error = built.mesh.validate(|e| built.element_numbers[e]).unwrap_err();
    assert!(
        matches!(
            error,
            MeshError::Inverted {
                element: 11,
                inverted: 1,
                of: 2,
                ..
            }
        ),
        "{error}"
    );
}

/// A damaged copy of `bytes`: bits turned, pieces cut out, doubled, zeroed or overwritten with an extreme word.
fn damaged(bytes: &[u8], seed: u64) -> Vec<u8> {
    // The sequence of Steele, Lea and Flood (2014), so that a failure can be made again.
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut next = move |below: usize| {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % below.max(1) as u64) as usize
    };
    let mut bytes = bytes.to_vec();
    for _ in 0..=next(4) {
        let at = next(bytes.len());
        let length = next(64).min(bytes.len() - at);
        match next(6) {
            0 => bytes[at] ^= 1 << next(8),
            1 => drop(bytes.drain(at..at + length)),
            2 => {
                let copy = bytes[at..at + length].to_vec();
                bytes.splice(at..at, copy);
            }
            3 => bytes[at..at + length].fill(0),
            4 => bytes.truncate(at),
            _ => {
                let words: [&[u8]; 6] = [b"-1", b" 18446744073709551615 ", b"nan", &[0xff; 8], b"1e999", b"$End"];
                let word = words[next(words.len())];
                let length = word.len().min(bytes.len() - at);
                bytes[at..at + length].copy_from_slice(&word[..length]);
            }
        }
        if bytes.is_empty() {
            break;
        }
    }
    bytes
}

#[test]
fn damaged_files_cause_no_panic() {
    let names = [
        "tet10-22-text.msh",
        "tet10-22-binary.msh",
        "tet10-41-text.msh",
        "tet10-41-binary.msh",
        "hex20.msh",
    ];
    let (mut refused, mut tried) = (0, 0);
    for name in names {
        let bytes = std::fs::read(sample(name)).unwrap();
        for seed in 0..100 {
            tried += 1;
            match parse(&damaged(&bytes, seed)) {
                // Changes of a coordinate or a blank are read; the quality check must not panic.
                Ok(built) => drop(built.mesh.quality()),
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().is_empty());
                }
            }
        }
    }
    assert!(
        refused * 10 > tried * 7,
        "only {refused} of {tried} damaged files were refused"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_after_the_header_cause_no_panic(
        body in proptest::collection::vec(any::<u8>(), 0..400),
        binary in any::<bool>(),
        four in any::<bool>(),
    ) {
        let mut bytes = format!("$MeshFormat\n{} {} 8\n", if four { "4.1" } else { "2.2" },
            u8::from(binary)).into_bytes();
        if binary {
            bytes.extend(1i32.to_le_bytes());
        }
        bytes.extend(b"\n$EndMeshFormat\n$Nodes\n");
        bytes.extend(&body);
        prop_assert!(parse(&bytes).is_err());
    }
}
