//! External faults during a command: full disks and outputs, signals, a cache that cannot be written, odd names.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{ROOT, SMALL, command, folder, messages, nailnoise, over};

/// Every file in a folder, with its contents.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    found
}

/// The command with a limit on the blocks of a file, each of 512 or 1024 bytes: writing more fails, like on a full
/// disk.
fn limited(blocks: u32, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_nailnoise");
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut limited = command(&[]);
    let environment: Vec<_> = limited
        .get_envs()
        .filter_map(|(name, value)| Some((name.to_owned(), value?.to_owned())))
        .collect();
    limited = Command::new("sh");
    limited.args(["-c", &script, program]).args(arguments);
    limited.current_dir(ROOT).envs(environment).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A command that stops in the middle of its files leaves all of the old ones, and nothing else.
#[track_caller]
fn leaves_the_folder_as_it_was(out: &Path, blocks: u32, arguments: &[&str]) {
    let before = files(out);
    let output = limited(blocks, arguments);
    let told = messages(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("cannot write") && told.contains("help"), "{told}");
    assert!(files(out) == before, "{arguments:?} changed the folder");
}

#[test]
fn a_full_disk_leaves_the_older_result_of_a_run() {
    let folder = folder("full-run");
    let (out, other) = (
        folder.join("out"),
        over(&folder, "other", "supply.pressure = \"95 psig\""),
    );
    let arguments = ["run", SMALL, "--out", text(&out)];
    // With the result in the cache only the files that differ are written.
    assert!(nailnoise(&arguments).status.success());
    assert!(nailnoise(&["run", &other, "--out", text(&out)]).status.success());
    for blocks in [0, 8, 64, 512] {
        leaves_the_folder_as_it_was(&out, blocks, &arguments);
    }
    // Without it all files are.
    let arguments = ["run", SMALL, "--no-cache", "--out", text(&out)];
    leaves_the_folder_as_it_was(&out, 64, &arguments);
}

#[test]
fn a_full_disk_leaves_the_older_files_of_a_cycle() {
    let folder = folder("full-cycle");
    let (out, other) = (
        folder.join("out"),
        over(&folder, "other", "supply.pressure = \"95 psig\""),
    );
    assert!(
        nailnoise(&["cycle", &other, "--figures", "--out", text(&out)])
            .status
            .success()
    );
    for blocks in [0, 8, 64, 512] {
        leaves_the_folder_as_it_was(&out, blocks, &["cycle", SMALL, "--figures", "--out", text(&out)]);
    }
}

#[test]
fn a_full_disk_leaves_the_older_files_of_modes_and_meshes() {
    let folder = folder("full-modes");
    let out = folder.join("out");
    let modes = ["modes", SMALL, "--body", "workpiece", "--out", text(&out)];
    assert!(nailnoise(&modes).status.success());
    leaves_the_folder_as_it_was(&out, 8, &[&modes[..], &["--uff"]].concat());
    let mesh = out.join("block.msh");
    let mesh = ["mesh", SMALL, "--body", "workpiece", "--write", text(&mesh)];
    assert!(nailnoise(&mesh).status.success());
    leaves_the_folder_as_it_was(&out, 8, &[&mesh[..], &["--format", "text22"]].concat());
}

#[test]
fn a_full_disk_leaves_the_older_files_of_laws() {
    let out = folder("full-prf");
    let laws = |wood| {
        [
            "prf",
            "law",
            "--law",
            "smooth",
            "--wood",
            wood,
            "--nail",
            "8d",
            "--out",
            text(&out),
        ]
    };
    assert!(nailnoise(&laws("pine")).status.success());
    leaves_the_folder_as_it_was(&out, 4, &laws("poplar plywood"));
}

/// A device that takes nothing.
fn full() -> Stdio {
    Stdio::from(File::options().write(true).open("/dev/full").unwrap())
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_reported() {
    let out = folder("full-output");
    let init = folder("full-output-init").join("new.toml");
    let law = ["prf", "law", "--constant", "1 kN", "--nail", "8d"];
    for arguments in [
        &["run", SMALL, "--json"][..],
        &["run", SMALL],
        &["cycle", SMALL, "--json"],
        &["cycle", SMALL],
        &["modes", SMALL, "--body", "workpiece"],
        &law,
    ] {
        expect_refusal(&[arguments, &["--out", text(&out)]].concat());
    }
    for arguments in [
        &["schema"][..],
        &["schema", "--of", "result"],
        &["completions", "zsh"],
        &["check", SMALL],
        &["check", SMALL, "--body", "workpiece", "--json"],
        &["mesh", SMALL, "--body", "workpiece"],
        &["prf", "law", "--list"],
        &["prf", "law", "--list", "--json"],
        &["cache"],
        &["cache", "--json"],
        &["init", text(&init)],
        &["--help"],
        &["--version"],
    ] {
        expect_refusal(arguments);
    }
}

#[track_caller]
fn expect_refusal(arguments: &[&str]) {
    let output = command(arguments).stdout(full()).output().unwrap();
    let told = messages(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    assert!(
        told.contains("cannot write to standard output"),
        "{arguments:?}: {told}"
    );
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let mut child = command(&["schema"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), messages(&output).as_str()), (Some(0), ""));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_error_stops_nothing() {
    let out = folder("full-error");
    let arguments = ["cycle", SMALL, "--json", "--out", text(&out)];
    let output = command(&arguments).stderr(full()).output().unwrap();
    assert!(output.status.success());
    assert!(serde_json::from_slice::<serde_json::Value>(&output.stdout).is_ok());
}

/// A design whose tool body gmsh must mesh.
fn to_mesh(folder: &Path) -> String {
    let file = folder.join("longer.toml");
    let base = Path::new(ROOT).join("designs/n80cb.toml");
    fs::write(&file, format!("base = {base:?}\nbody.handle_length = \"171 mm\"\n")).unwrap();
    text(&file).to_owned()
}

/// A program in place of gmsh that works for a minute, and the process that waits for it.
struct Meshing {
    folder: PathBuf,
    design: String,
    process: Child,
    gmsh: String,
}

impl Meshing {
    fn start(name: &str) -> Self {
        let folder = folder(name);
        let (program, number) = (folder.join("gmsh"), folder.join("number"));
        let script = format!(
            "#!/bin/sh\necho $$ > {0}.new\nmv {0}.new {0}\nexec sleep 60\n",
            text(&number)
        );
        fs::write(&program, script).unwrap();
        fs::set_permissions(&program, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
        fs::create_dir(folder.join("tmp")).unwrap();
        let design = to_mesh(&folder);
        let process = Self::command(&folder, &design, &program).spawn().unwrap();
        assert!(
            within(Duration::from_secs(20), || number.exists()),
            "gmsh is not started"
        );
        let gmsh = fs::read_to_string(&number).unwrap().trim().to_owned();
        Self {
            folder,
            design,
            process,
            gmsh,
        }
    }

    fn command(folder: &Path, design: &str, program: &Path) -> Command {
        let mut command = command(&["mesh", design, "--body", "tool"]);
        command.env("NAILNOISE_GMSH", program).env("TMPDIR", folder.join("tmp"));
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    fn send(&self, signal: &str) {
        let number = self.process.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &number]).status().unwrap();
        assert!(sent.success());
    }

    fn gmsh_ends(&self) -> bool {
        let alive = || {
            Command::new("kill")
                .args(["-0", &self.gmsh])
                .stderr(Stdio::null())
                .status()
                .unwrap()
                .success()
        };
        within(Duration::from_secs(1), || !alive())
    }

    /// Present or former working folders of gmsh.
    fn folders(&self) -> usize {
        fs::read_dir(self.folder.join("tmp")).unwrap().count()
    }
}

fn within(time: Duration, done: impl Fn() -> bool) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < time {
        if done() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    done()
}

#[test]
fn gmsh_ends_with_a_killed_command_and_its_folder_with_the_next() {
    let mut meshing = Meshing::start("killed-gmsh");
    meshing.send("KILL");
    meshing.process.wait().unwrap();
    assert!(meshing.gmsh_ends(), "gmsh works on");
    assert_eq!(meshing.folders(), 1);
    let quick = meshing.folder.join("no-gmsh");
    let next = Meshing::command(&meshing.folder, &meshing.design, &quick)
        .status()
        .unwrap();
    assert_eq!(next.code(), Some(2));
    assert_eq!(meshing.folders(), 0);
}

#[test]
fn every_request_to_end_ends_a_command_like_ctrl_c() {
    for signal in ["INT", "TERM", "HUP"] {
        let mut meshing = Meshing::start(&format!("ended-by-{signal}"));
        meshing.send(signal);
        assert_eq!(meshing.process.wait().unwrap().code(), Some(130), "{signal}");
        assert!(meshing.gmsh_ends(), "{signal}: gmsh works on");
        assert_eq!(meshing.folders(), 0, "{signal}");
    }
}

/// A program that replaces Python, has the package and works for a minute, or follows the script.
fn python(folder: &Path, works: &str) -> PathBuf {
    let program = folder.join("python");
    let number = folder.join("number");
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = -c ] && exit 0\necho $$ \"$@\" > {0}.new\nmv {0}.new {0}\n{works}\n",
        text(&number)
    );
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    program
}

const ON_CLUSTER: [&str; 6] = [
    "sweep",
    SMALL,
    "--vary",
    "exhaust.holes=3,5",
    "--scheduler",
    "tcp://127.0.0.1:1",
];

#[test]
fn python_ends_with_the_command_however_that_ends() {
    for (signal, status) in [
        ("INT", Some(130)),
        ("TERM", Some(130)),
        ("HUP", Some(130)),
        ("KILL", None),
    ] {
        let folder = folder(&format!("python-{signal}"));
        let program = python(&folder, "exec sleep 60");
        let mut sweep = command(&ON_CLUSTER).env("NAILNOISE_PYTHON", &program).spawn().unwrap();
        let number = folder.join("number");
        assert!(
            within(Duration::from_secs(20), || number.exists()),
            "python is not started"
        );
        let started = fs::read_to_string(&number).unwrap();
        let child = PathBuf::from("/proc").join(started.split_whitespace().next().unwrap());
        let own = sweep.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-s", signal, &own])
                .status()
                .unwrap()
                .success()
        );
        assert_eq!(sweep.wait().unwrap().code(), status, "{signal}");
        assert!(
            within(Duration::from_secs(2), || !child.exists()),
            "{signal}: python works on"
        );
    }
}

