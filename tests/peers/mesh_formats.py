"""Meshes and universal files of all versions, made by gmsh and pyuff, read by the command as gmsh, meshio and pyuff read them.

python mesh_formats.py NAILNOISE FOLDER: volume, nodes and areas of `nailnoise check` against gmsh's, written VTU files against
meshio, and modes in local axes against themselves. Needs the modules gmsh, meshio, pyuff and numpy.
"""

import json
import math
import pathlib
import subprocess
import sys

import gmsh
import meshio
import numpy
import pyuff

PROGRAM = str(pathlib.Path(sys.argv[1]).resolve())
WORK = pathlib.Path(sys.argv[2])
WORK.mkdir(parents=True, exist_ok=True)
ROOT = pathlib.Path(__file__).resolve().parents[2]


def command(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, cwd=ROOT)


def answer(*arguments):
    done = command(*arguments, "--json")
    assert done.returncode == 0, (arguments, done.returncode, done.stdout, done.stderr)
    return json.loads(done.stdout)


def option(name, value):
    gmsh.option.setNumber(name, value)


def body(kind, order, incomplete):
    """Makes a mesh of a kind of elements; lengths in m."""
    gmsh.clear()
    occ = gmsh.model.occ
    size = 0.1
    if kind == "curved":
        box, bore = occ.addBox(0, 0, 0, 0.3, 0.2, 0.1), occ.addCylinder(0.15, 0.1, 0, 0, 0, 0.1, 0.05)
        occ.cut([(3, box)], [(3, bore)])
        size = 0.025
    elif kind == "tetrahedra":
        # Two bodies with a face in common.
        boxes = occ.addBox(0, 0, 0, 0.4, 0.3, 0.2), occ.addBox(0, 0, 0.2, 0.4, 0.3, 0.1)
        occ.fragment([(3, boxes[0])], [(3, boxes[1])])
    else:
        base = occ.addRectangle(0, 0, 0, 0.3, 0.2)
        occ.extrude([(2, base)], 0, 0, 0.1, numElements=[2], recombine=True)
    occ.synchronize()
    if kind == "hexahedra":
        for dimension, tag in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(tag)
            gmsh.model.mesh.setRecombine(dimension, tag)
        for _, tag in gmsh.model.getEntities(3):
            gmsh.model.mesh.setTransfiniteVolume(tag)
    option("Mesh.MeshSizeMax", size)
    option("Mesh.MeshSizeMin", size)
    option("Mesh.SecondOrderIncomplete", incomplete)
    volumes = [tag for _, tag in gmsh.model.getEntities(3)]
    for number, tag in enumerate(volumes):
        gmsh.model.addPhysicalGroup(3, [tag], 11 + number, name="block" if number == 0 else "lid")
    heights = [gmsh.model.getBoundingBox(2, tag)[2::3] for _, tag in gmsh.model.getEntities(2)]
    for number, (name, pick) in enumerate((("bottom", min), ("top", max))):
        level = pick(height for pair in heights for height in pair)
        of_level = lambda tag: all(abs(z - level) < 1e-6 for z in gmsh.model.getBoundingBox(2, tag)[2::3])
        tags = [tag for _, tag in gmsh.model.getEntities(2) if of_level(tag)]
        gmsh.model.addPhysicalGroup(2, tags, 1 + number, name=name)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)


def sizes(dimension, tag):
    """Volume or area of an entity's elements by gmsh's own quadrature, and the nodes of its elements."""
    total, nodes = 0.0, set()
    types, _, of_types = gmsh.model.mesh.getElements(dimension, tag)
    for kind, tags in zip(types, of_types):
        points, weights = gmsh.model.mesh.getIntegrationPoints(kind, "Gauss6")
        _, determinants, _ = gmsh.model.mesh.getJacobians(kind, points, tag)
        total += (determinants.reshape(-1, len(weights)) @ weights).sum()
        nodes |= set(tags.tolist())
    return total, nodes


def expected_of(path):
    """What gmsh reads in a file: volumes of the volume groups, areas of the surface groups, nodes of the volume elements."""
    gmsh.clear()
    gmsh.open(str(path))
    whole, nodes = 0.0, set()
    for _, tag in gmsh.model.getEntities(3):
        volume, own = sizes(3, tag)
        whole += volume
        nodes |= own
    areas = {}
    for dimension, group in gmsh.model.getPhysicalGroups(2):
        name = gmsh.model.getPhysicalName(dimension, group)
        if name:
            tags = gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
            areas[name] = areas.get(name, 0.0) + sum(sizes(2, tag)[0] for tag in tags)
    return whole, len(nodes), areas


