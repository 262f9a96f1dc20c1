/* For tests: scenes read from YAML, and written again. */
#ifndef TESTS_CONFIG_TESTING_H
#define TESTS_CONFIG_TESTING_H

#include "near.h"

#include "tools/prepare/prepare.h"

#include <stdio.h>
#include <stdlib.h>

/* Of a scene that is to be trained. */
static inline ad_status read_to_train(const char *path, const char *text, int count,
                                      const char *const *overrides, config **result,
                                      ad_error *error)
{
    ad_status status = prepare_read(path, text, count, overrides, result, error);
    status = status == AD_OK ? prepare_training(*result, error) : status;
    if (status != AD_OK) {
        config_free(*result);
        *result = NULL;
    }
    return status;
}

/* text: NULL: the file's. */
static inline config *read_config(const char *path, const char *text, int count,
                                  const char *const *overrides)
{
    ad_error error = {.message = ""};
    config *made = NULL;
    if (read_to_train(path, text, count, overrides, &made, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return made;
}

static inline config *read_text(const char *text, int count, const char *const *overrides)
{
    return read_config("scene.yaml", text, count, overrides);
}

static inline config *read_with(const char *text, const char *override)
{
    return read_text(text, override != NULL, &override);
}

/* As YAML, to be freed. */
static inline char *written(const config *given, bool help)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    assert_int_equal(config_write(given, file, help), AD_OK);
    fclose(file);
    return text;
}

static inline void assert_text(quantity q, const char *expected)
{
    char *text = quantity_text(q, true);
    assert_string_equal(text, expected);
    free(text);
}

#endif
