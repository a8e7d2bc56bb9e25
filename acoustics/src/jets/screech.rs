use super::jet::Jet;
use super::opening::{FlowHistory, Opening};
use crate::air::Air;

/// Screech frequency of an underexpanded jet \[Hz\]; `None` below Mach 1. The source gives no level.
///
/// ```text
/// f D_j/U_j = 0.67 beta^-1 [1 + 0.7 M_j (1 + (g-1)/2 M_j^2)^-1/2 (T_a/T_0)^-1/2]^-1
/// ```
///
/// C. K. W. Tam, Annu. Rev. Fluid Mech. 27, 17 (1995). `diameter` is that of a single hole \[m\], `temperature` the
/// stagnation temperature T_0 \[K\].
pub fn screech_frequency(jet: &Jet, diameter: f64, temperature: f64, air: &Air) -> Option<f64> {
    let beta2 = jet.beta_squared();
    (beta2 > 0.0).then(|| {
        let expansion = (1.0 + 0.5 * (air.heat_ratio - 1.0) * jet.mach * jet.mach).sqrt();
        let convection = 1.0 + 0.7 * jet.mach / expansion / (air.temperature / temperature).sqrt();
        0.67 / (beta2.sqrt() * convection) * jet.velocity / (jet.diameter_ratio * diameter)
    })
}

/// Screech frequency \[Hz\] for each sample; `None` while the flow is subsonic or inward.
pub fn screech_track(history: &FlowHistory, opening: &Opening, air: &Air) -> Vec<Option<f64>> {
    let at = |(sample, ((&flow, &pressure), &temperature)): (usize, ((&f64, &f64), &f64))| {
        let air = history.surroundings(sample, air);
        let jet = Jet::expand(pressure, temperature, &air).filter(|_| flow > 0.0)?;
        screech_frequency(&jet, opening.diameter, temperature, &air)
    };
    history
        .mass_flow
        .iter()
        .zip(&history.pressure)
        .zip(&history.temperature)
        .enumerate()
        .map(at)
        .collect()
}
