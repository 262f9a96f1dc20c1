#include "tools/programs/picture_file.h"

#include "tools/files/file_bytes.h"
#include "tools/picture/images.h"

#include <stdlib.h>
#include <string.h>

static bool ends(const char *path, const char *ending)
{
    const size_t length = strlen(path), size = strlen(ending);
    return length > size && strcmp(path + length - size, ending) == 0;
}

ad_status picture_file_check(const char *path, ad_error *error)
{
    return ends(path, ".svg") || ends(path, ".png")
               ? file_bytes_check(path, error)
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "%.200s: ends in no form of a picture; allowed: "
                         ".svg, .png",
                         path);
}

static ad_status write_png(const picture *p, const char *path, ad_error *error)
{
    const int width = picture_width(p), height = picture_height(p);
    unsigned char *rgb = malloc(3 * (size_t)width * (size_t)height), *bytes = NULL;
    size_t size = 0;
    ad_status status = rgb ? picture_pixels(p, 3, rgb, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    status = status == AD_OK ? image_png(width, height, rgb, &bytes, &size, error) : status;
    status = status == AD_OK ? file_bytes_write(path, bytes, size, error) : status;
    free(rgb);
    free(bytes);
    return status;
}

static ad_status write_svg(const picture *p, const char *path, ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    ad_status status = picture_svg(p, &text, &size, error);
    status = status == AD_OK ? file_bytes_write(path, text, size, error) : status;
    free(text);
    return status;
}

ad_status picture_file_write(const picture *p, const char *path, ad_error *error)
{
    return ends(path, ".svg") ? write_svg(p, path, error) : write_png(p, path, error);
}
