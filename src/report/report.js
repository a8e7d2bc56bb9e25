"use strict";
// Draws every chart from the data beside it, zooms charts over time together, and switches between sounds.
(() => {
  const font = { family: "system-ui, -apple-system, 'Segoe UI', Roboto, Arial, 'DejaVu Sans', sans-serif", size: 13, color: "#1d2125" };
  const axis = { gridcolor: "#eaeaea", zerolinecolor: "#cfd4da", linecolor: "#888", ticks: "outside", tickcolor: "#888", automargin: true };
  const merge = (base, over) => {
    for (const key of Object.keys(over)) {
      const both = base[key] && typeof base[key] === "object" && !Array.isArray(over[key]) && over[key] && typeof over[key] === "object";
      base[key] = both ? merge({ ...base[key] }, over[key]) : over[key];
    }
    return base;
  };
  const plots = [...document.querySelectorAll(".plot")];
  const drawn = plots.map(async (plot) => {
    const { data, layout } = JSON.parse(document.getElementById(plot.id + "-data").textContent);
    // At the foot of the chart, below the axis and its title however many rows it has.
    const legend = { orientation: "h", x: 0, yref: "container", y: 0, yanchor: "bottom" };
    const full = merge({
      font, legend, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: !layout.scene,
      margin: { l: 58, r: 12, t: 34, b: 48 }, xaxis: { ...axis }, yaxis: { ...axis }, hoverlabel: { font: { size: 12 } },
    }, layout);
    await Plotly.newPlot(plot, data, full, { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d"] });
  });
  const ready = Promise.all(drawn).then(() => {
    const groups = plots.filter((plot) => plot.dataset.group);
    let following = false;
    for (const plot of groups) {
      plot.on("plotly_relayout", (change) => {
        if (following) return;
        const x = ["xaxis.range[0]", "xaxis.range[1]", "xaxis.autorange"].filter((key) => key in change);
        if (!x.length) return;
        following = true;
        const same = Object.fromEntries(x.map((key) => [key, change[key]]));
        const others = groups.filter((other) => other !== plot && other.dataset.group === plot.dataset.group);
        Promise.all(others.map((other) => Plotly.relayout(other, same))).finally(() => { following = false; });
      });
    }
    window.addEventListener("beforeprint", () => {
      document.querySelectorAll("details").forEach((part) => { part.open = true; });
      plots.forEach((plot) => Plotly.Plots.resize(plot));
    });
    return plots.length;
  });
  // For whoever looks after the page from outside: resolves with the number of charts once all are drawn.
  window.nailnoise = { ready };

  const players = [...document.querySelectorAll(".recording audio")];
  const control = (name) => document.querySelector(`[data-ab="${name}"]`);
  if (control("switch")) {
    let current = "B";
    control("switch").addEventListener("click", () => {
      const from = players[control(current).value];
      const at = from.paused ? 0 : from.currentTime;
      players.forEach((player) => player.pause());
      current = current === "A" ? "B" : "A";
      const to = players[control(current).value];
      to.currentTime = Math.min(at, to.duration || 0);
      to.play();
      control("now").textContent = "now " + current;
    });
  }
})();
