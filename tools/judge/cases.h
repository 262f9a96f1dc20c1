/* Cases, each by a network and by the solver: the table of cpinn-cases. */
#ifndef TOOLS_JUDGE_CASES_H
#define TOOLS_JUDGE_CASES_H

#include "tools/judge/judge.h"

typedef struct cases_row {
    char name[JUDGE_NAME]; /* of the case: that of its file */
    judge_method method;
    judge_row result;
} cases_row;

/* The table for people, as wide as the longest name. */
void cases_print_heading(FILE *file, int width);
/* before: the row above, or NULL; a case is named once. */
void cases_print_row(FILE *file, const cases_row *row, const cases_row *before, int width);

/* cases.csv and cases.h5. */
ad_status cases_write(const cases_row *rows, size_t count, const char *folder, ad_error *error);

#endif
