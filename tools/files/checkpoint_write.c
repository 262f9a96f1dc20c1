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

static bool write_columns(hid_t dataset, const checkpoint_item *item)
{
    size_t width;
    char *names = hdf5_image_words((const char *const *)item->column_names, item->columns, &width);
    hid_t type = hdf5_image_text_type(width);
    bool written = names && type >= 0 &&
                   hdf5_image_attribute(dataset, "columns", type, type, item->columns, names);
    hdf5_image_close(type);
    free(names);
    return written;
}

/* Make the groups above an item. */
static bool write_groups(hid_t file, const char *name)
{
    char prefix[CHECKPOINT_MAX_NAME + 1];
    for (const char *slash = strchr(name, '/'); slash; slash = strchr(slash + 1, '/')) {
        memcpy(prefix, name, (size_t)(slash - name));
        prefix[slash - name] = 0;
        if (H5Lexists(file, prefix, H5P_DEFAULT) > 0) {
            continue;
        }
        hid_t group = hdf5_image_group(file, prefix);
        hdf5_image_close(group);
        if (group < 0) {
            return false;
        }
    }
    return true;
}

static bool write_item(hid_t file, const checkpoint_item *item)
{
    hsize_t shape[CHECKPOINT_MAX_RANK] = {item->shape[0], item->shape[1], item->shape[2]};
    bool is_text = item->kind == CHECKPOINT_TEXT;
    hid_t text = is_text ? hdf5_image_text_type(item->count + 1) : H5I_INVALID_HID;
    hid_t dataset = hdf5_image_dataset(file, item->name, is_text ? text : file_type(item->kind),
                                       is_text ? text : checkpoint_memory_type(item->kind),
                                       is_text ? 0 : item->rank, shape, checkpoint_item_data(item));
    bool written = dataset >= 0 && (item->columns == 0 || write_columns(dataset, item));
    hdf5_image_close(dataset);
    hdf5_image_close(text);
    return written;
}

static bool write_contents(hid_t file, const void *context)
{
    const checkpoint *cp = context;
    int64_t version = CHECKPOINT_FORMAT_VERSION;
    uint64_t digest = checkpoint_digest(cp);
    bool written =
        hdf5_image_text(file, "format", CHECKPOINT_MAGIC) &&
        hdf5_image_attribute(file, "format_version", H5T_STD_I64LE, H5T_NATIVE_INT64, 0,
                             &version) &&
        hdf5_image_text(file, "library_version", cp->library_version) &&
        hdf5_image_attribute(file, "checksum", H5T_STD_U64LE, H5T_NATIVE_UINT64, 0, &digest);
    for (size_t k = 0; written && k < cp->count; k++) {
        written = write_groups(file, cp->items[k].name) && write_item(file, &cp->items[k]);
    }
    return written;
}

/* The whole file as bytes; the caller owns them. */
static ad_status build_file(const checkpoint *cp, unsigned char **bytes, size_t *size)
{
    size_t elements = 0;
    for (size_t k = 0; k < cp->count; k++) {
        elements += cp->items[k].count;
    }
    ad_status status = hdf5_image_write(CHECKPOINT_USER_BLOCK, elements * sizeof(double),
                                        write_contents, cp, bytes, size);
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
