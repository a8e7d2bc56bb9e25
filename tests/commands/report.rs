//! The report, the stored data of a run, and the start of a design: through the command.

use crate::common::{SMALL, command, folder};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

/// The command with modes from the tests' common cache, or with a separate cache.
fn nailnoise(cache: Option<&Path>, arguments: &[&str]) -> Output {
    let mut command = command(arguments);
    if let Some(cache) = cache {
        command.env("NAILNOISE_CACHE", cache);
    }
    command.output().unwrap()
}

fn run(cache: Option<&Path>, out: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["run", SMALL, "--out", out.to_str().unwrap()];
    arguments.extend(more);
    let output = nailnoise(cache, &arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Text between two marks, every time.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    text.split(start)
        .skip(1)
        .filter_map(|rest| rest.split(end).next())
        .collect()
}

/// The charts of a page: name and markup.
fn charts(page: &str) -> Vec<(&str, &str)> {
    between(page, "<figure class=\"chart\" id=\"chart-", "</figure>")
        .into_iter()
        .map(|chart| chart.split_once("\">").unwrap())
        .collect()
}

/// Series of a chart: the names and values of those that have a value for each category.
fn values(chart: &str) -> BTreeMap<&str, Vec<Option<f64>>> {
    between(chart, "data-name=\"", "</g>")
        .into_iter()
        .map(|series| {
            let (name, rest) = series.split_once('"').unwrap();
            let values = between(rest, "data-values=\"", "\"")[0];
            (name, values.split(' ').map(|value| value.parse().ok()).collect())
        })
        .collect()
}

/// The report of the small design, and its result.
static REPORT: LazyLock<(String, Value)> = LazyLock::new(|| {
    let out = folder("report");
    run(None, &out, &[]);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let result = serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    (page, result)
});

/// The text of the report without entities.
fn text() -> String {
    REPORT
        .0
        .replace("&amp;", "&")
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap()
}

#[test]
fn a_report_loads_nothing_from_a_network() {
    let page = &REPORT.0;
    for address in [
        "src=\"http",
        "href=\"http",
        "@import",
        "url(http",
        "fetch(",
        "XMLHttpRequest",
    ] {
        assert!(!page.contains(address), "{address}");
    }
}

#[test]
fn every_chart_has_its_own_name_and_is_not_empty() {
    let charts = charts(&REPORT.0);
    let names: BTreeSet<&str> = charts.iter().map(|(name, _)| *name).collect();
    assert_eq!(names.len(), charts.len());
    assert!(names.len() > 8, "{names:?}");
    for (name, chart) in &charts {
        // A series begins a path, or is a bar of a row.
        let drawn = between(chart, "<g class=\"s ", "</g>")
            .iter()
            .any(|series| series.contains(" d=\"M"));
        assert!(drawn || chart.contains("class=\"bar "), "{name} is empty");
    }
}

#[test]
fn the_band_chart_shows_the_levels_of_the_result() {
    let charts = charts(&REPORT.0);
    let bands = charts.iter().find(|(name, _)| *name == "bands").unwrap().1;
    let shown = values(bands);
    for source in list(&REPORT.1, "ranking") {
        let own = &shown[source["source"].as_str().unwrap()];
        assert_eq!(own.len(), list(source, "bands").len());
        for (shown, band) in own.iter().zip(list(source, "bands")) {
            match band["lwa_db"].as_f64() {
                Some(level) => assert!((shown.unwrap() - level).abs() <= 0.0051),
                None => assert!(shown.is_none()),
            }
        }
    }
}

#[test]
fn a_report_is_short_enough_for_the_mail() {
    assert!(REPORT.0.len() < 3_000_000, "{} bytes", REPORT.0.len());
}

#[test]
fn every_picture_has_a_text_in_its_place() {
    let page = &REPORT.0;
    for image in between(page, "<img ", ">") {
        assert!(
            between(image, "alt=\"", "\"").iter().any(|text| text.len() > 20),
            "{:.80}",
            image
        );
    }
    for plot in between(page, "<div class=\"plot\"", ">") {
        assert!(
            plot.contains("role=\"img\"") && plot.contains("aria-label=\""),
            "{plot}"
        );
    }
}

#[test]
fn a_report_contains_notes_checks_digest_sensors_and_every_value_of_the_design() {
    let (text, result) = (text(), &REPORT.1);
    for note in list(result, "notes").iter().chain(list(result, "method_notes")) {
        // A page sets a minus sign where the terminal has a hyphen, and begins a sentence with a capital.
        let set = note
            .as_str()
            .unwrap()
            .replace(" -", " \u{2212}")
            .replace("(-", "(\u{2212}");
        let (first, rest) = set.split_at(1);
        assert!(
            text.contains(&set) || text.contains(&(first.to_uppercase() + rest)),
            "{note}"
        );
    }
    for input in list(result, "inputs") {
        assert!(
            text.contains(&format!(">{}<", input["key"].as_str().unwrap())),
            "{input}"
        );
    }
    for check in list(result, "checks") {
        assert!(text.contains(check["name"].as_str().unwrap()), "{check}");
    }
    assert!(text.contains(result["design"]["digest"].as_str().unwrap()));
    assert!(text.contains("block_top"), "sensors");
}

#[test]
fn a_report_shows_six_modes() {
    assert_eq!(text().matches("alt=\"deflection of the ").count(), 6);
}

/// Rows of the table of the loudest modes: the text of each cell.
fn loudest_modes(page: &str) -> Vec<Vec<String>> {
    let section = between(page, "id=\"modes\"", "</section>")[0];
    let table = between(section, "<tbody>", "</tbody>")[0];
    let text = |cell: &str| {
        let cell = cell.split_once('>').map_or(cell, |(_, text)| text);
        cell.replace(['\u{2212}', '\u{2013}'], "-")
    };
    let row = |row: &str| {
        let row = row.replace("<th", "<td").replace("</th>", "</td>");
        between(&row, "<td", "</td>").into_iter().map(text).collect()
    };
    between(table, "<tr", "</tr>").into_iter().map(row).collect()
}

#[test]
fn without_radiation_efficiencies_modes_are_placed_by_their_level_at_radiation_efficiency_1() {
    let rows = loudest_modes(&REPORT.0);
    assert_eq!(rows.len(), 15);
    assert!(rows.iter().all(|row| row[3] == "-" && row[4] == "-"), "{rows:?}");
    let levels: Vec<f64> = rows.iter().map(|row| row[5].parse().unwrap()).collect();
    assert!(levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    assert!(text().contains("not computed: the method of this source takes radiation efficiency 1"));
}

#[test]
fn with_boundary_elements_modes_are_placed_by_the_level_with_their_own_radiation_efficiency() {
    let out = folder("report-bem");
    let output = nailnoise(
        None,
        &["run", "tests/data/small-bem.toml", "--out", out.to_str().unwrap()],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = loudest_modes(&fs::read_to_string(out.join("report.html")).unwrap());
    assert_eq!(rows.len(), 15);
    let number = |text: &str| text.parse::<f64>().ok();
    let mut changed = 0;
    let mut levels = Vec::new();
    for row in &rows {
        let [own, efficiency, at_one] = [3, 4, 5].map(|column| number(&row[column]));
        levels.push(own.or(at_one).unwrap());
        if let Some(own) = own {
            // Each of the three is rounded to 0.1 dB.
            let sum = at_one.unwrap() + efficiency.unwrap();
            assert!((own - sum).abs() < 0.151, "{row:?}");
            changed += usize::from((own - at_one.unwrap()).abs() > 0.5);
        }
    }
    assert!(levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    assert!(changed > 0, "{rows:?}");
    let file = fs::read_to_string(out.join("radiation-modes.csv")).unwrap();
    let header: Vec<&str> = file.lines().next().unwrap().split(',').collect();
    let column = header
        .iter()
        .position(|name| name.contains("radiation efficiency alone [dB]"));
    let result: Value = serde_json::from_slice(&fs::read(out.join("result.json")).unwrap()).unwrap();
    let first = file.lines().find(|line| line.starts_with("worktable,7,")).unwrap();
    let in_file: f64 = first.split(',').nth(column.unwrap()).unwrap().parse().unwrap();
    let bodies = list(&result, "radiation_efficiencies");
    let table = bodies.iter().find(|own| own["body"] == "worktable").unwrap();
    let in_result = table["modes"][6]["efficiency_db"].as_f64().unwrap();
    assert!((in_file - in_result).abs() < 0.0051, "{in_file} {in_result}");
}

/// The energy per area of the view in space, over the free faces, is the ERP of the ranking.
#[test]
fn the_view_in_space_sums_to_the_equivalent_radiated_power() {
    let (page, result) = &*REPORT;
    let workpiece = result["ranking"]
        .as_array()
        .unwrap()
        .iter()
        .find(|s| s["source"] == "workpiece")
        .unwrap();
    if workpiece["method"] != "ERP" {
        return; // only then are the two the same quantity
    }
    let scene = between(page, "<figure class=\"scene\">", "</figure>")[0];
    let scene: Value = serde_json::from_str(between(scene, "application/json\">", "</script>")[0]).unwrap();
    let bytes = |value: &Value| STANDARD.decode(value.as_str().unwrap()).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let (step, shown, high) = (
        number(&scene["step"]),
        number(&scene["shown"]),
        number(&scene["views"][0]),
    );
    let mut energy = 0.0;
    let of_the_source = |body: &&Value| ["workpiece", "worktable"].iter().any(|name| body["name"] == *name);
    for body in list(&scene, "bodies").iter().filter(of_the_source) {
        let points = bytes(&body["points"]);
        let points: Vec<f64> = points
            .chunks_exact(2)
            .map(|place| step * f64::from(i16::from_le_bytes([place[0], place[1]])))
            .collect();
        let corners = bytes(&body["triangles"]);
        let corners: Vec<usize> = corners
            .chunks_exact(4)
            .map(|corner| u32::from_le_bytes(corner.try_into().unwrap()) as usize)
            .collect();
        // Faces that are covered have no level.
        for (triangle, shade) in corners.chunks_exact(3).zip(bytes(&body["levels"][0])) {
            let level = high - shown * (1.0 - f64::from(shade) / 255.0);
            let p = [0, 1, 2].map(|corner: usize| [0, 1, 2].map(|axis| points[3 * triangle[corner] + axis]));
            let side = |a: usize| [0, 1, 2].map(|axis: usize| p[a][axis] - p[0][axis]);
            let (u, v) = (side(1), side(2));
            let cross = [
                u[1] * v[2] - u[2] * v[1],
                u[2] * v[0] - u[0] * v[2],
                u[0] * v[1] - u[1] * v[0],
            ];
            let area = 0.5 * cross.iter().map(|c| c * c).sum::<f64>().sqrt();
            energy += area * 1e-12 * 10f64.powf(level / 10.0);
        }
    }
    let level = 10.0 * (energy / 1e-12).log10();
    let expected = workpiece["lwa_db"].as_f64().unwrap();
    // One point a face of a coarse mesh, and octaves that reach over the ends of the range.
    assert!((level - expected).abs() < 1.0, "{level} is not {expected}");
}

#[test]
fn an_unchanged_design_is_restored_from_the_cache() {
    let (out, cache) = (folder("kept"), folder("kept-cache"));
    let first = run(Some(&cache), &out, &["--json"]);
    let all = |folder: &Path| -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path)
                } else {
                    files.insert(path.clone(), fs::read(path).unwrap());
                }
            }
        }
        files
    };
    let before = all(&out);
    assert!(
        before
            .keys()
            .all(|file| !file.to_string_lossy().contains(".unfinished")),
        "{:?}",
        before.keys()
    );
    // Spoiled, lost, one bit turned, cut short: among the files that are stored in full and among those that are
    // rendered.
    fs::write(out.join("levels.csv"), "spoiled").unwrap();
    fs::remove_file(out.join("report.html")).unwrap();
    fs::remove_file(out.join("modes.csv")).unwrap();
    let frame = out.join("fields/worktable.vtu");
    let mut bytes = before[&frame].clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&frame, &bytes).unwrap();
    let surface = out.join("fields/workpiece.vtu");
    fs::write(&surface, &before[&surface][..middle]).unwrap();
    let again = run(Some(&cache), &out, &["--json"]);
    assert_eq!(
        again.stdout, first.stdout,
        "to the last digit, timing included: it was not computed"
    );
    assert!(all(&out) == before, "every file is back, byte for byte");
    // Quiet is quiet, and another provenance is another result.
    let quiet = run(Some(&cache), &out, &["--quiet"]);
    assert!(quiet.stderr.is_empty(), "{}", String::from_utf8_lossy(&quiet.stderr));
    assert!(String::from_utf8_lossy(&quiet.stdout).contains("unchanged design"));
    // A damaged entry is noticed, and the digits are the same.
    let entry = fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().path());
    let entry = entry
        .into_iter()
        .find(|path| path.file_name().unwrap().to_string_lossy().starts_with("run-"))
        .unwrap();
    let mut bytes = fs::read(&entry).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&entry, bytes).unwrap();
    let repaired = run(Some(&cache), &out, &["--json"]);
    assert!(String::from_utf8_lossy(&repaired.stderr).contains("damaged"));
    let of = |output: &Output| -> Value {
        let mut value: Value = serde_json::from_slice(&output.stdout).unwrap();
        value.as_object_mut().unwrap().remove("timing");
        value
    };
    assert_eq!(of(&repaired), of(&first));
}

