// Modes in the view in space: the largest displacement, and on request the oscillation, in which a second shows one
// period.
(() => {
  // Calls `act.choose(mode)` with the mode whose button or option is used, null for none, and `act.swing(value, now)`
  // with its displacement in the steps of the points, which is drawn now or with the next frame.
  window.nailnoise.modes = (figure, data, act) => {
    const chosen = figure.querySelector(".mode"), play = figure.querySelector(".play");
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    let mode = null, since = null, swing = 0;
    const to = (value, now) => { swing = value; act.swing(value, now); };
    const pause = () => { since = null; play.textContent = still.matches ? "Other way" : "Play"; };
    const choose = (index) => {
      const given = data[index];
      mode = given ? { ...given, shape: new Int8Array(window.nailnoise.geometry.bytes(given.shape).buffer) } : null;
      chosen.value = mode ? String(index) : "";
      play.hidden = !mode;
      act.choose(mode);
      to(mode ? mode.reach : 0, false);
      pause();
    };
    const step = (now) => {
      if (since === null || !mode) return;
      to(mode.reach * Math.cos(2 * Math.PI * (now - since) / 1000), true);
      requestAnimationFrame(step);
    };
    const start = () => {
      // Where motion is unwelcome, the button shows the other end of the oscillation.
      if (still.matches) return to(-swing, false);
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
    return { stop: () => choose(-1) };
  };
})();
