//! Charts of a cycle: every one drawn, marked, small, and the same each time.

use nailnoise::chain::{cycle, cycle_as_published};
use nailnoise::figures::Chart;
use nailnoise::stages::cycle::Preset;
use nailnoise::{Design, figures};

fn design() -> Design {
    Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap()
}

fn charts() -> Vec<Chart> {
    let design = design();
    figures::cycle("n80cb", &design, &cycle(&design).unwrap())
}

/// Points of all lines of a drawing.
fn points(svg: &str) -> Vec<[i32; 2]> {
    let number = |text: &str| text.parse::<i32>().unwrap();
    let pair = |text: &str| text.split_once(',').map(|(x, y)| [number(x), number(y)]).unwrap();
    let lines = svg
        .split("points=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap());
    lines.flat_map(|line| line.split_whitespace().map(pair)).collect()
}

#[test]
fn every_chart_of_a_cycle_is_drawn_within_its_page() {
    let design = design();
    for record in [
        cycle(&design).unwrap(),
        cycle_as_published(&design, Preset::PublishedAll).unwrap(),
    ] {
        let charts = figures::cycle("n80cb", &design, &record);
        let names: Vec<&str> = charts.iter().map(|chart| chart.name.as_str()).collect();
        assert_eq!(names, ["pressures", "motion", "ratios", "forces", "flow", "energy"]);
        for chart in &charts {
            let (name, svg) = (&chart.name, chart.svg());
            assert!(
                svg.starts_with("<svg width=\"180mm\"") && svg.trim_end().ends_with("</svg>"),
                "{name}"
            );
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
            let size = svg.split("viewBox=\"0 0 3600 ").nth(1).unwrap();
            let height: i32 = size.split('"').next().unwrap().parse().unwrap();
            let outside = |p: &[i32; 2]| !(0..=3600).contains(&p[0]) || !(0..=height).contains(&p[1]);
            assert_eq!(points(&svg).into_iter().find(outside), None, "{name}");
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
fn a_drawing_holds_every_legend_entry_axis_title_and_description() {
    for chart in charts() {
        let svg = chart.svg();
        let texts: Vec<String> = svg.lines().map(|line| line.replace("&apos;", "'")).collect();
        let holds = |text: &str| texts.iter().any(|line| line == text);
        for panel in &chart.panels {
            for series in &panel.series {
                assert!(holds(&series.name), "{} in {}", series.name, chart.name);
            }
            let title = match panel.y.unit {
                "" => panel.y.label.clone(),
                unit => format!("{} ({unit})", panel.y.label),
            };
            assert!(holds(&title), "{title} in {}", chart.name);
        }
        assert!(svg.contains(&format!("<title>{}: n80cb</title>", chart.title)) && svg.contains("<desc>"));
    }
}

#[test]
fn every_event_is_marked_over_the_charts_of_time() {
    for chart in charts().iter().filter(|chart| chart.name != "energy") {
        let svg = chart.svg();
        for symbol in ["t₀", "t₁", "t₂", "t₉", "t₁₀", "t₁₈"] {
            assert!(svg.lines().any(|line| line == symbol), "{symbol} in {}", chart.name);
        }
    }
}

#[test]
fn spikes_of_a_few_microseconds_reach_their_height() {
    let design = design();
    let record = cycle(&design).unwrap();
    let lowest = record.forces.cap.iter().copied().fold(0.0, f64::min);
    assert!(lowest < -1e4, "the cap is struck: {lowest}");
    let charts = figures::cycle("n80cb", &design, &record);
    let forces = charts.iter().find(|chart| chart.name == "forces").unwrap();
    let valve = &forces.panels[0];
    let deepest = valve.series[0].y.iter().copied().fold(0.0, f64::min);
    assert!(
        (1e3 * deepest - lowest).abs() < 1e-9 * lowest.abs(),
        "{deepest} kN of {lowest} N"
    );
    // In the drawing: the axis is 34 mm high and ends 5 % below the deepest spike.
    let svg = forces.svg();
    let lines = |colour: &str| -> Vec<[i32; 2]> {
        let own = svg
            .split("<polyline")
            .filter(|line| line.contains(&format!("stroke=\"{colour}\"")));
        own.flat_map(|line| points(&format!("<polyline{line}"))).collect()
    };
    let drawn = lines("#CC79A7")
        .iter()
        .map(|p| p[1])
        .filter(|y| *y > 200)
        .max()
        .unwrap();
    let [low, high] = valve.y.range;
    let axis = lines("#222222");
    let bottom = axis
        .windows(2)
        .find(|pair| pair[0][1] == pair[1][1] && pair[1][0] - pair[0][0] > 3000)
        .unwrap()[0][1];
    let expected = 34.0 * 20.0 * (deepest - low) / (high - low);
    assert!(
        (f64::from(bottom - drawn) - expected).abs() < 3.0,
        "{} of {expected}",
        bottom - drawn
    );
}

#[test]
fn a_cascade_names_what_a_published_form_does_not_keep() {
    let design = design();
    let energy = |record| figures::energy("n80cb", &record).svg();
    let lost = "not kept by the model";
    assert!(!energy(cycle(&design).unwrap()).contains(lost));
    assert!(energy(cycle_as_published(&design, Preset::PublishedAll).unwrap()).contains(lost));
}

/// The energy stored at the start, with all flows, is the energy stored at the end.
#[test]
fn a_cascade_closes() {
    let design = design();
    for panel in figures::energy("n80cb", &cycle(&design).unwrap()).panels {
        let last = panel.y.categories.len() as f64 - 1.0;
        let stored = &panel.series[0];
        assert_eq!(stored.y.last(), Some(&last));
        assert!(stored.x.last().unwrap().abs() < 2e-3 * panel.x.range[1]);
    }
}
