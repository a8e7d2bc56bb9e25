//! Effect of each input of a design on its total level, or on the depth of its nail if no study gives the level.

use nailnoise_dynamics::Settings;
use serde::Serialize;

use crate::design::inputs::cycle::{cycle_settings, parameters};
use crate::design::{Design, Measurement, Provenance, facts};
use crate::error::Error;
use crate::graph::Graph;
use crate::stages::Progress;
use crate::stages::cycle::{Cycle, Engine};
use crate::stages::outcomes::{Outcomes, ShotOutcome};
use crate::study::{self, Draws, OneAtATime, Request, Serving, StudyResult, Tally, taking_part};

/// Sampling interval of cycles that are only used for the depth \[s\].
const SAMPLES: f64 = 1e-3;

/// The inputs that change a result, in descending order of effect.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Effects {
    /// The result, and how the effects were determined.
    pub(super) basis: String,
    /// Unit of the effects.
    pub(super) unit: &'static str,
    /// The inputs.
    pub(super) inputs: Vec<Effect>,
}

/// Effect of an input.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Effect {
    /// The key, or another variable of a study.
    pub(super) key: String,
    /// Its value and range in readable units; empty if the variable is not a key.
    pub(super) value: String,
    pub(super) range: String,
    /// The largest change that it causes, in the unit of the effects.
    pub(super) effect: f64,
}

/// A quantity to measure.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ToMeasure {
    /// The key.
    pub(super) key: String,
    /// The largest change that its uncertainty causes, in the unit of the effects.
    pub(super) effect: f64,
    #[serde(flatten)]
    pub(super) measurement: Measurement,
}

/// Keys in the order of their effect.
pub(super) struct OrderedKeys {
    /// The keys, the one of the largest effect first.
    pub(super) keys: Vec<String>,
    /// The results that decide the order.
    pub(super) basis: String,
}

impl Effects {
    /// Effects on the total from a known study of a design. Without one: effects of one input at a time if `compute`,
    /// else effects on the depth of the nail.
    pub(super) fn of(graph: &Graph, design: &Design, compute: bool, progress: &Progress) -> Result<Self, Error> {
        let known = Serving::of(graph.store(), design)?;
        match known.and_then(|serving| Self::of_study(&serving.result)) {
            Some(found) if !compute => Ok(found.described(design)),
            _ if compute => Ok(Self::computed(graph, design, progress)?.described(design)),
            _ => Ok(Self::on_depth(graph, design)?.described(design)),
        }
    }

    /// Keys in descending order of their effect on the total, from a known study, followed by those that the study does
    /// not separate from chance, by their effect on the depth of the nail.
    pub(super) fn ordered_keys(graph: &Graph, design: &Design) -> Result<OrderedKeys, Error> {
        let known = Serving::of(graph.store(), design)?;
        let on_total = known.and_then(|serving| Self::of_study(&serving.result));
        let (mut keys, mut bases) = (Vec::new(), Vec::new());
        for effects in on_total.into_iter().chain([Self::on_depth(graph, design)?]) {
            // The rest of a basis is about options of `check`.
            bases.extend(effects.basis.split(';').next().map(str::to_owned));
            for input in effects.inputs {
                if !keys.contains(&input.key) {
                    keys.push(input.key);
                }
            }
        }
        Ok(OrderedKeys {
            keys,
            basis: bases.join("; then "),
        })
    }

    fn of_study(study: &StudyResult) -> Option<Self> {
        if let Some(own) = &study.one_at_a_time {
            return Some(Self::of_changes(own));
        }
        let total = study.contributions.iter().find(|own| own.output == "total")?;
        let inputs = total
            .inputs
            .iter()
            .map(|own| (own.variable.clone(), own.effect_db.abs()));
        Some(Self::new(
            format!(
                "change of the total between the outer thirds of each input, from a study of {} draws; inputs whose \
                 effect is \
                 within chance are left out",
                study.draws
            ),
            "dB",
            inputs,
        ))
        .filter(|own| !own.inputs.is_empty())
    }

    fn of_changes(own: &OneAtATime) -> Self {
        Self::new(
            "largest change of the total with each input at the 5th or 95th percentile of its range, all others as in \
             the design"
                .to_owned(),
            "dB",
            own.inputs
                .iter()
                .map(|input| (input.variable.clone(), input.largest(0))),
        )
    }

