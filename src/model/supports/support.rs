//! What a support of the workpiece answers for, and the parts of its answers.

use nailnoise_acoustics::bem::SolidBox;
use nailnoise_acoustics::radiation::flush::{AbsorbingSand, MovingSand};
use nailnoise_dynamics as dynamics;
use nailnoise_fem::Material;
use nailnoise_fem::vibration::supports::contact_dashpot;
use nailnoise_fem::vibration::{Support as Spring, SupportLaw};

use crate::design::rules::refuse;
use crate::design::{Carrier, Conflict, Sprung, Values};
use crate::drawing::View;
use crate::error::Error;
use crate::measurement::manifest::Setup;
use crate::stages::bodies::{AddedSand, BodyKind, ContactCells, MeshSource, SideSand};
use crate::stages::radiation::OpenFaces;

/// Farthest floor below a workpiece that is part of its boundary elements \[m\]. The floor at the height h changes the
/// power by about sin(2 k h)/(2 k h), a ripple every c/2h. At twice the height it requires twice as many frequencies,
/// and it cancels in every wider band. The reflection of a farther floor at a microphone is the sound at the
/// microphone's image.
pub(crate) const FARTHEST_FLOOR: f64 = 1.0;

/// The support of a design's workpiece. Heights are above the workpiece's underside \[m\].
pub(crate) trait Support {
    /// The first conflict between its quantities, and with those of workpiece and tool.
    fn check(&self) -> Result<(), Conflict> {
        Ok(())
    }

    /// Its spring and dashpot under the lumped workpiece of the nailing cycle.
    ///
    /// # Errors
    /// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
    fn lumped(&self) -> Result<dynamics::Support, Error>;

    /// Its finite-element bodies.
    fn bodies(&self) -> &'static [BodyKind] {
        &[]
    }

    /// Mesh and materials of its body under the workpiece.
    ///
    /// # Errors
    /// Those of materials.
    fn table(&self) -> Result<Option<Table>, Error> {
        Ok(None)
    }

    /// The face group of the workpiece whose nodes it fixes.
    fn fixed(&self) -> Option<&'static str> {
        None
    }

    /// Contacts of the workpiece's underside with it.
    ///
    /// # Errors
    /// As [`lumped`](Self::lumped).
    fn contacts(&self) -> Result<Vec<Contact>, Error> {
        Ok(Vec::new())
    }

    /// Its contact with the workpiece's sides.
    ///
    /// # Errors
    /// As [`lumped`](Self::lumped).
    fn sides(&self) -> Result<Option<SideContact>, Error> {
        Ok(None)
    }

    /// Sand that moves with the workpiece's base.
    ///
    /// # Errors
    /// Those of the base's dimensions.
    fn added_sand(&self) -> Result<Option<AddedSand>, Error> {
        Ok(None)
    }

    /// Height of the plane that reflects sound \[m\].
    fn reflecting_plane(&self) -> f64;

    /// Height of the plane on which the measurement surface of ISO 3744 stands \[m\].
    fn measurement_plane(&self) -> f64 {
        self.reflecting_plane()
    }

    /// Height of the rigid floor if it is part of the workpiece's boundary elements \[m\].
    fn floor(&self) -> Option<f64> {
        Some(self.reflecting_plane())
    }

    /// Height of the middle of the workpiece's sound field, from which distances to microphones are measured \[m\].
    fn sound_centre(&self) -> f64 {
        0.0
    }

    /// The faces of the workpiece that radiate.
    fn open_faces(&self) -> OpenFaces {
        OpenFaces::AboveUnderside
    }

    /// The sand with which the workpiece's top is flush; none without [`OpenFaces::FlushTop`].
    ///
    /// # Errors
    /// As [`lumped`](Self::lumped).
    fn flush_sand(&self) -> Result<Option<FlushSand>, Error> {
        Ok(None)
    }

    /// The motion of the sand that sensors can lie on; none without [`Carrier::Sand`].
    ///
    /// # Errors
    /// As [`lumped`](Self::lumped).
    fn moving_sand(&self) -> Result<Option<MovingSand>, Error> {
        Ok(None)
    }

    /// Boxes that radiate together with the workpiece: parts 1, the top, and 2, the legs.
    fn boxes(&self) -> Vec<SolidBox> {
        Vec::new()
    }

    /// About the area of its radiating surface, for the cost of boundary elements \[m2\].
    fn radiating_area(&self) -> f64 {
        0.0
    }

    /// What sensors can be fixed to, in addition to workpiece and tool.
    fn carriers(&self) -> &'static [Carrier] {
        &[]
    }

    /// The setup of a wrapping test of EN 12549 that it is; none for a support that the standard does not have.
    fn test_setup(&self) -> Option<Setup> {
        None
    }

    /// Its name in the head of the report.
    fn name(&self) -> String;

    /// The workpiece on it, in the words of a note.
    fn in_words(&self) -> String;

    /// Adds its parts and dimensions to a view along the workpiece's width.
    fn draw(&self, view: &mut View);
}

