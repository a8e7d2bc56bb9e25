//! Every key of the design file, group by group.
//!
//! Each group is declared next to the physics that uses it: those of the nailing cycle in [`nailnoise_dynamics`], the
//! tool body's dimensions in [`nailnoise_meshes`], orthotropic solids in [`nailnoise_fem`], all others here. If Z. Nili
//! Ahmadabadi, "Noise source identification and dynamic modeling of a pneumatic nailing device" (ETS Montreal, 2016),
//! ch. 4, has a symbol for a quantity, it is used.

use nailnoise_dynamics as dynamics;
pub use nailnoise_dynamics::{
    Ambient, Chambers, Contacts, Form, Friction, Hand, HeadValve, Model, Piston, Supply, Tool, Trigger,
};
pub use nailnoise_fem::Orthotropic;
use nailnoise_quantities::dimension::*;
use nailnoise_quantities::{Kind, any, choice, fraction, group, modulus, nonnegative, positive};

use super::catalogue::{NailKind, Species, WorktablePreset};
use super::octaves::Octaves;
use super::recorded_surfaces::RecordedSurface;
use super::sensors::Sensor;
use super::springs::Spring;
use super::surfaces::NamedSurface;
use super::transducers::Transducer;

group! {
    /// All quantities of a design, in SI units.
    Values {}
    groups {
        supply: Supply,
        piston: Piston,
        head_valve: HeadValve,
        chambers: Chambers,
        exhaust: Exhaust,
        trigger: Trigger,
        nail: Nail,
        wood: Wood,
        workpiece: Workpiece,
        contacts: Contacts,
        tool: Tool,
        hand: Hand,
        support: Support,
        body: Body,
        ambient: Ambient,
        acoustics: Acoustics,
        sources: Sources,
        analysis: Analysis,
        model: Model,
        test: Test,
    }
    lists {
        sensors: Sensor,
        springs: Spring,
        surfaces: NamedSurface,
        recorded_surfaces: RecordedSurface,
        transducers: Transducer,
    }
}

group! {
    /// Exhaust holes behind the head valve; A_ma = n pi d^2/4.
    Exhaust {
        ..cycle: dynamics::Exhaust;
        /// Distance of neighbouring holes, centre to centre. Above 3 d, the jets radiate separately; closer than
        /// that, they merge and radiate as one jet of the same total area. Without effect for one hole.
        pitch: f64 = positive(LENGTH), "";
    }
    groups {
        plenum: Plenum,
        fitting: Fitting,
        muffler: Muffler,
    }
}

group! {
    /// The space between head valve and exhaust holes, whose air the holes' air bounces on:
    /// f_0 = (c/2 pi) sqrt(A_ma/(V L')).
    Plenum {
        /// Whether this resonance filters the sound of the unsteady outflow.
        resonance: bool = Kind::Switch, "";
        /// Volume.
        volume: f64 = positive(VOLUME), "V";
        /// Length of the holes with their end corrections.
        neck_length: f64 = positive(LENGTH), "L'";
        /// Quality factor of the resonance.
        quality: f64 = positive(NUMBER).within(0.01, 1e3), "Q";
    }
}

choice! {
    /// Fitting on the exhaust holes.
    FittingKind {
        /// Nothing.
        None = "none",
        /// A pipe, open at its end.
        Pipe = "pipe",
    }
}

choice! {
    /// Gas inside a fitting.
    FittingGas {
        /// That of the outflow, at its stagnation temperature.
        Outflow = "outflow",
        /// Air of the ambient temperature, as in a pipe without flow.
        Ambient = "ambient",
    }
}

group! {
    /// Pipe fitting on the exhaust holes, such as the one that carries a muffler in a wrapping test: a quarter-wave
    /// resonator that the choked holes close. It filters the unsteady outflow and excludes a muffler. Its wall moves
    /// with the tool and radiates; it points as the jets do (`thrust_share`).
    Fitting {
        /// The kind of fitting; the other keys are used for a pipe only.
        kind: FittingKind = FittingKind::KIND, "";
        /// Length from the holes to the open end.
        length: f64 = positive(LENGTH), "L";
        /// Inner diameter.
        diameter: f64 = positive(LENGTH), "d";
        /// Thickness of its wall.
        wall_thickness: f64 = positive(LENGTH), "t";
        /// Mach number of the mean flow at the outlet, whose jet damps the resonances.
        outlet_mach: f64 = nonnegative(NUMBER).within(0.0, 1.0), "M";
        /// Gas inside, whose sound speed sets the resonances.
        gas: FittingGas = FittingGas::KIND, "";
    }
}

