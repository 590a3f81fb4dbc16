// Tests the functions of neural_mesh.h: results, errors, and ten thousand calls with random arguments.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "neural_mesh.h"

enum { N = 24, VERTICES = N * N, INDICES = 6 * N * N };

static float positions[VERTICES * 4];
static uint32_t indices[INDICES];
static const size_t stride = 4 * sizeof(float);

// Makes a closed torus with one attribute after each position.
static void make_torus(void) {
    uint32_t *next = indices;
    for (uint32_t i = 0; i < N; i++)
        for (uint32_t j = 0; j < N; j++) {
            float u = 6.2831853f * i / N, v = 6.2831853f * j / N, *p = positions + 4 * (i * N + j);
            p[0] = (2 + cosf(v)) * cosf(u), p[1] = (2 + cosf(v)) * sinf(u), p[2] = sinf(v), p[3] = cosf(3 * u);
            uint32_t a = i * N + j, b = (i + 1) % N * N + j, c = (i + 1) % N * N + (j + 1) % N, d = i * N + (j + 1) % N;
            uint32_t corners[6] = {a, b, c, a, c, d};
            memcpy(next, corners, sizeof corners);
            next += 6;
        }
}

static void check_closed(const uint32_t *left, size_t n) {
    for (size_t i = 0; i < n; i++) {
        size_t twins = 0;
        uint32_t a = left[i], b = left[i - i % 3 + (i + 1) % 3];
        for (size_t j = 0; j < n; j++) twins += left[j] == b && left[j - j % 3 + (j + 1) % 3] == a;
        CHECK(twins == 1);
    }
}

static void test_buffers(void) {
    uint32_t left[INDICES];
    float error = -1;
    size_t n = nm_simplify(left, indices, INDICES, positions, VERTICES, stride, INDICES / 4, 1, 0, &error);
    CHECK(n == INDICES / 4 && error > 0 && error < 0.1f);
    check_closed(left, n);
    // A bound on the distance leaves more triangles, in the unit of the positions as well.
    float scale = nm_simplify_scale(positions, VERTICES, stride), again = 0;
    CHECK(fabsf(scale - 6) < 0.1f);
    size_t n_near = nm_simplify(left, indices, INDICES, positions, VERTICES, stride, 3, 0.02f, 0, &error);
    CHECK(n_near > 3 && n_near < INDICES && error <= 0.02f);
    CHECK(nm_simplify(left, indices, INDICES, positions, VERTICES, stride, 3, 0.02f * scale, NM_ERROR_ABSOLUTE, &again) == n_near);
    CHECK(fabsf(again - error * scale) < 1e-4f * scale);
    // In place, with nothing to do, and without an error.
    memcpy(left, indices, sizeof indices);
    CHECK(nm_simplify(left, left, INDICES, positions, VERTICES, stride, INDICES, 0, 0, NULL) == INDICES);
    CHECK(memcmp(left, indices, sizeof indices) == 0);
    CHECK(nm_simplify(left, indices, INDICES, positions, VERTICES, stride, INDICES / 4, 1, 0, NULL) == INDICES / 4);
    CHECK(nm_simplify(left, indices, INDICES, positions, VERTICES, stride, 0, 1, 0, &error) == 0 && error == 1);
    CHECK(nm_simplify(left, indices, 0, positions, VERTICES, stride, 0, 1, 0, NULL) == 0);
}

static void test_pool(void) {
    uint32_t alone[INDICES], shared[INDICES];
    size_t n = nm_simplify(alone, indices, INDICES, positions, VERTICES, stride, INDICES / 4, 1, 0, NULL);
    nm_pool *pool = nm_pool_new(2);
    CHECK(pool != NULL);
    nm_pool_use(pool);
    CHECK(nm_simplify(shared, indices, INDICES, positions, VERTICES, stride, INDICES / 4, 1, 0, NULL) == n);
    CHECK(memcmp(alone, shared, n * sizeof *alone) == 0);
    nm_pool_use(NULL);
    nm_pool_free(pool);
    nm_pool_free(NULL);
}

