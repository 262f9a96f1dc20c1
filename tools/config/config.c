/* Reading an experiment from end to end: file, overrides, defaults, checks. */
#include "tools/config/config_parts.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>

void config_free(config *experiment)
{
    if (experiment) {
        config_source_free(experiment->source);
        quantities_free(experiment->names);
        free(experiment);
    }
}

static ad_status read_text(config *experiment, const char *file, const char *text, size_t size,
                           ad_error *error)
{
    yaml_document_t document;
    config_reader reader = {experiment, &document, {file, NULL}, error, 0};
    ad_status status = config_document(&reader.origin, text, size, &document, error);
    if (status == AD_OK) {
        status = config_read_document(&reader);
        yaml_document_delete(&document);
    }
    return status;
}

static ad_status read_override(config *experiment, const char *file, const char *override,
                               ad_error *error)
{
    yaml_document_t document;
    config_reader reader = {experiment, &document, {file, override}, error, 0};
    char path[CONFIG_PATH_MAX];
    const char *equals = strchr(override, '=');
    size_t length = equals ? (size_t)(equals - override) : 0;
    if (length == 0 || length >= sizeof path - 1) {
        ad_fail(error, AD_BAD_INPUT, "--set %.200s: allowed: key=value, the key as in rod.length",
                override);
        if (error) {
            config_one_line(error->message);
        }
        return AD_BAD_INPUT;
    }
    memcpy(path, override, length);
    path[length] = '\0';
    ad_status status =
        config_document(&reader.origin, equals + 1, strlen(equals + 1), &document, error);
    if (status == AD_OK) {
        status = config_read_override(&reader, path);
        yaml_document_delete(&document);
    }
    return status;
}

static ad_status resolve_and_check(config *experiment, ad_error *error)
{
    ad_status status = config_parse_formulas(experiment, error);
    if (status == AD_OK) {
        status = config_resolve_choices(experiment, error);
    }
    if (status == AD_OK) {
        status = config_check_scene(experiment, error);
    }
    if (status == AD_OK) {
        status = config_resolve_physics(experiment, error);
    }
    if (status == AD_OK) {
        status = config_check_ends(experiment, error);
    }
    return status == AD_OK ? config_check_training(experiment, error) : status;
}

ad_status config_refuse(const config *experiment, const char *key, const char *problem,
                        ad_error *error)
{
    return config_blame(experiment->source, error, key, "%s", problem);
}

static ad_status read_all(config *experiment, const char *path, const char *text, int count,
                          const char *const *overrides, ad_error *error)
{
    char *owned = NULL;
    size_t size = text ? strlen(text) : 0;
    ad_status status = text ? AD_OK : config_file_text(path, &owned, &size, error);
    if (status == AD_OK) {
        status = read_text(experiment, path, text ? text : owned, size, error);
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = read_override(experiment, path, overrides[i], error);
    }
    free(owned);
    return status == AD_OK ? resolve_and_check(experiment, error) : status;
}

ad_status config_read(const char *path, const char *text, int count, const char *const *overrides,
                      config **result, ad_error *error)
{
    *result = NULL;
    config *experiment = malloc(sizeof *experiment);
    locale_t c_locale = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    if (experiment) {
        config_defaults(experiment);
        experiment->source = config_source_create(path);
        experiment->names = quantities_create();
    }
    if (!experiment || !experiment->source || !experiment->names || !c_locale) {
        config_free(experiment);
        if (c_locale) {
            freelocale(c_locale);
        }
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", path);
    }
    locale_t before = uselocale(c_locale); /* numbers have a point, whatever the user's language */
    ad_status status = read_all(experiment, path, text, count, overrides, error);
    uselocale(before);
    freelocale(c_locale);
    if (status == AD_OK) {
        *result = experiment;
    } else {
        config_free(experiment);
    }
    return status;
}