def close(a, b, tolerance=1e-9):
    return math.isclose(a, b, rel_tol=tolerance)


tried = 0


def is_read_alike(path, volume=None, areas=None, count=None, named=True):
    """Compares `check` with gmsh and with the known data of the model."""
    global tried
    found = answer("check", path, "--unit", "1 m")
    by_gmsh, nodes, groups = expected_of(path)
    assert close(found["quality"]["volume"], by_gmsh), (path, found["quality"]["volume"], by_gmsh)
    assert volume is None or close(by_gmsh, volume, 1e-7), (path, by_gmsh, volume)
    assert found["nodes"] == nodes and (count is None or count == nodes), (path, found["nodes"], nodes, count)
    if named:
        own = {group["name"]: group["area"] for group in found["groups"]}
        for name, area in (areas or groups).items():
            assert close(own[name], area, 1e-7), (path, name, own, area)
    tried += 1
    return found


def whole_of_model():
    volume = sum(sizes(3, tag)[0] for _, tag in gmsh.model.getEntities(3))
    nodes = set().union(*(sizes(3, tag)[1] for _, tag in gmsh.model.getEntities(3)))
    areas = {}
    for dimension, group in gmsh.model.getPhysicalGroups(2):
        tags = gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
        areas[gmsh.model.getPhysicalName(dimension, group)] = sum(sizes(2, tag)[0] for tag in tags)
    return volume, areas, len(nodes)


def versions(name):
    """Writes the present mesh in every version and encoding that gmsh writes."""
    for version, binary in ((1, 0), (2.2, 0), (2.2, 1), (4.0, 0), (4.1, 0), (4.1, 1)):
        option("Mesh.MshFileVersion", version)
        option("Mesh.Binary", binary)
        path = WORK / f"{name}-{version:g}{'b' if binary else ''}.msh"
        gmsh.write(str(path))
        yield path, version, binary


def meshes():
    kinds = (
        ("tetrahedra", 1, 0), ("tetrahedra", 2, 0), ("curved", 2, 0),
        ("hexahedra", 1, 0), ("hexahedra", 2, 0), ("hexahedra", 2, 1), ("prisms", 2, 1),
    )
    for kind, order, incomplete in kinds:
        name = f"{kind}-{order}{'s' if incomplete else ''}"
        body(kind, order, incomplete)
        model = whole_of_model()
        written = list(versions(name))
        for path, version, binary in written:
            found = is_read_alike(path, *model, named=version != 1)
            parts = [part["name"] for part in found["parts"]]
            if version == 1:
                assert all(part.startswith("volume group 1") for part in parts), parts
            else:
                assert set(parts) <= {"block", "lid"}, parts
            if (version, binary) == (4.1, 1):
                grids(path, found)
        # Remove the names and, in version 4.1, also the entities that carry the groups.
        text = (WORK / f"{name}-4.1.msh").read_text()
        for section in ("PhysicalNames", "Entities"):
            begin, end = text.index(f"${section}\n"), text.index(f"$End{section}\n") + len(f"$End{section}\n")
            text = text[:begin] + text[end:]
            path = WORK / f"{name}-without-{section}.msh"
            path.write_text(text)
            found = answer("check", path, "--unit", "1 m")
            assert close(found["quality"]["volume"], model[0], 1e-7) and found["nodes"] == model[2], path
            globals()["tried"] += 1


def partitions():
    for ghosts in (0, 1):
        for topology in (0, 1):
            body("tetrahedra", 2, 0)
            model = whole_of_model()
            option("Mesh.PartitionCreateTopology", topology)
            option("Mesh.PartitionCreateGhostCells", ghosts)
            gmsh.model.mesh.partition(3)
            for path, version, _ in list(versions(f"partitions-{topology}{ghosts}")):
                if version > 1:
                    found = answer("check", path, "--unit", "1 m")
                    assert close(found["quality"]["volume"], model[0], 1e-7), (path, found["quality"], model)
                    assert found["nodes"] == model[2], (path, found["nodes"], model[2])
                    own = {group["name"]: group["area"] for group in found["groups"]}
                    assert all(close(own[name], area, 1e-7) for name, area in model[1].items()), (path, own, model[1])
                    assert sorted(part["name"] for part in found["parts"]) == ["block", "lid"], found["parts"]
                    globals()["tried"] += 1
    body("curved", 1, 0)
    model = whole_of_model()
    option("Mesh.SaveParametric", 1)
    written = [path for path, version, _ in versions("parametric") if version > 1]
    option("Mesh.SaveParametric", 0)
    for path in written:
        found = answer("check", path, "--unit", "1 m")
        assert close(found["quality"]["volume"], model[0], 1e-7) and found["nodes"] == model[2], (path, found["nodes"], model)
        globals()["tried"] += 1


