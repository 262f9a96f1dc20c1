#include "autodiff/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { LINE = 64 }; /* of the cache: no vector of numbers lies across two of them */

typedef struct ad_memory_piece {
    struct ad_memory_piece *before;
} ad_memory_piece;

void *ad_memory_take(ad_memory *memory, size_t count, size_t size)
{
    void *piece = NULL;
    const bool fits = size == 0 || count <= (PTRDIFF_MAX - LINE) / size;
    if (!fits || memory->is_short || posix_memalign(&piece, LINE, LINE + count * size) != 0) {
        memory->is_short = true;
        return NULL;
    }
    *(ad_memory_piece *)piece = (ad_memory_piece){memory->last};
    memory->last = piece;
    return memset((unsigned char *)piece + LINE, 0, count * size);
}

ad_status ad_memory_status(const ad_memory *memory, ad_error *error, const char *format, ...)
{
    if (!memory->is_short) {
        return AD_OK;
    }
    va_list arguments;
    va_start(arguments, format);
    ad_fail_list(error, AD_NO_MEMORY, format, arguments);
    va_end(arguments);
    return AD_NO_MEMORY;
}

void ad_memory_free(ad_memory *memory)
{
    while (memory->last) {
        ad_memory_piece *piece = memory->last;
        memory->last = piece->before;
        free(piece);
    }
    memory->is_short = false;
}
