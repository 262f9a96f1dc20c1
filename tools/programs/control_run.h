/* What cpinn-control has of each loop that it runs, as text and tables. */
#ifndef TOOLS_PROGRAMS_CONTROL_RUN_H
#define TOOLS_PROGRAMS_CONTROL_RUN_H

#include "physics/scene/verdict.h"
#include "tools/config/config.h"
#include "tools/control/loop.h"
#include "tools/files/json.h"
#include "tools/surrogate/surrogate.h"

typedef struct control_row {
    const char *name; /* "linear model" */
    control_settings control;
    control_loop *loop; /* NULL: could not be run; `why` */
    loop_report report;
    ad_error why;
} control_row;

/* control_table.c */
void control_print_head(const config *of, const control_row *row, const char *model);
void control_print(int count, const control_row *rows);
void control_print_details(const control_row *row);
void control_json(int count, const control_row *rows, json *to);

/* control_files.c: the record as a table, and beside it NAME_shapes.h5 (loop_shapes, with the
 * radius of the plant). AD_BAD_ARGUMENT, AD_IO, AD_NO_MEMORY. */
ad_status control_write(const control_row *row, const scene *plant, const char *path,
                        ad_error *error);
ad_status control_write_shapes(const control_row *row, const scene *plant, const char *path,
                               ad_error *error);

/* control_export.c: filter and controller as OUT.c, OUT.h and OUT_selftest.c (export_loop.h), of a
 * loop that was run; trained models of the filter and the controller, NULL: none, which are
 * verified in rollouts; `found` is told where these diverge. AD_BAD_INPUT: it cannot be written;
 * AD_IO; errors of rollouts_judge, export_loop_record and export_texts_check. */
ad_status control_export(const config *of, const control_row *row, const char *model,
                         const surrogate *filter, const surrogate *controller, const char *out,
                         bool force, char said[256], verdict *found, ad_error *error);

#endif