def grids(path, found):
    """meshio reads the same mesh from the written VTU and MSH files."""
    # meshio does not support prisms of 15 nodes.
    if path.name.startswith("prisms"):
        return
    vtu, msh = path.with_suffix(".vtu"), path.with_name(path.stem + "-own.msh")
    answer("mesh", path, "--unit", "1 m", "--write", vtu, "--write", msh, "--format", "text22")
    for file in (vtu, msh):
        read = meshio.read(file)
        solid = [block for block in read.cells if block.dim == 3]
        assert len(read.points) == found["nodes"], (file, len(read.points))
        assert sum(len(block.data) for block in solid) == found["elements"], file
        corners = {"tetra": 4, "tetra10": 4}
        if all(block.type in corners for block in solid) and "curved" not in path.name:
            of = lambda block: read.points[block.data[:, :4].astype(int)]
            volume = sum(abs(numpy.linalg.det(p[:, 1:] - p[:, :1])).sum() / 6 for p in map(of, solid))
            assert close(volume, found["quality"]["volume"], 1e-6), (file, volume)
        globals()["tried"] += 1


def rotations(count):
    """Rotation matrices whose rows are axes, not two alike."""
    random = numpy.random.default_rng(48)
    made = []
    for _ in range(count):
        q, r = numpy.linalg.qr(random.normal(size=(3, 3)))
        q *= numpy.sign(numpy.diag(r))
        made.append(q if numpy.linalg.det(q) > 0 else -q)
    return made


def modes():
    design = "tests/data/small.toml"
    out = WORK / "modes"
    answer("modes", design, "--body", "workpiece", "--uff", "--out", out)
    sets = pyuff.UFF(str(out / "modes/workpiece/modes.uff")).read_sets()
    nodes = next(one for one in sets if one["type"] == 2411)
    shapes = [one for one in sets if one["type"] == 55]
    labels = numpy.array(nodes["node_nums"], dtype=int)
    place = numpy.array([nodes["x"], nodes["y"], nodes["z"]]).T
    turn = rotations(5)
    of_node = labels % len(turn)
    origin = numpy.array([0.1, -0.2, 0.3])
    local = numpy.array([turn[k] @ (p - origin) for k, p in zip(of_node, place)])

    def lines(path, blocks):
        text = "".join(f"    -1\n{number:6d}\n{block}    -1\n" for number, block in blocks)
        path.write_text(text)

    e13 = lambda values: "".join(f"{value:13.5E}" for value in values)
    d25 = lambda values: "".join(f"{value:25.16E}".replace("E", "D") for value in values)

    def systems(number):
        if number == 18:
            # Origin, a point on +x and a point in the +x +z half plane.
            points = [(origin, origin + q[0], origin + q[0] + q[2]) for q in turn]
            return "".join(
                f"{k + 2:10d}{0:10d}{0:10d}{8:10d}{1:10d}\nS{k}\n{e13([*a, *b])}\n{e13(c)}\n" for k, (a, b, c) in enumerate(points)
            )
        rows = lambda q: "".join(d25(row) + "\n" for row in [*q, origin])
        return f"{1:10d}\npart\n" + "".join(f"{k + 2:10d}{0:10d}{8:10d}\nS{k}\n{rows(q)}" for k, q in enumerate(turn))

    def points(number, definition, displacement, coordinates):
        made = []
        for label, k, p in zip(labels, of_node, coordinates):
            ids = f"{label:10d}{k + 2 if definition else 0:10d}{k + 2 if displacement else 0:10d}{11:10d}"
            made.append(f"{ids}{e13(p)}\n" if number == 15 else f"{ids}\n{d25(p)}\n")
        return "".join(made)

    def shape(one, turned, seen):
        u = numpy.array([one["r1"], one["r2"], one["r3"]]).real.T
        if turned:
            u = numpy.array([turn[k] @ v for k, v in zip(numpy.array(one["node_nums"], dtype=int) % len(turn), u)])
        u = u * numpy.array(seen)
        head = ["NONE"] * 5 + ["".join(f"{k:10d}" for k in (1, 2, 2, 8, 2, 3)), "".join(f"{k:10d}" for k in (2, 4, 1, 1))]
        head.append(e13([one["freq"], 1, 0, 0.02]))
        rows = "".join(f"{int(label):10d}\n{e13(v)}\n" for label, v in zip(one["node_nums"], u))
        return "\n".join(head) + "\n" + rows

    def is_matched(name, blocks, seen=(1, 1, 1), turned=True):
        path = WORK / f"{name}.uff"
        lines(path, blocks + [(55, shape(one, turned, seen)) for one in shapes[6:]])
        read = pyuff.UFF(str(path)).read_sets()
        assert sum(one["type"] == 55 for one in (read if isinstance(read, list) else [read])) == len(shapes) - 6
        found = answer("modes", design, "--body", "workpiece", "--mac", path, "--out", out)["correlation"]
        assert found["unmatched"] == 0 and found["farthest"] < 1e-5, (name, found["unmatched"], found["farthest"])
        for row, values in enumerate(found["mac"]):
            assert values[row + 6] > 0.999, (name, row, values[row + 6])
        globals()["tried"] += 1

    for systems_of in (18, 2420):
        for nodes_of in (15, 2411):
            is_matched(f"local-{systems_of}-{nodes_of}", [(systems_of, systems(systems_of)), (nodes_of, points(nodes_of, 1, 1, local))])
        is_matched(f"one-axis-{systems_of}", [(15, points(15, 0, 1, place)), (systems_of, systems(systems_of))], (1, 0, 0))
    is_matched("definition", [(18, systems(18)), (15, points(15, 1, 0, local))], turned=False)
    units = f"{5:10d}{'mm (newton)':20}{2:10d}\n{d25([1000, 1, 1])}\n{d25([273.15])}\n"
    is_matched("millimetres", [(164, units), (2411, points(2411, 0, 0, 1e3 * place))], turned=False)
    for name, blocks in (("unknown", [(15, points(15, 0, 1, place))]), ("modes-only", [])):
        path = WORK / f"{name}.uff"
        lines(path, blocks + [(55, shape(shapes[6], False, (1, 1, 1)))])
        done = command("modes", design, "--body", "workpiece", "--mac", path, "--out", out)
        assert done.returncode == 2, (name, done.returncode, done.stdout)
        globals()["tried"] += 1


