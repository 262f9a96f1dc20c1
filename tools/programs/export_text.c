#include "tools/programs/export_text.h"

#include <string.h>

void export_put(const char *name, const char *type, const char *text, FILE *file)
{
    static const char model[] = "model_", number[] = "number";
    for (const char *next = strstr(text, model); next; next = strstr(text, model)) {
        const char *behind = next + strlen(model);
        const int typed = strncmp(behind, number, strlen(number)) == 0;
        fprintf(file, "%.*s%s%s", (int)(next - text), text, typed ? type : name, typed ? "" : "_");
        text = typed ? behind + strlen(number) : behind;
    }
    fputs(text, file);
}

void export_put_lines(const char *name, const char *type, const char *const *lines, FILE *file)
{
    for (; *lines; lines++) {
        export_put(name, type, *lines, file);
    }
}
