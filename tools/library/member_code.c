#include "tools/library/member_code.h"

#include "tools/emit/export_family.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <stdlib.h>

struct member_code {
    ad_code *code;
    const export_family_table *table;
    double *memory; /* [table->memory] */
};

/* The text that is compiled. */
static ad_status write_text(const experiment *e, size_t points, const double *s, export_text *text,
                            ad_error *error)
{
    double *numbers = NULL;
    export_family f = {.name = "member", .shape_by = true};
    ad_status status = export_text_open(text)
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    if (status == AD_OK) {
        status = export_family_at(e, SOLVE_MEMBERS_COLUMNS, (int)points, s, &f, &numbers, error);
    }
    status = status == AD_OK ? export_family_write_code(&f, text->file, error) : status;
    if (!export_text_close(text) && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    }
    free(numbers);
    return status;
}

static ad_status load(member_code *code, const export_text *text, ad_error *error)
{
    char folder[4096];
    const void *table = NULL;
    const ad_code_settings how = {
        .options = "-O3 -fno-math-errno", .folder = folder, .compile = true};
    if (!trainer_fuse_folder(folder, true)) {
        return ad_fail(error, AD_IO, "no folder for compiled C: neither XDG_CACHE_HOME nor HOME");
    }
    ad_status status = ad_code_begin(text->bytes, text->size, &how, &code->code, error);
    status = status == AD_OK ? ad_code_finish(code->code, true, &table, error) : status;
    if (status == AD_OK) {
        code->table = table;
        code->memory = malloc(code->table->memory * sizeof *code->memory);
    }
    return status != AD_OK || code->memory
               ? status
               : ad_fail(error, AD_NO_MEMORY, "out of memory for compiled C");
}

ad_status member_code_create(const experiment *e, size_t points, const double *s,
                             member_code **result, ad_error *error)
{
    export_text text = {.bytes = NULL};
    member_code *code = calloc(1, sizeof *code);
    *result = NULL;
    ad_status status =
        points > MEMBER_CODE_POINTS_MAX
            ? ad_fail(error, AD_BAD_ARGUMENT, "%zu points; allowed for compiled C: up to %d",
                      points, MEMBER_CODE_POINTS_MAX)
        : code ? write_text(e, points, s, &text, error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for compiled C");
    status = status == AD_OK ? load(code, &text, error) : status;
    free(text.bytes);
    if (status != AD_OK) {
        member_code_free(code);
        return status;
    }
    *result = code;
    return AD_OK;
}

void member_code_free(member_code *code)
{
    if (code) {
        ad_code_free(code->code);
        free(code->memory);
        free(code);
    }
}

void member_code_answer(const member_code *code, int steps, const double *parameters,
                        double *values, double *jacobian, cpinn_answer *answer)
{
    double said[EXPORT_SAID];
    code->table->answer(parameters, steps, values, jacobian, answer ? said : NULL, code->memory);
    if (answer) {
        const cpinn_reason reason = (cpinn_reason)said[EXPORT_WHY];
        *answer = (cpinn_answer){.error = said[EXPORT_LEFT],
                                 .network_error = said[EXPORT_PREDICTED],
                                 .source = CPINN_FROM_NETWORK,
                                 .reason = reason,
                                 .trusted = reason == CPINN_REASON_NONE};
    }
}
