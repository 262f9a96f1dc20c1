/* Tables of numbers that formulas interpolate, and the law of the rod. */
#include "tools/config/config_parts.h"

#include "tools/files/table_file.h"
#include "tools/train/train_law.h"

#include <string.h>

/* The numbers of the file take its place, so that what is written is complete by itself. */
static ad_status take_rows(config *experiment, config_table *table, const table_file *file,
                           const char *path, ad_error *error)
{
    size_t rows = table_rows(file);
    if (table_columns(file) != 2) {
        return config_blame(experiment->source, error, path,
                            "has %zu columns; allowed: 2, of the argument and of the value",
                            table_columns(file));
    }
    if (rows < 2 || rows > QUANTITY_TABLE_MAX) {
        return config_blame(experiment->source, error, path, "has %zu rows; allowed: 2 to %d", rows,
                            QUANTITY_TABLE_MAX);
    }
    table->x_count = table->y_count = (int)rows;
    memcpy(table->x, table_column(file, table_name(file, 0)), rows * sizeof *table->x);
    memcpy(table->y, table_column(file, table_name(file, 1)), rows * sizeof *table->y);
    table->file = NULL;
    return AD_OK;
}

static ad_status read_file(config *experiment, config_table *table, const char *path,
                           ad_error *error)
{
    ad_error reason;
    table_file *file = NULL;
    ad_status status = config_absolute(experiment, path, &table->file, error);
    if (status != AD_OK) {
        return status;
    }
    status = table_read(table->file, TABLE_FINITE, &file, &reason);
    if (status == AD_NO_MEMORY) {
        return ad_fail(error, status, "%s", reason.message);
    }
    if (status != AD_OK) {
        return config_blame(experiment->source, error, path, "%s", reason.message);
    }
    status = take_rows(experiment, table, file, path, error);
    table_free(file);
    return status;
}

static ad_status define(config *experiment, int index, ad_error *error)
{
    config_table *table = &experiment->tables[index];
    char section[32], file[48];
    ad_error reason;
    snprintf(section, sizeof section, "tables[%d]", index);
    snprintf(file, sizeof file, "%s.file", section);
    if (!table->name) {
        return config_blame(experiment->source, error, section,
                            "has no name; give it the one that formulas call it by");
    }
    bool numbers = table->x_count > 0 || table->y_count > 0;
    if ((table->file != NULL) == numbers) {
        return config_blame(experiment->source, error, section,
                            numbers ? "has a file and numbers; allowed: one of the two"
                                    : "has no numbers; give file, or x and y");
    }
    ad_status status = table->file ? read_file(experiment, table, file, error) : AD_OK;
    if (status == AD_OK && table->x_count != table->y_count) {
        return config_blame(experiment->source, error, section,
                            "has %d numbers x and %d numbers y; allowed: as many", table->x_count,
                            table->y_count);
    }
    if (status == AD_OK) {
        status = quantities_define_table(experiment->names, table->name, table->x_count, table->x,
                                         table->y, &reason);
        return status == AD_BAD_INPUT
                   ? config_blame(experiment->source, error, section, "%s", reason.message)
               : status == AD_OK ? AD_OK
                                 : ad_fail(error, status, "%s", reason.message);
    }
    return status;
}

ad_status config_define_tables(config *experiment, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < experiment->table_count && status == AD_OK; i++) {
        status = define(experiment, i, error);
    }
    return status;
}

/* ---- the law ------------------------------------------------------------------------------- */

static ad_status read_law(config *experiment, ad_error *error)
{
    config_law *law = &experiment->law;
    if (law->count > 0) {
        return law->file
                   ? ad_fail(error, AD_BAD_INPUT, "has a file and numbers; allowed: one of the two")
                   : scene_law_create(law->count, law->numbers, &law->law, error);
    }
    ad_status status = train_law_read(law->file, &law->law, error);
    if (status == AD_OK) { /* what is written is complete by itself */
        law->count = scene_law_count(&law->law);
        law->file = NULL;
        scene_law_numbers(&law->law, law->numbers);
    }
    return status;
}

ad_status config_take_law(config *experiment, ad_error *error)
{
    config_law *law = &experiment->law;
    ad_error reason;
    const scene_law *by_hand = experiment->scene.rod.law;
    if (by_hand) {
        law->count = scene_law_count(by_hand);
        scene_law_numbers(by_hand, law->numbers);
    }
    if (!law->file && law->count == 0) {
        return AD_OK;
    }
    ad_status status = config_absolute(experiment, "rod.law.file", &law->file, error);
    if (status != AD_OK) {
        return status;
    }
    status = read_law(experiment, &reason);
    if (status == AD_OK) {
        scene_take_law(&experiment->scene.rod, &law->law);
        return AD_OK;
    }
    return status == AD_NO_MEMORY
               ? ad_fail(error, status, "%s", reason.message)
               : config_blame(experiment->source, error, "rod.law", "%s", reason.message);
}
