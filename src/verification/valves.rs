//! The six worked cases of IEC 60534-8-3:2010, annex A.

use nailnoise_acoustics::jets::{FlowRegime, ValveFlow, ValveNoise};

use super::row::{Case, Row};
use crate::error::Error;

const PRINTED: Case = Case {
    name: "valve noise, annex A",
    source: "IEC 60534-8-3:2010, table A.1, as transcribed in jmrplens/phonometry; F_P 0.984, as the printed p_vc \
        require",
};

const COMPUTED: Case = Case {
    name: "valve noise, intermediate values",
    source: "the same cases with the printed F_P 0.98, another implementation (CalebBell/fluids)",
};

/// A column of table A.1, with the values computed by the other implementation.
struct Worked {
    mass_flow: f64,
    outlet_pressure: f64,
    /// Diameter D_j of the jet \[m\].
    jet_diameter: f64,
    regime: FlowRegime,
    /// Sound power printed \[W\].
    printed_power: f64,
    mach: f64,
    stream_power: f64,
    peak_frequency: f64,
    efficiency: f64,
}

const WORKED: [Worked; 6] = [
    worked(
        2.22,
        720e3,
        11.61e-3,
        FlowRegime::Subsonic,
        22.3,
        [0.9827, 223_060.0, 7722.0, 9.824e-5],
    ),
    worked(
        2.29,
        690e3,
        11.61e-3,
        FlowRegime::Recompressed,
        30.4,
        [1.0295, 237_450.0, 8076.0, 1.2676e-4],
    ),
    worked(
        2.59,
        480e3,
        11.61e-3,
        FlowRegime::Choked,
        141.3,
        [1.3215, 268_550.0, 10_367.0, 5.271e-4],
    ),
    worked(
        1.18,
        420e3,
        7.74e-3,
        FlowRegime::MachDisc,
        86.1,
        [1.4179, 122_350.0, 16_388.0, 7.097e-4],
    ),
    worked(
        1.19,
        50e3,
        7.74e-3,
        FlowRegime::ConstantEfficiency,
        291.9,
        [2.6044, 123_390.0, 6850.0, 2.3945e-3],
    ),
    worked(
        0.89,
        50e3,
        6.70e-3,
        FlowRegime::ConstantEfficiency,
        218.3,
        [2.6044, 92_280.0, 7910.0, 2.3945e-3],
    ),
];

const fn worked(
    mass_flow: f64,
    outlet_pressure: f64,
    jet_diameter: f64,
    regime: FlowRegime,
    printed_power: f64,
    [mach, stream_power, peak_frequency, efficiency]: [f64; 4],
) -> Worked {
    Worked {
        mass_flow,
        outlet_pressure,
        jet_diameter,
        regime,
        printed_power,
        mach,
        stream_power,
        peak_frequency,
        efficiency,
    }
}

/// A ported cage globe valve (A_eta -3.8, St_p 0.2) with F_LP 0.792.
fn valve(piping_factor: f64) -> ValveNoise {
    ValveNoise {
        efficiency_exponent: -3.8,
        peak_strouhal: 0.2,
        recovery: 0.792 / piping_factor,
    }
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    let (mut printed, mut computed) = (Vec::new(), Vec::new());
    for (number, case) in (1..).zip(&WORKED) {
        let flow = ValveFlow {
            mass_flow: case.mass_flow,
            inlet_pressure: 1e6,
            outlet_pressure: case.outlet_pressure,
            inlet_density: 5.3,
            heat_ratio: 1.22,
        };
        if let Some(sound) = valve(0.984).sound(&flow)? {
            let row = PRINTED.row(
                format!("example {number}, sound power, W"),
                case.printed_power,
                sound.power(),
            );
            printed.push(row.within_part(5e-3).decimals(1));
        }
        if let Some(sound) = valve(0.98).sound(&flow)? {
            let row = |what: &str, reference: f64, found: f64, part: f64| {
                let row = COMPUTED.row(format!("example {number}, {what}"), reference, found);
                row.within_part(part)
            };
            let number = |regime: FlowRegime| 1.0 + f64::from(regime as u8);
            let peak = sound.peak_speed / case.jet_diameter;
            computed.extend([
                row("regime", number(case.regime), number(sound.regime), 1e-9).decimals(0),
                row("Mach number", case.mach, sound.mach, 5e-4).decimals(4),
                row("stream power, W", case.stream_power, sound.stream_power, 5e-4).decimals(0),
                row("peak frequency, Hz", case.peak_frequency, peak, 2e-3).decimals(0),
                row("efficiency, 1e-4", 1e4 * case.efficiency, 1e4 * sound.efficiency, 1e-3).decimals(3),
            ]);
        }
    }
    printed.append(&mut computed);
    Ok(printed)
}
