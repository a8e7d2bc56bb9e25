"""The view in space of a report, operated by mouse, fingers and keys; report.py calls it.

Asserts that it begins as the picture, and that each control changes what is drawn: turning, moving, coming closer to
the place under the pointer, sides, edges, hidden parts and one part alone, bodies apart, modes in motion. Laws of its
geometry: sharp edges stay sharp, normals of a cylinder are radial, and their change follows the deformation.
"""

import math
from pathlib import Path

from playwright.sync_api import Page

# Cosine of the largest angle between a normal of a cylinder and the radius. Least factor by which four times as many
# sides reduce the error of a change of normals; the weights of the mean are those of the undeformed surface.
RADIAL = math.cos(math.radians(1))
REDUCTION = 3

# Corners of a cube or of a cylinder with its caps as triangles.
BODIES = """
window.cube = (() => {
  const points = [], corners = [];
  for (let i = 0; i < 8; i++) points.push(1000 * (i & 1), 1000 * (i >> 1 & 1), 1000 * (i >> 2));
  for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) corners.push(a, b, c, a, c, d);
  return [points, corners];
})();
window.cylinder = (sides) => {
  const points = [0, 0, 0, 0, 0, 1], corners = [];
  for (let i = 0; i < sides; i++) {
    const angle = 2 * Math.PI * i / sides, next = (i + 1) % sides, [a, b, c, d] = [2 + 2 * i, 2 + 2 * next, 3 + 2 * next, 3 + 2 * i];
    points.push(Math.cos(angle), Math.sin(angle), 0, Math.cos(angle), Math.sin(angle), 1);
    corners.push(a, b, c, a, c, d, 0, b, a, 1, d, c);
  }
  return [points, corners];
};
"""

LAWS = """
() => {
  const { part, tilts } = window.nailnoise.geometry;
  const box = part(...window.cube);
  const normal = (own, corner) => [0, 1, 2].map((axis) => own.normals[3 * corner + axis]);
  const sharp = Math.min(...[...box.corners].map((_, corner) => Math.max(...normal(box, corner).map(Math.abs))));
  const rounds = [24, 96].map((sides) => {
    const [points, corners] = window.cylinder(sides), round = part(points, corners), radial = [];
    round.corners.forEach((point, corner) => {
      const n = normal(round, corner);
      if (Math.abs(n[2]) < 0.5) radial.push(n[0] * points[3 * point] + n[1] * points[3 * point + 1]);
    });
    // Bending of the cylinder, and the normals of the bent one.
    const step = 1e-3, shape = points.map((_, at) => (at % 3 === 0 ? points[at + 2] ** 2 : 0));
    const bent = part(points.map((value, at) => value + step * shape[at]), corners), change = tilts(round, points, shape);
    const errors = [...change].map((value, at) => Math.abs((bent.normals[at] - round.normals[at]) / step - value));
    return { edges: round.edges.length, radial: Math.min(...radial), change: Math.max(...change.map(Math.abs)), error: Math.max(...errors) };
  });
  return { edges: box.edges.length, sharp, rounds };
}
"""

# The point in space under a point of the canvas, in the plane of the view.
UNDER = """
([x, y]) => {
  const own = window.nailnoise.scene, canvas = document.querySelector(".scene canvas");
  const rows = own.axes(), half = own.half(canvas.clientWidth, canvas.clientHeight);
  return [0, 1, 2].map((axis) => own.target[axis] + x * half[0] * rows[0][axis] + y * half[1] * rows[1][axis]);
}
"""

# Names of the visible parts.
SEEN = """
() => {
  const found = new Set();
  for (let x = -0.95; x < 1; x += 0.05) for (let y = -0.95; y < 1; y += 0.05) found.add(window.nailnoise.read(x, y).split(":")[0]);
  found.delete("");
  return [...found];
}
"""

# Controls without a name for a screen reader, or too small for a finger (WCAG 2.2, 2.5.8: 24 px).
UNUSABLE = """
() => [...document.querySelectorAll(".scene button, .scene select, .scene input, .scene canvas")].filter((own) => own.getClientRects().length).filter((own) => {
  const name = own.getAttribute("aria-label") || own.closest("label")?.textContent.trim() || own.textContent.trim();
  const target = own.closest("label") || own, box = target.getBoundingClientRect();
  return !name || Math.min(box.width, box.height) < 24;
}).map((own) => own.outerHTML.slice(0, 80))
"""


def scene(page: Page, report: Path, picture: Path) -> None:
    """The view in space draws, begins as the picture, and follows its controls."""
    canvas = page.locator(".scene canvas")
    assert canvas.count() == 1, f"{report}: no view by WebGL"
    laws(page)
    unusable = page.evaluate(UNUSABLE)
    assert not unusable, f"{report}: {unusable}"
    canvas.scroll_into_view_if_needed()
    page.wait_for_timeout(300)
    assert len(set(canvas.screenshot(path=picture))) > 200, f"{report}: the view is empty"
    turn(page, report)
    move(page, report)
    look(page, report)
    parts(page, report, picture)
    apart(page, report, picture)
    oscillate(page, report, picture)


