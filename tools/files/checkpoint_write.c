/* The items of a checkpoint to a file. Layout in checkpoint.h. */
#include <hdf5.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/checkpoint.h"
#include "tools/files/checkpoint_parts.h"
#include "tools/files/file_bytes.h"
#include "tools/files/hdf5_image.h"

void checkpoint_user_block(unsigned char *block, size_t file_size, uint64_t hash)
{
    memset(block, 0, CHECKPOINT_USER_BLOCK);
    snprintf((char *)block, CHECKPOINT_USER_BLOCK,
             CHECKPOINT_MAGIC "\nformat_version %d\nbytes %zu\nfnv1a64 %016" PRIx64 "\n",
             CHECKPOINT_FORMAT_VERSION, file_size, hash);
}

static hid_t file_type(checkpoint_kind kind)
{
    return kind == CHECKPOINT_DOUBLE  ? H5T_IEEE_F64LE
           : kind == CHECKPOINT_INT64 ? H5T_STD_I64LE
                                      : H5T_STD_U64LE;
}

hid_t checkpoint_memory_type(checkpoint_kind kind)
{
    return kind == CHECKPOINT_DOUBLE  ? H5T_NATIVE_DOUBLE
           : kind == CHECKPOINT_INT64 ? H5T_NATIVE_INT64
                                      : H5T_NATIVE_UINT64;
}

/* Attribute with `count` elements, or a scalar if count is 0. */
static bool write_attribute(hid_t object, const char *name, hid_t type, hid_t from, size_t count,
                            const void *data)
{
    hid_t space =
        count == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, (const hsize_t[]){count}, NULL);
    hid_t attribute = space < 0 ? H5I_INVALID_HID
                                : H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    bool written = attribute >= 0 && H5Awrite(attribute, from, data) >= 0;
    hdf5_image_close(attribute);
    hdf5_image_close(space);
    return written;
}

static bool write_text_attribute(hid_t object, const char *name, const char *text)
{
    hid_t type = hdf5_image_text_type(strlen(text) + 1);
    bool written = type >= 0 && write_attribute(object, name, type, type, 0, text);
    hdf5_image_close(type);
    return written;
}

static bool write_columns(hid_t dataset, const checkpoint_item *item)
{
    size_t width = 1;
    for (size_t k = 0; k < item->columns; k++) {
        size_t needed = strlen(item->column_names[k]) + 1;
        width = needed > width ? needed : width;
    }
    char *names = calloc(item->columns, width);
    hid_t type = hdf5_image_text_type(width);
    for (size_t k = 0; names && k < item->columns; k++) {
        strcpy(names + k * width, item->column_names[k]);
    }
    bool written =
        names && type >= 0 && write_attribute(dataset, "columns", type, type, item->columns, names);
    hdf5_image_close(type);
    free(names);
    return written;
}

/* Make the groups above an item. */
static bool write_groups(hid_t file, const char *name, hid_t group_creation)
{
    char prefix[CHECKPOINT_MAX_NAME + 1];
    for (const char *slash = strchr(name, '/'); slash; slash = strchr(slash + 1, '/')) {
        memcpy(prefix, name, (size_t)(slash - name));
        prefix[slash - name] = 0;
        if (H5Lexists(file, prefix, H5P_DEFAULT) > 0) {
            continue;
        }
        hid_t group = H5Gcreate2(file, prefix, H5P_DEFAULT, group_creation, H5P_DEFAULT);
        hdf5_image_close(group);
        if (group < 0) {
            return false;
        }
    }
    return true;
}

static bool write_item(hid_t file, const checkpoint_item *item, hid_t dataset_creation)
{
    hsize_t shape[CHECKPOINT_MAX_RANK] = {item->shape[0], item->shape[1], item->shape[2]};
    bool is_text = item->kind == CHECKPOINT_TEXT;
    hid_t text = is_text ? hdf5_image_text_type(item->count + 1) : H5I_INVALID_HID;
    hid_t type = is_text ? text : file_type(item->kind);
    hid_t from = is_text ? text : checkpoint_memory_type(item->kind);
    hid_t space = is_text || item->rank == 0 ? H5Screate(H5S_SCALAR)
                                             : H5Screate_simple(item->rank, shape, NULL);
    hid_t dataset =
        H5Dcreate2(file, item->name, type, space, H5P_DEFAULT, dataset_creation, H5P_DEFAULT);
    bool written = dataset >= 0;
    if (written && (is_text || item->count > 0)) {
        written =
            H5Dwrite(dataset, from, H5S_ALL, H5S_ALL, H5P_DEFAULT, checkpoint_item_data(item)) >= 0;
    }
    if (written && item->columns > 0) {
        written = write_columns(dataset, item);
    }
    hdf5_image_close(dataset);
    hdf5_image_close(space);
    hdf5_image_close(text);
    return written;
}

static bool write_contents(hid_t file, const checkpoint *cp)
{
    int64_t version = CHECKPOINT_FORMAT_VERSION;
    uint64_t digest = checkpoint_digest(cp);
    hid_t dataset_creation = hdf5_image_creation(H5P_DATASET_CREATE);
    hid_t group_creation = hdf5_image_creation(H5P_GROUP_CREATE);
    bool written =
        dataset_creation >= 0 && group_creation >= 0 &&
        write_text_attribute(file, "format", CHECKPOINT_MAGIC) &&
        write_attribute(file, "format_version", H5T_STD_I64LE, H5T_NATIVE_INT64, 0, &version) &&
        write_text_attribute(file, "library_version", cp->library_version) &&
        write_attribute(file, "checksum", H5T_STD_U64LE, H5T_NATIVE_UINT64, 0, &digest);
    for (size_t k = 0; written && k < cp->count; k++) {
        written = write_groups(file, cp->items[k].name, group_creation) &&
                  write_item(file, &cp->items[k], dataset_creation);
    }
    hdf5_image_close(group_creation);
    hdf5_image_close(dataset_creation);
    return written;
}

/* The whole file as bytes; the caller owns them. */
static ad_status build_file(const checkpoint *cp, unsigned char **bytes, size_t *size)
{
    hdf5_printer printer;
    size_t elements = 0;
    for (size_t k = 0; k < cp->count; k++) {
        elements += cp->items[k].count;
    }
    if (!hdf5_image_silence(&printer, elements * sizeof(double))) {
        return AD_NO_MEMORY;
    }
    hid_t file = hdf5_image_create(CHECKPOINT_USER_BLOCK);
    ad_status status = AD_NO_MEMORY;
    if (file >= 0 && write_contents(file, cp)) {
        status = hdf5_image_bytes(file, CHECKPOINT_USER_BLOCK, bytes, size);
    }
    hdf5_image_close(file);
    hdf5_image_restore(&printer);
    if (status == AD_OK) {
        uint64_t hash = checkpoint_hash(CHECKPOINT_HASH_START, *bytes + CHECKPOINT_USER_BLOCK,
                                        *size - CHECKPOINT_USER_BLOCK);
        checkpoint_user_block(*bytes, *size, hash);
    }
    return status;
}

ad_status checkpoint_write(checkpoint *cp, const file_place *place, ad_error *error)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    if (cp->failure.status != AD_OK) {
        return ad_fail(error, cp->failure.status, "%s", cp->failure.message);
    }
    checkpoint_sort(cp);
    ad_status status = build_file(cp, &bytes, &size);
    if (status != AD_OK) {
        return ad_fail(error, status, "%s: cannot be written: out of memory for its %zu items",
                       file_bytes_shown(place->path), cp->count);
    }
    status = file_bytes_put(place, bytes, size, error);
    free(bytes);
    return status;
}
