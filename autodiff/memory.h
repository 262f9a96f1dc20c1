/* Memory that an object or a function takes piece by piece and gives back in one call: what it has
 * is named once, where it is taken, and nowhere else. */
#ifndef AD_MEMORY_H
#define AD_MEMORY_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct ad_memory {
    struct ad_memory_piece *last;
    bool is_short; /* a piece could not be had */
} ad_memory;       /* nothing: {0} */

/* `count` times `size` bytes of zeros, for numbers of any type; also of 0 there is a place. NULL:
 * there is no memory, and from then on there are no more pieces. */
void *ad_memory_take(ad_memory *memory, size_t count, size_t size);

/* `pointer` gets `count` of what it points to; and a member of an object, of the object's own. */
#define AD_TAKE_OF(memory, pointer, count)                                                         \
    ((pointer) = ad_memory_take(memory, (size_t)(count), sizeof *(pointer)))
#define AD_TAKE(object, member, count) AD_TAKE_OF(&(object)->memory, (object)->member, count)

/* AD_OK, or AD_NO_MEMORY and this message where a piece could not be had. */
ad_status ad_memory_status(const ad_memory *memory, ad_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Gives back all pieces; the memory can be used again. */
void ad_memory_free(ad_memory *memory);

#endif
