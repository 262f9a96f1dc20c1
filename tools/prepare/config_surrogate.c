#include "tools/prepare/config_surrogate.h"

#include <stdlib.h>
#include <sys/stat.h>

static void free_owner(void *owner)
{
    config_free(owner);
}

static ad_status read_model(const checkpoint *file, const char *path, surrogate *s, ad_error *error)
{
    char name[4096 + 16];
    const char *text = NULL;
    config *settings = NULL;
    if (!checkpoint_has(file, "surrogate/shape")) {
        return ad_fail(
            error, AD_BAD_INPUT,
            "%s: is no run of a one-step model; train a scene with the section surrogate", path);
    }
    ad_status status = checkpoint_get_text(file, "scene/yaml", &text, error);
    if (status == AD_OK) {
        snprintf(name, sizeof name, "%s:scene/yaml", path);
        status = prepare_read(name, text, 0, NULL, &settings, error);
    }
    if (status == AD_OK) {
        s->owner = settings;
        s->free_owner = free_owner;
        s->scene = &settings->scene;
        s->settings = settings->surrogate;
        status = s->settings.kind == SURROGATE_POLYNOMIAL
                     ? surrogate_get_nodes(file, &s->step, &s->numbers, error)
                     : surrogate_get(file, &s->step, &s->numbers, error);
    }
    if (status == AD_OK && s->step.inputs != s->scene->parameter_count) {
        status = ad_fail(error, AD_BAD_INPUT, "%s: the model is not that of its scene", path);
    }
    return status;
}

ad_status surrogate_load(const char *path, surrogate **result, ad_error *error)
{
    char found[4096];
    struct stat info;
    checkpoint *file = NULL;
    surrogate *s = calloc(1, sizeof *s);
    const bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    const int length = snprintf(found, sizeof found, "%s%s", path, folder ? "/checkpoint.h5" : "");
    *result = NULL;
    if (!s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    ad_status status = length < 0 || (size_t)length >= sizeof found
                           ? ad_fail(error, AD_BAD_ARGUMENT, "the path is too long")
                           : checkpoint_open(found, &file, error);
    status = status == AD_OK ? read_model(file, found, s, error) : status;
    checkpoint_free(file);
    if (status != AD_OK) {
        surrogate_free(s);
        return status;
    }
    *result = s;
    return AD_OK;
}
