#include "tools/library/member_code.h"

#include "tools/emit/export_family.h"
#include "tools/train/trainer.h"

#include <math.h>
#include <stdlib.h>

struct member_code {
    ad_code *code;
    const export_family_table *table;
    double length;
    double *memory; /* [table->memory] */
};

/* The text that is compiled. */
static ad_status write_text(const experiment *e, size_t points, const double *s, export_text *text,
                            ad_error *error)
{
    const size_t nodes = solve_members_nodes(targets_solver(e->targets));
    const size_t count = (size_t)e->scene->parameter_count;
    const double length = scene_length(e->scene), unmeasured = NAN;
    double *room = malloc((points + EXPORT_JUDGED * (count + 3 * nodes)) * sizeof *room);
    double *parameters = room + points;
    export_family f = {.name = "member",
                       .shape_by = true,
                       .places = (int)points,
                       .s = room,
                       .columns = SOLVE_MEMBERS_COLUMNS,
                       .values = &unmeasured};
    ad_status status = export_text_open(text) && room
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        room[i] = fmin(s[i] / length, 1);
    }
    for (int c = 0; c < f.columns; c++) {
        f.which[c] = c;
    }
    if (status == AD_OK) {
        status = export_family_of(e, &f, parameters, parameters + EXPORT_JUDGED * count, error);
    }
    status = status == AD_OK ? export_family_write_code(&f, text->file, error) : status;
    if (!export_text_close(text) && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    }
    free(room);
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
    code->length = scene_length(e->scene);
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

static cpinn_reason reason_of(const member_code *code, int status, const double *said)
{
    return (status & EXPORT_SINGULAR) || !isfinite(said[EXPORT_LEFT]) ? CPINN_REASON_NOT_FINITE
           : said[EXPORT_STABLE] == 0                                 ? CPINN_REASON_UNSTABLE
           : said[EXPORT_PREDICTED] > SOLVE_TRUSTED * code->length    ? CPINN_REASON_TOO_FAR
           : said[EXPORT_TRUSTED] == 0                                ? CPINN_REASON_NOT_SETTLING
                                                                      : CPINN_REASON_NONE;
}

void member_code_answer(const member_code *code, int steps, const double *parameters,
                        double *values, double *jacobian, cpinn_answer *answer)
{
    double said[EXPORT_SAID];
    const int status = code->table->answer(parameters, steps, values, jacobian,
                                           answer ? said : NULL, code->memory);
    if (answer) {
        const cpinn_reason reason = reason_of(code, status, said);
        *answer = (cpinn_answer){.error = said[EXPORT_LEFT],
                                 .network_error = said[EXPORT_PREDICTED],
                                 .source = CPINN_FROM_NETWORK,
                                 .reason = reason,
                                 .trusted = reason == CPINN_REASON_NONE};
    }
}
