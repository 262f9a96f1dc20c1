/* A table as HDF5. */
#include "tests/fuzz/fuzz.h"
#include "tools/files/table_parts.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    for (int i = TABLE_FINITE; i <= TABLE_MEASURED; i++) {
        const table_wanted wanted = {"fuzz.h5", (table_numbers)i, NULL};
        ad_error error = {AD_OK, ""};
        table_file *table;
        if (table_from_hdf5(&wanted, bytes, size, &table, &error) == AD_OK) {
            table_free(table);
        } else {
            fuzz_refused(&error);
        }
    }
    return 0;
}
