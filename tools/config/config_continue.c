/* What may differ between an experiment and the one that continues it. */
#include "tools/config/config_parts.h"

#include <stdlib.h>
#include <string.h>

static bool always_free(const char *path)
{
    static const char *const sections[] = {"checkpoint.", "output.", "reference."};
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++) {
        if (strncmp(path, sections[i], strlen(sections[i])) == 0) {
            return true;
        }
    }
    return strcmp(path, "name") == 0;
}

/* The value as YAML; NULL when memory runs out. */
static char *value_text(const config_key *key, const void *base, const config *experiment)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return NULL;
    }
    config_write_value(file, key, base, (const char *)experiment, false);
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

/* Both values of one key, of the stages `index` for a key of a stage. */
static ad_status compare(const config_key *key, const config *before, const config *now, int index,
                         const char *why, ad_error *error)
{
    bool of_stage = config_key_in_stage(key);
    char *old =
        value_text(key, of_stage ? (const void *)&before->settings.stages[index] : before, before);
    char *new = value_text(key, of_stage ? (const void *)&now->settings.stages[index] : now, now);
    ad_status status = AD_OK;
    if (!old || !new) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory while comparing experiments");
    } else if (strcmp(old, new) != 0) {
        const char *name = of_stage ? strrchr(key->path, ']') + 2 : key->path;
        char place[32] = "";
        if (of_stage) {
            snprintf(place, sizeof place, "training.stages[%d].", index);
        }
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s%s: %.80s in the checkpoint, %.80s now; %s, or choose another folder "
                         "with --out",
                         place, name, old, new, why);
    }
    free(old);
    free(new);
    return status;
}

static ad_status compare_stage(const config *before, const config *now, int index, bool at_work,
                               ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        bool state = strstr(key->path, "].optimizer") || strstr(key->path, "].memory");
        if (!config_key_in_stage(key) || (at_work && !state)) {
            continue;
        }
        status = compare(key, before, now, index,
                         at_work ? "the stage at work keeps its optimiser and memory"
                                 : "this stage is over, add one after it",
                         error);
    }
    return status;
}

ad_status config_continues(const config *before, const config *now, int stage, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        if (!config_key_in_stage(key) && key->type != CONFIG_PARAMETER && !always_free(key->path)) {
            status =
                compare(key, before, now, 0, "a run keeps its scene, network and points", error);
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
