"""Kills runs at random moments and looks at what they leave.

    kill.py NAILNOISE DESIGN [KILLS] [SEED]

After every kill -9 each file in the output folder is read, a folder with result.json has all of it, and no entry of the
cache is damaged. Kills take turns: everything computed anew; the cycle alone computed anew beside kept modes, into a
folder that holds another design's files; nothing computed, kept files put into such a folder. Each falls at any moment of
a run of its kind. At the end an undisturbed run has the digits it had at the beginning.
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
    """Reads every file that has its place, and tells how many they are; one that is cut off fails here."""
    files = [file for file in folder.rglob("*") if file.is_file() and ".unfinished-" not in str(file)]
    # A half-written file has another name and is nobody's: the next run does not look at it.
    files = [file for file in files if not (file.name.startswith(".") and file.name.endswith(".tmp"))]
    for file in files:
        content = file.read_bytes()
        assert content, f"{file} is empty"
        if file.suffix == ".wav":
            assert int.from_bytes(content[4:8], "little") + 8 == len(content), f"{file} is cut off"
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
    """Runs of one design and of another, in folders of their own."""

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
        """Removes what the cache keeps of some stages of the design; of all stages and designs without any."""
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


def main(program: str, design: str, kills: int, seed: int) -> None:
    chance, runs = random.Random(seed), Runs(program, design)
    runs.whole(design)
    expected, complete = result(runs.out), readable(runs.out)
    lasts = {}
    for kind in KINDS:
        runs.prepare(kind)
        lasts[kind] = runs.whole(design)
    found = {kind: dict(kills=0, partly=0, files=0) for kind in KINDS}
    for kill in range(kills):
        kind = KINDS[kill % len(KINDS)]
        runs.prepare(kind)
        process = subprocess.Popen(runs.command(design), **runs.quiet)
        try:
            process.wait(timeout=chance.uniform(0.0, lasts[kind]))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            found[kind]["kills"] += 1
        files = readable(runs.out) if runs.out.exists() else 0
        found[kind]["files"] += files
        if (runs.out / "result.json").exists():
            # The digits are this design's or, where nothing has taken its place yet, the other's; and all files are there.
            name = result(runs.out)["design"]["name"]
            assert name == "other" or result(runs.out) == expected, f"kill {kill}: other digits"
            assert files >= complete, f"kill {kill}: a result without its files"
        elif files:
            found[kind]["partly"] += 1
        runs.verify()
    runs.whole(design)
    assert result(runs.out) == expected, "the run after the last kill has other digits"
    shutil.rmtree(runs.work)
    for kind, count in found.items():
        print(
            f"{kind}: {count['kills']} killed at work within {lasts[kind]:.1f} s, {count['partly']} of them while files took "
            f"their places, {count['files']} files read"
        )
    print(f"{kills} runs, no file unreadable, no entry damaged, the same digits at the end")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 200, int(sys.argv[4]) if len(sys.argv) > 4 else 1)