static void test_other_ways(void) {
    uint32_t left[INDICES], chosen[VERTICES];
    float error = -1;
    unsigned char locks[VERTICES] = {0};
    size_t n = nm_simplify_sloppy(left, indices, INDICES, positions, VERTICES, stride, NULL, 150, 1, &error);
    CHECK(n > 0 && n <= 150 && n % 3 == 0 && error > 0 && error < 1);
    CHECK(nm_simplify_sloppy(left, indices, INDICES, positions, VERTICES, stride, locks, 150, 1e-4f, &error) == INDICES && error == 0);
    CHECK(nm_simplify_prune(left, indices, INDICES, positions, VERTICES, stride, 0.1f) == INDICES);
    CHECK(nm_simplify_prune(left, indices, INDICES, positions, VERTICES, stride, 2) == 0);
    n = nm_simplify_points(chosen, positions, VERTICES, stride, NULL, 0, 0, 50);
    CHECK(n > 10 && n <= 50 && chosen[n - 1] < VERTICES);
    CHECK(nm_simplify_points(chosen, positions, VERTICES, stride, positions, stride, 0.5f, 50) <= 50);
    CHECK(nm_simplify_points(chosen, positions, VERTICES, stride, NULL, 0, 0, VERTICES) == VERTICES);
    CHECK(nm_simplify_sloppy(left, NULL, 3, positions, VERTICES, stride, NULL, 0, 1, NULL) == NM_FAILED);
}

static void test_clusters(void) {
    nm_clusters *made = nm_clusters_build(indices, INDICES, positions, VERTICES, stride, positions + 3, stride, 1, 64, 32);
    CHECK(made);
    size_t n_clusters, n_groups, n_positions, n_attributes, n_vertices, n_triangles, n_bytes;
    const nm_cluster *clusters = nm_clusters_clusters(made, &n_clusters);
    const nm_cluster_group *groups = nm_clusters_groups(made, &n_groups);
    const float *places = nm_clusters_positions(made, &n_positions), *values = nm_clusters_attributes(made, &n_attributes);
    const uint32_t *vertices = nm_clusters_vertices(made, &n_vertices);
    const uint8_t *triangles = nm_clusters_triangles(made, &n_triangles), *bytes = nm_clusters_bytes(made, &n_bytes);
    CHECK(places && values && n_attributes == n_positions && n_groups > 0 && memcmp(bytes, "nmc", 4) == 0 && n_bytes > 65536);
    size_t n_roots = 0, n_finest = 0;
    for (size_t i = 0; i < n_clusters; i++) {
        nm_cluster c = clusters[i];
        n_roots += c.group == NM_NO_GROUP;
        n_finest += c.source == NM_NO_GROUP ? c.triangle_count : 0;
        CHECK(c.vertex_count <= 64 && c.triangle_count <= 32);
        CHECK(c.first_vertex + c.vertex_count <= n_vertices && c.first_triangle + c.triangle_count <= n_triangles);
        if (c.source != NM_NO_GROUP && c.group != NM_NO_GROUP) CHECK(groups[c.group].error >= groups[c.source].error);
        for (size_t k = 0; k < 3 * c.triangle_count; k++) {
            uint8_t corner = triangles[3 * c.first_triangle + k];
            CHECK(corner < c.vertex_count && vertices[c.first_vertex + corner] < n_positions);
        }
    }
    CHECK(n_roots == 1 && n_finest == INDICES / 3);
    nm_clusters_free(made);
    CHECK(!nm_clusters_build(indices, INDICES, positions, VERTICES, stride, NULL, 0, 0, 3, 128) && strstr(nm_last_error(), "max_vertices"));
    CHECK(!nm_clusters_build(indices, 4, positions, VERTICES, stride, NULL, 0, 0, 64, 128) && strstr(nm_last_error(), "index_count"));
    CHECK(!nm_clusters_groups(NULL, NULL) && strstr(nm_last_error(), "is null"));
    nm_clusters_free(NULL);
}

