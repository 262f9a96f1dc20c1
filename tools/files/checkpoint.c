/* The items of a checkpoint in memory; the file is checkpoint_read.c and checkpoint_write.c. */
#include "tools/files/checkpoint.h"

#include <stdlib.h>
#include <string.h>

#include "tools/files/checkpoint_parts.h"
#include "tools/files/file_bytes.h"

static const char *const kind_word[] = {
#define KIND_WORD(name, letter, word) [name] = word,
    CHECKPOINT_KINDS(KIND_WORD)
#undef KIND_WORD
};

static const unsigned char kind_letter[] = {
#define KIND_LETTER(name, letter, word) [name] = letter,
    CHECKPOINT_KINDS(KIND_LETTER)
#undef KIND_LETTER
};

char *checkpoint_copy(const char *text)
{
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, text, size) : NULL;
}

checkpoint *checkpoint_create(const char *library_version)
{
    checkpoint *cp = calloc(1, sizeof *cp);
    if (cp) {
        cp->library_version = checkpoint_copy(library_version);
    }
    if (cp && !cp->library_version) {
        checkpoint_free(cp);
        return NULL;
    }
    return cp;
}

void checkpoint_free(checkpoint *cp)
{
    if (!cp) {
        return;
    }
    for (size_t k = 0; k < cp->count; k++) {
        free(cp->items[k].name);
        free(cp->items[k].owned_data);
        free(cp->items[k].owned_names);
    }
    free(cp->items);
    free(cp->library_version);
    free(cp->path);
    free(cp);
}

/* ---- checksum ---- */

uint64_t checkpoint_hash(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    for (size_t k = 0; k < size; k++) {
        hash = (hash ^ byte[k]) * UINT64_C(1099511628211);
    }
    return hash;
}

/* Little-endian whatever the machine is. */
static uint64_t hash_word(uint64_t hash, uint64_t word)
{
    for (int shift = 0; shift < 64; shift += 8) {
        hash = (hash ^ (word >> shift & 0xff)) * UINT64_C(1099511628211);
    }
    return hash;
}

uint64_t checkpoint_digest(const checkpoint *cp)
{
    uint64_t hash = CHECKPOINT_HASH_START;
    for (size_t k = 0; k < cp->count; k++) {
        const checkpoint_item *item = &cp->items[k];
        const unsigned char *data = checkpoint_item_data(item);
        hash = checkpoint_hash(hash, item->name, strlen(item->name) + 1);
        hash = checkpoint_hash(hash, &kind_letter[item->kind], 1);
        hash = hash_word(hash, (uint64_t)item->rank);
        for (int axis = 0; axis < item->rank; axis++) {
            hash = hash_word(hash, item->shape[axis]);
        }
        if (item->kind == CHECKPOINT_TEXT) {
            hash = checkpoint_hash(hash, data, item->count);
        } else {
            for (size_t element = 0; element < item->count; element++) {
                uint64_t word;
                memcpy(&word, data + element * sizeof word, sizeof word);
                hash = hash_word(hash, word);
            }
        }
        hash = hash_word(hash, item->columns);
        for (size_t column = 0; column < item->columns; column++) {
            const char *name = item->column_names[column];
            hash = checkpoint_hash(hash, name, strlen(name) + 1);
        }
    }
    return hash;
}

/* ---- filling ---- */

const void *checkpoint_item_data(const checkpoint_item *item)
{
    return item->data ? item->data : (const void *)&item->scalar;
}

static int by_name(const void *first, const void *second)
{
    return strcmp(((const checkpoint_item *)first)->name, ((const checkpoint_item *)second)->name);
}

void checkpoint_sort(checkpoint *cp)
{
    if (cp->count > 0) {
        qsort(cp->items, cp->count, sizeof *cp->items, by_name);
    }
}

