/* The command line of the programs: a table of options, --help and --version, and errors on one
 * line of stderr. */
#ifndef TOOLS_PROGRAMS_CLI_H
#define TOOLS_PROGRAMS_CLI_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stdio.h>

enum {
    CLI_RUN = -1, /* the arguments are fine: go on */
    CLI_BAD = 2,  /* exit status of bad arguments, bad input, and whatever else fails */
    CLI_LIST_MAX = 128
};

typedef enum cli_kind {
    CLI_FLAG,    /* bool */
    CLI_CHOICE,  /* const char *: one of `value`, "program|support", where it is given as
                  * "--explain=program", else "" */
    CLI_TEXT,    /* const char * */
    CLI_LIST,    /* cli_list: may be given again and again */
    CLI_FOLDER,  /* the same, of --set: data_folder=, a folder that is there */
    CLI_INTEGER, /* int within low .. high */
    CLI_NUMBER   /* double within low .. high */
} cli_kind;

typedef struct cli_list {
    int count;
    const char *texts[CLI_LIST_MAX];
} cli_list;

typedef struct cli_option {
    const char *name;  /* "--out" */
    const char *value; /* "FILE"; NULL for a flag */
    cli_kind kind;
    void *target; /* where the value goes; its default is there already */
    double low, high;
} cli_option;

typedef struct cli_program {
    const char *name;         /* "cpinn-eval" */
    const char *operand;      /* "CONFIG.yaml"; exactly one is expected. NULL: none */
    const char *const *help;  /* lines, help.h */
    void (*more)(FILE *file); /* prints more help, may be NULL */
    cli_list *operands;       /* where one or more operands go; NULL: there is only one */
} cli_program;

/* Rows that several programs have, with the same meaning in each; help/shared.txt explains them. */
#define CLI_SET(list)      ((cli_option){"--set", "KEY=VALUE", CLI_LIST, list, 0, 0})
#define CLI_DATA(list)     ((cli_option){"--data", "FOLDER", CLI_FOLDER, list, 0, 0})
#define CLI_AT(text)       ((cli_option){"--at", "NAME=VALUE,...", CLI_TEXT, text, 0, 0})
#define CLI_OUT(file)      ((cli_option){"--out", "FILE", CLI_TEXT, file, 0, 0}) /* of shapes */
#define CLI_GRID(text)     ((cli_option){"--grid", "NSxNT", CLI_TEXT, text, 0, 0})
#define CLI_POINTS(file)   ((cli_option){"--points", "FILE", CLI_TEXT, file, 0, 0})
#define CLI_THREADS(count) ((cli_option){"--threads", "N", CLI_INTEGER, count, 0, 1024})
#define CLI_SEED(seed)     ((cli_option){"--seed", "N", CLI_INTEGER, seed, 0, 2147483647})
#define CLI_SECONDS(limit) ((cli_option){"--seconds", "S", CLI_NUMBER, limit, 1e-3, 1e6})
#define CLI_FORCE(flag)    ((cli_option){"--force", NULL, CLI_FLAG, flag, 0, 0})
#define CLI_JSON(file)     ((cli_option){"--json", "FILE|-", CLI_TEXT, file, 0, 0})
#define CLI_QUIET(flag)    ((cli_option){"--quiet", NULL, CLI_FLAG, flag, 0, 0})

/* `options` [count], without --help and --version, which every program has. Values are given as
 * "--out FILE" or "--out=FILE"; "--" ends the options. The texts are those of argv. Returns CLI_RUN
 * with *operand set (the last of several), or the exit status after having printed help, version or
 * one line of error. From then on a program whose output cannot be written says so when it ends,
 * and its exit status is 1. */
int cli_parse(const cli_program *program, const cli_option *options, int count, int argc,
              char **argv, const char **operand);

/* One line on stderr; returns CLI_BAD. An ad_error of bad input begins with its place in a file and
 * is printed as it is, any other after the name of the program; what is returned is the exit status
 * that the error has in every program: that of its verdict (physics/scene/verdict.h), 2 where the
 * input or a place for files is at fault, else 1. */
int cli_fail(const char *program, const char *format, ...) __attribute__((format(printf, 2, 3)));
int cli_fail_error(const char *program, const ad_error *error);

/* One line of a table of errors, unless the value is NaN: name, value, and what follows it. */
void cli_print_error(const char *name, double value, const char *unit);

/* A remark on stderr that does not end the program. */
void cli_warn(const char *program, const char *format, ...) __attribute__((format(printf, 2, 3)));

enum { CLI_GRID_MAX = 100000000 }; /* points */

/* Points along s and t from "NSxNT", or "NS" in a static scene, where *nt is 1; false: anything
 * else, or too many. */
bool cli_grid(const char *text, bool dynamic, long *ns, long *nt);

/* The project's version, "0.1.0". */
const char *cli_version(void);

#endif