static void test_attributes(void) {
    uint32_t left[INDICES];
    float weight = 0.5f, moved[VERTICES * 4];
    unsigned char locks[VERTICES] = {0};
    locks[7] = locks[100] = 1;
    size_t n = nm_simplify_with_attributes(left, indices, INDICES, positions, VERTICES, stride, positions + 3, stride, &weight, 1,
                                           locks, INDICES / 6, 1, 0, NULL);
    CHECK(n == INDICES / 6);
    size_t used[2] = {0};
    for (size_t i = 0; i < n; i++) used[0] += left[i] == 7, used[1] += left[i] == 100;
    CHECK(used[0] > 0 && used[1] > 0);
    memcpy(moved, positions, sizeof positions);
    memcpy(left, indices, sizeof indices);
    n = nm_simplify_with_update(left, INDICES, moved, VERTICES, stride, moved + 3, stride, &weight, 1, NULL, INDICES / 6, 1, 0, NULL);
    CHECK(n == INDICES / 6 && memcmp(moved, positions, sizeof positions) != 0);
    check_closed(left, n);
}

static int32_t count_calls(void *user, float done, const char *stage) {
    int *n = user;
    CHECK(done >= 0 && done <= 1 && stage != NULL);
    return ++*n > 1000000;
}

static int32_t end_run(void *user, float done, const char *stage) {
    return (void)user, (void)done, (void)stage, 1;
}

static void test_jobs(void) {
    nm_job *job = nm_job_new();
    int n = 0;
    CHECK(job != NULL && nm_job_run(job) == NULL && strlen(nm_last_error()) > 0);
    CHECK(nm_job_read_arrays(job, positions, VERTICES, stride, indices, INDICES));
    CHECK(nm_job_set(job, "ratio", "50%") && nm_job_set(job, "format", "obj") && nm_job_set(job, "threads", "1"));
    CHECK(nm_job_listen(job, count_calls, &n));
    nm_result *result = nm_job_run(job);
    CHECK(result != NULL && n > 0 && nm_result_levels(result) == 1);
    const float *places;
    const uint32_t *left;
    size_t vertex_count, index_count, byte_count;
    CHECK(nm_result_arrays(result, 0, &places, &vertex_count, &left, &index_count));
    CHECK(vertex_count == VERTICES / 2 && index_count == INDICES / 2);
    check_closed(left, index_count);
    const char *bytes = nm_result_bytes(result, 0, &byte_count);
    CHECK(bytes != NULL && byte_count > 1000 && memchr(bytes, 'v', byte_count) != NULL);
    CHECK(strstr(nm_result_report(result), "\"outcome\":\"reached\"") != NULL);
    // The file of one job is the mesh of the next; each level is a file.
    nm_job *again = nm_job_new();
    CHECK(nm_job_read_bytes(again, bytes, byte_count, "mesh.obj") && nm_job_set(again, "lods", "50%,25%"));
    nm_result *levels = nm_job_run(again);
    CHECK(levels != NULL && nm_result_levels(levels) == 2 && nm_result_bytes(levels, 1, NULL) != NULL);
    CHECK(nm_result_bytes(levels, 2, NULL) == NULL && strstr(nm_last_error(), "level: 2") != NULL);
    CHECK(nm_job_listen(again, end_run, NULL) && nm_job_run(again) == NULL);
    CHECK(nm_job_listen(again, NULL, NULL) && nm_job_cancel(again) && nm_job_run(again) == NULL);
    nm_result_free(levels);
    nm_result_free(result);
    nm_job_free(again);
    nm_job_free(job);
}

