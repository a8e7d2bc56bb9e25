//! Figures of a cycle: every one drawn, marked, small, and the same each time.

use nailnoise::chain::{cycle, cycle_as_published};
use nailnoise::stages::cycle::Preset;
use nailnoise::{Design, figures};

fn design() -> Design {
    Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap()
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
fn every_figure_is_drawn_within_its_page_and_is_small() {
    let design = design();
    for record in [
        cycle(&design).unwrap(),
        cycle_as_published(&design, Preset::PublishedAll).unwrap(),
    ] {
        let figures = figures::cycle("n80cb", &design, &record);
        let names: Vec<&str> = figures.iter().map(|figure| figure.name).collect();
        assert_eq!(names, ["pressures", "motion", "ratios", "forces", "energy"]);
        for figure in &figures {
            let svg = &figure.svg;
            assert!(svg.len() < 300_000, "{} has {} bytes", figure.name, svg.len());
            assert!(
                svg.starts_with("<svg width=\"180mm\"") && svg.trim_end().ends_with("</svg>"),
                "{}",
                figure.name
            );
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", figure.name);
            let height: i32 = svg
                .split("viewBox=\"0 0 3600 ")
                .nth(1)
                .unwrap()
                .split('"')
                .next()
                .unwrap()
                .parse()
                .unwrap();
            let outside = |p: &[i32; 2]| !(0..=3600).contains(&p[0]) || !(0..=height).contains(&p[1]);
            assert_eq!(points(svg).into_iter().find(outside), None, "{}", figure.name);
        }
        assert_eq!(figures, figures::cycle("n80cb", &design, &record));
    }
}

#[test]
fn every_event_is_marked_over_the_figures_of_time() {
    let design = design();
    let record = cycle(&design).unwrap();
    for figure in figures::cycle("n80cb", &design, &record)
        .iter()
        .filter(|figure| figure.name != "energy")
    {
        for symbol in ["t₀", "t₁", "t₂", "t₉", "t₁₀", "t₁₈"] {
            assert!(
                figure.svg.lines().any(|line| line == symbol),
                "{symbol} in {}",
                figure.name
            );
        }
    }
}

#[test]
fn spikes_of_a_few_microseconds_reach_their_height() {
    let design = design();
    let record = cycle(&design).unwrap();
    let lowest = record.forces.cap.iter().copied().fold(0.0, f64::min);
    assert!(lowest < -1e4, "the cap is struck: {lowest}");
    let figures = figures::cycle("n80cb", &design, &record);
    let forces = &figures.iter().find(|figure| figure.name == "forces").unwrap().svg;
    // The first panel holds the head valve's contacts; its range ends 5 % of the spread below the deepest spike.
    let purple = forces
        .split("<polyline")
        .filter(|line| line.contains("stroke=\"#CC79A7\""));
    let deepest = purple
        .flat_map(|line| points(&format!("<polyline{line}")))
        .map(|p| p[1])
        .max()
        .unwrap();
    let frame = forces
        .split("<polyline")
        .filter(|line| line.contains("stroke=\"#222222\""));
    let bottom = frame
        .map(|line| points(&format!("<polyline{line}")))
        .find(|line| line.len() == 5)
        .unwrap()[2][1];
    let [top, height] = [34.0 * 20.0, f64::from(bottom - deepest)];
    let highest = record.forces.seat.iter().copied().fold(0.0, f64::max);
    let margin = top * 0.05 / 1.1;
    assert!(
        (height - margin).abs() < 2.0,
        "{height} of {margin} for {lowest} to {highest}"
    );
}

#[test]
fn a_cascade_names_what_a_published_form_does_not_keep() {
    let design = design();
    let energy = |record| figures::cycle("n80cb", &design, &record).pop().unwrap().svg;
    let lost = "not kept by the model";
    assert!(!energy(cycle(&design).unwrap()).contains(lost));
    assert!(energy(cycle_as_published(&design, Preset::PublishedAll).unwrap()).contains(lost));
}
