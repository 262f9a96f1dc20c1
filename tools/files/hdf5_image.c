#include "tools/files/hdf5_image.h"

#include "tools/files/checkpoint.h"

#include <stdlib.h>
#include <string.h>

/* Memory behind a growing image is extended by this many bytes at a time. */
#define IMAGE_INCREMENT (1u << 20)

/* Bytes that HDF5 has for itself and for the metadata of a file. */
#define STARTING ((size_t)4 << 20)

/* Compression by deflate shrinks at most 1032:1 (zlib's documentation), so a dataset that claims
 * more for what it stores is damaged or mostly absent. */
#define MAX_COMPRESSION 1032

/* The error printer that was installed before `silence`, and what has been heard since. */
typedef struct hdf5_printer {
    H5E_auto2_t function;
    void *data;
    bool no_memory; /* an error since was one of memory */
} hdf5_printer;

static herr_t look_at(unsigned number, const H5E_error2_t *error, void *no_memory)
{
    (void)number;
    *(bool *)no_memory |= error->min_num == H5E_NOSPACE || error->min_num == H5E_CANTALLOC;
    return 0;
}

/* In place of what prints the errors. */
static herr_t note(hid_t stack, void *printer)
{
    return H5Ewalk2(stack, H5E_WALK_UPWARD, look_at, &((hdf5_printer *)printer)->no_memory);
}

/* `size` bytes of data are in HDF5's image and in a copy of it. */
static bool can_start(size_t size)
{
    void *volatile tried = size < SIZE_MAX / 4 ? malloc(2 * size + STARTING) : NULL;
    const bool fits = tried != NULL;
    free(tried);
    return fits;
}

void checkpoint_at_exit(void)
{
    if (can_start(0)) {
        H5dont_atexit();
    }
}

/* Stop HDF5 printing its error stack. False: no memory for HDF5 and `size` bytes of data, and it is
 * not touched: where memory ends within it, it recurses, crashes or ends the process. `printer`
 * must stay where it is. */
static bool silence(hdf5_printer *printer, size_t size)
{
    printer->no_memory = !can_start(size) || H5open() < 0;
    return !printer->no_memory &&
           H5Eget_auto2(H5E_DEFAULT, &printer->function, &printer->data) >= 0 &&
           H5Eset_auto2(H5E_DEFAULT, note, printer) >= 0;
}

static void restore(const hdf5_printer *printer)
{
    H5Eclear2(H5E_DEFAULT);
    H5Eset_auto2(H5E_DEFAULT, printer->function, printer->data);
}

void hdf5_image_close(hid_t identifier)
{
    if (identifier >= 0) {
        H5Idec_ref(identifier);
    }
}

hid_t hdf5_image_text_type(size_t size)
{
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 && (H5Tset_size(type, size) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0 ||
                      H5Tset_strpad(type, H5T_STR_NULLTERM) < 0)) {
        hdf5_image_close(type);
        return H5I_INVALID_HID;
    }
    return type;
}

/* Property list for creating a file, group or dataset without time stamps. Tracking the order of
 * attributes makes HDF5 choose the object headers that have checksums of their own and can hold
 * attributes above 64 KiB. */
static hid_t creation_of(hid_t property_class)
{
    hid_t list = H5Pcreate(property_class);
    if (list >= 0 && (H5Pset_obj_track_times(list, 0) < 0 ||
                      H5Pset_attr_creation_order(list, H5P_CRT_ORDER_TRACKED) < 0)) {
        hdf5_image_close(list);
        return H5I_INVALID_HID;
    }
    return list;
}

/* ---- what a file consists of --------------------------------------------------------------- */

static hid_t space_of(int rank, const hsize_t *shape)
{
    return rank > 0 ? H5Screate_simple(rank, shape, NULL) : H5Screate(H5S_SCALAR);
}

hid_t hdf5_image_group(hid_t parent, const char *name)
{
    hid_t creation = creation_of(H5P_GROUP_CREATE);
    hid_t group = creation < 0 ? H5I_INVALID_HID
                               : H5Gcreate2(parent, name, H5P_DEFAULT, creation, H5P_DEFAULT);
    hdf5_image_close(creation);
    return group;
}

