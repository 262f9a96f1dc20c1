/* The table of keys of a scene file: one row per key, in the order of --help. Internal to the
 * config_*.c files. */
#ifndef TOOLS_CONFIG_CONFIG_KEYS_H
#define TOOLS_CONFIG_CONFIG_KEYS_H

#include "tools/config/config.h"

typedef enum config_type {
    CONFIG_NUMBER,   /* double; NaN: not given */
    CONFIG_INTEGER,  /* int */
    CONFIG_LONG,     /* int64_t or uint64_t within its range */
    CONFIG_CHOICE,   /* an enumeration */
    CONFIG_TEXT,     /* const char *; NULL: not given */
    CONFIG_FORMULAS, /* names and formulas: const char *, a line "name=formula" of each; NULL */
    CONFIG_QUANTITY, /* quantity, a number or a formula */
    CONFIG_PARAMETER /* one of config.parameters, by the last part of its path */
} config_type;

enum {
    CONFIG_LOW_OPEN = OPTIM_LOW_OPEN,   /* low itself is not allowed */
    CONFIG_HIGH_OPEN = OPTIM_HIGH_OPEN, /* nor high */
    CONFIG_INFINITE = 4,                /* .inf is allowed */
    CONFIG_BY_NAME = 128 /* a number; its name in place of the section stands for a default */
};

enum { CONFIG_LIST_MAX = 16, CONFIG_PATH_MAX = 160 };

typedef struct config_key {
    const char *path; /* "rod.section.radius", "training.stages[].learning_rate" */
    config_type type;
    int entries_min; /* of a list; both 0: a single value */
    int entries_max;
    size_t offset; /* into config; for a path with [] into the first entry of its list */
    size_t
        count_offset; /* of the int that holds the length of a list of variable length; as offset */
    const char *unit;
    double low;
    double high;
    unsigned flags;
    unsigned reads; /* of a stage: for optimisers that read one of these groups; 0: for all */
    const char *const *(*names)(void); /* of a choice */
    const char *fallback, *help;       /* of a quantity of the scene; see config_words_of */
} config_key;

extern const config_key config_keys[];
extern const int config_key_count;

/* Lines of keys.txt: a path, then, by two spaces, its default, if that depends on other keys, and
 * its help; four spaces: the default goes on. */
extern const char *const config_text_keys[];

typedef struct config_words {
    char help[1000];
    char fallback[200]; /* the default in words; "": it is a value, or there is none */
} config_words;

config_words config_words_of(const config_key *key);

/* A list of sections. What an entry does not give is as in the last entry of config_defaults. */
typedef struct config_list {
    const char *path; /* "training.stages", of the keys "training.stages[].learning_rate" */
    const char *one, *many;
    const char *required; /* a choice that an entry has to give, "optimizer"; NULL: none */
    int least, most;
    size_t offset, stride, count_offset; /* into config */
} config_list;

extern const config_list config_lists[];
extern const int config_list_count;

/* The list that a key or a path in one ("loads.points[2].force") belongs to; NULL: none. */
const config_list *config_list_of(const char *path);

/* The list of that very path, without brackets; NULL: none. */
const config_list *config_list_find(const char *path);

int config_list_length(const config *experiment, const config_list *list);

/* How many fields there are of a key: entries of its list, or 1. */
int config_key_fields(const config *experiment, const config_key *key);

/* The path of one of them, "loads.points[2].force". */
void config_key_path(const config_key *key, int index, char path[CONFIG_PATH_MAX]);

/* Where one of them is, less the offset of the key. */
const char *config_key_base(const config *experiment, const config_key *key, int index);

/* The path in the table of every named parameter; of those with a range keys lie below it. */
#define CONFIG_PARAMETER_PATH "parameters.<name>"

/* What follows "parameters." in a path, as "load" or "load.range"; NULL: another key. */
const char *config_parameter_of(const char *path);

/* The parameter of such a path; NULL: none of that name. */
config_parameter *config_parameter_find(config *experiment, const char *path);

/* Row of a path pattern ("training.stages[].steps"), NULL when there is none. */
const config_key *config_key_find(const char *pattern);

/* The key whose name may stand in place of `section`, NULL when there is none. */
const config_key *config_key_by_name(const char *section);

/* Whether keys lie below `pattern` ("rod", "training.stages", "training.stages[]"). */
bool config_key_is_section(const char *pattern);

/* "rod.x[3].y" becomes "rod.x[].y", and the name of a parameter "<name>". */
void config_key_pattern(const char *path, char pattern[CONFIG_PATH_MAX]);

/* Whether entry `index` may have the key: one of a stage belongs to some optimisers. */
bool config_key_applies(const config *experiment, const config_key *key, int index);

/* The known key closest to `pattern`: of the same section, or of the same last part elsewhere; ""
 * when nothing is close. */
void config_key_suggest(const char *pattern, char suggestion[CONFIG_PATH_MAX]);

/* The names a section allows, "a, b, c", cut when they do not fit. */
void config_key_siblings(const char *section, char *text, size_t size);

/* "a number > 0", "a list of 3 numbers or formulas", "one of x, y". */
void config_key_allowed(const config_key *key, char *text, size_t size);

/* The same for one entry of a list. */
void config_key_entry_allowed(const config_key *key, char *text, size_t size);

/* Bytes of one entry. */
size_t config_key_entry_size(const config_key *key);

#endif