/* What is wrong with a name, NULL if nothing is. */
static const char *name_problem(const char *name)
{
    if (strlen(name) > CHECKPOINT_MAX_NAME) {
        return "is longer than 255 bytes";
    }
    for (const char *part = name;; part++) {
        size_t length = strcspn(part, "/");
        if (length == 0) {
            return "has an empty part; parts are joined by a single '/'";
        }
        if (part[0] == '.' && (length == 1 || (length == 2 && part[1] == '.'))) {
            return "has the part '.' or '..'";
        }
        for (size_t k = 0; k < length; k++) {
            if (part[k] <= ' ' || part[k] > '~') {
                return "has a character that is not printable ASCII";
            }
        }
        part += length;
        if (*part == 0) {
            return NULL;
        }
    }
}

/* True if one name is the other or lies inside it as in a group. */
static bool names_collide(const char *first, const char *second)
{
    size_t one = strlen(first), two = strlen(second);
    size_t common = one < two ? one : two;
    const char *longer = one < two ? second : first;
    return strncmp(first, second, common) == 0 && (longer[common] == 0 || longer[common] == '/');
}

static ad_status check_name(const checkpoint *cp, const char *name, ad_error *error)
{
    const char *problem = name_problem(name);
    if (problem) {
        return ad_fail(error, AD_BAD_ARGUMENT, "checkpoint item '%.80s': the name %s", name,
                       problem);
    }
    if (cp->count >= CHECKPOINT_MAX_ITEMS) {
        return ad_fail(error, AD_BAD_ARGUMENT, "checkpoint item '%s': more than %d items", name,
                       CHECKPOINT_MAX_ITEMS);
    }
    for (size_t k = 0; k < cp->count; k++) {
        if (names_collide(name, cp->items[k].name)) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "checkpoint item '%.200s': collides with '%.200s', which is there", name,
                           cp->items[k].name);
        }
    }
    return AD_OK;
}

ad_status checkpoint_add(checkpoint *cp, const char *name, const checkpoint_item *item,
                         ad_error *error)
{
    ad_status status = check_name(cp, name, error);
    if (status != AD_OK) {
        return status;
    }
    if (cp->count == cp->capacity) {
        size_t capacity = cp->capacity ? 2 * cp->capacity : 32;
        checkpoint_item *items = realloc(cp->items, capacity * sizeof *items);
        if (!items) {
            return ad_fail(error, AD_NO_MEMORY, "checkpoint item '%s': out of memory", name);
        }
        cp->items = items;
        cp->capacity = capacity;
    }
    char *copy = checkpoint_copy(name);
    if (!copy) {
        return ad_fail(error, AD_NO_MEMORY, "checkpoint item '%s': out of memory", name);
    }
    cp->items[cp->count] = *item;
    cp->items[cp->count].name = copy;
    cp->count++;
    return AD_OK;
}

/* checkpoint_add that remembers the first failure. */
static ad_status put(checkpoint *cp, const char *name, const checkpoint_item *item)
{
    ad_error failure = {AD_OK, ""};
    ad_status status = checkpoint_add(cp, name, item, &failure);
    if (status != AD_OK && cp->failure.status == AD_OK) {
        cp->failure = failure;
    }
    return status;
}

/* Remember that the caller's `name` cannot be put. */
static ad_status refuse_put(checkpoint *cp, ad_status why, const char *name, const char *problem)
{
    if (cp->failure.status == AD_OK) {
        ad_fail(&cp->failure, why, "checkpoint item '%.200s': %s", name, problem);
    }
    return why;
}

