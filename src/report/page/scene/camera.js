// The camera of the surfaces in space: an orthographic view, by an azimuth about the vertical and an elevation.
(() => {
  const LARGEST = 40, SMALLEST = 0.4; // of the size at which everything fits
  const MARGIN = 0.94; // of the canvas that the content fills

  // A camera that begins with the line of sight `towards` the viewer.
  window.nailnoise.camera = (towards) => {
    const first = { azimuth: Math.atan2(towards[1], towards[0]), elevation: Math.asin(towards[2]) };
    const right = Math.PI / 2, steep = 1.57;
    const sides = {
      first, front: { azimuth: -right, elevation: 0 },
        right: { azimuth: 0, elevation: 0 }, back: { azimuth: right, elevation: 0 },
      left: { azimuth: 2 * right, elevation: 0 },
        above: { azimuth: -right, elevation: steep }, below: { azimuth: -right, elevation: -steep },
    };
    // `target` is the place in the middle of the canvas; `across` the width and height that fit at zoom 1.
    const own = { ...first, zoom: 1, target: [0, 0, 0], across: [1, 1], fitted: true };

    // To the right, up, and towards the viewer.
    own.axes = () => {
      const [ca, sa, ce, se] = [Math.cos(own.azimuth), Math.sin(own.azimuth),
        Math.cos(own.elevation), Math.sin(own.elevation)];
      return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
    };
    // Half of the canvas in units of space, for its width and height.
    own.half = (width, height) => {
      const size = MARGIN * own.zoom * Math.min(width / own.across[0], height / own.across[1]);
      return [0.5 * width / size, 0.5 * height / size];
    };
    own.fit = (ends) => {
      const rows = own.axes();
      const { low, high } = ends(rows);
      const middle = [0, 1, 2].map((axis) => 0.5 * (low[axis] + high[axis]));
      own.target = [0, 1, 2].map((axis) => rows.reduce((sum, row, number) => sum + middle[number] * row[axis], 0));
      own.across = [0, 1].map((axis) => Math.max(high[axis] - low[axis], 1e-9));
      Object.assign(own, { zoom: 1, fitted: true });
    };
    own.look = (side) => Object.assign(own, sides[side]);
    own.turn = (azimuth, elevation) => {
      own.azimuth += azimuth;
      own.elevation = Math.max(-steep, Math.min(steep, own.elevation + elevation));
    };
    // Moves the content by a fraction of half the canvas, to the right and up.
    own.move = (x, y, width, height) => {
      const rows = own.axes(), half = own.half(width, height);
      own.target = own.target.map((value, axis) => value - x * half[0] * rows[0][axis] - y * half[1] * rows[1][axis]);
      own.fitted = false;
    };
    // Magnifies the view; the place at (x, y), from -1 to 1 to the right and up, stays where it is.
    own.zoomBy = (factor, x, y, width, height) => {
      const before = own.half(width, height);
      own.zoom = Math.max(SMALLEST, Math.min(LARGEST, own.zoom * factor));
      const after = own.half(width, height), rows = own.axes();
      const [dx, dy] = [x * (before[0] - after[0]), y * (before[1] - after[1])];
      own.target = own.target.map((value, axis) => value + dx * rows[0][axis] + dy * rows[1][axis]);
      own.fitted = false;
    };
    return own;
  };
})();