choice! {
    /// Muffler behind the exhaust holes.
    MufflerKind {
        /// Nothing: the holes open into the air.
        None = "none",
        /// A muffler whose insertion loss was measured.
        InsertionLoss = "insertion_loss",
        /// An expansion chamber with a tail pipe, computed from its dimensions.
        Chamber = "chamber",
    }
}

group! {
    /// Muffler behind the exhaust holes; only the keys of the chosen kind take part.
    Muffler {
        /// The kind of muffler.
        kind: MufflerKind = MufflerKind::KIND, "";
        /// Effective flow area C A of its narrowest passage, in series with the holes: its back pressure in the cycle.
        flow_area: f64 = positive(AREA), "C A_s";
        /// Length of the chamber.
        chamber_length: f64 = positive(LENGTH), "L_c";
        /// Inner diameter of the chamber.
        chamber_diameter: f64 = positive(LENGTH), "D_c";
        /// Length of the tail pipe.
        tail_length: f64 = positive(LENGTH), "L_t";
        /// Inner diameter of the tail pipe.
        tail_diameter: f64 = positive(LENGTH), "D_t";
        /// Thickness of the porous lining around the tail pipe; 0 for a bare pipe.
        lining_thickness: f64 = nonnegative(LENGTH), "t";
        /// Flow resistivity of the lining.
        lining_resistivity: f64 = positive(FLOW_RESISTIVITY), "sigma";
    }
    groups {
        octaves: Octaves,
    }
}

group! {
    /// The nail and its position under the rod.
    Nail {
        /// Nail by size and shank, which sets length, diameter and head; keys beside it win. `nailnoise list nails`
        /// prints them.
        kind: NailKind = NailKind::KIND, "";
        ..cycle: dynamics::Nail;
        /// Where the nail is driven: distance from the block's centre along its length.
        offset_along: f64 = any(LENGTH), "";
        /// Where the nail is driven: distance from the block's centre across its width.
        offset_across: f64 = any(LENGTH), "";
    }
}

choice! {
    /// The direction across the grain along which the nail is driven.
    Rings {
        /// Driven across the growth rings: the thickness is radial, the width tangential.
        Radial = "radial",
        /// Driven along the growth rings: the thickness is tangential, the width radial.
        Tangential = "tangential",
    }
}

group! {
    /// The wood of the workpiece.
    Wood {
        /// Wood by name, which sets density, hardness modulus, loss factor, elastic constants and, with the shank of
        /// `nail.kind`, penetration law and share of friction; keys beside it win. `nailnoise list woods` prints them.
        species: Species = Species::KIND, "";
        ..cycle: dynamics::NailedWood;
        /// Fitted law of the word `fitted`, a file that `nailnoise penetration fit` writes; unused with the other laws.
        penetration_fit: String = Kind::File, "";
        /// Share of the resistance at full depth that is friction along the shank; the rest acts at the tip.
        friction_share: f64 = fraction(), "";
        /// Direction of driving relative to the growth rings.
        driven: Rings = Rings::KIND, "";
        /// Loss factor of the free block's modes.
        loss_factor: f64 = fraction(), "eta";
    }
    groups {
        elastic: Grain,
    }
}

