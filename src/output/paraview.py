"""Opens the fields in this folder in ParaView: paraview --script=paraview.py

One view shows the velocity level of the bodies in one octave, the loudest of the workpiece. Another shows the film of the
shot. After `run --fields`, further views show the sound exposure level on the surface and in the planes, and the
directivity, in one-third octaves.
"""

import glob
import json
import os

from paraview.simple import (
    ColorBy,
    CreateLayout,
    CreateRenderView,
    GetAnimationScene,
    GetColorTransferFunction,
    GetScalarBar,
    LoadPalette,
    OpenDataFile,
    Render,
    ResetCamera,
    SetActiveView,
    Show,
)

here = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
fields = os.path.join(here, "fields")
with open(os.path.join(here, "result.json")) as file:
    result = json.load(file)
value = {entry["key"]: entry["value"] for entry in result["inputs"]}

# The tool's axes begin at the tip of its nose, which stands on the workpiece.
NOSE = [value["nail.offset_along"], value["nail.offset_across"], value["workpiece.thickness"]]

# Levels shown below the highest [dB], and the share of the highest velocity at which colours end.
SHOWN, SHARE = 40.0, 0.2


def arrays(source):
    """Names and ranges of the fields on the points."""
    data = source.PointData
    found = [data.GetArray(i) for i in range(data.GetNumberOfArrays())]
    return {array.Name: array.GetRange(-1 if array.GetNumberOfComponents() > 1 else 0) for array in found}


def view_of(files, choose, limits, title, time=0.0):
    """A view of some files at a time by the field that `choose` finds, on one scale for all of them."""
    view = CreateRenderView()
    SetActiveView(view)
    LoadPalette("WhiteBackground")
    view.OrientationAxesVisibility = 1
    view.ViewTime = time
    sources = [(file, OpenDataFile(file)) for file in files]
    for _, source in sources:
        source.UpdatePipeline(time)
    name = choose(sources)
    for file, source in sources:
        shown = Show(source, view)
        if os.path.basename(file).startswith("tool"):
            shown.Position = NOSE
        if name in arrays(source):
            ColorBy(shown, ("POINTS", name))
            shown.RescaleTransferFunctionToDataRangeOverTime()
    if name:
        table = GetColorTransferFunction(name)
        table.ApplyPreset("Viridis (matplotlib)", True)
        table.RescaleTransferFunction(*limits(sources, name, table))
        bar = GetScalarBar(table, view)
        bar.Title, bar.ComponentTitle, bar.Visibility = title(name), "", 1
        bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, "%.3g", "%.3g"
        bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
    # From the front, the right and above.
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [1.3, -1.7, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    ResetCamera(view)
    Render(view)
    return view


def loudest(sources):
    """The octave with the highest level of the workpiece."""
    own = next(arrays(source) for file, source in sources if os.path.basename(file) == "workpiece.vtu")
    return max(own, key=lambda name: own[name][1], default=None)


def levels(sources, name, _):
    """The highest level of all bodies, and what is shown below it."""
    high = max(arrays(source)[name][1] for _, source in sources if name in arrays(source))
    return high - SHOWN, high


def speeds(_, __, table):
    """From rest to a share of the highest velocity of the film."""
    return 0.0, SHARE * table.RGBPoints[-4]


CreateLayout("levels")
view_of(sorted(glob.glob(os.path.join(fields, "*.vtu"))), loudest, levels, lambda name: name.replace("[", "(").replace("]", ")"))
films = sorted(glob.glob(os.path.join(fields, "*-shot.pvd")))
if films:
    CreateLayout("the shot")
    film = view_of(films, lambda sources: "velocity [m/s]", speeds, lambda name: "velocity (m/s)")
    scene = GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    # Where the rod meets the nail there is something to see.
    steps, strike = list(scene.TimeKeeper.TimestepValues), result["events"].get("t8")
    if steps and strike is not None:
        scene.AnimationTime = min(steps, key=lambda time: abs(time - strike - 3e-4))
    Render(film)

# The workpiece's sound, if `run --fields` left it: time is the frequency of the band in Hz.
sounds = [file for name in ("surface", "plane-xz", "plane-yz", "plane-xy") for file in glob.glob(os.path.join(fields, f"sound-{name}.pvd"))]
spheres = glob.glob(os.path.join(fields, "sound-sphere.pvd"))
for title, files, wanted, below in [
    ("the sound", sounds, "sound exposure level [dB re (20 uPa)2 s]", SHOWN),
    ("its directions", spheres, "directivity index [dB]", 0.5 * SHOWN),
]:
    if files:
        CreateLayout(title)
        own = next(source for source in result["ranking"] if source["source"] == "workpiece")
        bands = sorted(OpenDataFile(files[0]).TimestepValues)
        level = {band["hz"]: band["lwa_db"] or 0.0 for band in own["bands"]}
        view_of(
            files,
            lambda sources: wanted,
            lambda sources, name, _: (levels(sources, name, _)[1] - below, levels(sources, name, _)[1]),
            lambda name: name.replace("[", "(").replace("]", ")"),
            max(bands, key=lambda hz: level.get(hz, 0.0)),
        )
