"use strict";
// Follows `nailnoise watch`: what the bar says, and each new report in place of the old one, at the same place of the page.
(() => {
  const part = (id) => document.getElementById(id);
  const [bar, status, failure, place, form] = ["bar", "status", "failure", "report", "sliders"].map(part);
  let wanted = null, markup = null;
  const post = (path) => fetch(path, { method: "POST" });

  // Sliders: each move is sent once the hand rests for a moment; what is being dragged is left to the hand.
  const figures = (value) => Number(value.toPrecision(4)).toString();
  let offered = null, dragged = null, sent = 0;
  const row = ({ key, range: [low, high], unit, whole }) => {
    const label = document.createElement("label"), name = document.createElement("code"), input = document.createElement("input");
    const output = document.createElement("output");
    // A long key is broken behind a dot or an underscore.
    name.append(...key.split(/(?<=[._])/).flatMap((piece) => [piece, document.createElement("wbr")]));
    const shown = unit.replace(/(?<=[a-z])[23]/g, (digit) => ({ 2: "\u00b2", 3: "\u00b3" })[digit]);
    Object.assign(input, { type: "range", name: key, min: low, max: high, step: whole ? 1 : "any" });
    input.setAttribute("aria-description", `${figures(low)} to ${figures(high)} ${shown}`);
    const say = () => { output.textContent = `${whole ? Math.round(input.value) : figures(Number(input.value))} ${shown}`; };
    // A key moves a continuous range by a fiftieth, not by the browser's guess.
    input.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!by || whole) return;
      event.preventDefault();
      input.value = Math.min(high, Math.max(low, Number(input.value) + by * (high - low) / 50));
      input.dispatchEvent(new Event("input"));
    });
    input.addEventListener("input", () => {
      say();
      dragged = key;
      clearTimeout(sent);
      sent = setTimeout(() => { dragged = null; post(`move?${key}=${input.value}`); }, 150);
    });
    label.append(name, input, output);
    return { label, input, say };
  };
  const rows = new Map();
  const slide = (news) => {
    form.hidden = news.sliders.length === 0;
    const structure = JSON.stringify(news.sliders.map(({ key, range, unit }) => [key, range, unit]));
    if (structure !== offered && dragged === null) {
      offered = structure;
      rows.clear();
      news.sliders.forEach((own) => rows.set(own.key, row(own)));
      const line = document.createElement("p"), why = document.createElement("span");
      line.className = "line quiet";
      for (const [path, text] of [["save", "Save as design"], ["reset", "Back to the file"]]) {
        const button = document.createElement("button");
        Object.assign(button, { type: "button", textContent: text });
        button.dataset.post = path;
        line.append(button);
      }
      const told = document.createElement("output");
      told.id = "saved";
      why.textContent = news.basis ? `Chosen by: ${news.basis}.` : "";
      line.append(told, why);
      form.replaceChildren(...[...rows.values()].map(({ label }) => label), line);
    }
    for (const own of news.sliders) {
      const there = rows.get(own.key);
      if (!there) continue;
      if (own.key !== dragged) { there.input.value = own.value; there.say(); }
      there.label.classList.toggle("moved", news.moved.includes(own.key));
    }
    const told = part("saved");
    if (told) told.textContent = news.saved ?? "";
    form.querySelectorAll("button").forEach((button) => { button.disabled = news.moved.length === 0; });
  };

  // The pinned and the last run in a loop, in turn, at their relative loudness.
  let context = null, playing = null;
  const listen = async (button) => {
    if (playing) { playing.stop(); playing = null; hear(); return; }
    context ??= new AudioContext();
    await context.resume();
    const names = ["pinned", "last"];
    const sounds = await Promise.all(names.map(async (name) => context.decodeAudioData(await (await fetch("sound/" + name)).arrayBuffer())));
    const gap = 0.25, length = sounds.reduce((sum, sound) => sum + sound.duration + gap, 0), rate = sounds[0].sampleRate;
    const both = context.createBuffer(1, Math.ceil(length * rate), rate), data = both.getChannelData(0);
    let at = 0;
    const begins = sounds.map((sound, index) => {
      const begin = at, scale = Number(button.dataset[names[index]]);
      sound.getChannelData(0).forEach((value, n) => { data[Math.round(begin * rate) + n] = scale * value; });
      at += sound.duration + gap;
      return begin;
    });
    const source = context.createBufferSource(), since = context.currentTime;
    Object.assign(source, { buffer: both, loop: true });
    source.connect(context.destination);
    source.start();
    const timer = setInterval(() => hear((context.currentTime - since) % both.duration < begins[1] ? "pinned run" : "this run"), 60);
    playing = { stop: () => { clearInterval(timer); source.stop(); }, peaks: sounds.map((sound) => sound.duration) };
    hear();
  };
  const hear = (now = "") => {
    const heard = part("heard"), button = bar.querySelector("[data-listen]");
    if (heard) heard.textContent = now;
    if (button) button.textContent = playing ? "Stop" : "Listen to both";
  };

  // Charts may take long to draw: the new report is shown when they are there, or after a second.
  const drawn = (frame) => Promise.race([frame.contentWindow.nailnoise?.ready, new Promise((done) => setTimeout(done, 1000))]);

  const takeOver = (from, to) => {
    const open = (frame) => [...frame.contentDocument.querySelectorAll("details")];
    const before = open(from), after = open(to);
    if (before.length === after.length) after.forEach((own, i) => { own.open = before[i].open; });
    to.contentWindow.scrollTo({ left: from.contentWindow.scrollX, top: from.contentWindow.scrollY, behavior: "instant" });
  };

  const bring = (number) => {
    wanted = number;
    place.querySelectorAll("iframe.next").forEach((frame) => frame.remove());
    const next = document.createElement("iframe");
    Object.assign(next, { title: "Report of the last run", className: "next", src: "report?" + number });
    next.addEventListener("load", async () => {
      await drawn(next);
      if (wanted !== number) return;
      const old = place.querySelector("iframe:not(.next)");
      if (old) takeOver(old, next);
      next.classList.remove("next");
      if (old) old.remove();
      // For whoever looks after the page from outside.
      document.documentElement.dataset.shown = number;
    }, { once: true });
    place.append(next);
  };

  const events = new EventSource("events");
  events.onmessage = ({ data }) => {
    const news = JSON.parse(data);
    document.body.classList.remove("gone");
    document.title = news.title;
    status.textContent = news.status;
    if (failure.textContent !== (news.failure ?? "")) failure.textContent = news.failure ?? "";
    failure.hidden = news.failure === null;
    if (markup !== news.bar) {
      const focused = document.activeElement?.dataset?.post;
      if (playing) { playing.stop(); playing = null; }
      bar.innerHTML = markup = news.bar;
      if (focused) bar.querySelector("button")?.focus();
    }
    slide(news);
    if (news.report !== null && news.report !== wanted) bring(news.report);
  };
  events.onerror = () => {
    document.body.classList.add("gone");
    status.textContent = "nailnoise watch has ended; this is its last result";
  };
  document.querySelector("header").addEventListener("click", ({ target }) => {
    const button = target.closest("button");
    if (button?.dataset.post) post(button.dataset.post);
    if (button?.dataset.listen !== undefined) listen(button);
  });
})();
