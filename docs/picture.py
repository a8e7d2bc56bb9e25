"""Draws docs/output.png, the picture in the README, from the output files of two runs.

    cargo run --release -- run designs/n80cb.toml
    cargo run --release -- run designs/n80cb-sandbox.toml
    pip install matplotlib pyvista && python docs/picture.py
"""

import csv
from pathlib import Path

import matplotlib.image
import matplotlib.pyplot as plt
import pyvista

ROOT = Path(__file__).resolve().parent.parent
COLOURS = {"workpiece": "#0072B2", "exhaust": "#D55E00", "body": "#009E73"}  # Okabe and Ito, safe for the colour-blind


def levels(name):
    with open(ROOT / "out" / name / "levels.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    with open(ROOT / "out" / name / "ranking.csv", newline="") as file:
        ranking = [row for row in csv.DictReader(file) if row["source"] != "total"]
    return [float(row["band [Hz]"]) for row in rows], {
        # A body's modes may end below the last band, whose cell is empty then.
        f"{own['source']} ({own['method']})": (
            [float(row[f"{own['source']} L_W [dB]"] or "nan") for row in rows], float(own["L_WA [dB]"]))
        for own in ranking
    }


def spectra(axes, name, title):
    hz, sources = levels(name)
    for source, (band_levels, total) in sorted(sources.items(), key=lambda item: -item[1][1]):
        name, method = source.split(" ", 1)
        method = "(jets, unsteady flow)" if name == "exhaust" else method
        label = f"{name} {method}  {total:.1f} dB(A)"
        axes.step(hz, band_levels, where="mid", color=COLOURS[name], lw=1.8, label=label)
    axes.set_xscale("log")
    axes.set_xticks([63, 125, 250, 500, 1000, 2000, 4000, 8000], ["63", "125", "250", "500", "1k", "2k", "4k", "8k"])
    axes.minorticks_off()
    axes.set_ylim(28, 137)
    axes.grid(alpha=0.3)
    axes.set_title(title, loc="left", fontsize=10)
    axes.set_ylabel("$L_{W,1s}$ in dB re 1 pW s")
    axes.legend(loc="upper left", fontsize=8, frameon=False)


def field(band):
    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=(760, 1000))
    plotter.set_background("white")
    name = f"velocity exposure level {band} Hz octave [dB]"
    bar = {"title": f"velocity exposure level, {band} Hz octave, dB re (50 nm/s)^2 s\n ", "color": "black",
           "title_font_size": 20, "label_font_size": 18, "n_labels": 4, "fmt": "%.0f", "width": 0.8, "height": 0.08,
           "position_x": 0.1, "position_y": 0.02}
    for body in ("worktable", "workpiece"):
        mesh = pyvista.read(ROOT / "out" / "n80cb" / "fields" / f"{body}.vtu")
        plotter.add_mesh(mesh, scalars=name, cmap="viridis", clim=(75, 115), scalar_bar_args=bar)
    plotter.camera_position = [(1.35, -1.62, 0.5), (0, 0, -0.36), (0, 0, 1)]
    return plotter.screenshot(return_img=True)


figure = plt.figure(figsize=(11, 5.6), dpi=110)
grid = figure.add_gridspec(2, 2, width_ratios=(1.55, 1), hspace=0.32, wspace=0.06)
top, bottom = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1, 0])
spectra(top, "n80cb", "on worktable A")
spectra(bottom, "n80cb-sandbox", "in the sandbox")
bottom.set_xlabel("one-third-octave band in Hz")
right = figure.add_subplot(grid[:, 1])
right.imshow(field(500))
right.axis("off")
figure.savefig(ROOT / "docs" / "output.png", bbox_inches="tight", facecolor="white")
