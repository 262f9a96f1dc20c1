/* The page: HTML, style and scripts of tools/show with the data in their places. */
#include "tools/programs/show.h"

#include "tools/files/file_bytes.h"

#include <stdlib.h>
#include <string.h>

static void put_lines(FILE *file, const char *const *lines)
{
    for (; *lines; lines++) {
        fputs(*lines, file);
    }
}

/* As text of an element, where < and & begin something else. */
static void put_escaped(FILE *file, const char *text)
{
    for (; *text; text++) {
        if (*text == '<' || *text == '&') {
            fputs(*text == '<' ? "&lt;" : "&amp;", file);
        } else {
            fputc(*text, file);
        }
    }
}

/* Within a script, which would end at "</script"; < stands in texts only. */
static void put_data(FILE *file, const char *text)
{
    for (const char *next; (next = strchr(text, '<')); text = next + 1) {
        fwrite(text, 1, (size_t)(next - text), file);
        fputs("\\u003c", file);
    }
    fputs(text, file);
}

/* What computes shapes, or draws tips, residuals or loops, is only where there are some. */
static void put_page(FILE *file, const char *title, const char *data)
{
    static const char *const nothing[] = {NULL};
    const bool is_live = strstr(data, "\"live\": {") != NULL,
               has_tips = strstr(data, "\"workspace\": {") != NULL,
               has_rows = strstr(data, "\"residuals\": {") != NULL,
               has_loop = strstr(data, "\"loop\": {") != NULL;
    for (const char *const *line = show_text_page; *line; line++) {
        if (strstr(*line, "<!--title-->")) {
            fputs("<title>", file);
            put_escaped(file, title);
            fputs("</title>\n", file);
        } else if (strstr(*line, "<!--style-->")) {
            put_lines(file, show_text_style);
            put_lines(file, has_rows ? show_text_measured : nothing);
        } else if (strstr(*line, "<!--data-->")) {
            put_data(file, data);
        } else if (strstr(*line, "<!--script-->")) {
            const char *const *const scripts[] = {show_text_vectors,
                                                  show_text_scene,
                                                  show_text_draw,
                                                  show_text_charts,
                                                  is_live ? show_text_live : nothing,
                                                  has_tips ? show_text_workspace : nothing,
                                                  has_rows ? show_text_residuals : nothing,
                                                  has_loop ? show_text_loop : nothing,
                                                  show_text_picture,
                                                  show_text_player,
                                                  show_text_main};
            for (size_t k = 0; k < sizeof scripts / sizeof *scripts; k++) {
                put_lines(file, scripts[k]);
            }
        } else {
            fputs(*line, file);
        }
    }
}

ad_status show_page(json *to, const char *title, const char *path, ad_error *error)
{
    char *data = NULL, *page = NULL;
    size_t size = 0, length = 0;
    ad_status status = json_take(to, &data, &size, error);
    FILE *file = status == AD_OK ? open_memstream(&page, &length) : NULL;
    if (file) {
        put_page(file, title, data);
    }
    if (status == AD_OK && (!file || fclose(file) != 0)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %s", file_bytes_shown(path));
    }
    status = status == AD_OK ? file_bytes_write(path, page, length, error) : status;
    free(page);
    free(data);
    return status;
}
