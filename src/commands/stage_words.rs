//! Stages of a computation in the words of a user, for progress.

/// The description of a stage for users; the name of a stage without one.
pub(super) fn in_words(stage: &str) -> &str {
    match stage {
        "analysis of a source" => "spectra of a source",
        "body" => "a body with its materials and surfaces",
        "checks of the coupling" | "checks of the response" | "checks of the tool" => "checking the vibration",
        "end of the records" => "when the sound has died away",
        "energy of a source" => "sound energy of a source",
        "fields of the bodies" => "films of the bodies",
        "fit of surface velocities" => "motion of the surfaces, fitted for their sound",
        "fluid loading" => "how the air loads the surfaces",
        "inputs of the outcome" => "which inputs change how the shot ends",
        "levels of a draw" => "levels of drawn designs",
        "load vectors" => "where the forces act on the bodies",
        "materials and attachments" => "materials and joints of a body",
        "mesh" => "mesh of a body",
        "modal spectra" => "vibration of a body over frequency",
        "modes" => "vibration modes of a body",
        "motion of the coupled response" => "motion of workpiece and tool together",
        "motion in bands" => "vibration of the bodies in bands",
        "nailing cycle of the coupled response" | "nailing cycle with workpiece and support" => {
            "nailing cycle on the moving workpiece"
        }
        "noise of the outflow" => "noise of the exhaust air",
        "order of elimination" => "preparing the equations of a body",
        "other starts" => "the shot at other moments of the support",
        "outcomes of shots" => "how drawn shots end",
        "pictures of the bodies" => "pictures of the moving surfaces",
        "pressure from reference structures" | "radiation from reference structures" => {
            "sound of a structure, from similar ones"
        }
        "pressure on the surface" => "sound pressure on the surfaces",
        "radiation at the microphones" => "sound from the surfaces to the microphones",
        "radiation in the ambient air" | "radiation of the tool in the ambient air" => "sound radiated into the air",
        "radiation matrix" => "how well the surfaces radiate",
        "radiation of the tool" => "how well the tool's body radiates",
        "radiation of the tool's cap" => "how well the tool's cap radiates",
        "radiation of the workpiece" => "how well the workpiece radiates",
        "radiation of the workpiece in a plane" => "how well the workpiece in the sand radiates",
        "radiation of workpiece and worktable" => "how well workpiece and worktable radiate",
        "requirements of a body" => "whether a body can be used",
        "response of the tool" => "vibration of the tool in the shot",
        "response of workpiece and support" => "vibration of workpiece and support in the shot",
        "response with the complete impedance of the air" => "vibration of the tool with the mass of the air",
        "sensor modes" => "modes at the sensors",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::in_words;

    #[test]
    fn terms_of_the_method_are_in_plain_words_and_known_names_stay() {
        for (stage, words) in [
            ("order of elimination", "preparing the equations of a body"),
            ("load vectors", "where the forces act on the bodies"),
            ("nailing cycle", "nailing cycle"),
            ("writing files", "writing files"),
        ] {
            assert_eq!(in_words(stage), words);
        }
    }

    /// A name that a stage no longer has would be a translation of nothing.
    #[test]
    fn every_name_is_that_of_a_stage() {
        let mut sources = String::new();
        let mut open = vec![std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/src"))];
        while let Some(folder) = open.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                match path.is_dir() {
                    true => open.push(path),
                    false if path.ends_with("stage_words.rs") => {}
                    false => sources.push_str(&std::fs::read_to_string(path).unwrap_or_default()),
                }
            }
        }
        let own = include_str!("stage_words.rs");
        let (table, _) = own.split_once("other => other").unwrap();
        let names = table.lines().filter(|line| line.contains("=>")).flat_map(|line| {
            let (names, _) = line.split_once("=>").unwrap();
            names
                .split(" | ")
                .map(|name| name.trim().trim_matches('"').to_owned())
                .collect::<Vec<_>>()
        });
        let mut count = 0;
        for name in names {
            assert!(
                sources.contains(&format!("const NAME: &'static str = \"{name}\"")),
                "no stage \"{name}\""
            );
            count += 1;
        }
        assert!(count > 35, "{count} names");
    }
}
