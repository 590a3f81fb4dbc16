"""A ComfyUI node that simplifies meshes with their texture coordinates, colours and normals.

Put this folder into `custom_nodes` and install the package `neural-mesh` into ComfyUI's environment.
"""

from .simplify import SimplifyMesh

NODE_CLASS_MAPPINGS = {"NeuralMeshSimplify": SimplifyMesh}
NODE_DISPLAY_NAME_MAPPINGS = {"NeuralMeshSimplify": "Simplify Mesh (neural-mesh)"}

__all__ = ["NODE_CLASS_MAPPINGS", "NODE_DISPLAY_NAME_MAPPINGS"]
