#!/usr/bin/env python3
"""The worktable case of the N80CB as open data for other programs, and CalculiX's modes of its bodies.

    apt-get install calculix-ccx
    cargo build --release
    python3 tests/peers/benchmark.py target/release/nailnoise FOLDER

Writes into FOLDER the geometry (Gmsh 2.2), the materials (case.json), the forces on the block over time, the exposure of
the surface velocities in third octaves (VTK), the modes, the sound power in third octaves and the pressures at nine
microphones. The example 13 adds the surface of block and table with its complex velocities at three frequencies.
docs/benchmark.md describes the files. Where `ccx` is installed, its frequencies on the same meshes are
added to the modes; they must agree to 2e-5, the rounding of modes.csv.
"""

import csv
import json
import math
import pathlib
import shutil
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[2]
DESIGN = ROOT / "designs" / "n80cb.toml"
# Frequencies of the surface velocities [Hz].
SURFACE_AT = ["200", "500", "1000"]
FORCES = ["penetration_force [N]", "nose_force [N]", "guard_force [N]"]
GROUPS = ("ambient.", "workpiece.", "wood.", "support.contact.", "support.worktable.", "acoustics.", "nail.")
# CalculiX numbers the middle nodes of a 20-node hexahedron face by face, Gmsh corner by corner.
GMSH_TO_CALCULIX = [*range(8), 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15]
HEX20, MODES = 17, 24


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def write(path, header, lines):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(lines)


def samples(path, full_scale):
    """The pressures of a mono file of 24 bits, in Pa."""
    data = path.read_bytes()
    at = data.index(b"data")
    length = struct.unpack("<I", data[at + 4 : at + 8])[0]
    body = data[at + 8 : at + 8 + length]
    scale = full_scale / 2**23
    return [int.from_bytes(body[i : i + 3], "little", signed=True) * scale for i in range(0, length, 3)]


def mesh(path):
    """Nodes, elements (part, nodes) and nodes of the face groups of a mesh in format 2.2."""
    lines = iter(path.read_text().splitlines())
    names, nodes, elements, groups = {}, {}, [], {}
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                dimension, number, name = next(lines).split(maxsplit=2)
                names[int(dimension), int(number)] = name.strip('"')
        elif line == "$Nodes":
            for _ in range(int(next(lines))):
                number, *point = next(lines).split()
                nodes[int(number)] = [float(x) for x in point]
        elif line == "$Elements":
            for _ in range(int(next(lines))):
                words = [int(word) for word in next(lines).split()]
                kind, tags = words[1], words[2]
                own, group = words[3 + tags :], words[3]
                if kind == HEX20:
                    elements.append((names[3, group], own))
                else:
                    groups.setdefault(names[2, group], set()).update(own)
    return nodes, elements, groups