def solids():
    """Geometries: units, several solids, sewn faces and sheets, a mesh that memory does not suffice for."""
    occ = gmsh.model.occ
    gmsh.clear()
    occ.addBox(0, 0, 0, 50, 50, 50)
    occ.addBox(200, 0, 0, 20, 20, 20)
    occ.synchronize()
    two = WORK / "two.step"
    gmsh.write(str(two))
    volume = lambda found: sum(part[1] for part in found["parts"])
    found = answer("mesh", two, "--size", "20 mm")
    assert close(volume(found), 133e-6, 1e-6), found
    assert any("2 solids" in note and "8.0 cm3" in note for note in found["notes"]), found["notes"]
    assert close(volume(answer("mesh", two, "--size", "20 mm", "--solid", "2")), 8e-6, 1e-6)
    third = command("mesh", two, "--size", "20 mm", "--solid", "3")
    assert third.returncode == 2 and "no solid 3" in " ".join(third.stderr.split()), third
    fine = command("mesh", two, "--size", "0.02 mm", "--memory", "4GB")
    assert fine.returncode == 2 and "elements" in fine.stderr, fine
    gmsh.clear()
    cube = occ.addBox(0, 0, 0, 50, 50, 50)
    occ.synchronize()
    gmsh.write(str(WORK / "cube.igs"))
    gmsh.write(str(WORK / "cube.brep"))
    for name, unit, expected in (("cube.igs", (), 125e-6), ("cube.brep", (), 125e-6), ("cube.brep", ("--unit", "1 in"), 125e3 * 0.0254**3)):
        size = "0.6 m" if unit else "25 mm"
        assert close(volume(answer("mesh", WORK / name, "--size", size, *unit)), expected, 1e-6), name
    occ.remove([(3, cube)])
    occ.remove([(2, 1)], True)
    occ.synchronize()
    gmsh.write(str(WORK / "sheets.step"))
    sheets = command("mesh", WORK / "sheets.step", "--size", "25 mm")
    assert sheets.returncode == 2 and "5 faces and no solid" in " ".join(sheets.stderr.split()), sheets
    globals()["tried"] += 6


gmsh.initialize(["mesh_formats", "-v", "0"])
meshes()
partitions()
solids()
gmsh.finalize()
modes()
assert tried >= 25, tried
print(f"{tried} files are read as gmsh, meshio and pyuff read them")