#[test]
fn a_comparison_has_a_page() {
    let out = folder("report-compare");
    fs::create_dir_all(&out).unwrap();
    let quiet = out.join("quiet.toml");
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join(SMALL);
    fs::write(&quiet, format!("base = {base:?}\nsupply.pressure = \"650 kPa\"\n")).unwrap();
    let output = nailnoise(
        None,
        &[
            "compare",
            SMALL,
            quiet.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ],
    );
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(out.join("compare-small-quiet.html")).unwrap();
    let overview = values(charts(&page)[0].1);
    assert_eq!(overview.keys().copied().collect::<Vec<_>>(), ["quiet", "small"]);
    assert!(page.contains("supply.pressure"));
    assert_eq!(
        page.matches("src=\"data:audio/wav").count(),
        2,
        "a sound for each design"
    );
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
}

/// Comma-separated files as spreadsheets take them: every row as wide as the header.
#[test]
fn tables_are_rectangular() {
    let out = folder("rectangular");
    run(None, &out, &[]);
    for entry in fs::read_dir(&out).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            let text = fs::read_to_string(&path).unwrap();
            let widths: BTreeSet<usize> = text.lines().map(|line| line.split(',').count()).collect();
            assert_eq!(widths.len(), 1, "{}: {widths:?}", path.display());
            assert!(
                !text.contains('"') && text.is_ascii() && text.ends_with('\n'),
                "{}",
                path.display()
            );
        }
    }
}

