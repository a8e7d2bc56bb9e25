"""Ends runs at random moments, by KILL or TERM, and checks the files they leave behind.

    kill.py NAILNOISE DESIGN [KILLS] [SEED]

After every end, each file in the output folder must be readable, a folder with result.json must be complete, and no
entry of the cache may be damaged. The kills alternate between three cases: everything is computed; only the cycle is
computed, with cached modes, into the folder of another design; nothing is computed, and cached files are restored into such
a folder. A kill falls at a random moment of such a run. Files are put in place within milliseconds at the end of a run, so
a random kill hardly ever falls there. In every second round, the script therefore watches the folder, waits for the first
file to change, and kills at a random moment while the files are put in place. At the end, an undisturbed run must give the
same digits as at the beginning. A study that is ended again and again must end with the files of one that was not, to the byte.
Where gmsh is installed, commands that it works for are ended, too: gmsh must end with them.
"""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def result(folder: Path) -> dict:
    """The result, timing aside."""
    found = json.loads((folder / "result.json").read_text())
    found.pop("timing")
    return found


def readable(folder: Path) -> int:
    """Reads every file that is in place and returns their number; fails on a truncated file."""
    files = [file for file in folder.rglob("*") if file.is_file() and ".unfinished-" not in str(file)]
    # A partly written file has a temporary name, and the next run ignores it.
    files = [file for file in files if not (file.name.startswith(".") and file.name.endswith(".tmp"))]
    for file in files:
        content = file.read_bytes()
        assert content, f"{file} is empty"
        if file.suffix == ".wav":
            assert int.from_bytes(content[4:8], "little") + 8 == len(content), f"{file} is cut off"
            continue
        if file.suffix == ".uff":
            # Dataset 58b is binary; the mark that closes the last dataset is text.
            assert content.rstrip().endswith(b"\n    -1"), f"{file} is cut off"
            continue
        text = content.decode()
        if file.suffix == ".json":
            json.loads(text)
        elif file.suffix in (".vtu", ".pvd"):
            ElementTree.fromstring(text)
        elif file.suffix == ".csv":
            rows = text.splitlines()
            assert text.endswith("\n") and len({row.count(",") for row in rows if '"' not in row}) == 1, file
        elif file.suffix == ".html":
            assert text.endswith("</html>"), file
    return len(files)


class Runs:
    """Runs of one design and of another, in separate folders."""

    def __init__(self, program: str, design: str) -> None:
        self.program, self.design = program, design
        self.work = Path(tempfile.mkdtemp(prefix="nailnoise-kill-"))
        self.out, self.cache = self.work / "out", self.work / "cache"
        self.other = self.work / "other.toml"
        self.other.write_text(f"base = {json.dumps(str(Path(design).resolve()))}\nsupply.pressure = \"95 psig\"\n")
        self.others: set[Path] = set()  # entries of the other design
        environment = dict(os.environ, NAILNOISE_CACHE=str(self.cache))
        self.quiet = dict(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)

    def command(self, design: str | Path) -> list[str]:
        return [self.program, "run", str(design), "--json", "--out", str(self.out)]

    def whole(self, design: str | Path) -> float:
        """Runs to the end; how long that took."""
        begin = time.monotonic()
        subprocess.run(self.command(design), check=True, **self.quiet)
        return time.monotonic() - begin

    def forget(self, *stages: str) -> None:
        """Removes the cached results of some stages of the design; of all stages and designs without any."""
        for entry in self.cache.glob("*.entry"):
            if not stages or (entry.name.startswith(stages) and entry not in self.others):
                entry.unlink()

    def prepare(self, kind: str) -> None:
        """Brings folder and cache to where a run of this kind begins."""
        if kind == "anew":
            self.forget()
            shutil.rmtree(self.out, ignore_errors=True)
            return
        if kind == "kept":
            self.whole(self.design)
        before = set(self.cache.glob("*.entry"))
        self.whole(self.other)  # its files are now in the folder
        self.others |= set(self.cache.glob("*.entry")) - before
        if kind == "cycle":
            self.forget("run-", "sound")

    def verify(self) -> None:
        subprocess.run([self.program, "cache", "verify"], check=True, **self.quiet)


KINDS = ("anew", "cycle", "kept")


