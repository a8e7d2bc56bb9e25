use thiserror::Error;

/// What can go wrong between a motion or a flow and its sound power.
#[derive(Debug, Error)]
pub enum AcousticsError {
    /// Two arrays that describe the same thing differ in length.
    #[error("{what}: {found} values where {expected} are needed; give both on the same points or samples")]
    Length {
        /// The array that was counted.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// A quantity that must be finite and positive is not.
    #[error("{what} is {value}; it must be a finite number above zero")]
    NotPositive {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A value of a history or spectrum is not finite.
    #[error("{what}[{index}] is {value}; every value must be finite")]
    NotFinite {
        /// The array.
        what: &'static str,
        /// Position of the first bad value.
        index: usize,
        /// The value.
        value: f64,
    },
    /// A quantity lies outside the interval in which the model holds.
    #[error("{what} is {value}, outside {low} to {high}")]
    OutsideRange {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Lowest value allowed.
        low: f64,
        /// Highest value allowed.
        high: f64,
    },
    /// The analysed range is empty or reaches above half the sampling frequency.
    #[error("the range {low} to {high} Hz is empty or reaches above {nyquist} Hz, half the sampling frequency")]
    Range {
        /// Lower end \[Hz\].
        low: f64,
        /// Upper end \[Hz\].
        high: f64,
        /// Highest frequency the samples can carry \[Hz\].
        nyquist: f64,
    },
    /// A record is too short to be transformed.
    #[error("the record {what} has {found} samples; at least {needed} are needed")]
    ShortRecord {
        /// The record.
        what: &'static str,
        /// Its number of samples.
        found: usize,
        /// The least number of samples.
        needed: usize,
    },
    /// Frequencies do not rise strictly.
    #[error("the frequency {next} Hz follows {previous} Hz; a spectrum's frequencies rise strictly")]
    Frequencies {
        /// A frequency \[Hz\].
        previous: f64,
        /// The one after it \[Hz\].
        next: f64,
    },
    /// A frequency is not a multiple of the bin width.
    #[error("{hz} Hz is no multiple of {resolution} Hz; signals over time need the bins of one transform")]
    NotABin {
        /// The frequency \[Hz\].
        hz: f64,
        /// Mean distance of the frequencies \[Hz\].
        resolution: f64,
    },
    /// The Rayleigh integral was asked for a surface that is not one plane facing up.
    #[error(
        "surface point {point} lies {offset} m off the plane z = {plane} m or its normal is not +z (n_z = {normal}); \
         the Rayleigh integral holds for a flat face in a rigid plane, use another operator for this surface"
    )]
    NotPlanar {
        /// Index of the quadrature point.
        point: usize,
        /// Distance from the plane \[m\].
        offset: f64,
        /// Height of the plane \[m\].
        plane: f64,
        /// Vertical component of the point's normal.
        normal: f64,
    },
    /// A patch index points past the list of patch names.
    #[error("surface point {point} belongs to patch {patch}, but only {patches} patches are named")]
    Patch {
        /// Index of the quadrature point.
        point: usize,
        /// Its patch index.
        patch: usize,
        /// Number of named patches.
        patches: usize,
    },
    /// The block's footprint does not lie inside the sand box.
    #[error("the footprint {footprint:?} m (x, y) does not lie inside the sand box {sand:?} m; enlarge the box")]
    SandBox {
        /// Half-open intervals of the block's top, x then y \[m\].
        footprint: [[f64; 2]; 2],
        /// Intervals of the sand surface, x then y \[m\].
        sand: [[f64; 2]; 2],
    },
    /// The radiation matrix was not resolved over frequency with the samples allowed.
    #[error(
        "the radiation matrix near {hz} Hz is interpolated with error {error:.1e} after {samples} samples, \
         above the tolerance {tolerance:.1e}; allow more samples or a larger tolerance"
    )]
    Unresolved {
        /// Middle of the worst interval \[Hz\].
        hz: f64,
        /// Its estimated relative error.
        error: f64,
        /// Samples taken.
        samples: usize,
        /// Error asked for.
        tolerance: f64,
    },
    /// The mesh has no such patch or quadrature.
    #[error(transparent)]
    Mesh(#[from] nailnoise_meshes::MeshError),
    /// A muffler was asked for a frequency at which waves across it propagate.
    #[error(
        "a muffler element of {diameter} m carries plane waves alone up to {highest:.0} Hz only, not at {hz:.0} Hz; \
         analyse a lower range, or give the muffler's insertion loss by bands"
    )]
    NotPlaneWaves {
        /// The frequency \[Hz\].
        hz: f64,
        /// Inner diameter of the element \[m\].
        diameter: f64,
        /// Cut-on frequency of its first cross mode \[Hz\].
        highest: f64,
    },
    /// A muffler's insertion loss is not given for a frequency.
    #[error(
        "the muffler's insertion loss has no value at {hz} Hz: give neighbouring one-third-octave bands in rising order \
         that cover the analysed range"
    )]
    MufflerBands {
        /// The frequency \[Hz\].
        hz: f64,
    },
    /// The exhaust's area differs from that of its holes.
    #[error(
        "{count} exhaust holes of {diameter} m have {found:.4e} m2, not the {area:.4e} m2 given; correct one of the three"
    )]
    HoleArea {
        /// Number of holes.
        count: usize,
        /// Diameter of one \[m\].
        diameter: f64,
        /// Their area \[m²\].
        found: f64,
        /// Area given \[m²\].
        area: f64,
    },
    /// Air leaves against a higher pressure.
    #[error(
        "air leaves at sample {sample} ({flow:.3e} kg/s) from {pressure:.0} Pa into {ambient:.0} Pa; an outflow needs \
         a pressure above ambient before the opening: check the pressures' origin (absolute, not gauge)"
    )]
    BelowAmbient {
        /// The sample.
        sample: usize,
        /// Mass flow outward \[kg/s\].
        flow: f64,
        /// Pressure before the opening \[Pa\].
        pressure: f64,
        /// Ambient pressure \[Pa\].
        ambient: f64,
    },
    /// An outlet or a receiver below the floor.
    #[error("a point at z = {z} m lies below the floor at {floor} m; outlet and receiver must stand on or above it")]
    BelowFloor {
        /// Height of the point \[m\].
        z: f64,
        /// Height of the floor \[m\].
        floor: f64,
    },
    /// A receiver too close to a radiating surface.
    #[error(
        "the point {point:?} m lies {distance} m from the radiating surface; at least {needed} m, the longest edge of a \
         panel, are needed: move it away or refine the mesh"
    )]
    NearSurface {
        /// The point \[m\].
        point: [f64; 3],
        /// Its distance from the nearest point of a panel \[m\].
        distance: f64,
        /// Distance needed \[m\].
        needed: f64,
    },
    /// Exhaust holes so close that their jets merge.
    #[error(
        "{count} holes of {diameter} m stand {pitch} m apart; below three diameters their jets merge: give a larger \
         pitch, or one hole of {merged:.2e} m"
    )]
    MergingJets {
        /// Number of holes.
        count: usize,
        /// Hole diameter \[m\].
        diameter: f64,
        /// Distance between centres \[m\].
        pitch: f64,
        /// Diameter of one hole of the same area \[m\].
        merged: f64,
    },
    /// A surface whose exterior is to be solved has a hole.
    #[error(
        "the surface is open: {edges} edges belong to one panel only, one of them near {at:?} m; merge coincident nodes \
         or close the hole (a body may be open only where it stands on the floor)"
    )]
    OpenSurface {
        /// Number of open edges.
        edges: usize,
        /// Middle of one of them \[m\].
        at: [f64; 3],
    },
    /// More than two panels meet at an edge, or one twice.
    #[error(
        "{panels} panels meet at the edge near {at:?} m; a closed surface has two at every edge, remove the others"
    )]
    TangledSurface {
        /// Panels at the edge.
        panels: usize,
        /// Middle of the edge \[m\].
        at: [f64; 3],
    },
    /// The floor cuts through the body or lies above it.
    #[error(
        "the floor z = {floor} m lies above the body's lowest point z = {lowest} m (its highest is {highest} m); lower the \
         floor or raise the body"
    )]
    FloorThroughBody {
        /// Height of the floor \[m\].
        floor: f64,
        /// Lowest point of the body \[m\].
        lowest: f64,
        /// Highest point of the body \[m\].
        highest: f64,
    },
    /// A mirror plane cuts the part of the surface that should lie above it.
    #[error(
        "the mirror plane {axis} = {plane} m lies above the lowest {axis} = {lowest} m of the part given; give the part \
         above the plane alone, or the whole surface without the mirror"
    )]
    MirrorThroughPart {
        /// Axis across the plane.
        axis: &'static str,
        /// Position of the plane \[m\].
        plane: f64,
        /// Lowest coordinate along the axis \[m\].
        lowest: f64,
    },
    /// A panel lies on no face of the mesh that moves it.
    #[error(
        "the faces of the volume mesh cover {share:.6} of panel {panel} near {at:?} m; body and boundary mesh must have \
         the same flat sides"
    )]
    Uncovered {
        /// Number of the panel.
        panel: usize,
        /// Its centre \[m\].
        at: [f64; 3],
        /// Area covered over its area.
        share: f64,
    },
    /// A panel has no area.
    #[error("panel {panel} has an area of {area:.1e} m2; remove it or repair the mesh")]
    DegeneratePanel {
        /// Number of the panel.
        panel: usize,
        /// Its area \[m²\].
        area: f64,
    },
    /// The mesh does not resolve the wave.
    #[error(
        "the panels' longest edge, {edge} m, is 1/{per_wavelength:.1} of the wavelength at {hz:.0} Hz; 1/{needed} is \
         needed: stay below {highest:.0} Hz or refine the mesh"
    )]
    TooCoarse {
        /// Frequency asked for \[Hz\].
        hz: f64,
        /// Longest edge \[m\].
        edge: f64,
        /// Panels per wavelength there are.
        per_wavelength: f64,
        /// Panels per wavelength there should be.
        needed: f64,
        /// Highest frequency the mesh resolves \[Hz\].
        highest: f64,
    },
}

impl AcousticsError {
    /// Whether the design must change for it, rather than the program.
    pub fn is_of_the_design(&self) -> bool {
        matches!(
            self,
            Self::NotPlaneWaves { .. }
                | Self::MufflerBands { .. }
                | Self::HoleArea { .. }
                | Self::MergingJets { .. }
                | Self::BelowAmbient { .. }
                | Self::BelowFloor { .. }
                | Self::OutsideRange { .. }
                | Self::SandBox { .. }
        )
    }
}

/// Fails with [`AcousticsError::NotPositive`] unless `value` is finite and above zero.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, AcousticsError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(AcousticsError::NotPositive { what, value })
    }
}

/// Fails with [`AcousticsError::NotFinite`] at the first value that is not finite.
pub(crate) fn finite(what: &'static str, values: &[f64]) -> Result<(), AcousticsError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(AcousticsError::NotFinite {
            what,
            index,
            value: values[index],
        }),
    }
}

/// Fails with [`AcousticsError::Length`] unless the two lengths agree.
pub(crate) fn same_length(what: &'static str, found: usize, expected: usize) -> Result<(), AcousticsError> {
    if found == expected {
        Ok(())
    } else {
        Err(AcousticsError::Length { what, found, expected })
    }
}
