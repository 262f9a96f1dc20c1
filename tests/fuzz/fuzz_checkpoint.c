/* A checkpoint whose first bytes fit what is behind them, so that HDF5 and the items are reached.
 * The input is what is behind them. */
#include "tests/fuzz/fuzz.h"
#include "tools/files/checkpoint_parts.h"

#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    static FILE *file; /* one for all */
    static char path[32];
    unsigned char block[CHECKPOINT_USER_BLOCK];
    ad_error error = {AD_OK, ""};
    checkpoint *cp;
    if (!file) {
        file = tmpfile();
        fuzz_require(file);
        snprintf(path, sizeof path, "/proc/self/fd/%d", fileno(file));
    }
    checkpoint_user_block(block, sizeof block + size,
                          checkpoint_hash(CHECKPOINT_HASH_START, bytes, size));
    rewind(file);
    fuzz_require(ftruncate(fileno(file), 0) == 0 && fwrite(block, sizeof block, 1, file) == 1 &&
                 fwrite(bytes, 1, size, file) == size && fflush(file) == 0);
    if (checkpoint_open(path, &cp, &error) == AD_OK) {
        checkpoint_free(cp);
    } else {
        fuzz_refused(&error);
    }
    return 0;
}
