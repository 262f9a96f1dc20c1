/* The law of a section as a table. */
#include "tools/files/table_file.h"
#include "tools/train/train_law.h"

#include <math.h>
#include <string.h>

ad_status train_law_write(const char *path, const scene_law *law, ad_error *error)
{
    table_build to;
    double values[SCENE_LAW_NUMBERS_MAX];
    char text[SCENE_LAW_NUMBERS_MAX][32];
    const char *words[SCENE_LAW_NUMBERS_MAX];
    const int count = scene_law_count(law);
    scene_law_numbers(law, values);
    for (int i = 0; i < count; i++) {
        scene_law_name(law, i, text[i]);
        words[i] = text[i];
    }
    table_begin(&to, (size_t)count);
    table_add(&to, "name", NULL, NULL, words);
    table_add(&to, "value", NULL, values, NULL);
    return table_write(path, &to.table, error);
}

ad_status train_law_read(const char *path, scene_law *law, ad_error *error)
{
    static const char *const words[] = {"name", NULL};
    table_file *file = NULL;
    ad_error reason;
    ad_status status = table_read_words(path, TABLE_NONFINITE, words, &file, error);
    if (status != AD_OK) {
        return status;
    }
    const double *values = table_column(file, "value");
    const char *const *names = table_words(file, "name");
    if (!values || !names) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: has no columns name and value; allowed: a law "
                         "that cpinn-law has written",
                         path);
    } else {
        status = scene_law_create((int)fmin((double)table_rows(file), 1e6), values, law, &reason);
        status = status == AD_OK ? AD_OK : ad_fail(error, status, "%s: %s", path, reason.message);
    }
    for (int i = 0; status == AD_OK && i < scene_law_count(law); i++) {
        char name[32];
        scene_law_name(law, i, name);
        if (strcmp(name, names[i]) != 0) {
            status = ad_fail(error, AD_BAD_INPUT, "%s: row %d is '%s'; allowed here: '%s'", path,
                             i + 1, names[i], name);
        }
    }
    table_free(file);
    return status;
}
