//! Laws of the valve noise of IEC 60534-8-3:2010; its worked cases are benchmarks of `nailnoise verify`.

use nailnoise_acoustics::Air;
use nailnoise_acoustics::jets::{FlowHistory, FlowRegime, ValveFlow, ValveNoise, ValveSound};

/// A valve that recovers pressure, so that all five regimes exist.
const VALVE: ValveNoise = ValveNoise {
    efficiency_exponent: -4.2,
    peak_strouhal: 0.2,
    recovery: 0.8,
};

/// Air from 10 bar, with a mass flow of 1 kg/s.
fn flow(outlet_pressure: f64) -> ValveFlow {
    ValveFlow {
        mass_flow: 1.0,
        inlet_pressure: 1e6,
        outlet_pressure,
        inlet_density: 11.6,
        heat_ratio: 1.4,
    }
}

fn at(outlet_pressure: f64) -> ValveSound {
    VALVE.sound(&flow(outlet_pressure)).unwrap().unwrap()
}

#[test]
fn regimes_follow_one_another_and_the_efficiency_rises_as_the_outlet_pressure_falls() {
    let falling: Vec<ValveSound> = (1..1000).map(|i| at(1e6 - 1e3 * f64::from(i))).collect();
    for pair in falling.windows(2) {
        assert!(pair[0].regime <= pair[1].regime, "{pair:?}");
        assert!(pair[0].stream_power <= pair[1].stream_power * (1.0 + 1e-12), "{pair:?}");
    }
    for regime in [
        FlowRegime::Subsonic,
        FlowRegime::Recompressed,
        FlowRegime::Choked,
        FlowRegime::MachDisc,
        FlowRegime::ConstantEfficiency,
    ] {
        let own: Vec<&ValveSound> = falling.iter().filter(|sound| sound.regime == regime).collect();
        assert!(!own.is_empty(), "{regime:?}");
        assert!(
            own.windows(2).all(|pair| pair[0].efficiency <= pair[1].efficiency),
            "{regime:?}"
        );
    }
}

#[test]
fn beyond_a_pressure_ratio_of_22_nothing_changes() {
    // alpha = 0.528/(1 - 0.64 x 0.472) = 0.757: regime V begins at p_1/p_2 = 22 x 0.757 = 16.7.
    assert_eq!(at(6.1e4).regime, FlowRegime::MachDisc);
    assert_eq!(at(5.9e4).regime, FlowRegime::ConstantEfficiency);
    assert_eq!(at(5.9e4), at(1.0));
}

#[test]
fn a_flow_without_a_falling_pressure_is_silent_and_an_impossible_one_refused() {
    assert_eq!(VALVE.sound(&flow(1e6)).unwrap(), None);
    assert_eq!(VALVE.sound(&flow(2e6)).unwrap(), None);
    for wrong in [
        ValveFlow {
            mass_flow: 0.0,
            ..flow(1e5)
        },
        ValveFlow {
            outlet_pressure: f64::NAN,
            ..flow(1e5)
        },
        ValveFlow {
            heat_ratio: 1.0,
            ..flow(1e5)
        },
    ] {
        assert!(VALVE.sound(&wrong).is_err(), "{wrong:?}");
    }
}

#[test]
fn the_energy_of_a_steady_flow_is_its_power_times_its_duration() {
    let air = Air::default();
    let (pressure, temperature, samples) = (4e5, 290.0, 500);
    let history = FlowHistory {
        sample_interval: 1e-5,
        mass_flow: vec![0.02; samples],
        pressure: vec![pressure; samples],
        temperature: vec![temperature; samples],
        back_pressure: None,
    };
    let flow = ValveFlow {
        mass_flow: 0.02,
        inlet_pressure: pressure,
        outlet_pressure: air.pressure,
        inlet_density: pressure / (air.gas_constant * temperature),
        heat_ratio: air.heat_ratio,
    };
    let power = ValveNoise::DRILLED_PLATE.sound(&flow).unwrap().unwrap().power();
    let energy = ValveNoise::DRILLED_PLATE.energy(&history, &air);
    assert!((energy / (power * 5e-3) - 1.0).abs() < 1e-12, "{energy} {power}");
}
