/* The elementwise groups of a program as machine code: written as C (c_groups.c), compiled while
 * the program goes on as it is. Both give the same bits, so it does not matter when the one takes
 * over.
 */
#include "autodiff/emit/c_code.h"

#include <stdlib.h>
#include <unistd.h>

#define OPTIONS "-O2 -fno-math-errno -ffp-contract=off"

void ad_fuse_clear(ad_program *program)
{
    ad_code_free(program->code);
    program->code = NULL;
    program->is_fused = false;
}

/* Functions of all runs of groups, in the order of c_groups.c. */
static void take(ad_program *program, const fused_groups *table)
{
    for (int s = 0; s < program->pass_count; s++) {
        pass *p = &program->passes[s];
        for (int g = 0; g < p->group_count; g++) {
            p->groups[g].fused_count = ad_c_run_length(p, g);
            if (p->groups[g].fused_count > 0) {
                p->groups[g].fused = *table++;
                g += p->groups[g].fused_count - 1;
            }
        }
    }
    program->is_fused = true;
}

ad_status ad_fuse_begin(ad_program *program, size_t points, size_t members, const char *folder,
                        bool compile, ad_error *error)
{
    const ad_code_settings how = {.options = OPTIONS, .folder = folder, .compile = compile};
    char *text = NULL;
    size_t size = 0;
    int way = compile ? 2 : 1;
    if (program->is_fused || program->fuse_begun >= way) {
        return AD_OK;
    }
    program->fuse_begun = way;
    if (!compile && access(folder, F_OK) != 0) {
        return AD_OK; /* nothing is kept: no text is needed to look for it */
    }
    for (int s = 0; s < program->pass_count; s++) {
        pass *p = &program->passes[s];
        p->fused_tile = ad_execute_tile(program, p, points, members);
    }
    FILE *file = open_memstream(&text, &size);
    bool ok = file && ad_c_write_groups(program, "ad_code_table", file);
    ok = file && fclose(file) == 0 && ok;
    ad_status status = ok ? ad_code_begin(text, size, &how, &program->code, error)
                          : ad_fail(error, AD_NO_MEMORY, "out of memory while writing C");
    free(text);
    return status;
}

ad_status ad_fuse_finish(ad_program *program, bool wait, ad_fuse_state *state, ad_error *error)
{
    const void *table = NULL;
    *state = program->is_fused ? AD_FUSED : AD_INTERPRETED;
    if (!program->code || program->is_fused) {
        return AD_OK;
    }
    ad_status status = ad_code_finish(program->code, wait, &table, error);
    if (status != AD_OK) {
        ad_fuse_clear(program);
    } else if (table) {
        take(program, table);
    }
    *state = program->is_fused ? AD_FUSED : program->code ? AD_FUSING : AD_INTERPRETED;
    return status;
}
