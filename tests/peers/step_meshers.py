"""Whether rapidmesh, a mesher in Rust, could mesh the STEP file of a housing in place of gmsh.

    step_meshers.py NAILNOISE FOLDER [page|casting|thin|bore-x|bore-y ...]

Three housings are drawn by OpenCASCADE: the one of `docs/own-housing.md`; a casting with fillets, ribs, bores and a
handle swept along a curve; walls of 2 mm with bosses, a sleeve and a magazine as solids that touch. Two tubes with one
bore in the wall, along x and along y, narrow down what fails. gmsh meshes each through `nailnoise mesh`, with sides of
at most 18 and 10 mm. rapidmesh meshes it twice for each size: with that size and nothing else, and with a limit on the
geometric error of quadratic elements. `nailnoise check` and `nailnoise modes` read all meshes.

Prints a row for each mesh: elements, longest side, processor time, peak memory, errors of volume and outer area against
OpenCASCADE, inverted and poor elements, pieces, and the largest deviation of the first six elastic modes from gmsh at
the same size, for the first housing also from gmsh at 7 mm. Fails only if gmsh does not carry a shape at 10 mm. The
modules gmsh and rapidmesh must be installed (tried: 4.15.2 and 4.0.1). rapidmesh 0.6, the last under the MIT licence,
reads no STEP file.
"""

import json
import math
import os
import pathlib
import resource
import subprocess
import sys

import gmsh

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIZES = 18, 10
# Limits of rapidmesh on address space [bytes] and processor time [s]: the bore along y takes more than 5 GB.
MEMORY, SECONDS = 4 << 30, 120
FINE = 7
# rapidmesh uses its size as a mean: its longest sides are at most 1.8 times as long.
LONGEST = 1.8
# Options of rapidmesh for a size: those of a new user, and those of its documentation for quadratic elements.
WAYS = {
    "rapidmesh": lambda size: {"maxh": size},
    "rapidmesh, error": lambda size: {"maxh": size / LONGEST, "geom_error": 1e-3, "order": 2},
}
HEAD = """  mesher           size   elem.   side   time memory   volume     area  inv.  poor  pieces  modes from gmsh
                                     mm      s     MB        %        %                      same %  fine %"""
DESIGN = f"""base = "{ROOT}/designs/n80cb.toml"
[body]
model = "rigid" # only modes are computed: the meshes lack the surfaces of a tool
lumped = false
mesh = "NAME"
[analysis]
body_max_frequency = "4 kHz"
"""


def rapidmesh(step: str, options: str, msh: str) -> None:
    """The child process whose time and memory are measured."""
    import rapidmesh

    geometry = rapidmesh.Geometry()
    try:
        geometry.import_step(step)
        geometry.mesh(**json.loads(options)).write_msh(msh, order=2)
    except ValueError as error:
        sys.exit(str(error))


def bored(outer, holes):
    return gmsh.model.occ.cut(outer, [(3, hole) for hole in holes])[0]


def turned(tags, count, offset=0.0):
    """Turns solids about z to every count-th of a circle."""
    for number, tag in enumerate(tags):
        gmsh.model.occ.rotate([(3, tag)], 0, 0, 0, 0, 0, 1, 2 * math.pi * (number % count + offset) / count)


def rounded(x, y, z, length, width, height, radius):
    """A box with rounded edges."""
    occ = gmsh.model.occ
    box = occ.addBox(x, y, z, length, width, height)
    occ.synchronize()
    faces = gmsh.model.getBoundary([(3, box)], oriented=False)
    edges = gmsh.model.getBoundary(faces, combined=False, oriented=False)
    return occ.fillet([box], sorted({tag for _, tag in edges}), [radius])[0][1]


