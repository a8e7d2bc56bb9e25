// The drawing of the tool: a key that is pointed at or focused is highlighted in all views and in the table of keys.
(() => {
  const keys = new Map();
  for (const part of document.querySelectorAll(".of-tool .key[data-key], .keys-of-drawing tr[data-key]")) {
    const own = keys.get(part.dataset.key) || [];
    own.push(part);
    keys.set(part.dataset.key, own);
  }
  for (const own of keys.values()) {
    const light = (on) => own.forEach((part) => part.classList.toggle("lit", on));
    for (const part of own) {
      for (const [begin, end] of [["pointerenter", "pointerleave"], ["focus", "blur"]]) {
        part.addEventListener(begin, () => light(true));
        part.addEventListener(end, () => light(false));
      }
    }
  }
})();
