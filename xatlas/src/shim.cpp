// The few calls of xatlas that are needed, as C functions over plain arrays.

#include <xatlas.h>

using namespace xatlas;

// What a layout is: sides in texels, numbers of charts, vertices and atlases, texels along a unit of length.
struct NeuralMeshLayout {
    uint32_t width, height, charts, vertices, atlases;
    float texels_per_unit;
};

extern "C" {

// Cuts triangles into charts; null where they are none.
Atlas *neural_mesh_charts(const float *positions, uint32_t n_vertices, const uint32_t *faces, uint32_t n_faces)
{
    static const bool quiet = (SetPrint(nullptr, false), true);
    (void)quiet;
    MeshDecl mesh;
    mesh.vertexPositionData = positions;
    mesh.vertexPositionStride = 3 * sizeof(float);
    mesh.vertexCount = n_vertices;
    mesh.indexData = faces;
    mesh.indexCount = 3 * n_faces;
    mesh.indexFormat = IndexFormat::UInt32;
    Atlas *atlas = Create();
    if (AddMesh(atlas, mesh) != AddMeshError::Success) {
        Destroy(atlas);
        return nullptr;
    }
    ComputeCharts(atlas);
    return atlas;
}

// Lays the charts out; 0 texels along a unit: as many as about fill the resolution.
void neural_mesh_pack(Atlas *atlas, uint32_t resolution, uint32_t padding, float texels_per_unit, NeuralMeshLayout *layout)
{
    PackOptions options;
    options.padding = padding;
    options.texelsPerUnit = texels_per_unit;
    options.resolution = texels_per_unit > 0 ? 0 : resolution;
    PackCharts(atlas, options);
    layout->width = atlas->width;
    layout->height = atlas->height;
    layout->charts = atlas->chartCount;
    layout->vertices = atlas->meshCount > 0 ? atlas->meshes[0].vertexCount : 0;
    layout->atlases = atlas->atlasCount;
    layout->texels_per_unit = atlas->texelsPerUnit;
}

// Copies the vertices of the layout (chart, or -1 for none; texels; vertex of the input) and its faces.
void neural_mesh_copy(const Atlas *atlas, int32_t *charts, float *texels, uint32_t *vertices, uint32_t *faces)
{
    const Mesh &mesh = atlas->meshes[0];
    for (uint32_t i = 0; i < mesh.vertexCount; i++) {
        const Vertex &vertex = mesh.vertexArray[i];
        charts[i] = vertex.atlasIndex < 0 ? -1 : vertex.chartIndex;
        texels[2 * i] = vertex.uv[0];
        texels[2 * i + 1] = vertex.uv[1];
        vertices[i] = vertex.xref;
    }
    for (uint32_t i = 0; i < mesh.indexCount; i++)
        faces[i] = mesh.indexArray[i];
}

void neural_mesh_free(Atlas *atlas)
{
    Destroy(atlas);
}

}
