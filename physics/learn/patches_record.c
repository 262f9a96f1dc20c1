/* The residuals of a set of points as a program of the derivatives of the fields.
 *
 * Fields are recorded as polynomials of x - p whose coefficients are inputs: their derivatives at
 * x. After p has become x, a residual and its derivatives by these inputs are what Gauss-Newton
 * needs, whatever the functions are that fields are made of. */
#include "physics/learn/patches_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void patch_jets_fill(patch_jets *jets, int dims)
{
    *jets = (patch_jets){.dims = dims};
    int order[PATCH_DIMS] = {0};
    for (int total = 0; total <= PATCH_ORDER; total++) {
        memset(order, 0, sizeof order);
        order[0] = total;
        for (bool more = true; more;) {
            for (int d = 0; d < dims; d++) {
                jets->order[jets->count][d] = (unsigned char)order[d];
            }
            jets->count++;
            /* the next composition of `total`, in descending order */
            int last = dims - 1, from = last - 1;
            const int rest = order[last];
            order[last] = 0;
            while (from >= 0 && order[from] == 0) {
                from--;
            }
            more = from >= 0;
            if (more) {
                order[from]--;
                order[from + 1] = rest + 1;
            }
        }
    }
}

int patch_jet_of(const patch_jets *jets, const int *order)
{
    for (int i = 0; i < jets->count; i++) {
        int same = 0;
        while (same < jets->dims && jets->order[i][same] == order[same]) {
            same++;
        }
        if (same == jets->dims) {
            return i;
        }
    }
    return 0;
}

void patch_law_clear(patch_law *law)
{
    free(law->weight);
    free(law->same);
    free(law->entries);
    free(law->uses);
    ad_program_free(law->program);
    *law = (patch_law){.rows = 0};
}

/* ---- the tape of a set ----------------------------------------------------------------------- */

typedef struct recording {
    const physics_model *m;
    const patch_jets *jets;
    domain_place at;
    ad_value p[PATCH_DIMS];
    ad_value *jet; /* [outputs][jets] */
    ad_value unknown[MODEL_UNKNOWNS_MAX];
    ad_value *outputs; /* of the program: rows, entries */
    int output_count;
} recording;

/* The field as its Taylor polynomial about p. */
static ad_value polynomial(const recording *r, int output)
{
    ad_value sum = r->jet[output * r->jets->count];
    for (int i = 1; i < r->jets->count; i++) {
        ad_value product = r->jet[output * r->jets->count + i];
        for (int d = 0; d < r->jets->dims; d++) {
            const ad_value step = ad_sub(r->at.x[d], r->p[d]);
            for (int k = 1; k <= r->jets->order[i][d]; k++) {
                product = ad_mul(product, ad_scale(step, 1.0 / k));
            }
        }
        sum = ad_add(sum, product);
    }
    return sum;
}

static void record_leaves(recording *r, const model_set *set)
{
    const physics_model *m = r->m;
    const int dims = r->jets->dims, outputs = m->outputs, jets = r->jets->count;
    ad_tape *tape = r->at.tape;
    char name[MODEL_NAME];
    for (int d = 0; d < dims; d++) {
        r->at.x[d] = ad_input(tape, m->domain.coordinates[d].name, 1);
    }
    for (int i = 0; i < outputs * jets; i++) {
        r->jet[i] = ad_input(tape, "derivative", 1);
    }
    for (int i = 0; i < m->own_unknown_count; i++) {
        snprintf(name, sizeof name, "%s", m->own_unknowns[i].name);
        r->unknown[i] = ad_input(tape, name, 1);
    }
    if (m->own_unknown_count > 0) {
        r->at.unknowns = ad_stack(m->own_unknown_count, r->unknown);
    }
    if (set->source.rows > 0) {
        r->at.data = ad_input(tape, "data", set->source.rows);
    }
    for (int d = 0; d < dims; d++) {
        r->p[d] = ad_input(tape, "about", 1);
    }
    const int time = m->domain.time;
    const domain_coordinate *t = &m->domain.coordinates[time < 0 ? 0 : time];
    r->at.over = &m->domain;
    r->at.start = ad_scalar(tape, time < 0 ? 0 : t->low);
    r->at.span = ad_scalar(tape, time < 0 ? 1 : t->high - t->low);
    r->at.load_factor = ad_scalar(tape, 1);
}

static bool is_same(ad_value x)
{
    return ad_extent_of(x) != AD_BATCH;
}

/* Derivatives of a row by the derivatives of the fields and by the unknowns, those that are not 0.
 */
