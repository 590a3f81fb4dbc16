"""A node for ComfyUI: a mesh in, a lighter mesh out, with texture coordinates, colours and normals.

Put this folder into `custom_nodes` and install the package `neural-mesh` beside ComfyUI's own.
"""

from .simplify import SimplifyMesh

NODE_CLASS_MAPPINGS = {"NeuralMeshSimplify": SimplifyMesh}
NODE_DISPLAY_NAME_MAPPINGS = {"NeuralMeshSimplify": "Simplify Mesh (neural-mesh)"}

__all__ = ["NODE_CLASS_MAPPINGS", "NODE_DISPLAY_NAME_MAPPINGS"]