group! {
    /// Elastic constants of wood: L along the grain, R radial, T tangential to the growth rings.
    Grain {
        /// Young's modulus along the grain.
        e_l: f64 = modulus(), "E_L";
        /// Young's modulus in radial direction.
        e_r: f64 = modulus(), "E_R";
        /// Young's modulus in tangential direction.
        e_t: f64 = modulus(), "E_T";
        /// Shear modulus in the longitudinal-radial plane.
        g_lr: f64 = modulus(), "G_LR";
        /// Shear modulus in the longitudinal-tangential plane.
        g_lt: f64 = modulus(), "G_LT";
        /// Rolling shear modulus, in the radial-tangential plane.
        g_rt: f64 = modulus(), "G_RT";
        /// Radial contraction for a pull along the grain.
        nu_lr: f64 = any(NUMBER).within(-10.0, 10.0), "nu_LR";
        /// Tangential contraction for a pull along the grain.
        nu_lt: f64 = any(NUMBER).within(-10.0, 10.0), "nu_LT";
        /// Tangential contraction for a radial pull.
        nu_rt: f64 = any(NUMBER).within(-10.0, 10.0), "nu_RT";
    }
}

group! {
    /// The block of wood that is nailed.
    Workpiece {
        ..block: dynamics::Block;
        /// Mesh (.msh) or geometry (.step) in place of the block, for the modes and the response. The length is centred
        /// on x = 0, the width on y = 0, and z points up from the underside. It has the surfaces `top` and `bottom`. In
        /// a file without names they are the highest and the lowest plane, or those of `surfaces.NAME`.
        mesh: String = Kind::File, "";
        /// Length of one unit of that file.
        mesh_unit: f64 = positive(LENGTH), "";
    }
    groups {
        board: Board,
    }
}

group! {
    /// A board on the block, of the same wood: the nail goes through it and fastens it. The pieces touch in unilateral
    /// points, as block and table do; friction between them is left out.
    Board {
        /// Thickness, a part of `workpiece.thickness`; 0 for a workpiece of one piece.
        thickness: f64 = nonnegative(LENGTH), "";
        /// Stiffness per area of the contact between the pieces.
        stiffness_per_area: f64 = positive(STIFFNESS_PER_AREA), "";
        /// Stiffness of the nail along its axis, against separation of the pieces.
        axial_stiffness: f64 = positive(STIFFNESS), "";
        /// Stiffness of the nail across its axis, against slip between the pieces.
        shear_stiffness: f64 = positive(STIFFNESS), "K_ser";
        /// Loss ratio of contact and nail, at `support.contact.loss_frequency`.
        loss_ratio: f64 = nonnegative(NUMBER).within(0.0, 10.0), "";
    }
}

choice! {
    /// Support of the workpiece.
    SupportKind {
        /// The block stands on a worktable.
        Worktable = "worktable",
        /// The block lies in a sandbox, its top flush with the sand.
        Sandbox = "sandbox",
        /// The block lies on a rigid floor, on the springs and dashpots of `support.contact`; soft and bonded ones hang
        /// it free.
        Floor = "floor",
        /// The block's underside is held.
        Clamped = "clamped",
        /// The block stands on the springs and dashpots of `springs.NAME` alone.
        Springs = "springs",
    }
}

choice! {
    /// How the nailing cycle and the structures it drives are joined.
    Coupling {
        /// The cycle has a lumped workpiece of its own; its forces drive the structures.
        OneWay = "one-way",
        /// The structures' modes take the place of the lumped workpiece: the support acts back on the shot.
        TwoWay = "two-way",
    }
}

choice! {
    /// How the worktable stands on the floor.
    TableFoot {
        /// Its feet, the surface `floor`, are held.
        Clamped = "clamped",
        /// It stands on the springs and dashpots of `springs.NAME` alone.
        Springs = "springs",
    }
}

choice! {
    /// Material of the worktable.
    TableMaterial {
        /// Orthotropic wood: the constants of `top` and `legs`.
        Wood = "wood",
        /// An isotropic metal for top and legs, the constants of `metal`.
        Metal = "metal",
    }
}

group! {
    /// Support of the workpiece; only the group of the chosen kind has an effect.
    Support {
        /// The support.
        kind: SupportKind = SupportKind::KIND, "";
        /// Whether the structures act back on the nailing cycle.
        coupling: Coupling = Coupling::KIND, "";
        /// Height of the underside of a block on springs above the floor: that of rubber feet, or of straps. Up to 1 m
        /// the floor is part of the block's radiation; one farther below is left out of its power and reflects to the
        /// microphones alone. With 0 the block lies on the floor, and its underside makes no sound.
        clearance: f64 = nonnegative(LENGTH), "h";
    }
    groups {
        worktable: Worktable,
        contact: BlockContact,
        sand: Sand,
    }
}

