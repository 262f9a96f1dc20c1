/* A program written out as C. Private to autodiff. */
#ifndef AD_C_CODE_H
#define AD_C_CODE_H

#include "autodiff/program.h"

/* The texts of lanes.h and stumpff.h, which what is written needs (made by CMakeLists.txt). */
extern const char *const ad_text_lanes[], *const ad_text_stumpff[]; /* lines, NULL at the end */
void ad_c_text(const char *const *lines, FILE *file);

/* How many groups of elementwise instructions follow one another from `group` on: what one function
 * does (fused_run). */
int ad_c_run_length(const pass *p, int group);

/* All elementwise groups of a program for tiles of `tile` points, one function for each run of
 * them, and a table `name` of the functions in the order of passes and groups. False: out of
 * memory. */
bool ad_c_write_groups(const ad_program *program, int tile, const char *name, FILE *file);

/* Which numbers of the workspace are read after each instruction (c_lives.c). */
typedef struct lives {
    bool *kept;    /* of all instructions' rows, one after the other: read after its segment */
    size_t *first; /* [instructions] in `kept` */
} lives;

/* `end`[instruction]: the instruction after the last of its segment. False: out of memory; clear it
 * all the same. */
bool ad_c_lives_create(const pass *p, const int *end, lives *l);
void ad_c_lives_clear(lives *l);

/* A number as C: exact, and a double. */
void ad_c_number(double number, FILE *file);

#endif
