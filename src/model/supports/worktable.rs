//! A worktable on which the workpiece lies: a top on four legs, clamped at the floor or on the user's springs.

use nailnoise_acoustics::bem::SolidBox;
use nailnoise_dynamics as dynamics;
use nailnoise_fem::Material;
use nailnoise_meshes::Worktable;
use nalgebra::Matrix3;

use super::floor;
use super::support::{Contact, Support, Table, carried};
use crate::design::rules::{at_most, below, elastic, incompressible};
use crate::design::{Carrier, Conflict, Sprung, TableFoot, TableMaterial, Values, WorktablePreset};
use crate::drawing::{self, Annotation, Part, Side, View, rectangle};
use crate::error::Error;
use crate::measurement::manifest::Setup;
use crate::stages::bodies::{BodyKind, MeshSource};

/// A workpiece on a worktable.
pub(super) struct OnWorktable<'a>(pub(super) &'a Values);

impl OnWorktable<'_> {
    /// Wall thickness of the legs \[m\]; `None` for solid legs.
    fn tube_wall(&self) -> Option<f64> {
        let wall = self.0.support.worktable.leg_wall;
        (wall > 0.0).then_some(wall)
    }

    /// Materials of top and legs.
    fn materials(&self) -> Result<[Material; 2], Error> {
        let table = &self.0.support.worktable;
        match table.material {
            TableMaterial::Metal => {
                let metal = &table.metal;
                let material = Material::isotropic(metal.young_modulus, metal.poisson_ratio, metal.density)?;
                Ok([material.clone(), material])
            }
            TableMaterial::Wood => {
                // Legs: grain (axis 1) vertical, radial axis 2 along y, tangential axis 3 along x.
                let upright = Matrix3::new(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0);
                Ok([
                    Material::orthotropic(&table.top, &Matrix3::identity(), table.top_density)?,
                    Material::orthotropic(&table.legs, &upright, table.leg_density)?,
                ])
            }
        }
    }
}