def casting():
    """Fillets, ribs, bores and a hollow handle that is swept along a spline."""
    occ = gmsh.model.occ
    barrel = occ.addCylinder(0, 0, 110, 0, 0, 200, 40)
    nose = occ.addCone(0, 0, 0, 0, 0, 115, 13, 20)
    arm = occ.addBox(10, -4, 45, 95, 8, 75)
    ribs = [occ.addBox(35, -2, 120, 15, 4, 110) for _ in range(6)]
    turned(ribs, 6, 0.5)
    flange = occ.addCylinder(0, 0, 298, 0, 0, 12, 52)

    def handle(radius, begin):
        points = (begin, 0, 275), (90, 0, 279), (150, 0, 268), (205, 0, 235)
        path = occ.addWire([occ.addSpline([occ.addPoint(*point) for point in points])])
        disc = occ.addDisk(begin, 0, 275, radius, radius, zAxis=[1, 0, 0.08], xAxis=[0, 1, 0])
        return [tag for dimension, tag in occ.addPipe([(2, disc)], path) if dimension == 3]

    body = occ.fuse([(3, barrel)], [(3, tag) for tag in [nose, arm, flange, *ribs, *handle(20, 34)]])[0]
    screws = [occ.addCylinder(46, 0, 290, 0, 0, 30, 2.5) for _ in range(6)]
    turned(screws, 6, 0.5)
    holes = [
        occ.addCylinder(0, 0, 118, 0, 0, 150, 30), occ.addCylinder(0, 0, 268, 0, 0, 42, 36),
        occ.addBox(-6, -6, 0, 12, 12, 130), occ.addCylinder(0, -60, 150, 0, 120, 0, 5),
        occ.addCylinder(85, -10, 60, 0, 20, 0, 4), *handle(16, 30), *screws,
    ]
    body = bored(body, holes)
    occ.synchronize()
    # The upper rim of the flange and the edges of the arm are rounded.
    edges = [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(100, -9, 40, 110, 9, 125, dim=1)]
    edges += [tag for _, tag in gmsh.model.getEntitiesInBoundingBox(-53, -53, 309, 53, 53, 311, dim=1)
              if gmsh.model.getBoundingBox(1, tag)[3] > 45]
    assert len(edges) >= 5, edges
    occ.fillet([tag for _, tag in body], edges, [2.5])


def thin():
    """Walls of 2 mm with bosses, a sleeve pressed into them and a magazine that touches them."""
    occ = gmsh.model.occ
    shell = occ.addCylinder(0, 0, 60, 0, 0, 160, 34)
    grip, inside = rounded(20, -14, 170, 150, 28, 40, 8), rounded(10, -12, 172, 158, 24, 36, 6)
    # Two rings of six bosses.
    bosses = [occ.addCylinder(30, 0, height, 12, 0, 0, 6) for height in 6 * [75] + 6 * [120]]
    turned(bosses, 6, 0.5)
    body = occ.fuse([(3, shell)], [(3, tag) for tag in [grip, *bosses]])[0]
    hollow = occ.addCylinder(0, 0, 60, 0, 0, 158, 32)
    screws = [occ.addCylinder(34, 0, height, 9, 0, 0, 2) for height in 6 * [75] + 6 * [120]]
    turned(screws, 6, 0.5)
    bored(body, [hollow, inside, *screws])
    bored([(3, occ.addCylinder(0, 0, 60, 0, 0, 100, 32))], [occ.addCylinder(0, 0, 60, 0, 0, 100, 29)])
    bored([(3, occ.addBox(-20, -20, 0, 140, 40, 60))], [occ.addBox(-17, -17, 3, 134, 34, 54)])


def tube(direction):
    """A tube with a bore through its wall, along x or y."""
    occ = gmsh.model.occ
    bore = occ.addCylinder(0, 0, 200, *(60 * part for part in direction), 5)
    bored([(3, occ.addCylinder(0, 0, 0, 0, 0, 400, 40))], [occ.addCylinder(0, 0, 0, 0, 0, 400, 30), bore])


SHAPES = {
    "page": lambda: gmsh.open(str(ROOT / "examples/housing/housing.geo")),
    "casting": casting,
    "thin": thin,
    "bore-x": lambda: tube((1, 0, 0)),
    "bore-y": lambda: tube((0, 1, 0)),
}


def drawn(name: str, folder: pathlib.Path):
    """Writes the STEP file; its solids, exact volume [m3] and outer area [m2]."""
    gmsh.clear()
    SHAPES[name]()
    gmsh.model.occ.synchronize()
    path = folder / f"{name}.step"
    gmsh.write(str(path))
    gmsh.clear()
    gmsh.model.occ.importShapes(str(path))
    gmsh.model.occ.fragment(gmsh.model.occ.getEntities(3), [])
    gmsh.model.occ.synchronize()
    solids = gmsh.model.getEntities(3)
    outer = gmsh.model.getBoundary(solids, combined=True, oriented=False)
    mass = gmsh.model.occ.getMass
    total = lambda entities: sum(mass(*entity) for entity in entities)
    return path, len(solids), 1e-9 * total(solids), 1e-6 * total(outer)


