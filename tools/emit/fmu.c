#include "tools/emit/fmu_parts.h"

#include "tools/emit/export_compile.h"
#include "tools/files/checkpoint.h"
#include "tools/files/file_bytes.h"
#include "tools/files/zip.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>

/* For all machines of one kind, whichever their processor: without -march, and without contraction,
 * so that results are the same bits. */
#define OPTIONS "-std=c99 -O3 -fPIC -shared -fvisibility=hidden -ffp-contract=off -s"

enum { TOKEN = 17, NAME_MAX_LENGTH = 100, HEADER = 0, SOURCE, FUNCTIONS, SOURCES };

static ad_status check(const fmu_model *m, ad_error *error)
{
    int s = fmu_input(m, "s"), t = fmu_input(m, "t");
    if (strlen(m->name) > NAME_MAX_LENGTH) {
        return ad_fail(error, AD_BAD_ARGUMENT, "the name %.40s... is too long; allowed: %d letters",
                       m->name, NAME_MAX_LENGTH);
    }
    if (s < 0 || m->input_count != 1 + (t >= 0) || m->input_count > FMU_INPUTS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "this model has other inputs than s and t; an FMU needs a model of these");
    }
    if (m->place_count < 1 || m->place_count > FMU_PLACES_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%d places; allowed: 1 to %d", m->place_count,
                       FMU_PLACES_MAX);
    }
    for (int i = 0; i < m->place_count; i++) {
        if (!(m->places[i] >= m->inputs[s].lower && m->places[i] <= m->inputs[s].upper)) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "place %g m is outside the model; allowed: %g to %g m", m->places[i],
                           m->inputs[s].lower, m->inputs[s].upper);
        }
    }
    return AD_OK;
}

/* ---- texts ---------------------------------------------------------------------------------- */

/* NAME_fmi3.c: what fmi3_instance.h says that has to stand before it, and then that itself. */
static void put_functions(const fmu_model *m, FILE *file)
{
    double lower[FMU_INPUTS_MAX], upper[FMU_INPUTS_MAX];
    for (int i = 0; i < m->input_count; i++) {
        lower[i] = m->inputs[i].lower;
        upper[i] = m->inputs[i].upper;
    }
    fprintf(file,
            "#include \"%s.h\"\n\n"
            "#define FMU_EVAL     %s_eval\n"
            "#define FMU_JACOBIAN %s_jacobian\n"
            "#define FMU_MEMORY   %s_MEMORY\n"
            "#define FMU_INPUTS   %d\n"
            "#define FMU_OUTPUTS  %d\n"
            "#define FMU_PLACES   %d\n"
            "#define FMU_S        %d\n"
            "#define FMU_TIME     (%d)\n",
            m->name, m->name, m->name, m->name, m->input_count, m->output_count, m->place_count,
            fmu_input(m, "s"), fmu_input(m, "t"));
    export_put_array(file, (size_t)m->input_count, lower,
                     "static const double fmu_lower[FMU_INPUTS]");
    export_put_array(file, (size_t)m->input_count, upper,
                     "static const double fmu_upper[FMU_INPUTS]");
    export_put_array(file, (size_t)m->place_count, m->places,
                     "static const double fmu_start[FMU_PLACES]");
    export_put_lines(m->name, EXPORT_DOUBLE, fmu_text_fmi3_types, file);
    export_put_lines(m->name, EXPORT_DOUBLE, fmu_text_fmi3_instance, file);
    export_put_lines(m->name, EXPORT_DOUBLE, fmu_text_fmi3_functions, file);
}

/* The token tells this FMU from all others: a hash of everything that can make a difference. */
static bool make_functions(const fmu_model *m, export_text *functions, char token[TOKEN])
{
    export_text rest = {.bytes = NULL};
    bool ok = export_text_open(&rest);
    if (ok) {
        put_functions(m, rest.file);
        ok = export_text_close(&rest);
    }
    uint64_t hash = checkpoint_hash(CHECKPOINT_HASH_START, m->source, strlen(m->source));
    hash = checkpoint_hash(hash, m->header, strlen(m->header));
    hash = ok ? checkpoint_hash(hash, rest.bytes, rest.size) : 0;
    snprintf(token, TOKEN, "%016" PRIx64, hash);
    ok = ok && export_text_open(functions);
    if (ok) {
        fprintf(functions->file, "/* %s as an FMU of FMI 3.0. Made by %s. */\n", m->name, m->tool);
        fprintf(functions->file, "#define FMU_TOKEN \"%s\"\n%s", token, rest.bytes);
        ok = export_text_close(functions);
    }
    free(rest.bytes);
    return ok;
}

