/* A file to the items of a checkpoint. Layout in checkpoint.h. */
#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "tools/files/checkpoint.h"
#include "tools/files/checkpoint_parts.h"
#include "tools/files/file_bytes.h"
#include "tools/files/hdf5_image.h"

/* ---- the first bytes ---- */

/* What to do about a bad file: name the generation before it if there is one. "run/checkpoint.h5"
 * is followed by "run/checkpoint.1.h5", that one by "run/checkpoint.2.h5". */
static const char *advice(const char *path, char *scratch, size_t size)
{
    size_t stem = strlen(path), digits = 0;
    char *older = NULL;
    int index = 0;
    if (stem > 3 && strcmp(path + stem - 3, ".h5") == 0) {
        stem -= 3;
        while (digits < 6 && digits < stem && strchr("0123456789", path[stem - digits - 1])) {
            digits++;
        }
        if (digits > 0 && digits < stem && path[stem - digits - 1] == '.') {
            index = (int)strtol(path + stem - digits, NULL, 10); /* of six at most */
            stem -= digits + 1;
        }
    }
    size_t length = strlen(path) + 16;
    older = malloc(length);
    if (older && index > 0) {
        snprintf(older, length, "%.*s.%d.h5", (int)stem, path, index + 1);
    } else {
        free(older);
        older = file_bytes_older(path, 1);
    }
    if (older && access(older, R_OK) == 0) {
        snprintf(scratch, size, "try %s", file_bytes_shown(older));
    } else {
        snprintf(scratch, size, "restore it from a copy or train anew");
    }
    free(older);
    return scratch;
}

static ad_status refuse(ad_error *error, const char *path, const char *problem)
{
    char scratch[256];
    return ad_fail(error, AD_BAD_INPUT, "%s: %s; %s", file_bytes_shown(path), problem,
                   advice(path, scratch, sizeof scratch));
}

/* Judge a file by its first bytes, head [size] followed by a zero byte. */
static ad_status check_head(const char *path, const unsigned char *head, size_t size,
                            size_t file_size, ad_error *error)
{
    const char *text = (const char *)head;
    const char *shown = file_bytes_shown(path);
    unsigned version = 0;
    size_t bytes = 0;
    if (file_size == 0) {
        return refuse(error, path, "is empty, not a cpinn checkpoint");
    }
    if (strncmp(text, CHECKPOINT_MAGIC "\n", sizeof CHECKPOINT_MAGIC) != 0) {
        bool hdf5 = size >= 8 && memcmp(head, "\211HDF\r\n\032\n", 8) == 0;
        return refuse(error, path,
                      hdf5 ? "is an HDF5 file but not a cpinn checkpoint"
                           : "is not a cpinn checkpoint, or its first bytes are damaged");
    }
    if (size < CHECKPOINT_USER_BLOCK) {
        return refuse(error, path, "is truncated inside its first 512 bytes");
    }
    if (sscanf(text + sizeof CHECKPOINT_MAGIC, "format_version %9u", &version) != 1) {
        return refuse(error, path, "is damaged: its first bytes name no format_version");
    }
    if (version != CHECKPOINT_FORMAT_VERSION) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: has format_version %u, of a cpinn %s; this one reads format_version %d",
                       shown, version,
                       version > CHECKPOINT_FORMAT_VERSION ? "later than this"
                                                           : "before " CHECKPOINT_FORMAT_SINCE,
                       CHECKPOINT_FORMAT_VERSION);
    }
    const char *line = strstr(text, "\nbytes ");
    if (line && sscanf(line, "\nbytes %18zu", &bytes) == 1 && file_size < bytes) {
        char problem[96];
        snprintf(problem, sizeof problem, "is truncated: it has %zu of %zu bytes", file_size,
                 bytes);
        return refuse(error, path, problem);
    }
    return AD_OK;
}

/* ---- the items ---- */

/* A file being read. */
typedef struct reader {
    const char *path;
    size_t file_size; /* no item can hold more bytes than this */
    size_t *links;    /* visited so far */
    checkpoint *cp;
    ad_error *error;
} reader;

/* The metadata of a file whose bytes passed their checksum can still be wrong: someone else wrote
 * it. */
static ad_status refuse_item(const reader *from, const char *name, const char *problem)
{
    char text[CHECKPOINT_MAX_NAME + 64];
    snprintf(text, sizeof text, "item '%.120s' %s", name, problem);
    return refuse(from->error, from->path, text);
}

static ad_status no_memory(const reader *from)
{
    return ad_fail(from->error, AD_NO_MEMORY, "%s: out of memory while reading it",
                   file_bytes_shown(from->path));
}

