"""Reads back what tests/peers/meshes.sh has the command write."""

import csv
import json
import pathlib
import sys
import wave
import xml.etree.ElementTree

import numpy
import pyuff

# Modules that need no display.
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersGeneral import vtkDataSetTriangleFilter
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

work = pathlib.Path(sys.argv[1])


def load(name):
    return json.loads((work / name).read_text())


def grid(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert reader.GetErrorCode() == 0, path
    found = reader.GetOutput()
    assert found.GetNumberOfCells() > 0, path
    return found


def volume(found):
    """Volume by VTK's own split of each cell into tetrahedra, which makes curved sides straight."""
    cells = vtkDataSetTriangleFilter()
    cells.SetInputData(found)
    size = vtkCellSizeFilter()
    size.SetInputConnection(cells.GetOutputPort())
    size.Update()
    return vtk_to_numpy(size.GetOutput().GetCellData().GetArray("Volume")).sum()


files = 0
for path in sorted(work.rglob("*.vtu")):
    found = grid(path)
    data = found.GetPointData()
    for index in range(data.GetNumberOfArrays()):
        values = vtk_to_numpy(data.GetArray(index))
        assert numpy.isfinite(values).all(), path
        # The first frames of a film are at rest; a mode is not.
        assert "modes" not in path.parts or numpy.abs(values).max() > 0, path
    files += 1
tool = grid(work / "tool.vtu")
checked = load("gmsh-41.json")
assert tool.GetNumberOfCells() == checked["elements"] and tool.GetNumberOfPoints() == checked["nodes"]
assert abs(volume(tool) / checked["quality"]["volume"] - 1) < 0.02, (volume(tool), checked["quality"]["volume"])
plate = grid(next((work / "plate/modes/tool").glob("mode-*.vtu")))
assert abs(volume(plate) / (0.3 * 0.2 * 0.02) - 1) < 1e-6
print(f"VTK read {files} .vtu files")

# The film in one file has the times, faces and values of its frames.
films = 0
for path in sorted(work.rglob("*.vtkhdf")):
    series = xml.etree.ElementTree.parse(path.with_suffix(".pvd")).iter("DataSet")
    listed = [(float(frame.get("timestep")), path.parent / frame.get("file")) for frame in series]
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert numpy.allclose(times, [time for time, _ in listed], rtol=1e-12), path
    for time, frame in (listed[0], listed[len(listed) // 2], listed[-1]):
        reader.UpdateTimeStep(time)
        found, expected = reader.GetOutput(), grid(frame)
        assert found.GetNumberOfCells() == expected.GetNumberOfCells()
        assert (vtk_to_numpy(found.GetPoints().GetData()) == vtk_to_numpy(expected.GetPoints().GetData())).all()
        for name in ("displacement [m]", "velocity [m/s]"):
            one = found.GetPointData().GetArray(name.replace("/", " per "))
            other = expected.GetPointData().GetArray(name)
            assert (vtk_to_numpy(one) == vtk_to_numpy(other)).all(), (path, name)
    films += 1
assert films == 2, films
print(f"VTK read {films} .vtkhdf films")

for name in ("22", "41"):
    own = load(f"gmsh-{name}.json")
    assert [part["name"] for part in own["parts"]] == ["cap", "housing", "nose", "sleeve"], own["parts"]
    assert {group["name"] for group in own["groups"]} == {
        "nose_tip", "gas_bore", "bumper_seat", "seat", "cap", "handle", "magazine", "fit_slave", "fit_master",
        "sleeve_outside", "supply", "plenum"
    }, own["groups"]
print("gmsh read .msh 2.2 and 4.1 and wrote them again")

sets = 0
for folder, result in (("plate/modes/tool", "plate.json"), ("small/modes/worktable", "small.json")):
    universal = pyuff.UFF(str(work / folder / "modes.uff"))
    read = universal.read_sets()
    modes = [one for one in read if one["type"] == 55]
    expected = load(result)["modes"]
    assert len(modes) == len(expected), (len(modes), len(expected))
    assert sorted({one["type"] for one in read}) == [15, 55, 2411, 2412]
    nodes = next(one for one in read if one["type"] == 2411)
    coarse = next(one for one in read if one["type"] == 15)
    assert numpy.allclose(nodes["x"], coarse["x"], rtol=1e-5, atol=1e-9)
    shells = next(one for one in read if one["type"] == 2412)
    labels = set(nodes["node_nums"].astype(int))
    for key, elements in shells.items():
        if isinstance(key, int):
            assert all(set(element["nodes_nums"]) <= labels for element in elements)
    for one, mode in zip(modes, expected):
        assert abs(one["freq"] - mode["hz"]) <= 1e-5 * max(1.0, mode["hz"]), (one["freq"], mode["hz"])
        shape = numpy.stack([one["r1"], one["r2"], one["r3"]])
        assert set(one["node_nums"]) == labels and numpy.abs(shape).max() > 0
    sets += len(read)
sensors = pyuff.UFF(str(work / "run/sensors.uff")).read_sets()
recorded = load("run.json")["sensors"]
assert len(sensors) == len(recorded) and all(one["type"] == 58 for one in sensors)
for one, sensor in zip(sensors, recorded):
    assert abs(numpy.abs(one["data"]).max() / 9.80665 / sensor["peak_g"] - 1) < 1e-3, sensor
sets += len(sensors)
known = {work / "run/sensors.uff", *(work / folder / "modes.uff" for folder in ("plate/modes/tool", "small/modes/worktable"))}
assert set(work.rglob("*.uff")) == known, "a universal file that nobody read"
print(f"pyuff read {sets} datasets")

# Sound files contain the exposures and the bands of the tables.
EDGES = 1000 * 10 ** (0.1 * (numpy.arange(-13, 15) - 0.5))
REFERENCE = 4e-10
LENGTH = 1 << 19


def table(name):
    with open(work / "run" / name, newline="") as file:
        return list(csv.DictReader(file))


def pressure(path, full_scale):
    with wave.open(str(path)) as file:
        assert (file.getnchannels(), file.getsampwidth(), file.getframerate()) == (1, 3, 48000), path
        raw = numpy.frombuffer(file.readframes(file.getnframes()), dtype=numpy.uint8).reshape(-1, 3)
    wide = numpy.concatenate([numpy.zeros((len(raw), 1), numpy.uint8), raw], axis=1)
    return full_scale * wide.view("<i4")[:, 0] / 2**31


def cumulated(signal):
    """Exposure from 0 Hz on, at the lines of a padded transform."""
    density = 2 * numpy.abs(numpy.fft.rfft(signal, LENGTH) / 48000) ** 2
    step = 48000 / LENGTH
    return numpy.arange(len(density)) * step, numpy.concatenate([[0], numpy.cumsum(0.5 * (density[1:] + density[:-1]))]) * step


def decibels(ratio):
    return 10 * numpy.log10(ratio)


below, sounds = {}, 0
for row in table("microphones.csv"):
    path = work / f"run/microphones/{row['source']}-{row['microphone']}.wav"
    signal = pressure(path, float(row["full scale of the file [Pa]"]))
    apart = decibels((signal**2).sum() / 48000 / REFERENCE) - float(row["L_E [dB]"])
    assert abs(apart) < 0.05, (path, apart)
    hz, sums = cumulated(signal)
    low, high = (numpy.interp(float(row[f"range {end} [Hz]"]) * factor, hz, sums) for end, factor in (("from", 0.8), ("to", 1.1)))
    assert high - low > 0.995 * sums[-1], (path, "sound outside the range")
    below.setdefault(row["source"], []).append(numpy.interp(EDGES, hz, sums))
    sounds += 1
assert sounds == len(list(work.rglob("*.wav"))) == 36, sounds
area = load("run.json")["microphones"]["area_m2"]
for row in table("microphones-bands.csv"):
    if row["microphones L_W [dB]"]:
        band = round(10 * numpy.log10(float(row["band [Hz]"]) / 1000)) + 13
        mean = numpy.mean([sums[band + 1] - sums[band] for sums in below[row["source"]]])
        apart = decibels(mean / REFERENCE * area) - float(row["microphones L_W [dB]"])
        assert abs(apart) < 0.1, (row, apart)
print(f"Python's wave read {sounds} sound files, which hold what the tables state")

# First bending mode of the plate: f = 22.37/(2 pi L^2) sqrt(E h^2/(12 rho)) for a beam, within the effects of width,
# shear and rotary inertia. The plate is free, so it has six rigid modes.
modes = load("plate.json")["modes"]
assert [mode["rigid"] for mode in modes[:7]] == [True] * 6 + [False]
beam = 22.37 / (2 * numpy.pi * 0.3**2) * numpy.sqrt(207e9 * 0.02**2 / (12 * 7850))
elastic = [mode["hz"] for mode in modes[6:]]
assert min(abs(hz / beam - 1) for hz in elastic) < 0.05, (beam, elastic)
pairs = load("mac.json")["correlation"]["pairs"]
for index, pair in enumerate(pairs[6:]):
    assert pair["mode"] == index + 7 and pair["mac"] > 0.999, pair
assert load("check.json")["faults"] == []
for name, size in (("check", 0.020), ("fine", 0.018), ("block", 0.025)):
    longest = load(f"{name}.json")["quality"]["longest_edge"]
    assert 0.6 * size < longest <= size, (name, longest)
# The same plate, in wood and defined on the command line, also has six rigid modes.
line = load("line.json")["modes"]
assert [mode["rigid"] for mode in line[:7]] == [True] * 6 + [False]
other = load("other.json")
assert [name for name, _ in other["parts"]] == ["cap", "housing", "nose", "sleeve"]
print("STEP to modes, MAC, check and re-meshing: as expected; first bending at",
      round(min(elastic, key=lambda hz: abs(hz / beam - 1)), 1), "Hz, beam", round(beam, 1), "Hz")
