"""Runs on file systems that are too small and checks that a folder contains the old result or the new one, and no
mixture.

    full_disk.py NAILNOISE DESIGN [STEPS]

The folder is on a file system in memory and contains the result of a changed design. Its size is stepped from hardly
any free space to more than a run needs, and its number of files likewise. In each step the design is run twice: with
its result in the cache, and computed anew. Every run must end with status 0 and leave the new result, or with status 2
and a message and leave the old one, file for file. At the end, a run must work with a cache on a file system that is
mounted for reading.

Mounting needs root on Linux. Elsewhere the script says so and ends with status 0.
"""

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# A file system that is mounted without a limit cannot get one later.
AMPLE = "size=4g,nr_inodes=1000000"


def mounted(folder: Path, options: str) -> bool:
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)], capture_output=True, text=True)
    if done.returncode != 0:
        print(f"skipped: no file system can be mounted here ({done.stderr.strip()})")
    return done.returncode == 0


def remount(folder: Path, options: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{options}", str(folder)], check=True)


def digest(folder: Path) -> str:
    """Of the names and contents of all files, without the times that a run took."""
    whole = hashlib.sha256()
    for file in sorted(file for file in folder.rglob("*") if file.is_file()):
        content = file.read_bytes()
        if file.name == "result.json":
            result = json.loads(content)
            result.pop("timing")
            content = json.dumps(result).encode()
        elif file.name == "report.html":
            assert content.endswith(b"</html>"), f"{file} is cut off"
            content = re.search(rb"<title>.*?</title>", content).group()
        whole.update(f"{file.relative_to(folder)} {len(content)} ".encode() + content)
    return whole.hexdigest()


def room(folder: Path) -> tuple[int, int]:
    """Bytes and files that are in use."""
    status = os.statvfs(folder)
    return (status.f_blocks - status.f_bfree) * status.f_frsize, status.f_files - status.f_ffree


class Disk:
    def __init__(self, program: str, design: str, work: Path, disk: Path) -> None:
        self.program, self.design, self.disk = program, design, disk
        self.out, self.kept, self.cache = disk / "out", work / "old", work / "cache"
        other = work / "other.toml"
        other.write_text(f"base = {json.dumps(str(Path(design).resolve()))}\nsupply.pressure = \"95 psig\"\n")
        assert self.run(other).returncode == 0
        shutil.copytree(self.out, self.kept)
        self.need = room(disk)
        assert self.run(design).returncode == 0
        self.old, self.new = digest(self.kept), digest(self.out)
        assert self.old != self.new

    def run(self, design: str | Path) -> subprocess.CompletedProcess:
        environment = dict(os.environ, NAILNOISE_CACHE=str(self.cache), NO_COLOR="1")
        command = [self.program, "run", str(design), "--json", "--quiet", "--out", str(self.out)]
        return subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def restore(self) -> None:
        """Puts the old result back."""
        remount(self.disk, AMPLE)
        shutil.rmtree(self.out)
        shutil.copytree(self.kept, self.out)

    def step(self, limit: str, anew: bool) -> bool:
        """Whether the design fits under a limit."""
        if anew:
            for entry in self.cache.glob("run-*.entry"):
                entry.unlink()
        remount(self.disk, limit)
        done = self.run(self.design)
        found = digest(self.out)
        left = [path.name for path in self.out.iterdir() if path.name.startswith(".")]
        assert not left, f"{limit}: {left} left behind"
        if done.returncode == 0:
            assert found == self.new, f"{limit}: the new result is not whole"
            return True
        assert done.returncode == 2 and "cannot write" in done.stderr, f"{limit}: {done.returncode} {done.stderr}"
        assert found == self.old, f"{limit}: the old result is not whole"
        return False


def main(program: str, design: str, steps: int) -> None:
    work = Path(tempfile.mkdtemp(prefix="nailnoise-full-"))
    disk = work / "disk"
    disk.mkdir()
    if not mounted(disk, AMPLE):
        shutil.rmtree(work)
        return
    try:
        full = Disk(program, design, work, disk)
        size, files = full.need
        for what, begin, limits in [("size", size, "size={},nr_inodes=1000000"), ("number of files", files, "size=4g,nr_inodes={}")]:
            for anew in (False, True):
                whole = 0
                for step in range(steps):
                    full.restore()
                    # Up to 2.2 times the size of the old result: while files are replaced, both results exist.
                    limit = begin + max(1, step * begin * 12 // (steps * 10))
                    whole += full.step(limits.format(limit), anew)
                assert 0 < whole < steps, f"{what}: {whole} of {steps} runs left the new result"
                kind = "computed anew" if anew else "from the cache"
                print(f"{what}, {kind}: {steps - whole} runs left the old result, {whole} the new one")
        full.restore()
        reading_only(full, work)
    finally:
        subprocess.run(["umount", str(disk)], check=True)
        shutil.rmtree(work)


def reading_only(full: Disk, work: Path) -> None:
    """Empty, and with everything in it, the cache is on a file system for reading."""
    entries = full.cache.rename(work / "entries")
    full.cache.mkdir()
    for filled in (False, True):
        assert mounted(full.cache, AMPLE)
        try:
            if filled:
                shutil.copytree(entries, full.cache, dirs_exist_ok=True)
            remount(full.cache, "ro")
            done = full.run(full.design)
            assert done.returncode == 0 and digest(full.out) == full.new, done.stderr
            full.restore()
        finally:
            subprocess.run(["umount", str(full.cache)], check=True)
    print("with a cache for reading only: the new result, whether it is cached or not")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 40)