group! {
    /// Worktable: a plate on four square legs, clamped at the floor or on springs. A preset sets its build, all but
    /// length, width and height.
    Worktable {
        /// Build of the table by name; results are stated with it. A name replaces the values of these keys from bases;
        /// a key given with it wins.
        preset: WorktablePreset = WorktablePreset::KIND, "";
        /// How it stands on the floor.
        foot: TableFoot = TableFoot::KIND, "";
        /// Length of the top, along the workpiece's length.
        length: f64 = positive(LENGTH), "";
        /// Width of the top.
        width: f64 = positive(LENGTH), "";
        /// Height of the top's upper face above the floor.
        height: f64 = positive(LENGTH), "";
        /// Thickness of the top.
        top_thickness: f64 = positive(LENGTH), "";
        /// Side of a leg's square section; the legs stand flush with the top's corners.
        leg_width: f64 = positive(LENGTH), "";
        /// Wall of a leg of square tube; 0 for solid legs.
        leg_wall: f64 = nonnegative(LENGTH), "";
        /// Material of top and legs.
        material: TableMaterial = TableMaterial::KIND, "";
        /// Density of a wooden top.
        top_density: f64 = positive(DENSITY), "rho";
        /// Density of wooden legs.
        leg_density: f64 = positive(DENSITY), "rho";
        /// Loss factor of the assembled table's modes.
        loss_factor: f64 = fraction(), "eta";
        /// Stiffness under the block in the cycle model, where the table is one spring.
        stiffness: f64 = positive(STIFFNESS), "k_ws";
        /// Damping ratio of that spring, on the workpiece's mass.
        damping_ratio: f64 = nonnegative(NUMBER).within(0.0, 10.0), "zeta_ws";
        /// Mesh (.msh) or geometry (.step) in place of the table, with z = 0 at its upper face. It has the parts `top`
        /// and `leg`, the surface `top` and, if it is clamped, the surface `floor`. In a file without names the
        /// surfaces are the highest and the lowest plane, or those of `surfaces.NAME`. Bodies meshed apart are tied:
        /// the nodes of a surface `NAME_slave` follow those of `NAME_master`.
        mesh: String = Kind::File, "";
        /// Length of one unit of that file.
        mesh_unit: f64 = positive(LENGTH), "";
    }
    groups {
        top: Orthotropic,
        legs: Orthotropic,
        metal: Isotropic,
    }
}

group! {
    /// An isotropic solid.
    Isotropic {
        /// Young's modulus.
        young_modulus: f64 = modulus(), "E";
        /// Poisson's ratio.
        poisson_ratio: f64 = nonnegative(NUMBER).within(0.0, 0.5), "nu";
        /// Density.
        density: f64 = positive(DENSITY), "rho";
    }
}

group! {
    /// Contact between block and worktable or floor: unilateral points, p = max(0, k'' d + c'' d') for d > 0.
    BlockContact {
        /// Stiffness per area.
        stiffness_per_area: f64 = positive(STIFFNESS_PER_AREA), "k''";
        /// Loss ratio 2 pi f c''/k'' at the frequency below.
        loss_ratio: f64 = nonnegative(NUMBER).within(0.0, 10.0), "";
        /// Frequency of the loss ratio.
        loss_frequency: f64 = positive(FREQUENCY), "f";
        /// Contact points along the block's length.
        points_along: u32 = Kind::Count(1000), "";
        /// Contact points across the block's width.
        points_across: u32 = Kind::Count(1000), "";
        /// Whether the block is glued to the table (linear) or lifts off it.
        bonded: bool = Kind::Switch, "";
    }
}

choice! {
    /// The plane on which the measurement surface around a sandbox stands.
    SandboxPlane {
        /// The sand's surface.
        Sand = "sand",
        /// The floor under the box, its depth lower.
        Floor = "floor",
    }
}