/* "x86_64-linux" as the standard names this machine; NULL: it has no name. */
static const char *platform_name(char text[64])
{
    struct utsname machine;
    if (uname(&machine) != 0) {
        return NULL;
    }
    const char *architecture = strcmp(machine.machine, "arm64") == 0 ? "aarch64" : machine.machine;
    const char *system = strcmp(machine.sysname, "Linux") == 0    ? "linux"
                         : strcmp(machine.sysname, "Darwin") == 0 ? "darwin"
                                                                  : NULL;
    static const char *const known[] = {"x86_64", "aarch64", "riscv64"};
    for (size_t i = 0; system && i < sizeof known / sizeof *known; i++) {
        if (strcmp(architecture, known[i]) == 0) {
            snprintf(text, 64, "%s-%s", known[i], system);
            return text;
        }
    }
    return NULL;
}

/* ".so" */
static const char *library_ending(void)
{
#ifdef __APPLE__
    return ".dylib";
#else
    return ".so";
#endif
}

/* ---- the archive ---------------------------------------------------------------------------- */

static void put_entry(zip *z, const char *folder, const char *name, const void *bytes, size_t size)
{
    char path[2 * ZIP_NAME];
    snprintf(path, sizeof path, "%.40s%.255s", folder, name);
    zip_begin(z, path);
    zip_put(z, bytes, size);
    zip_end(z);
}

static void put_library(zip *z, const fmu_model *m, const export_file *sources, bool *compiled,
                        char note[FMU_NOTE])
{
    char platform[64], name[ZIP_NAME];
    size_t size = 0;
    char *library = NULL;
    ad_error why = {.message = "FMI has no name for this machine"};
    if (platform_name(platform)) {
        const export_compiler cc = {"cc", OPTIONS, "-lm"};
        export_compile(&cc, SOURCES, sources, false, &library, &size, &why);
    }
    snprintf(note, FMU_NOTE, "%s", library ? "" : why.message);
    *compiled = library != NULL;
    if (library) {
        snprintf(name, sizeof name, "%s/%s%s", platform, m->name, library_ending());
        put_entry(z, "binaries/", name, library, size);
    }
    free(library);
}

/* The descriptions, sources and library as a zip archive, which has failed when memory runs out. */
static ad_status put_all(const fmu_model *m, const char *token, const export_file *sources, zip *z,
                         bool *compiled, char note[FMU_NOTE], ad_error *error)
{
    export_text description = {.bytes = NULL}, build = {.bytes = NULL};
    ad_status status = AD_OK;
    bool ok = export_text_open(&description);
    if (export_text_open(&build) && ok) {
        status = fmu_put_description(m, token, description.file, error);
        fmu_put_build_description(m, build.file);
    }
    z->failed = !export_text_close(&description);
    z->failed = !export_text_close(&build) || z->failed;
    if (status == AD_OK && !z->failed) {
        put_entry(z, "", "modelDescription.xml", description.bytes, description.size);
        put_entry(z, "sources/", "buildDescription.xml", build.bytes, build.size);
        for (int i = 0; i < SOURCES; i++) {
            put_entry(z, "sources/", sources[i].name, sources[i].text, sources[i].size);
        }
        put_library(z, m, sources, compiled, note);
    }
    free(description.bytes);
    free(build.bytes);
    return status;
}

ad_status fmu_write(const fmu_model *m, const char *path, bool *compiled, char note[FMU_NOTE],
                    ad_error *error)
{
    char token[TOKEN];
    export_text functions = {.bytes = NULL};
    zip z = {.bytes = NULL};
    unsigned char *bytes = NULL;
    size_t size = 0;
    *note = 0;
    *compiled = false;
    ad_status status = check(m, error);
    z.failed = status != AD_OK || !make_functions(m, &functions, token);
    if (!z.failed) {
        export_file sources[SOURCES] = {
            [HEADER] = {.text = m->header, .size = strlen(m->header)},
            [SOURCE] = {.text = m->source, .size = strlen(m->source)},
            [FUNCTIONS] = {.text = functions.bytes, .size = functions.size}};
        snprintf(sources[HEADER].name, sizeof sources->name, "%s.h", m->name);
        snprintf(sources[SOURCE].name, sizeof sources->name, "%s.c", m->name);
        snprintf(sources[FUNCTIONS].name, sizeof sources->name, "%s_fmi3.c", m->name);
        status = put_all(m, token, sources, &z, compiled, note, error);
    }
    free(functions.bytes);
    if (!zip_finish(&z, &bytes, &size) && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "%s: out of memory", file_bytes_shown(path));
    }
    if (status == AD_OK) {
        status = file_bytes_write(path, bytes, size, error);
    }
    free(bytes);
    return status;
}
