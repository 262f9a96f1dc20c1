/* Reading an experiment from end to end: file, overrides, checks. */
#include "tools/config/config_parts.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>

void config_free(config *experiment)
{
    if (experiment) {
        config_source_free(experiment->source);
        quantities_free(experiment->names);
        if (experiment->residual.saved) {
            learned_file_free(experiment->residual.saved);
            free(experiment->residual.saved);
        }
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
        ad_fail(error, AD_BAD_INPUT,
                "override %.200s: allowed: key=value, the key as in rod.length", override);
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
        status = config_take_law(experiment, error);
    }
    if (status == AD_OK) {
        status = config_check_scene(experiment, error);
    }
    return status == AD_OK ? config_resolve_physics(experiment, error) : status;
}

ad_status config_refuse(const config *experiment, const char *key, const char *problem,
                        ad_error *error)
{
    return config_blame(experiment->source, error, key, "%s", problem);
}

bool config_gives(const config *experiment, const char *key)
{
    return config_given(experiment->source, key);
}

bool config_has(const config *experiment, const char *section)
{
    const size_t length = strlen(section);
    char path[CONFIG_PATH_MAX];
    bool any = false;
    for (int i = 0; i < config_key_count && !any; i++) {
        const config_key *key = &config_keys[i];
        const config_list *list = config_list_of(key->path);
        if (strncmp(key->path, section, length) == 0) {
            config_key_path(key, 0, path);
            any = config_given(experiment->source, list ? list->path : path);
        }
    }
    return any;
}

bool config_controls(const config *experiment)
{
    return config_has(experiment, "control.");
}

bool config_plans(const config *experiment)
{
    return config_has(experiment, "plan.");
}

/* An experiment with its defaults, of which nothing is given yet; NULL when memory runs out. */
static config *begin(const char *file)
{
    config *experiment = malloc(sizeof *experiment);
    if (experiment) {
        config_defaults(experiment);
        experiment->source = config_source_create(file);
        experiment->names = quantities_create();
        experiment->scene.names = experiment->names;
    }
    if (experiment && (!experiment->source || !experiment->names)) {
        config_free(experiment);
        experiment = NULL;
    }
    return experiment;
}

ad_status config_with_points(config *experiment, config_work *work, const void *context,
                             ad_error *error)
{
    locale_t c_locale = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    if (!c_locale) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory",
                       config_source_file(experiment->source));
    }
    locale_t before = uselocale(c_locale);
    ad_status status = work(experiment, context, error);
    uselocale(before);
    freelocale(c_locale);
    return status;
}

static ad_status make(const char *file, config_work *fill, const void *context, config **result,
                      ad_error *error)
{
    config *experiment = begin(file);
    *result = NULL;
    if (!experiment) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", file);
    }
    ad_status status = config_with_points(experiment, fill, context, error);
    if (status == AD_OK) {
        *result = experiment;
    } else {
        config_free(experiment);
    }
    return status;
}

typedef struct file_request {
    const char *path, *text;
    int count;
    const char *const *overrides;
    bool member;    /* one is wanted, */
    const char *at; /* this one */
} file_request;

static ad_status read_all(config *experiment, const file_request *r, ad_error *error)
{
    char *owned = NULL;
    size_t size = r->text ? strlen(r->text) : 0;
    ad_status status = r->text ? AD_OK : config_file_text(r->path, &owned, &size, error);
    if (status == AD_OK) {
        status = read_text(experiment, r->path, r->text ? r->text : owned, size, error);
    }
    for (int i = 0; i < r->count && status == AD_OK; i++) {
        status = read_override(experiment, r->path, r->overrides[i], error);
    }
    free(owned);
    if (status == AD_OK) {
        config_resolve_end_type(experiment);
    }
    return status;
}

/* One member is neither stepped, controlled nor chosen: what would be its inputs are numbers now.
 */
static ad_status close_member(config *experiment, const file_request *r, ad_error *error)
{
    ad_status status = config_close(experiment, r->at, error);
    if (status == AD_OK && config_controls(experiment)) {
        status = read_override(experiment, r->path, "control=null", error);
    }
    if (status == AD_OK && surrogate_is_given(&experiment->surrogate)) {
        status = read_override(experiment, r->path, "surrogate=null", error);
    }
    if (status == AD_OK && optimize_is_given(&experiment->optimize)) {
        status = read_override(experiment, r->path, "optimize=null", error);
    }
    return status;
}

static ad_status fill_from_file(config *experiment, const void *context, ad_error *error)
{
    const file_request *r = context;
    ad_status status = read_all(experiment, r, error);
    status = status == AD_OK ? config_take_residual(experiment, error) : status;
    if (status == AD_OK && r->member) {
        status = close_member(experiment, r, error);
    }
    return status == AD_OK ? resolve_and_check(experiment, error) : status;
}

ad_status config_read(const char *path, const char *text, int count, const char *const *overrides,
                      config **result, ad_error *error)
{
    const file_request request = {path, text, count, overrides, false, NULL};
    return make(path, fill_from_file, &request, result, error);
}