/// A body under the workpiece as finite elements.
pub(crate) struct Table {
    /// Materials by the name of the part; the first also for a mesh of only one part.
    pub(crate) materials: Vec<(&'static str, Material)>,
    /// The mesh of its dimensions.
    pub(crate) built_in: MeshSource,
    /// Loss factor of its modes \[-\].
    pub(crate) loss_factor: f64,
    /// Face group whose nodes are fixed.
    pub(crate) fixed: Option<&'static str>,
}

/// Contact of the workpiece's underside with its support.
pub(crate) struct Contact {
    /// The cells.
    pub(crate) cells: ContactCells,
    /// Stiffness per area \[N/m3\].
    pub(crate) stiffness: f64,
    /// Damping per area \[N s/m3\].
    pub(crate) damping: f64,
    /// Whether it can open.
    pub(crate) law: SupportLaw,
}

impl Contact {
    /// Contact of the whole underside by the keys of `support.contact`.
    pub(super) fn of_underside(values: &Values) -> Self {
        let contact = &values.support.contact;
        Self {
            cells: underside(values),
            stiffness: contact.stiffness_per_area,
            damping: contact_dashpot(contact.stiffness_per_area, contact.loss_ratio, contact.loss_frequency),
            law: law(contact.bonded),
        }
    }

    /// Springs and dashpots of its cells.
    pub(crate) fn springs(&self) -> Vec<Spring> {
        let spring = |&area: &f64| Spring {
            stiffness: self.stiffness * area,
            damping: self.damping * area,
            gap: 0.0,
            law: self.law,
        };
        self.cells.grid().areas.iter().map(spring).collect()
    }
}

/// Contact of a support with the sides of the workpiece.
pub(crate) struct SideContact {
    /// Its cells.
    pub(crate) cells: SideSand,
    /// Springs and dashpots of the cells.
    pub(crate) springs: Vec<Spring>,
}

/// Sand around a workpiece whose top is flush with it.
pub(crate) struct FlushSand {
    /// The sand as an absorber.
    pub(crate) absorbing: AbsorbingSand,
    /// The motion of its surface with the workpiece, if it radiates.
    pub(crate) moving: Option<MovingSand>,
}

/// Cells of the workpiece's whole underside.
pub(crate) fn underside(values: &Values) -> ContactCells {
    let (block, contact) = (&values.workpiece, &values.support.contact);
    ContactCells {
        centre: [0.0; 2],
        size: [block.length, block.width],
        cells: [contact.points_along, contact.points_across],
    }
}

/// Law of a contact that is bonded, or can open.
pub(super) fn law(bonded: bool) -> SupportLaw {
    if bonded {
        SupportLaw::Bonded
    } else {
        SupportLaw::Unilateral
    }
}

/// Conflict unless the springs of the user carry a body, which the key says rests on them alone.
pub(super) fn carried(values: &Values, body: Sprung, key: &'static str) -> Result<(), Conflict> {
    let [stiffness, _] = values.sprung(body);
    refuse(stiffness == 0.0, Conflict::NotCarried { body, key })
}
