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

/* What a text says and leaves open. Equilibria to begin in are the solver's, in seconds. */
static inline ad_status fuzz_read(const char *text, int count, const char *const *overrides,
                                  config **result, ad_error *error)
{
    ad_status status = config_read("fuzz.yaml", text, count, overrides, result, error);
    status = status == AD_OK ? prepare_choices(*result, error) : status;
    const bool settles = status == AD_OK && (*result)->scene.initial.state == SCENE_EQUILIBRIUM;
    return status == AD_OK && !settles ? prepare_start(*result, error) : status;
}

static inline void fuzz_config(const char *text, int count, const char *const *overrides)
{
    ad_error error = {AD_OK, ""};
    config *settings, *again;
    if (fuzz_read(text, count, overrides, &settings, &error) != AD_OK) {
        fuzz_refused(&error);
        config_free(settings);
        return;
    }
    char *open = fuzz_config_text(settings);
    fuzz_require(fuzz_read(open, 0, NULL, &again, &error) == AD_OK);
    config_free(again);
    free(open);
    if (prepare_training(settings, &error) != AD_OK) {
        fuzz_refused(&error);
        config_free(settings);
        return;
    }
    char *written = fuzz_config_text(settings);
    fuzz_require(fuzz_read(written, 0, NULL, &again, &error) == AD_OK);
    char *twice = fuzz_config_text(again);
    fuzz_require(strcmp(written, twice) == 0);
    config_free(again);
    config_free(settings);
    free(twice);
    free(written);
}

#endif
