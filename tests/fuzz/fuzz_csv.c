/* A table as CSV: read, written, and read back to the same names and the same bits. */
#include "tests/fuzz/fuzz.h"
#include "tools/files/table_parts.h"

/* What was measured: whatever stands in a column is refused, if at all, by whoever asks for it. */
static void read_measured(const unsigned char *text, size_t size)
{
    const table_wanted wanted = {"fuzz.csv", TABLE_MEASURED, NULL};
    ad_error error;
    table_file *table;
    if (table_from_csv(&wanted, text, size, &table, &error) != AD_OK) {
        fuzz_refused(&error);
        return;
    }
    for (size_t k = 0; k < table->columns; k++) {
        const double *found;
        if (table_find(table, table->names[k], TABLE_FINITE, &found, &error) != AD_OK) {
            fuzz_refused(&error);
        }
        fuzz_require(!found || table_column(table, table->names[k]) == found);
    }
    table_free(table);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const char *const words[] = {"place", NULL};
    const table_wanted wanted = {"fuzz.csv", TABLE_NONFINITE, words};
    ad_error error = {AD_OK, ""};
    table_file *table, *again;
    unsigned char *text = (unsigned char *)fuzz_text(bytes, size), *written = NULL;
    const ad_status status = table_from_csv(&wanted, text, size, &table, &error);
    read_measured(text, size);
    free(text);
    if (status != AD_OK) {
        fuzz_refused(&error);
        return 0;
    }
    const size_t columns = table->columns, rows = table->rows;
    const char **names = calloc(columns, sizeof *names);
    fuzz_require(names);
    for (size_t k = 0; k < columns; k++) {
        names[k] = table->names[k];
    }
    const table_source source = {.names = names,
                                 .columns = (const double *const *)table->values,
                                 .words = (const char *const *const *)table->pointers,
                                 .ncols = columns,
                                 .nrows = rows};
    size_t length = 0;
    fuzz_require(table_to_csv(&source, &written, &length) == AD_OK);
    text = (unsigned char *)fuzz_text(written, length);
    fuzz_require(table_from_csv(&wanted, text, length, &again, &error) == AD_OK);
    fuzz_require(again->columns == columns && again->rows == rows);
    for (size_t k = 0; k < columns; k++) {
        fuzz_require(strcmp(again->names[k], names[k]) == 0);
        for (size_t row = 0; row < rows; row++) {
            const double *a = table->values[k], *b = again->values[k];
            fuzz_require(a ? memcmp(a + row, b + row, sizeof *a) == 0 ||
                                 (a[row] != a[row] && b[row] != b[row])
                           : strcmp(table->words[k][row], again->words[k][row]) == 0);
        }
    }
    table_free(again);
    table_free(table);
    free(names);
    free(written);
    free(text);
    return 0;
}