static ad_status put_array(checkpoint *cp, const char *name, checkpoint_kind kind, const void *data,
                           int rank, const size_t *shape)
{
    checkpoint_item item = {.kind = kind, .rank = rank, .shape = {1, 1, 1}, .count = 1};
    if (rank < 0 || rank > CHECKPOINT_MAX_RANK || (rank > 0 && !shape)) {
        return refuse_put(cp, AD_BAD_ARGUMENT, name, "its rank must be 0 to 3, with a shape");
    }
    for (int axis = 0; axis < rank; axis++) {
        if (shape[axis] > 0 && item.count > SIZE_MAX / 16 / shape[axis]) {
            return refuse_put(cp, AD_BAD_ARGUMENT, name, "its shape is too large");
        }
        item.shape[axis] = shape[axis];
        item.count *= shape[axis];
    }
    if (!data && item.count > 0) {
        return refuse_put(cp, AD_BAD_ARGUMENT, name, "it has no data");
    }
    item.data = data;
    return put(cp, name, &item);
}

ad_status checkpoint_put_doubles(checkpoint *cp, const char *name, const double *data, int rank,
                                 const size_t *shape)
{
    return put_array(cp, name, CHECKPOINT_DOUBLE, data, rank, shape);
}

ad_status checkpoint_put_int64(checkpoint *cp, const char *name, const int64_t *data, int rank,
                               const size_t *shape)
{
    return put_array(cp, name, CHECKPOINT_INT64, data, rank, shape);
}

ad_status checkpoint_put_uint64(checkpoint *cp, const char *name, const uint64_t *data, int rank,
                                const size_t *shape)
{
    return put_array(cp, name, CHECKPOINT_UINT64, data, rank, shape);
}

ad_status checkpoint_put_text(checkpoint *cp, const char *name, const char *text)
{
    if (!text) {
        return refuse_put(cp, AD_BAD_ARGUMENT, name, "it has no text");
    }
    const size_t length = strlen(text);
    char *copy = checkpoint_copy(text);
    if (!copy) {
        return refuse_put(cp, AD_NO_MEMORY, name, "out of memory");
    }
    const checkpoint_item item = {.kind = CHECKPOINT_TEXT,
                                  .rank = 1,
                                  .shape = {length, 1, 1},
                                  .count = length,
                                  .data = copy,
                                  .owned_data = copy};
    const ad_status status = put(cp, name, &item);
    if (status != AD_OK) {
        free(copy);
    }
    return status;
}

ad_status checkpoint_put_table(checkpoint *cp, const char *name, const double *data, size_t rows,
                               size_t columns, const char *const *column_names)
{
    if (columns > CHECKPOINT_MAX_ITEMS) {
        return refuse_put(cp, AD_BAD_ARGUMENT, name, "it has too many columns");
    }
    for (size_t column = 0; column < columns; column++) {
        if (strlen(column_names[column]) > CHECKPOINT_MAX_NAME) {
            return refuse_put(cp, AD_BAD_ARGUMENT, name,
                              "a name of a column is longer than 255 bytes");
        }
    }
    ad_status status =
        put_array(cp, name, CHECKPOINT_DOUBLE, data, 2, (const size_t[]){rows, columns});
    if (status == AD_OK) {
        cp->items[cp->count - 1].columns = columns;
        cp->items[cp->count - 1].column_names = column_names;
    }
    return status;
}

ad_status checkpoint_put_double(checkpoint *cp, const char *name, double value)
{
    checkpoint_item item = {.kind = CHECKPOINT_DOUBLE, .shape = {1, 1, 1}, .count = 1};
    item.scalar.real = value;
    return put(cp, name, &item);
}

ad_status checkpoint_put_integer(checkpoint *cp, const char *name, int64_t value)
{
    checkpoint_item item = {.kind = CHECKPOINT_INT64, .shape = {1, 1, 1}, .count = 1};
    item.scalar.integer = value;
    return put(cp, name, &item);
}

/* ---- looking up ---- */

size_t checkpoint_count(const checkpoint *cp)
{
    return cp->count;
}

const char *checkpoint_name(const checkpoint *cp, size_t index)
{
    return cp->items[index].name;
}

const char *checkpoint_library_version(const checkpoint *cp)
{
    return cp->library_version;
}

