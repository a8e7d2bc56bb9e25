// Geometry of the surfaces in space: parts, sharp edges, and normals that are smooth between them.
(() => {
  // Faces that meet at a smaller angle are shaded as one curved surface; a larger one is an edge.
  const LIMIT = Math.cos(40 * Math.PI / 180);

  const bytes = (text) => Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const difference = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const scaled = (a, factor) => a.map((value) => factor * value);
  const vector = (values, index) => [values[3 * index], values[3 * index + 1], values[3 * index + 2]];

  // The unit normal of each triangle, zero without an area; twice its area; the angles at its corners, which weight it.
  const facets = (points, corners) => {
    const found = [];
    for (let first = 0; first < corners.length; first += 3) {
      const p = [0, 1, 2].map((corner) => vector(points, corners[first + corner]));
      const n = cross(difference(p[1], p[0]), difference(p[2], p[0])), twice = Math.hypot(...n);
      const angles = [0, 1, 2].map((corner) => {
        const [u, v] = [1, 2].map((other) => difference(p[(corner + other) % 3], p[corner]));
        return Math.atan2(Math.hypot(...cross(u, v)), dot(u, v));
      });
      found.push({ normal: twice ? scaled(n, 1 / twice) : [0, 0, 0], twice, angles });
    }
    return found;
  };

  // Joins the corners of triangles that meet at a point without a sharp edge between them. Returns the group of each
  // corner and the sharp edges: two points, and the triangles beside them.
  const smoothed = (corners, facets) => {
    const parent = Uint32Array.from(corners, (_, index) => index);
    const root = (corner) => {
      while (parent[corner] !== corner) corner = parent[corner] = parent[parent[corner]];
      return corner;
    };
    const beside = new Map();
    for (let corner = 0; corner < corners.length; corner++) {
      const other = corner % 3 === 2 ? corner - 2 : corner + 1;
      const [a, b] = [Math.min(corners[corner], corners[other]), Math.max(corners[corner], corners[other])];
      const key = a * 2 ** 26 + b;
      if (!beside.has(key)) beside.set(key, []);
      beside.get(key).push([corner, other]);
    }
    const edges = [], ends = new Map();
    const smooth = (sides) => {
      for (const corner of sides[0]) {
        const same = sides[1].find((other) => corners[other] === corners[corner]);
        parent[root(corner)] = root(same);
      }
    };
    for (const sides of beside.values()) {
      const triangles = sides.map(([corner]) => Math.floor(corner / 3));
      const [s, t] = triangles.map((triangle) => facets[triangle]);
      // A triangle without area has no normal, and no edge.
      if (sides.length === 2 && (!s.twice || !t.twice || dot(s.normal, t.normal) >= LIMIT)) {
        smooth(sides);
        continue;
      }
      const edge = { sides, triangles, ends: sides[0].map((corner) => corners[corner]) };
      edges.push(edge);
      edge.ends.forEach((point) => ends.set(point, (ends.get(point) || 0) + 1));
    }
    // An edge that no other one continues at either end is a crease of a coarse mesh.
    const crease = ({ sides, ends: own }) => sides.length === 2 && own.every((point) => ends.get(point) === 1);
    edges.filter(crease).forEach(({ sides }) => smooth(sides));
    return { group: Uint32Array.from(corners, (_, corner) => root(corner)),
      edges: edges.filter((edge) => !crease(edge)) };
  };

  // The mean of vectors of triangles at each corner over its group, weighted by angles, relative to the length of the
  // mean normal.
  const means = (part, ofTriangle) => {
    const sums = new Float64Array(3 * part.corners.length), lengths = new Float64Array(3 * part.corners.length);
    part.facets.forEach((facet, triangle) => {
      const own = ofTriangle(facet, triangle);
      for (let corner = 0; corner < 3; corner++) {
        const at = 3 * part.group[3 * triangle + corner];
        for (let axis = 0; axis < 3; axis++) {
          sums[at + axis] += facet.angles[corner] * own[axis];
          lengths[at + axis] += facet.angles[corner] * facet.normal[axis];
        }
      }
    });
    const found = new Float32Array(3 * part.corners.length);
    for (let corner = 0; corner < part.corners.length; corner++) {
      const size = Math.hypot(...vector(lengths, part.group[corner])) || 1;
      for (let axis = 0; axis < 3; axis++) found[3 * corner + axis] = sums[3 * part.group[corner] + axis] / size;
    }
    return found;
  };
  const normals = (part) => means(part, (facet) => facet.normal);

  // Change of the normals with the displacement of a mode, to first order: n' = (dn - n (n dn))/|n| with
  // dn = du x v + u x dv, where u and v are sides of the triangle.
  const tilts = (part, points, shape) => means(part, (facet, triangle) => {
    if (!facet.twice) return [0, 0, 0];
    const [a, b, c] = [0, 1, 2].map((corner) => part.corners[3 * triangle + corner]);
    const side = (values, end) => difference(vector(values, end), vector(values, a));
    const first = cross(side(shape, b), side(points, c)), second = cross(side(points, b), side(shape, c));
    const change = [0, 1, 2].map((axis) => (first[axis] + second[axis]) / facet.twice);
    const along = dot(change, facet.normal);
    return change.map((value, axis) => value - along * facet.normal[axis]);
  });

  // A part whose corners are indices of points.
  const part = (points, corners) => {
    const own = { corners, facets: facets(points, corners) };
    Object.assign(own, smoothed(corners, own.facets));
    own.normals = normals(own);
    return own;
  };

  // The bodies of the page's data, and their parts. `list` are the triangles of a part in its body, free ones first.
  const decoded = (data) => {
    const bodies = data.bodies.map((body) => ({
      name: body.name,
      points: new Int16Array(bytes(body.points).buffer),
      triangles: new Uint32Array(bytes(body.triangles).buffer),
      levels: body.levels.map(bytes),
    }));
    const parts = data.bodies.flatMap((body, number) => body.parts.map((given) => {
      const range = ([from, to]) => Array.from({ length: to - from }, (_, index) => from + index);
      const list = [...range(given.free), ...range(given.covered)];
      const own = bodies[number];
      const corners = Uint32Array.from(
        list.flatMap((triangle) => [...own.triangles.subarray(3 * triangle, 3 * triangle + 3)]));
      const name = body.parts.length > 1 ? `${body.name}, ${given.name}` : body.name;
      return { name, body: number, stack: given.stack, list, ...part(own.points, corners) };
    }));
    return { bodies, parts };
  };

  window.nailnoise.geometry = { bytes, dot, part, decoded, tilts };
})();
