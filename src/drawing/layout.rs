//! Positions of the parts of the tool: heights above the tip of the nose and distances from the axis.
//!
//! Every length that has a key has the value of that key. Piston, bumper and the ring of the head valve have no key for
//! their height. They fill the space that the stroke and the dead volumes leave in the cylinder sleeve, so that the
//! dead volumes V_01 and V_02 are to scale if the sleeve has room for them.

use std::f64::consts::PI;

use crate::design::Values;

/// Number of round holes in which an area of check-ring or return holes is drawn, evenly spaced around the cylinder.
pub const HOLES: f64 = 8.0;

/// Minimum space in the sleeve for piston, bumper and dead volumes \[m\].
const LEAST_ROOM: f64 = 12e-3;

/// Heights z above the tip of the nose and distances from the axis \[m\].
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    /// Upper side of the barrel's floor.
    pub floor: f64,
    /// Upper end of the cylinder sleeve, the seat of the head valve.
    pub seat: f64,
    /// Upper side of the barrel's roof, where the cap begins.
    pub roof: f64,
    /// Top of the cap.
    pub top: f64,
    /// Radius of the bore.
    pub bore: f64,
    /// Inner and outer radius of the barrel.
    pub barrel: [f64; 2],
    /// Upper and lower side of the piston at its upper stop.
    pub piston: [f64; 2],
    /// Upper side of the bumper.
    pub bumper: f64,
    /// Outer radius of the bumper: the space around it has the volume V_02.
    pub bumper_radius: f64,
    /// Tip of the rod with the piston at its upper stop.
    pub rod_tip: f64,
    /// Diameter of one check-ring hole of [`HOLES`], and height of its upper edge.
    pub check_hole: [f64; 2],
    /// Diameter of one return hole of [`HOLES`], and height of its lower edge.
    pub return_hole: [f64; 2],
    /// Head valve.
    pub valve: ValveLayout,
    /// Right end of the handle.
    pub handle_end: f64,
    /// Radius of the hole of the hose fitting, with the area A_sup.
    pub hose: f64,
    /// Height of the axis of the exhaust hole that the section shows.
    pub exhaust: f64,
    /// The trigger channel from the volume above the head valve to the trigger valve.
    pub channel: [[f64; 2]; 3],
}

/// The head valve on its seat: heights above the seat and distances from the axis \[m\].
///
/// A ring slides on the exhaust tube. A skirt outside the seat overlaps the cylinder by the intake's lap. Its lower lip
/// closes on a plug below the tube when the ring has risen by the exhaust's lap.
#[derive(Debug, Clone, PartialEq)]
pub struct ValveLayout {
    /// Inner, seat and outer radius of the ring.
    pub inner: f64,
    /// Radius of the seat.
    pub seat: f64,
    /// Outer radius.
    pub outer: f64,
    /// Radius of the plug, the seat of the exhaust.
    pub plug: f64,
    /// Height of the ring.
    pub height: f64,
    /// Height of the lip.
    pub lip: f64,
    /// Radius of the recess above the lip, through which the exhaust flows around the plug, and its upper end.
    pub recess: [f64; 2],
    /// Lower edge of the plug, where it seals, and its upper side.
    pub plug_levels: [f64; 2],
    /// Lower end of the exhaust tube.
    pub tube: f64,
    /// Bore of the exhaust tube.
    pub tube_bore: f64,
    /// Underside of the cap that stops the ring.
    pub stop: f64,
    /// Lower end of the cylinder around the ring.
    pub guide: f64,
    /// Radius of the supply space around the ring, and its lower end.
    pub jacket: [f64; 2],
    /// Height of the collar of the cylinder within the skirt.
    pub collar: f64,
    /// Inner and outer radius of the pocket of the closing spring in the ring.
    pub pocket: [f64; 2],
    /// Bottom of that pocket.
    pub pocket_floor: f64,
}