hid_t hdf5_image_dataset(hid_t parent, const char *name, hid_t stored, hid_t given, int rank,
                         const hsize_t *shape, const void *values)
{
    hid_t creation = creation_of(H5P_DATASET_CREATE), space = space_of(rank, shape);
    hid_t dataset =
        creation < 0 ? H5I_INVALID_HID
                     : H5Dcreate2(parent, name, stored, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    bool is_empty = false;
    for (int k = 0; k < rank; k++) {
        is_empty = is_empty || shape[k] == 0;
    }
    if (dataset >= 0 && !is_empty &&
        H5Dwrite(dataset, given, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
        hdf5_image_close(dataset);
        dataset = H5I_INVALID_HID;
    }
    hdf5_image_close(space);
    hdf5_image_close(creation);
    return dataset;
}

bool hdf5_image_attribute(hid_t object, const char *name, hid_t stored, hid_t given, size_t count,
                          const void *values)
{
    hid_t space = space_of(count > 0, (const hsize_t[]){count});
    hid_t attribute = space < 0 ? H5I_INVALID_HID
                                : H5Acreate2(object, name, stored, space, H5P_DEFAULT, H5P_DEFAULT);
    bool written = attribute >= 0 && H5Awrite(attribute, given, values) >= 0;
    hdf5_image_close(attribute);
    hdf5_image_close(space);
    return written;
}

bool hdf5_image_text(hid_t object, const char *name, const char *text)
{
    hid_t type = hdf5_image_text_type(strlen(text) + 1);
    bool written = type >= 0 && hdf5_image_attribute(object, name, type, type, 0, text);
    hdf5_image_close(type);
    return written;
}

char *hdf5_image_words(const char *const *words, size_t count, size_t *size)
{
    *size = 1;
    for (size_t k = 0; k < count; k++) {
        *size = strlen(words[k]) >= *size ? strlen(words[k]) + 1 : *size;
    }
    char *values = calloc(count > 0 ? count : 1, *size);
    for (size_t k = 0; values && k < count; k++) {
        strcpy(values + k * *size, words[k]);
    }
    return values;
}

/* ---- files in memory ----------------------------------------------------------------------- */

/* Access properties of a file in memory that has no file behind it. The oldest superblock is asked
 * for, because H5Fget_file_image of HDF5 1.10 clears a flag in newer ones without renewing their
 * checksum, and the image could then not be opened. */
static hid_t memory_access(void)
{
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (access >= 0 && (H5Pset_fapl_core(access, IMAGE_INCREMENT, 0) < 0 ||
                        H5Pset_fclose_degree(access, H5F_CLOSE_STRONG) < 0 ||
                        H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V110) < 0)) {
        hdf5_image_close(access);
        return H5I_INVALID_HID;
    }
    return access;
}

static hid_t create(size_t user_block)
{
    hid_t file = H5I_INVALID_HID;
    hid_t access = memory_access();
    hid_t creation = creation_of(H5P_FILE_CREATE);
    /* Order of creation is tracked so that the columns of a table come back in their order. */
    if (access >= 0 && creation >= 0 && H5Pset_userblock(creation, user_block) >= 0 &&
        H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED) >= 0) {
        file = H5Fcreate("cpinn image being written", H5F_ACC_TRUNC, creation, access);
    }
    hdf5_image_close(creation);
    hdf5_image_close(access);
    return file;
}

static ad_status bytes_of(hid_t file, size_t user_block, unsigned char **bytes, size_t *size)
{
    if (H5Fflush(file, H5F_SCOPE_GLOBAL) < 0) { /* in memory nothing else is left to go wrong */
        return AD_NO_MEMORY;
    }
    /* HDF5 counts the image from behind the user block. */
    ssize_t length = H5Fget_file_image(file, NULL, 0);
    if (length <= 0) {
        return AD_NO_MEMORY;
    }
    unsigned char *image = malloc(user_block + (size_t)length);
    if (!image) {
        return AD_NO_MEMORY;
    }
    if (H5Fget_file_image(file, image + user_block, (size_t)length) != length) {
        free(image);
        return AD_NO_MEMORY;
    }
    memset(image, 0, user_block);
    *bytes = image;
    *size = user_block + (size_t)length;
    return AD_OK;
}

ad_status hdf5_image_write(size_t user_block, size_t data,
                           bool (*write)(hid_t file, const void *context), const void *context,
                           unsigned char **bytes, size_t *size)
{
    hdf5_printer printer;
    if (!silence(&printer, data)) {
        return AD_NO_MEMORY;
    }
    hid_t file = create(user_block);
    ad_status status =
        file >= 0 && write(file, context) ? bytes_of(file, user_block, bytes, size) : AD_NO_MEMORY;
    hdf5_image_close(file);
    restore(&printer);
    return status;
}

/* Where the superblock is: at 0, or behind a user block of 512, 1024, ... bytes; `size`: nowhere.
 */
static size_t superblock_place(const unsigned char *bytes, size_t size)
{
    static const unsigned char signature[] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    size_t place = 0;
    while (place < size && size - place >= sizeof signature) {
        if (memcmp(bytes + place, signature, sizeof signature) == 0) {
            return place;
        }
        place = place ? 2 * place : 512;
    }
    return size;
}

