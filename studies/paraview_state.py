"""Shows snapshots of isph in ParaView 5.11: fluid as balls of the size of particles, coloured by speed, bodies in grey.

In ParaView choose File, Load State, and this file: it opens the newest .xdmf of the folder in which ParaView was started.
Without a window: pvpython paraview_state.py flow.xdmf out.png (below xvfb-run where there is no display)."""
import glob
import os
import sys

from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy


def index():
    """Returns the path of the index of snapshots."""
    named = [word for word in sys.argv[1:] if word.endswith(".xdmf")]
    found = named or sorted(glob.glob("*.xdmf"), key=os.path.getmtime)
    if not found:
        sys.exit("paraview_state.py: no .xdmf here: start ParaView in the folder of the snapshots, or name one")
    return os.path.abspath(found[-1])


def spacing(points):
    """Returns the median distance of a particle from its nearest neighbour."""
    chosen = range(0, len(points), max(1, len(points) // 200))
    nearest = sorted(sorted(((points - points[k]) ** 2).sum(axis=1))[1] ** 0.5 for k in chosen)
    return nearest[len(nearest) // 2]


def show(reader, view, name, field, low, high):
    """Shows the particles between two values of a field as balls; returns how they are shown, and their places."""
    part = simple.Threshold(Input=reader, Scalars=["POINTS", field], LowerThreshold=low, UpperThreshold=high)
    simple.RenameSource(name, part)
    shown = simple.Show(part, view)
    simple.UpdatePipeline(view.ViewTime, part)
    data = servermanager.Fetch(part)
    points = vtk_to_numpy(data.GetPoints().GetData()) if data.GetNumberOfPoints() > 1 else None
    if points is not None:
        shown.SetRepresentationType("Point Gaussian")
        shown.GaussianRadius = 0.62 * spacing(points)
        shown.ShaderPreset = "Sphere"
    return shown, points


def main():
    reader = simple.Xdmf3ReaderS(FileName=[index()])
    scene = simple.GetAnimationScene()
    scene.UpdateAnimationUsingDataTimeSteps()
    scene.GoToLast()
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = [1000, 800]
    simple.LoadPalette("WhiteBackground")
    fluid, points = show(reader, view, "fluid", "type", 0, 0)
    plane = points is None or points[:, 2].min() == points[:, 2].max()
    simple.ColorBy(fluid, ("POINTS", "velocity", "Magnitude"))
    fluid.RescaleTransferFunctionToDataRange(False)
    fluid.SetScalarBarVisibility(view, True)
    bodies, _ = show(reader, view, "bodies", "boundary", 4 if plane else 6, 1e9)  # the sides of the box come before
    box = simple.Show(simple.Outline(Input=reader), view)
    for shown in bodies, box:
        shown.ColorArrayName = [None, ""]
        shown.AmbientColor = shown.DiffuseColor = [0.5, 0.5, 0.5]
    if plane:
        view.InteractionMode = "2D"
    else:
        camera = view.GetActiveCamera()
        camera.Azimuth(30)
        camera.Elevation(20)
    simple.ResetCamera(view)
    simple.Render(view)
    for word in sys.argv[1:]:
        if word.endswith(".png"):
            simple.SaveScreenshot(word, view)


main()
