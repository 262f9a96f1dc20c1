#include "tools/programs/export_files.h"

#include "tools/files/file_bytes.h"

#include <ctype.h>
#include <string.h>
#include <unistd.h>

ad_status export_files_name(export_out *to, ad_error *error)
{
    const char *base = file_bytes_name(to->path);
    const char *ending = to->ending ? to->ending : export_endings[EXPORT_SOURCE];
    size_t count = strlen(base), end = strlen(ending);
    count -= count > end && strcmp(base + count - end, ending) == 0 ? end : 0;
    bool ok = count > 0 && count <= EXPORT_NAME_MAX && !isdigit((unsigned char)base[0]);
    for (size_t i = 0; i < count; i++) {
        ok = ok && (base[i] == '_' || isalnum((unsigned char)base[i]));
    }
    if (!ok) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s %s: functions cannot be called %.*s; allowed: up to %d letters, digits "
                       "and _, the first no digit",
                       to->option, to->path, (int)count, base, EXPORT_NAME_MAX);
    }
    snprintf(to->name, sizeof to->name, "%.*s", (int)count, base);
    to->length = (size_t)(base - to->path) + count;
    return AD_OK;
}

void export_files_path(const export_out *to, const char *ending, char path[EXPORT_PATH])
{
    snprintf(path, EXPORT_PATH, "%.*s%s", (int)to->length, to->path, ending);
}

ad_status export_files_check(const export_out *to, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < (to->ending ? 1 : EXPORT_TEXTS) && status == AD_OK; i++) {
        char path[EXPORT_PATH];
        export_files_path(to, to->ending ? to->ending : export_endings[i], path);
        status = file_bytes_check(path, error);
        if (status == AD_OK && !to->force && access(path, F_OK) == 0) {
            status = ad_fail(error, AD_IO, "%s: there is such a file already; --force replaces it",
                             file_bytes_shown(path));
        }
    }
    return status;
}

ad_status export_files_put(const export_out *to, const export_texts texts, ad_error *error)
{
    static const int order[EXPORT_TEXTS] = {EXPORT_SELFTEST, EXPORT_SOURCE, EXPORT_HEADER};
    ad_status status = AD_OK;
    for (int i = 0; i < EXPORT_TEXTS && status == AD_OK; i++) {
        const export_text *text = &texts[order[i]];
        char path[EXPORT_PATH];
        export_files_path(to, export_endings[order[i]], path);
        status = file_bytes_write(path, text->bytes, text->size, error);
    }
    return status;
}
