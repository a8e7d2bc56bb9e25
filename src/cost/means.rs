//! Boundary elements averaged over frequency, more than half an octave above single frequencies: estimates their finer
//! meshes without making them.

use nailnoise_acoustics::bem::{EquationSolver, SurfaceSize};
use nailnoise_acoustics::radiation::boundary_elements::MeanBands;

use super::stage::{SOUND_SPEED, StageCost};
use crate::design::{Acoustics, BemEquations};

/// Number of panels of bisected triangles per square of the longest edge: the N80CB's body up to 8 kHz has 17 900.
const TRIANGLES: f64 = 5.4;

/// Number of panels of boxes per square of the longest edge.
const RECTANGLES: f64 = 1.1;

/// Processor time for the close pairs of a panel if no two are congruent \[s\].
const CLOSE: f64 = 290e-6;

/// Number of frequencies solved simultaneously, about the number of threads.
const TOGETHER: f64 = 2.0;

/// A radiating surface.
pub(super) enum RadiatingSurface {
    /// Boxes with two mirror planes above a floor, with this total area \[m2\].
    Boxes(f64),
    /// A body of triangles.
    Body {
        /// Its total area \[m2\].
        area: f64,
        /// Number of its symmetric parts.
        parts: f64,
    },
}

impl RadiatingSurface {
    /// Size of a mesh with this longest edge \[m\], and processor time of its close pairs \[s\].
    fn size(&self, edge: f64) -> (SurfaceSize, f64) {
        match self {
            Self::Boxes(area) => {
                let panels = 0.25 * RECTANGLES * area / (edge * edge);
                let size = SurfaceSize {
                    unknowns: panels,
                    panels,
                    values: 4.0 * panels,
                    copies: 4.0,
                    images: 8.0,
                };
                (size, 0.0)
            }
            Self::Body { area, parts } => {
                let panels = TRIANGLES * area / (edge * edge) / parts;
                let size = SurfaceSize {
                    unknowns: 0.5 * panels,
                    panels,
                    values: 3.0 * panels,
                    copies: *parts,
                    images: *parts,
                };
                (size, CLOSE * panels)
            }
        }
    }
}

/// How the equations are stored and solved.
pub(super) fn equation_solver(acoustics: &Acoustics) -> EquationSolver {
    match acoustics.bem_equations {
        BemEquations::Auto => EquationSolver::Auto,
        BemEquations::Dense => EquationSolver::Dense,
        BemEquations::Compressed => EquationSolver::Compressed,
    }
}

/// Adds the finer meshes of the averages to the cost of a radiation at single frequencies up to `top_hz`, for a surface
/// with `modes` modes.
pub(super) fn add(
    stage: &mut StageCost,
    acoustics: &Acoustics,
    (surface, modes): (&RadiatingSurface, f64),
    top_hz: f64,
) {
    let mean_top = (acoustics.bem_mean_max_frequency > 0.0).then_some(acoustics.bem_mean_max_frequency);
    for (hz, bands) in MeanBands::new(top_hz, mean_top).finer_meshes() {
        let (size, close) = surface.size(SOUND_SPEED / (acoustics.bem_panels * hz));
        let cost = size.cost(equation_solver(acoustics));
        let patterns = modes / size.copies;
        stage.cpu_seconds += MeanBands::samples(bands) as f64 * (cost.seconds_with(patterns) + close);
        let velocities = 8.0 * size.values * modes;
        let gigabytes = 1e-9 * (TOGETHER * cost.bytes_with(patterns) + 2.0 * velocities);
        stage.gigabytes = stage.gigabytes.max(gigabytes);
        for (what, count) in &mut stage.counts {
            if *what == "panels" {
                *count = count.max(size.panels * size.copies);
            }
        }
        stage.keys = &[
            ("acoustics.bem_mean_max_frequency", "lower"),
            ("acoustics.bem_max_frequency", "lower"),
            ("acoustics.bem_panels", "lower"),
        ];
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::{of_run, radiation_of_tool};
    use crate::design::Design;

    fn tool(mean_top: f64) -> super::StageCost {
        let mut design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        design.acoustics.bem_mean_max_frequency = mean_top;
        radiation_of_tool(&design, 160.0).unwrap().unwrap()
    }

    #[test]
    fn means_up_to_half_an_octave_cost_nothing_more() {
        assert_eq!(tool(0.0), tool(3000.0));
        assert!(tool(8000.0).cpu_seconds > 4.0 * tool(0.0).cpu_seconds);
    }

    /// `nailnoise run` reports 17 900 panels, counted in the meshes themselves.
    #[test]
    fn regression_panels_of_the_finest_mesh() {
        let cost = tool(8000.0);
        let panels = cost.counts[0].1;
        assert!((panels / 17_858.0 - 1.0).abs() < 0.1, "{panels}");
        assert_eq!(cost.keys[0].0, "acoustics.bem_mean_max_frequency");
    }

    #[test]
    fn finer_meshes_are_part_of_the_cost_of_a_run() {
        let mut design = Design::load(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/n80cb.toml")).unwrap();
        let total = |design: &Design| {
            of_run(design)
                .unwrap()
                .iter()
                .map(|stage| stage.cpu_seconds)
                .sum::<f64>()
        };
        let before = total(&design);
        design.acoustics.bem_mean_max_frequency = 8000.0;
        assert!(total(&design) > 3.0 * before);
    }
}
