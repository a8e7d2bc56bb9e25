//! Compilation of passages and faces.

use super::compiler::Compiler;
use super::gas::{AreaPlan, CoefficientPlan, FacePlan, FlowLedger, PassagePlan, RestrictionPlan, TravelPlan};
use super::mechanics::Pair;
use crate::network::assembly::{
    Assembly, Base, Coefficient, Cone, Force, ForceLaw, Opens, Passage, PassageLaw, Polytropic, Push, Restriction,
    Space,
};
use crate::network::error::RunError;
use crate::network::gas::Air;

/// Restrictions of a passage, and the motions that open them.
struct Restrictions {
    list: Vec<RestrictionPlan>,
    travels: [Option<Pair>; 2],
}

impl Compiler<'_> {
    fn restrictions(&mut self, passage: &Passage) -> Result<Restrictions, RunError> {
        let count = passage.restrictions.len();
        let refuse = |reason| RunError::Passage {
            name: passage.name.clone(),
            reason,
        };
        if count == 0 || count > 3 {
            return Err(refuse("has no restriction, or more than three in series"));
        }
        let mut found = Restrictions {
            list: Vec::with_capacity(count),
            travels: [None; 2],
        };
        let assembly = self.assembly;
        for restriction in &passage.restrictions {
            let mut travel = |pair: Pair, push: Push, at: f64| {
                let input = match found.travels {
                    [None, _] => 0,
                    [Some(first), _] if first == pair => 0,
                    [Some(_), None] => 1,
                    [_, Some(second)] if second == pair => 1,
                    _ => return Err(refuse("is opened by more than two motions")),
                };
                found.travels[input] = Some(pair);
                Ok(TravelPlan {
                    pair,
                    sign: push.sign(),
                    at,
                    input,
                    switch: self.switch(),
                })
            };
            let constant = match (&restriction.coefficient, restriction.pipe) {
                (Coefficient::RatioPolynomial { .. }, _) if count > 1 => {
                    return Err(refuse("has a coefficient over the pressure ratio in a series"));
                }
                (Coefficient::RatioPolynomial { .. }, Some(_)) => {
                    return Err(refuse("has a coefficient over the pressure ratio and a pipe"));
                }
                _ => restriction.discharge_coefficient(),
            };
            let area = match restriction.opens {
                Opens::Constant { area } => AreaPlan::Constant(area * constant.unwrap_or(1.0)),
                Opens::Ramp { area, time } if time > 0.0 => AreaPlan::Ramp {
                    area: area * constant.unwrap_or(1.0),
                    time,
                },
                Opens::Ramp { area, .. } => AreaPlan::Constant(area * constant.unwrap_or(1.0)),
                Opens::Seat {
                    body,
                    against,
                    push,
                    at,
                    diameter,
                    angle,
                    cone,
                } => {
                    let (sine, cosine) = angle.sin_cos();
                    let sign = match cone {
                        Cone::Narrows => -1.0,
                        Cone::Widens => 1.0,
                    };
                    AreaPlan::Seat {
                        travel: travel(pair_of(assembly, body, against), push, at)?,
                        diameter,
                        sine,
                        slope: sign * sine * cosine,
                    }
                }
                Opens::Holes {
                    body,
                    against,
                    push,
                    at,
                    area,
                    diameter,
                } => AreaPlan::Holes {
                    travel: travel(pair_of(assembly, body, against), push, at)?,
                    area,
                    diameter,
                },
            };
            let moving = matches!(area, AreaPlan::Seat { .. } | AreaPlan::Holes { .. });
            let coefficient = match &restriction.coefficient {
                Coefficient::Constant(_) if moving => CoefficientPlan::Constant(constant.unwrap_or(1.0)),
                Coefficient::Constant(_) => CoefficientPlan::Constant(1.0),
                Coefficient::RatioPolynomial { coefficients, from, to } => CoefficientPlan::Ratio {
                    polynomial: coefficients.clone(),
                    from: *from,
                    to: *to,
                },
            };
            found.list.push(RestrictionPlan { area, coefficient });
        }
        Ok(found)
    }
}

fn pair_of(assembly: &Assembly, on: usize, against: Base) -> Pair {
    let against = match against {
        Base::Ground => assembly.bodies.len(),
        Base::Body(i) => i,
    };
    Pair { on, against }
}