def measured(*command, limited=False):
    """The error of a command if it failed, its processor time [s] and the peak memory [MB] of its largest process."""
    limits = ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_CPU, SECONDS))
    limit = lambda: [resource.setrlimit(kind, (most, most)) for kind, most in limits]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    child = subprocess.Popen([*map(str, command)], preexec_fn=limit if limited else None, **quiet)
    said = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    failed = child.returncode and (said or f"status {child.returncode}")
    return failed, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def answer(*command):
    done = subprocess.run([*map(str, command), "--json"], capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode in (0, 1) and done.stdout else done.stderr


def frequencies(program, msh, unit):
    """First six elastic modes of the mesh, free; a message if they are refused."""
    design = msh.with_suffix(".toml")
    design.write_text(DESIGN.replace("NAME", msh.name))
    found = answer(program, "modes", design, "--body", "tool", "--unit", unit, "--out", msh.with_suffix(""))
    if isinstance(found, str):
        return found
    return [mode["hz"] for mode in found["modes"] if not mode["rigid"]][:6]


def deviation(found, expected):
    if not (isinstance(found, list) and isinstance(expected, list) and found and expected):
        return "     -"
    return f"{100 * max((f / e - 1 for f, e in zip(found, expected)), key=abs):+6.2f}"


def row(program, way, size, msh, unit, made, exact, same, fine):
    """Prints what a mesh is like; its modes, or a message."""
    failed, seconds, memory = made
    begin = f"  {way:17}{size:3} mm"
    if failed:
        print(f"{begin} fails after {seconds:.1f} s, {memory:.0f} MB: {' '.join(failed.split())[:200]}", flush=True)
        return "no mesh"
    checked = answer(program, "check", msh, "--unit", unit)
    if isinstance(checked, str):
        print(f"{begin} refused by check: {' '.join(checked.split())[:300]}", flush=True)
        return "refused"
    modes = frequencies(program, msh, unit)
    quality = checked["quality"]
    errors = [100 * (quality[key] / value - 1) for key, value in zip(("volume", "skin_area"), exact, strict=True)]
    print(
        f"{begin} {checked['elements']:8} {1e3 * quality['longest_edge']:6.1f} {seconds:6.1f} {memory:6.0f}",
        f"{errors[0]:+8.3f} {errors[1]:+8.3f} {quality['inverted']:5} {quality['poor']:5} {quality['pieces']:7}",
        f" {deviation(modes, same)}  {deviation(modes, fine)}", flush=True,
    )
    if isinstance(modes, str):
        print(f"    no modes: {' '.join(modes.split())[:300]}", flush=True)
    return modes


def main() -> int:
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    carried = True
    for name in sys.argv[3:] or SHAPES:
        step, solids, *exact = drawn(name, folder)
        file = lambda way, size: folder / f"{name}-{way.replace(', ', '-')}-{size}.msh"
        by_gmsh = lambda size: measured(
            program, "mesh", step, "--size", f"{size} mm", "--write", file("gmsh", size), "--quiet"
        )
        by_rapidmesh = lambda way, size: measured(
            sys.executable, __file__, "--rapidmesh", step, json.dumps(WAYS[way](size)), file(way, size), limited=True
        )
        print(f"\n{name}: {solids} solids, {1e6 * exact[0]:.2f} cm3, {1e4 * exact[1]:.1f} cm2")
        print(HEAD)
        made = {(way, size): by_rapidmesh(way, size) for size in SIZES for way in WAYS}
        fine = None
        if name == "page":
            fine = row(program, "gmsh", FINE, file("gmsh", FINE), "1 m", by_gmsh(FINE), exact, None, None)
        for size in SIZES:
            same = row(program, "gmsh", size, file("gmsh", size), "1 m", by_gmsh(size), exact, None, fine)
            carried &= size > min(SIZES) or isinstance(same, list)
            for way in WAYS:
                row(program, way, size, file(way, size), "1 mm", made[way, size], exact, same, fine)
    return 0 if carried else 1


if __name__ == "__main__":
    if sys.argv[1] == "--rapidmesh":
        rapidmesh(*sys.argv[2:])
    else:
        sys.exit(main())
