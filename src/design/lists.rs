//! Values derived from the sensors, springs and surfaces of a design.

use super::groups::{BodyModel, Values};
use super::recorded_surfaces::{RecordedSurface, RecordedSurfaceProblem};
use super::sensors::SensorProblem;
use super::springs::Sprung;
use super::surfaces::{NamedSurface, SurfaceOf, SurfaceProblem};
use crate::model::supports;
use crate::stages::bodies::BodyKind;

impl From<BodyKind> for SurfaceOf {
    fn from(kind: BodyKind) -> Self {
        match kind {
            BodyKind::Workpiece => Self::Workpiece,
            BodyKind::Worktable => Self::Worktable,
            BodyKind::Tool => Self::Tool,
        }
    }
}

impl Values {
    /// Whether the design has this body.
    pub(crate) fn has(&self, body: Sprung) -> bool {
        match body {
            Sprung::Workpiece => true,
            Sprung::Worktable => supports::of(self).bodies().contains(&BodyKind::Worktable),
        }
    }

    /// Names of the springs whose body is not in the design.
    pub(crate) fn idle_springs(&self) -> Vec<&str> {
        let absent = self.springs.iter().filter(|(_, spring)| !self.has(spring.body));
        absent.map(|(name, _)| name.as_str()).collect()
    }

    /// Total stiffness \[N/m\] and damping \[N s/m\] along z of all springs on a body.
    pub(crate) fn sprung(&self, body: Sprung) -> [f64; 2] {
        let on = self.springs.values().filter(|spring| spring.body == body);
        on.fold([0.0; 2], |[k, c], spring| {
            [k + spring.stiffness_z, c + spring.damping_z]
        })
    }

    /// Whether a run solves this body with a mesh from a file.
    pub(crate) fn is_from_file(&self, body: SurfaceOf) -> bool {
        let is_solved = match body {
            SurfaceOf::Workpiece => true,
            SurfaceOf::Worktable => self.has(Sprung::Worktable),
            SurfaceOf::Tool => self.body.model != BodyModel::Rigid,
        };
        is_solved && !self.mesh_of(body).is_empty()
    }

    /// The file that replaces the mesh of a body; empty for a built-in one.
    pub(crate) fn mesh_of(&self, body: SurfaceOf) -> &str {
        match body {
            SurfaceOf::Workpiece => &self.workpiece.mesh,
            SurfaceOf::Worktable => &self.support.worktable.mesh,
            SurfaceOf::Tool => &self.body.mesh,
        }
    }

    /// Names of the surfaces whose body is built in or absent, so that they have no effect.
    pub(crate) fn idle_surfaces(&self) -> Vec<&str> {
        let idle = self.surfaces.iter().filter(|(_, own)| !self.is_from_file(own.body));
        idle.map(|(name, _)| name.as_str()).collect()
    }

    /// Names of the records of surfaces whose body is built in or absent, so that they have no effect.
    pub(crate) fn idle_records(&self) -> impl Iterator<Item = (&str, SurfaceOf)> {
        let idle = self
            .recorded_surfaces
            .iter()
            .filter(|(_, own)| !self.is_from_file(own.body));
        idle.map(|(name, own)| (name.as_str(), own.body))
    }

    /// The first surface that does not belong to its body, with its name.
    pub(crate) fn surface_problem(&self) -> Option<(&str, SurfaceProblem)> {
        let other = |own: &NamedSurface| !own.body.surfaces().contains(&own.surface);
        let (name, own) = self.surfaces.iter().find(|(_, own)| other(own))?;
        let NamedSurface { body, surface, .. } = *own;
        Some((name, SurfaceProblem::OfOtherBody { surface, body }))
    }

    /// The first record of a surface that does not belong to its body, with its name.
    pub(crate) fn record_problem(&self) -> Option<(&str, RecordedSurfaceProblem)> {
        let other = |own: &RecordedSurface| !own.body.surfaces().contains(&own.surface);
        let (name, own) = self.recorded_surfaces.iter().find(|(_, own)| other(own))?;
        let RecordedSurface { body, surface, .. } = *own;
        Some((name, RecordedSurfaceProblem::OfOtherBody { surface, body }))
    }

    /// The first sensor with conflicting values, with its name.
    pub(crate) fn sensor_problem(&self) -> Option<(&str, SensorProblem)> {
        let nyquist = 0.5 / self.analysis.time_step;
        self.sensors.iter().find_map(|(name, sensor)| {
            let (low, high) = (sensor.band_low, sensor.band_high);
            let still = [sensor.along_x, sensor.along_y, sensor.along_z]
                .iter()
                .all(|c| *c == 0.0);
            let problem = if still {
                SensorProblem::NoDirection
            } else if low >= high || high >= nyquist {
                SensorProblem::Band { low, high, nyquist }
            } else {
                return None;
            };
            Some((name.as_str(), problem))
        })
    }
}
