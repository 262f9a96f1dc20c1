#include "tools/emit/export_module.h"

#include "tools/emit/export_compile.h"
#include "tools/emit/export_family.h"
#include "tools/train/experiment.h"

#include <stdlib.h>

/* The three texts, the last of them what the module exports; <math.h>, which is also <string.h>. */
enum { MATH = EXPORT_TEXTS, FILES = MATH + 2 };

#define NAME    "rod"
#define REACHED 1e-9 /* m: the tip is there */

/* All numbers as one column. */
static ad_status record(const scene *of, int drawn, const export_drawn *list, ad_tape *tape,
                        ad_pool *pool, ad_program **program, ad_error *error)
{
    const ad_settings settings = ad_settings_default();
    const int count = of->parameter_count;
    quantity_binding bindings[2 + SCENE_PARAMETERS_MAX];
    const ad_value p = ad_input(tape, "p", count);
    ad_value *rows = malloc((size_t)drawn * sizeof *rows);
    if (!rows) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a module");
    }
    for (int k = 0; k < count; k++) {
        bindings[2 + k] = (quantity_binding){of->parameters[k].name, ad_row(p, k)};
    }
    bindings[1] = (quantity_binding){"t", ad_scalar(tape, 0)};
    for (int i = 0; i < drawn; i++) {
        bindings[0] = (quantity_binding){"s", ad_scalar(tape, list[i].s)};
        rows[i] = quantity_record(list[i].of, tape, 2 + count, bindings);
    }
    const ad_value all = ad_stack(drawn, rows);
    free(rows);
    return ad_compile(1, &all, &settings, pool, program, error);
}

static ad_status write_drawn(const scene *of, int drawn, const export_drawn *list, FILE *file,
                             ad_error *error)
{
    static const double *const no_parameters[] = {NULL}, *const *const no_uniforms[] = {NULL};
    const ad_c_options options = {.name = "drawn",
                                  .points = 1,
                                  .sets = 1,
                                  .parameters = no_parameters,
                                  .uniforms = no_uniforms,
                                  .internal = true};
    size_t workspace = 0;
    ad_program *program = NULL;
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_status status =
        tape && pool ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a module");
    if (status == AD_OK && drawn > 0) {
        status = record(of, drawn, list, tape, pool, &program, error);
    }
    if (status == AD_OK && drawn > 0) {
        status = ad_write_c(1, &program, &options, false, file, &workspace, error);
    }
    fprintf(file, "#define DRAWN %d\n#define WORKSPACE %zu\n", drawn, workspace);
    ad_program_free(program);
    ad_pool_free(pool);
    ad_tape_free(tape);
    return status;
}

/* The texts of the family but, in the place of the self-test, what the module exports. */
typedef struct page {
    export_family family;
    const scene *of;
    int drawn;
    const export_drawn *list;
} page;

static ad_status write_text(void *of, int which, FILE *file, ad_error *error)
{
    page *x = of;
    if (which == MATH) {
        export_put_lines(NAME, EXPORT_DOUBLE, export_module_math, file);
        return AD_OK;
    }
    if (which != EXPORT_SELFTEST) {
        return export_family_write(&x->family, which, file, error);
    }
    fputs("#include \"" NAME ".h\"\n\n", file);
    const ad_status status = write_drawn(x->of, x->drawn, x->list, file, error);
    fprintf(file, "#define WHOLE_FUNCTION static\n#define REACHED %.17g\n", REACHED);
    export_put_lines(NAME, EXPORT_DOUBLE, export_module_seek, file);
    export_put_lines(NAME, EXPORT_DOUBLE, export_module_functions, file);
    return status;
}

static ad_status compile(const export_text texts[MATH + 1], char **bytes, size_t *size,
                         ad_error *error)
{
    static const export_compiler clang = {
        "clang",
        "--target=wasm32 -msimd128 -mbulk-memory -O3 -w -ffreestanding -ffp-contract=off -nostdlib "
        "-Wl,--no-entry -Wl,--allow-undefined -Wl,--strip-all -Wl,-z,stack-size=1048576",
        NULL};
    static const char *const names[] = {NAME ".c", NAME ".h", NAME "_page.c", "math.h", "string.h"};
    export_file files[FILES];
    for (int i = 0; i < FILES; i++) {
        const export_text *of = &texts[i < MATH ? i : MATH];
        files[i] = (export_file){.text = of->bytes, .size = of->size};
        snprintf(files[i].name, sizeof files[i].name, "%s", names[i]);
    }
    return export_compile(&clang, FILES, files, false, bytes, size, error);
}

ad_status export_module_create(const experiment *e, int places, const double *s, int drawn,
                               const export_drawn *list, char **bytes, size_t *size,
                               ad_error *error)
{
    double *numbers = NULL;
    export_text texts[MATH + 1] = {{.bytes = NULL}};
    page x = {.family = {.name = NAME}, .of = e->scene, .drawn = drawn, .list = list};
    *bytes = NULL;
    ad_status status = export_family_at(e, STRAIN_COLUMNS, places, s, &x.family, &numbers, error);
    x.family.tip = true;
    for (int i = 0; i <= MATH && status == AD_OK; i++) {
        status = export_text_write(&texts[i], i, write_text, &x, error);
    }
    status = status == AD_OK ? compile(texts, bytes, size, error) : status;
    for (int i = 0; i <= MATH; i++) {
        free(texts[i].bytes);
    }
    free(numbers);
    return status;
}
