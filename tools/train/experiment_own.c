#include "tools/train/experiment_own.h"

#include "tools/files/file_bytes.h"

#include <stdlib.h>
#include <string.h>

/* ---- as text ------------------------------------------------------------------------------- */

static void write_domain(const domain *d, FILE *file)
{
    for (int i = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        fprintf(file, "%s: {range: [%.17g, %.17g], unit: \"%s\", scale: %.17g%s}\n", c->name,
                c->low * c->scale, c->high * c->scale, c->unit, c->scale,
                i == d->time ? ", time: true" : "");
    }
}

static void write_physics(const physics_model *m, FILE *file)
{
    for (int i = 0; i < m->field_count; i++) {
        fprintf(file, "field %s: {rows: %d}\n", m->symbols[i], m->field_rows[i]);
    }
    for (int i = 0; i < m->term_count; i++) {
        fprintf(file, "term %s: {at: %s, weight: %.17g}\n", m->terms[i].name,
                m->sets[m->terms[i].set].name, m->terms[i].weight);
    }
}

static void write_network(const nn_mlp_settings *network, FILE *file)
{
    static const char *const activations[] = {
#define TEXT(name, text) text,
        NN_ACTIVATION_LIST(TEXT)
#undef TEXT
    };
    fputs("network: {hidden: [", file);
    for (int i = 0; i < network->hidden_count; i++) {
        fprintf(file, "%s%d", i ? ", " : "", network->hidden[i]);
    }
    fprintf(file, "], activation: %s, features: %d, degree: %d}\n",
            activations[network->activation], network->fourier_features, network->degree);
}

static void write_text(const experiment_own *own, FILE *file)
{
    write_domain(&own->model->domain, file);
    write_physics(own->model, file);
    write_network(&own->settings->network, file);
}

/* Allocated; NULL when memory runs out. */
static char *text_of(const experiment_own *own)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return NULL;
    }
    write_text(own, file);
    if (fclose(file) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

/* ---- compared ------------------------------------------------------------------------------ */

static ad_status compare(const char *path, const char *before, const char *now, ad_error *error)
{
    while (*before || *now) {
        const int old = (int)strcspn(before, "\n"), new = (int)strcspn(now, "\n");
        if (old != new || strncmp(before, now, (size_t)old) != 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: '%.*s' in the checkpoint, '%.*s' now; a run keeps its coordinates, "
                           "fields, terms and network",
                           file_bytes_shown(path), old < 150 ? old : 150, before,
                           new < 150 ? new : 150, now);
        }
        before += old + (before[old] == '\n');
        now += new + (now[new] == '\n');
    }
    return AD_OK;
}

static ad_status check_same(const experiment_own *own, const char *path, const char *text,
                            ad_error *error)
{
    char *now = text_of(own);
    ad_status status =
        now ? compare(path, text, now, error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory while comparing experiments");
    free(now);
    return status;
}

ad_status experiment_own_check(const experiment_own *own, const char *path, const checkpoint *file,
                               ad_error *error)
{
    const char *text;
    if (!checkpoint_has(file, "physics/text")) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: is not of physics of one's own; cpinn_open opens runs of scenes",
                       file_bytes_shown(path));
    }
    ad_status status = checkpoint_get_text(file, "physics/text", &text, error);
    return status == AD_OK ? check_same(own, path, text, error) : status;
}

/* ---- as an origin -------------------------------------------------------------------------- */

static ad_status write_all(void *context, FILE *file)
{
    write_text(context, file);
    return AD_OK;
}

static ad_status continues(void *context, const char *path, const char *text, int64_t stage,
                           ad_error *error)
{
    (void)stage; /* later stages may be others */
    return check_same(context, path, text, error);
}

train_origin experiment_own_origin(experiment_own *own)
{
    return (train_origin){.context = own, .write = write_all, .continues = continues};
}
