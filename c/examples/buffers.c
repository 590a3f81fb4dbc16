// Simplifies an index buffer, as with meshoptimizer: a wavy sheet of 20,000 triangles to a tenth.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "neural_mesh_core.h"

int main(void) {
    enum { N = 100 };
    size_t vertex_count = (N + 1) * (N + 1), index_count = 6 * N * N;
    float *positions = malloc(vertex_count * 3 * sizeof(float));
    uint32_t *indices = malloc(index_count * sizeof(uint32_t)), *next = indices;
    for (int i = 0; i <= N; i++)
        for (int j = 0; j <= N; j++) {
            float x = (float)i / N, y = (float)j / N, *p = positions + 3 * (i * (N + 1) + j);
            p[0] = x, p[1] = y, p[2] = 0.1f * sinf(7 * x) * cosf(9 * y);
            if (i < N && j < N) {
                uint32_t a = i * (N + 1) + j, b = a + N + 1;
                *next++ = a, *next++ = b, *next++ = a + 1;
                *next++ = a + 1, *next++ = b, *next++ = b + 1;
            }
        }
    float error = 0;
    size_t left = nm_simplify(indices, indices, index_count, positions, vertex_count, 3 * sizeof(float), index_count / 10,
                              0.05f, 0, &error);
    if (left == NM_FAILED) return fprintf(stderr, "%s\n", nm_last_error()), 1;
    printf("%zu of %zu triangles, within %.4f of the extent\n", left / 3, index_count / 3, error);
    free(positions);
    free(indices);
    return 0;
}
