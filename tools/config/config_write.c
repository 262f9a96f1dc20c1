/* The table of keys printed: an experiment as YAML, and the help on all keys. */
#include "tools/config/config_parts.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HELP_COLUMNS = 96 };

/* ---- values -------------------------------------------------------------------------------- */

static void write_part(FILE *file, const char *text, size_t length)
{
    fputc('"', file);
    for (const char *end = text + length; text < end; text++) {
        unsigned char byte = (unsigned char)*text;
        if (byte == '"' || byte == '\\') {
            fprintf(file, "\\%c", byte);
        } else if (byte < 0x20 || byte == 0x7f) {
            fprintf(file, "\\x%02x", byte);
        } else {
            fputc(byte, file);
        }
    }
    fputc('"', file);
}

static void write_quoted(FILE *file, const char *text)
{
    write_part(file, text, strlen(text));
}

/* Lines "name=formula". */
static void write_formulas(FILE *file, const char *lines)
{
    fputc('{', file);
    for (const char *line = lines; *line; line += strspn(line, "\n")) {
        const size_t name = strcspn(line, "=");
        const char *formula = line + name + 1;
        fprintf(file, "%s%.*s: ", line == lines ? "" : ", ", (int)name, line);
        write_part(file, formula, strcspn(formula, "\n"));
        line = formula + strcspn(formula, "\n");
    }
    fputc('}', file);
}

static void write_quantity(FILE *file, quantity q, bool as_written)
{
    double value = 0;
    char *text = quantity_text(q, as_written);
    if (text && !config_parse_number(text, &value)) {
        fputs(text, file);
    } else {
        write_quoted(file, text ? text : "out of memory");
    }
    free(text);
}

static void write_entry(FILE *file, const config_key *key, const void *field, bool as_written)
{
    quantity q;
    char number[32];
    double real = 0;
    int64_t wide = 0;
    int whole = 0;
    const char *text = NULL;
    switch (key->type) {
    case CONFIG_NUMBER:
        memcpy(&real, field, sizeof real);
        quantity_number_text(real, number);
        fputs(number, file);
        break;
    case CONFIG_LONG:
        memcpy(&wide, field, sizeof wide);
        fprintf(file, "%lld", (long long)wide);
        break;
    case CONFIG_INTEGER:
        memcpy(&whole, field, sizeof whole);
        fprintf(file, "%d", whole);
        break;
    case CONFIG_CHOICE:
        memcpy(&whole, field, sizeof whole);
        fputs(key->names()[whole], file);
        break;
    case CONFIG_TEXT:
        memcpy(&text, field, sizeof text);
        write_quoted(file, text);
        break;
    case CONFIG_FORMULAS:
        memcpy(&text, field, sizeof text);
        write_formulas(file, text);
        break;
    case CONFIG_QUANTITY:
        memcpy(&q, field, sizeof q);
        write_quantity(file, q, as_written);
        break;
    case CONFIG_PARAMETER:
        break;
    }
}

/* Whether the field holds something: numbers that are not NaN, texts that are not NULL, quantities
 * that are given, whole numbers and choices that are allowed, which those left open are not. */
static bool has_value(const config_key *key, const char *field)
{
    if (key->type == CONFIG_NUMBER) {
        double real = 0;
        memcpy(&real, field, sizeof real);
        return !isnan(real);
    }
    if (key->type == CONFIG_INTEGER || key->type == CONFIG_CHOICE) {
        int whole = 0;
        memcpy(&whole, field, sizeof whole);
        return key->entries_max > 0 || whole >= (key->type == CONFIG_CHOICE ? 0 : key->low);
    }
    if (key->type == CONFIG_LONG) {
        int64_t wide = 0;
        memcpy(&wide, field, sizeof wide);
        return key->entries_max > 0 || (double)wide >= key->low;
    }
    if (key->type == CONFIG_QUANTITY) {
        return ((const quantity *)(const void *)field)->is_given;
    }
    if (key->type == CONFIG_PARAMETER) {
        return false;
    }
    if (key->type == CONFIG_TEXT || key->type == CONFIG_FORMULAS) {
        const char *text = NULL;
        memcpy(&text, field, sizeof text);
        return text != NULL;
    }
    return true;
}

