#include "tools/programs/export_text.h"

#include <stdbool.h>
#include <string.h>

static void put(const char *name, const char *type, bool single, const char *text, FILE *file)
{
    const struct {
        const char *word, *to, *behind;
        bool of_single;
    } words[] = {{"model_number", type, "", false}, {"model_", name, "_", false},
                 {"double ", "float ", "", true},   {"fabs(", "fabsf(", "", true},
                 {"sqrt(", "sqrtf(", "", true},     {"HUGE_VAL", "HUGE_VALF", "", true}};
    while (*text) {
        size_t i = 0;
        while (i < sizeof words / sizeof *words &&
               ((words[i].of_single && !single) ||
                strncmp(text, words[i].word, strlen(words[i].word)) != 0)) {
            i++;
        }
        if (i == sizeof words / sizeof *words) {
            fputc(*text++, file);
        } else {
            fprintf(file, "%s%s", words[i].to, words[i].behind);
            text += strlen(words[i].word);
        }
    }
}

void export_put(const char *name, const char *type, const char *text, FILE *file)
{
    put(name, type, false, text, file);
}

void export_put_single(const char *name, const char *text, FILE *file)
{
    put(name, "float", true, text, file);
}

void export_put_lines(const char *name, const char *type, const char *const *lines, FILE *file)
{
    for (; *lines; lines++) {
        export_put(name, type, *lines, file);
    }
}
