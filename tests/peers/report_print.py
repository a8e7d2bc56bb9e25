"""A page as it is printed on A4: nothing is cut or shrunk, texts are large enough, few pages where few are promised."""

import re
import shutil
import subprocess
from pathlib import Path

from playwright.sync_api import Page

#: Pages of the summary of a report, before its appendix.
SUMMARY_PAGES = 4

#: Width of A4 between the margins of the pages, 182 mm [px].
PRINTED = 688

#: Smallest text of paragraphs and lists, and of cells and legends [pt].
BODY, CELLS = 8.0, 7.0

# Elements that are wider than the paper: the browser would shrink the whole page to fit them.
WIDE = """
(width) => [...document.querySelectorAll("main table, main figure, main p, main ul, main dl, header *")]
  .filter((e) => e.getClientRects().length && !e.closest("svg") && e.getBoundingClientRect().right > width + 1)
  .map((e) => `${(e.closest("section") || {}).id} ${e.tagName} ${Math.round(e.getBoundingClientRect().right - width)} px: ${e.textContent.slice(0, 40)}`)
"""

# Smallest text size of these elements in pt, with the beginning of the text.
SMALLEST = """
(elements) => [...document.querySelectorAll(elements)].filter((e) => e.getClientRects().length && [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()))
  .map((e) => [0.75 * parseFloat(getComputedStyle(e).fontSize), e.textContent.slice(0, 40)])
  .reduce((least, own) => own[0] < least[0] ? own : least, [Infinity, ""])
"""

# Width of the name of the program at the top of the page in pt.
NAME = """
() => { const range = document.createRange(); range.selectNodeContents(document.querySelector(".brand")); return 0.75 * range.getBoundingClientRect().width; }
"""


def printed(page: Page, report: Path, path: Path) -> None:
    """Prints the page, and asserts the size of its texts on paper and its number of pages."""
    page.emulate_media(media="print")
    page.set_viewport_size({"width": PRINTED, "height": 900})
    wide = page.evaluate(WIDE, PRINTED)
    assert not wide, f"{report}, printed: wider than the paper: {wide[:6]}"
    body = page.evaluate(SMALLEST, "header p:not(.brand), main p:not(.axis), main li, dd")
    cells = page.evaluate(SMALLEST, "td, th, .meaning, .quiet, .legend button")
    name = page.evaluate(NAME)
    page.pdf(path=path, format="A4", print_background=True)
    if not shutil.which("pdftotext"):
        return
    # Factor by which the browser has shrunk the page, from the width of a word; it does not depend on the font.
    boxes = subprocess.run(["pdftotext", "-bbox", "-l", "1", path, "-"], capture_output=True, text=True, check=True).stdout
    word = re.search(r'<word xMin="([\d.]+)" yMin="[\d.]+" xMax="([\d.]+)" yMax="[\d.]+">nailnoise<', boxes)
    assert word, f"{report}, printed: the first page does not name the program"
    factor = (float(word[2]) - float(word[1])) / name
    assert factor > 0.97, f"{report}, printed: shrunk to {factor:.2f}"
    # The page is not shrunk, so text sizes are those of the style sheet.
    assert body[0] >= BODY, f"{report}, printed: text of {body[0]:.1f} pt: {body[1]}"
    assert cells[0] >= CELLS, f"{report}, printed: text of {cells[0]:.1f} pt: {cells[1]}"
    text = subprocess.run(["pdftotext", "-layout", path, "-"], capture_output=True, text=True, check=True).stdout
    pages = text.split("\f")[:-1]
    print(f"{report}: {len(pages)} pages, text of {body[0]:.1f} pt, cells of {cells[0]:.1f} pt")
    if page.locator(".appendix-begins").count():
        summary = next(number for number, text in enumerate(pages) if text.lstrip().startswith("Appendix"))
        assert summary <= SUMMARY_PAGES, f"{report}: a summary of {summary} pages"
        print(f"{report}: {summary} pages of summary")
    if report.stem == "declaration":
        assert len(pages) == 1, f"{report}: {len(pages)} pages instead of one"