#[test]
fn a_design_begins_with_init_and_is_explained_by_check() {
    let place = folder("init");
    let file = place.join("mine.toml");
    let name = file.to_str().unwrap();
    let output = nailnoise(None, &["init", name]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // Every line that is offered is a key of the design.
    let text = fs::read_to_string(&file).unwrap();
    let offered: String = text
        .lines()
        .map(|line| {
            let key = line
                .strip_prefix("# ")
                .filter(|rest| rest.split_whitespace().nth(1) == Some("="));
            format!("{}\n", key.unwrap_or(line))
        })
        // Without a geometry of the user's own and other dimensions of the tool, which gmsh would have to mesh.
        .filter(|line| {
            !["housing.step", "bore"].iter().any(|other| line.contains(other)) && !line.starts_with("  mass")
        })
        .collect();
    fs::write(place.join("all.toml"), offered).unwrap();
    for design in [name, place.join("all.toml").to_str().unwrap()] {
        let output = nailnoise(None, &["check", design, "--json"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let told: Value = serde_json::from_slice(&output.stdout).unwrap();
        // All offers at once are a weaker tool, which need not drive its nail.
        assert!(design != name || told["shot"]["outcome"] == "drives", "{told}");
        assert!(told["provenance"]["estimated"].as_u64().unwrap() > 100);
        // Other dimensions of the tool require a new mesh.
        let meshed = |body: &Value| body["gmsh"] == false;
        assert!(
            design != name || told["bodies"].as_array().unwrap().iter().all(meshed),
            "{told}"
        );
        assert!(told["estimates"][0]["range"].is_array());
    }
    let again = nailnoise(None, &["init", name]);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("already"));
    // Other dimensions of the tool body need gmsh, which the explanation states.
    let long = place.join("long.toml");
    fs::write(&long, "base = \"n80cb.toml\"\nbody.handle_length = \"163 mm\"\n").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_nailnoise"))
        .args(["check", long.to_str().unwrap(), "--json"])
        .env("NAILNOISE_GMSH", "no-such-gmsh")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told: Value = serde_json::from_slice(&output.stdout).unwrap();
    let tool = told["bodies"]
        .as_array()
        .unwrap()
        .iter()
        .find(|body| body["body"] == "tool")
        .unwrap();
    assert_eq!(tool["gmsh"], true);
    assert!(told["obstacles"][0].as_str().unwrap().contains("gmsh"), "{told}");
}

/// Whether a value satisfies a schema, as far as these schemas go.
fn keeps(schema: &Value, value: &Value, root: &Value, place: &str) {
    if let Some(reference) = schema["$ref"].as_str() {
        let target = root.pointer(reference.strip_prefix('#').unwrap()).unwrap();
        return keeps(target, value, root, place);
    }
    for alternatives in [&schema["anyOf"], &schema["oneOf"]]
        .into_iter()
        .filter_map(Value::as_array)
    {
        let kept = |own: &Value| std::panic::catch_unwind(|| keeps(own, value, root, place)).is_ok();
        assert!(alternatives.iter().any(kept), "{place}: {value}");
    }
    if let Some(only) = schema.get("const") {
        assert_eq!(value, only, "{place}");
    }
    if let Some(choices) = schema["enum"].as_array() {
        assert!(choices.contains(value), "{place}: {value}");
    }
    let name = match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(number) if number.is_i64() && ["uint", "int32"].map(Value::from).contains(&schema["format"]) => {
            "integer"
        }
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    };
    match &schema["type"] {
        Value::String(one) => assert_eq!(one, name, "{place}"),
        Value::Array(several) => assert!(several.iter().any(|one| one == name), "{place}: {name}"),
        _ => {}
    }
    let items = value.as_array().map_or(0, Vec::len) as u64;
    if value.is_array() {
        assert!(
            schema["minItems"].as_u64().is_none_or(|least| items >= least),
            "{place}: {items} items"
        );
        assert!(
            schema["maxItems"].as_u64().is_none_or(|most| items <= most),
            "{place}: {items} items"
        );
    }
    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
        if schema["items"].is_object() {
            keeps(&schema["items"], item, root, &format!("{place}/{index}"));
        }
    }
    let Some(fields) = value.as_object() else { return };
    for key in schema["required"].as_array().into_iter().flatten() {
        assert!(fields.contains_key(key.as_str().unwrap()), "{place} lacks {key}");
    }
    for (key, field) in fields {
        let own = &schema["properties"][key];
        let own = if own.is_null() {
            &schema["additionalProperties"]
        } else {
            own
        };
        if own.is_object() {
            keeps(own, field, root, &format!("{place}/{key}"));
        }
    }
}