void config_write_value(FILE *file, const config_key *key, const char *base, bool as_written)
{
    const char *field = base + key->offset;
    int count = key->entries_max;
    if (count > 0 && key->entries_min != key->entries_max) {
        memcpy(&count, base + key->count_offset, sizeof count);
    }
    if (count < 0 || !has_value(key, field)) {
        fputs("null", file);
        return;
    }
    if (count == 0 && key->entries_max == 0) {
        write_entry(file, key, field, as_written);
        return;
    }
    fputc('[', file);
    for (int i = 0; i < count; i++) {
        fputs(i ? ", " : "", file);
        write_entry(file, key, field + (size_t)i * config_key_entry_size(key), as_written);
    }
    fputc(']', file);
}

/* ---- YAML ---------------------------------------------------------------------------------- */

typedef struct yaml_writer {
    FILE *file;
    const config *experiment;
    const config *derived; /* the experiment, with what follows from section and material */
    bool help;
    bool as_written;    /* formulas; else the same however they were written */
    const char *before; /* path of the row written last */
    bool *explained;    /* [config_key_count] of lists: not again with the next entry */
} yaml_writer;

static void indent(FILE *file, int depth)
{
    fprintf(file, "%*s", 2 * depth, "");
}

/* Headings of the sections in `path` that were not open after the row before, beginning `extra`
 * levels deep. Returns the depth of the key itself and in *name its last part. */
static int open_sections(const yaml_writer *writer, const char *path, int extra, const char **name)
{
    const char *before = writer->before;
    int depth = extra;
    bool same = true;
    const char *dot = strchr(path, '.');
    while (dot) {
        size_t length = (size_t)(dot - path) + 1;
        same = same && strncmp(before, path, length) == 0;
        if (!same) {
            indent(writer->file, depth);
            fprintf(writer->file, "%.*s:\n", (int)length - 1, path);
        }
        before += same ? length : 0;
        path = dot + 1;
        depth++;
        dot = strchr(path, '.');
    }
    *name = path;
    return depth;
}

static void write_comment(FILE *file, const config_key *key, int depth)
{
    char allowed[300];
    config_key_allowed(key, allowed, sizeof allowed);
    indent(file, depth);
    fprintf(file, "# %s", config_words_of(key).help);
    fprintf(file,
            key->entries_max || key->names || key->unit || key->type != CONFIG_TEXT ? " (%s)\n"
                                                                                    : "\n",
            allowed);
}

/* What follows from section and material: a number, or how it varies. */
static void write_derived(FILE *file, const config_key *key, const char *derived)
{
    const quantity *q = (const quantity *)(const void *)(derived + key->offset);
    bool varies = quantity_any_depends_on(key->entries_max ? key->entries_max : 1, q, "s");
    if (varies) {
        fputs("a function of s", file);
    } else {
        config_write_value(file, key, derived, false);
    }
}

/* What the entry does not say, of what follows from other keys. */
static void write_derived_of(const yaml_writer *writer, const config_key *key, int index)
{
    const char *base = config_key_base(writer->experiment, key, index);
    const char *derived = config_key_base(writer->derived, key, index);
    if (!has_value(key, base + key->offset) && has_value(key, derived + key->offset)) {
        fputs(" # ", writer->file);
        write_derived(writer->file, key, derived);
        fprintf(writer->file, ", %s", config_words_of(key).fallback);
    }
}

static void write_parameter(FILE *file, const config_parameter *parameter)
{
    char low[32], high[32];
    fprintf(file, "  %s: ", parameter->name);
    if (isnan(parameter->range[0])) {
        write_quantity(file, parameter->value, true);
    } else {
        quantity_number_text(parameter->range[0], low);
        quantity_number_text(parameter->range[1], high);
        fprintf(file, "{range: [%s, %s], scale: %s", low, high,
                scene_scale_names()[parameter->scale]);
        if (!isnan(parameter->identify)) {
            quantity_number_text(parameter->identify, low);
            fprintf(file, ", identify: %s", low);
        }
        fputc('}', file);
    }
    fputc('\n', file);
}

/* Of what a solution depends on, those that are open: the formulas have the others put in. */
static void write_parameters(yaml_writer *writer, const config_key *key, bool open_alone)
{
    const config *experiment = writer->experiment;
    const int count = open_alone ? experiment->scene.parameter_count : experiment->parameter_count;
    if (writer->help) {
        write_comment(writer->file, key, 0);
    }
    fprintf(writer->file, "parameters:%s\n", count ? "" : " {}");
    for (int i = 0; i < experiment->parameter_count; i++) {
        if (!open_alone || !isnan(experiment->parameters[i].range[0])) {
            write_parameter(writer->file, &experiment->parameters[i]);
        }
    }
    writer->before = key->path;
}

