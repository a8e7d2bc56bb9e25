//! Random texts of assemblies that are valid by grammar.

use std::fmt::Write as _;

/// Linear congruential generator (Knuth, MMIX).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5851_F42D_4C95_7F2D);
        random.below(2);
        random
    }

    /// A whole number from 0 to `most` - 1.
    pub(crate) fn below(&mut self, most: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % most.max(1)
    }

    /// A number from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(10_001) as f64 / 10_000.0
    }

    pub(crate) fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }
}

/// The first of the seeds of a test: 0, or the number in `NAILNOISE_SEED`, for runs with further assemblies.
pub(crate) fn first_seed() -> u64 {
    let given = std::env::var("NAILNOISE_SEED").ok();
    given.and_then(|text| text.parse().ok()).unwrap_or(0)
}

/// The text of a random assembly: volumes (none in one of six texts), bodies with balanced faces, passages of all kinds
/// with their options, contacts, springs, friction, triggers and events; formulas over a key; blocks that an `if`
/// switches; a fastener with a blow; gravity, a motor, a latch that follows a word, a jet, a sensor and an outcome.
pub(crate) fn random_assembly(random: &mut Random) -> String {
    let (volumes, bodies) = (random.below(6), random.below(4));
    let mut text = String::from(
        "[cycle]\nassembly = { name = \"random\", schema = 1 }\ngas = { constant = \"287.05 J/(kg K)\", ratio = 1.4 }\n\
         end = \"20 ms\"\n[cycle.let]\nPa = \"101.325 kPa\"\nbore = \"20 mm\"\n\
         [cycle.reservoir]\natmosphere = { pressure = \"=Pa\", temperature = \"20 degC\" }\n\
         hose = { pressure = \"=6*Pa\", temperature = \"20 degC\" }\n\
         [cycle.trigger.pulled]\nstarts = false\nschedule = [[\"2 ms\", true], [\"9 ms\", false]]\n",
    );
    let line = |text: &str, out: &mut String| {
        out.push_str(text);
        out.push('\n');
    };
    for volume in 0..volumes {
        let (dead, pressure) = (random.between(5.0, 500.0), random.between(1.0, 8.0));
        line(
            &format!("[cycle.volume.v{volume}]\ndead = \"{dead:.3} cm3\"\npressure = \"={pressure:.3}*Pa\""),
            &mut text,
        );
        if random.chance(40) {
            line("wall = { area = \"60 cm2\", transfer = \"200 W/(m2 K)\" }", &mut text);
        } else if random.chance(20) {
            line("isothermal = true", &mut text);
        }
    }
    for body in 0..bodies {
        let mass = random.between(20.0, 2000.0);
        line(&format!("[cycle.body.b{body}]\nmass = \"{mass:.3} g\""), &mut text);
        if body > 0 && random.chance(50) {
            line(&format!("parent = \"b{}\"", random.below(body)), &mut text);
        }
        let stroke = random.between(5.0, 80.0);
        let area = random.between(50.0, 900.0);
        if volumes > 0 {
            let volume = random.below(volumes);
            line(
                &format!(
                    "[cycle.face.top{body}]\nvolume = \"v{volume}\"\nbody = \"b{body}\"\npush = \"down\"\n\
                     area = \"{area:.3} mm2\"\n[cycle.face.bottom{body}]\nvolume = \"atmosphere\"\n\
                     body = \"b{body}\"\npush = \"up\"\narea = \"{area:.3} mm2\""
                ),
                &mut text,
            );
        }
        line(
            &format!(
                "[cycle.contact.below{body}]\non = \"b{body}\"\nstop = \"below\"\nat = \"{stroke:.3} mm\"\n\
                 stiffness = \"1 kN/mm\"\ndamping_ratio = 0.2\n\
                 [cycle.contact.above{body}]\non = \"b{body}\"\nstop = \"above\"\nstiffness = \"1 kN/mm\"\n\
                 damping = \"100 N s/m\""
            ),
            &mut text,
        );
        if random.chance(50) {
            line(
                &format!(
                    "[cycle.spring.return{body}]\non = \"b{body}\"\npush = \"up\"\nstiffness = \"1 N/mm\"\n\
                     preload = \"{:.3} mm\"",
                    random.between(0.0, 20.0)
                ),
                &mut text,
            );
        }
        if random.chance(50) {
            line(
                &format!("[cycle.friction.seal{body}]\non = \"b{body}\"\nstatic = \"6 N\"\nsliding = \"4 N\""),
                &mut text,
            );
        }
        if random.chance(30) {
            line(
                &format!("[cycle.force.push{body}]\non = \"b{body}\"\nforce = \"30 N\""),
                &mut text,
            );
        }
    }
    for volume in 0..volumes {
        let other = match random.below(3) {
            0 if volume > 0 => format!("v{}", random.below(volume)),
            1 => "hose".to_owned(),
            _ => "atmosphere".to_owned(),
        };
        let area = random.between(2.0, 100.0);
        let opens = match random.below(6) {
            0 if bodies > 0 => format!(
                "seat = {{ body = \"b{}\", opens = \"down\", at = \"1 mm\", diameter = \"=bore\", angle = \"45 deg\", \
                 cone = \"widens\" }}",
                random.below(bodies)
            ),
            1 if bodies > 0 => format!(
                "holes = {{ body = \"b{}\", opens = \"down\", at = \"3 mm\", area = \"{area:.3} mm2\" }}",
                random.below(bodies)
            ),
            2 => format!("ramp = {{ area = \"{area:.3} mm2\", time = \"1 ms\" }}"),
            3 => "pipe = { length = \"100 mm\", diameter = \"6 mm\" }".to_owned(),
            4 => format!(
                "series = [{{ name = \"first\", area = \"{area:.3} mm2\" }}, {{ name = \"last\", area \
                 = \"=disc(bore/4)\" }}]"
            ),
            _ => format!("area = \"{area:.3} mm2\""),
        };
        line(
            &format!("[cycle.passage.p{volume}]\nbetween = [\"v{volume}\", \"{other}\"]\n{opens}"),
            &mut text,
        );
        for (percent, field) in [
            (60, "coefficient = 0.82"),
            (20, "one_way = true"),
            (20, "open = { when = \"pulled\", delay = \"0.3 ms\" }"),
        ] {
            if random.chance(percent) {
                line(field, &mut text);
            }
        }
        if other == "atmosphere" {
            if random.chance(50) {
                line("silent = true", &mut text);
            } else {
                let is_constant = ["pipe", "series", "area"].iter().any(|kind| opens.starts_with(kind));
                let diameter = if is_constant { "" } else { "\ndiameter = \"4 mm\"" };
                let opening = format!("[cycle.opening.o{volume}]\npassage = \"p{volume}\"\ncount = 2{diameter}");
                line(&opening, &mut text);
            }
        }
    }
    text.push_str("[cycle.event]\nt0 = { at = \"0 s\" }\n");
    if volumes > 0 {
        let _ = writeln!(text, "empty = {{ becomes = \"v0.pressure < 1.1*Pa\", after = \"t0\" }}");
    }
    if bodies > 0 {
        let _ = writeln!(
            text,
            "moves = {{ becomes = \"b0.travel > 1 mm and b0.speed > 0\", after = \"t0\" }}"
        );
        let _ = writeln!(text, "strikes = {{ becomes = \"below0 closes\" }}");
    }
    let _ = write!(
        text,
        "[keys.own]\ncount = {{ domain = \"0 .. 10\", text = \"number of holes\" }}\n[own]\ncount = {}\n",
        1 + random.below(10)
    );
    if volumes > 0 {
        text.push_str(&switched_passage(random));
    }
    if bodies > 0 && random.chance(60) {
        text.push_str(&fastener(random));
    }
    if bodies > 0 && random.chance(70) {
        text.push_str(&mechanisms(random, bodies, volumes));
    }
    if random.chance(50) {
        text = text.replacen("end = ", "gravity = \"9.81 m/s2\"\nend = ", 1);
    }
    text
}

