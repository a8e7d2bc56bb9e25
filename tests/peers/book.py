"""Makes the pictures of the book from a report, and compares them with the stored ones.

    book.py REPORT.html docs/pictures [--update]

Every picture is a figure of the report as a reader sees it. The stored pictures must have the size of today's, and the
differences must not exceed those of other fonts and of the last digit of a level. Every picture must be on a page of
the book, and every picture on a page must be stored. `--update` writes them anew.
"""

import io
import re
import shutil
import sys
from pathlib import Path

from PIL import Image, ImageChops, ImageFilter, ImageStat
from playwright.sync_api import sync_playwright

ARGUMENTS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-sandbox"]

# Figures of the report, by the names of their pictures.
FIGURES = {
    "bands": "#chart-bands",
    "intervals": "#chart-intervals",
    "pressures": "#chart-pressures",
    "forces": "#chart-forces",
    "surfaces": ".scene .stage",
}

WIDTH = 900
# Largest differences between two pictures: of their sizes in pixels, and of their mean blurred grey values (0 to 255).
OTHER_SIZE = 40
OTHER_GREY = 6.0


def shots(report: Path) -> dict[str, Image.Image]:
    system = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
    pictures = {}
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=system, args=ARGUMENTS)
        page = browser.new_context(viewport={"width": WIDTH, "height": 900}, color_scheme="light").new_page()
        page.goto(report.resolve().as_uri())
        page.wait_for_load_state("load")
        # The navigation stays at the top of the window and would cover the figure.
        page.add_style_tag(content="nav { display: none; }")
        for name, selector in FIGURES.items():
            figure = page.locator(selector).first
            figure.scroll_into_view_if_needed()
            page.wait_for_timeout(500)
            pictures[name] = Image.open(io.BytesIO(figure.screenshot(animations="disabled"))).convert("RGB")
        browser.close()
    return pictures


def difference(old: Image.Image, new: Image.Image) -> float:
    blurred = [picture.convert("L").resize(new.size).filter(ImageFilter.GaussianBlur(4)) for picture in (old, new)]
    return ImageStat.Stat(ImageChops.difference(*blurred)).mean[0]


def main(report: Path, folder: Path, update: bool) -> None:
    pages = sorted(folder.parent.glob("*.md"))
    shown = {name for page in pages for name in re.findall(r"\]\(pictures/([a-z-]+)\.png\)", page.read_text())}
    assert shown == set(FIGURES), f"on pages {sorted(shown)}, made {sorted(FIGURES)}"
    faults = []
    for name, new in shots(report).items():
        path = folder / f"{name}.png"
        if update:
            folder.mkdir(exist_ok=True)
            new.save(path, optimize=True)
            print(f"{path}: {new.width} x {new.height}, {path.stat().st_size / 1000:.0f} kB")
            continue
        old = Image.open(path)
        apart = max(abs(a - b) for a, b in zip(old.size, new.size))
        grey = difference(old, new)
        print(f"{path}: {apart} pixels, {grey:.1f} grey apart")
        if apart > OTHER_SIZE or grey > OTHER_GREY:
            faults.append(name)
    assert not faults, f"other than kept: {faults}; look at them, then write them anew with --update"


main(Path(sys.argv[1]), Path(sys.argv[2]), "--update" in sys.argv[3:])
