/* A scene's file: read, written with every default, and read back to the same text. */
#include "tests/fuzz/fuzz.h"
#include "tools/config/config.h"

static char *text_of(const config *settings)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    const bool written = file && config_write(settings, file, false) == AD_OK;
    fuzz_require(file && fclose(file) == 0 && written);
    return text;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    ad_error error = {AD_OK, ""};
    config *settings, *again;
    char *text = fuzz_text(bytes, size);
    if (config_read("fuzz.yaml", text, 0, NULL, &settings, &error) != AD_OK) {
        fuzz_refused(&error);
        free(text);
        return 0;
    }
    char *written = text_of(settings);
    fuzz_require(config_read("written.yaml", written, 0, NULL, &again, &error) == AD_OK);
    char *twice = text_of(again);
    fuzz_require(strcmp(written, twice) == 0);
    config_free(again);
    config_free(settings);
    free(twice);
    free(written);
    free(text);
    return 0;
}
