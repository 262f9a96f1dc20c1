/* What the config_*.c files share; not for others. */
#ifndef TOOLS_CONFIG_CONFIG_PARTS_H
#define TOOLS_CONFIG_CONFIG_PARTS_H

#include "tools/config/config_keys.h"

#include <yaml.h>

/* ---- config_source.c: texts, and where each key stands ------------------------------------- */

/* Where the text being read comes from: a file, or an override "key=value". */
typedef struct config_origin {
    const char *file;
    const char *override; /* NULL: the file */
} config_origin;

typedef struct config_source config_source;

config_source *config_source_create(const char *file);
void config_source_free(config_source *source);
const char *config_source_file(const config_source *source);

/* A copy that lives as long as the source; NULL when memory runs out. */
const char *config_keep(config_source *source, const char *text);

/* Note that `path` ("network.hidden[1]") stands at `mark` of `origin`. False: out of memory. */
bool config_place(config_source *source, const config_origin *origin, const char *path,
                  yaml_mark_t mark);

/* Forget where `path` and everything below stands: it is no longer given. */
void config_unplace(config_source *source, const char *path);

/* Whether `path` itself was given. */
bool config_given(const config_source *source, const char *path);

/* The same, by --set. */
bool config_overridden(const config_source *source, const char *path);

/* Write "file:line:column: path: message" to error, the place that of `path` or of the nearest
 * section that has one; returns AD_BAD_INPUT. */
ad_status config_blame(const config_source *source, ad_error *error, const char *path,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Control characters become '?', so that a message stays one line. */
void config_one_line(char *text);

/* Whether any key of a section, "control.", was given. */
bool config_has(const config *experiment, const char *section);

/* ---- config_yaml.c: the document ----------------------------------------------------------- */

/* Load `text` of `size` bytes as one YAML document; on success the caller deletes it. */
ad_status config_document(const config_origin *origin, const char *text, size_t size,
                          yaml_document_t *document, ad_error *error);

/* Read a whole file into memory the caller frees, with a zero byte at the end. */
ad_status config_file_text(const char *path, char **text, size_t *size, ad_error *error);

/* ---- config_value.c: one value ------------------------------------------------------------- */

/* NULL and *value, or what is wrong with the text as a number (static). Infinity and NaN are
 * numbers here. Independent of the locale only within config_read. */
const char *config_parse_number(const char *text, double *value);

/* Store the value at `node`, a scalar or list, into the field of `key`. */
typedef struct config_reader {
    config *experiment;
    yaml_document_t *document;
    config_origin origin;
    ad_error *error;
    int visits; /* entries seen; bounds what aliases may expand to */
} config_reader;

ad_status config_read_value(config_reader *reader, const config_key *key, const char *path,
                            yaml_node_t *node);

/* The same for entry `index` of a list that is given already. */
ad_status config_read_entry(config_reader *reader, const config_key *key, const char *path,
                            int index, yaml_node_t *node);

/* The parameter of a path below "parameters", made where there is none, loses its value, and if it
 * is read anew its range. */
ad_status config_begin_parameter(config_reader *reader, const char *path, bool anew);

/* null: as if the key had never been given. */
ad_status config_unset(config_reader *reader, const config_key *key, const char *path);

/* The list, or one entry of it if entry >= 0, as if never given. */
ad_status config_reset_list(config_reader *reader, const config_list *list, int entry);

/* Whether `value` lies in the range of `key`. */
bool config_in_range(const config_key *key, double value);

/* Where the field of `key` lies; the entry of its list is taken from the path. */
void *config_field(config *experiment, const config_key *key, const char *path);

bool config_is_plain(const yaml_node_t *node);
bool config_is_empty(const yaml_node_t *node); /* nothing written after the colon */
bool config_is_null(const yaml_node_t *node);  /* null or ~ */

/* ---- config_read.c: the walk --------------------------------------------------------------- */

ad_status config_read_document(config_reader *reader);
ad_status config_read_override(config_reader *reader, const char *path);

/* {identify: ..., range: ...} in place of a number at `path`: a parameter of a name of its own, and
 * the quantity its formula. One that stood there before is forgotten; what is no section is left to
 * others. */
ad_status config_read_range(config_reader *reader, const char *path, yaml_node_t *node,
                            quantity *field);

/* ---- config_write.c: one value as YAML ----------------------------------------------------- */

/* `base` as of config_key_base. Formulas as they were written, or with the parameters put in and
 * the same however they were written. */
void config_write_value(FILE *file, const config_key *key, const char *base, bool as_written);

/* ---- config_resolve.c, config_check.c: after reading --------------------------------------- */

void config_defaults(config *experiment);

/* Of the end s = length, where it is not given. */
void config_resolve_end_type(config *experiment);

/* Defaults that depend on other keys but on no physics: the name, what ends hold, windows. */
ad_status config_resolve_choices(config *experiment, ad_error *error);

/* What section and material determine, as numbers where nothing was given; needs a scene that
 * passes its check. For people: scene_properties_of computes them from the scene itself. */
void config_fill_stiffness(scene *rod_scene);

/* Loads in SI, unit quaternions, absolute paths of files that are read later; needs a scene that
 * passes its check. */
ad_status config_resolve_physics(config *experiment, ad_error *error);

/* The path of a file that stands at `path` (a key), relative to the folder of the scene file, made
 * absolute, since what is written goes to another folder. */
ad_status config_absolute(config *experiment, const char *path, const char **file, ad_error *error);

/* Read the files of tables, and define them as functions of formulas (config_tables.c). */
ad_status config_define_tables(config *experiment, ad_error *error);

/* Read the file of rod.law and give the rod its law (config_tables.c). */
ad_status config_take_law(config *experiment, ad_error *error);

/* Read the file of residual, and give unknowns that were found with it their values; define its
 * names; and whether all are used (config_residual.c). */
ad_status config_take_residual(config *experiment, ad_error *error);
ad_status config_define_residual(config *experiment, ad_error *error);
ad_status config_residual_inputs(config *experiment, ad_error *error);
bool config_residual_opens(const config *experiment); /* outputs are to be learned */
bool config_residual_uses(const config *experiment, const char *name); /* as an input */
ad_status config_check_residual(const config *experiment, ad_error *error);

/* The values `at`, "a=1, b=2", in place of all ranges (config_at.c). */
ad_status config_close(config *experiment, const char *at, ad_error *error);

/* Define the parameters and parse what is not a plain number. */
ad_status config_parse_formulas(config *experiment, ad_error *error);
ad_status config_check_scene(const config *experiment, ad_error *error);

#endif