#[test]
fn the_published_schema_is_that_of_the_result() {
    let output = nailnoise(None, &["schema", "--of", "result"]);
    let schema: Value = serde_json::from_slice(&output.stdout).unwrap();
    let out = folder("result-schema");
    let result: Value = serde_json::from_slice(&run(None, &out, &["--json"]).stdout).unwrap();
    keeps(&schema, &result, &schema, "");
    let mut wrong = result.clone();
    wrong["ranking"][0]["share"] = "much".into();
    assert!(std::panic::catch_unwind(|| keeps(&schema, &wrong, &schema, "")).is_err());
}

/// The book's table of contents names files that are there.
#[test]
fn every_page_of_the_book_exists() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let mut pages = 0;
    for entry in fs::read_dir(&docs).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        pages += 1;
        let text = fs::read_to_string(&path).unwrap();
        for link in between(&text, "](", ")") {
            let file = link.split('#').next().unwrap();
            if !file.is_empty() && !file.contains("://") {
                assert!(docs.join(file).exists(), "{}: {link}", path.display());
            }
        }
    }
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    assert_eq!(
        between(&summary, "](", ")").len(),
        pages - 1,
        "every page is in the table of contents"
    );
}

/// Ctrl-C at several moments, the last as the first files take their places: status 130, no unfinished folder, and no
/// file without the rest of its run.
#[cfg(unix)]
#[test]
fn an_interruption_leaves_no_partial_file() {
    let mut interrupted = 0;
    for (index, wait) in [Some(40), Some(300), Some(900), None].into_iter().enumerate() {
        let out = folder(&format!("interrupted-{index}"));
        let mut run = Command::new(env!("CARGO_BIN_EXE_nailnoise"))
            .args(["run", SMALL, "--quiet", "--no-cache", "--out", out.to_str().unwrap()])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        match wait {
            Some(wait) => std::thread::sleep(std::time::Duration::from_millis(wait)),
            None => {
                while left_in(&out).iter().all(|name| name.starts_with('.')) {
                    std::thread::sleep(std::time::Duration::from_micros(200));
                }
            }
        }
        let sent = Command::new("kill")
            .args(["-INT", &run.id().to_string()])
            .status()
            .unwrap();
        let status = run.wait().unwrap();
        if !status.success() {
            assert!(sent.success());
            interrupted += 1;
            assert_eq!(status.code(), Some(130));
        }
        let left = left_in(&out);
        assert!(left.iter().all(|name| !name.starts_with('.')), "{left:?}");
        let whole = left.iter().any(|name| name == "result.json");
        assert!(left.is_empty() || whole, "{left:?}");
        assert!(!whole || left.iter().any(|name| name == "report.html"), "{left:?}");
    }
    assert!(interrupted > 0, "none was interrupted");
}

/// The names in a folder; of one that is not there, none.
fn left_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect()
}
