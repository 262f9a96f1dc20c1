#include "tools/judge/result_table.h"

#include "tools/files/table_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

result_table result_table_create(const char *const *names, size_t words, size_t numbers,
                                 size_t capacity)
{
    result_table s = {
        .names = names, .word_count = words, .number_count = numbers, .capacity = capacity};
    s.words = calloc(words * capacity + 1, sizeof *s.words);
    s.numbers = calloc(numbers * capacity + 1, sizeof *s.numbers);
    return s;
}

void result_table_free(result_table *s)
{
    free(s->words);
    free(s->numbers);
}

void result_table_add(result_table *s, const char *const *words, const double *numbers)
{
    if (!s->words || !s->numbers) {
        return;
    }
    for (size_t k = 0; k < s->word_count; k++) {
        s->words[k * s->capacity + s->rows] = words[k];
    }
    for (size_t k = 0; k < s->number_count; k++) {
        s->numbers[k * s->capacity + s->rows] = numbers[k];
    }
    s->rows++;
}

static ad_status write_table(const result_table *s, const char *path, ad_error *error)
{
    table_build to;
    if (!s->words || !s->numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    }
    table_begin(&to, s->rows);
    for (size_t k = 0; k < s->word_count + s->number_count; k++) {
        const size_t n = k - s->word_count;
        table_add(&to, s->names[k], NULL, k < s->word_count ? NULL : s->numbers + n * s->capacity,
                  k < s->word_count ? s->words + k * s->capacity : NULL);
    }
    return table_write(path, &to.table, error);
}

ad_status result_table_write_both(const result_table *s, const char *folder, const char *name,
                                  ad_error *error)
{
    static const char *const endings[] = {"csv", "h5"};
    char path[4096];
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < 2; i++) {
        snprintf(path, sizeof path, "%s/%s.%s", folder, name, endings[i]);
        status = write_table(s, path, error);
    }
    return status;
}

const char *result_table_seconds(double seconds, char text[RESULT_TABLE_TEXT])
{
    if (!isfinite(seconds)) {
        return "-";
    }
    int digits = seconds < 0.00095  ? 4
                 : seconds < 0.0995 ? 3
                 : seconds < 9.995  ? 2
                 : seconds < 99.95  ? 1
                                    : 0;
    snprintf(text, RESULT_TABLE_TEXT, "%.*f", digits, seconds);
    return text;
}

const char *result_table_error(double error, char text[RESULT_TABLE_TEXT])
{
    snprintf(text, RESULT_TABLE_TEXT, isfinite(error) ? "%.1e" : "-", error);
    return text;
}
