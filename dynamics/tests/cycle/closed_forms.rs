//! Parts of a shot that have a closed form, and the order at which they are approached.

use nailnoise_dynamics::{
    Crossing, CycleRecord, Direction, Geometry, LogEntry, Method, Parameters, Settings, simulate,
};

use crate::common::n80cb;

fn run(p: &Parameters, method: Method, relative_tolerance: f64, end: f64) -> CycleRecord {
    let settings = Settings {
        method,
        relative_tolerance,
        sample_interval: 2e-5,
        end,
        ..Settings::default()
    };
    simulate(p, &settings).unwrap()
}

/// Exponent n of error = C x^n through the first and last of the points.
fn order(points: &[(f64, f64)]) -> f64 {
    let ((x0, e0), (x1, e1)) = (points[0], points[points.len() - 1]);
    (e1 / e0).ln() / (x1 / x0).ln()
}

/// The error is small and falls with the tolerance of a step as a method of order p makes it, tol^(p/(p+1)): order 3
/// for ESDIRK; 5 for BDF, whose changes of order bring it towards proportionality, and for the pair that replaces it
/// where the equations are not stiff.
fn follows_the_tolerance(limit: f64, error: impl Fn(Method, f64) -> f64) {
    let orders = [
        (Method::Switching, 5.0 / 6.0, 1.1),
        (Method::Bdf, 5.0 / 6.0, 1.0),
        (Method::Esdirk34, 0.75, 0.75),
    ];
    for (method, least, most) in orders {
        let points = [1e-5, 1e-6, 1e-7, 1e-8].map(|tolerance| (tolerance, error(method, tolerance)));
        let order = order(&points);
        assert!(
            least - 0.1 < order && order < most + 0.1,
            "{method:?}: order {order}, {points:?}"
        );
        assert!(points[2].1 < limit, "{method:?}: {points:?}");
    }
}

#[test]
fn a_vessel_blows_down_through_a_choked_hole() {
    // The volume above a valve that cannot move, without heat, through the trigger's channel:
    // m = m_0 (1 + (gamma - 1)/2 t m'_0/m_0)^(-2/(gamma - 1)), P = P_0 (m/m_0)^gamma, until P_cr P = P_a.
    let mut p = n80cb();
    p.head_valve.mass = 1e3;
    p.contacts.seat_stiffness = 1e12;
    p.chambers.above_valve = 1e-3;
    p.chambers.wall_heat_transfer = 0.0;
    p.trigger.vent_area = 2e-4;
    let geometry = Geometry::new(&p);
    let gamma = p.ambient.heat_capacity_ratio;
    let base: f64 = 2.0 / (gamma + 1.0);
    let critical = base.powf(gamma / (gamma - 1.0));
    let choked = (gamma / p.ambient.gas_constant * base.powf((gamma + 1.0) / (gamma - 1.0))).sqrt();
    let volume = p.chambers.above_valve + geometry.valve_control_area * p.head_valve.lift;
    let (p0, t0) = (p.supply.pressure, p.ambient.temperature);
    let mass = p0 * volume / (p.ambient.gas_constant * t0);
    let flow = p.trigger.vent_area * geometry.attenuation_vent * choked * p0 / t0.sqrt();
    let pressure = |t: f64| p0 * (1.0 + 0.5 * (gamma - 1.0) * t * flow / mass).powf(-2.0 * gamma / (gamma - 1.0));
    follows_the_tolerance(5e-6, |method, tolerance| {
        let r = run(&p, method, tolerance, 0.03);
        let worst = (0..r.len())
            .map(|i| (r.time(i) - geometry.channel_delay, r.history("above_valve.pressure")[i]))
            .filter(|(t, found)| *t > 0.0 && critical * found > p.ambient.pressure)
            .map(|(t, found)| (found / pressure(t) - 1.0).abs())
            .fold(0.0, f64::max);
        assert!(
            critical * r.history("above_valve.pressure")[r.len() - 1] < p.ambient.pressure,
            "not blown down"
        );
        worst
    });
}

#[test]
fn the_piston_compresses_a_closed_volume_along_the_adiabat() {
    // Neither holes, leak nor heat below the piston: P V^gamma is constant over the whole shot.
    let mut p = n80cb();
    p.chambers.wall_heat_transfer = 0.0;
    // Holes a thirtieth of a micrometre wide: nothing leaves.
    p.chambers.return_hole_area = 1e-15;
    p.chambers.leak_area = 0.0;
    p.chambers.below_piston = 4e-4;
    let area = Geometry::new(&p).ring_area;
    let gamma = p.ambient.heat_capacity_ratio;
    follows_the_tolerance(1e-7, |method, tolerance| {
        let r = run(&p, method, tolerance, 0.03);
        let invariant = |i: usize| {
            let volume = p.chambers.below_piston + area * (p.piston.stroke - r.history("piston.travel")[i]);
            r.history("below_piston.pressure")[i] * volume.powf(gamma)
        };
        let compressed = r.history("below_piston.pressure").iter().copied().fold(0.0, f64::max);
        assert!(compressed > 1.5 * p.ambient.pressure, "{compressed} Pa");
        (0..r.len())
            .map(|i| (invariant(i) / invariant(0) - 1.0).abs())
            .fold(0.0, f64::max)
    });
}

#[test]
fn a_damped_contact_bounces_with_the_closed_form_of_its_restitution() {
    // A contact k u + c u' that lets go at zero force, both bodies free (Schwager and Poeschel 2007):
    // t = (pi - atan(2 zeta sqrt(1 - zeta^2)/(1 - 2 zeta^2)))/omega_d, e = exp(-zeta omega_n t).
    // Gas and spring change it in the ratio of their force to the contact's, so that the distance falls as k^(-1/2).
    // Friction would work against them and is left out.
    let restitution = |stiffness: f64| {
        let mut p = n80cb();
        p.head_valve.friction.static_force = 0.0;
        p.head_valve.friction.sliding_force = 0.0;
        p.contacts.cap_stiffness = stiffness;
        let r = run(&p, Method::Bdf, 1e-8, 0.018);
        let at = |direction: Direction| -> LogEntry {
            let is = |e: &&LogEntry| e.crossing == Crossing::CapContact && e.direction == direction;
            *r.figures.log.iter().find(is).unwrap()
        };
        let (hit, left) = (at(Direction::Rising), at(Direction::Falling));
        let (valve, tool) = (p.head_valve.mass, p.tool.mass);
        let zeta = p.contacts.valve_damping_ratio * ((valve + tool) / tool).sqrt();
        let omega = (stiffness * (valve + tool) / (valve * tool)).sqrt();
        let root = (1.0 - zeta * zeta).sqrt();
        let phase = std::f64::consts::PI - (2.0 * zeta * root / (1.0 - 2.0 * zeta * zeta)).atan();
        let (duration, e) = (phase / (omega * root), (-zeta * phase / root).exp());
        (
            ((left.time - hit.time) / duration - 1.0).abs(),
            (-left.state.valve_velocity / hit.state.valve_velocity / e - 1.0).abs(),
        )
    };
    let stiffnesses = [4e9, 1.6e10, 6.4e10];
    let found = stiffnesses.map(restitution);
    for (name, error) in [("duration", found.map(|f| f.0)), ("restitution", found.map(|f| f.1))] {
        let points: Vec<(f64, f64)> = stiffnesses.into_iter().zip(error).collect();
        let order = order(&points);
        assert!((order + 0.5).abs() < 0.1, "{name}: order {order}, {points:?}");
        assert!(error[2] < 2e-3, "{name}: {points:?}");
    }
}