/* Bytes of one fixed-length text of this type, 0 if it is another type or longer than the file. */
static size_t text_width(hid_t type, size_t file_size)
{
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 ||
        H5Tget_size(type) > file_size) {
        return 0;
    }
    return H5Tget_size(type);
}

static bool read_number_attribute(hid_t file, const char *name, hid_t expected, hid_t into,
                                  void *value)
{
    hid_t attribute =
        H5Aexists(file, name) > 0 ? H5Aopen(file, name, H5P_DEFAULT) : H5I_INVALID_HID;
    hid_t type = attribute < 0 ? H5I_INVALID_HID : H5Aget_type(attribute);
    hid_t space = attribute < 0 ? H5I_INVALID_HID : H5Aget_space(attribute);
    bool good = type >= 0 && space >= 0 && H5Tequal(type, expected) > 0 &&
                H5Sget_simple_extent_type(space) == H5S_SCALAR &&
                H5Aread(attribute, into, value) >= 0;
    hdf5_image_close(space);
    hdf5_image_close(type);
    hdf5_image_close(attribute);
    return good;
}

/* Texts of an attribute with `count` of them (0: a scalar) of `*width` bytes each; the caller owns
 * `*texts`. AD_BAD_INPUT: there is no such attribute. No message is written. */
static ad_status read_text_attribute(hid_t object, const char *name, size_t count, size_t file_size,
                                     char **texts, size_t *width)
{
    ad_status status = AD_BAD_INPUT;
    hid_t attribute =
        H5Aexists(object, name) > 0 ? H5Aopen(object, name, H5P_DEFAULT) : H5I_INVALID_HID;
    hid_t type = attribute < 0 ? H5I_INVALID_HID : H5Aget_type(attribute);
    hid_t space = attribute < 0 ? H5I_INVALID_HID : H5Aget_space(attribute);
    size_t total = count == 0 ? 1 : count;
    *texts = NULL;
    *width = type < 0 ? 0 : text_width(type, file_size);
    if (*width > 0 && space >= 0 && total <= file_size / *width &&
        H5Sget_simple_extent_npoints(space) == (hssize_t)total) {
        *texts = calloc(total, *width + 1);
        status = *texts ? AD_OK : AD_NO_MEMORY;
    }
    if (status == AD_OK && H5Aread(attribute, type, *texts) < 0) {
        free(*texts);
        *texts = NULL;
        status = AD_BAD_INPUT;
    }
    hdf5_image_close(space);
    hdf5_image_close(type);
    hdf5_image_close(attribute);
    return status;
}

/* Column names of a table: one block of pointers and the texts behind them. */
static ad_status read_columns(const reader *from, hid_t dataset, const char *name,
                              checkpoint_item *item)
{
    size_t width = 0, columns = item->shape[1];
    if (item->kind != CHECKPOINT_DOUBLE || item->rank != 2 || columns == 0 ||
        columns > CHECKPOINT_MAX_ITEMS) {
        return refuse_item(from, name, "has column names but is no table");
    }
    char *texts;
    ad_status status =
        read_text_attribute(dataset, "columns", columns, from->file_size, &texts, &width);
    if (status != AD_OK) {
        return status == AD_NO_MEMORY
                   ? no_memory(from)
                   : refuse_item(from, name, "has column names that cannot be read");
    }
    char **names = malloc(columns * (sizeof *names + width + 1));
    if (!names) {
        free(texts);
        return no_memory(from);
    }
    char *copy = (char *)(names + columns);
    for (size_t k = 0; k < columns; k++) {
        names[k] = copy + k * (width + 1);
        memcpy(names[k], texts + k * width, width);
        names[k][width] = 0;
    }
    free(texts);
    item->columns = columns;
    item->column_names = (const char *const *)names;
    item->owned_names = names;
    return AD_OK;
}

/* Fill kind, rank, shape and count from the type and shape of a dataset; *width is the size of a
 * text. Nothing is allocated before the size is known to fit the file. */
