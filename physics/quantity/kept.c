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
    quantity_kept *kept = quantities_kept(names);
    char *bytes = malloc(key_size + size);
    if (!bytes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what formulas say");
    }
    memcpy(bytes, key, key_size);
    memcpy(bytes + key_size, found, size);
    pthread_mutex_lock(&kept->lock);
    quantity_finding *oldest = &kept->findings[kept->count++ % QUANTITY_KEPT_MAX];
    free(oldest->bytes);
    *oldest = (quantity_finding){key_size, size, bytes};
    pthread_mutex_unlock(&kept->lock);
    return AD_OK;
}

ad_status quantities_recall(quantities *names, size_t key_size, const void *key, size_t *size,
                            void **found, ad_error *error)
{
    quantity_kept *kept = quantities_kept(names);
    ad_status status = AD_OK;
    *found = NULL;
    pthread_mutex_lock(&kept->lock);
    for (int i = 0; i < QUANTITY_KEPT_MAX && !*found && status == AD_OK; i++) {
        const quantity_finding *one = &kept->findings[i];
        if (one->bytes && one->key_size == key_size && memcmp(one->bytes, key, key_size) == 0) {
            *size = one->size;
            *found = malloc(one->size);
            if (*found) {
                memcpy(*found, one->bytes + key_size, one->size);
            } else {
                status = ad_fail(error, AD_NO_MEMORY, "out of memory for what formulas say");
            }
        }
    }
    pthread_mutex_unlock(&kept->lock);
    return status;
}

bool quantity_kept_start(quantity_kept *kept)
{
    return pthread_mutex_init(&kept->lock, NULL) == 0;
}

void quantity_kept_end(quantity_kept *kept)
{
    for (int i = 0; i < QUANTITY_KEPT_MAX; i++) {
        free(kept->findings[i].bytes);
    }
    pthread_mutex_destroy(&kept->lock);
}
