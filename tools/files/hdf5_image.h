/* HDF5 files that live in memory: the HDF5 library only turns datasets into bytes and back, and
 * never opens a file itself. So a full disk, a kill or the library's exit hooks cannot meet a
 * half-written file, and nothing stays open between calls. Shared by checkpoints and tables.
 *
 * Files are deterministic: no time stamps, so equal content gives equal bytes. */
#ifndef TOOLS_FILES_HDF5_IMAGE_H
#define TOOLS_FILES_HDF5_IMAGE_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>

#include "autodiff/error.h"

/* A file that `write` fills, as bytes behind `user_block` of them (0, or a power of two >= 512)
 * that are not HDF5 but zeros; `data` bytes are put in. The caller owns `*bytes`. AD_NO_MEMORY,
 * also where `write` returns false; `*bytes` is then untouched, and there is no message. */
ad_status hdf5_image_write(size_t user_block, size_t data,
                           bool (*write)(hid_t file, const void *context), const void *context,
                           unsigned char **bytes, size_t *size);

/* Calls `read` with `size` bytes, user block included, as a file; negative: they are not HDF5. What
 * it returns, but AD_NO_MEMORY in place of AD_BAD_INPUT where HDF5 had none; and AD_NO_MEMORY,
 * where it was not called. */
ad_status hdf5_image_read(const unsigned char *bytes, size_t size,
                          ad_status (*read)(hid_t file, void *context), void *context);

/* What a file consists of, without time stamps. `stored` and `given`: types in the file and of
 * `values`. Of a group and a dataset: negative on failure; close with hdf5_image_close. */
hid_t hdf5_image_group(hid_t parent, const char *name);
/* shape[rank]; rank 0: a scalar. */
hid_t hdf5_image_dataset(hid_t parent, const char *name, hid_t stored, hid_t given, int rank,
                         const hsize_t *shape, const void *values);
/* An attribute of `count` values, 0: of a scalar; and of a text. */
bool hdf5_image_attribute(hid_t object, const char *name, hid_t stored, hid_t given, size_t count,
                          const void *values);
bool hdf5_image_text(hid_t object, const char *name, const char *text);

/* Words as values of the type hdf5_image_text_type(*size), to be freed by the caller; NULL: no
 * memory. */
char *hdf5_image_words(const char *const *words, size_t count, size_t *size);

/* Texts of up to size - 1 bytes in UTF-8, ended by a zero byte. Close with hdf5_image_close. */
hid_t hdf5_image_text_type(size_t size);

/* Close an identifier of any kind; a negative one is fine. */
void hdf5_image_close(hid_t identifier);

/* Name of the link number `index` of `group`, by creation where `by_creation`, else by name, to
 * name [size] with its last zero. False: damaged, too long, or not the only hard link to its object
 * (soft and external links can lead out of the file, and what has two names could be visited for
 * ever, so they are never followed). */
bool hdf5_image_link_name(hid_t group, hsize_t index, bool by_creation, char *name, size_t size);

/* What is wrong with how the `count` > 0 elements of `width` bytes of a dataset are stored in an
 * image of so many bytes, NULL if nothing is: not in this file, more than it can hold, or by a
 * filter other than gzip, shuffle and fletcher32. Asked before there is memory for them. */
const char *hdf5_image_storage_problem(hid_t dataset, hsize_t count, size_t width,
                                       size_t image_size);

#endif
