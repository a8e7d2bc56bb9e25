//! Charts of a cycle: every one drawn, marked, small, and the same each time.

use nailnoise::chain::cycle;
use nailnoise::design::inputs::cycle::{cycle_settings, parameters};
use nailnoise::figures::Chart;
use nailnoise::stages::cycle::{Cycle, Preset};
use nailnoise::{Design, figures};
use nailnoise_dynamics::CycleRecord;

/// The cycle of a design with every form as published.
fn published(design: &Design) -> CycleRecord {
    let cycle = Cycle {
        parameters: parameters(design).unwrap(),
        settings: cycle_settings(design),
    };
    cycle.published(Preset::PublishedAll).record().unwrap()
}

fn design() -> Design {
    Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap()
}

fn charts() -> Vec<Chart> {
    let design = design();
    figures::cycle("n80cb", &design, (&cycle(&design).unwrap()).into())
}

/// The values of an attribute, in the order of the file.
fn attributes<'a>(svg: &'a str, name: &str) -> Vec<&'a str> {
    let before = format!(" {name}=\"");
    let values = svg.split(&before).skip(1);
    values.filter_map(|rest| rest.split('"').next()).collect()
}

/// The contents of all texts.
fn texts(svg: &str) -> Vec<String> {
    let texts = svg
        .split("<text ")
        .skip(1)
        .filter_map(|rest| rest.split("</text>").next());
    texts
        .filter_map(|text| Some(text.split_once('>')?.1.to_owned()))
        .collect()
}

/// The points of a curve: `M` begins a piece, steps follow.
fn points(path: &str) -> Vec<[i64; 2]> {
    let mut found = Vec::new();
    for piece in path.split('M').skip(1) {
        let numbers = piece.split([' ', 'l']).filter_map(|number| number.parse::<i64>().ok());
        let numbers: Vec<i64> = numbers.collect();
        let mut at = [0, 0];
        for step in numbers.chunks_exact(2) {
            at = [at[0] + step[0], at[1] + step[1]];
            found.push(at);
        }
    }
    found
}

#[test]
fn every_chart_of_a_cycle_is_drawn_within_its_page() {
    let design = design();
    for record in [cycle(&design).unwrap(), published(&design)] {
        let charts = figures::cycle("n80cb", &design, (&record).into());
        let names: Vec<&str> = charts.iter().map(|chart| chart.name.as_str()).collect();
        assert_eq!(names, ["pressures", "motion", "ratios", "forces", "flow", "energy"]);
        for chart in &charts {
            let (name, svg) = (&chart.name, chart.svg());
            assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>"), "{name}");
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
            assert_eq!(attributes(&svg, "width")[0], "180mm");
            let sizes = attributes(&svg, "viewBox");
            let size = |place: usize| -> Vec<f64> { sizes[place].split(' ').map(|own| own.parse().unwrap()).collect() };
            let height = size(0)[3];
            // Each panel is a clipped drawing inside the page.
            let panels = svg.split("<svg x=").skip(1);
            let mut bottom = 0.0;
            for panel in panels {
                let number = |name| attributes(panel, name)[0].parse::<f64>().unwrap();
                assert!(number("y") > bottom && number("width") < 3600.0, "{name}");
                bottom = number("y") + number("height");
            }
            assert!(sizes.len() == 1 + chart.panels.len() && bottom < height, "{name}");
        }
    }
}

#[test]
fn a_drawing_is_small() {
    for chart in charts() {
        let bytes = chart.svg().len();
        assert!(bytes < 300_000, "{} has {bytes} bytes", chart.name);
    }
}

#[test]
fn a_chart_is_drawn_the_same_each_time() {
    let drawn = || charts().iter().map(Chart::svg).collect::<Vec<_>>();
    assert_eq!(drawn(), drawn());
}

#[test]
fn a_drawing_contains_every_legend_entry_axis_title_and_description() {
    for chart in charts() {
        let svg = chart.svg();
        let texts = texts(&svg);
        let contains = |text: &str| texts.iter().any(|own| own == text);
        for panel in &chart.panels {
            for series in panel.series.iter().filter(|own| !own.name.is_empty()) {
                assert!(contains(&series.name), "{} in {}", series.name, chart.name);
            }
            let title = match panel.y.unit {
                "" => panel.y.label.clone(),
                unit => format!("{} ({unit})", panel.y.label),
            };
            assert!(contains(&title), "{title} in {}", chart.name);
        }
        assert!(svg.contains(&format!("<title>{}: n80cb</title>", chart.title)) && svg.contains("<desc>"));
    }
}

#[test]
fn every_event_is_marked_over_the_charts_of_time() {
    for chart in charts().iter().filter(|chart| chart.name != "energy") {
        let texts = texts(&chart.svg());
        for symbol in ["t₀", "t₁", "t₂", "t₉", "t₁₀", "t₁₈"] {
            assert!(texts.iter().any(|text| text == symbol), "{symbol} in {}", chart.name);
        }
    }
}

#[test]
fn spikes_of_a_few_microseconds_reach_their_height() {
    let design = design();
    let record = cycle(&design).unwrap();
    let lowest = record.history("cap.force").iter().copied().fold(0.0, f64::min);
    assert!(lowest < -1e4, "the cap is struck: {lowest}");
    let charts = figures::cycle("n80cb", &design, (&record).into());
    let forces = charts.iter().find(|chart| chart.name == "forces").unwrap();
    let valve = &forces.panels[0];
    let deepest = valve.series[0].y.iter().copied().fold(0.0, f64::min);
    assert!(
        (1e3 * deepest - lowest).abs() < 1e-9 * lowest.abs(),
        "{deepest} kN of {lowest} N"
    );
    // In the drawing: 20 units a millimetre, from the upper end of the axis down.
    let svg = forces.svg();
    let own = svg
        .split("<path ")
        .filter(|path| path.contains("stroke=\"#CC79A7\" stroke-width=\"7\""));
    let curves = own.flat_map(|path| points(attributes(&format!(" {path}"), "d")[0]));
    let drawn = curves.map(|[_, y]| y).filter(|y| *y > 100).max().unwrap();
    let [low, high] = valve.y.range;
    let expected = f64::from(valve.height) * 20.0 * (high - deepest) / (high - low);
    assert!((drawn as f64 - expected).abs() < 1.0, "{drawn} of {expected}");
}

#[test]
fn a_cascade_names_what_a_published_form_does_not_keep() {
    let design = design();
    let energy = |own: CycleRecord| figures::energy("n80cb", &design.ambient, &own.figures).svg();
    let lost = "not kept by the model";
    assert!(!energy(cycle(&design).unwrap()).contains(lost));
    assert!(energy(published(&design)).contains(lost));
}

/// The energy stored at the start, with all flows, is the energy stored at the end.
#[test]
fn a_cascade_closes() {
    let design = design();
    for panel in figures::energy("n80cb", &design.ambient, &cycle(&design).unwrap().figures).panels {
        let last = panel.y.categories.len() as f64 - 1.0;
        let stored = &panel.series[0];
        assert_eq!(stored.y.last(), Some(&last));
        assert!(stored.x.last().unwrap().abs() < 2e-3 * panel.x.range[1]);
    }
}
