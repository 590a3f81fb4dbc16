/* neural-mesh for C. SPDX-License-Identifier: MIT OR Apache-2.0
 *
 * Functions that fail give 0, null or NM_FAILED; nm_last_error() says why, in one line. Every function may be called from any thread; one job
 * is run by one thread at a time. Made from Rust by cbindgen: not to be edited. */

#ifndef NEURAL_MESH_H
#define NEURAL_MESH_H

#include <stddef.h>
#include <stdint.h>

// What functions that give a number of indices give where they fail.
#define NM_FAILED SIZE_MAX

// Number of this interface: another one where functions change or go.
#define NM_ABI_VERSION 1



// Vertices on boundaries stay.
#define NM_LOCK_BORDER 1

// Accepted for its meaning elsewhere, and of no effect here: vertices that no index names cost nothing.
#define NM_SPARSE 2

// Errors are in the unit of the positions, not shares of the extent.
#define NM_ERROR_ABSOLUTE 4

// Components that cost more than they show may go.
#define NM_PRUNE 8

// Accepted for its meaning elsewhere, and of no effect here: triangles are regular as they are.
#define NM_REGULARIZE 16

// Accepted for its meaning elsewhere, and of no effect here: seams cost their price always.
#define NM_PERMISSIVE 32

// What is to be simplified, and how.
typedef struct nm_job nm_job;

// What came of a job.
typedef struct nm_result nm_result;

// Hears how far a run is, from 0 to 1, and at what; anything but 0 ends it. It may be called on another thread than the one that runs the
// job, never on two at once.
typedef int32_t (*nm_progress)(void *user, float done, const char *stage);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Returns the number of the interface that the library has; a program compares it with `NM_ABI_VERSION`.
uint32_t nm_abi_version(void);

// Returns why the last call of this thread failed, in one line of UTF-8; empty where it did not. The text is there until the next call of
// this thread.
const char *nm_last_error(void);

// Simplifies an index buffer: writes the indices that are left to `destination`, which has room for `index_count`, and returns how many.
//
// The result has `target_index_count` indices at most where it stays within `target_error` of the original, a share of the longest side of
// its box, else as few as stay within. Vertices stay where they are. `result_error`, unless null, gets the error. Returns `NM_FAILED` where
// it fails.
//
// # Safety
// As many values as are said are at each address; `vertex_positions_stride` is in bytes.
size_t nm_simplify(uint32_t *destination,
                   const uint32_t *indices,
                   size_t index_count,
                   const float *vertex_positions,
                   size_t vertex_count,
                   size_t vertex_positions_stride,
                   size_t target_index_count,
                   float target_error,
                   uint32_t options,
                   float *result_error);

// As `nm_simplify`, where numbers of the vertices count: `attribute_count` of them, each times its weight, are as dear as a distance of that
// share of the extent. A vertex whose `vertex_lock` is odd stays; the array may be null.
//
// # Safety
// As for `nm_simplify`; `vertex_attributes_stride` is in bytes.
size_t nm_simplify_with_attributes(uint32_t *destination,
                                   const uint32_t *indices,
                                   size_t index_count,
                                   const float *vertex_positions,
                                   size_t vertex_count,
                                   size_t vertex_positions_stride,
                                   const float *vertex_attributes,
                                   size_t vertex_attributes_stride,
                                   const float *attribute_weights,
                                   size_t attribute_count,
                                   const uint8_t *vertex_lock,
                                   size_t target_index_count,
                                   float target_error,
                                   uint32_t options,
                                   float *result_error);

// As `nm_simplify_with_attributes`, where vertices move to where they serve best: indices, positions and attributes are written over.
//
// # Safety
// As for `nm_simplify_with_attributes`; the arrays are written to.
size_t nm_simplify_with_update(uint32_t *indices,
                               size_t index_count,
                               float *vertex_positions,
                               size_t vertex_count,
                               size_t vertex_positions_stride,
                               float *vertex_attributes,
                               size_t vertex_attributes_stride,
                               const float *attribute_weights,
                               size_t attribute_count,
                               const uint8_t *vertex_lock,
                               size_t target_index_count,
                               float target_error,
                               uint32_t options,
                               float *result_error);