/* An empty line before what does not belong to the section of the row before. */
static void begin_section(const yaml_writer *writer, const char *path)
{
    bool other = strncmp(path, writer->before, strcspn(path, ".") + 1) != 0;
    if ((*writer->before && !strchr(path, '.') != !strchr(writer->before, '.')) ||
        (strchr(path, '.') && other)) {
        fputc('\n', writer->file);
    }
}

static void write_row(yaml_writer *writer, const config_key *key)
{
    const char *name = NULL;
    const char *base = (const char *)writer->experiment;
    begin_section(writer, key->path);
    int depth = open_sections(writer, key->path, 0, &name);
    if (writer->help) {
        write_comment(writer->file, key, depth);
    }
    indent(writer->file, depth);
    fprintf(writer->file, "%s: ", name);
    config_write_value(writer->file, key, base, writer->as_written);
    write_derived_of(writer, key, 0);
    fputc('\n', writer->file);
    writer->before = key->path;
}

/* Entry `index` of the list whose keys are neighbours in the table, from `first` to `end`. */
static void write_entry_of(const yaml_writer *outer, int first, int end, int index, int depth)
{
    yaml_writer writer = *outer;
    size_t prefix = (size_t)(strstr(config_keys[first].path, "[].") + 3 - config_keys[first].path);
    writer.before = "";
    for (int i = first; i < end; i++) {
        const config_key *key = &config_keys[i];
        const char *path = key->path + prefix, *name = path;
        if (!config_key_applies(writer.experiment, key, index)) {
            continue;
        }
        int inner = i == first ? depth + 1 : open_sections(&writer, path, depth + 1, &name);
        if (writer.help && !writer.explained[i]) {
            write_comment(writer.file, key, inner);
        }
        writer.explained[i] = true;
        indent(writer.file, i == first ? depth : inner);
        fprintf(writer.file, "%s%s: ", i == first ? "- " : "", name);
        config_write_value(writer.file, key, config_key_base(writer.experiment, key, index),
                           writer.as_written);
        write_derived_of(&writer, key, index);
        fputc('\n', writer.file);
        writer.before = path;
    }
}

/* All entries of the list whose keys begin at `first`; returns the key behind them. */
static int write_list(yaml_writer *writer, int first)
{
    const config_key *key = &config_keys[first];
    const config_list *list = config_list_of(key->path);
    int end = first, count = config_list_length(writer->experiment, list);
    const char *name = NULL;
    const bool is_open = count > 0 && list->required && /* which is its first key */
                         !has_value(key, config_key_base(writer->experiment, key, 0) + key->offset);
    while (end < config_key_count && config_list_of(config_keys[end].path) == list) {
        end++;
    }
    begin_section(writer, list->path);
    int depth = open_sections(writer, list->path, 0, &name);
    indent(writer->file, depth);
    fprintf(writer->file, "%s:%s\n", name, is_open ? " null" : count ? "" : " []");
    for (int i = 0; i < count && !is_open; i++) {
        write_entry_of(writer, first, end, i, depth + 1);
    }
    writer->before = config_keys[end - 1].path;
    return end;
}

/* Keys that a classical solution does not depend on. */
static bool is_physics(const char *path)
{
    static const char *const others[] = {
        "name",   "data_folder", "tables",  "data",      "time.windows", "formulation",
        "motion", "enforcement", "network", "losses",    "training",     "checkpoint",
        "output", "members",     "control", "surrogate", "plan",         "optimize"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        size_t length = strlen(others[i]);
        if (strncmp(path, others[i], length) == 0 && strchr(".[", path[length])) { /* or its end */
            return false;
        }
    }
    return true;
}

static void write_keys(yaml_writer *writer, bool physics_alone)
{
    const bool controls = config_controls(writer->experiment);
    const bool plans = config_plans(writer->experiment);
    const bool steps = surrogate_is_given(&writer->experiment->surrogate);
    const bool chooses = optimize_is_given(&writer->experiment->optimize);
    for (int i = 0; i < config_key_count;) {
        if ((strncmp(config_keys[i].path, "control.", 8) == 0 && !controls) ||
            (strncmp(config_keys[i].path, "plan.", 5) == 0 && !plans) ||
            (strncmp(config_keys[i].path, "surrogate.", 10) == 0 && !steps) ||
            (strncmp(config_keys[i].path, "optimize.", 9) == 0 && !chooses)) {
            i++; /* the section as a whole is given, or is not */
        } else if (config_keys[i].type == CONFIG_PARAMETER &&
                   (!physics_alone || scene_is_open(&writer->experiment->scene))) {
            begin_section(writer, config_keys[i].path);
            write_parameters(writer, &config_keys[i++], physics_alone);
        } else if (config_parameter_of(config_keys[i].path) ||
                   (physics_alone && !is_physics(config_keys[i].path))) {
            i++;
        } else if (config_list_of(config_keys[i].path)) {
            i = write_list(writer, i);
        } else {
            write_row(writer, &config_keys[i++]);
        }
    }
}

