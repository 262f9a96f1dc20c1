/* What may differ between an experiment and the one that continues it. */
#include "tools/config/config_parts.h"

#include <stdlib.h>
#include <string.h>

static bool always_free(const char *path)
{
    static const char *const sections[] = {"checkpoint.", "output.",   "reference.",
                                           "control.",    "optimize.", "plan."};
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++) {
        if (strncmp(path, sections[i], strlen(sections[i])) == 0) {
            return true;
        }
    }
    return strcmp(path, "name") == 0 || strcmp(path, "data_folder") == 0;
}

/* The value as YAML; NULL when memory runs out. */
static char *value_text(const config_key *key, const char *base)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return NULL;
    }
    config_write_value(file, key, base, false);
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

/* Both values of one key, of the entries `index` for a key of a list. */
static ad_status compare(const config_key *key, const config *before, const config *now, int index,
                         const char *why, ad_error *error)
{
    char *old = value_text(key, config_key_base(before, key, index));
    char *new = value_text(key, config_key_base(now, key, index));
    char path[CONFIG_PATH_MAX];
    ad_status status = AD_OK;
    config_key_path(key, index, path);
    if (!old || !new) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory while comparing experiments");
    } else if (strcmp(old, new) != 0) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: %.80s in the checkpoint, %.80s now; %s, or choose another "
                         "folder",
                         path, old, new, why);
    }
    free(old);
    free(new);
    return status;
}

static bool in_stage(const config_key *key)
{
    const config_list *list = config_list_of(key->path);
    return list && list->offset == offsetof(config, settings.stages);
}

/* All entries of a key that is not of a stage. */
static ad_status compare_entries(const config_key *key, const config *before, const config *now,
                                 ad_error *error)
{
    static const char why[] = "a run keeps its scene, network and points";
    const config_list *list = config_list_of(key->path);
    int fields = config_key_fields(before, key), now_fields = config_key_fields(now, key);
    ad_status status = AD_OK;
    if (fields != now_fields) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: %d in the checkpoint, %d now; %s, or choose another folder", list->path,
                       fields, now_fields, why);
    }
    for (int index = 0; index < fields && status == AD_OK; index++) {
        status = compare(key, before, now, index, why, error);
    }
    return status;
}

static ad_status compare_stage(const config *before, const config *now, int index, bool at_work,
                               ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        bool state = strstr(key->path, "].optimizer") || strstr(key->path, "].memory");
        if (!in_stage(key) || (at_work && !state)) {
            continue;
        }
        status = compare(key, before, now, index,
                         at_work ? "the stage at work keeps its optimiser and memory"
                                 : "this stage is over, add one after it",
                         error);
    }
    return status;
}

/* Ranges; what a parameter with a value changes is seen in the formulas. */
static ad_status compare_ranges(const config *before, const config *now, ad_error *error)
{
    const scene *old = &before->scene, *new = &now->scene;
    bool same =
        old->parameter_count == new->parameter_count && old->unknown_count == new->unknown_count;
    for (int i = 0; i < old->parameter_count && same; i++) {
        const scene_parameter *a = &old->parameters[i], *b = &new->parameters[i];
        same = strcmp(a->name, b->name) == 0 && a->low == b->low && a->high == b->high &&
               a->scale == b->scale &&
               (i < scene_known_count(old) || old->guess[i] == new->guess[i]);
    }
    return same ? AD_OK
                : ad_fail(error, AD_BAD_INPUT,
                          "parameters: other ranges in the checkpoint than now; a run keeps its "
                          "scene, network and points, or choose another folder");
}

ad_status config_continues(const config *before, const config *now, int stage, ad_error *error)
{
    ad_status status = compare_ranges(before, now, error);
    for (int i = 0; status == AD_OK && i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        if (!in_stage(key) && !config_parameter_of(key->path) && !always_free(key->path)) {
            status = compare_entries(key, before, now, error);
        }
    }
    int needed = stage < before->settings.stage_count ? stage + 1 : before->settings.stage_count;
    if (status == AD_OK && now->settings.stage_count < needed) {
        return ad_fail(error, AD_BAD_INPUT,
                       "training.stages: the checkpoint is in stage %d, only %d are left; keep the "
                       "stages that have begun",
                       needed, now->settings.stage_count);
    }
    for (int index = 0; status == AD_OK && index < needed; index++) {
        status = compare_stage(before, now, index, index == stage, error);
    }
    return status;
}