group! {
    /// Sandbox.
    Sand {
        /// Length of the box, along the workpiece's length.
        box_length: f64 = positive(LENGTH), "";
        /// Width of the box.
        box_width: f64 = positive(LENGTH), "";
        /// Depth of the box.
        box_depth: f64 = positive(LENGTH), "";
        /// Density of the sand.
        density: f64 = positive(DENSITY), "rho";
        /// Small-strain shear modulus.
        shear_modulus: f64 = modulus(), "G_0";
        /// Poisson's ratio.
        poisson_ratio: f64 = nonnegative(NUMBER).within(0.0, 0.5), "nu";
        /// Hysteretic loss factor.
        loss_factor: f64 = fraction(), "eta";
        /// Flow resistivity of the surface, for its sound absorption.
        flow_resistivity: f64 = positive(FLOW_RESISTIVITY), "sigma";
        /// Share of the absorption of an infinite sand plane, in dB, that the patch around the block reaches.
        absorption_share: f64 = fraction(), "";
        /// Whether the block sticks to the sand (linear) or lifts off it.
        bonded: bool = Kind::Switch, "";
        /// Share of the block's sides that the sand holds, with the springs and dashpots per area of its base.
        side_contact: f64 = fraction(), "";
        /// Sand that moves with the base, as a part of rho r_0 A; its weight rests in the sand.
        added_mass: f64 = nonnegative(NUMBER).within(0.0, 100.0), "";
        /// Whether the sand's surface around the block moves with it and radiates.
        moving_surface: bool = Kind::Switch, "";
        /// Highest frequency at which the sand's surface moves with the block.
        moving_surface_max_frequency: f64 = positive(FREQUENCY), "";
        /// The plane on which the measurement surface of ISO 3744 stands: the area of that surface, with it the
        /// correction K2, and the heights of the microphones. Radiation is the same in both: the sand reflects all
        /// sources, and the block radiates over the sand's plane.
        measurement_plane: SandboxPlane = SandboxPlane::KIND, "";
    }
}

choice! {
    /// Sources of sound of the tool body.
    BodyModel {
        /// Its rigid motion and the vibration of its housing, from finite elements.
        Elastic = "elastic",
        /// Its rigid motion alone.
        Rigid = "rigid",
    }
}

group! {
    /// Tool body: barrel with cap on a hollow nose, hollow handle, coil-magazine can, cylinder sleeve; z up from the
    /// nose's tip, the handle along +x. Of a rigid body, `run` uses only the outer dimensions, which give the displaced
    /// air.
    Body {
        /// Its sources of sound: rigid motion and vibration, or rigid motion only, which is a lower bound.
        model: BodyModel = BodyModel::KIND, "";
        ..dimensions: nailnoise_meshes::ToolDimensions;
        /// Whether the part of the tool's mass that the geometry does not include (head valve, nails, fittings) is
        /// lumped on it.
        lumped: bool = Kind::Switch, "";
        /// Share of the lumped mass on the nose's tip. The rest, apart from the magazine's share, is on the sleeve's
        /// seat.
        lumped_nose: f64 = fraction(), "";
        /// Share of the lumped mass on the magazine, as a solid cylinder that fills it.
        lumped_magazine: f64 = fraction(), "";
        /// Loss factor of the assembled tool's modes.
        loss_factor: f64 = fraction(), "eta";
        /// Mesh (.msh) or geometry (.step) in place of all of this, in the same axes. Parts named `housing`, `cap`,
        /// `nose` and `sleeve` take their materials; a mesh with a single part takes that of the housing. Masses are
        /// lumped on the surfaces `nose_tip`, `magazine` and `seat`. The nodes of a surface `NAME_slave` follow those
        /// of `NAME_master`. Forces of the shot act on `cap`, `seat`, `bumper_seat`, `gas_bore`, `nose_tip` and
        /// `handle`, and gas acts on `supply`, `plenum`, `sleeve_outside` and `barrel_inside`, if the mesh has these.
        /// `surfaces.NAME` gives the places of surfaces that the file does not name. In a file that names none of them,
        /// all but the magazine are recognised by the axis x = y = 0 and the bore; `nailnoise check DESIGN --body tool`
        /// shows them.
        mesh: String = Kind::File, "";
        /// Length of one unit of that file.
        mesh_unit: f64 = positive(LENGTH), "";
    }
    groups {
        housing: Isotropic,
        cap: Isotropic,
        nose: Isotropic,
        sleeve: Isotropic,
        cover: Cover,
    }
}