#[test]
fn a_python_that_is_killed_is_not_a_result() {
    let folder = folder("python-killed");
    for (works, status, told) in [
        ("exit 1", 2, "did not compute all of it"),
        ("kill -KILL $$", 3, "ended by signal 9"),
    ] {
        let program = python(&folder, works);
        let output = command(&ON_CLUSTER).env("NAILNOISE_PYTHON", &program).output().unwrap();
        assert_eq!(output.status.code(), Some(status), "{works}: {}", messages(&output));
        assert!(messages(&output).contains(told), "{works}: {}", messages(&output));
    }
}

/// The command under a limit of its shell.
fn under(limit: &str, arguments: &[&str], change: impl FnOnce(&mut Command)) -> Output {
    let script = format!("ulimit {limit} && exec \"$0\" \"$@\"");
    let mut limited = Command::new("sh");
    limited
        .args(["-c", &script, env!("CARGO_BIN_EXE_nailnoise")])
        .args(arguments);
    limited.current_dir(ROOT);
    change(&mut limited);
    limited.output().unwrap()
}

/// From a limit that prevents the command from starting to one that it does not meet.
#[test]
#[cfg(target_os = "linux")]
fn a_limit_of_the_address_space_ends_a_command_with_words_and_status_2_or_3() {
    let folder = folder("limit-memory");
    let (out, mut ended) = (folder.join("out"), 0);
    for gigabytes in [0.1, 0.15, 0.3, 0.6, 1.0, 1.5, 2.0, 4.0] {
        let limit = format!("-v {}", (gigabytes * 1024.0 * 1024.0) as u32);
        let arguments = ["modes", SMALL, "--body", "workpiece", "--no-cache", "--out", text(&out)];
        let output = under(&limit, &arguments, |_| ());
        let told = messages(&output);
        assert!(
            matches!(output.status.code(), Some(0 | 2 | 3)),
            "{gigabytes} GiB: {:?}: {told}",
            output.status
        );
        assert!(
            output.status.success() || told.contains("memory") || told.contains("thread"),
            "{told}"
        );
        assert!(!told.contains("has a fault"), "{told}");
        ended += usize::from(!output.status.success());
    }
    assert!(ended > 0, "no limit was met");
}

