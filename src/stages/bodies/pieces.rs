//! Detects pieces of a mesh that nothing joins or fixes.

use std::collections::BTreeMap;

use nailnoise_meshes::JOINT;
use nalgebra::Vector3;

use super::attachment::Meshed;
use crate::error::Error;
use crate::stages::bodies::BodyError;

impl Meshed {
    /// Checks that the pieces of the mesh are one body: joined by common nodes, ties or a joint, or fixed.
    ///
    /// # Errors
    /// [`BodyError::LoosePiece`] with the place of the smallest loose piece; [`BodyError::NotTied`] for pieces that a
    /// tie does not reach.
    pub fn check_pieces(&self, body: &'static str) -> Result<(), Error> {
        let mesh = &self.imported.mesh;
        let followers = self.attachments.followers(mesh, &self.constraints);
        let followers = followers.map_err(|cause| BodyError::NotTied { body, cause })?;
        let piece_of = mesh.piece_of_nodes();
        // Each piece that is tied to another takes its number.
        let mut whole: BTreeMap<usize, usize> = piece_of.iter().flatten().map(|&piece| (piece, piece)).collect();
        let mut join = |a: usize, b: usize| {
            let (keep, replace) = (whole[&a].min(whole[&b]), whole[&a].max(whole[&b]));
            whole
                .values_mut()
                .filter(|own| **own == replace)
                .for_each(|own| *own = keep);
        };
        for (node, followed) in followers {
            for other in followed {
                if let (Some(slave), Some(master)) = (piece_of[node], piece_of[other]) {
                    join(slave, master);
                }
            }
        }
        // The contact and the nail of a joint connect its two pieces.
        let touching = JOINT.map(|group| mesh.group_nodes(group).ok()?.first().and_then(|&node| piece_of[node]));
        if let [Some(lower), Some(upper)] = touching {
            join(lower, upper);
        }
        // A fixed piece moves with the ground.
        let held: Vec<usize> = self.constraints.iter().filter_map(|(node, _)| piece_of[node]).collect();
        held.windows(2).for_each(|pair| join(pair[0], pair[1]));
        let mut pieces: BTreeMap<usize, (f64, Vector3<f64>)> = BTreeMap::new();
        for (element, view) in mesh.elements().enumerate() {
            let Some(piece) = piece_of[view.nodes[0]] else { continue };
            let volume = mesh.volume_of(element)?;
            let centre: Vector3<f64> = view.nodes.iter().map(|&node| mesh.nodes[node].coords).sum();
            let own = pieces.entry(whole[&piece]).or_insert((0.0, Vector3::zeros()));
            own.0 += volume;
            own.1 += volume * centre / view.nodes.len() as f64;
        }
        let smallest = pieces.values().min_by(|a, b| a.0.total_cmp(&b.0));
        match smallest {
            Some((volume, moment)) if pieces.len() > 1 => Err(BodyError::LoosePiece {
                body,
                pieces: pieces.len(),
                volume: *volume,
                centre: (moment / *volume).into(),
            }
            .into()),
            _ => Ok(()),
        }
    }
}