choice! {
    /// Surfaces of the tool under a sound absorbing cover.
    CoverSurfaces {
        /// None.
        None = "none",
        /// The outer surface without cap, handle and tip of the nose.
        Housing = "housing",
        /// The outer side of the cap; the exhaust holes stay open.
        Cap = "cap",
        /// Both.
        Both = "both",
    }
}

choice! {
    /// Motion of the frame of the cover's foam.
    CoverFrame {
        /// It moves with the wall, to which it is glued, as below the first resonance of its thickness.
        Moving = "moving",
        /// It rests, as that of a cover on soft spacers, or far above that resonance.
        Resting = "resting",
    }
}

group! {
    /// Sound absorbing cover on the tool: a layer of open-cell foam or felt, as a locally reacting layer of the law of
    /// Miki (1990) after Delany and Bazley. It changes the radiation of the elastic body by boundary elements; the
    /// motion of the wall, the exhaust and the mass of the tool are those of the bare tool.
    Cover {
        /// The surfaces under it; the other keys are used with a cover only.
        surfaces: CoverSurfaces = CoverSurfaces::KIND, "";
        /// Thickness.
        thickness: f64 = nonnegative(LENGTH).within(0.0, 0.2), "t";
        /// Flow resistivity of the material.
        resistivity: f64 = positive(FLOW_RESISTIVITY).within(500.0, 1e6), "sigma";
        /// What its frame does. The truth lies between both.
        frame: CoverFrame = CoverFrame::KIND, "";
    }
}

choice! {
    /// How the radiation of the workpiece with its support, or of the tool's body, is computed; that of the workpiece
    /// in sand is always Rayleigh's integral.
    RadiationMethod {
        /// Boundary elements on the closed surface above the floor, block and table as one.
        Bem = "bem",
        /// Equivalent radiated power: radiation efficiency 1, for the tool's body that of a sphere of its volume.
        Erp = "erp",
    }
}

choice! {
    /// Part of the air's radiation impedance R + jX that acts on the modes of workpiece, support and tool.
    FluidLoading {
        /// Nothing: they move as in vacuum.
        None = "none",
        /// R at each mode's resonance, as damping.
        Damping = "damping",
        /// R as damping, and X as mass of air that moves along; by boundary elements only.
        Full = "full",
    }
}

choice! {
    /// How the equations of boundary elements are stored and solved.
    BemEquations {
        /// The cheaper of the two by their estimated time: compressed from about 6 000 unknowns.
        Auto = "auto",
        /// A dense matrix and its factors.
        Dense = "dense",
        /// Blocks of low rank by adaptive cross approximation, and a block Krylov method.
        Compressed = "compressed",
    }
}

group! {
    /// Radiation of vibrating surfaces.
    Acoustics {
        /// Radiation of the workpiece with its support.
        method: RadiationMethod = RadiationMethod::KIND, "";
        /// Radiation of the tool's body where it is elastic: boundary elements on its housing, at single frequencies
        /// up to `bem_max_frequency` or as far as its mesh resolves the waves, or that of a sphere of its volume.
        body_method: RadiationMethod = RadiationMethod::KIND, "";
        /// Highest single frequency of the boundary elements in air of 20 degrees Celsius, in other air higher as its
        /// speed of sound is; above it they are solved in the mean over frequency, up to `bem_mean_max_frequency`.
        bem_max_frequency: f64 = positive(FREQUENCY).within(20.0, 1e5), "";
        /// Upper end of the boundary elements in the mean over bands of at most a sixth of an octave, for workpiece and
        /// tool, in the same air as `bem_max_frequency`. With 0 it is half an octave above the highest single
        /// frequency, which needs no finer mesh. At least one band is solved. Above it the high-frequency limit
        /// applies.
        bem_mean_max_frequency: f64 = nonnegative(FREQUENCY).within(0.0, 1e5), "";
        /// How the equations of boundary elements are stored and solved.
        bem_equations: BemEquations = BemEquations::KIND, "";
        /// Least number of panels per wavelength of sound.
        bem_panels: f64 = positive(NUMBER).within(2.0, 30.0), "";
        /// Largest interpolation error of the radiation matrix over frequency: root mean square of the entries R_ij,
        /// relative to sqrt(R_ii R_jj).
        bem_tolerance: f64 = positive(NUMBER).within(1e-6, 0.5), "";
        /// Fluid loading of the modes of workpiece, support and tool: none, radiation damping, or damping and added
        /// mass. Added mass needs boundary elements; with it, linear motion has the impedance of every frequency. Every
        /// run states what fluid loading changes.
        fluid_loading: FluidLoading = FluidLoading::KIND, "";
        /// Equivalent absorption area of the room in which the microphones stand; 0 for none but the reflecting plane.
        room_absorption: f64 = nonnegative(AREA), "A";
        /// Steady A-weighted sound pressure level of the background at the microphones, in dB; 0 for none.
        background_level: f64 = nonnegative(NUMBER).within(0.0, 200.0), "L_B";
        /// Operator's ear: distance from the axis of driving along the workpiece's length.
        ear_along: f64 = any(LENGTH).within(-5.0, 5.0), "";
        /// Operator's ear: distance from the axis of driving across the workpiece's width.
        ear_across: f64 = any(LENGTH).within(-5.0, 5.0), "";
        /// Operator's ear: height above the workpiece's upper face.
        ear_height: f64 = positive(LENGTH).within(0.1, 5.0), "";
    }
}