/* Numbers and lists as they were written; choices as they are. */
static void take_written(scene *to, const scene *written)
{
    const scene chosen = *to;
    *to = *written;
    to->motion = chosen.motion;
    to->formulation = chosen.formulation;
    to->rotation = chosen.rotation;
    to->windows = chosen.windows;
    to->boundary_enforcement = chosen.boundary_enforcement;
    to->initial_enforcement = chosen.initial_enforcement;
}

static ad_status write_experiment(const config *experiment, FILE *file, bool help,
                                  bool physics_alone)
{
    locale_t c_locale = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    config *written = malloc(sizeof *written), *derived = malloc(sizeof *derived);
    bool *explained = calloc((size_t)config_key_count, sizeof *explained);
    if (!c_locale || !written || !derived || !explained) {
        if (c_locale) {
            freelocale(c_locale);
        }
        free(written);
        free(derived);
        free(explained);
        return AD_NO_MEMORY;
    }
    *written = *experiment;
    if (experiment->is_mapped) {
        take_written(&written->scene, &experiment->as_written);
    }
    *derived = *written;
    config_fill_stiffness(&derived->scene);
    yaml_writer writer = {file, written, derived, help, !physics_alone, "", explained};
    locale_t before = uselocale(c_locale);
    write_keys(&writer, physics_alone);
    uselocale(before);
    freelocale(c_locale);
    free(written);
    free(derived);
    free(explained);
    return ferror(file) ? AD_IO : AD_OK;
}

ad_status config_write(const config *experiment, FILE *file, bool help)
{
    fprintf(file,
            "# Every key of the experiment, defaults filled in; loads are in SI units. null: not\n"
            "# given. Behind a null # is the number that follows from section and material;\n"
            "# a number in place of the null would come before it.\n");
    return write_experiment(experiment, file, help, false);
}

ad_status config_write_physics(const config *experiment, FILE *file)
{
    return write_experiment(experiment, file, false, true);
}

/* ---- help ---------------------------------------------------------------------------------- */

/* Words of `text`, wrapped and indented. */
static void write_wrapped(FILE *file, const char *text, int margin)
{
    int column = 0;
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (column == 0 || column + 1 + length > HELP_COLUMNS) {
            fprintf(file, "%s%*s", column == 0 ? "" : "\n", margin, "");
            column = margin;
        } else {
            fputc(' ', file);
            column++;
        }
        fprintf(file, "%.*s", length, text);
        column += length;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', file);
}

/* Of an entry of a list, the defaults of one that the file gives; without any stage other values
 * hold, which the help of its optimizer names. */
static void help_row(FILE *file, const config *defaults, const config_key *key)
{
    char allowed[300];
    const config_words words = config_words_of(key);
    const config_list *list = config_list_of(key->path);
    const char *base = config_key_base(defaults, key, list ? list->most - 1 : 0);
    bool none = !has_value(key, base + key->offset);
    config_key_allowed(key, allowed, sizeof allowed);
    fprintf(file, "  %s: %s", key->path, allowed);
    if (*words.fallback) {
        fprintf(file, "; %s%s", strcmp(words.fallback, "required") ? "default: " : "",
                words.fallback);
    } else if (!none) {
        fprintf(file, "; default: ");
        config_write_value(file, key, base, true);
    }
    if (key->reads) {
        optim_method_list(0, key->reads, allowed, sizeof allowed);
        fprintf(file, "; %s only", allowed);
    }
    fputc('\n', file);
    write_wrapped(file, words.help, 6);
}

void config_help(FILE *file)
{
    config *defaults = malloc(sizeof *defaults);
    const char *before = "";
    if (!defaults) {
        return;
    }
    config_defaults(defaults);
    for (int i = 0; i < config_key_count; i++) {
        const char *path = config_keys[i].path;
        size_t length = strcspn(path, ".");
        if (!(strncmp(path, before, length) == 0 && strcspn(before, ".") == length)) {
            fprintf(file, "%s%.*s\n", i ? "\n" : "", (int)length, path);
        }
        help_row(file, defaults, &config_keys[i]);
        before = path;
    }
    fprintf(file, "\nformulas\n");
    write_wrapped(file, config_words_of(&(config_key){.path = "formulas"}).help, 2);
    free(defaults);
}
