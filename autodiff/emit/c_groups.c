/* Elementwise groups as C: those that follow one another, between two matrix products, are one
 * function for tiles of points. */
#include "autodiff/emit/c_code.h"

#include <stdlib.h>

int ad_c_run_length(const pass *p, int group)
{
    int count = 0;
    while (group + count < p->group_count &&
           op_is_elementwise(p->instructions[p->groups[group + count].first].op)) {
        count++;
    }
    return count;
}

static void uniform_in_memory(const c_writer *w, place p, int row, char *text)
{
    (void)w;
    snprintf(text, C_OPERAND, row < 0 ? "%c[%d + r]" : "%c[%d]",
             p.kind == PLACE_UNIFORM ? 'u' : 'p', p.offset + (row < 0 ? 0 : row * p.stride));
}

static bool write_pass(c_writer *w, const pass *p, int *number)
{
    bool ok = ad_c_begin_pass(w, p);
    fprintf(w->file, "\n#undef TILE\n#define TILE %d\n", p->fused_tile);
    for (int g = 0; ok && g < p->group_count; g++) {
        int length = ad_c_run_length(p, g);
        if (length > 0) {
            const group *last = &p->groups[g + length - 1];
            fprintf(w->file,
                    "\nstatic void run_%d(double *restrict w, const double *restrict u, "
                    "const double *restrict p,\n    int points)\n{\n    (void)u, (void)p;\n",
                    (*number)++);
            ad_c_write_segments(w, p->groups[g].first, last->first + last->count);
            fputs("}\n", w->file);
            g += length - 1;
        }
    }
    ad_c_end_pass(w);
    return ok;
}

static void write_table(const char *name, int count, FILE *file)
{
    fprintf(file,
            "\ntypedef void run(double *restrict, const double *restrict, const double *restrict, "
            "int);\nextern run *const %s[];\nrun *const %s[] = {",
            name, name);
    for (int i = 0; i < count; i++) {
        fprintf(file, "%srun_%d,", i % 8 == 0 ? "\n    " : " ", i);
    }
    fputs("\n    0};\n", file);
}

bool ad_c_write_groups(const ad_program *program, const char *name, FILE *file)
{
    c_writer w = {.program = program, .file = file, .vectors = true, .type = "vec"};
    bool *known = ad_c_constants(program), ok = known != NULL;
    int count = 0;
    w.suffix = "";
    w.points = "for (int j = 0; j < points; j += LANES) ";
    w.uniform = uniform_in_memory;
    w.known = known;
    fputs(
        "/* Elementwise groups of a program: w is the workspace of a tile, u the values that are\n"
        " * the same at all points, p the parameters. */\n",
        file);
    ad_c_text(ad_text_stumpff, file);
    ad_c_text(ad_text_lanes, file);
    fputs("\n#define AT(unit)          (*(vec *)(w + (ptrdiff_t)(unit) * TILE + j))\n"
          "#define ROW(unit, stride) AT((unit) + r * (stride))\n",
          file);
    for (int s = 0; ok && s < program->pass_count; s++) {
        ok = write_pass(&w, &program->passes[s], &count);
    }
    write_table(name, count, file);
    free(known);
    return ok;
}
