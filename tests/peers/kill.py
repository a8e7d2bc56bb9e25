"""Kills runs at random moments and looks at what they leave.

    kill.py NAILNOISE DESIGN [KILLS] [SEED]

After every kill -9 each file in the output folder can be read, a folder with result.json has all of it, and no entry of
the cache is damaged; the next run gives the digits of an undisturbed one. The cache begins empty every other time, so that
kills fall into every stage.
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
    """Reads every file that has its place; one that is cut off fails here."""
    files = [file for file in folder.rglob("*") if file.is_file() and ".unfinished-" not in str(file)]
    for file in files:
        if file.name.startswith(".") and file.name.endswith(".tmp"):
            continue  # half-written, and nobody's: the next run does not look at it
        text = file.read_text(errors="strict")
        if file.suffix == ".json":
            json.loads(text)
        elif file.suffix in (".vtu", ".pvd"):
            ElementTree.fromstring(text)
        elif file.suffix == ".csv":
            rows = text.splitlines()
            assert text.endswith("\n") and len({row.count(",") for row in rows if '"' not in row}) <= 2, file
        elif file.suffix == ".html":
            assert text.endswith("</html>"), file
    return len(files)


def main(program: str, design: str, kills: int, seed: int) -> None:
    chance = random.Random(seed)
    work = Path(tempfile.mkdtemp(prefix="nailnoise-kill-"))
    out, cache = work / "out", work / "cache"
    environment = dict(os.environ, NAILNOISE_CACHE=str(cache))
    command = [program, "run", design, "--json", "--out", str(out)]
    quiet = dict(stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)

    begin = time.monotonic()
    subprocess.run(command, check=True, **quiet)
    whole = time.monotonic() - begin
    expected, complete = result(out), readable(out)

    in_time, looked = 0, 0
    for kill in range(kills):
        if kill % 2 == 0:
            shutil.rmtree(cache, ignore_errors=True)
        if kill % 5 == 0:
            shutil.rmtree(out, ignore_errors=True)
        process = subprocess.Popen(command, **quiet)
        try:
            process.wait(timeout=chance.uniform(0.0, whole))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            in_time += 1
        if out.exists():
            looked += readable(out)
            if (out / "result.json").exists():
                assert result(out) == expected, f"kill {kill}: other digits"
                assert readable(out) >= complete, f"kill {kill}: a result without its files"
        subprocess.run([program, "cache", "verify"], check=True, **quiet)
    subprocess.run(command, check=True, **quiet)
    assert result(out) == expected, "the run after the last kill has other digits"
    shutil.rmtree(work)
    print(f"{kills} runs, {in_time} killed at work within {whole:.1f} s, {looked} files read, the same digits at the end")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 200, int(sys.argv[4]) if len(sys.argv) > 4 else 1)
