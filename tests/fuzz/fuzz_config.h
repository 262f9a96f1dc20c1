/* A scene's file: read, written with every default, and read back to the same text. */
#ifndef TESTS_FUZZ_FUZZ_CONFIG_H
#define TESTS_FUZZ_FUZZ_CONFIG_H

#include "tests/fuzz/fuzz.h"
#include "tools/prepare/prepare.h"

static inline char *fuzz_config_text(const config *settings)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    const bool written = file && config_write(settings, file, false) == AD_OK;
    fuzz_require(file && fclose(file) == 0 && written);
    return text;
}

/* What is written says the same again; what it begins with has been solved. */
static inline config *fuzz_read_again(const char *text)
{
    config *again;
    ad_error error;
    fuzz_require(config_read("again.yaml", text, 0, NULL, &again, &error) == AD_OK);
    fuzz_require(prepare_choices(again, &error) == AD_OK);
    return again;
}

static inline void fuzz_config(const char *text, int count, const char *const *overrides)
{
    ad_error error = {AD_OK, ""};
    config *settings;
    if (prepare_read("fuzz.yaml", text, count, overrides, &settings, &error) != AD_OK) {
        fuzz_refused(&error);
        return;
    }
    char *open = fuzz_config_text(settings);
    config_free(fuzz_read_again(open));
    free(open);
    if (prepare_training(settings, &error) != AD_OK) {
        fuzz_refused(&error);
        config_free(settings);
        return;
    }
    char *written = fuzz_config_text(settings);
    config *again = fuzz_read_again(written);
    char *twice = fuzz_config_text(again);
    fuzz_require(strcmp(written, twice) == 0);
    config_free(again);
    config_free(settings);
    free(twice);
    free(written);
}

#endif
