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

/* The error printer that was installed before hdf5_image_silence, and what has been heard since. */
typedef struct hdf5_printer {
    H5E_auto2_t function;
    void *data;
    bool no_memory; /* an error since was one of memory */
} hdf5_printer;

/* Stop HDF5 printing its error stack, and put the printer back. False: no memory for HDF5 and
 * `size` bytes of data, and it is not touched: where memory ends within it, it recurses, crashes or
 * ends the process. `printer` must stay where it is. */
bool hdf5_image_silence(hdf5_printer *printer, size_t size);
void hdf5_image_restore(const hdf5_printer *printer);

/* A new file in memory behind `user_block` bytes (0, or a power of two >= 512) that are not HDF5;
 * negative on failure. Close with hdf5_image_close. */
hid_t hdf5_image_create(size_t user_block);

/* The bytes of that file, the user block first and zeroed; the caller owns `*bytes`.
 * Error: AD_NO_MEMORY; `*bytes` is then untouched. No message is written. */
ad_status hdf5_image_bytes(hid_t file, size_t user_block, unsigned char **bytes, size_t *size);

/* Open `size` bytes, user block included, read-only; negative if they are not HDF5. */
hid_t hdf5_image_open(const unsigned char *bytes, size_t size);

/* Property list for creating a file, group or dataset without time stamps. Tracking the order of
 * attributes makes HDF5 choose the object headers that have checksums of their own and can hold
 * attributes above 64 KiB. */
hid_t hdf5_image_creation(hid_t property_class);

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