// Returns the longest side of the box around vertices, which errors are shares of; negative where it fails.
//
// # Safety
// As many positions as are said are at the address.
float nm_simplify_scale(const float *vertex_positions, size_t vertex_count, size_t vertex_positions_stride);

// Returns a job without a mesh and without options; `nm_job_free` gives it back. Null where it fails.
nm_job *nm_job_new(void);

// Gives a job back; nothing where it is null.
//
// # Safety
// The job is one of `nm_job_new`, and nobody uses it any more.
void nm_job_free(nm_job *job);

// Sets an option of `neural-mesh simplify` by its name, `_` for `-`, to a value as it is typed there: `ratio` to `10%`, `subset` to `true`,
// `threads` to `2`. Returns 1, or 0 where it fails.
//
// # Safety
// Job and texts are valid.
int32_t nm_job_set(const nm_job *job,
                   const char *name,
                   const char *value);

// Takes the mesh from a file; of what it names, what lies in its folder is found. Returns 1, or 0 where it fails.
//
// # Safety
// Job and text are valid.
int32_t nm_job_read_file(const nm_job *job, const char *path);

// Takes the mesh from the bytes of a file; `name`, which may be null, says the format where the bytes do not. Returns 1, or 0 where it
// fails.
//
// # Safety
// Job and text are valid, and so many bytes are at the address.
int32_t nm_job_read_bytes(const nm_job *job,
                          const void *data,
                          size_t byte_count,
                          const char *name);

// Takes the mesh from positions and triangles. Returns 1, or 0 where it fails.
//
// # Safety
// The job is valid, and as many values as are said are at each address; the stride is in bytes.
int32_t nm_job_read_arrays(const nm_job *job,
                           const float *vertex_positions,
                           size_t vertex_count,
                           size_t vertex_positions_stride,
                           const uint32_t *indices,
                           size_t index_count);

// Lets a function hear how far a run is; `user` goes back to it. Returns 1, or 0 where it fails.
//
// # Safety
// The job is valid, and the function may be called until the job is given back.
int32_t nm_job_listen(const nm_job *job, nm_progress progress, void *user);

// Ends the run of a job, from any thread; one that runs it next ends at once, too. Returns 1, or 0 where it fails.
//
// # Safety
// The job is valid.
int32_t nm_job_cancel(const nm_job *job);

// Runs a job and returns its result, which `nm_result_free` gives back; null where it fails. A job may run again, with other options.
//
// # Safety
// The job is valid.
nm_result *nm_job_run(const nm_job *job);

// Returns how many levels of detail a result has, 1 without such; 0 where it fails.
//
// # Safety
// The result is valid.
size_t nm_result_levels(const nm_result *result);

// Returns the report as JSON, UTF-8 that ends with a zero and lasts as long as the result; null where it fails.
//
// # Safety
// The result is valid.
const char *nm_result_report(const nm_result *result);

// Gives the addresses of a level's positions (3 numbers each) and indices, and how many there are; they last as long as the result. Places
// that are null get nothing. Returns 1, or 0 where it fails.
//
// # Safety
// The result is valid, and so are the places that are not null.
int32_t nm_result_arrays(const nm_result *result,
                         size_t level,
                         const float **vertex_positions,
                         size_t *vertex_count,
                         const uint32_t **indices,
                         size_t *index_count);

// Returns the bytes of a level's file, in the format of the option `format`, PLY without it, and writes how many to `byte_count`; they last
// as long as the result. Null where it fails.
//
// # Safety
// The result is valid, and so is the place unless it is null.
const void *nm_result_bytes(const nm_result *result,
                            size_t level,
                            size_t *byte_count);

// Writes a level's file, with what belongs beside it; one that is there is replaced where `force` is not 0. Returns 1, or 0 where it fails.
//
// # Safety
// Result and text are valid.
int32_t nm_result_write(const nm_result *result,
                        size_t level,
                        const char *path,
                        int32_t force);

// Gives a result back; nothing where it is null.
//
// # Safety
// The result is one of `nm_job_run`, and nobody uses it or what it gave any more.
void nm_result_free(nm_result *result);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* NEURAL_MESH_H */