impl Support for OnWorktable<'_> {
    fn check(&self) -> Result<(), Conflict> {
        let (block, table) = (&self.0.workpiece, &self.0.support.worktable);
        let (length, width) = (("workpiece.length", block.length), ("workpiece.width", block.width));
        let on_table = "the block lies on the table";
        at_most(length, ("support.worktable.length", table.length), on_table)?;
        at_most(width, ("support.worktable.width", table.width), on_table)?;
        let leg = ("support.worktable.leg_width", table.leg_width);
        let half_length = ("half of `support.worktable.length`", table.length / 2.0);
        let half_width = ("half of `support.worktable.width`", table.width / 2.0);
        below(leg, half_length, "the legs stand apart")?;
        below(leg, half_width, "the legs stand apart")?;
        let top = ("support.worktable.top_thickness", table.top_thickness);
        let height = ("support.worktable.height", table.height);
        below(top, height, "the top stands on legs")?;
        let half_leg = ("half of `support.worktable.leg_width`", table.leg_width / 2.0);
        below(
            ("support.worktable.leg_wall", table.leg_wall),
            half_leg,
            "a tube is hollow",
        )?;
        let poisson = "support.worktable.metal.poisson_ratio";
        incompressible(poisson, table.metal.poisson_ratio)?;
        elastic("support.worktable.top", &table.top)?;
        elastic("support.worktable.legs", &table.legs)?;
        match table.foot {
            TableFoot::Clamped => Ok(()),
            TableFoot::Springs => carried(self.0, Sprung::Worktable, "support.worktable.foot"),
        }
    }

    fn lumped(&self) -> Result<dynamics::Support, Error> {
        let table = &self.0.support.worktable;
        Ok(dynamics::Support {
            stiffness: table.stiffness,
            damping: dynamics::SupportDamping::Ratio(table.damping_ratio),
        })
    }

    fn bodies(&self) -> &'static [BodyKind] {
        &[BodyKind::Worktable]
    }

    fn table(&self) -> Result<Option<Table>, Error> {
        let (table, analysis, wall) = (&self.0.support.worktable, &self.0.analysis, self.tube_wall());
        let [top, legs] = self.materials()?;
        let of_leg = [analysis.worktable_leg_element, analysis.worktable_tube_element];
        let spec = Worktable {
            top: [table.length, table.width],
            thickness: table.top_thickness,
            leg: [table.leg_width; 2],
            height: table.height,
            element_size: analysis.worktable_element,
            leg_element_size: of_leg[usize::from(wall.is_some())],
            top_layers: analysis.worktable_top_layers as usize,
            origin: [-0.5 * table.length, -0.5 * table.width, -table.height],
        };
        Ok(Some(Table {
            materials: vec![("top", top), ("leg", legs.clone()), ("legs", legs)],
            built_in: MeshSource::Worktable(spec, wall),
            loss_factor: table.loss_factor,
            fixed: (table.foot == TableFoot::Clamped).then_some("floor"),
        }))
    }

    fn contacts(&self) -> Result<Vec<Contact>, Error> {
        Ok(vec![Contact::of_underside(self.0)])
    }

    fn reflecting_plane(&self) -> f64 {
        -self.0.support.worktable.height
    }

    fn boxes(&self) -> Vec<SolidBox> {
        let table = &self.0.support.worktable;
        let (x, y, under) = (0.5 * table.length, 0.5 * table.width, -table.top_thickness);
        let leg = table.leg_width;
        let top = SolidBox {
            low: [-x, -y, under],
            high: [x, y, 0.0],
            part: 1,
        };
        let legs = [[-x, -y], [x - leg, -y], [-x, y - leg], [x - leg, y - leg]];
        let leg = |[from_x, from_y]: [f64; 2]| SolidBox {
            low: [from_x, from_y, -table.height],
            high: [from_x + leg, from_y + leg, under],
            part: 2,
        };
        std::iter::once(top).chain(legs.map(leg)).collect()
    }

    fn radiating_area(&self) -> f64 {
        let table = &self.0.support.worktable;
        2.0 * table.length * table.width + 16.0 * table.leg_width * table.height
    }

    fn carriers(&self) -> &'static [Carrier] {
        &[Carrier::Worktable]
    }

    fn test_setup(&self) -> Option<Setup> {
        Some(Setup::Worktable)
    }

    fn name(&self) -> String {
        match self.0.support.worktable.preset {
            WorktablePreset::Own => "worktable".to_owned(),
            preset => format!("worktable {}", preset.as_str()),
        }
    }

    fn in_words(&self) -> String {
        format!("workpiece on {}", self.name())
    }

    fn draw(&self, view: &mut View) {
        let table = &self.0.support.worktable;
        let (half, foot) = (0.5 * table.length, -table.height);
        let (thickness, leg) = (table.top_thickness, table.leg_width);
        let [of_legs, of_top] = match table.material {
            TableMaterial::Wood => [drawing::Material::Solid, drawing::Material::Plywood],
            TableMaterial::Metal => [drawing::Material::Steel; 2],
        };
        floor::draw(view, floor::beyond(half), foot);
        let leg_from = |x: f64| rectangle([x, x + leg], [foot, -thickness]);
        let legs = vec![leg_from(-half), leg_from(half - leg)];
        let top = vec![rectangle([-half, half], [-thickness, 0.0])];
        view.parts.extend([
            Part::new("legs of the worktable", of_legs, legs),
            Part::new("top of the worktable", of_top, top),
        ]);
        let (length, height) = ("support.worktable.length", "support.worktable.height");
        let middle = 0.55 * foot;
        view.annotations.extend([
            Annotation::across(length, Side::Right, [-half, half], foot - 0.06, [foot; 2]),
            Annotation::upright(height, Side::Left, [foot, 0.0], -half - 0.05, [-half; 2]),
            Annotation::upright(
                "support.worktable.top_thickness",
                Side::Right,
                [-thickness, 0.0],
                half + 0.03,
                [half; 2],
            ),
            Annotation::across(
                "support.worktable.leg_width",
                Side::Right,
                [half - leg, half],
                middle,
                [middle; 2],
            ),
            Annotation::dot("support.worktable.width", Side::Left, [-0.4 * half, -0.5 * thickness]),
        ]);
        if let Some(wall) = self.tube_wall() {
            let across = [half - wall, half];
            let low = 0.8 * foot;
            let annotation = Annotation::across("support.worktable.leg_wall", Side::Right, across, low, [low; 2]);
            view.annotations.push(annotation);
        }
    }
}