def state(folder: Path) -> dict[str, tuple[int, int]]:
    """Every file that has its place, with what changes when another takes it."""
    found, folders = {}, [str(folder)]
    while folders:
        try:
            entries = list(os.scandir(folders.pop()))
        except FileNotFoundError:
            continue
        for entry in entries:
            if entry.name.startswith("."):
                continue
            if entry.is_dir():
                folders.append(entry.path)
            else:
                status = os.stat(entry.path, follow_symlinks=False)
                found[entry.path] = (status.st_ino, status.st_mtime_ns)
    return found


def changed(folder: Path, before: dict[str, tuple[int, int]]) -> bool:
    try:
        return state(folder) != before
    except FileNotFoundError:  # a file that has just been replaced
        return True


def placing(runs: "Runs", kind: str) -> float:
    """How long files take their places in a run of a kind, from the first change to the end."""
    runs.prepare(kind)
    before = state(runs.out)
    process = subprocess.Popen(runs.command(runs.design), **runs.quiet)
    while process.poll() is None and not changed(runs.out, before):
        pass
    begin = time.monotonic()
    process.wait()
    return time.monotonic() - begin


def strike(runs: "Runs", process: subprocess.Popen, moment: float | None, last: float, how: signal.Signals) -> bool:
    """Ends a run by a signal after a time or, without one, `last` seconds after the first file takes its place; whether it
    was at work."""
    before = state(runs.out)
    if moment is None:
        while process.poll() is None and not changed(runs.out, before):
            pass
        moment = last
    try:
        process.wait(timeout=moment)
        return False
    except subprocess.TimeoutExpired:
        end(process, how)
        return True


def end(process: subprocess.Popen, how: signal.Signals) -> None:
    """Ends a process by a signal; TERM must lead to status 130, unless the work was just done or the program had not yet
    installed its handler, when it had not begun either."""
    handled = handles(process.pid, signal.SIGTERM)
    process.send_signal(how)
    status = process.wait(timeout=20)
    allowed = (130, 0) if how == signal.SIGTERM and handled else (-how, 130, 0)
    assert status in allowed, f"status {status} after {how.name}"


