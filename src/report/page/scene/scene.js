// The surfaces in space: a view by WebGL in the place of the picture, where the browser has it, and its controls.
(() => {
  const figure = document.querySelector(".scene");
  if (!figure) return;
  const one = (selector) => figure.querySelector(selector);
  const data = JSON.parse(one("script").textContent);
  const stage = one(".stage"), image = stage.querySelector("img");
  const canvas = document.createElement("canvas");
  const { geometry, camera: cameraFrom, gestures, painter: painterFor, modes: modesOf } = window.nailnoise;
  const plain = () => document.querySelectorAll(".in-space").forEach((own) => own.remove()); // the picture stays
  const gl = canvas.getContext("webgl", { antialias: true, alpha: true,
    premultipliedAlpha: false, preserveDrawingBuffer: true });
  if (!gl) return plain();
  const { bodies, parts } = geometry.decoded(data);
  const painter = painterFor(gl, bodies, parts);
  if (!painter) return plain();

  const camera = cameraFrom([data.axes[6], data.axes[7], data.axes[8]]);
  const output = one("output"), direction = one(".direction"), apart = one(".apart input");
  const shown = parts.map(() => true);
  let view = "0"; // of the levels, or "mode" for displacements
  let mode = null, swing = 0; // the mode that is shown, and its displacement in the steps of the points

  // Bodies that lie on each other are raised by their levels in the stack.
  const high = bodies.flatMap((body) => [...body.points]).reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const lift = () => parts.map((part) => 0.004 * apart.value * high * part.stack);
  const above = (rows, use) => {
    const raised = lift(), low = rows.map(() => Infinity), top = rows.map(() => -Infinity);
    parts.forEach((part, index) => {
      if (!use[index]) return;
      const points = bodies[part.body].points;
      for (const point of part.corners) {
        for (let axis = 0; axis < rows.length; axis++) {
          const row = rows[axis], at = row[0] * points[3 * point] + row[1] * points[3 * point + 1] +
            row[2] * (points[3 * point + 2] + raised[index]);
          low[axis] = Math.min(low[axis], at);
          top[axis] = Math.max(top[axis], at);
        }
      }
    });
    return { low, high: top };
  };
  const fit = () => camera.fit((rows) => above(rows, shown.some(Boolean) ? shown : parts.map(() => true)));

  // Largest distance of a place from the axis origin, so that nothing is cut off in depth whichever way it is turned.
  let box = null;
  const bound = () => {
    const { low, high } = above([[1, 0, 0], [0, 1, 0], [0, 0, 1]], parts.map(() => true));
    box = { centre: low.map((value, axis) => 0.5 * (value + high[axis])),
      reach: 0.5 * Math.hypot(...low.map((value, axis) => high[axis] - value)) };
  };
  const draw = () => {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight]
      .map((size) => Math.round(size * devicePixelRatio));
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const rows = camera.axes();
    painter.draw({
      rows, target: camera.target, half: camera.half(width, height),
        middle: geometry.dot(rows[2], camera.target) - geometry.dot(rows[2], box.centre),
      depth: box.reach + Math.abs(swing), swing, shown, lift: lift(), withEdges: one(".edges").checked, width, height,
    });
  };
  let waiting = false;
  const later = () => { if (!waiting) { waiting = true; requestAnimationFrame(() => { waiting = false; draw(); }); } };

  // The largest displacement of a triangle's corners on average, 0 to 1.
  const displaced = (part, triangle) => {
    const shape = mode.body === part.body ? mode.shape : null;
    if (!shape) return 0;
    const size = (corner) => { const point = 3 * bodies[part.body].triangles[3 * triangle + corner];
      return Math.hypot(shape[point], shape[point + 1], shape[point + 2]); };
    return (size(0) + size(1) + size(2)) / (3 * 127);
  };
  // A value of a triangle from 0 to 1 in the present view; null for a covered one.
  const valueOf = (part, place) => {
    const triangle = part.list[place];
    if (view === "mode") return displaced(part, triangle);
    const levels = bodies[part.body].levels[view];
    return triangle < levels.length ? levels[triangle] / 255 : null;
  };
  const words = (value) => {
    if (value === null) return "covered";
    if (view === "mode") return `${(100 * value).toFixed(0)} % of the largest displacement`;
    return `${value > 0 ? "" : "at most "}${(data.views[view] - data.shown * (1 - value)).toFixed(0)} dB`;
  };
  const scale = Array.from({ length: 256 }, (_, level) => {
    const at = level / 255 * (data.colours.length - 1), first = Math.min(Math.floor(at), data.colours.length - 2);
    return [0, 1, 2]
      .map((c) => data.colours[first][c] + (data.colours[first + 1][c] - data.colours[first][c]) * (at - first));
  });
  const label = (view) => {
    const ofMode = view === "mode", top = data.views[view];
    one(".low").textContent = ofMode ? "0" : (top - data.shown).toFixed(0);
    one(".high").textContent = ofMode ? "100" : top.toFixed(0);
    one(".unit-of-scale").textContent = ofMode ? "% of the largest displacement" : unit;
  };
  const unit = one(".unit-of-scale").textContent;
  const paint = () => {
    painter.colour((part, place) => {
      const value = valueOf(part, place);
      return value === null ? null : scale[Math.min(255, Math.round(255 * value))];
    });
    label(view);
    for (const entry of entries) {
      const values = entry.parts.flatMap((index) => parts[index].list.map((_, place) => valueOf(parts[index], place)))
        .filter((value) => value !== null);
      entry.most.textContent = values.length
        ? words(values.reduce((most, value) => Math.max(most, value), 0)) : "covered";
    }
    later();
  };

  // The part and the triangle at a place of the canvas, the nearest to the viewer.
  const at = (x, y) => {
    const rows = camera.axes(), half = camera.half(canvas.clientWidth, canvas.clientHeight), raised = lift();
    const [px, py] = [x * half[0], y * half[1]];
    let best = -Infinity, found = null;
    parts.forEach((part, index) => {
      if (!shown[index]) return;
      const points = bodies[part.body].points, shape = mode && mode.body === part.body ? mode.shape : null;
      const seen = (point) => {
        const own = [0, 1, 2].map((axis) => points[3 * point + axis] +
          (shape ? swing * shape[3 * point + axis] / 127 : 0) - camera.target[axis]);
        own[2] += raised[index];
        return rows.map((row) => geometry.dot(row, own));
      };
      for (let place = 0; place < part.list.length; place++) {
        const [p, q, r] = [0, 1, 2].map((corner) => seen(part.corners[3 * place + corner]));
        const twice = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        const edge = (s, t) => ((t[0] - s[0]) * (py - s[1]) - (t[1] - s[1]) * (px - s[0])) / twice;
        const [w, u, v] = [edge(p, q), edge(q, r), edge(r, p)];
        const depth = u * p[2] + v * q[2] + w * r[2];
        if (u >= 0 && v >= 0 && w >= 0 && depth > best) { best = depth; found = [index, place]; }
      }
    });
    return found;
  };
  const read = (x, y) => {
    const found = at(x, y);
    return found ? `${parts[found[0]].name}: ${words(valueOf(parts[found[0]], found[1]))}` : "";
  };

  image.after(canvas);
  stage.classList.add("turns");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-roledescription", "3D view");
  canvas.setAttribute("aria-label", [
    `${image.alt}. Arrow keys turn it, with Shift move it, plus and minus change its size,`,
    "Enter reads the face in the middle, Escape returns to the first view",
  ].join(" "));
  const size = () => [canvas.clientWidth, canvas.clientHeight];
  const reset = () => { camera.look("first"); direction.value = "first"; fit(); later(); };
  const act = {
    turn(azimuth, elevation) { camera.turn(azimuth, elevation); direction.value = ""; later(); },
    move(x, y) { camera.move(x, y, ...size()); later(); },
    zoom(factor, x, y) { camera.zoomBy(factor, x, y, ...size()); later(); },
    read(x, y) { output.textContent = read(x, y) || "no face here"; },
    hover(x, y) { output.textContent = read(x, y); },
    only(x, y) { const found = at(x, y);
      found && shown.some((own, index) => own && index !== found[0]) ? only([found[0]]) : all(); },
    reset,
  };
  const dragging = one(".dragging");
  gestures(canvas, act, () => dragging.value === "move");
  dragging.addEventListener("change", () => stage.classList.toggle("moves", dragging.value === "move"));
  direction.addEventListener("change", () => { camera.look(direction.value); fit(); later(); });
  const tools = {
    closer: () => act.zoom(1.25, 0, 0), farther: () => act.zoom(0.8, 0, 0), fit: () => { fit(); later(); },
    reset: () => { apart.value = 0; bound(); all(); reset(); },
  };
  figure.querySelectorAll("[data-tool]").forEach((button) =>
    button.addEventListener("click", tools[button.dataset.tool]));
  one(".edges").addEventListener("change", later);
  apart.addEventListener("input", () => { bound(); if (camera.fitted) fit(); later(); });
  if (new Set(parts.map((part) => part.stack)).size < 2) one(".apart").remove();

  // Parts that are hidden, and one that is shown alone.
  const entries = [...figure.querySelectorAll("[data-parts]")].map((entry) => ({
    parts: entry.dataset.parts.split(" ").map(Number), box: entry.querySelector("input"),
      only: entry.querySelector("button"), most: entry.querySelector(".most"),
  }));
  const renew = () => {
    const count = shown.filter(Boolean).length;
    for (const entry of entries) {
      const own = entry.parts.filter((index) => shown[index]).length;
      entry.box.checked = own > 0;
      entry.box.indeterminate = own > 0 && own < entry.parts.length;
      entry.only.setAttribute("aria-pressed", String(
        own === entry.parts.length && own === count && count < parts.length));
    }
    if (camera.fitted) fit();
    later();
  };
  const only = (own) => { parts.forEach((_, index) => { shown[index] = own.includes(index); }); fit(); renew(); };
  const all = () => only(parts.map((_, index) => index));
  for (const entry of entries) {
    entry.box.addEventListener("change", () => { entry.parts.forEach((index) => { shown[index] = entry.box.checked; });
      renew(); });
    entry.only.addEventListener("click", () =>
      (entry.only.getAttribute("aria-pressed") === "true" ? all() : only(entry.parts)));
  }

  const choice = one(".view");
  choice.addEventListener("change", () => { view = choice.value; paint(); });
  const modes = modesOf(figure, data.modes, {
    choose(chosen) {
      mode = chosen;
      painter.deform(bodies.map((_, body) => (mode && mode.body === body ? mode.shape : null)));
      choice.querySelector('[value="mode"]').disabled = !mode;
      if (view !== "mode") return;
      if (!mode) choice.value = view = "0";
      paint();
    },
    swing(value, now) { swing = value; now ? draw() : later(); },
  });
  // The picture is printed, which has the colours of the first view.
  window.addEventListener("beforeprint", () => { modes.stop(); label("0"); });
  window.addEventListener("afterprint", () => label(view));
  canvas.addEventListener("webglcontextlost", () => { stage.classList.remove("turns"); canvas.remove(); plain(); });
  new ResizeObserver(later).observe(canvas);
  bound();
  fit();
  paint();
  draw();
  Object.assign(window.nailnoise, { scene: camera, swing: () => swing, shown, read });
})();
