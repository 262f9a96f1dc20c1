#include "tools/picture/images.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

static void put_number(unsigned char *to, uint32_t value)
{
    for (int k = 0; k < 4; k++) {
        to[k] = (unsigned char)(value >> (24 - 8 * k));
    }
}

/* Length, name, data and checksum; how many bytes. */
static size_t put_chunk(unsigned char *to, const char name[4], const void *data, size_t size)
{
    put_number(to, (uint32_t)size);
    memcpy(to + 4, name, 4);
    if (size > 0) {
        memmove(to + 8, data, size);
    }
    put_number(to + 8 + size, (uint32_t)crc32(0, to + 4, (uInt)(4 + size)));
    return 12 + size;
}

static int predicted(int a, int b, int c) /* of PNG's filter 4, after Paeth */
{
    const int pa = abs(b - c), pb = abs(a - c), pc = abs(a + b - 2 * c);
    return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/* A row by the filter, 0 to 4, in which it differs least. */
static void filter_row(unsigned char *to, const unsigned char *row, const unsigned char *above,
                       size_t bytes, unsigned char *trial)
{
    unsigned long least = 0;
    for (int filter = 0; filter < 5; filter++) {
        unsigned long sum = 0;
        for (size_t i = 0; i < bytes; i++) {
            const int a = i >= 3 ? row[i - 3] : 0, b = above ? above[i] : 0;
            const int c = i >= 3 && above ? above[i - 3] : 0;
            const int guess[] = {0, a, b, (a + b) / 2, predicted(a, b, c)};
            trial[i] = (unsigned char)(row[i] - guess[filter]);
            sum += (unsigned long)(trial[i] < 128 ? trial[i] : 256 - trial[i]);
        }
        if (filter == 0 || sum < least) {
            least = sum;
            to[0] = (unsigned char)filter;
            memcpy(to + 1, trial, bytes);
        }
    }
}

ad_status image_png(int width, int height, const unsigned char *rgb, unsigned char **bytes,
                    size_t *size, ad_error *error)
{
    static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
    const size_t row = 3 * (size_t)width, plain = (row + 1) * (size_t)height;
    uLongf packed = compressBound((uLong)plain);
    unsigned char head[13] = {[8] = 8, 2}; /* bits, colours */
    unsigned char *filtered = malloc(plain + row);
    *bytes = malloc(packed + 64);
    for (int y = 0; filtered && y < height; y++) {
        filter_row(filtered + (size_t)y * (row + 1), rgb + (size_t)y * row,
                   y > 0 ? rgb + (size_t)(y - 1) * row : NULL, row, filtered + plain);
    }
    if (!filtered || !*bytes || compress2(*bytes + 41, &packed, filtered, plain, 9) != Z_OK) {
        free(filtered);
        free(*bytes);
        *bytes = NULL;
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    free(filtered);
    put_number(head, (uint32_t)width);
    put_number(head + 4, (uint32_t)height);
    memcpy(*bytes, signature, 8);
    *size = 8;
    *size += put_chunk(*bytes + *size, "IHDR", head, sizeof head);
    *size += put_chunk(*bytes + *size, "IDAT", *bytes + 41, packed);
    *size += put_chunk(*bytes + *size, "IEND", NULL, 0);
    return AD_OK;
}
