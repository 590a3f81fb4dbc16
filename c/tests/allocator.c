// Tests nm_set_allocator: all blocks come from the caller's functions and go back to them, none is left of a call, and it is refused late.
// `allocator late` sets the functions after a call.
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "neural_mesh_core.h"

enum { N = 48, VERTICES = N * N, INDICES = 6 * N * N, MARK = 0x6e6d };

static float positions[VERTICES][3];
static uint32_t indices[INDICES], left[INDICES];
static atomic_long n_allocated, n_freed;

// A mark in front of each block, within the alignment of malloc.
static void *count_allocation(size_t size) {
    atomic_fetch_add(&n_allocated, 1);
    size_t *block = malloc(size + 16);
    *block = MARK;
    return (char *)block + 16;
}

static void count_free(void *block) {
    size_t *whole = (size_t *)((char *)block - 16);
    if (*whole != MARK) abort();
    *whole = 0;
    atomic_fetch_add(&n_freed, 1);
    free(whole);
}

static void make_torus(void) {
    uint32_t *next = indices;
    for (uint32_t i = 0; i < N; i++)
        for (uint32_t j = 0; j < N; j++) {
            float u = 6.2831853f * i / N, v = 6.2831853f * j / N, *p = positions[i * N + j];
            p[0] = (2 + cosf(v)) * cosf(u), p[1] = (2 + cosf(v)) * sinf(u), p[2] = sinf(v);
            uint32_t a = i * N + j, b = (i + 1) % N * N + j, c = (i + 1) % N * N + (j + 1) % N, d = i * N + (j + 1) % N;
            uint32_t corners[6] = {a, b, c, a, c, d};
            memcpy(next, corners, sizeof corners);
            next += 6;
        }
}

static void simplify(void) {
    CHECK(nm_simplify(left, indices, INDICES, positions[0], VERTICES, 12, INDICES / 4, 1, 0, NULL) == INDICES / 4);
}

int main(int count, char **arguments) {
    make_torus();
    if (count > 1 && strcmp(arguments[1], "late") == 0) {
        simplify();
        CHECK(nm_set_allocator(count_allocation, count_free) == 0 && strstr(nm_last_error(), "before all other calls"));
        simplify();
        CHECK(n_allocated == 0 && n_freed == 0);
        return 0;
    }
    CHECK(nm_set_allocator(count_allocation, count_free) == 1);
    simplify();
    long n_first = n_allocated, n_kept = n_allocated - n_freed;
    CHECK(n_first > 20 && n_kept >= 0 && n_kept < 5);
    simplify();
    CHECK(n_allocated > n_first + 10 && n_allocated - n_freed == n_kept);
    CHECK(nm_simplify(left, indices, 4, positions[0], VERTICES, 12, 0, 1, 0, NULL) == NM_FAILED);
    nm_pool *pool = nm_pool_new(2);
    nm_pool_use(pool);
    simplify();
    nm_pool_use(NULL);
    nm_pool_free(pool);
    CHECK(nm_set_allocator(count_allocation, count_free) == 0 && nm_set_allocator(NULL, count_free) == 0);
    simplify();
    CHECK(n_allocated > n_freed);
    printf("%ld blocks of the caller\n", (long)n_allocated);
    return 0;
}