/// A motor, a latch, a jet and laws of contacts, springs and friction on some of the bodies.
fn mechanisms(random: &mut Random, bodies: usize, volumes: usize) -> String {
    let (body, other) = (random.below(bodies), random.below(bodies));
    let mut text = format!(
        "[cycle.sensor]\nheight = {{ is = \"b{body}.travel + 1 mm\", unit = \"m\" }}\n\
         [cycle.outcome]\nstruck = \"strikes\"\nheld = \"held.on > 0\"\n"
    );
    let mut words = vec![
        format!("below{body} closes"),
        format!("above{other} opens"),
        format!("b{other} reverses"),
    ];
    if volumes > 0 {
        words.extend(["choked", "unchoked", "reverses"].map(|word| format!("p{} {word}", random.below(volumes))));
    }
    let set = &words[random.below(words.len())];
    let clear = ["", "clear = \"above0 closes\"\n", "schedule = [[\"4 ms\", true]]\n"][random.below(3)];
    let _ = write!(
        text,
        "[cycle.trigger.held]\nset = \"{set}\"\n{clear}\
         [cycle.hold.latch]\non = \"b{body}\"\nstiffness = \"{:.3} kN/mm\"\nwhile = \"held\"\n",
        random.between(0.1, 5.0)
    );
    if random.chance(50) {
        let while_ = ["pulled", "held"][random.below(2)];
        let _ = write!(
            text,
            "[cycle.motor.drive]\non = \"b{other}\"\npush = \"up\"\nstall = \"200 N\"\nfree_speed = \"4 m/s\"\n\
             while = \"{while_}\"\n"
        );
    }
    let laws = [
        "[cycle.contact.pad]\nacts = { on = \"bB\", stop = \"below\", at = \"4 mm\", stiffness = 3e7, exponent = 1.5, \
         hysteresis = \"0.3 s/m\" }\n",
        "[cycle.contact.glue]\nacts = { on = \"bB\", stop = \"below\", at = \"3 mm\", stiffness = \"50 N/mm\", \
         damping_ratio = 0.1, may_pull = true }\n",
        "[cycle.spring.coil]\nacts = { on = \"bB\", push = \"up\", polynomial = [2, 400, 3e4] }\n",
        "[cycle.friction.brake]\non = \"bB\"\nstatic = \"20 N\"\nsliding = \"12 N\"\n\
         stick = { stiffness = \"1 kN/mm\", damping = \"10 N s/m\" }\n",
        "[cycle.force.ramp]\non = \"bB\"\ntable = [[\"0 s\", \"0 N\"], [\"3 ms\", \"60 N\"], [\"9 ms\", \"0 N\"]]\n",
    ];
    for law in laws {
        if random.chance(40) {
            text.push_str(&law.replace("bB", &format!("b{}", random.below(bodies))));
        }
    }
    if volumes > 0 {
        let _ = write!(
            text,
            "[cycle.force.jet]\non = \"b{other}\"\njet = \"switched\"\nshare = 0.5\n\
             if = \"own.count > 3 and not own.count > 8\"\n"
        );
    }
    text
}