pub(super) fn passages(c: &mut Compiler<'_>, airs: &mut Vec<Air>, full: bool) -> Result<Vec<PassagePlan>, RunError> {
    let assembly = c.assembly;
    assembly
        .passages
        .iter()
        .enumerate()
        .map(|(index, passage)| {
            let boundary = matches!(
                (passage.from, passage.to),
                (Space::Volume(_), Space::Reservoir(_)) | (Space::Reservoir(_), Space::Volume(_))
            );
            let air = match passage.law {
                PassageLaw::Nozzle => 0,
                PassageLaw::Iso6358 { critical_ratio } => {
                    airs.push(airs[0].elliptic(critical_ratio));
                    airs.len() - 1
                }
            };
            let restrictions = c.restrictions(passage)?;
            let jet = |force: &Force| matches!(force.law, ForceLaw::Jet { passage, .. } if passage == index);
            let shut = |r: &RestrictionPlan| matches!(r.area, AreaPlan::Constant(area) if area <= 0.0);
            let gate = passage.gate.as_ref().map(|_| c.switch());
            let also = passage.gate.as_ref().and_then(|gate| gate.also.as_ref());
            let condition = also.map(|_| c.switch());
            let moving = restrictions.list.iter().filter_map(RestrictionPlan::travel);
            let switches = moving.map(|way| way.switch).chain(gate).chain(condition);
            let delayed = passage
                .gate
                .as_ref()
                .filter(|gate| gate.delays_flow && gate.delay > 0.0);
            let per_mass = |law: Polytropic, exponent: Option<f64>| {
                let rt = assembly.gas_constant * law.temperature;
                exponent.unwrap_or(law.inflow) * rt / (assembly.heat_capacity_ratio - 1.0)
            };
            Ok(PassagePlan {
                switches: switches.collect(),
                shut: restrictions.list.iter().any(shut),
                follows: passage.gate.as_ref().map(|gate| (gate.trigger, gate.inverted)),
                delay: delayed.map(|gate| gate.delay),
                undelayed: undelayed(passage)?,
                weights: assembly.polytropic.map(|law| {
                    let [first, second] = passage.exponents.map(|exponent| per_mass(law, exponent));
                    [first, second, per_mass(law, None)]
                }),
                from: c.gas(passage.from),
                to: c.gas(passage.to),
                restrictions: restrictions.list,
                travels: restrictions.travels,
                air,
                one_way: passage.one_way,
                gate,
                condition,
                ledger: (boundary || full).then(|| FlowLedger {
                    mass: c.integral(format!("mass.{}", passage.name), "kg"),
                    enthalpy: c.integral(format!("enthalpy.{}", passage.name), "J"),
                }),
                jet: assembly.forces.iter().any(jet),
            })
        })
        .collect()
}

/// Factor of the flow that leaves a passage without delay and discharge coefficient; none if it leaves as it arrives.
fn undelayed(passage: &Passage) -> Result<Option<f64>, RunError> {
    if !passage.gate.as_ref().is_some_and(|gate| gate.leaves_undelayed) {
        return Ok(None);
    }
    match &passage.restrictions[..] {
        [
            Restriction {
                coefficient: Coefficient::Constant(c),
                pipe: None,
                ..
            },
        ] if *c > 0.0 => Ok(Some(1.0 / c)),
        _ => Err(RunError::Passage {
            name: passage.name.clone(),
            reason: "has leaves = \"undelayed\", which needs a single restriction with a constant coefficient",
        }),
    }
}

pub(super) fn faces(c: &mut Compiler<'_>) -> Vec<FacePlan> {
    let assembly = c.assembly;
    let mut work = vec![None; assembly.bodies.len()];
    assembly
        .faces
        .iter()
        .map(|face| {
            let volume = match face.gas {
                Space::Volume(i) => Some(i),
                Space::Reservoir(_) => None,
            };
            let place = &mut work[face.body];
            if volume.is_some() && face.sweeps && place.is_none() {
                *place = Some(c.integral(format!("work.{}", assembly.bodies[face.body].name), "J"));
            }
            let own = volume.filter(|_| !face.sweeps);
            let work = match own {
                Some(_) => Some(c.integral(format!("unswept.{}", face.name), "J")),
                None => volume.and(*place),
            };
            FacePlan {
                gas: c.gas(face.gas),
                pressed: volume,
                volume: volume.filter(|_| face.sweeps),
                pair: c.pair(face.body, face.against),
                area: face.push.sign() * face.area,
                zero: face.zero,
                perimeter: face.push.sign() * face.perimeter,
                work,
            }
        })
        .collect()
}