#[test]
fn a_file_that_would_exceed_its_limit_is_an_error_with_words() {
    let out = folder("limit-file");
    let output = under("-f 0", &["cycle", SMALL, "--out", text(&out)], |_| ());
    let told = messages(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("cannot write"), "{told}");
}

#[test]
#[cfg(target_os = "linux")]
fn a_limit_of_processor_time_ends_a_command_with_words() {
    let out = folder("limit-time");
    let arguments = ["cycle", SMALL, "--draw", "60000", "--out", text(&out)];
    let output = under("-S -t 1", &arguments, |_| ());
    let told = messages(&output);
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("processor time"), "{told}");
}

#[test]
fn a_number_of_threads_that_cannot_be_is_refused() {
    for number in ["100000", "-1", "many"] {
        let output = command(&["cycle", SMALL, "--json"])
            .env("RAYON_NUM_THREADS", number)
            .output()
            .unwrap();
        let told = messages(&output);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains("RAYON_NUM_THREADS"), "{told}");
    }
}

/// A design with this file name that changes nothing.
fn named(folder: &Path, name: &str) -> PathBuf {
    let file = folder.join(name);
    let base = Path::new(ROOT).join(SMALL);
    fs::write(&file, format!("base = {base:?}\n")).unwrap();
    file
}

#[test]
fn a_design_cannot_be_named_after_a_folder_above() {
    let folder = folder("names");
    let here = folder.join("here");
    fs::create_dir(&here).unwrap();
    for name in ["...toml", "..toml"] {
        let design = named(&folder, name);
        for arguments in [&["run"][..], &["cycle"], &["compare", text(&design)]] {
            let output = command(&[arguments, &[text(&design)]].concat())
                .current_dir(&here)
                .output()
                .unwrap();
            let told = messages(&output).replace("\n  | ", " ");
            assert_eq!(output.status.code(), Some(2), "{told}");
            let expected = "cannot be the name of a folder";
            assert!(told.contains(expected) && told.contains("--out DIR"), "{told}");
        }
        assert_eq!(files(&here).len(), 0);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "a file outside");
        // With a separate folder it is a design like any other.
        let out = here.join("out");
        assert!(
            nailnoise(&["cycle", text(&design), "--out", text(&out)])
                .status
                .success()
        );
        fs::remove_file(design).unwrap();
        fs::remove_dir_all(&out).unwrap();
    }
}
