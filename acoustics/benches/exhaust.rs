//! Time to analyse the exhaust over one cycle of 0.11 s at 4 us on one core; the requirement for the complete analysis
//! is 50 ms.

use divan::Bencher;
use nailnoise_acoustics::jets::{
    ExhaustNoise, ExhaustSettings, FlowHistory, Jet, Opening, Outlet, exhaust_noise, screech_track,
};
use nailnoise_acoustics::{AcousticsError, Air};

fn main() {
    divan::main();
}

const HOLES: Opening = Opening {
    count: 5,
    diameter: 5.97e-3,
    discharge_coefficient: 0.82,
    pitch: Some(20e-3),
};

/// An exhaust that opens after 43 ms and empties its plenum from 3.7 bar.
fn cycle() -> FlowHistory {
    let (air, dt, samples) = (Air::default(), 4e-6, 27_500);
    let pressure: Vec<f64> = (0..samples)
        .map(|i| i as f64 * dt - 0.043)
        .map(|t| air.pressure + if t > 0.0 { 2.7e5 * (-t / 8e-3).exp() } else { 0.0 })
        .collect();
    let flow = |&p: &f64| Jet::expand(p, 290.0, &air).map_or(0.0, |jet| jet.mass_flow(HOLES.effective_area()));
    FlowHistory {
        sample_interval: dt,
        mass_flow: pressure.iter().map(flow).collect(),
        temperature: vec![290.0; samples],
        pressure,
        back_pressure: None,
    }
}

/// The trigger vent: a chamber that empties from 9 bar within milliseconds.
const VENT: Opening = Opening {
    count: 1,
    diameter: 2.42e-3,
    discharge_coefficient: 1.0,
    pitch: None,
};

fn vent() -> FlowHistory {
    let air = Air::default();
    let mut flow = cycle();
    for (i, (p, m)) in flow.pressure.iter_mut().zip(&mut flow.mass_flow).enumerate() {
        *p = air.pressure + 8e5 * (-(i as f64) * 4e-6 / 2e-3).exp();
        *m = Jet::expand(*p, 290.0, &air).map_or(0.0, |jet| jet.mass_flow(VENT.effective_area()));
    }
    flow
}

fn spectrum(flow: &FlowHistory) -> Result<ExhaustNoise, AcousticsError> {
    exhaust_noise("exhaust", flow, &HOLES, &Air::default(), &ExhaustSettings::default())
}

/// Holes and vent: spectra of all components, levels between 20 edges, power over time, screech track.
#[divan::bench]
fn whole(bencher: Bencher) {
    let (holes, vent, air) = (cycle(), vent(), Air::default());
    let edges: Vec<f64> = (0..20).map(|i| 5.5e-3 * f64::from(i)).collect();
    let over_time = |noise: &ExhaustNoise| noise.history.analyse(&edges, [50.0, 10_000.0]);
    bencher.bench_local(|| {
        let screech = screech_track(&holes, &HOLES, &air);
        let holes = spectrum(&holes)?;
        let vent = exhaust_noise("vent", &vent, &VENT, &air, &ExhaustSettings::default())?;
        Ok::<_, AcousticsError>((over_time(&holes), over_time(&vent), screech))
    });
}

#[divan::bench]
fn spectra(bencher: Bencher) {
    let flow = cycle();
    bencher.bench_local(|| spectrum(&flow));
}

#[divan::bench]
fn microphone(bencher: Bencher) {
    let flow = cycle();
    let Ok(noise) = spectrum(&flow) else { return };
    let outlet = Outlet {
        position: [0.0, 0.0, 0.5],
        directions: vec![[1.0, 0.0, 0.0]],
    };
    bencher.bench_local(|| noise.at(&outlet, [1.0, 1.0, 1.0], None, &Air::default()));
}
