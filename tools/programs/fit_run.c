#include "tools/programs/fit_run.h"

#include "tools/programs/progress.h"
#include "tools/programs/signals.h"

#include <stdarg.h>
#include <stdlib.h>
#include <unistd.h>

ad_status fit_run_ask(fit_run *o, const config *settings, ad_error *error, const char *format, ...)
{
    size_t size;
    FILE *file = open_memstream(&o->text, &size);
    ad_status status = AD_OK;
    va_list arguments;
    if (file) {
        va_start(arguments, format);
        vfprintf(file, format, arguments);
        va_end(arguments);
        status = settings ? config_write(settings, file, false) : AD_OK;
    }
    return file && fclose(file) == 0 && status == AD_OK
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %s", o->program);
}

static ad_status write_text(void *context, FILE *file)
{
    return fputs(((const fit_run *)context)->text, file) < 0 ? AD_IO : AD_OK;
}

static ad_status run(void *context, least_squares *ls, ad_error *error)
{
    fit_run *o = context;
    const train_origin origin = {.context = o, .write = write_text};
    session s = {.fit = &ls->fit};
    run_folder folder = {.rows = NULL};
    ls->fit.origin = &origin;
    ad_status status = o->folder ? run_name(&folder, o->folder, error) : AD_OK;
    if (o->resume && !o->folder) {
        status = ad_fail(error, AD_BAD_INPUT, "--resume: allowed: with --run DIR");
    }
    if (status == AD_OK && !o->resume) {
        status = fit_start(&ls->fit, error);
    }
    if (status == AD_OK && o->folder) {
        signals_catch();
        status = session_begin(&s, &folder, o->resume, error);
    }
    if (status == AD_OK) {
        const bool speaks = !o->quiet && (o->folder || isatty(STDERR_FILENO));
        progress p = progress_start(stderr, !speaks, &ls->fit);
        status = progress_train(&p, &s, error);
        progress_clear(&p);
    }
    if (status == AD_OK && ls->fit.state == FIT_RUNNING) {
        o->signal = signals_caught();
        cli_warn(o->program, "stopped at step %lld and saved; --run %s --resume goes on",
                 (long long)s.saved_step, o->folder);
    }
    run_end(&folder);
    return status;
}

least_squares_runner fit_run_by(fit_run *o)
{
    return (least_squares_runner){run, o};
}

int fit_run_end(fit_run *o)
{
    free(o->text);
    o->text = NULL;
    return o->signal ? 128 + o->signal : 0;
}
