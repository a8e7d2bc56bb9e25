// Drawing of the surfaces in space by WebGL: faces with smooth shading, and their sharp edges.
(() => {
  const AMBIENT = 0.62; // brightness of a face whose normal is perpendicular to the line of sight
  const NEUTRAL = [200, 200, 200]; // covered faces

  const VERTEX = `
    attribute vec3 place; attribute vec3 normal; attribute vec3 tilt; attribute vec3 colour; attribute vec3 move;
    uniform mat3 view; uniform vec3 target; uniform vec3 lift; uniform vec2 scale;
      uniform float middle; uniform float depth;
    uniform float swing;
    varying vec3 n; varying vec3 c;
    void main() {
      vec3 p = view * (place + swing * move + lift - target);
      gl_Position = vec4(p.xy * scale, -(p.z + middle) * depth, 1.0);
      n = view * (normal + swing * tilt);
      c = colour;
    }`;
  const FRAGMENT = `
    precision mediump float;
    varying vec3 n; varying vec3 c;
    uniform float ambient;
    void main() { gl_FragColor = vec4(c * (ambient + (1.0 - ambient) * abs(normalize(n).z)), 1.0); }`;

  // The program; null if the browser cannot make it.
  const compiled = (gl) => {
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
  };

  // An edge is lighter than dark faces beside it, and darker than light ones.
  const ofEdge = (colours) => {
    const mean = [0, 1, 2].map((c) => colours.reduce((sum, colour) => sum + colour[c], 0) / colours.length);
    const light = (0.2126 * mean[0] + 0.7152 * mean[1] + 0.0722 * mean[2]) / 255;
    return light < 0.3 ? mean.map((value) => value + 0.5 * (255 - value)) : mean.map((value) => 0.35 * value);
  };

  window.nailnoise.painter = (gl, bodies, parts) => {
    const program = compiled(gl);
    if (!program) return null;
    gl.useProgram(program);
    let corners = 0, ends = 0;
    for (const part of parts) {
      part.first = corners;
      part.firstEnd = ends;
      corners += part.corners.length;
      ends += 2 * part.edges.length;
    }
    // Values of the corners of all faces, or of the ends of all edges.
    const values = (Kind, count) => new Kind(3 * count);
    const faces = {
      place: values(Float32Array, corners), normal: values(Float32Array, corners), tilt: values(Float32Array, corners),
      colour: values(Uint8Array, corners), move: values(Int8Array, corners),
    };
    const edges = { place: values(Float32Array, ends), colour: values(Uint8Array, ends),
      move: values(Int8Array, ends) };
    const copy = (to, from, point, at) =>
      { for (let axis = 0; axis < 3; axis++) to[3 * at + axis] = from[3 * point + axis]; };
    const pointwise = (faces, edges, values) => {
      for (const part of parts) {
        const own = values(part.body);
        part.corners.forEach((point, corner) => copy(faces, own, point, part.first + corner));
        part.edges.forEach((edge, number) => edge.ends.forEach((point, end) =>
          copy(edges, own, point, part.firstEnd + 2 * number + end)));
      }
    };
    pointwise(faces.place, edges.place, (body) => bodies[body].points);
    for (const part of parts) faces.normal.set(part.normals, 3 * part.first);

    const buffers = new Map();
    const store = (values) => {
      if (!buffers.has(values)) buffers.set(values, gl.createBuffer());
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers.get(values));
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    };
    [faces, edges].forEach((set) => Object.values(set).forEach(store));
    const kinds = new Map([[Float32Array, [gl.FLOAT, false]], [Uint8Array, [gl.UNSIGNED_BYTE, true]],
      [Int8Array, [gl.BYTE, true]]]);
    const use = (set) => {
      for (const name of ["place", "normal", "tilt", "colour", "move"]) {
        const location = gl.getAttribLocation(program, name);
        if (location < 0) continue;
        if (!set[name]) {
          gl.disableVertexAttribArray(location);
          gl.vertexAttrib3f(location, 0, 0, name === "normal" ? 1 : 0);
          continue;
        }
        gl.bindBuffer(gl.ARRAY_BUFFER, buffers.get(set[name]));
        gl.enableVertexAttribArray(location);
        gl.vertexAttribPointer(location, 3, ...kinds.get(set[name].constructor), 0, 0);
      }
    };
    const uniform = (name) => gl.getUniformLocation(program, name);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    // Faces lie a little behind their edges.
    gl.polygonOffset(1, 2);

    return {
      faces, edges,
      // Colours of the triangles of each part; null for a covered one.
      colour(ofTriangle) {
        for (const part of parts) {
          const colours = part.list.map((_, place) => ofTriangle(part, place) || NEUTRAL);
          colours.forEach((colour, place) => {
            for (let corner = 0; corner < 3; corner++) faces.colour.set(colour, 3 * (part.first + 3 * place + corner));
          });
          part.edges.forEach((edge, number) => {
            const colour = ofEdge(edge.triangles.map((triangle) => colours[triangle]));
            for (let end = 0; end < 2; end++) edges.colour.set(colour, 3 * (part.firstEnd + 2 * number + end));
          });
        }
        store(faces.colour);
        store(edges.colour);
      },
      // Displacements relative to the largest of a mode, in 127 steps; null for a body at rest.
      deform(shapes) {
        faces.tilt.fill(0);
        const none = bodies.map((body) => new Int8Array(body.points.length));
        pointwise(faces.move, edges.move, (body) => shapes[body] || none[body]);
        for (const part of parts) {
          if (!shapes[part.body]) continue;
          const unit = Float32Array.from(shapes[part.body], (value) => value / 127);
          faces.tilt.set(window.nailnoise.geometry.tilts(part, bodies[part.body].points, unit), 3 * part.first);
        }
        [faces.tilt, faces.move, edges.move].forEach(store);
      },
      // Draws what is shown: `half` of the canvas and of the `depth` in units of space, each part raised by its `lift`.
      draw({ rows, target, half, middle, depth, swing, shown, lift, withEdges, width, height }) {
        gl.viewport(0, 0, width, height);
        gl.uniformMatrix3fv(uniform("view"), false, [0, 1, 2].flatMap((axis) => rows.map((row) => row[axis])));
        gl.uniform3fv(uniform("target"), target);
        gl.uniform2fv(uniform("scale"), half.map((value) => 1 / value));
        gl.uniform1f(uniform("middle"), middle);
        gl.uniform1f(uniform("depth"), 0.98 / depth);
        gl.uniform1f(uniform("swing"), swing);
        gl.clearColor(0, 0, 0, 0);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        const each = (own) => parts.forEach((part, index) => {
          if (!shown[index]) return;
          gl.uniform3fv(uniform("lift"), [0, 0, lift[index]]);
          own(part);
        });
        use(faces);
        gl.uniform1f(uniform("ambient"), AMBIENT);
        gl.enable(gl.POLYGON_OFFSET_FILL);
        each((part) => gl.drawArrays(gl.TRIANGLES, part.first, part.corners.length));
        gl.disable(gl.POLYGON_OFFSET_FILL);
        if (!withEdges) return;
        use(edges);
        gl.uniform1f(uniform("ambient"), 1);
        each((part) => gl.drawArrays(gl.LINES, part.firstEnd, 2 * part.edges.length));
      },
    };
  };
})();
