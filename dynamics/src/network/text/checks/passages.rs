//! Checks that passages to the atmosphere make noise, and that no supply empties through them.

use super::place::{error_of, stop_position};
use crate::network::assembly::{Assembly, Base, Family, Opens, Passage, Push, Space, Stop};
use crate::network::text::blocks::{is_atmosphere, reaches_atmosphere};
use crate::network::text::changes::Part;
use crate::network::text::fault::{AssemblyError, Fault, Travels};
use crate::network::text::resolver::Resolver;

/// Checks that every passage to the atmosphere has an opening or is marked as silent.
pub(super) fn are_heard(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    for (index, passage) in assembly.passages.iter().enumerate() {
        let heard = passage.silent || assembly.openings.iter().any(|opening| opening.passage == index);
        if !heard && reaches_atmosphere(resolver, passage) {
            let parts = Part::of_block(Family::Passage, &passage.name);
            return Err(error_of(resolver, "passage", &passage.name, Fault::Unheard, &parts));
        }
    }
    Ok(())
}

/// A seat of a passage, with the range of travel over which it is open.
struct SeatRange {
    passage: usize,
    body: usize,
    against: Base,
    open: [f64; 2],
}

/// Checks that no two seats of a body are open together such that a reservoir empties into the atmosphere through both.
pub(super) fn shut_in_turn(resolver: &Resolver<'_>, assembly: &Assembly) -> Result<(), AssemblyError> {
    let seats = seats(assembly);
    for (at, first) in seats.iter().enumerate() {
        for second in &seats[at + 1..] {
            if first.body != second.body || first.against != second.against || first.passage == second.passage {
                continue;
            }
            let from = first.open[0].max(second.open[0]);
            let to = first.open[1].min(second.open[1]);
            let Some(reservoir) = emptied(resolver, assembly, [first.passage, second.passage]) else {
                continue;
            };
            if from < to {
                let fault = Fault::OpenTogether {
                    other: assembly.passages[second.passage].name.clone(),
                    travels: Box::new(Travels {
                        body: assembly.bodies[first.body].name.clone(),
                        from,
                        to,
                    }),
                    reservoir: assembly.reservoirs[reservoir].name.clone(),
                };
                let name = &assembly.passages[first.passage].name;
                let parts = Part::of_passages(assembly, [first.passage, second.passage]);
                return Err(error_of(resolver, "passage", name, fault, &parts));
            }
        }
    }
    Ok(())
}

fn seats(assembly: &Assembly) -> Vec<SeatRange> {
    let mut seats = Vec::new();
    for (passage, own) in assembly.passages.iter().enumerate() {
        for restriction in &own.restrictions {
            let Opens::Seat {
                body,
                against,
                push,
                at,
                ..
            } = restriction.opens
            else {
                continue;
            };
            let limit = |side: Stop, none: f64| stop_position(assembly, body, against, side).unwrap_or(none);
            let (low, high) = (limit(Stop::Above, f64::NEG_INFINITY), limit(Stop::Below, f64::INFINITY));
            let open = match push {
                Push::Down => [at.max(low), high],
                Push::Up => [low, at.min(high)],
            };
            seats.push(SeatRange {
                passage,
                body,
                against,
                open,
            });
        }
    }
    seats
}

/// Whether a passage is open regardless of bodies and triggers.
fn is_always_open(passage: &Passage) -> bool {
    let constant = |opens: &Opens| matches!(opens, Opens::Constant { area } if *area > 0.0);
    passage.gate.is_none()
        && passage
            .restrictions
            .iter()
            .all(|restriction| constant(&restriction.opens))
}

/// The reservoir that is connected to the atmosphere through both passages but not without them.
fn emptied(resolver: &Resolver<'_>, assembly: &Assembly, both: [usize; 2]) -> Option<usize> {
    let reaches = |from: usize, seats: &[usize]| {
        let mut seen = vec![Space::Reservoir(from)];
        let mut next = 0;
        while let Some(space) = seen.get(next).copied() {
            next += 1;
            for (index, passage) in assembly.passages.iter().enumerate() {
                if !seats.contains(&index) && !is_always_open(passage) {
                    continue;
                }
                let other = match (passage.from == space, passage.to == space) {
                    (true, _) => passage.to,
                    (_, true) if !passage.one_way => passage.from,
                    _ => continue,
                };
                if is_atmosphere(resolver, other) {
                    return true;
                }
                if !seen.contains(&other) {
                    seen.push(other);
                }
            }
        }
        false
    };
    (0..assembly.reservoirs.len()).find(|index| {
        !is_atmosphere(resolver, Space::Reservoir(*index))
            && reaches(*index, &both)
            && !reaches(*index, &both[..1])
            && !reaches(*index, &both[1..])
    })
}