/* Whether the superblock (versions 0 and 1) has the address of a driver's information, which files
 * of several parts have. HDF5 takes as much memory as that block says, up to 4 GB. */
static bool has_driver_block(const unsigned char *bytes, size_t size)
{
    enum { VERSION = 8, WIDTH_OF_ADDRESSES = 13, ADDRESSES = 24, DRIVER = 3 };
    const size_t place = superblock_place(bytes, size), rest = size - place;
    if (rest <= ADDRESSES || bytes[place + VERSION] > 1) {
        return false;
    }
    const unsigned char *block = bytes + place;
    const size_t width = block[WIDTH_OF_ADDRESSES];
    const size_t first = ADDRESSES + (block[VERSION] == 1 ? 4 : 0) + DRIVER * width;
    for (size_t k = first; k < first + width && k < rest; k++) {
        if (block[k] != 0xff) {
            return true;
        }
    }
    return false;
}

static hid_t open_image(const unsigned char *bytes, size_t size)
{
    hid_t file = H5I_INVALID_HID;
    hid_t access = memory_access();
    /* HDF5 copies the bytes and, opened read-only, does not change them. */
    if (access >= 0 && !has_driver_block(bytes, size) &&
        H5Pset_file_image(access, (void *)bytes, size) >= 0) {
        file = H5Fopen("cpinn image being read", H5F_ACC_RDONLY, access);
    }
    hdf5_image_close(access);
    return file;
}

ad_status hdf5_image_read(const unsigned char *bytes, size_t size,
                          ad_status (*read)(hid_t file, void *context), void *context)
{
    hdf5_printer printer;
    if (!silence(&printer, size)) {
        return AD_NO_MEMORY;
    }
    hid_t file = open_image(bytes, size);
    ad_status status = read(file, context);
    hdf5_image_close(file);
    restore(&printer);
    return status == AD_BAD_INPUT && printer.no_memory ? AD_NO_MEMORY : status;
}

bool hdf5_image_link_name(hid_t group, hsize_t index, bool by_creation, char *name, size_t size)
{
    H5_index_t order = by_creation ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
    H5O_info_t info; /* of a hard link's object; a soft one may have none */
    H5L_info_t link;
    ssize_t length =
        H5Lget_name_by_idx(group, ".", order, H5_ITER_INC, index, name, size, H5P_DEFAULT);
    return length > 0 && (size_t)length < size &&
           H5Lget_info(group, name, &link, H5P_DEFAULT) >= 0 && link.type == H5L_TYPE_HARD &&
           H5Oget_info_by_name(group, name, &info, H5P_DEFAULT) >= 0 && info.rc == 1;
}

static bool filters_are_known(hid_t creation)
{
    int count = H5Pget_nfilters(creation);
    for (int k = 0; k < count; k++) {
        unsigned flags;
        size_t values = 0;
        H5Z_filter_t filter =
            H5Pget_filter2(creation, (unsigned)k, &flags, &values, NULL, 0, NULL, NULL);
        if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE &&
            filter != H5Z_FILTER_FLETCHER32) {
            return false;
        }
    }
    return count >= 0;
}

const char *hdf5_image_storage_problem(hid_t dataset, hsize_t count, size_t width,
                                       size_t image_size)
{
    const char *problem = NULL;
    hid_t creation = H5Dget_create_plist(dataset);
    H5D_layout_t layout = creation < 0 ? H5D_LAYOUT_ERROR : H5Pget_layout(creation);
    hsize_t stored = layout == H5D_CHUNKED ? H5Dget_storage_size(dataset) : image_size;
    hsize_t chunk[H5S_MAX_RANK], held = 1;
    int rank = layout == H5D_CHUNKED ? H5Pget_chunk(creation, H5S_MAX_RANK, chunk) : 0;
    for (int axis = 0; axis < rank; axis++) {
        held *= chunk[axis]; /* HDF5 reads whole chunks, which have less than 2^32 bytes */
    }
    hsize_t ratio = layout == H5D_CHUNKED ? MAX_COMPRESSION : 1;
    if (layout == H5D_LAYOUT_ERROR || layout == H5D_VIRTUAL || rank < 0 ||
        H5Pget_external_count(creation) != 0) {
        problem = "has its values in another file or is damaged";
    } else if (!filters_are_known(creation)) {
        problem = "is stored with a filter other than gzip, shuffle and fletcher32";
    } else if (stored > image_size || (count > held ? count : held) / ratio > stored / width) {
        problem = "has more rows than the file can hold";
    }
    hdf5_image_close(creation);
    return problem;
}
