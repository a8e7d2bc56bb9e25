"""Opens reports and other pages in headless Chromium as readers would, without a network.

    report.py PICTURES REPORT.html ... [--every-picture]

Windows of four widths, light and dark, without JavaScript, without WebGL, and in print. Asserts for each that nothing
is requested from a network, that no error is in the console, that no label of a chart touches another or leaves the
window, that texts have enough contrast and pictures a text; that the values under the pointer are there, series can be
hidden, time is zoomed in all charts together, the 3D view follows its controls (report_scene.py), sounds load, and A
and B run in step; that no column of a table is lost and no text shows signs of markup; that the file is short enough,
and the page on paper is neither cut nor shrunk (report_print.py). Pages without charts, legends, sounds or a 3D view
are held to the rest. Saves screenshots (of all windows with --every-picture) and the page as printed. Uses the Chromium
of the system, or else that of playwright.
"""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

from report_print import printed
from report_scene import scene

ARGUMENTS = ["--autoplay-policy=no-user-gesture-required", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-sandbox"]
WIDTHS = [360, 420, 768, 1400]
MEGABYTE = 1_000_000

# Labels that touch a label of the same panel, or leave the window.
OVERLAPS = """
() => {
  const found = [];
  const shown = (e) => { const s = getComputedStyle(e); return s.visibility !== "hidden" && e.getClientRects().length > 0; };
  for (const panel of document.querySelectorAll(".panel")) {
    const labels = [...panel.querySelectorAll(".tick, .events abbr, .note, .row .name, .axis, .legend button")].filter(shown).map((e) => {
      // The text itself, not the box that holds it.
      const range = document.createRange();
      range.selectNodeContents(e);
      const unseen = e.querySelector(".unseen");
      if (unseen) range.setEndBefore(unseen);
      const own = [...range.getClientRects()].filter((r) => r.width > 1 && r.height > 1);
      return own.length ? { text: e.textContent.slice(0, 30), left: Math.min(...own.map((r) => r.left)), right: Math.max(...own.map((r) => r.right)),
        top: Math.min(...own.map((r) => r.top)), bottom: Math.max(...own.map((r) => r.bottom)) } : null;
    }).filter(Boolean);
    const where = panel.closest("figure").id;
    for (const [i, a] of labels.entries()) {
      if (a.left < -1 || a.right > innerWidth + 1) found.push(`${where}: "${a.text}" leaves the window`);
      for (const b of labels.slice(i + 1)) {
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left), down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (across > 1 && down > 2.5) found.push(`${where}: "${a.text}" over "${b.text}"`);
      }
    }
  }
  return found;
}
"""

# Lowest contrast of texts against the page (WCAG 2.1, 1.4.3).
CONTRAST = """
() => {
  const parts = (text) => text.match(/[\\d.]+/g).map(Number);
  const luminance = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const paper = luminance(parts(getComputedStyle(document.body).backgroundColor));
  const texts = ["body", ".quiet", "a", "th", ".tick", "figcaption", "nav a", ".brand"].map((s) => document.querySelector(s)).filter(Boolean);
  return Math.min(...texts.map((e) => luminance(parts(getComputedStyle(e).color))).map((l) => (Math.max(l, paper) + 0.05) / (Math.min(l, paper) + 0.05)));
}
"""

UNNAMED = """
() => [...document.querySelectorAll("img")].filter((e) => !e.alt).length + [...document.querySelectorAll("table")].filter((e) => !e.querySelector("th")).length
  + [...document.querySelectorAll(".plot")].filter((e) => !e.getAttribute("aria-label")).length
"""

# Tables that are wider than their parent, unless the parent scrolls and shows this by its shaded edge. Hidden cells.
# All folded elements are opened for this check.
LOST = """
() => {
  const folded = [...document.querySelectorAll("details:not([open])")];
  folded.forEach((e) => e.open = true);
  const right = (e) => e.getBoundingClientRect().right;
  const named = (e) => `${(e.closest("section") || {}).id}: ${e.textContent.slice(0, 40)}`;
  const tables = [...document.querySelectorAll("table")].filter((e) => e.getClientRects().length);
  const wide = tables.filter((e) => !e.parentElement.matches(".scroll") && right(e) > right(e.parentElement) + 1);
  const without = [...document.querySelectorAll(".scroll")].filter((e) => e.scrollWidth > e.clientWidth + 1)
    .filter((e) => getComputedStyle(e).overflowX !== "auto" || getComputedStyle(e).backgroundImage === "none");
  const cells = tables.flatMap((e) => [...e.querySelectorAll("th, td")]).filter((e) => !e.getClientRects().length);
  const found = [...wide, ...without, ...cells].map(named);
  folded.forEach((e) => e.open = false);
  return found;
}
"""

# Texts that contain markup characters.
MARKUP = """
() => [...document.querySelectorAll("body *:not(script):not(style)")].filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.includes("`")))
  .map((e) => e.textContent.slice(0, 60))
"""

NO_WEBGL = """
const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind.startsWith("webgl") ? null : get.call(this, kind, ...more); };
"""

SOUNDS = """
async () => Promise.all([...document.querySelectorAll("audio")].map(async (audio) => {
  for (let i = 0; i < 100 && audio.readyState < 2; i++) await new Promise((r) => setTimeout(r, 50));
  return { state: audio.readyState, duration: audio.duration, said: audio.closest(".recording").querySelector(".duration").textContent };
}))
"""


def opened(browser: Browser, report: Path, errors: list[str], before: str = "", **settings: object) -> Page:
    context = browser.new_context(offline=True, **settings)
    page = context.new_page()
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: errors.append(request.url) if not request.url.startswith(("file:", "data:", "blob:")) else None)
    if before:
        page.add_init_script(before)
    page.goto(report.resolve().as_uri(), wait_until="load")
    return page


