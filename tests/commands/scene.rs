//! The data of the 3D view of a report.

use crate::common::{SMALL, command, folder};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use std::fs;

/// The data of the view of the small design with a board on its block.
fn with_board() -> Value {
    let out = folder("scene");
    let board = "workpiece.board.thickness=38mm";
    let output = command(&["run", SMALL, "--set", board, "--out", out.to_str().unwrap()]).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let (_, scene) = page.split_once("<figure class=\"scene\">").unwrap();
    let (_, data) = scene.split_once("application/json\">").unwrap();
    serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap()
}

fn length(value: &Value) -> usize {
    STANDARD.decode(value.as_str().unwrap()).unwrap().len()
}

fn ends(value: &Value) -> [usize; 2] {
    [0, 1].map(|end| value[end].as_u64().unwrap() as usize)
}

/// Free triangles come first and have levels; each triangle belongs to one part. The board lies on the block, which
/// lies on the table.
#[test]
fn parts_share_out_the_triangles_and_lie_on_each_other() {
    let data = with_board();
    let mut stacks = Vec::new();
    for body in data["bodies"].as_array().unwrap() {
        let (triangles, free) = (length(&body["triangles"]) / 12, length(&body["levels"][0]));
        let parts = body["parts"].as_array().unwrap();
        let mut ranges: Vec<[usize; 2]> = parts.iter().map(|part| ends(&part["free"])).collect();
        assert_eq!(ranges.last().unwrap()[1], free, "{}", body["name"]);
        ranges.extend(parts.iter().map(|part| ends(&part["covered"])));
        assert_eq!((ranges[0][0], ranges.last().unwrap()[1]), (0, triangles));
        assert!(ranges.windows(2).all(|pair| pair[0][1] == pair[1][0]), "{ranges:?}");
        let name = |part: &Value| part["name"].as_str().unwrap().to_owned();
        stacks.extend(parts.iter().map(|part| (name(part), part["stack"].as_u64().unwrap())));
    }
    stacks.sort_by_key(|own| own.1);
    let expected = [("top", 0), ("leg", 0), ("block", 1), ("board", 2)];
    assert_eq!(stacks, expected.map(|(name, stack)| (name.to_owned(), stack)));
}