def laws(page: Page) -> None:
    page.evaluate(BODIES)
    found = page.evaluate(LAWS)
    # Diagonals of the cube's sides are not edges; a cylinder has the edges of its caps.
    coarse, fine = found["rounds"]
    assert [found["edges"], coarse["edges"], fine["edges"]] == [12, 48, 192], found
    assert found["sharp"] > 1 - 1e-6 and coarse["radial"] > RADIAL, found
    assert coarse["change"] > 0.5 and coarse["error"] > REDUCTION * fine["error"], found


def changes(page: Page, report: Path, what: str, act) -> bytes:
    """What is drawn after an action, which must change it."""
    canvas = page.locator(".scene canvas")
    before = canvas.screenshot()
    act()
    page.wait_for_timeout(300)
    after = canvas.screenshot()
    assert after != before, f"{report}: {what} changes nothing"
    return after


def drag(page: Page, dx: float, dy: float, button: str = "left") -> None:
    box = page.locator(".scene canvas").bounding_box()
    x, y = box["x"] + 0.4 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down(button=button)
    page.mouse.move(x + dx, y + dy, steps=6)
    page.mouse.up(button=button)


def turn(page: Page, report: Path) -> None:
    azimuth = page.evaluate("window.nailnoise.scene.azimuth")
    box = page.locator(".scene canvas").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    read = page.locator(".scene output").inner_text()
    assert "dB" in read or "covered" in read or read == "", read
    changes(page, report, "dragging", lambda: drag(page, 120, 30))
    turned = page.evaluate("window.nailnoise.scene.azimuth")
    assert abs(turned - azimuth) > 0.5, f"{report}: the view does not turn"
    page.locator(".scene canvas").focus()
    changes(page, report, "an arrow key", lambda: page.keyboard.press("ArrowLeft"))
    assert page.evaluate("window.nailnoise.scene.azimuth") < turned
    page.keyboard.press("Escape")
    assert page.evaluate("window.nailnoise.scene.azimuth") == azimuth, f"{report}: Escape does not return"


def move(page: Page, report: Path) -> None:
    """Moves and comes closer by mouse, keys and fingers; what is under the pointer stays there."""
    target, azimuth = "window.nailnoise.scene.target", page.evaluate("window.nailnoise.scene.azimuth")
    canvas = page.locator(".scene canvas")
    for what, act in {
        "the right button": lambda: drag(page, 60, 20, "right"),
        "Shift and an arrow": lambda: canvas.press("Shift+ArrowRight"),
        "the choice of dragging": lambda: (page.locator(".dragging").select_option("move"), drag(page, -40, 10)),
    }.items():
        before = page.evaluate(target)
        changes(page, report, what, act)
        assert page.evaluate(target) != before and page.evaluate("window.nailnoise.scene.azimuth") == azimuth, what
    page.locator(".dragging").select_option("turn")
    canvas.press("Escape")
    box, place = canvas.bounding_box(), [0.3, -0.2]
    page.mouse.move(box["x"] + 0.5 * (1 + place[0]) * box["width"], box["y"] + 0.5 * (1 - place[1]) * box["height"])
    before = page.evaluate(UNDER, place)
    page.keyboard.down("Control")
    changes(page, report, "the wheel", lambda: page.mouse.wheel(0, -300))
    page.keyboard.up("Control")
    size = math.hypot(*before)
    assert page.evaluate("window.nailnoise.scene.zoom") > 1.5 and math.dist(page.evaluate(UNDER, place), before) < 0.01 * size, f"{report}: the wheel does not come closer to the pointer"
    changes(page, report, "the minus key", lambda: canvas.press("-"))
    changes(page, report, "a button", lambda: page.locator('[data-tool="closer"]').click())
    canvas.press("Escape")
    assert page.evaluate("window.nailnoise.scene.zoom") == 1
    pinch(page, report, box)


def pinch(page: Page, report: Path, box: dict) -> None:
    """Two fingers move apart: the view comes closer, and the page does not scroll."""
    session, scrolled = page.context.new_cdp_session(page), page.evaluate("window.scrollY")
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]

    def fingers(kind: str, spread: float) -> None:
        points = [] if kind == "touchEnd" else [{"x": x - spread, "y": y, "id": 0}, {"x": x + spread, "y": y + 10, "id": 1}]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def act() -> None:
        fingers("touchStart", 40)
        for spread in (50, 60, 80):
            fingers("touchMove", spread)
        fingers("touchEnd", 0)

    changes(page, report, "two fingers", act)
    assert 1.8 < page.evaluate("window.nailnoise.scene.zoom") < 2.2 and page.evaluate("window.scrollY") == scrolled, f"{report}: two fingers"
    page.locator('[data-tool="fit"]').tap() if page.evaluate("navigator.maxTouchPoints") else page.locator('[data-tool="fit"]').click()
    assert page.evaluate("window.nailnoise.scene.zoom") == 1
    session.detach()


