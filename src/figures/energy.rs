//! Energy of a shot as two cascades: for the gas, and for the mechanics that its work drives.
//!
//! Each bar begins at the end of the one above it, so that inputs build up to the right and losses lead back to the
//! remainder.

use nailnoise_dynamics::{Ambient, EnergyFlow, NailerFigures};

use super::chart::{Axis, Chart, Panel, Series, Shape};
use super::palette::GREY;

/// Terms below this fraction of the largest are drawn together.
const SMALL: f64 = 1e-3;

/// A step of a cascade: its name, and the energy that enters (positive) or leaves \[J\].
type Term = (&'static str, f64);

/// The chart of the energy flow of a nailing cycle. `subject` names the design.
pub fn energy(subject: &str, ambient: &Ambient, nailer: &NailerFigures) -> Chart {
    Chart {
        name: "energy".to_owned(),
        title: "Energy flow",
        subject: subject.to_owned(),
        caption:
            "Energy of the gas against that of air at ambient temperature, from its value at the start, and of the \
                  mechanics that the work of the gas drives. Air that flows in or out brings its flow work. Each bar \
                  begins where the one above it ends."
                .to_owned(),
        panels: vec![gas(ambient, nailer), mechanics(&nailer.energy)],
        events: Vec::new(),
    }
}

/// Each mass is counted with the internal energy of air at ambient temperature, R T_a / (gamma - 1), as its zero: a
/// constant of each kilogram drops out of the balance.
fn gas(ambient: &Ambient, nailer: &NailerFigures) -> Panel {
    let (e, mass) = (&nailer.energy, &nailer.summary);
    let zero = ambient.gas_constant * ambient.temperature / (ambient.heat_capacity_ratio - 1.0);
    let gained = mass.supply_mass - mass.exhaust_mass - mass.vent_mass - mass.leak_mass;
    let change = e.gas_end - e.gas_start - gained * zero;
    let flows = vec![
        ("air from the hose", e.supply - mass.supply_mass * zero),
        ("heat from the walls", e.wall_heat),
        ("work on the piston", -e.piston_work),
        ("work on the head valve", -e.valve_work),
        ("air out of the exhaust", mass.exhaust_mass * zero - e.exhaust),
        ("air out of the trigger vent", mass.vent_mass * zero - e.vent),
        ("air out of the rod guide", mass.leak_mass * zero - e.leak),
    ];
    let largest = flows
        .iter()
        .fold(0.0, |largest: f64, (_, energy)| largest.max(energy.abs()));
    let flows = gather(flows, largest, e.gas_residual());
    let end = if change < 0.0 {
        "fall of the stored energy"
    } else {
        "rise of the stored energy"
    };
    cascade(
        "Energy of the gas",
        ("gas at the start, counted as 0", 0.0),
        flows,
        (end, -change),
    )
}

fn mechanics(e: &EnergyFlow) -> Panel {
    let c = &e.contacts;
    let flows = vec![
        ("gas on the piston", e.piston_work),
        ("gas on the head valve", e.valve_work),
        ("air on the rod", e.atmosphere),
        ("hand", e.hand),
        ("gravity", e.gravity),
        ("thrust of the exhaust", e.thrust),
        ("nail into the wood", -e.penetration),
        ("rod on nail, impact", -e.nail_impact),
        ("left with the nail", -e.nail_left),
        ("friction of the piston", -e.piston_friction),
        ("friction of the head valve", -e.valve_friction),
        ("friction in the magazine", -e.magazine_friction),
        ("bumper", -c.bumper),
        ("stopper", -c.stopper),
        ("head valve on the cap", -c.cap),
        ("head valve on its seat", -c.seat),
        ("nose on the wood", -c.nose),
        ("support", -c.support),
        ("damping in the hand", -e.hand_damping),
    ];
    let largest = e.piston_work.abs().max(e.penetration.abs());
    let flows = gather(flows, largest, e.mechanical_residual());
    let start = ("springs and motion at the start", e.kinetic_start + e.elastic_start);
    let end = ("springs and motion at the end", -(e.kinetic_end + e.elastic_end));
    cascade("Mechanical energy", start, flows, end)
}

/// Draws small terms together, so that the cascade still balances. Energy that a published form does not conserve is a
/// separate term; for forms that conserve energy, the residual is rounding, which is too small for a term.
fn gather(flows: Vec<Term>, largest: f64, residual: f64) -> Vec<Term> {
    let small = |energy: f64| energy.abs() < SMALL * largest;
    let (rest, mut flows): (Vec<Term>, Vec<Term>) = flows.into_iter().partition(|(_, energy)| small(*energy));
    let rest: f64 = rest.iter().map(|(_, energy)| energy).sum();
    if rest != 0.0 {
        flows.push(("all others", rest));
    }
    if !small(residual) {
        flows.push(("not kept by the model", -residual));
    }
    flows
}

/// The panel of a cascade between the stored energies at the start and at the end.
fn cascade(label: &str, start: Term, flows: Vec<Term>, end: Term) -> Panel {
    let empty = |name: &str, colour| Series::over(name, colour, Shape::Spans(Vec::new()), []);
    let mut series = [empty("stored", GREY), empty("in", 0), empty("out", 1)];
    let terms: Vec<Term> = std::iter::once(start).chain(flows).chain([end]).collect();
    let (mut level, mut ends) = (0.0f64, [0.0f64; 2]);
    for (row, (_, energy)) in terms.iter().enumerate() {
        let stored = row == 0 || row + 1 == terms.len();
        let own = &mut series[if stored {
            0
        } else if *energy >= 0.0 {
            1
        } else {
            2
        }];
        if let Shape::Spans(from) = &mut own.shape {
            from.push(level);
        }
        level += energy;
        own.x.push(level);
        own.y.push(row as f64);
        own.notes
            .push(note(if stored { energy.abs() } else { *energy }, !stored));
        ends = [ends[0].min(level), ends[1].max(level)];
    }
    let [low, high] = ends;
    Panel {
        // The labels follow the bars.
        x: Axis::new(
            "Energy",
            "J",
            [low, (high + 0.12 * (high - low)).max(f64::MIN_POSITIVE)],
        ),
        y: Axis::categories(label, "", terms.iter().map(|(name, _)| (*name).to_owned()).collect()),
        height: 5 * terms.len() as u32,
        series: series.into(),
    }
}

/// An energy to a tenth of a joule; with its sign for a flow.
fn note(energy: f64, flow: bool) -> String {
    let rounded = (10.0 * energy).round() / 10.0 + 0.0;
    let text = if flow {
        format!("{rounded:+.1}")
    } else {
        format!("{rounded:.1}")
    };
    text.replace('-', "\u{2212}")
}
