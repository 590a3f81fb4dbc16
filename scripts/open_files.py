#!/usr/bin/env python3
"""open_files.py TOOL FILE...: opens mesh files with trimesh, open3d or pymeshlab, and prints for each a line of JSON: the numbers
of triangles that the tool can be said to have read, each mesh counted once and wherever a scene places it, or the error.
"""

import json
import sys


def trimesh_opens(path):
    import trimesh
    scene = trimesh.load_scene(path, process=False)
    return [sum(len(mesh.faces) for mesh in meshes) for meshes in (scene.geometry.values(), scene.dump())]


def open3d_opens(path):
    import open3d
    return [len(open3d.io.read_triangle_mesh(path).triangles)]


def pymeshlab_opens(path):
    import pymeshlab
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(path)
    return [sum(mesh.face_number() for mesh in meshes)]


def main():
    opens = {"trimesh": trimesh_opens, "open3d": open3d_opens, "pymeshlab": pymeshlab_opens}[sys.argv[1]]
    for path in sys.argv[2:]:
        try:
            found = opens(path)
        except Exception as error:
            found = f"{type(error).__name__}: {error}".split("\n")[0]
        print(json.dumps(found), flush=True)


main()
