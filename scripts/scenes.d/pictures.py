"""Draws an original and results of it from one view, and says how alike the pictures are."""

import io

import numpy as np
import vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import gltf

SIZE = 640
# From the front, the right and above, as product pictures are taken.
VIEW = np.array([0.6, 0.45, 0.8])
BACKGROUND = 1.0
SHOWN = ("gltfpack", "gltfpack -sa")
# The likeness of pictures that are the same, in dB.
ALIKE = 99.0

vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_ERROR)  # it warns where there is no X server


def to_texture(image):
    """Returns the texture of an image file in memory, rows from the bottom up as glTF's v runs down."""
    pixels = np.ascontiguousarray(np.asarray(Image.open(io.BytesIO(image)).convert("RGB")))
    data = vtk.vtkImageData()
    data.SetDimensions(pixels.shape[1], pixels.shape[0], 1)
    data.GetPointData().SetScalars(numpy_to_vtk(pixels.reshape(-1, 3), deep=True))
    texture = vtk.vtkTexture()
    texture.SetInputDataObject(data)
    texture.InterpolateOn()
    texture.MipmapOn()
    return texture


def to_actor(placed, of_material, image):
    """Returns an actor of the triangles of one material, shaded by their stored normals."""
    n_corners = 3 * int(of_material.sum())
    data = vtk.vtkPolyData()
    points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetData(numpy_to_vtk(placed.corners[of_material].reshape(-1, 3), deep=True))
    cells.SetData(3, numpy_to_vtk(np.arange(n_corners, dtype=np.int64), deep=True, array_type=vtk.VTK_ID_TYPE))
    data.SetPoints(points)
    data.SetPolys(cells)
    data.GetPointData().SetNormals(numpy_to_vtk(placed.normals[of_material].reshape(-1, 3), deep=True))
    # Factors are linear, pictures are not.
    colours = (255 * np.clip(placed.colours[of_material], 0, 1) ** (1 / 2.2)).astype(np.uint8)
    data.GetPointData().SetScalars(numpy_to_vtk(colours.reshape(-1, 3), deep=True))
    data.GetPointData().SetTCoords(numpy_to_vtk(placed.uvs[of_material].reshape(-1, 2), deep=True))
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetInterpolationToPhong()
    actor.GetProperty().SetAmbient(0.25)
    actor.GetProperty().SetDiffuse(0.75)
    if image:
        actor.SetTexture(to_texture(image))
    return actor


def draw_scene(path, centre, diagonal):
    """Returns the picture of a scene, SIZE x SIZE x 3 bytes, and which of its pixels show it."""
    asset = gltf.Asset(path)
    placed = asset.place_scene()
    placed.corners = (placed.corners - centre) / diagonal
    [picture] = draw_triangles(placed, asset.read_base_image, [(VIEW, 1.0)])
    return picture


def add_lights(renderer):
    """Adds a headlight and two lights of the scene: a key from the upper left, a fill from the right."""
    for place, strength, is_at_eye in [((0, 0, 1), 0.5, True), ((-1, 1.2, 1), 0.6, False), ((1.5, 0.2, 0.4), 0.3, False)]:
        light = vtk.vtkLight()
        light.SetLightTypeToHeadlight() if is_at_eye else light.SetLightTypeToCameraLight()
        light.SetPosition(*place)
        light.SetIntensity(strength)
        renderer.AddLight(light)


def look_from(renderer, view, distance):
    """Points the camera at the origin; at `distance` 2 all is half as large."""
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*(2.0 * view / np.linalg.norm(view)))
    camera.SetFocalPoint(0, 0, 0)
    camera.SetViewUp(0, 1, 0)
    half = 0.29 * distance
    renderer.ResetCamera(-half, half, -half, half, -half, half)


def read_window(window):
    """Returns the picture in a window and which of its pixels show triangles."""
    depth, grab = vtk.vtkFloatArray(), vtk.vtkWindowToImageFilter()
    window.GetZbufferData(0, 0, SIZE - 1, SIZE - 1, depth)
    is_shown = vtk_to_numpy(depth).reshape(SIZE, SIZE)[::-1] < 1
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    grab.Update()
    pixels = vtk_to_numpy(grab.GetOutput().GetPointData().GetScalars()).reshape(SIZE, SIZE, -1)[::-1, :, :3]
    return pixels.copy(), is_shown


def draw_triangles(placed, read_image, views, lights=None):
    """Yields per view, a direction and a distance, the picture of triangles about the origin, of diagonal 1, and its shown pixels.

    `read_image` returns the base colour texture of a material; `lights` adds lights to the renderer, which otherwise has a
    headlight.
    """
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    renderer.SetBackground(BACKGROUND, BACKGROUND, BACKGROUND)
    for material in np.unique(placed.materials):
        renderer.AddActor(to_actor(placed, placed.materials == material, read_image(material)))
    if lights:
        lights(renderer)
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(8)
    window.SetSize(SIZE, SIZE)
    window.AddRenderer(renderer)
    for direction, distance in views:
        look_from(renderer, direction, distance)
        window.Render()
        yield read_window(window)
    window.Finalize()


def measure_psnr(original, result):
    """Returns the PSNR of two pictures in dB, over the pixels that show either."""
    (one, is_in_one), (other, is_in_other) = original, result
    differences = one[is_in_one | is_in_other].astype(float) - other[is_in_one | is_in_other]
    error = np.mean(differences**2) if len(differences) else 0.0
    return min(10 * float(np.log10(255**2 / error)), ALIKE) if error else ALIKE


def draw_results(original):
    """Writes original, program's and gltfpack's side by side beside the results; returns (run, PSNR) of each that is there."""
    before, found = draw_scene(original.path, original.centre, original.diagonal), []
    for tool in SHOWN:
        runs = [run for run in (f"as {tool}", tool) if original.result_path(run).is_file()]
        pictures = [draw_scene(original.result_path(run), original.centre, original.diagonal) for run in runs]
        found += [(run, measure_psnr(before, picture)) for run, picture in zip(runs, pictures, strict=True)]
        side_by_side = np.concatenate([before[0]] + [picture[0] for picture in pictures], axis=1)
        Image.fromarray(side_by_side).save(original.folder / f"{tool}.png")
    return found
