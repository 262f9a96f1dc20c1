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

bool hdf5_image_silence(hdf5_printer *printer, size_t size)
{
    printer->no_memory = !can_start(size) || H5open() < 0;
    return !printer->no_memory &&
           H5Eget_auto2(H5E_DEFAULT, &printer->function, &printer->data) >= 0 &&
           H5Eset_auto2(H5E_DEFAULT, note, printer) >= 0;
}

void hdf5_image_restore(const hdf5_printer *printer)
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

hid_t hdf5_image_creation(hid_t property_class)
{
    hid_t list = H5Pcreate(property_class);
    if (list >= 0 && (H5Pset_obj_track_times(list, 0) < 0 ||
                      H5Pset_attr_creation_order(list, H5P_CRT_ORDER_TRACKED) < 0)) {
        hdf5_image_close(list);
        return H5I_INVALID_HID;
    }
    return list;
}

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

hid_t hdf5_image_create(size_t user_block)
{
    hid_t file = H5I_INVALID_HID;
    hid_t access = memory_access();
    hid_t creation = hdf5_image_creation(H5P_FILE_CREATE);
    /* Order of creation is tracked so that the columns of a table come back in their order. */
    if (access >= 0 && creation >= 0 && H5Pset_userblock(creation, user_block) >= 0 &&
        H5Pset_link_creation_order(creation, H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED) >= 0) {
        file = H5Fcreate("cpinn image being written", H5F_ACC_TRUNC, creation, access);
    }
    hdf5_image_close(creation);
    hdf5_image_close(access);
    return file;
}

ad_status hdf5_image_bytes(hid_t file, size_t user_block, unsigned char **bytes, size_t *size)
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

hid_t hdf5_image_open(const unsigned char *bytes, size_t size)
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