/// A passage with options that the key may switch off.
fn switched_passage(random: &mut Random) -> String {
    let mut text = String::from(
        "[cycle.passage.switched]\nif = \"own.count > 3 and not own.count > 8\"\nbetween = [\"v0\", \"atmosphere\"]\n\
         silent = true\narea = \"=if(own.count > 5, disc(bore/8), max(2 mm2, disc(own.count*0.2 mm)))\"\n",
    );
    let options = [
        "law = { kind = \"iso6358\", critical_ratio = 0.35 }",
        "coefficient = { ratio_polynomial = [1.1, -0.71, 0.49, -0.14], from = 0.39, to = 0.91 }",
        "coefficient = \"=exp(-0.1*own.count)\"",
        "one_way = \"=own.count > 6\"",
    ];
    text.push_str(options[random.below(options.len())]);
    text.push('\n');
    let opens = [
        "",
        "open = { when = \"not pulled\", delay = \"0.2 ms\", before = true }\n",
        "open = { when = \"pulled\", delay = \"=own.count*0.1 ms\", delays = \"flow\" }\n",
        "open = { when = \"pulled\", delay = \"0.3 ms\", delays = \"flow\", leaves = \"undelayed\" }\n",
    ];
    text.push_str(opens[random.below(opens.len())]);
    text
}

/// A fastener that the first body drives into the ground, with a blow that the key may switch off.
fn fastener(random: &mut Random) -> String {
    let laws = [
        "kind = \"constant\", force = \"150 N\"",
        "kind = \"table\", points = [[\"0 mm\", \"0 N\"], [\"2 mm\", \"120 N\"], [\"5 mm\", \"300 N\"]]",
        "kind = \"solid_wood\", hardness = \"40 N/mm\", offset = 0.1",
        "kind = \"wood\", resistance = \"solid_wood\", density = \"500 kg/m3\", hardness = \"40 N/mm\", \
         diameter = \"1 mm\", \
         head_diameter = \"2 mm\"",
    ];
    let mut text = format!(
        "[cycle.fastener.nail]\nplace = {{ driver = \"b0\", into = \"ground\", head_at = \"1 mm\", \
         tip_at = \"1.2 mm\" }}\n\
         item = {{ length = \"3 mm\", mass = \"{:.3} g\" }}\nlaw = {{ {} }}\n\
         seated = {{ head_stiffness = \"200 N/mm\", unloading = \"2 kN/mm\" }}\n",
        random.between(0.05, 2.0),
        laws[random.below(laws.len())]
    );
    if random.chance(70) {
        let condition = ["", "if = \"own.count > 5\"\n"][random.below(2)];
        let _ = write!(
            text,
            "[cycle.blow.nail]\n{condition}rod = {{ length = \"{:.3} mm\", area = \"=disc(bore/5)\", \
             modulus = \"207 GPa\", \
             density = \"7850 kg/m3\" }}\nshank = {{ diameter = \"1 mm\", head_diameter = \"2 mm\", legs = {} }}\n\
             wood = {{ density = \"500 kg/m3\", shear_speed = \"900 m/s\" }}\n",
            random.between(10.0, 150.0),
            1 + random.below(2)
        );
    }
    text
}