def handles(pid: int, how: signal.Signals) -> bool:
    """Whether a process has installed a handler of a signal (proc_pid_status(5), `SigCgt`)."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:  # it has ended
        return False
    caught = next((int(line.split()[1], 16) for line in lines if line.startswith("SigCgt")), 0)
    return bool(caught >> (how - 1) & 1)


def end_studies(runs: "Runs", kills: int, chance: random.Random) -> None:
    """Ends one study again and again: its files are those of a study that was not ended, to the byte."""
    drawn = runs.work / "drawn.toml"
    outcomes = '["drives", "underdriven", "overdriven", "strikes_bumper"]'
    base = json.dumps(str(Path(runs.design).resolve()))
    drawn.write_text(f"base = {base}\n[study]\nscreening = 8\nrequire = {outcomes}\n")

    def study(name: str) -> tuple[list[str], dict]:
        command = [runs.program, "study", str(drawn), "-n", "16", "--out", str(runs.work / name)]
        return command, dict(runs.quiet, env=dict(runs.quiet["env"], NAILNOISE_CACHE=str(runs.work / f"{name}-cache")))

    def files(name: str) -> list[bytes]:
        return [(runs.work / name / "study" / file).read_bytes() for file in ("study.json", "draws.csv")]

    command, quiet = study("undisturbed")
    begin = time.monotonic()
    subprocess.run(command, check=True, **quiet)
    whole = time.monotonic() - begin
    command, quiet = study("ended")
    at_work = 0
    for _ in range(kills):
        process = subprocess.Popen(command, **quiet)
        try:
            # Later kills hit a study with many stored results.
            process.wait(timeout=chance.uniform(0.0, whole) * chance.random())
        except subprocess.TimeoutExpired:
            end(process, chance.choice((signal.SIGKILL, signal.SIGTERM)))
            at_work += 1
        subprocess.run([runs.program, "cache", "verify"], check=True, **quiet)
    subprocess.run(command, check=True, **quiet)
    assert files("ended") == files("undisturbed"), "a study that was ended has other files"
    left = list((runs.work / "ended" / "study").glob(".unfinished-*"))
    assert not left, f"left after the next study: {left}"
    print(f"{at_work} of {kills} studies ended at work within {whole:.1f} s; the same files to the byte")


def end_meshers(runs: "Runs", kills: int, chance: random.Random) -> None:
    """Ends commands while gmsh works for them: no gmsh goes on, and the next command leaves no folder of theirs."""
    folder = runs.work / "temporary"
    folder.mkdir()
    quiet = dict(runs.quiet, env=dict(runs.quiet["env"], TMPDIR=str(folder)))
    body = [runs.design, "--body", "tool", "--set", "body.barrel_wall=4 mm"]
    modes = [*body, "--set", "analysis.body_max_frequency=500 Hz", "--no-cache", "--out", str(runs.work / "modes")]
    commands = [[runs.program, "mesh", *body, "--size", "25 mm"], [runs.program, "modes", *modes]]
    begin = time.monotonic()
    subprocess.run(commands[0], check=True, **quiet)
    whole = time.monotonic() - begin
    for kill in range(kills):
        command = commands[kill % 2]
        process = subprocess.Popen(command, **quiet)
        try:
            process.wait(timeout=chance.uniform(0.0, whole))
        except subprocess.TimeoutExpired:
            end(process, chance.choice((signal.SIGKILL, signal.SIGTERM)))
        deadline = time.monotonic() + 2.0
        while working := [pid for pid in Path("/proc").glob("[0-9]*") if works_in(pid, folder)]:
            assert time.monotonic() < deadline, f"still at work for a command that has ended: {working}"
            time.sleep(0.02)
    subprocess.run(commands[0], check=True, **quiet)
    left = list(folder.iterdir())
    assert not left, f"left after the next command: {left}"
    print(f"{kills} commands ended within {whole:.1f} s of gmsh's work; nothing works on and nothing is left")


def works_in(pid: Path, folder: Path) -> bool:
    """Whether a process works in a folder below `folder`."""
    try:
        return folder in Path(os.readlink(pid / "cwd")).parents
    except OSError:  # it has ended
        return False


def main(program: str, design: str, kills: int, seed: int) -> None:
    chance, runs = random.Random(seed), Runs(program, design)
    runs.whole(design)
    expected, complete = result(runs.out), readable(runs.out)
    lasts, places = {}, {}
    for kind in KINDS:
        runs.prepare(kind)
        lasts[kind] = runs.whole(design)
        places[kind] = placing(runs, kind)
    found = {kind: dict(kills=0, aimed=0, partly=0, files=0) for kind in KINDS}
    for kill in range(kills):
        kind = KINDS[kill % len(KINDS)]
        runs.prepare(kind)
        aimed = kill // len(KINDS) % 2 == 1
        process = subprocess.Popen(runs.command(design), **runs.quiet)
        moment = None if aimed else chance.uniform(0.0, lasts[kind])
        how = chance.choice((signal.SIGKILL, signal.SIGTERM))
        if strike(runs, process, moment, chance.uniform(0.0, places[kind]), how):
            found[kind]["kills"] += 1
            found[kind]["aimed"] += aimed
        files = readable(runs.out) if runs.out.exists() else 0
        found[kind]["files"] += files
        if (runs.out / "result.json").exists():
            # The digits are those of this design or, if not yet replaced, of the other one. All files exist.
            name = result(runs.out)["design"]["name"]
            assert name == "other" or result(runs.out) == expected, f"kill {kill}: other digits"
            assert files >= complete, f"kill {kill}: a result without its files"
        elif files:
            found[kind]["partly"] += 1
        runs.verify()
    runs.whole(design)
    assert result(runs.out) == expected, "the run after the last kill has other digits"
    assert not list(runs.out.glob(".unfinished-*")), "what a killed run left is not removed"
    end_studies(runs, kills // 3, chance)
    if shutil.which("gmsh"):
        end_meshers(runs, kills // 3, chance)
    shutil.rmtree(runs.work)
    for kind, count in found.items():
        print(
            f"{kind}: {count['kills']} killed at work within {lasts[kind]:.1f} s, {count['aimed']} of them in the last "
            f"{1e3 * places[kind]:.0f} ms, while files took their places; {count['partly']} left some files and no result; "
            f"{count['files']} files read"
        )
    print(f"{kills} runs, no file unreadable, no entry damaged, the same digits at the end")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 200, int(sys.argv[4]) if len(sys.argv) > 4 else 1)
