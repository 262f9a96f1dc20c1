/* What a family depends on, in words. */
#include "tools/programs/explain.h"

#include <string.h>

enum { WIDTH = 96, INDENT = 6 };

/* A line of words, which goes on behind an indent. */
static void print_line(FILE *file, char *text)
{
    char *rest = NULL;
    int column = 1;
    fputc(' ', file);
    for (char *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
        const int length = (int)strlen(word);
        if (column + 1 + length > WIDTH) {
            fprintf(file, "\n%*s", INDENT - 1, "");
            column = INDENT - 1;
        }
        column += fprintf(file, " %s", word);
    }
    fputc('\n', file);
}

void explain_groups(FILE *file, const scene *family, const groups_settings *settings)
{
    groups *x;
    ad_error error = {.message = ""};
    char line[600];
    fputs("\nGroups, dimensionless numbers on which the shapes of the family depend\n", file);
    if (groups_find(family, settings, &x, &error) != AD_OK) {
        fprintf(file, "  %s\n", error.message);
        return;
    }
    for (int i = 0; groups_text(x, i, line, sizeof line); i++) {
        print_line(file, line);
    }
    groups_free(x);
}
