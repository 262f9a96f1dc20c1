/* checkpoint_compare A B: whether two checkpoints hold the same items to the last bit, but for
 * seconds. Exit 0; 1 with a line about the first that differs; 2: a file cannot be read. */
#include "tools/files/checkpoint.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct item {
    const char *name;
    size_t rows, columns, count;
    double *numbers; /* also integers, by their bits */
    const char *text;
} item;

static bool is_time(const char *name)
{
    return strstr(name, "seconds") != NULL;
}

static bool get(const checkpoint *from, const char *name, item *to)
{
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    ad_error error;
    *to = (item){.name = name};
    if (!checkpoint_shape(from, name, &rank, shape)) {
        return false;
    }
    to->count = shape[0] * shape[1] * shape[2];
    to->rows = shape[0];
    to->columns = to->count / (shape[0] ? shape[0] : 1);
    to->numbers = calloc(to->count + 1, sizeof *to->numbers);
    return to->numbers &&
           (checkpoint_get_doubles(from, name, to->numbers, to->count, &error) == AD_OK ||
            checkpoint_get_int64(from, name, (int64_t *)to->numbers, to->count, &error) == AD_OK ||
            checkpoint_get_uint64(from, name, (uint64_t *)to->numbers, to->count, &error) ==
                AD_OK ||
            checkpoint_get_text(from, name, &to->text, &error) == AD_OK);
}

/* The number in which they differ; `count`: none. */
static size_t first_difference(const checkpoint *from, const item *a, const item *b)
{
    for (size_t i = 0; i < a->count; i++) {
        const char *column = a->columns ? checkpoint_column(from, a->name, i % a->columns) : NULL;
        const bool same = memcmp(&a->numbers[i], &b->numbers[i], sizeof *a->numbers) == 0;
        if (!same && !(column && is_time(column))) {
            return i;
        }
    }
    return a->count;
}

static bool same(const checkpoint *one, const checkpoint *other, const char *name)
{
    item a, b;
    bool equal = get(one, name, &a) && get(other, name, &b);
    if (!equal) {
        printf("%s is in one of them alone\n", name);
    } else if (a.text || b.text) {
        equal = a.text && b.text && strcmp(a.text, b.text) == 0;
        if (!equal) {
            printf("%s: '%.300s', then '%.300s'\n", name, a.text ? a.text : "numbers",
                   b.text ? b.text : "numbers");
        }
    } else {
        const size_t at = a.count == b.count ? first_difference(one, &a, &b) : 0;
        equal = a.count == b.count && at == a.count;
        if (!equal) {
            printf("%s: number %zu of %zu, row %zu of %zu: %.17g, then %.17g (of %zu)\n", name, at,
                   a.count, at / (a.columns ? a.columns : 1), a.rows, a.numbers[at], b.numbers[at],
                   b.count);
        }
    }
    free(a.numbers);
    free(b.numbers);
    return equal;
}

int main(int count, char **arguments)
{
    checkpoint *files[2] = {NULL, NULL};
    ad_error error;
    if (count != 3) {
        fprintf(stderr, "checkpoint_compare A B\n");
        return 2;
    }
    for (int i = 0; i < 2; i++) {
        if (checkpoint_open(arguments[i + 1], &files[i], &error) != AD_OK) {
            fprintf(stderr, "%s\n", error.message);
            return 2;
        }
    }
    bool equal = true;
    for (int from = 0; from < 2; from++) {
        for (size_t i = 0; i < checkpoint_count(files[from]) && equal; i++) {
            const char *name = checkpoint_name(files[from], i);
            equal = is_time(name) || same(files[0], files[1], name);
        }
    }
    checkpoint_free(files[0]);
    checkpoint_free(files[1]);
    return equal ? 0 : 1;
}