choice! {
    /// Which source a part counts to.
    Convention {
        /// By the mechanism: the exhaust is the sound of the outflow, the body that of all vibrating parts.
        Physical = "physical",
        /// As selective wrapping measures: the exhaust is the outflow with the surfaces of cap and exhaust, which lie
        /// outside the body's wrap, whatever sets them in motion.
        Wrapping = "wrapping",
    }
}

choice! {
    /// The source to which the trigger vent counts by the convention of wrapping.
    VentSource {
        /// The body: the vent lies under the body's wrap.
        Body = "body",
        /// The exhaust, as by the physical convention.
        Exhaust = "exhaust",
    }
}

group! {
    /// Bookkeeping of the sources. It moves energy between exhaust and body and leaves the total as it is: each part of
    /// the body's surface has its own term and half of each cross term of the body's radiated power, and may be
    /// negative.
    Sources {
        /// Which source a part counts to.
        convention: Convention = Convention::KIND, "";
        /// Source of the trigger vent by the convention of wrapping; without effect by the physical one.
        trigger_vent: VentSource = VentSource::KIND, "";
    }
}

group! {
    /// Settings of the computation: frequency ranges, meshes, steps and tolerances.
    Analysis {
        /// Lower end of the range over which sources are ranked.
        range_low: f64 = positive(FREQUENCY).within(1.0, 1e5), "";
        /// Upper end of the range over which sources are ranked.
        range_high: f64 = positive(FREQUENCY).within(1.0, 1e5), "";
        /// Top frequency of the workpiece's modes that take part.
        workpiece_max_frequency: f64 = positive(FREQUENCY).within(1.0, 1e5), "";
        /// Top frequency of the worktable's modes that take part.
        worktable_max_frequency: f64 = positive(FREQUENCY).within(1.0, 1e5), "";
        /// Top frequency of the tool body's modes that take part.
        body_max_frequency: f64 = positive(FREQUENCY).within(1.0, 1e5), "";
        /// Top frequency of the exhaust.
        exhaust_max_frequency: f64 = positive(FREQUENCY).within(1.0, 1e5), "";
        /// Modes are computed up to this many times the top frequency.
        mode_margin: f64 = positive(NUMBER).within(1.0, 3.0), "";
        /// Largest side of a quadratic element of the workpiece.
        workpiece_element: f64 = positive(LENGTH).within(1e-5, 10.0), "";
        /// Largest side of a quadratic element of the worktable, seen from above.
        worktable_element: f64 = positive(LENGTH).within(1e-5, 10.0), "";
        /// Largest length of a quadratic element along the worktable's legs.
        worktable_leg_element: f64 = positive(LENGTH).within(1e-5, 10.0), "";
        /// Largest side of a quadratic element in the walls of legs of tube.
        worktable_tube_element: f64 = positive(LENGTH).within(1e-5, 10.0), "";
        /// Largest side of a quadratic tetrahedron of a tool body from a file. For the parametric one it is gmsh's
        /// target, which its sides exceed by half at most; a third of it where nose, arm and handle join.
        body_element: f64 = positive(LENGTH).within(1e-5, 10.0), "";
        /// Fewest elements in the shortest bending wave or shear wave at the top frequency, for geometry meshed by
        /// gmsh.
        elements_per_wave: f64 = positive(NUMBER).within(0.5, 30.0), "";
        /// Layers of quadratic elements through the worktable's top.
        worktable_top_layers: u32 = Kind::Count(100), "";
        /// Step of the structural response and of the sampled cycle.
        time_step: f64 = positive(TIME), "";
        /// Duration of the structural response from the trigger on.
        duration: f64 = positive(TIME).within(1e-3, 60.0), "";
        /// Starts of the response, all but the first with gaps of 1 um between block and support: how far the level of
        /// a block that bounces scatters. The levels are those of the first.
        starts: u32 = Kind::Count(10_000), "";
        /// Latest end of the cycle's record.
        cycle_end: f64 = positive(TIME).within(1e-3, 10.0), "t_end";
        /// Record of the cycle after its last event.
        cycle_tail: f64 = nonnegative(TIME), "";
        /// Relative tolerance of the cycle's integration.
        cycle_tolerance: f64 = positive(NUMBER).within(1e-12, 1e-2), "";
        /// Largest relative residual of a mode.
        mode_tolerance: f64 = positive(NUMBER).within(1e-14, 1e-2), "";
    }
}

