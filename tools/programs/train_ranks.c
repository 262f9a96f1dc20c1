#include "tools/programs/train_ranks.h"

#include "tools/programs/program_ranks.h"

#include <stdlib.h>

static void name_file(FILE *to, const char *path)
{
    if (path) {
        ranks_name_file(to, path);
        fputc('\n', to);
    }
}

ad_status train_ranks_compare(const ad_ranks *ranks, const config *settings, const char *checkpoint,
                              ad_status status, ad_error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = ranks && status == AD_OK ? open_memstream(&text, &size) : NULL;
    if (file) {
        const train_settings *training = &settings->settings;
        config_write(settings, file, false);
        for (int i = 0; i < training->data_count; i++) {
            name_file(file, training->data[i].file);
        }
        name_file(file, training->members_file);
        name_file(file, training->reference_file);
        name_file(file, checkpoint);
    }
    if (ranks && status == AD_OK && (!file || fclose(file) != 0)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for what ranks compare");
    }
    status = ranks_compare(ranks, status, text, error);
    free(text);
    return status;
}