    /// The levels when varying one input at a time; none if the design itself has no levels.
    fn computed(graph: &Graph, design: &Design, progress: &Progress) -> Result<Self, Error> {
        let request = Request::new(0, 1);
        let made = Draws {
            variables: study::variables(design)?,
            draws: Vec::new(),
            structures: 0,
            tally: Tally::default(),
            failures: Vec::new(),
            open_ends: Vec::new(),
        };
        match study::nominal(graph, design, &request)? {
            Some(nominal) => {
                let own = study::one_at_a_time(graph, design, &request, (&made, &nominal), progress)?;
                Ok(Self::of_changes(&own))
            }
            None => Self::on_depth(graph, design),
        }
    }

    /// Effects on the depth of the nail, from the cycle with a lumped workpiece only.
    fn on_depth(graph: &Graph, design: &Design) -> Result<Self, Error> {
        let settings = Settings {
            sample_interval: SAMPLES,
            ..cycle_settings(design)
        };
        let cycle = |parameters| Cycle {
            parameters,
            settings: settings.clone(),
        };
        let (mut keys, mut cycles) = (Vec::new(), vec![cycle(parameters(design)?)]);
        for input in taking_part(design)? {
            for end in input.range {
                let mut moved = design.clone();
                let set = moved.set(&[(input.key.as_str(), input.hold(end))]);
                let own = set.ok().filter(|()| moved.conflict().is_none());
                if let Some(parameters) = own.and_then(|()| parameters(&moved).ok()) {
                    keys.push(input.key.clone());
                    cycles.push(cycle(parameters));
                }
            }
        }
        let engines = cycles.into_iter().map(|cycle| Engine::Keys(Box::new(cycle))).collect();
        let outcomes = graph.get(Outcomes { engines })?;
        let depth = |outcome: &ShotOutcome| match outcome {
            ShotOutcome::Shot(shot) => Some(1e3 * shot.penetration),
            _ => None,
        };
        let here = outcomes.first().and_then(depth);
        let mut effects: Vec<(String, f64)> = Vec::new();
        for (key, there) in keys.into_iter().zip(outcomes.iter().skip(1).map(depth)) {
            let effect = here.zip(there).map_or(0.0, |(here, there)| (there - here).abs());
            match effects.iter_mut().find(|(own, _)| *own == key) {
                Some((_, largest)) => *largest = effect.max(*largest),
                None => effects.push((key, effect)),
            }
        }
        Ok(Self::new(
            "largest change of the depth of the nail's tip with each input at an end of its range, all others as in \
             the design; no \
             study of this design is known: --effects computes the effects on the total in dB, which takes minutes"
                .to_owned(),
            "mm",
            effects.into_iter(),
        ))
    }

    fn new(basis: String, unit: &'static str, effects: impl Iterator<Item = (String, f64)>) -> Self {
        let effect = |(key, effect): (String, f64)| Effect {
            key,
            value: String::new(),
            range: String::new(),
            effect,
        };
        let mut inputs: Vec<Effect> = effects.map(effect).collect();
        inputs.sort_by(|a, b| b.effect.total_cmp(&a.effect).then_with(|| a.key.cmp(&b.key)));
        Self { basis, unit, inputs }
    }

    /// Adds the values and ranges of the keys.
    fn described(mut self, design: &Design) -> Self {
        for entry in design.entries() {
            if let Some(own) = self.inputs.iter_mut().find(|own| own.key == entry.key) {
                let shown = |value| design.value_in_words(&entry.key, value);
                own.value = shown(entry.value.clone());
                own.range = entry.range.map_or_else(String::new, |range| {
                    let [low, high] = range.map(|end| shown(nailnoise_quantities::Value::Number(end)));
                    format!("{low} .. {high}")
                });
            }
        }
        self
    }

    /// Inputs to measure, in descending order of effect: those that can be measured and have not been.
    pub(super) fn to_measure(&self, design: &Design) -> Vec<ToMeasure> {
        let entries = design.entries();
        let measured = |key: &str| {
            let entry = entries.iter().find(|entry| entry.key == key);
            entry.is_some_and(|entry| entry.provenance == Provenance::Constant || entry.source.contains("measured"))
        };
        let of = |own: &Effect| {
            Some(ToMeasure {
                key: own.key.clone(),
                effect: own.effect,
                measurement: facts(&own.key)?.measurement()?,
            })
        };
        let open = self.inputs.iter().filter(|own| own.effect > 0.0 && !measured(&own.key));
        open.filter_map(of).collect()
    }
}
