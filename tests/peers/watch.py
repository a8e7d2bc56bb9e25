"""Fifty saves of a watched design while its page is open in headless Chromium.

    watch.py NAILNOISE DESIGN PICTURES [SAVES]

Saves a design over DESIGN in the same ways as editors, among them broken and half-written files, and waits after each
until the open page shows the expected content: the new report with the changed value in its bar, or the message over
the last report. Then: no error in the console, every save shown, memory of the process bounded, no connection left open
by closed pages, status 130 and no process after SIGINT. Prints how long a save took to reach the page. Saves pictures
of the page: light, dark, narrow, with a message.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from playwright.sync_api import sync_playwright

PATIENCE = 600.0

#: Runs after which the peak of the memory is that of any run.
FIRST_RUNS = 10

BROKEN = [
    ("supply.pressure = \"600 ", "TOML"),
    ("base = \"between.toml\"\nsupply.presure = 1\n", "supply.pressure"),
    ("base = \"between.toml\"\nsupply.pressure = \"3 mm\"\n", "unit"),
    ("base = \"between.toml\"\nbody.mesh = \"nothing.step\"\n", "nothing.step"),
    ("", "base"),
]


def in_place(path: Path, text: str) -> None:
    path.write_text(text)


def renamed(path: Path, text: str) -> None:
    new = path.with_suffix(".tmp")
    new.write_text(text)
    new.replace(path)


def removed(path: Path, text: str) -> None:
    path.unlink()
    time.sleep(0.05)
    path.write_text(text)


def in_halves(path: Path, text: str) -> None:
    with path.open("w") as file:
        file.write(text[: len(text) // 2])
        file.flush()
        time.sleep(0.2)
        file.write(text[len(text) // 2 :])


WAYS = [in_place, renamed, removed, in_halves]


def memory(process: int, key: str) -> float:
    """Resident memory, now (VmRSS) or at most so far (VmHWM) [MB]."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(re.search(rf"{key}:\s+(\d+)", status)[1]) / 1024


def threads(process: int) -> int:
    return len(os.listdir(f"/proc/{process}/task"))


# The report is in the page, not only announced: check its number and the bar above it.
SHOWN = """([value, before]) => Number(document.documentElement.dataset.shown || 0) > before
  && document.getElementById("failure").hidden && document.getElementById("bar").textContent.includes(value)"""
FAILED = """(text) => !document.getElementById("failure").hidden && document.getElementById("failure").textContent.includes(text)"""
NUMBER = "() => Number(document.documentElement.dataset.shown || 0)"


def look(page, pictures: Path, name: str) -> None:
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)
        for width in (1400, 768, 360):
            page.set_viewport_size({"width": width, "height": 900})
            page.wait_for_timeout(700)
            page.screenshot(path=pictures / f"watch-{name}-{scheme}-{width}.png")
            over = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
            assert over <= 0, f"{over} px wider than a window of {width}"
    page.emulate_media(color_scheme="light")
    page.set_viewport_size({"width": 1280, "height": 900})


def main(program: Path, design: Path, pictures: Path, saves: int) -> None:
    pictures.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp())
    own, between = folder / "own.toml", folder / "between.toml"
    between.write_text(f'base = "{design.resolve()}"\n')
    text = lambda pressure: f'base = "between.toml"\nsupply.pressure = "{pressure} kPa"\n'
    own.write_text(text(690))
    # A separate cache: every run is computed, and none is faster because an earlier step had the same design.
    environment = {**os.environ, "NAILNOISE_CACHE": str(folder / "cache")}
    process = subprocess.Popen(
        [program, "watch", own], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment
    )
    address = process.stdout.readline().strip()
    assert address.startswith("http://127.0.0.1:"), address
    system = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
    times, broken, resident, peak, idle = [], 0, [], 0.0, 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=system, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.set_default_timeout(1000 * PATIENCE)
        errors: list[str] = []
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)
        page.wait_for_function(NUMBER)
        for number in range(1, saves + 1):
            save = WAYS[number % len(WAYS)]
            if number % 5 == 0:
                content, message = BROKEN[number // 5 % len(BROKEN)]
                save(own, content)
                page.wait_for_function(FAILED, arg=message)
                broken += 1
                if broken == 2:
                    look(page, pictures, "failed")
                continue
            value, before = f"{690 + number} kPa", page.evaluate(NUMBER)
            begin = time.monotonic()
            save(own, text(690 + number))
            page.wait_for_function(SHOWN, arg=[f"\u2192 {value}", before])
            times.append(time.monotonic() - begin)
            if number == 3:
                page.get_by_role("button", name="Pin run").click()
            if number == 7:
                # Later reports remain at the scroll position of the reader.
                page.frames[1].evaluate("window.scrollTo({ top: 700, behavior: 'instant' })")
            if number == 8:
                assert abs(page.frames[-1].evaluate("window.scrollY") - 700) < 2, "the page jumps"
                assert "pinned" in page.locator("#bar").inner_text()
                look(page, pictures, "shown")
            resident.append(memory(process.pid, "VmRSS"))
            if len(resident) == FIRST_RUNS:
                peak = memory(process.pid, "VmHWM")
            idle = threads(process.pid)
        # Pages that are opened and closed do not leave threads behind.
        for _ in range(10):
            other = browser.new_page()
            other.goto(address)
            other.wait_for_function(NUMBER)
            other.close()
        end = time.monotonic() + 30
        while threads(process.pid) > idle + 1 and time.monotonic() < end:
            time.sleep(0.5)
        assert threads(process.pid) <= idle + 1, f"{threads(process.pid)} threads after {idle}"
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 130, process.returncode
        page.wait_for_function("() => document.body.classList.contains('gone')")
        browser.close()
    own_errors = [error for error in errors if "ERR_CONNECTION_REFUSED" not in error and "ERR_INCOMPLETE_CHUNKED" not in error]
    assert not own_errors, own_errors
    # The allocator may retain the memory of a run for later runs, but not more than the peak of a run.
    last = median(resident[-FIRST_RUNS:])
    assert last < 1.2 * peak + 20, f"memory grows: {resident} after a peak of {peak}"
    shutil.rmtree(folder)
    times.sort()
    print(
        f"{saves} saves, {broken} of them broken, all shown; from a save to the drawn report {times[len(times) // 2]:.2f} s "
        f"({times[0]:.2f} .. {times[-1]:.2f} s); memory {last:.0f} MB in the last runs, {peak:.0f} MB at the peak of the first {FIRST_RUNS}"
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]), int(sys.argv[4]) if len(sys.argv) > 4 else 50)
