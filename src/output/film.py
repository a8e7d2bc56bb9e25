"""Plays the film of the shot in this folder in ParaView: paraview --script=film.py

Every body is warped by its displacement, each enlarged so that its largest is 3 % of the body's diagonal, and coloured by its
velocity. The film plays in real time, slower than the shot by the factor of `nailnoise run --fields --slow-motion`.
"""

import glob
import json
import os

from paraview.simple import (
    ColorBy,
    CreateLayout,
    CreateRenderView,
    GetAnimationScene,
    LoadPalette,
    OpenDataFile,
    Render,
    ResetCamera,
    SetActiveView,
    Show,
    WarpByVector,
)

here = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
with open(os.path.join(here, "result.json")) as file:
    value = {entry["key"]: entry["value"] for entry in json.load(file)["inputs"]}

# The tool's axes begin at the tip of its nose, which stands on the workpiece.
NOSE = [value["nail.offset_along"], value["nail.offset_across"], value["workpiece.thickness"]]
SHARE = 0.03
DISPLACEMENT, VELOCITY = "displacement [m]", "velocity [m/s]"

CreateLayout("the shot in slow motion")
view = CreateRenderView()
SetActiveView(view)
LoadPalette("WhiteBackground")
last = 1.0
for path in sorted(glob.glob(os.path.join(here, "fields", "*-film.pvd"))):
    source = OpenDataFile(path)
    largest = 0.0
    for time in source.TimestepValues:
        source.UpdatePipeline(time)
        largest = max(largest, source.PointData[DISPLACEMENT].GetRange(-1)[1])
        last = max(last, time)
    low, high = source.GetDataInformation().GetBounds()[0::2], source.GetDataInformation().GetBounds()[1::2]
    diagonal = sum((b - a) ** 2 for a, b in zip(low, high)) ** 0.5
    warped = WarpByVector(Input=source)
    warped.Vectors = ["POINTS", DISPLACEMENT]
    warped.ScaleFactor = SHARE * diagonal / largest if largest > 0.0 else 0.0
    shown = Show(warped, view)
    if os.path.basename(path).startswith("tool"):
        shown.Position = NOSE
    ColorBy(shown, ("POINTS", VELOCITY, "Magnitude"))
    shown.RescaleTransferFunctionToDataRangeOverTime()
view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [1.3, -1.7, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]
ResetCamera(view)
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.PlayMode = "Real Time"
scene.Duration = max(1, round(last))
Render(view)