def sound(page: Page, report: Path, what: str) -> None:
    """Conditions for every reader: nothing overlaps or is cut, contrast, texts instead of pictures."""
    overlaps = page.evaluate(OVERLAPS)
    assert not overlaps, f"{report}, {what}: {overlaps[:8]}"
    over = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
    assert over <= 0, f"{report}, {what}: {over} px too wide"
    contrast = page.evaluate(CONTRAST)
    assert contrast >= 4.5, f"{report}, {what}: contrast {contrast:.2f}"
    assert page.evaluate(UNNAMED) == 0, f"{report}, {what}: a picture or a table without a name"
    lost = page.evaluate(LOST)
    assert not lost, f"{report}, {what}: columns that are lost without a hint: {lost[:6]}"
    signs = page.evaluate(MARKUP)
    assert not signs, f"{report}, {what}: backticks: {signs[:6]}"


def scroll(page: Page, path) -> None:
    """Pictures of a page from top to bottom: a single one would be too high to be drawn at once."""
    step = 1800
    page.set_viewport_size({"width": page.viewport_size["width"], "height": step})
    for part in range(-(-page.evaluate("document.documentElement.scrollHeight") // step)):
        page.evaluate(f"window.scrollTo({{ top: {part * step}, behavior: 'instant' }})")
        page.wait_for_timeout(150)
        page.screenshot(path=path(part))
    page.evaluate("window.scrollTo(0, 0)")


def charts(page: Page, report: Path) -> int:
    """Values under the pointer and by the keys, series that are hidden, the zoom."""
    count = page.evaluate("window.nailnoise.charts")
    for index in range(count):
        read = page.evaluate(f"[0.05, 0.2, 0.35, 0.5, 0.65, 0.8].flatMap((place) => window.nailnoise.values({index}, place).rows.map((row) => row[2]))")
        assert read and all(any(c.isdigit() for c in text) or text == "silent" for text in read), f"{report}: chart {index} has no values: {read}"
    if not count:
        return 0
    plot = page.locator(".plot").first
    plot.scroll_into_view_if_needed()
    plot.focus()
    page.keyboard.press("ArrowRight")
    assert page.locator(".tip").is_visible(), f"{report}: no values by the keys"
    panel = page.locator(".panel:has(.legend [data-series])").first
    if panel.count():
        key = panel.locator(".legend [data-series]").first
        key.click()
        assert panel.locator(".s.off, .row .off").count() > 0, f"{report}: no series is hidden"
        key.click()
    timed = page.locator('.panel[data-group="time"] .plot')
    if timed.count() > 1:
        timed.first.scroll_into_view_if_needed()
        box = timed.first.bounding_box()
        page.mouse.move(box["x"] + 0.2 * box["width"], box["y"] + 60)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 60, steps=4)
        page.mouse.up()
        assert page.locator(".zoomed").count() == timed.count(), f"{report}: the charts of time are not zoomed together"
        overlaps = page.evaluate(OVERLAPS)
        assert not overlaps, f"{report}, zoomed: {overlaps[:8]}"
        page.locator(".zoomed .whole").first.click()
        assert page.locator(".zoomed").count() == 0
    return count


def listen(page: Page, report: Path) -> int:
    """Every sound loads; A and B run in step, and the switch changes which one is heard."""
    sounds = page.evaluate(SOUNDS)
    for own in sounds:
        assert own["state"] >= 2 and own["duration"] > 0 and own["said"] == f"{own['duration']:.2f} s", f"{report}: a sound does not load: {own}"
    if len(sounds) > 1:
        page.locator('[data-ab="play"]').click()
        page.wait_for_function("window.nailnoise.sounds.heard()")
        first = page.evaluate("window.nailnoise.sounds.heard().letter")
        page.locator('[data-ab="switch"]').click()
        page.wait_for_timeout(300)
        heard = page.evaluate("window.nailnoise.sounds.heard()")
        at = "AB".index(heard["letter"])
        assert heard["letter"] != first and heard["gains"][at] > 0.9 and heard["gains"][1 - at] < 0.1, f"{report}: the switch: {heard}"
        page.locator('[data-ab="play"]').click()
    return len(sounds)


def look(browser: Browser, report: Path, pictures: Path, every: bool) -> None:
    name = f"{report.parent.name}-{report.stem}"
    limit = 2 if report.stem.startswith("compare") else 3
    assert report.stat().st_size <= limit * MEGABYTE, f"{report}: {report.stat().st_size} bytes"
    errors: list[str] = []
    for scheme in ("light", "dark"):
        for width in WIDTHS:
            page = opened(browser, report, errors, viewport={"width": width, "height": 900}, color_scheme=scheme)
            sound(page, report, f"{width} px, {scheme}")
            # Charts are drawn when they come into view. One pass finds all errors; further passes only make pictures.
            if every or (width, scheme) == (WIDTHS[-1], "dark"):
                scroll(page, lambda part: pictures / f"{name}-{width}-{scheme}-{part}.png")
            page.context.close()
    # A reader without JavaScript sees every chart and the picture of the surfaces.
    page = opened(browser, report, errors, viewport={"width": 1000, "height": 900}, java_script_enabled=False)
    drawn = page.locator(".plot path").count() > 0 or page.locator(".plot, .track").count() == 0
    assert drawn and (page.locator(".scene").count() == 0 or page.locator(".stage img").is_visible())
    page.screenshot(path=pictures / f"{name}-no-script.png", full_page=True)
    page.context.close()
    page = opened(browser, report, errors, NO_WEBGL, viewport={"width": 1000, "height": 900})
    assert page.locator(".scene canvas").count() == 0 and (page.locator(".scene").count() == 0 or page.locator(".stage img").is_visible())
    sound(page, report, "without WebGL")
    page.context.close()
    page = opened(browser, report, errors, viewport={"width": 1280, "height": 900})
    count = charts(page, report)
    if page.locator(".scene").count():
        scene(page, report, pictures / f"{name}-view.png")
    sounds = listen(page, report)
    printed(page, report, pictures / f"{name}.pdf")
    page.context.close()
    assert not errors, f"{report}: {errors}"
    print(f"{report}: {count} charts, {sounds} sounds, {report.stat().st_size / MEGABYTE:.2f} MB, no error")


def main(pictures: Path, reports: list[Path], every: bool) -> None:
    pictures.mkdir(parents=True, exist_ok=True)
    system = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=system, args=ARGUMENTS)
        for report in reports:
            look(browser, report, pictures, every)
        browser.close()


arguments = [argument for argument in sys.argv[1:] if argument != "--every-picture"]
main(Path(arguments[0]), [Path(report) for report in arguments[1:]], "--every-picture" in sys.argv)
