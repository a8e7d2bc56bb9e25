// Gestures on the view in space: mouse, fingers and keys, in terms of the camera.
(() => {
  const TAP = 6; // pixels that a pointer may move during a click

  // Calls `act` with what a gesture asks for: turn(azimuth, elevation), move(x, y), zoom(factor, x, y), read(x, y),
  // hover(x, y), only(x, y), reset(). Places are from -1 to 1 to the right and up; moves in halves of the canvas.
  window.nailnoise.gestures = (canvas, act, moves) => {
    const place = (x, y) => {
      const box = canvas.getBoundingClientRect();
      return [2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height];
    };
    const by = (dx, dy) => [2 * dx / canvas.clientWidth, -2 * dy / canvas.clientHeight];
    const down = new Map();
    let travelled = 0;
    const middle = () => {
      const all = [...down.values()], mean = (axis) => all.reduce((sum, at) => sum + at[axis], 0) / all.length;
      const at = [mean(0), mean(1)];
      return { at, spread: Math.hypot(all[0][0] - at[0], all[0][1] - at[1]) };
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (!down.size) travelled = 0;
      down.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
    });
    const up = (event) => {
      const clicked = down.delete(event.pointerId) && !down.size && travelled < TAP;
      if (event.type === "pointerup" && clicked && event.button === 0) act.read(...place(event.clientX, event.clientY));
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("pointermove", (event) => {
      if (!down.has(event.pointerId)) {
        act.hover(...place(event.clientX, event.clientY));
        return;
      }
      const before = middle();
      const [x, y] = down.get(event.pointerId);
      down.set(event.pointerId, [event.clientX, event.clientY]);
      travelled += Math.hypot(event.clientX - x, event.clientY - y);
      const after = middle(), [dx, dy] = [after.at[0] - before.at[0], after.at[1] - before.at[1]];
      if (down.size > 1) {
        act.move(...by(dx, dy));
        if (before.spread > 0) act.zoom(after.spread / before.spread, ...place(...after.at));
      } else if (moves() || event.shiftKey || event.buttons & 6) {
        act.move(...by(dx, dy));
      } else {
        act.turn(-0.008 * dx, 0.008 * dy);
      }
    });
    // One finger scrolls the page up and down; two belong to the view.
    canvas.addEventListener("touchmove", (event) =>
      { if (event.touches.length > 1) event.preventDefault(); }, { passive: false });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return; // the page scrolls
      event.preventDefault();
      act.zoom(Math.exp(-0.003 * event.deltaY), ...place(event.clientX, event.clientY));
    }, { passive: false });
    canvas.addEventListener("dblclick", (event) => act.only(...place(event.clientX, event.clientY)));
    canvas.addEventListener("keydown", (event) => {
      const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      const keys = { "+": () => act.zoom(1.25, 0, 0), "-": () => act.zoom(0.8, 0, 0),
        Enter: () => act.read(0, 0), Escape: act.reset };
      if (event.ctrlKey || event.metaKey || event.altKey || (!arrow && !keys[event.key])) return;
      event.preventDefault();
      if (!arrow) keys[event.key]();
      else if (event.shiftKey) act.move(0.1 * arrow[0], 0.1 * arrow[1]);
      else act.turn(0.1 * arrow[0], 0.1 * arrow[1]);
    });
  };
})();
