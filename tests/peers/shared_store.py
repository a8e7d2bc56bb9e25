"""Whether four processes that begin with one empty store compute no draw more than twice and leave no damage.

    shared_store.py NAILNOISE DESIGN [DRAWS]

The kernel (inotify) counts how often each entry comes into the folder by its final name: that is how often it was
computed. Then each process's result must be that of a single process, and `cache verify` must find nothing.
"""

import collections
import ctypes
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

MOVED_TO = 0x80


def arrivals(descriptor: int) -> collections.Counter[str]:
    """Names that came into the folder so far."""
    counts: collections.Counter[str] = collections.Counter()
    while True:
        try:
            data = os.read(descriptor, 1 << 20)
        except BlockingIOError:
            return counts
        while data:
            _, _, _, length = struct.unpack_from("iIII", data)
            counts[data[16 : 16 + length].rstrip(b"\0").decode()] += 1
            data = data[16 + length :]


def main() -> int:
    program, base = (str(Path(own).resolve()) for own in sys.argv[1:3])
    draws = sys.argv[3] if len(sys.argv) > 3 else "8"
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        design = folder / "drawn.toml"
        design.write_text(f'base = "{base}"\n[study]\nrequire = ["drives", "underdriven", "overdriven", "strikes_bumper"]\n')

        def command(out: str, store: str, *more: str) -> list[str]:
            common = ["study", str(design), "-n", draws, "--store", store, "--json", "--threads", "1", "--out", out]
            return [program, *common, *more]

        environment = dict(os.environ, NAILNOISE_CACHE=str(folder / "cache"))
        alone = subprocess.run(command("alone", "one"), cwd=folder, env=environment, capture_output=True, check=True).stdout
        store = folder / "shared"
        store.mkdir()
        libc = ctypes.CDLL(None, use_errno=True)
        watch = libc.inotify_init1(os.O_NONBLOCK)
        assert libc.inotify_add_watch(watch, os.fsencode(store), MOVED_TO) >= 0
        processes = [
            subprocess.Popen(command(f"out{number}", "shared"), cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            for number in range(4)
        ]
        for process in processes:
            said, wrong = process.communicate()
            assert process.returncode == 0, wrong.decode()
            assert said == alone, "a process that shared its store states another result"
        counts = {name: count for name, count in arrivals(watch).items() if name.endswith(".entry")}
        levels = [count for name, count in counts.items() if name.startswith("levels-of-a-draw")]
        assert len(levels) >= int(draws), f"{len(levels)} draws"
        assert max(counts.values()) <= 2, {name: count for name, count in counts.items() if count > 2}
        left = [name for name in os.listdir(store) if not name.endswith(".entry")]
        assert not left, left
        verified = subprocess.run([program, "cache", "verify"], cwd=folder, env=dict(environment, NAILNOISE_CACHE=str(store)), capture_output=True)
        assert verified.returncode == 0, verified.stdout + verified.stderr
        twice = sum(count == 2 for count in counts.values())
        print(f"four processes, {len(counts)} entries, {len(levels)} draws: {twice} entries computed twice, none more often, none damaged")
    return 0


if __name__ == "__main__":
    sys.exit(main())