static ad_status read_shape(const reader *from, const char *name, hid_t type, hid_t space,
                            checkpoint_item *item, size_t *width)
{
    hsize_t shape[CHECKPOINT_MAX_RANK] = {1, 1, 1};
    int rank = H5Sget_simple_extent_ndims(space);
    H5S_class_t extent = H5Sget_simple_extent_type(space);
    *width = text_width(type, from->file_size);
    if (H5Tequal(type, H5T_IEEE_F64LE) > 0) {
        item->kind = CHECKPOINT_DOUBLE;
    } else if (H5Tequal(type, H5T_STD_I64LE) > 0) {
        item->kind = CHECKPOINT_INT64;
    } else if (H5Tequal(type, H5T_STD_U64LE) > 0) {
        item->kind = CHECKPOINT_UINT64;
    } else if (*width > 0 && rank == 0) {
        item->kind = CHECKPOINT_TEXT;
    } else {
        return refuse_item(from, name, "is neither float64, int64, uint64 nor text");
    }
    if (rank < 0 || rank > CHECKPOINT_MAX_RANK || (extent != H5S_SCALAR && extent != H5S_SIMPLE) ||
        H5Sget_simple_extent_dims(space, shape, NULL) < 0) {
        return refuse_item(from, name, "has a rank above 3");
    }
    item->rank = rank;
    item->count = 1;
    for (int axis = 0; axis < CHECKPOINT_MAX_RANK; axis++) {
        if (shape[axis] > 0 && item->count > from->file_size / 8 / shape[axis]) {
            return refuse_item(from, name, "has a shape larger than the file");
        }
        item->shape[axis] = (size_t)shape[axis];
        item->count *= (size_t)shape[axis];
    }
    return AD_OK;
}

static ad_status read_data(const reader *from, hid_t dataset, hid_t type, const char *name,
                           size_t width, checkpoint_item *item)
{
    bool is_text = item->kind == CHECKPOINT_TEXT;
    hid_t into = is_text ? type : checkpoint_memory_type(item->kind);
    item->owned_data = is_text ? calloc(width + 1, 1) : malloc(item->count * 8 + 1);
    if (!item->owned_data) {
        return no_memory(from);
    }
    if ((is_text || item->count > 0) &&
        H5Dread(dataset, into, H5S_ALL, H5S_ALL, H5P_DEFAULT, item->owned_data) < 0) {
        return refuse_item(from, name, "cannot be read");
    }
    item->data = item->owned_data;
    if (is_text) {
        item->rank = 1;
        item->count = strlen(item->data);
        item->shape[0] = item->count;
    }
    return AD_OK;
}

static ad_status read_item(const reader *from, hid_t dataset, const char *name)
{
    checkpoint_item item = {.kind = CHECKPOINT_DOUBLE};
    size_t width = 0;
    hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    ad_status status = type < 0 || space < 0 ? refuse_item(from, name, "cannot be read")
                                             : read_shape(from, name, type, space, &item, &width);
    size_t bytes = item.kind == CHECKPOINT_TEXT ? width : sizeof(double);
    const char *problem =
        status == AD_OK && item.count > 0
            ? hdf5_image_storage_problem(dataset, item.count, bytes, from->file_size)
            : NULL;
    if (problem) {
        status = refuse_item(from, name, problem);
    }
    if (status == AD_OK) {
        status = read_data(from, dataset, type, name, width, &item);
    }
    if (status == AD_OK && H5Aexists(dataset, "columns") > 0) {
        status = read_columns(from, dataset, name, &item);
    }
    if (status == AD_OK) {
        status = checkpoint_add(from->cp, name, &item, from->error);
    }
    if (status != AD_OK) {
        free(item.owned_data);
        free(item.owned_names);
    }
    hdf5_image_close(space);
    hdf5_image_close(type);
    return status;
}

static ad_status read_group(const reader *from, hid_t group, const char *prefix);

/* The link number `index` of a group: an item or a group of items. */
static ad_status read_link(const reader *from, hid_t group, const char *prefix, hsize_t index)
{
    char link[CHECKPOINT_MAX_NAME + 1], name[2 * CHECKPOINT_MAX_NAME + 2];
    if (!hdf5_image_link_name(group, index, false, link, sizeof link)) {
        return refuse_item(from, prefix, "holds something that is not an item");
    }
    if (++*from->links > CHECKPOINT_MAX_LINKS) {
        return refuse_item(from, prefix, "is one of too many groups");
    }
    snprintf(name, sizeof name, "%s%s%s", prefix, *prefix ? "/" : "", link);
    if (strlen(name) > CHECKPOINT_MAX_NAME) {
        return refuse_item(from, name, "has a name that is too long");
    }
    hid_t object = H5Oopen(group, link, H5P_DEFAULT);
    ad_status status;
    switch (object < 0 ? H5I_BADID : H5Iget_type(object)) {
    case H5I_GROUP:
        status = read_group(from, object, name); /* ends, because names have a longest length */
        break;
    case H5I_DATASET:
        status = read_item(from, object, name);
        break;
    default:
        status = refuse_item(from, name, "is neither a dataset nor a group");
        break;
    }
    hdf5_image_close(object);
    return status;
}

