//! Named surfaces of a user's own body, by their places.

use nailnoise_quantities::dimension::LENGTH;
use nailnoise_quantities::{any, choice, component, group, nonnegative};

use super::show::mm;

choice! {
    /// The body from a file whose surface it is.
    SurfaceOf {
        /// The block of wood.
        Workpiece = "workpiece",
        /// The worktable.
        Worktable = "worktable",
        /// The tool's housing.
        Tool = "tool",
    }
}

choice! {
    /// Surfaces on which forces, gas, contacts and lumped masses act.
    SurfaceName {
        /// Tip of the tool's nose, on the workpiece.
        NoseTip = "nose_tip",
        /// Inner side of the tool's cylinder.
        GasBore = "gas_bore",
        /// Where the bumper lies, around the rod at the cylinder's lower end.
        BumperSeat = "bumper_seat",
        /// Upper rim of the cylinder, on which the head valve closes.
        Seat = "seat",
        /// Ceiling under which the head valve moves.
        Cap = "cap",
        /// Outer side of the handle.
        Handle = "handle",
        /// Where the magazine is fixed.
        Magazine = "magazine",
        /// Walls of the supply's volume in the handle.
        Supply = "supply",
        /// Walls of the exhaust's volume in the cap.
        Plenum = "plenum",
        /// Outer side of the cap with the exhaust's outlets, which counts to the exhaust by the convention of wrapping.
        CapOutside = "cap_outside",
        /// Outer side of the cylinder, between supply and return volume.
        SleeveOutside = "sleeve_outside",
        /// Inner side of the barrel around the cylinder.
        BarrelInside = "barrel_inside",
        /// Upper side of workpiece or worktable.
        Top = "top",
        /// Underside of the workpiece.
        Bottom = "bottom",
        /// Undersides of the worktable's feet.
        Floor = "floor",
        /// Side of the workpiece towards -x.
        XMin = "x_min",
        /// Side of the workpiece towards +x.
        XMax = "x_max",
        /// Side of the workpiece towards -y.
        YMin = "y_min",
        /// Side of the workpiece towards +y.
        YMax = "y_max",
    }
}

group! {
    /// A surface of a body from a file (`body.mesh`, `workpiece.mesh`, `support.worktable.mesh`), by its place instead
    /// of its name in the file. The point lies on the face; several members may give parts of one surface. A face ends
    /// where the skin turns by more than 30 degrees. It has no effect on the built-in bodies. The origin is that of the
    /// body: the nose's tip of the tool, z up on the axis of the cylinder, x along the handle; else the centre of the
    /// workpiece's underside.
    NamedSurface {
        /// The body.
        body: SurfaceOf = SurfaceOf::KIND, "";
        /// The surface that this place is, or is a part of.
        surface: SurfaceName = SurfaceName::KIND, "";
        /// Position along x of a point on the face.
        x: f64 = any(LENGTH), "x";
        /// Position along y of that point.
        y: f64 = any(LENGTH), "y";
        /// Height of that point.
        z: f64 = any(LENGTH), "z";
        /// Distance from the point up to which the face belongs to the surface; 0 for the whole face.
        radius: f64 = nonnegative(LENGTH), "a";
        /// Component along x of the direction out of the body at that point, whose length does not matter; with three
        /// zeros the nearest face is taken, whichever way it looks.
        along_x: f64 = component(), "";
        /// Component along y of that direction.
        along_y: f64 = component(), "";
        /// Component along z of that direction.
        along_z: f64 = component(), "";
    }
}

/// The fault in the place of a surface, with the numbers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceProblem {
    /// The surface belongs to another body.
    #[error("names `{}`, which the {} does not have", surface.as_str(), body.as_str())]
    OfOtherBody {
        /// The surface.
        surface: SurfaceName,
        /// The body.
        body: SurfaceOf,
    },
    /// It is not on its body.
    #[error("at ({}, {}, {}) is {} outside the {}", mm(point[0]), mm(point[1]), mm(point[2]), mm(*distance),
        body.as_str())]
    Outside {
        /// The body.
        body: SurfaceOf,
        /// Where it is \[m\].
        point: [f64; 3],
        /// How far from the nearest face that looks its way \[m\].
        distance: f64,
    },
    /// No face of the body looks its way.
    #[error("has a direction in which no face of the {} looks", body.as_str())]
    NoFace {
        /// The body.
        body: SurfaceOf,
    },
}

impl SurfaceOf {
    /// Names of the surfaces of the body that a run reads.
    pub fn surfaces(self) -> &'static [SurfaceName] {
        use SurfaceName::*;
        match self {
            Self::Workpiece => &[Top, Bottom, XMin, XMax, YMin, YMax],
            Self::Worktable => &[Top, Floor],
            Self::Tool => &[
                NoseTip,
                GasBore,
                BumperSeat,
                Seat,
                Cap,
                Handle,
                Magazine,
                Supply,
                Plenum,
                CapOutside,
                SleeveOutside,
                BarrelInside,
            ],
        }
    }

    /// The same in words.
    pub(crate) fn known_surfaces(self) -> String {
        let known: Vec<&str> = self.surfaces().iter().map(|surface| surface.as_str()).collect();
        format!("surfaces of the {} are {}", self.as_str(), known.join(", "))
    }
}

impl SurfaceProblem {
    /// The keys of the surface that are at fault.
    pub(crate) fn keys(&self) -> &'static [&'static str] {
        match self {
            Self::OfOtherBody { .. } => &["surface", "body"],
            Self::Outside { .. } => &["x", "y", "z", "along_x", "along_y", "along_z", "body"],
            Self::NoFace { .. } => &["along_x", "along_y", "along_z"],
        }
    }

    /// The remedy.
    pub(crate) fn remedy(&self) -> String {
        match self {
            Self::OfOtherBody { body, .. } => body.known_surfaces(),
            Self::Outside { .. } | Self::NoFace { .. } => {
                "move x, y and z onto the face, with along_x, along_y and along_z out of the body there, or all three \
                 0; \
                 `nailnoise check DESIGN --body BODY` shows the centres of the surfaces that are known"
                    .to_owned()
            }
        }
    }
}
