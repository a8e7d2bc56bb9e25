// Charts: values under the pointer or the arrow keys, series that are switched off, and a zoom that all charts of time share.
(() => {
  const ACROSS = 4000, UP = 2000;
  const SHOW = 14; // most series in a tip
  const number = (value) => {
    if (!Number.isFinite(value)) return "\u2013";
    const size = Math.abs(value);
    const digits = size >= 100 || size === 0 ? 1 : size >= 1 ? 2 : 4;
    return (+value.toFixed(digits)).toString().replace("-", "\u2212");
  };

  // The points of a curve, in the coordinates of its path: M begins a piece, steps follow.
  const points = (path) => {
    const found = [];
    for (const piece of (path.getAttribute("d") || "").split("M").slice(1)) {
      const values = piece.match(/-?\d+/g).map(Number);
      let [x, y] = values;
      found.push([x, y]);
      for (let i = 2; i + 1 < values.length; i += 2) found.push([x += values[i], y += values[i + 1]]);
      found.push(null);
    }
    return found;
  };
  // The ordinate of a curve at an abscissa; none in a gap.
  const at = (curve, x) => {
    for (let i = 1; i < curve.length; i++) {
      const [a, b] = [curve[i - 1], curve[i]];
      if (a && b && a[0] <= x && x <= b[0]) return b[0] === a[0] ? b[1] : a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]);
    }
    return NaN;
  };
  const nearest = (dots, x) => dots.filter(Boolean).reduce((best, dot) => Math.abs(dot[0] - x) < Math.abs(best[0] - x) ? dot : best, [Infinity, NaN]);
  const ticks = (low, high, most) => {
    const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((digit) => digit * power).find((own) => own >= raw * 0.999);
    const decimals = Math.max(0, -Math.floor(Math.log10(step)));
    const found = [];
    for (let i = Math.ceil(low / step - 1e-6); i * step <= high + 1e-6 * step; i++) {
      found.push([(i * step - low) / (high - low), (i * step).toFixed(decimals).replace("-", "\u2212")]);
    }
    return found;
  };

  const tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  document.body.append(tip);
  const live = document.createElement("p");
  live.className = "unseen";
  live.setAttribute("aria-live", "polite");
  document.body.append(live);

  const panels = [...document.querySelectorAll(".panel")].filter((panel) => panel.querySelector(".plot")).map((panel) => {
    const ends = (name) => panel.dataset[name].split(" ").map(Number);
    const plot = panel.querySelector(".plot"), svg = plot.querySelector("svg");
    const cursor = document.createElement("i");
    cursor.className = "cursor";
    cursor.hidden = true;
    plot.append(cursor);
    return {
      panel, plot, svg, cursor, full: ends("x"), shown: ends("x"), y: ends("y"), at: 0.5,
      categories: panel.dataset.categories ? panel.dataset.categories.split("|") : null,
      series: [...svg.querySelectorAll(".s")], curves: new Map(),
    };
  });

  // What the series have at a place of the plot, 0 to 1 from its left end.
  const values = (own, place) => {
    const [from, to] = own.shown;
    const x = from + place * (to - from);
    const category = own.categories && Math.min(own.categories.length - 1, Math.max(0, Math.floor(x)));
    const head = own.categories ? `${own.categories[category]} ${own.panel.dataset.across || ""}` : `${number(x)} ${own.panel.dataset.across || ""}`;
    const rows = [];
    for (const group of own.series.filter((group) => !group.classList.contains("off") && (group.dataset.name || group.dataset.notes))) {
      let text;
      if (own.categories) {
        const value = (group.dataset.values || "").split(" ")[category];
        const note = (group.dataset.notes || "").split("|")[category];
        if (!value) continue;
        text = note || `${number(+value)} ${own.panel.dataset.unit}`;
      } else {
        const path = group.querySelector("path.line, path.broad, path.dashed") || group.querySelector("path.dots");
        if (!path) continue;
        if (!own.curves.has(group)) own.curves.set(group, points(path));
        const curve = own.curves.get(group), wide = own.full[1] - own.full[0], here = (x - own.full[0]) / wide * ACROSS;
        // Of points that no line joins the nearest one, with its own abscissa.
        const dot = path.matches(".dots") ? nearest(curve, here) : null;
        const y = dot ? dot[1] : at(curve, here);
        if (!Number.isFinite(y)) continue;
        text = `${number(own.y[0] + (1 - y / UP) * (own.y[1] - own.y[0]))} ${own.panel.dataset.unit}`;
        if (dot) text += ` at ${number(own.full[0] + dot[0] / ACROSS * wide)} ${own.panel.dataset.across || ""}`.trimEnd();
      }
      rows.push([group, group.dataset.name || "", text]);
    }
    // The event that is closest, if it is close.
    const events = [...own.panel.querySelectorAll(".events abbr")].map((event) => [Math.abs(+event.dataset.at - x), event.title]);
    const closest = events.sort((a, b) => a[0] - b[0])[0];
    return { head, rows, event: closest && closest[0] < 0.015 * (to - from) ? closest[1] : null };
  };
  const show = (own, place, x, y) => {
    own.at = Math.min(1, Math.max(0, place));
    const { head, rows, event } = values(own, own.at);
    own.cursor.hidden = false;
    own.cursor.style.left = `${100 * own.at}%`;
    const line = (text, group) => {
      const row = document.createElement("div");
      if (group) {
        const dot = document.createElement("i");
        dot.className = `dot ${[...group.classList].find((name) => /^c\d+$/.test(name))}`;
        row.append(dot);
      }
      row.append(text);
      return row;
    };
    const head_ = document.createElement("b");
    head_.textContent = head;
    tip.replaceChildren(head_, ...rows.slice(0, SHOW).map(([group, name, text]) => line(`${name ? name + ": " : ""}${text}`, group)), ...(event ? [line(event)] : []));
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    const left = x + 16 + box.width > window.innerWidth ? x - 16 - box.width : x + 16;
    tip.style.left = `${Math.max(4, left)}px`;
    tip.style.top = `${Math.max(4, Math.min(window.innerHeight - box.height - 4, y + 12))}px`;
    return `${head}: ${rows.map(([, name, text]) => `${name} ${text}`).join(", ")}${event ? ", " + event : ""}`;
  };
  const hide = (own) => { tip.hidden = true; own.cursor.hidden = true; };

  // Shows a part of the time in all charts of a group.
  const zoom = (group, range) => {
    for (const own of panels.filter((own) => own.panel.dataset.group === group)) {
      const [low, high] = own.full;
      own.shown = range ? [Math.max(low, range[0]), Math.min(high, range[1])] : own.full;
      const [from, to] = own.shown;
      const left = ACROSS * (from - low) / (high - low), width = Math.max(1, ACROSS * (to - from) / (high - low));
      own.svg.setAttribute("viewBox", `${left} 0 ${width} ${UP}`);
      const xs = own.panel.querySelector(".xs");
      own.labels ??= xs.innerHTML;
      if (range) {
        xs.replaceChildren(...ticks(from, to, xs.clientWidth > 500 ? 8 : 4).map(([place, label]) => {
          const span = document.createElement("span");
          span.className = "tick";
          span.style.left = `${100 * place}%`;
          span.textContent = label;
          return span;
        }));
      } else {
        xs.innerHTML = own.labels;
      }
      for (const event of own.panel.querySelectorAll(".events abbr")) {
        const place = (+event.dataset.at - from) / (to - from);
        event.style.left = `${100 * place}%`;
        event.hidden = place < 0 || place > 1;
      }
      own.panel.classList.toggle("zoomed", !!range);
    }
  };
  const about = (own, factor) => {
    const [from, to] = own.shown, middle = from + own.at * (to - from), half = Math.max(0.25, 0.5 * factor * (to - from));
    zoom(own.panel.dataset.group, 2 * half >= own.full[1] - own.full[0] ? null : [middle - half, middle + half]);
  };

  for (const own of panels) {
    const { plot, panel } = own;
    const group = panel.dataset.group;
    let start = null, band = null;
    const place = (event) => {
      const box = plot.getBoundingClientRect();
      return (event.clientX - box.left) / box.width;
    };
    plot.tabIndex = 0;
    plot.addEventListener("pointermove", (event) => {
      const now = Math.min(1, Math.max(0, place(event)));
      show(own, now, event.clientX, event.clientY);
      if (band) {
        band.style.left = `${100 * Math.min(start, now)}%`;
        band.style.width = `${100 * Math.abs(now - start)}%`;
      }
    });
    plot.addEventListener("pointerleave", () => hide(own));
    plot.addEventListener("blur", () => hide(own));
    if (group) {
      plot.addEventListener("pointerdown", (event) => {
        if (event.pointerType === "touch") return;
        start = place(event);
        plot.setPointerCapture(event.pointerId);
        band = document.createElement("i");
        band.className = "band";
        plot.append(band);
      });
      const end = (event) => {
        if (!band) return;
        const now = Math.min(1, Math.max(0, place(event))), [from, to] = own.shown;
        band.remove();
        band = null;
        hide(own);
        const range = [Math.min(start, now), Math.max(start, now)].map((part) => from + part * (to - from));
        if (Math.abs(now - start) > 0.01 && range[1] - range[0] > 0.05) zoom(group, range);
      };
      plot.addEventListener("pointerup", end);
      plot.addEventListener("pointercancel", end);
      plot.addEventListener("dblclick", () => zoom(group, null));
      const back = document.createElement("button");
      back.type = "button";
      back.className = "whole";
      back.textContent = "whole shot";
      back.addEventListener("click", () => zoom(group, null));
      panel.querySelector(".legend").append(back);
    }
    plot.addEventListener("keydown", (event) => {
      const step = own.categories ? 1 / own.categories.length : event.shiftKey ? 0.1 : 0.01;
      const keys = {
        ArrowLeft: () => { own.at = Math.max(0, own.at - step); },
        ArrowRight: () => { own.at = Math.min(1, own.at + step); },
        "+": () => group && about(own, 0.5),
        "-": () => group && about(own, 2),
        Escape: () => group && zoom(group, null),
      };
      if (!keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
      const box = plot.getBoundingClientRect();
      live.textContent = show(own, own.at, box.left + own.at * box.width, box.top + 0.3 * box.height);
    });
  }

  // A click on an entry of a legend hides its series.
  for (const key of document.querySelectorAll(".legend [data-series]")) {
    key.addEventListener("click", () => {
      const off = key.getAttribute("aria-pressed") === "true";
      key.setAttribute("aria-pressed", String(!off));
      const own = key.closest(".panel").querySelectorAll(`.s[data-series="${key.dataset.series}"], .row [data-series="${key.dataset.series}"]`);
      own.forEach((part) => part.classList.toggle("off", off));
    });
  }

  // All details are printed, and are closed again behind it.
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open])")];
    opened.forEach((part) => { part.open = true; });
    if (panels.some((own) => own.panel.classList.contains("zoomed"))) zoom("time", null);
  });
  window.addEventListener("afterprint", () => opened.forEach((part) => { part.open = false; }));
  document.documentElement.classList.add("script");
  // For whoever looks after the page from outside: what stands under the pointer of a chart.
  window.nailnoise = { charts: panels.length, values: (index, place) => values(panels[index], place) };
})();
