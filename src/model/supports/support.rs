//! The interface of a support of the workpiece, and the types it returns.

use nailnoise_acoustics::bem::SolidBox;
use nailnoise_acoustics::radiation::flush_with_sand::{AbsorbingSand, MovingSand};
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

/// Maximum distance below the workpiece at which a floor is included in its boundary elements \[m\]. The floor at the
/// distance h changes the power by about sin(2 k h)/(2 k h), a ripple with period c/2h. At twice the distance, it
/// requires twice as many frequencies, and it averages out in every wider band. The reflection from a more distant
/// floor at a microphone is the sound at the microphone's image.
pub(crate) const FARTHEST_FLOOR: f64 = 1.0;

/// The support of a design's workpiece. Heights are above the workpiece's underside \[m\].
pub(crate) trait Support {
    /// The first conflict between its quantities, or between these and those of workpiece and tool.
    fn check(&self) -> Result<(), Conflict> {
        Ok(())
    }

    /// Its spring and dashpot for the lumped workpiece of the nailing cycle.
    ///
    /// # Errors
    /// [`Error::Sand`] when the sand's constants are outside the range of the foundation's formulas.
    fn lumped(&self) -> Result<dynamics::Support, Error>;

    /// Its finite-element bodies.
    fn bodies(&self) -> &'static [BodyKind] {
        &[]
    }

    /// Mesh and materials of its body below the workpiece.
    ///
    /// # Errors
    /// The errors of the materials.
    fn table(&self) -> Result<Option<Table>, Error> {
        Ok(None)
    }

    /// The face group of the workpiece whose nodes are fixed.
    fn fixed(&self) -> Option<&'static str> {
        None
    }

    /// Contacts of the workpiece's underside with it.
    ///
    /// # Errors
    /// Same as [`lumped`](Self::lumped).
    fn contacts(&self) -> Result<Vec<Contact>, Error> {
        Ok(Vec::new())
    }

    /// Its contact with the workpiece's sides.
    ///
    /// # Errors
    /// Same as [`lumped`](Self::lumped).
    fn sides(&self) -> Result<Option<SideContact>, Error> {
        Ok(None)
    }

    /// Sand that moves with the base of the workpiece.
    ///
    /// # Errors
    /// The errors of the base's dimensions.
    fn added_sand(&self) -> Result<Option<AddedSand>, Error> {
        Ok(None)
    }

    /// Height of the reflecting plane \[m\].
    fn reflecting_plane(&self) -> f64;

    /// Height of the base plane of the measurement surface of ISO 3744 \[m\].
    fn measurement_plane(&self) -> f64 {
        self.reflecting_plane()
    }

    /// Height of the rigid floor \[m\], if it is included in the workpiece's boundary elements.
    fn floor(&self) -> Option<f64> {
        Some(self.reflecting_plane())
    }

    /// Height of the centre of the workpiece's sound field, from which distances to microphones are measured \[m\].
    fn sound_centre(&self) -> f64 {
        0.0
    }

    /// The faces of the workpiece that radiate.
    fn open_faces(&self) -> OpenFaces {
        OpenFaces::AboveUnderside
    }

    /// The sand with which the top of the workpiece is flush; `None` without [`OpenFaces::FlushTop`].
    ///
    /// # Errors
    /// Same as [`lumped`](Self::lumped).
    fn flush_sand(&self) -> Result<Option<FlushSand>, Error> {
        Ok(None)
    }

    /// The motion of the sand on which sensors can lie; `None` without [`Carrier::Sand`].
    ///
    /// # Errors
    /// Same as [`lumped`](Self::lumped).
    fn moving_sand(&self) -> Result<Option<MovingSand>, Error> {
        Ok(None)
    }

    /// Boxes that radiate together with the workpiece: part 1 is the top, part 2 the legs.
    fn boxes(&self) -> Vec<SolidBox> {
        Vec::new()
    }

    /// Approximate area of its radiating surface \[m2\], for the cost of boundary elements.
    fn radiating_area(&self) -> f64 {
        0.0
    }

    /// Carriers of sensors in addition to workpiece and tool.
    fn carriers(&self) -> &'static [Carrier] {
        &[]
    }

    /// The setup of a wrapping test in EN 12549 that corresponds to it; `None` for a support that the standard does not
    /// have.
    fn test_setup(&self) -> Option<Setup> {
        None
    }

    /// Its name in the head of the report.
    fn name(&self) -> String;

    /// The workpiece on this support, worded for a note.
    fn in_words(&self) -> String;

    /// Adds its parts and dimensions to a view along the workpiece's width.
    fn draw(&self, view: &mut View);
}

/// A body below the workpiece, as finite elements.
pub(crate) struct Table {
    /// Materials by the name of the part; the first is also used for a mesh with only one part.
    pub(crate) materials: Vec<(&'static str, Material)>,
    /// The mesh for its dimensions.
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
    /// Whether the contact can open.
    pub(crate) law: SupportLaw,
}

impl Contact {
    /// Contact of the complete underside, from the keys of `support.contact`.
    pub(super) fn of_underside(values: &Values) -> Self {
        let contact = &values.support.contact;
        Self {
            cells: underside(values),
            stiffness: contact.stiffness_per_area,
            damping: contact_dashpot(contact.stiffness_per_area, contact.loss_ratio, contact.loss_frequency),
            law: law(contact.bonded),
        }
    }

    /// Springs and dashpots of the cells.
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
    /// The motion of its surface with the workpiece, if that radiates.
    pub(crate) moving: Option<MovingSand>,
}

/// Cells of the complete underside of the workpiece.
pub(crate) fn underside(values: &Values) -> ContactCells {
    let (block, contact) = (&values.workpiece, &values.support.contact);
    ContactCells {
        centre: [0.0; 2],
        size: [block.length, block.width],
        cells: [contact.points_along, contact.points_across],
    }
}

/// Law of a contact that is bonded or can open.
pub(super) fn law(bonded: bool) -> SupportLaw {
    if bonded {
        SupportLaw::Bonded
    } else {
        SupportLaw::Unilateral
    }
}

/// Conflict unless the user's springs carry a body that, according to the key, rests only on them.
pub(super) fn carried(values: &Values, body: Sprung, key: &'static str) -> Result<(), Conflict> {
    let [stiffness, _] = values.sprung(body);
    refuse(stiffness == 0.0, Conflict::NotCarried { body, key })
}