static void test_errors(void) {
    uint32_t left[INDICES], wrong[3] = {0, 1, VERTICES};
    float nan_weight = NAN;
    CHECK(nm_simplify(left, NULL, 3, positions, VERTICES, stride, 3, 1, 0, NULL) == NM_FAILED);
    CHECK(strcmp(nm_last_error(), "indices: is null") == 0);
    CHECK(nm_simplify(left, indices, 4, positions, VERTICES, stride, 3, 1, 0, NULL) == NM_FAILED);
    CHECK(nm_simplify(left, wrong, 3, positions, VERTICES, stride, 0, 1, 0, NULL) == NM_FAILED);
    CHECK(nm_simplify(left, indices, INDICES, positions, VERTICES, 7, 3, 1, 0, NULL) == NM_FAILED);
    CHECK(nm_simplify(left, indices, INDICES, positions, SIZE_MAX, stride, 3, 1, 0, NULL) == NM_FAILED);
    CHECK(nm_simplify(left, indices, INDICES, positions, VERTICES, stride, 3, NAN, 0, NULL) == NM_FAILED);
    CHECK(nm_simplify(left, indices, INDICES, positions, VERTICES, stride, 3, 1, 1 << 20, NULL) == NM_FAILED);
    CHECK(nm_simplify(NULL, indices, INDICES, positions, VERTICES, stride, 300, 1, 0, NULL) == NM_FAILED);
    CHECK(nm_simplify_with_attributes(left, indices, INDICES, positions, VERTICES, stride, positions, stride, &nan_weight, 1, NULL, 3, 1, 0, NULL) == NM_FAILED);
    nm_job *job = nm_job_new();
    CHECK(!nm_job_set(job, "ration", "0.1") && !nm_job_set(job, NULL, "1") && !nm_job_set(job, "threads", "0"));
    CHECK(!nm_job_set(NULL, "ratio", "0.1") && !nm_job_read_file(job, "nowhere.ply") && !nm_job_read_bytes(job, NULL, 5, NULL));
    CHECK(nm_job_read_arrays(job, positions, VERTICES, stride, indices, INDICES) && nm_job_set(job, "format", "doc"));
    CHECK(nm_job_run(job) == NULL && strncmp(nm_last_error(), "format: doc: choose from ", 24) == 0);
    CHECK(nm_job_run(NULL) == NULL && nm_result_levels(NULL) == 0 && nm_result_report(NULL) == NULL);
    CHECK(nm_abi_version() == NM_ABI_VERSION && strlen(nm_last_error()) == 0 + strlen(nm_last_error()));
    nm_job_free(job);
    nm_job_free(NULL);
    nm_result_free(NULL);
}

static uint32_t state = 1;

static uint32_t draw(uint32_t below) {
    state ^= state << 13, state ^= state >> 17, state ^= state << 5;
    return state % below;
}

// Arrays are null or exactly as large as the counts say: sanitizers see what reads beyond.
static void test_random_calls(void) {
    for (int i = 0; i < 10000; i++) {
        size_t vertex_count = draw(12), index_count = draw(40), width = draw(3);
        float *places = malloc(vertex_count * 20 + 1), *values = malloc(vertex_count * width * sizeof(float) + 1);
        float weights[2] = {draw(3) / 2.0f, 1}, error;
        uint32_t *corners = malloc(index_count * sizeof(uint32_t) + 1);
        for (size_t k = 0; k < 5 * vertex_count; k++) places[k] = draw(50) ? draw(5) : draw(2) ? NAN : INFINITY;
        for (size_t k = 0; k < width * vertex_count; k++) values[k] = draw(9);
        for (size_t k = 0; k < index_count; k++) corners[k] = draw((uint32_t)vertex_count + (draw(20) == 0) + (vertex_count == 0));
        size_t count = draw(3) ? index_count / 3 * 3 : index_count;
        size_t left = nm_simplify_with_update(draw(30) ? corners : NULL, count, draw(30) ? places : NULL, vertex_count, draw(30) ? 12 : draw(20),
                                              draw(30) ? values : NULL, width ? 4 * width : 0, draw(30) ? weights : NULL, width, NULL, draw(40),
                                              draw(9) ? draw(10) / 9.0f : -1, draw(128), draw(2) ? &error : NULL);
        CHECK(strncmp(nm_last_error(), "internal", 8) != 0);
        CHECK(left == NM_FAILED ? strlen(nm_last_error()) > 0 : left <= count && left % 3 == 0);
        for (size_t k = 0; left != NM_FAILED && k < left; k++) CHECK(corners[k] < vertex_count);
        free(places), free(values), free(corners);
    }
}

int main(void) {
    make_torus();
    test_buffers();
    test_pool();
    test_other_ways();
    test_clusters();
    test_attributes();
    test_jobs();
    test_errors();
    test_random_calls();
    puts("all tests passed");
    return 0;
}
