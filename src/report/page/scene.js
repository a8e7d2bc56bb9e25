// The surfaces in space: a view by WebGL in the place of the picture, where the browser has it.
(() => {
  const figure = document.querySelector(".scene");
  if (!figure) return;
  const data = JSON.parse(figure.querySelector("script").textContent);
  const stage = figure.querySelector(".stage"), image = stage.querySelector("img");
  const canvas = document.createElement("canvas");
  const gl = canvas.getContext("webgl", { antialias: true, alpha: true, premultipliedAlpha: false, preserveDrawingBuffer: true });
  if (!gl) {
    document.querySelectorAll(".in-space").forEach((own) => own.remove());
    return; // the picture stays
  }

  const bytes = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const bodies = data.bodies.map((body) => ({
    name: body.name,
    points: new Int16Array(bytes(body.points).buffer),
    triangles: new Uint32Array(bytes(body.triangles).buffer),
    levels: body.levels.map(bytes),
  }));
  // Three corners a triangle, so that each has one colour.
  const corners = bodies.reduce((sum, body) => sum + body.triangles.length, 0);
  const places = new Float32Array(3 * corners), normals = new Float32Array(3 * corners), colours = new Uint8Array(3 * corners);
  const moves = new Int8Array(3 * corners); // of the mode that is shown, relative to its largest displacement
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  let next = 0;
  for (const body of bodies) {
    for (let first = 0; first < body.triangles.length; first += 3) {
      const p = [0, 1, 2].map((corner) => [0, 1, 2].map((axis) => body.points[3 * body.triangles[first + corner] + axis]));
      const [u, v] = [1, 2].map((corner) => p[corner].map((value, axis) => value - p[0][axis]));
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const size = Math.hypot(...n) || 1;
      for (const corner of p) {
        for (let axis = 0; axis < 3; axis++) {
          places[next] = corner[axis];
          normals[next++] = n[axis] / size;
          low[axis] = Math.min(low[axis], corner[axis]);
          high[axis] = Math.max(high[axis], corner[axis]);
        }
      }
    }
  }
  const centre = low.map((value, axis) => 0.5 * (value + high[axis]));

  const shader = (kind, source) => {
    const own = gl.createShader(kind);
    gl.shaderSource(own, source);
    gl.compileShader(own);
    return own;
  };
  const program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER, `
    attribute vec3 place; attribute vec3 normal; attribute vec3 colour; attribute vec3 move;
    uniform mat3 view; uniform vec3 centre; uniform vec2 scale; uniform float depth; uniform vec2 shift; uniform float swing;
    varying vec3 shade;
    void main() {
      vec3 p = view * (place + swing * move - centre);
      gl_Position = vec4(p.xy * scale + shift, -p.z * depth, 1.0);
      shade = colour * (0.62 + 0.38 * abs((view * normal).z));
    }`));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER, "precision mediump float; varying vec3 shade; void main() { gl_FragColor = vec4(shade, 1.0); }"));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  gl.useProgram(program);
  const attribute = (name, values, type, normalised) => {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    const location = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, 3, type, normalised, 0, 0);
    return () => {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    };
  };
  attribute("place", places, gl.FLOAT, false);
  attribute("normal", normals, gl.FLOAT, false);
  const renewColours = attribute("colour", colours, gl.UNSIGNED_BYTE, true);
  const renewMoves = attribute("move", moves, gl.BYTE, true);
  gl.enable(gl.DEPTH_TEST);
  gl.uniform3fv(gl.getUniformLocation(program, "centre"), centre);

  let view = 0;
  const paint = () => {
    const scale = Array.from({ length: 256 }, (_, level) => {
      const at = level / 255 * (data.colours.length - 1), first = Math.min(Math.floor(at), data.colours.length - 2);
      return [0, 1, 2].map((c) => data.colours[first][c] + (data.colours[first + 1][c] - data.colours[first][c]) * (at - first));
    });
    let next = 0;
    for (const body of bodies) {
      const levels = body.levels[view];
      for (let triangle = 0; triangle < body.triangles.length / 3; triangle++) {
        const colour = triangle < levels.length ? scale[levels[triangle]] : [200, 200, 200];
        for (let corner = 0; corner < 3; corner++) for (let c = 0; c < 3; c++) colours[next++] = colour[c];
      }
    }
    renewColours();
    label(view);
  };
  const label = (view) => {
    const top = data.views[view];
    figure.querySelector(".low").textContent = (top - data.shown).toFixed(0);
    figure.querySelector(".high").textContent = top.toFixed(0);
  };
  // The picture is printed, which has the colours of the first view.
  window.addEventListener("beforeprint", () => label(0));
  window.addEventListener("afterprint", () => label(view));

  // The view: an azimuth about the vertical and an elevation. It begins as the picture.
  const towards = [data.axes[6], data.axes[7], data.axes[8]];
  const begin = { azimuth: Math.atan2(towards[1], towards[0]), elevation: Math.asin(towards[2]), zoom: 1 };
  const camera = { ...begin };
  const axes = () => {
    const [ca, sa, ce, se] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth), Math.cos(camera.elevation), Math.sin(camera.elevation)];
    return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  };
  // Half of what the view from the given axes has across, up and in depth.
  const extent = (rows) => rows.map((row) => row.reduce((sum, part, axis) => sum + Math.abs(part) * 0.5 * (high[axis] - low[axis]), 0));
  const projected = (rows) => {
    const ends = [[Infinity, -Infinity], [Infinity, -Infinity]];
    for (let i = 0; i < places.length; i += 3) {
      for (let axis = 0; axis < 2; axis++) {
        const at = rows[axis][0] * (places[i] - centre[0]) + rows[axis][1] * (places[i + 1] - centre[1]) + rows[axis][2] * (places[i + 2] - centre[2]);
        ends[axis][0] = Math.min(ends[axis][0], at);
        ends[axis][1] = Math.max(ends[axis][1], at);
      }
    }
    return ends;
  };
  const first = projected(axes());
  let frame = { scale: [1, 1], shift: [0, 0] };
  let swing = 0; // displacement of the mode, in the steps of the points
  const draw = () => {
    const width = Math.round(canvas.clientWidth * devicePixelRatio), height = Math.round(canvas.clientHeight * devicePixelRatio);
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    gl.viewport(0, 0, width, height);
    const rows = axes();
    const size = 0.94 * camera.zoom * Math.min(width / (first[0][1] - first[0][0]), height / (first[1][1] - first[1][0]));
    const scale = [2 * size / width, 2 * size / height];
    const shift = [0, 1].map((axis) => -0.5 * (first[axis][0] + first[axis][1]) * scale[axis]);
    frame = { scale, shift, rows };
    gl.uniformMatrix3fv(gl.getUniformLocation(program, "view"), false, [0, 1, 2].flatMap((axis) => rows.map((row) => row[axis])));
    gl.uniform2fv(gl.getUniformLocation(program, "scale"), scale);
    gl.uniform2fv(gl.getUniformLocation(program, "shift"), shift);
    gl.uniform1f(gl.getUniformLocation(program, "depth"), 0.98 / Math.hypot(...extent(rows)));
    gl.uniform1f(gl.getUniformLocation(program, "swing"), swing);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.drawArrays(gl.TRIANGLES, 0, corners);
  };

  // The level of the face at a point of the canvas, by the triangle nearest to the viewer.
  const pick = (x, y) => {
    const [px, py] = [(x - frame.shift[0]) / frame.scale[0], (y - frame.shift[1]) / frame.scale[1]];
    const [a, b, c] = [0, 3, 6];
    let best = -Infinity, found = null, i = 0;
    for (const body of bodies) {
      for (let triangle = 0; triangle < body.triangles.length / 3; triangle++, i += 9) {
        const at = (corner) => frame.rows.map((row) => row.reduce((sum, part, axis) => sum + part * (places[i + corner + axis] - centre[axis]), 0));
        const [p, q, r] = [at(a), at(b), at(c)];
        const twice = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        const edge = (s, t) => ((t[0] - s[0]) * (py - s[1]) - (t[1] - s[1]) * (px - s[0])) / twice;
        const [w, u, v] = [edge(p, q), edge(q, r), edge(r, p)];
        const depth = u * p[2] + v * q[2] + w * r[2];
        if (u >= 0 && v >= 0 && w >= 0 && depth > best) { best = depth; found = [body, triangle]; }
      }
    }
    if (!found) return "";
    const level = found[0].levels[view][found[1]];
    if (level === undefined) return `${found[0].name}: covered`;
    const value = data.views[view] - data.shown * (1 - level / 255);
    return `${found[0].name}: ${level ? "" : "at most "}${value.toFixed(0)} dB`;
  };

  image.after(canvas);
  stage.classList.add("turns");
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${image.alt}; arrow keys turn it, plus and minus change its size, Escape returns to the first view`);
  const output = figure.querySelector("output");
  let from = null, waiting = false;
  const later = () => { if (!waiting) { waiting = true; requestAnimationFrame(() => { waiting = false; draw(); }); } };
  const turn = (azimuth, elevation) => {
    camera.azimuth += azimuth;
    camera.elevation = Math.max(-1.57, Math.min(1.57, camera.elevation + elevation));
    later();
  };
  const closer = (factor) => { camera.zoom = Math.max(0.5, Math.min(20, camera.zoom * factor)); later(); };
  canvas.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { from = null; });
  canvas.addEventListener("pointermove", (event) => {
    if (from) {
      turn(-0.008 * (event.clientX - from[0]), 0.008 * (event.clientY - from[1]));
      from = [event.clientX, event.clientY];
    } else if (frame.rows) {
      const box = canvas.getBoundingClientRect();
      output.textContent = pick(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    }
  });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return; // the page scrolls
    event.preventDefault();
    closer(Math.exp(-0.003 * event.deltaY));
  }, { passive: false });
  canvas.addEventListener("dblclick", () => { Object.assign(camera, begin); later(); });
  canvas.addEventListener("keydown", (event) => {
    const keys = {
      ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
      "+": () => closer(1.25), "-": () => closer(0.8), Escape: () => { Object.assign(camera, begin); later(); },
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  // A mode: its largest displacement, and on request its oscillation, in which a second shows one period.
  const chosen = figure.querySelector(".mode"), play = figure.querySelector(".play");
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let mode = null, since = null;
  const pause = () => { since = null; play.textContent = still.matches ? "Other way" : "Play"; };
  const choose = (index) => {
    mode = data.modes[index] ?? null;
    chosen.value = mode ? String(index) : "";
    play.hidden = !mode;
    moves.fill(0);
    if (mode) {
      const shape = new Int8Array(bytes(mode.shape).buffer);
      let next = 0;
      bodies.forEach((body, number) => {
        if (number !== mode.body) { next += 3 * body.triangles.length; return; }
        for (const point of body.triangles) for (let axis = 0; axis < 3; axis++) moves[next++] = shape[3 * point + axis];
      });
    }
    renewMoves();
    swing = mode ? mode.reach : 0;
    pause();
    later();
  };
  const step = (now) => {
    if (since === null || !mode) return;
    swing = mode.reach * Math.cos(2 * Math.PI * (now - since) / 1000);
    draw();
    requestAnimationFrame(step);
  };
  const start = () => {
    // Where motion is unwelcome, the button shows the other end of the oscillation.
    if (still.matches) { swing = -swing; later(); return; }
    play.textContent = "Pause";
    requestAnimationFrame((now) => { since = now; step(now); });
  };
  chosen.addEventListener("change", () => choose(chosen.value === "" ? -1 : +chosen.value));
  play.addEventListener("click", () => (since === null ? start() : pause()));
  document.querySelectorAll("button[data-mode]").forEach((button) => button.addEventListener("click", () => {
    choose(+button.dataset.mode);
    figure.scrollIntoView({ block: "center", behavior: still.matches ? "auto" : "smooth" });
    start();
  }));
  window.addEventListener("beforeprint", () => choose(-1));
  figure.querySelector(".view").addEventListener("change", (event) => { view = +event.target.value; paint(); later(); });
  canvas.addEventListener("webglcontextlost", () => { stage.classList.remove("turns"); canvas.remove(); });
  new ResizeObserver(later).observe(canvas);
  paint();
  draw();
  window.nailnoise.scene = camera;
  window.nailnoise.swing = () => swing;
})();
