//! The sandbox of EN 12549; the top of the workpiece is flush with its sand.

use nailnoise_acoustics::radiation::flush_with_sand::{AbsorbingSand, MovingSand};
use nailnoise_dynamics as dynamics;
use nailnoise_fem::vibration::supports::{RectangularBase, Sand};

use super::floor;
use super::support::{Contact, FlushSand, SideContact, Support, law, underside};
use crate::design::rules::{at_most, below, incompressible, refuse};
use crate::design::{Carrier, Conflict, SandboxPlane, Values};
use crate::drawing::{Annotation, Material, Part, Side, View, rectangle};
use crate::error::Error;
use crate::measurement::manifest::Setup;
use crate::stages::bodies::{AddedSand, SideSand};
use crate::stages::radiation::OpenFaces;

/// A workpiece in a sandbox.
pub(super) struct InSandbox<'a>(pub(super) &'a Values);

impl InSandbox<'_> {
    /// The sand as an elastic half-space.
    fn half_space(&self) -> Result<Sand, Error> {
        let sand = &self.0.support.sand;
        Ok(Sand::new(sand.shear_modulus, sand.density, sand.poisson_ratio)?)
    }

    /// The workpiece's underside as a foundation.
    fn base(&self) -> Result<RectangularBase, Error> {
        let block = &self.0.workpiece;
        Ok(RectangularBase::new(block.length, block.width)?)
    }

    /// Conflict unless the microphones at mid-height are above the sand: their height above the floor is half the sum
    /// of 1 m and the height of the tool's centre.
    fn microphones_above_sand(&self) -> Result<(), Conflict> {
        let (sand, body) = (&self.0.support.sand, &self.0.body);
        let centre = 0.5 * (body.nose_height + body.barrel_height + body.cap_height);
        let (depth, highest) = (sand.box_depth, 1.0 + centre);
        let in_sand = sand.measurement_plane == SandboxPlane::Floor && depth >= highest;
        refuse(in_sand, Conflict::MicrophonesInSand { depth, highest })
    }
}

impl Support for InSandbox<'_> {
    fn check(&self) -> Result<(), Conflict> {
        let (block, sand) = (&self.0.workpiece, &self.0.support.sand);
        let (length, width) = (("workpiece.length", block.length), ("workpiece.width", block.width));
        let thickness = ("workpiece.thickness", block.thickness);
        let in_sand = "the block lies in the sand";
        at_most(length, ("support.sand.box_length", sand.box_length), in_sand)?;
        at_most(width, ("support.sand.box_width", sand.box_width), in_sand)?;
        below(thickness, ("support.sand.box_depth", sand.box_depth), in_sand)?;
        incompressible("support.sand.poisson_ratio", sand.poisson_ratio)?;
        self.microphones_above_sand()
    }

    /// The vertical foundation stiffness K_z and the radiation dashpot rho V_La of the workpiece's base.
    fn lumped(&self) -> Result<dynamics::Support, Error> {
        let (sand, base) = (self.half_space()?, self.base()?);
        Ok(dynamics::Support {
            stiffness: base.stiffness(&sand).z,
            damping: dynamics::SupportDamping::Coefficient(sand.normal_dashpot() * base.area()),
        })
    }

    fn contacts(&self) -> Result<Vec<Contact>, Error> {
        let (sand, base) = (self.half_space()?, self.base()?);
        Ok(vec![Contact {
            cells: underside(self.0),
            stiffness: base.normal_bedding(&sand),
            damping: sand.normal_dashpot(),
            law: law(self.0.support.sand.bonded),
        }])
    }

    fn sides(&self) -> Result<Option<SideContact>, Error> {
        let (block, share) = (&self.0.workpiece, self.0.support.sand.side_contact);
        if share == 0.0 {
            return Ok(None);
        }
        let cells = SideSand {
            block: [block.length, block.width, block.thickness],
        };
        let springs = cells.supports(&self.base()?, &self.half_space()?, share);
        Ok(Some(SideContact { cells, springs }))
    }

    /// Its mass is a fraction of rho r_0 A.
    fn added_sand(&self) -> Result<Option<AddedSand>, Error> {
        let (block, sand, base) = (&self.0.workpiece, &self.0.support.sand, self.base()?);
        Ok(Some(AddedSand {
            mass: sand.added_mass * sand.density * base.equivalent_radius() * base.area(),
            base: [block.length, block.width],
        }))
    }

    /// The sand's surface.
    fn reflecting_plane(&self) -> f64 {
        self.0.workpiece.thickness
    }

    fn measurement_plane(&self) -> f64 {
        let sand = &self.0.support.sand;
        match sand.measurement_plane {
            SandboxPlane::Sand => self.reflecting_plane(),
            SandboxPlane::Floor => self.reflecting_plane() - sand.box_depth,
        }
    }

    fn open_faces(&self) -> OpenFaces {
        OpenFaces::FlushTop
    }

    fn flush_sand(&self) -> Result<Option<FlushSand>, Error> {
        let sand = &self.0.support.sand;
        Ok(Some(FlushSand {
            absorbing: AbsorbingSand {
                resistivity: sand.flow_resistivity,
                share: sand.absorption_share,
            },
            moving: self.moving_sand()?.filter(|_| sand.moving_surface),
        }))
    }

    fn moving_sand(&self) -> Result<Option<MovingSand>, Error> {
        let (block, sand) = (&self.0.workpiece, &self.0.support.sand);
        let around = |length: f64| [-0.5 * length, 0.5 * length];
        Ok(Some(MovingSand {
            footprint: [around(block.length), around(block.width)],
            sand: [around(sand.box_length), around(sand.box_width)],
            shear_speed: self.half_space()?.shear_speed(),
            poisson_ratio: sand.poisson_ratio,
            loss_factor: sand.loss_factor,
            to_hz: sand.moving_surface_max_frequency,
        }))
    }

    fn carriers(&self) -> &'static [Carrier] {
        &[Carrier::Sand]
    }

    fn test_setup(&self) -> Option<Setup> {
        Some(Setup::Sandbox)
    }

    fn name(&self) -> String {
        "sandbox of EN 12549".to_owned()
    }

    fn in_words(&self) -> String {
        "workpiece in sand".to_owned()
    }

    fn draw(&self, view: &mut View) {
        let sand = &self.0.support.sand;
        let top = self.0.workpiece.thickness;
        let half = 0.5 * sand.box_length;
        let bottom = top - sand.box_depth;
        floor::draw(view, [-half - 0.06, half + 0.06], bottom);
        view.parts.push(Part::new(
            "sand, flush with the top of the workpiece",
            Material::Sand,
            vec![rectangle([-half, half], [bottom, top])],
        ));
        let (depth, width) = ("support.sand.box_depth", "support.sand.box_width");
        view.annotations.extend([
            Annotation::across(
                "support.sand.box_length",
                Side::Right,
                [-half, half],
                bottom - 0.06,
                [bottom; 2],
            ),
            Annotation::upright(depth, Side::Left, [bottom, top], -half - 0.03, [-half; 2]),
            Annotation::dot(width, Side::Right, [0.7 * half, 0.5 * bottom]),
        ]);
    }
}
