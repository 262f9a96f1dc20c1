/* A scene's file. */
#include "tests/fuzz/fuzz_config.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char *text = fuzz_text(bytes, size);
    fuzz_config(text, 0, NULL);
    free(text);
    return 0;
}
