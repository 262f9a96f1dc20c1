#include "physics/quantity/kept.h"

#include "physics/quantity/quantity_internal.h"

#include <stdlib.h>
#include <string.h>

quantities *quantity_names(quantity q)
{
    return q.node ? q.node->owner : NULL;
}

ad_status quantities_keep(quantities *names, size_t key_size, const void *key, size_t size,
                          const void *found, ad_error *error)
{
    char *bytes = malloc(key_size + size);
    if (!bytes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what formulas say");
    }
    memcpy(bytes, key, key_size);
    memcpy(bytes + key_size, found, size);
    quantity_kept *kept = quantities_lock_kept(names);
    quantity_finding *oldest = &kept->findings[kept->count++ % QUANTITY_KEPT_MAX];
    free(oldest->bytes);
    *oldest = (quantity_finding){key_size, size, bytes};
    quantities_unlock_kept(names);
    return AD_OK;
}

/* A copy of it. */
static ad_status hand_out(const quantity_finding *one, size_t *size, void **found, ad_error *error)
{
    *found = malloc(one->size);
    if (!*found) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what formulas say");
    }
    memcpy(*found, one->bytes + one->key_size, one->size);
    *size = one->size;
    return AD_OK;
}

ad_status quantities_recall(quantities *names, size_t key_size, const void *key, size_t *size,
                            void **found, ad_error *error)
{
    const quantity_finding *one = NULL;
    *found = NULL;
    const quantity_kept *kept = quantities_lock_kept(names);
    for (int i = 0; i < QUANTITY_KEPT_MAX && !one; i++) {
        const quantity_finding *at = &kept->findings[i];
        bool same = at->bytes && at->key_size == key_size && memcmp(at->bytes, key, key_size) == 0;
        one = same ? at : NULL;
    }
    ad_status status = one ? hand_out(one, size, found, error) : AD_OK;
    quantities_unlock_kept(names);
    return status;
}
