//! Any list of sources, of any length, flows through levels, ranking and study.

use nailnoise::Error;
use nailnoise::graph::Graph;
use nailnoise::result::Uncertainty;
use nailnoise::stages::apart::{Apart, Moved, PartError};
use nailnoise::stages::convention::counted;
use nailnoise::stages::intervals::EventEdges;
use nailnoise::stages::levels::{Levels, ShotLevels};
use nailnoise::stages::outcomes::ShotFigures;
use nailnoise::stages::ranking::rank;
use nailnoise::stages::sound::{Sound, SoundSource};
use nailnoise::stages::sources::{Analysis, Emission};
use nailnoise::stages::{Code, Stored};
use nailnoise::study::{Draw, Draws, Request, StudyResult};
use nailnoise_acoustics::signals::{SourceSpectrum, Weighting};
use serde::Serialize;

use crate::common::{SMALL, design};

const RANGE: [f64; 2] = [50.0, 10_000.0];

/// A source of constant energy density, of which a part may count to another source.
#[derive(Clone, Serialize)]
struct Noise {
    name: String,
    /// Energy density \[J/Hz\].
    density: f64,
    /// Energy density of the part, and the source to which it counts.
    moved: Option<(f64, String)>,
}

impl Noise {
    /// Source number `n` of a list of `count`, each 3 dB above the one before; the last gives a tenth to the first.
    fn list(count: usize) -> Vec<Self> {
        let noise = |n: usize| Self {
            name: format!("source {n}"),
            density: 1e-9 * 2f64.powi(n as i32),
            moved: (n > 0 && n + 1 == count).then(|| (1e-10, "source 0".to_owned())),
        };
        (0..count).map(noise).collect()
    }

    fn spectrum(name: &str, density: f64) -> SourceSpectrum {
        let frequency: Vec<f64> = (4..=1100).map(|n| 10.0 * f64::from(n)).collect();
        let density = vec![density; frequency.len()];
        SourceSpectrum::new(name, "constant", frequency, density, RANGE).unwrap()
    }

    fn analysed(spectrum: SourceSpectrum, edges: &EventEdges) -> SoundSource {
        let sound = Sound {
            spectrum,
            signals: Vec::new(),
            openings: Vec::new(),
            uncertainty: Uncertainty {
                minus: Some(1.0),
                plus: Some(2.0),
                basis: "known".to_owned(),
            },
            cross_check: None,
            radiation: None,
        };
        SoundSource::new(sound, edges, RANGE)
    }
}

impl Emission for Noise {
    const CODE: Code = Code(&[]);

    fn energy(&self) -> Result<Apart<SourceSpectrum>, Error> {
        Ok(Apart {
            own: Self::spectrum(&self.name, self.density),
            moved: self.moved.as_ref().map(|(density, to)| Moved {
                to: to.clone().into(),
                error: PartError::OfPart,
                part: Self::spectrum("part", *density),
            }),
        })
    }

    fn analysed(&self, edges: &EventEdges, _: [f64; 2]) -> Result<Apart<SoundSource>, Error> {
        let energy = self.energy()?;
        Ok(energy.map(|spectrum| Self::analysed(spectrum.clone(), edges)))
    }
}

/// Levels of a shot with this many sources.
fn levels(count: usize) -> Levels {
    let graph = Graph::default();
    let record = nailnoise::chain::shot(&design(SMALL)).unwrap();
    let (cycle, end) = (Stored::ready([1; 32], record), Stored::ready([2; 32], 0.2));
    let source = |emission: Noise| {
        graph.add(Analysis {
            emission,
            cycle: cycle.clone(),
            end: end.clone(),
            range_hz: RANGE,
        })
    };
    let levels = graph.get(ShotLevels {
        sources: Noise::list(count).into_iter().map(source).collect(),
        cycle: cycle.clone(),
        range_hz: RANGE,
        bodies: Vec::new(),
        responses: Vec::new(),
        sensors: None,
    });
    Levels::clone(&*levels.unwrap())
}

fn energy(level: Option<f64>) -> f64 {
    level.map_or(0.0, |level| 10f64.powf(0.1 * level))
}