static ad_status read_group(const reader *from, hid_t group, const char *prefix)
{
    H5G_info_t info;
    if (H5Gget_info(group, &info) < 0 || info.nlinks > CHECKPOINT_MAX_LINKS) {
        return refuse_item(from, prefix, "cannot be read, or is a group of too many items");
    }
    ad_status status = AD_OK;
    for (hsize_t k = 0; status == AD_OK && k < info.nlinks; k++) {
        status = read_link(from, group, prefix, k);
    }
    return status;
}

/* ---- the file ---- */

static ad_status read_root_attributes(const reader *from, hid_t file, uint64_t *digest)
{
    int64_t version = 0;
    size_t width = 0;
    char *format = NULL;
    ad_status status = read_text_attribute(file, "format", 0, from->file_size, &format, &width);
    if (status == AD_OK) {
        bool good =
            strcmp(format, CHECKPOINT_MAGIC) == 0 &&
            read_number_attribute(file, "format_version", H5T_STD_I64LE, H5T_NATIVE_INT64,
                                  &version) &&
            version == CHECKPOINT_FORMAT_VERSION &&
            read_number_attribute(file, "checksum", H5T_STD_U64LE, H5T_NATIVE_UINT64, digest);
        status = good ? read_text_attribute(file, "library_version", 0, from->file_size,
                                            &from->cp->library_version, &width)
                      : AD_BAD_INPUT;
    }
    free(format);
    if (status == AD_NO_MEMORY) {
        return no_memory(from);
    }
    return status == AD_OK ? AD_OK
                           : refuse(from->error, from->path,
                                    "is damaged: its root attributes are missing or wrong");
}

/* Root attributes, then all items, then their checksum. */
static ad_status read_contents(const reader *from, hid_t file)
{
    uint64_t digest = 0;
    ad_status status = read_root_attributes(from, file, &digest);
    if (status == AD_OK) {
        status = read_group(from, file, "");
    }
    if (status != AD_OK) {
        return status;
    }
    checkpoint_sort(from->cp);
    if (checkpoint_digest(from->cp) != digest) {
        return refuse(from->error, from->path, "is damaged: its items do not match their checksum");
    }
    return AD_OK;
}

static ad_status read_image(hid_t file, void *context)
{
    const reader *from = context;
    return file < 0 ? refuse(from->error, from->path, "cannot be opened by HDF5: damaged")
                    : read_contents(from, file);
}

/* Read the file's bytes and check all of them before HDF5 sees any. The first bytes are judged
 * before room for the whole file is allocated. */
static ad_status read_checked(const char *path, unsigned char **bytes, size_t *size,
                              ad_error *error)
{
    unsigned char *head = NULL;
    unsigned char block[CHECKPOINT_USER_BLOCK];
    size_t head_size = 0, file_size = 0;
    ad_status status =
        file_bytes_read(path, CHECKPOINT_USER_BLOCK, &head, &head_size, &file_size, error);
    if (status == AD_OK) {
        status = check_head(path, head, head_size, file_size, error);
    }
    free(head);
    if (status == AD_OK) {
        status = file_bytes_read(path, 0, bytes, size, &file_size, error);
    }
    if (status != AD_OK) {
        return status;
    }
    /* Once more: between the two reads a new checkpoint may have taken the name. */
    status = check_head(path, *bytes, *size, file_size, error);
    if (status == AD_OK) {
        checkpoint_user_block(block, *size,
                              checkpoint_hash(CHECKPOINT_HASH_START, *bytes + CHECKPOINT_USER_BLOCK,
                                              *size - CHECKPOINT_USER_BLOCK));
        if (memcmp(block, *bytes, CHECKPOINT_USER_BLOCK) != 0) {
            status = refuse(error, path, "is damaged: its bytes do not match their checksum");
        }
    }
    if (status != AD_OK) {
        free(*bytes);
    }
    return status;
}

ad_status checkpoint_open(const char *path, checkpoint **cp, ad_error *error)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    *cp = NULL;
    ad_status status = read_checked(path, &bytes, &size, error);
    if (status != AD_OK) {
        return status;
    }
    size_t links = 0;
    reader from = {path, size, &links, calloc(1, sizeof *from.cp), error};
    if (from.cp) {
        from.cp->path = checkpoint_copy(path);
    }
    status =
        from.cp && from.cp->path ? hdf5_image_read(bytes, size, read_image, &from) : AD_NO_MEMORY;
    status = status == AD_NO_MEMORY ? no_memory(&from) : status;
    free(bytes);
    if (status != AD_OK) {
        checkpoint_free(from.cp);
        return status;
    }
    *cp = from.cp;
    return AD_OK;
}