def calculix(folder, name, materials, clamped):
    """The lowest frequencies by CalculiX; `materials` gives the constants and axes of each part."""
    nodes, elements, groups = mesh(folder / f"{name}.msh")
    text = ["*NODE, NSET=ALL"]
    text += [f"{number}, {', '.join(f'{x:.11e}' for x in point)}" for number, point in nodes.items()]
    for part in sorted({part for part, _ in elements}):
        text.append(f"*ELEMENT, TYPE=C3D20, ELSET=E_{part}")
        for number, (own, corners) in enumerate(elements, start=1):
            if own == part:
                listed = [number, *(corners[i] for i in GMSH_TO_CALCULIX)]
                text += [", ".join(map(str, listed[:11])) + ",", ", ".join(map(str, listed[11:]))]
        constants, axes, density = materials[part]
        text += [f"*MATERIAL, NAME=M_{part}", "*ELASTIC, TYPE=ENGINEERING CONSTANTS"]
        text += [", ".join(map(repr, constants[:8])), repr(constants[8])]
        text += ["*DENSITY", repr(density), f"*ORIENTATION, NAME=O_{part}", ", ".join(map(str, axes))]
        text.append(f"*SOLID SECTION, ELSET=E_{part}, MATERIAL=M_{part}, ORIENTATION=O_{part}")
    if clamped:
        text.append("*BOUNDARY")
        text += [f"{node}, 1, 3" for node in sorted(groups[clamped])]
    text += ["*STEP", "*FREQUENCY", str(MODES), "*END STEP", ""]
    deck = folder / f"{name}.inp"
    deck.write_text("\n".join(text))
    subprocess.run(["ccx", "-i", name], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    found = []
    for line in (folder / f"{name}.dat").read_text().splitlines():
        words = line.split()
        if len(words) == 5 and words[0].isdigit():
            found.append(float(words[3]))
        elif found:
            break
    for suffix in ("dat", "frd", "sta", "cvg", "12d", "eig"):
        (folder / f"{name}.{suffix}").unlink(missing_ok=True)
    (folder / "spooles.out").unlink(missing_ok=True)
    return found


def orthotropic(values, group, axes="123"):
    """Constants in CalculiX's order; those of wood have the names of its axes."""
    a, b, c = axes if axes == "123" else (f"_{axes[0]}", f"_{axes[1]}", f"_{axes[2]}")
    second = [own[-1] for own in (a, b, c)]
    names = [f"e{own}" for own in (a, b, c)]
    names += [f"{kind}{own}" for kind in ("nu", "g") for own in (a + second[1], a + second[2], b + second[2])]
    return [values[f"{group}.{name}"] for name in names]


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    out = folder / "run"
    subprocess.run([program, "run", DESIGN, "--out", out], check=True, stdout=subprocess.DEVNULL)
    for body in ("workpiece", "worktable"):
        file = folder / f"{body}.msh"
        command = [program, "mesh", DESIGN, "--body", body, "--write", file, "--format", "text22"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        shutil.copy(out / "fields" / f"{body}.vtu", folder / f"{body}-velocity.vtu")

    example = ["cargo", "run", "--release", "--quiet", "--example", "13_surface_velocities", "--"]
    subprocess.run([*example, DESIGN, folder.resolve(), *SURFACE_AT], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)

    result = json.loads((out / "result.json").read_text())
    inputs = [own for own in result["inputs"] if own["key"].startswith(GROUPS)]
    microphones = result["microphones"]
    case = {
        "schema": "nailnoise-benchmark/1",
        "design": result["design"],
        "inputs": inputs,
        "events_s": result["events"],
        "microphones_m": microphones["positions_m"],
        "sampling_rate_hz": 48000,
        "range_hz": microphones["range_hz"],
    }
    (folder / "case.json").write_text(json.dumps(case, indent=1) + "\n")

    histories = rows(out / "histories.csv")
    header = ["time [s]", *FORCES]
    write(folder / "forces.csv", header, ([row[name] for name in header] for row in histories))
    levels = rows(out / "levels.csv")
    header = ["band [Hz]", "workpiece L_W [dB]", "workpiece L_WA [dB]"]
    write(folder / "powers.csv", header, ([row[name] for name in header] for row in levels))
    signals = [
        samples(out / "microphones" / f"workpiece-{number + 1}.wav", microphones["full_scale_pa"])
        for number in range(len(microphones["positions_m"]))
    ]
    header = ["time [s]", *(f"p_{number + 1} [Pa]" for number in range(len(signals)))]
    lines = ([f"{i / 48000:.7f}", *(f"{p:.4e}" for p in own)] for i, own in enumerate(zip(*signals)))
    write(folder / "pressures.csv", header, lines)

    values = {own["key"]: own["value"] for own in result["inputs"]}
    wood = (orthotropic(values, "wood.elastic", "lrt"), WOOD_AXES, values["wood.density"])
    top = (orthotropic(values, "support.worktable.top"), TOP_AXES, values["support.worktable.top_density"])
    legs = (orthotropic(values, "support.worktable.legs"), LEG_AXES, values["support.worktable.leg_density"])
    bodies = {
        "workpiece": ({"block": wood}, None),
        "worktable": ({"top": top, "leg": legs}, "floor"),
    }
    modes, worst = rows(out / "modes.csv"), 0.0
    lines = []
    for body, (materials, clamped) in bodies.items():
        ours = [float(row["frequency [Hz]"]) for row in modes if row["body"] == body]
        theirs = calculix(folder, body, materials, clamped) if shutil.which("ccx") else []
        for number, hz in enumerate(ours, start=1):
            other = theirs[number - 1] if number <= len(theirs) else math.nan
            if hz > 1.0 and not math.isnan(other):
                worst = max(worst, abs(other / hz - 1.0))
            lines.append([body, number, hz, "" if math.isnan(other) else other])
    write(folder / "modes.csv", ["body", "mode", "frequency [Hz]", "CalculiX [Hz]"], lines)
    shutil.rmtree(out)
    print(f"largest difference from CalculiX: {worst:.1e}")
    if worst > 2e-5:
        sys.exit("the frequencies differ")


# Material axes 1 and 2 in global coordinates, as CalculiX reads them.
WOOD_AXES = (1, 0, 0, 0, 0, 1)
TOP_AXES = (1, 0, 0, 0, 1, 0)
LEG_AXES = (0, 0, 1, 0, 1, 0)

if __name__ == "__main__":
    main()