group! {
    /// Virtual wrapping test of EN 12549 (`nailnoise test`). It changes no level of a run.
    Test {
        /// Shots of each configuration; EN 12549 requires 5.
        repeats: u32 = Kind::Count(100), "";
        /// Sampling rate of the recordings.
        sampling_rate: f64 = positive(FREQUENCY).within(25e3, 1e6), "";
        /// Length of a recording; at least 1 s after the trigger is analysed.
        record_length: f64 = positive(TIME).within(0.2, 10.0), "";
        /// Latest trigger after the first 10 ms of a recording; each is drawn uniformly from 0 to this.
        trigger_delay: f64 = nonnegative(TIME).within(0.0, 1.0), "";
        /// Relative standard deviation of the supply pressure from shot to shot.
        pressure_scatter: f64 = nonnegative(NUMBER).within(0.0, 0.5), "";
        /// Relative standard deviation of the wood's resistance from shot to shot.
        resistance_scatter: f64 = nonnegative(NUMBER).within(0.0, 0.5), "";
        /// Standard deviation of an accelerometer's noise.
        acceleration_noise: f64 = nonnegative(ACCELERATION), "";
    }
    groups {
        wraps: Wraps,
    }
}

group! {
    /// Wraps of the virtual wrapping test: foam inside a barrier on body or workpiece, a muffler on the exhaust. Losses
    /// are in dB, linear in the logarithm of frequency between the two frequencies, constant outside.
    Wraps {
        /// Insertion loss of the workpiece's wrap up to 125 Hz, in dB.
        workpiece_low: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Insertion loss of the workpiece's wrap from 4 kHz on, in dB.
        workpiece_high: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Insertion loss of the body's wrap up to 125 Hz, in dB.
        body_low: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Insertion loss of the body's wrap from 4 kHz on, in dB.
        body_high: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Insertion loss of the muffler up to 50 Hz, in dB.
        muffler_low: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Insertion loss of the muffler from 400 Hz on, in dB.
        muffler_high: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Loss of the bare exhaust through the body's wrap, which is tight on the exhaust, in dB.
        exhaust_mask: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Loss of the bare workpiece through the body's wrap, which reaches down over the nose, in dB.
        workpiece_mask: f64 = nonnegative(NUMBER).within(0.0, 200.0), "";
        /// Mass of the body's wrap.
        mass: f64 = nonnegative(MASS).within(0.0, 50.0), "";
        /// Whether this mass is added to the tool's where its body is wrapped.
        adds_mass: bool = Kind::Switch, "";
    }
}
