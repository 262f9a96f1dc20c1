/* A table as C3D. */
#include "tests/fuzz/fuzz.h"
#include "tools/files/table_parts.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    for (int i = TABLE_FINITE; i <= TABLE_MEASURED; i++) {
        const table_wanted wanted = {"fuzz.c3d", (table_numbers)i, NULL};
        ad_error error = {AD_OK, ""};
        table_file *table;
        if (table_from_c3d(&wanted, bytes, size, &table, &error) == AD_OK) {
            fuzz_require(table_rows(table) * (table_columns(table) - 1) <= size);
            table_free(table);
        } else {
            fuzz_refused(&error);
        }
    }
    return 0;
}
