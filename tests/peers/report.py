"""Opens reports in headless Chromium as a reader would, without a network.

    report.py PICTURES REPORT.html ...

Asserts that there is no network request and no error in the console, that every chart has data and is drawn, that the 3D
view draws and rotates, and that every sound loads and A/B switches between two. Saves screenshots of wide and narrow
windows and the page as printed. Uses the Chromium of the system, or else that of playwright.
"""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

GRAPHICS = ["--autoplay-policy=no-user-gesture-required", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-sandbox"]

# For each chart: how many finite values its data hold, and how large its drawing is.
CHARTS = """
async () => {
  await window.nailnoise.ready;
  const finite = (values) => values === undefined || values === null ? 0
    : typeof values.length === "number" ? Array.from(values).filter((v) => Number.isFinite(+v) && v !== null).length : 0;
  return [...document.querySelectorAll(".plot")].map((plot) => ({
    id: plot.id,
    values: plot.data.map((trace) => Math.max(finite(trace.x), finite(trace.y), finite(trace.intensity), finite(trace.z))),
    drawn: plot.querySelectorAll(".main-svg, canvas").length,
    width: plot.getBoundingClientRect().width,
    scene: !!plot.layout.scene,
  }));
}
"""

SOUNDS = """
async () => Promise.all([...document.querySelectorAll("audio")].map(async (audio) => {
  for (let i = 0; i < 100 && audio.readyState < 2; i++) await new Promise((r) => setTimeout(r, 50));
  return { state: audio.readyState, duration: audio.duration };
}))
"""


def colours(png: bytes) -> int:
    """Different bytes in a picture: an empty view has next to none."""
    return len(set(png))


# Switches twice, the second time while the first sound plays; tells which sound began each time, where, and how many play.
SWITCH = """
async () => {
  const sounds = [...document.querySelectorAll(".recording audio")], begun = [];
  let reached = 0;
  sounds.forEach((audio, i) => audio.addEventListener("playing", () => begun.push({
    sound: i, at: audio.currentTime, playing: sounds.filter((other) => !other.paused).length })));
  for (let turn = 1; turn <= 2; turn++) {
    const before = begun.length ? sounds[begun[0].sound] : null;
    reached = before && !before.paused ? before.currentTime : 0;
    document.querySelector('[data-ab="switch"]').click();
    for (let i = 0; i < 4000 && begun.length < turn; i++) await new Promise((r) => setTimeout(r, 5));
    if (turn === 1) await new Promise((r) => setTimeout(r, 40));
  }
  sounds.forEach((audio) => audio.pause());
  return { begun, reached };
}
"""


def listen(page, report: Path) -> None:
    """A/B: a sound plays, the switch goes over to another at the same moment, and only that one plays then."""
    told = page.evaluate(SWITCH)
    begun, reached = told["begun"], told["reached"]
    assert len(begun) == 2, f"{report}: A/B plays {begun}"
    first, second = begun
    assert first["sound"] != second["sound"], f"{report}: the switch stays at one sound: {begun}"
    # The clock of a sound is coarse: what plays goes on where the other was, to a hundredth of a second.
    assert second["at"] >= reached - 0.01 and second["playing"] == 1, f"{report}: the switch does not go on: {begun}"


def look(page, report: Path, pictures: Path, errors: list[str]) -> None:
    page.goto(report.resolve().as_uri(), wait_until="load")
    charts = page.evaluate(CHARTS)
    assert charts, f"{report}: no charts"
    for chart in charts:
        assert sum(chart["values"]) > 0, f"{report}: {chart['id']} has no data"
        assert chart["drawn"] > 0 and chart["width"] > 200, f"{report}: {chart['id']} is not drawn: {chart}"
    name = f"{report.parent.name}-{report.stem}"
    for chart in (chart for chart in charts if chart["scene"]):
        view = page.locator(f"#{chart['id']}")
        view.scroll_into_view_if_needed()
        page.wait_for_timeout(1500)
        before = view.screenshot(path=pictures / f"{name}-view.png")
        box = view.bounding_box()
        x, y = box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"]
        camera = f"document.getElementById('{chart['id']}')._fullLayout.scene._scene.getCamera().eye"
        eye = page.evaluate(camera)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 160, y + 40, steps=12)
        page.mouse.up()
        page.wait_for_timeout(1000)
        after = view.screenshot(path=pictures / f"{name}-view-turned.png")
        turned = page.evaluate(camera)
        assert max(abs(eye[k] - turned[k]) for k in "xyz") > 0.1, f"{report}: the view does not turn: {eye} {turned}"
        assert before != after and colours(before) > 200, f"{report}: the view is empty"
    sounds = page.evaluate(SOUNDS)
    for sound in sounds:
        assert sound["state"] >= 2 and sound["duration"] > 0, f"{report}: a sound does not load: {sound}"
    if len(sounds) > 1:
        listen(page, report)
    page.evaluate("window.scrollTo(0, 0)")
    for width in (1280, 400):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(1200)
        scroll(page, lambda part: pictures / f"{name}-{width}-{part}.png")
        over = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
        assert over <= 0, f"{report}: {over} px wider than a window of {width}"
    page.pdf(path=pictures / f"{name}.pdf", format="A4", print_background=True)
    assert not errors, f"{report}: {errors}"
    print(f"{report}: {len(charts)} charts, {len(sounds)} sounds, no error")


def scroll(page, path) -> None:
    """Pictures of a page from top to bottom: one of the whole would be higher than what can be drawn at once."""
    step = 1800
    page.set_viewport_size({"width": page.viewport_size["width"], "height": step})
    for part in range(-(-page.evaluate("document.documentElement.scrollHeight") // step)):
        page.evaluate(f"window.scrollTo(0, {part * step})")
        page.wait_for_timeout(300)
        page.screenshot(path=path(part))


def main(pictures: Path, reports: list[Path]) -> None:
    pictures.mkdir(parents=True, exist_ok=True)
    system = next((found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=system, args=GRAPHICS)
        for report in reports:
            context = browser.new_context(viewport={"width": 1280, "height": 900}, offline=True)
            page = context.new_page()
            errors: list[str] = []
            page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
            page.on("pageerror", lambda error: errors.append(str(error)))
            asked = lambda request: errors.append(f"asks for {request.url}") if request.url.startswith("http") else None
            page.on("request", asked)
            look(page, report, pictures, errors)
            context.close()
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]), [Path(report) for report in sys.argv[2:]])