impl ValveLayout {
    fn new(v: &Values, barrel: [f64; 2], room: f64) -> Self {
        let valve = &v.head_valve;
        let [inner, seat, outer, plug] = [
            valve.inner_diameter,
            valve.seat_diameter,
            valve.outer_diameter,
            valve.exhaust_seat_diameter,
        ]
        .map(|diameter| 0.5 * diameter);
        let wall = outer - inner;
        let height = (1.9 * wall)
            .max(4.0 * valve.exhaust_lap + 6e-3)
            .min((room - valve.lift).max(6e-3));
        let lip = 0.2 * height;
        let plug_low = lip + valve.exhaust_lap;
        let plug_high = plug_low + 0.11 * height;
        let tube = plug_high + 0.14 * height;
        let collar = valve.intake_lap + 2e-3;
        Self {
            inner,
            seat,
            outer,
            plug,
            height,
            lip,
            recess: [(inner + 0.35 * wall).max(plug + 0.1 * wall), tube + 0.04 * height],
            plug_levels: [plug_low, plug_high],
            tube,
            tube_bore: inner - 0.28 * wall.min(inner),
            stop: height + valve.lift,
            guide: 0.5 * height,
            jacket: [barrel[0].max((outer + 1.5e-3).min(barrel[1] - 0.8e-3)), -collar],
            collar,
            pocket: [inner + 0.5 * wall, inner + 0.8 * wall],
            pocket_floor: 0.72 * height,
        }
    }
}

impl Layout {
    /// The layout of a design.
    pub fn new(v: &Values) -> Self {
        let b = &v.body;
        let bore = 0.5 * v.piston.bore;
        let floor = b.nose_height + b.barrel_wall;
        let seat = floor + b.sleeve_height;
        let roof = b.nose_height + b.barrel_height;
        let outer = b.barrel_radius(bore);
        let barrel = [outer - b.barrel_wall, outer];
        // Room for piston, bumper and dead volumes. If the stroke leaves none, the piston is drawn through the floor.
        let room = (b.sleeve_height - v.piston.stroke).max(LEAST_ROOM);
        let above = (v.chambers.above_piston / v.piston.area()).min(0.35 * room);
        let thickness = (0.45 * (room - above)).clamp(3e-3, 25e-3);
        let piston = [seat - above, seat - above - thickness];
        let bumper = piston[1] - v.piston.stroke;
        let free = v.chambers.below_piston / (PI * (bumper - floor).max(1e-3));
        let bumper_radius = (bore * bore - free).max(0.2 * bore * bore).sqrt();
        let hole = |area: f64| (4.0 * area / (PI * HOLES)).sqrt();
        let valve = ValveLayout::new(v, barrel, roof - b.barrel_wall - seat);
        let handle_end = outer - 4e-3 + b.handle_length;
        // The channel runs from above the ring to the trigger valve below the handle. It has the length of its key if
        // the trigger valve is then on the handle.
        let start = [0.5 * (valve.inner + valve.outer), seat + valve.stop];
        let level = (b.handle_level + b.handle_radius - 0.5 * b.handle_wall).max(start[1] + 1e-3);
        let valve_level = b.handle_level - b.handle_radius;
        let along = v.trigger.channel_length - (level - start[1]) - (level - valve_level);
        let reach = [outer + 14e-3, handle_end - 20e-3];
        let across = (start[0] + along).clamp(reach[0].min(reach[1]), reach[1]);
        let channel = [[start[0], level], [across, level], [across, valve_level]];
        Self {
            floor,
            seat,
            roof,
            top: roof + b.cap_height,
            bore,
            barrel,
            piston,
            bumper,
            bumper_radius,
            rod_tip: v.piston.stroke - v.piston.rod_protrusion,
            check_hole: [
                hole(v.chambers.check_hole_area),
                piston[0] - v.chambers.check_hole_position,
            ],
            return_hole: [hole(v.chambers.return_hole_area), floor + 1e-3],
            valve,
            handle_end,
            hose: (v.supply.hose_area / PI).sqrt(),
            exhaust: roof + 0.5 * b.cap_height,
            channel,
        }
    }

    /// Length of the trigger channel as drawn \[m\].
    pub fn channel_length(&self) -> f64 {
        let [a, b, c] = self.channel;
        (a[1] - (self.seat + self.valve.stop)) + (b[0] - a[0]) + (b[1] - c[1])
    }
}
