/* A YAML file as a tree that is read section by section, where names are free: of equations of
 * one's own. Overrides take the place of what stands at their path, and are added to the section
 * that it is in. Every mistake is one line with its place. */
#ifndef TOOLS_CONFIG_CONFIG_TREE_H
#define TOOLS_CONFIG_CONFIG_TREE_H

#include "tools/config/config_parts.h"

enum { CONFIG_OVERRIDES_MAX = 128, CONFIG_ENTRIES_MAX = 64 };

/* A node of the file or of an override. */
typedef struct config_view {
    yaml_document_t *document;
    yaml_node_t *node;
    const config_origin *origin;
} config_view;

typedef struct config_override {
    char path[CONFIG_PATH_MAX];
    yaml_document_t document;
    config_origin origin;
    bool used;
} config_override;

typedef struct config_tree {
    config_source *source;
    bool is_open;
    yaml_document_t document;
    config_origin origin;
    int override_count;
    config_override overrides[CONFIG_OVERRIDES_MAX];
    ad_error *error; /* where all below put theirs */
} config_tree;

/* An entry of a section, or of a list, whose keys are "". */
typedef struct config_entry {
    char path[CONFIG_PATH_MAX];
    const char *key;
    config_view value;
} config_entry;

typedef struct config_section {
    const char *path;
    int count;
    config_entry entries[CONFIG_ENTRIES_MAX];
} config_section;

/* `path`, or `text` of that name where it is not NULL; the tree stays where it is. To be closed,
 * also after an error. */
ad_status config_tree_open(config_tree *r, const char *path, const char *text, int count,
                           const char *const *overrides, ad_error *error);
void config_tree_close(config_tree *r);
config_view config_tree_root(config_tree *r);

/* The entries of a section, and those that overrides add, but for those that are null; the entries
 * of a list, of which a single value is one. */
ad_status config_tree_section(config_tree *r, const char *path, const config_view *v,
                              config_section *s);
ad_status config_tree_list(config_tree *r, const char *path, const config_view *v,
                           config_section *s);
bool config_tree_has(const config_section *s, const char *key);

/* Blames a key that is none of `allowed`, "range, time". */
ad_status config_tree_unknown(config_tree *r, const config_entry *e, const char *allowed);

/* Blames overrides whose path has not been read. */
ad_status config_tree_all_used(config_tree *r);

/* The text of a value, which is called `what`; true or false. */
ad_status config_tree_text(config_tree *r, const config_entry *e, const char *what,
                           const char **text);
ad_status config_tree_truth(config_tree *r, const config_entry *e, bool *truth);

/* Blames `path` for what a function has said, unless it said AD_OK. */
ad_status config_tree_blame(config_tree *r, const char *path, ad_status status,
                            const ad_error *why);

#endif