static const checkpoint_item *find(const checkpoint *cp, const char *name)
{
    for (size_t k = 0; k < cp->count; k++) {
        if (strcmp(cp->items[k].name, name) == 0) {
            return &cp->items[k];
        }
    }
    return NULL;
}

bool checkpoint_has(const checkpoint *cp, const char *name)
{
    return find(cp, name) != NULL;
}

bool checkpoint_shape(const checkpoint *cp, const char *name, int *rank,
                      size_t shape[CHECKPOINT_MAX_RANK])
{
    const checkpoint_item *item = find(cp, name);
    if (item) {
        *rank = item->rank;
        memcpy(shape, item->shape, sizeof item->shape);
    }
    return item != NULL;
}

/* The item of that name and kind, NULL with a message if there is none. */
static const checkpoint_item *demand(const checkpoint *cp, const char *name, checkpoint_kind kind,
                                     ad_error *error)
{
    const char *path = file_bytes_shown(cp->path ? cp->path : "checkpoint");
    const checkpoint_item *item = find(cp, name);
    if (!item) {
        ad_fail(error, AD_BAD_INPUT, "%s: has no item '%.200s'; it was written for something else",
                path, name);
    } else if (item->kind != kind) {
        ad_fail(error, AD_BAD_INPUT, "%s: item '%s' is %s where %s is needed", path, name,
                kind_word[item->kind], kind_word[kind]);
        item = NULL;
    }
    return item;
}

static ad_status get_array(const checkpoint *cp, const char *name, checkpoint_kind kind,
                           void *destination, size_t expected_count, ad_error *error)
{
    const checkpoint_item *item = demand(cp, name, kind, error);
    if (!item) {
        return AD_BAD_INPUT;
    }
    if (item->count != expected_count) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: item '%s' has %zu elements (rank %d, %zu x %zu x %zu) where %zu are "
                       "needed",
                       file_bytes_shown(cp->path ? cp->path : "checkpoint"), name, item->count,
                       item->rank, item->shape[0], item->shape[1], item->shape[2], expected_count);
    }
    if (expected_count > 0) {
        memcpy(destination, checkpoint_item_data(item), expected_count * 8);
    }
    return AD_OK;
}

ad_status checkpoint_get_doubles(const checkpoint *cp, const char *name, double *destination,
                                 size_t expected_count, ad_error *error)
{
    return get_array(cp, name, CHECKPOINT_DOUBLE, destination, expected_count, error);
}

ad_status checkpoint_get_int64(const checkpoint *cp, const char *name, int64_t *destination,
                               size_t expected_count, ad_error *error)
{
    return get_array(cp, name, CHECKPOINT_INT64, destination, expected_count, error);
}

ad_status checkpoint_get_integer(const checkpoint *cp, const char *name, int64_t low, int64_t high,
                                 int64_t *value, ad_error *error)
{
    ad_status status = checkpoint_get_int64(cp, name, value, 1, error);
    if (status == AD_OK && (*value < low || *value > high)) {
        return ad_fail(error, AD_BAD_INPUT, "checkpoint: %s is %lld; %lld to %lld are possible",
                       name, (long long)*value, (long long)low, (long long)high);
    }
    return status;
}

ad_status checkpoint_get_uint64(const checkpoint *cp, const char *name, uint64_t *destination,
                                size_t expected_count, ad_error *error)
{
    return get_array(cp, name, CHECKPOINT_UINT64, destination, expected_count, error);
}

ad_status checkpoint_get_text(const checkpoint *cp, const char *name, const char **text,
                              ad_error *error)
{
    const checkpoint_item *item = demand(cp, name, CHECKPOINT_TEXT, error);
    if (!item) {
        return AD_BAD_INPUT;
    }
    *text = checkpoint_item_data(item);
    return AD_OK;
}

const char *checkpoint_column(const checkpoint *cp, const char *name, size_t column)
{
    const checkpoint_item *item = find(cp, name);
    return item && column < item->columns ? item->column_names[column] : NULL;
}