ad_status config_read_member(const char *path, const char *text, int count,
                             const char *const *overrides, const char *at, config **result,
                             ad_error *error)
{
    const file_request request = {path, text, count, overrides, true, at};
    return make(path, fill_from_file, &request, result, error);
}

/* ---- by hand ------------------------------------------------------------------------------- */

typedef struct hand_request {
    const scene *scene;
    const train_settings *settings;
} hand_request;

/* Texts and formulas of the caller become the experiment's own. False: out of memory. */
static bool keep(config *experiment, const config_key *key, void *field)
{
    const char **text = field;
    quantity *q = field;
    if ((key->type == CONFIG_TEXT || key->type == CONFIG_FORMULAS) && *text) {
        *text = config_keep(experiment->source, *text);
        return *text != NULL;
    }
    if (key->type == CONFIG_QUANTITY && q->is_given && q->node) {
        char *formula = quantity_text(*q, false);
        *q = quantity_unparsed(experiment->names, formula);
        free(formula);
        return formula != NULL;
    }
    return true;
}

static ad_status keep_field(config *experiment, const config_key *key, int index, ad_error *error)
{
    ad_error reason;
    char path[CONFIG_PATH_MAX];
    config_key_path(key, index, path);
    char *field = config_field(experiment, key, path);
    int count = key->entries_max ? key->entries_max : 1;
    for (int k = 0; k < count; k++, field += config_key_entry_size(key)) {
        ad_status status = key->type == CONFIG_QUANTITY
                               ? quantity_check(*(quantity *)(void *)field, &reason)
                               : AD_OK;
        if (status == AD_NO_MEMORY) {
            return ad_fail(error, status, "%s", reason.message);
        }
        if (status != AD_OK) {
            return config_blame(experiment->source, error, path, "%s", reason.message);
        }
        if (!keep(experiment, key, field)) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for a scene");
        }
    }
    return AD_OK;
}

static ad_status keep_all(config *experiment, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < config_key_count && status == AD_OK; i++) {
        const config_key *key = &config_keys[i];
        bool is_one = key->type == CONFIG_TEXT || key->type == CONFIG_FORMULAS ||
                      key->type == CONFIG_QUANTITY;
        int fields = is_one ? config_key_fields(experiment, key) : 0;
        for (int index = 0; index < fields && status == AD_OK; index++) {
            status = keep_field(experiment, key, index, error);
        }
    }
    return status;
}

static ad_status keep_parameters(config *experiment, const scene *given, ad_error *error)
{
    if (given->parameter_count < 0 || given->parameter_count > SCENE_PARAMETERS_MAX) {
        return config_blame(experiment->source, error, "parameters",
                            "has %d entries; allowed: 0 to %d", given->parameter_count,
                            SCENE_PARAMETERS_MAX);
    }
    for (int i = 0; i < given->parameter_count; i++) {
        const scene_parameter *from = &given->parameters[i];
        if (i >= scene_given_count(given) && i < scene_known_count(given)) {
            continue; /* states of plays, which formulas say again */
        }
        config_parameter *to = &experiment->parameters[experiment->parameter_count++];
        if (strlen(from->name) >= sizeof to->name) {
            return config_blame(experiment->source, error, "parameters",
                                "%.60s... is too long for a name", from->name);
        }
        snprintf(to->name, sizeof to->name, "%s", from->name);
        to->range[0] = from->low;
        to->range[1] = from->high;
        to->scale = (int)from->scale;
        to->identify = i < scene_known_count(given) ? NAN : given->guess[i];
    }
    return AD_OK;
}

/* Lengths that a program gave, before anything goes by them. */
static ad_status check_lists(const config *experiment, ad_error *error)
{
    for (int i = 0; i < config_list_count; i++) {
        const config_list *list = &config_lists[i];
        int count = config_list_length(experiment, list);
        if (count < list->least || count > list->most) {
            return config_blame(experiment->source, error, list->path,
                                "has %d entries; allowed: %d to %d", count, list->least,
                                list->most);
        }
    }
    return AD_OK;
}

static ad_status fill_by_hand(config *experiment, const void *context, ad_error *error)
{
    const hand_request *r = context;
    experiment->scene = *r->scene;
    experiment->scene.names = experiment->names;
    experiment->scene.parameter_count = experiment->scene.unknown_count =
        experiment->scene.memory_count = 0; /* until they are defined */
    experiment->settings = *r->settings;
    ad_status status = check_lists(experiment, error);
    if (status == AD_OK) {
        status = keep_parameters(experiment, r->scene, error);
    }
    if (status == AD_OK) {
        status = keep_all(experiment, error);
    }
    return status == AD_OK ? resolve_and_check(experiment, error) : status;
}

ad_status config_create(const scene *rod_scene, const train_settings *settings, config **result,
                        ad_error *error)
{
    const hand_request request = {rod_scene, settings};
    return make(settings->name ? settings->name : "scene", fill_by_hand, &request, result, error);
}