static ad_status record_entries(recording *r, patch_law *law, int row, ad_error *error)
{
    const int jets = r->jets->count, outputs = r->m->outputs, all = outputs * jets;
    const int unknowns = r->m->own_unknown_count, wrt_count = all + unknowns;
    ad_value *wrt = malloc((size_t)wrt_count * sizeof *wrt);
    ad_value *by = malloc((size_t)wrt_count * sizeof *by);
    ad_status status = wrt && by ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    if (status == AD_OK) {
        memcpy(wrt, r->jet, (size_t)all * sizeof *wrt);
        memcpy(wrt + all, r->unknown, (size_t)unknowns * sizeof *wrt);
        /* a residual that is the same everywhere has no derivatives */
        status = is_same(r->outputs[row])
                     ? AD_OK
                     : ad_reverse(r->outputs[row], wrt_count, wrt, AD_PER_POINT, by);
        if (status != AD_OK) {
            ad_tape_status(r->at.tape, error);
        }
    }
    for (int i = 0; i < wrt_count && status == AD_OK && !is_same(r->outputs[row]); i++) {
        if (ad_is_constant(by[i], 0)) {
            continue;
        }
        const bool of_jet = i < all;
        law->entries[law->entry_count++] = (patch_entry){.row = row,
                                                         .output = of_jet ? i / jets : -1,
                                                         .jet = of_jet ? i % jets : i - all,
                                                         .same = is_same(by[i])};
        for (int k = 0; k < all && law->linear; k++) { /* in the fields */
            law->linear = !ad_uses(1, &by[i], wrt[k]);
        }
        if (of_jet) {
            law->uses[i] = true;
        }
        r->outputs[r->output_count++] = by[i];
    }
    free(wrt);
    free(by);
    return status;
}

/* What derivative is too high, or NULL. */
static const char *too_high(const patch_law *law, const recording *r)
{
    for (int i = 0; i < r->m->outputs * r->jets->count; i++) {
        int total = 0;
        for (int d = 0; d < r->jets->dims; d++) {
            total += r->jets->order[i % r->jets->count][d];
        }
        if (law->uses[i] && total == PATCH_ORDER) {
            return r->m->columns[i / r->jets->count].name;
        }
    }
    return NULL;
}

static ad_status record(recording *r, patch_law *law, int set, ad_pool *pool, ad_error *error)
{
    const physics_model *m = r->m;
    ad_value rows[PATCH_OUTPUTS], fields[MODEL_FIELDS_MAX];
    record_leaves(r, law->set);
    for (int i = 0; i < m->outputs; i++) {
        rows[i] = polynomial(r, i);
    }
    m->call.ansatz(m, &r->at, ad_stack(m->outputs, rows), fields);
    for (int i = 0; i < m->term_count; i++) {
        const model_term *term = &m->terms[i];
        if (term->set != set || term->weight == 0) {
            continue;
        }
        ad_value residual = term->residual(term->context, &r->at, fields);
        for (int d = 0; d < r->jets->dims; d++) {
            residual = ad_substitute(residual, r->p[d], r->at.x[d]);
        }
        if (!ad_is_valid(residual) || law->rows + ad_rows(residual) > PATCH_OUTPUTS) {
            return ad_tape_status(r->at.tape, error) != AD_OK
                       ? error->status
                       : ad_fail(error, AD_BAD_ARGUMENT, "%s: more than %d rows of residuals",
                                 law->set->name, PATCH_OUTPUTS);
        }
        for (int k = 0; k < ad_rows(residual); k++) {
            law->weight[law->rows] = term->weight;
            r->outputs[law->rows++] = ad_row(residual, k);
        }
    }
    r->output_count = law->rows;
    for (int i = 0; i < law->rows; i++) {
        law->same[i] = is_same(r->outputs[i]);
        ad_status status = record_entries(r, law, i, error);
        if (status != AD_OK) {
            return status;
        }
    }
    const char *high = too_high(law, r);
    return high ? ad_fail(error, AD_BAD_ARGUMENT,
                          "%s: a derivative of %s of order %d or more; allowed: up to %d",
                          law->set->name, high, PATCH_ORDER, PATCH_ORDER - 1)
                : ad_compile(r->output_count, r->outputs, NULL, pool, &law->program, error);
}

ad_status patch_law_create(const physics_model *m, int set, const patch_jets *jets, ad_pool *pool,
                           patch_law *law, ad_error *error)
{
    const size_t all = (size_t)m->outputs * (size_t)jets->count;
    const size_t most = PATCH_OUTPUTS * (all + MODEL_UNKNOWNS_MAX);
    recording r = {.m = m, .jets = jets, .at = {.tape = ad_tape_create()}};
    *law = (patch_law){.set = &m->sets[set],
                       .linear = true,
                       .weight = malloc(PATCH_OUTPUTS * sizeof *law->weight),
                       .same = malloc(PATCH_OUTPUTS * sizeof *law->same),
                       .entries = malloc(most * sizeof *law->entries),
                       .uses = calloc(all, sizeof *law->uses)};
    r.jet = malloc(all * sizeof *r.jet);
    r.outputs = malloc((PATCH_OUTPUTS + most) * sizeof *r.outputs);
    ad_status status =
        r.at.tape && law->weight && law->same && law->entries && law->uses && r.jet && r.outputs
            ? record(&r, law, set, pool, error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory for equations");
    free(r.jet);
    free(r.outputs);
    ad_tape_free(r.at.tape);
    if (status != AD_OK) {
        patch_law_clear(law);
    }
    return status;
}
