"""Whether a user can use a store that another user's killed process has left claims in, whatever the modes of the folder and the files.

    two_users.py NAILNOISE DESIGN

Needs root and setpriv, because it runs as two users. One begins a study in a shared folder and is killed as soon as a claim is there.
The other's study over the same store must end with status 0 within the 90 s after which a claim is stale and the time of its own work,
and its notes must name the cause of a wait or of a claim that cannot be removed.
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STALE = 90.0
WORK = 90.0


def as_user(number: int, umask: str, home: Path, command: list[str]) -> list[str]:
    shell = f'umask {umask}; exec "$@"'
    environment = ["env", f"HOME={home}", f"NAILNOISE_CACHE={home}/cache"]
    user = ["setpriv", "--reuid", str(number), "--regid", str(number), "--clear-groups"]
    return [*user, *environment, "sh", "-c", shell, "sh", *command]


def case(program: str, base: str, mode: int, umask: str) -> None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        folder.chmod(0o755)
        # Perhaps neither user can enter the folder of the program, so copy it. Both must be able to read the design.
        own = folder / "nailnoise"
        shutil.copy(program, own)
        own.chmod(0o755)
        design = folder / "drawn.toml"
        design.write_text(f'base = "{base}"\n[study]\nrequire = ["drives", "underdriven", "overdriven", "strikes_bumper"]\n')
        design.chmod(0o644)
        store = folder / "shared"
        store.mkdir()
        store.chmod(mode)
        homes = [folder / name for name in ("one", "other")]
        for number, home in enumerate(homes, 1001):
            home.mkdir()
            os.chown(home, number, number)

        def study(out: Path) -> list[str]:
            return [str(own), "study", str(design), "-n", "16", "--store", str(store), "--out", str(out)]

        first = subprocess.Popen(
            as_user(1001, umask, homes[0], study(homes[0] / "out")), cwd="/", stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        end = time.monotonic() + 60
        while not any("claim" in name for name in os.listdir(store)):
            assert time.monotonic() < end and first.poll() is None, "the first study makes no claim"
            time.sleep(0.01)
        first.send_signal(signal.SIGKILL)
        first.wait()
        left = [name for name in os.listdir(store) if "claim" in name]
        begin = time.monotonic()
        second = subprocess.run(
            as_user(1002, "022", homes[1], study(homes[1] / "out")), cwd="/", capture_output=True, text=True, timeout=STALE + WORK + 60
        )
        took = time.monotonic() - begin
        name = f"folder {mode:o}, umask {umask}"
        assert second.returncode == 0, f"{name}: {second.stderr}"
        assert took < STALE + WORK, f"{name}: {took:.0f} s"
        notes = [line for line in second.stderr.splitlines() if "waiting for" in line or "cannot be removed" in line]
        if left and (umask == "077" or mode == 0o1777):
            assert notes, f"{name}: no note of {left}\n{second.stderr}"
        print(f"{name}: {len(left)} claims left, {took:.1f} s, status 0; {notes[0][:110] if notes else 'no wait'}", flush=True)


def main() -> int:
    program, base = (str(Path(own).resolve()) for own in sys.argv[1:3])
    if os.geteuid() != 0 or not shutil.which("setpriv"):
        print("two users: left out, needs root and setpriv")
        return 0
    for mode in (0o1777, 0o777):
        for umask in ("022", "077"):
            case(program, base, mode, umask)
    return 0


if __name__ == "__main__":
    sys.exit(main())