def look(page: Page, report: Path) -> None:
    """Sides, edges, and the level of the face in the middle."""
    changes(page, report, "the view from above", lambda: page.locator(".direction").select_option("above"))
    assert page.evaluate("window.nailnoise.scene.elevation") > 1.5
    changes(page, report, "edges", lambda: page.locator(".edges").focus() or page.keyboard.press("Space"))
    page.locator(".edges").check()
    page.locator(".scene canvas").press("Enter")
    read = page.locator(".scene output").inner_text()
    assert "dB" in read or "covered" in read, f"{report}: Enter reads nothing: {read}"
    page.locator('[data-tool="reset"]').click()
    # All faces have a level in the view of all bands; another octave has other colours.
    changes(page, report, "another octave", lambda: page.locator(".view").select_option("1"))
    page.locator(".view").select_option("0")


def parts(page: Page, report: Path, picture: Path) -> None:
    """A body alone, by a button; hidden and shown again, by the keys; alone by a double click."""
    bodies = page.locator(".parts .of-body > .entry:first-child")
    everything = set(page.evaluate(SEEN))
    for index in range(bodies.count()):
        body = bodies.nth(index)
        name = body.locator("label").inner_text().strip()
        assert "dB" in body.locator(".most").inner_text(), f"{report}: {name} has no level"
        if bodies.count() == 1:
            break
        changes(page, report, f"{name} alone", lambda: body.locator("button").click())
        page.locator(".scene canvas").screenshot(path=picture.with_stem(f"{picture.stem}-{name}"))
        seen = page.evaluate(SEEN)
        assert seen and all(own.split(",")[0] == name for own in seen), f"{report}: {name} alone: {seen}"
        assert body.locator("button").get_attribute("aria-pressed") == "true"
        body.locator("button").click()
    assert set(page.evaluate(SEEN)) == everything and all(page.evaluate("window.nailnoise.shown"))
    first = bodies.first.locator("input")
    first.focus()
    changes(page, report, "a hidden part", lambda: page.keyboard.press("Space"))
    name = bodies.first.locator("label").inner_text().strip()
    assert not any(own.split(",")[0] == name for own in page.evaluate(SEEN)), f"{report}: {name} is not hidden"
    page.keyboard.press("Space")
    if page.locator(".parts .entry").count() > 1:
        canvas, box = page.locator(".scene canvas"), page.locator(".scene canvas").bounding_box()
        page.mouse.dblclick(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
        assert sum(page.evaluate("window.nailnoise.shown")) in (1, len(page.evaluate("window.nailnoise.shown")))
    page.locator('[data-tool="reset"]').click()


def apart(page: Page, report: Path, picture: Path) -> None:
    """Bodies apart by the keys, and together again."""
    if page.locator(".apart").count() == 0:
        return
    canvas, slider = page.locator(".scene canvas"), page.locator(".apart input")
    slider.focus()
    page.wait_for_timeout(300)
    together = canvas.screenshot()
    changes(page, report, "bodies apart", lambda: page.keyboard.press("End"))
    canvas.screenshot(path=picture.with_stem(f"{picture.stem}-apart"))
    slider.focus()
    assert changes(page, report, "bodies together", lambda: page.keyboard.press("Home")) == together, f"{report}: bodies do not return"


def oscillate(page: Page, report: Path, picture: Path) -> None:
    """A mode is shown at its largest displacement, and moves on a button only; none at all is the beginning."""
    canvas, swing = page.locator(".scene canvas"), "window.nailnoise.swing()"
    assert page.evaluate(swing) == 0 and page.locator(".scene .play").is_hidden(), f"{report}: a mode moves unasked"
    rest = canvas.screenshot()
    page.locator(".scene .mode").select_option("0")
    page.wait_for_timeout(200)
    largest = page.evaluate(swing)
    assert largest > 0 and canvas.screenshot(path=picture.with_stem(f"{picture.stem}-mode")) != rest, f"{report}: no mode is shown"
    changes(page, report, "colours of the displacement", lambda: page.locator(".scene .view").select_option("mode"))
    assert page.locator(".scene .unit-of-scale").inner_text().startswith("%")
    page.locator(".scene .play").click()
    # Without a graphics processor a frame takes tenths of a second.
    seen = set()
    for _ in range(200):
        page.wait_for_timeout(60)
        seen.add(round(page.evaluate(swing)))
        if len(seen) > 2:
            break
    assert len(seen) > 2 and max(map(abs, seen)) <= largest + 1, f"{report}: the mode does not oscillate: {seen}"
    page.locator(".scene .play").click()
    page.locator(".scene .mode").select_option("")
    page.wait_for_timeout(200)
    assert page.evaluate(swing) == 0
    assert page.locator(".scene .view").input_value() == "0" and "pW" in page.locator(".scene .unit-of-scale").inner_text()
    page.emulate_media(reduced_motion="reduce")
    page.locator("button[data-mode]").nth(1).click()
    page.wait_for_timeout(400)
    still = page.evaluate(swing)
    page.wait_for_timeout(200)
    assert still != 0 and page.evaluate(swing) == still, f"{report}: a mode moves although motion is unwelcome"
    page.locator(".scene .play").click()
    assert page.evaluate(swing) == -still
    page.emulate_media(reduced_motion="no-preference")
    page.locator(".scene .mode").select_option("")