#[test]
fn a_shot_has_the_levels_of_all_sources_in_the_order_of_their_list() {
    for count in [1, 2, 4, 6] {
        let found = levels(count);
        let names: Vec<&str> = found.sources.iter().map(|source| source.source.as_str()).collect();
        let list = Noise::list(count);
        assert_eq!(names, list.iter().map(|own| own.name.as_str()).collect::<Vec<_>>());
        // Energies and parts sum to the energy that the list emits.
        let sum: f64 = found.sources.iter().map(|source| energy(source.lwa_db)).sum();
        let density = |own: &Noise| own.density + own.moved.as_ref().map_or(0.0, |moved| moved.0);
        let density = list.iter().map(density).sum();
        let emitted = 1e12 * Noise::spectrum("all", density).energy(RANGE, Weighting::A);
        assert!(
            (sum / emitted - 1.0).abs() < 1e-9,
            "{count} sources: {sum} of {emitted}"
        );
        // The part widens the band of the source to which it counts by its own error.
        let [minus, plus] = found.sources[0].method_db.map(Option::unwrap);
        assert!(
            (minus.abs() - 1.0).abs() < 1e-9 && (plus - 2.0).abs() < 1e-9,
            "{minus} {plus}"
        );
    }
}

#[test]
fn a_ranking_has_all_sources_loudest_first_and_their_shares_sum_to_one() {
    let edges = EventEdges::new(&[], 0.2);
    for count in [1, 2, 4, 6] {
        let list = Noise::list(count);
        let analysed: Vec<Apart<SoundSource>> = list
            .iter()
            .map(|own| Emission::analysed(own, &edges, RANGE).unwrap())
            .collect();
        let apart: Vec<Apart<&SoundSource>> = analysed.iter().map(|own| own.map(|source| source)).collect();
        let sources = counted(&apart, RANGE);
        let (ranking, total) = rank(&sources.iter().collect::<Vec<_>>(), RANGE);
        let names: Vec<&str> = ranking.iter().map(|source| source.source.as_str()).collect();
        let loudest_first: Vec<&str> = list.iter().rev().map(|own| own.name.as_str()).collect();
        assert_eq!(names, loudest_first);
        let shares: f64 = ranking.iter().map(|source| source.share).sum();
        assert!((shares - 1.0).abs() < 1e-12);
        let sum: f64 = ranking.iter().map(|source| energy(source.lwa_db)).sum();
        assert!((sum / energy(total.lwa_db) - 1.0).abs() < 1e-12);
        let first = &ranking[count - 1];
        let parts: Vec<&str> = first.components.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(parts.contains(&"part"), count > 1, "{parts:?}");
    }
}

#[test]
fn a_study_has_all_sources_and_their_probabilities_of_being_first_sum_to_one() {
    let design = design(SMALL);
    for count in [1, 2, 4, 6] {
        let nominal = levels(count);
        let uniform = |draw: usize, place: usize| nailnoise_acoustics::random::uniform(1, draw as u64, place as u64);
        let draw = |number: usize| Draw {
            structure: 0,
            candidate: number as u64,
            shares: Vec::new(),
            shot: ShotFigures {
                outcome: "drives".to_owned(),
                mean_drive_speed: Some(20.0),
                penetration: 0.08,
                exhaust_mass: 3e-3,
            },
            levels: nominal.clone(),
            method_db: (0..count).map(|place| 20.0 * uniform(number, place)).collect(),
        };
        let made = Draws {
            draws: (0..64).map(draw).collect(),
            ..Draws::default()
        };
        let study = StudyResult::new(&design, &Request::new(64, 1), &made, Some(&nominal));
        assert_eq!(study.sources.len(), count);
        let names = nominal.sources.iter().map(|source| &source.source);
        assert!(names.clone().all(|name| study.source(name).is_some()));
        let first: f64 = study.sources.iter().map(|source| source.first.value.unwrap()).sum();
        let orders: f64 = study.orders.iter().map(|order| order.probability.value.unwrap()).sum();
        assert!(
            (first - 1.0).abs() < 1e-12 && (orders - 1.0).abs() < 1e-12,
            "{first} {orders}"
        );
        assert!(study.orders.iter().all(|order| order.order.len() == count));
        assert_eq!(study.louder.len(), count * (count - 1) / 2);
    }
}
