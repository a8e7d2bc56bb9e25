"""Opens the pictures of this folder in ParaView: paraview --script=paraview.py

Every body of the shot by the velocity level of its loudest octave, the film of the shot beside it.
"""

import glob
import os

from paraview.simple import (
    ColorBy,
    CreateLayout,
    GetColorTransferFunction,
    CreateRenderView,
    OpenDataFile,
    Render,
    ResetCamera,
    Show,
)

here = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
fields = os.path.join(here, "fields")


def view_of(files, choose):
    """A view of some files, each coloured by the array that `choose` picks from its names."""
    view = CreateRenderView()
    view.OrientationAxesVisibility = 1
    for file in files:
        source = OpenDataFile(file)
        source.UpdatePipeline()
        shown = Show(source, view)
        arrays = source.PointData
        names = [arrays.GetArray(i).Name for i in range(arrays.GetNumberOfArrays())]
        name = choose(arrays, names)
        if name:
            ColorBy(shown, ("POINTS", name))
            shown.RescaleTransferFunctionToDataRange(True)
            shown.SetScalarBarVisibility(view, True)
            GetColorTransferFunction(name).ApplyPreset("Viridis (matplotlib)", True)
    ResetCamera(view)
    Render(view)
    return view


def loudest(arrays, names):
    """The octave with the highest level."""
    return max(names, key=lambda name: arrays.GetArray(name).GetRange()[1], default=None)


bodies = [file for file in sorted(glob.glob(os.path.join(fields, "*.vtu")))]
films = sorted(glob.glob(os.path.join(fields, "*-shot.pvd")))
CreateLayout("levels")
view_of(bodies, loudest)
if films:
    CreateLayout("the shot")
    view_of(films, lambda arrays, names: names[0] if names else None)
