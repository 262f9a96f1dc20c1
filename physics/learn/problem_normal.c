/* The loss as a sum of squares: its Jacobian, as such, in normal equations or in products. */
#include "physics/learn/problem_internal.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ad_status problem_prepare_least_squares(problem *p, problem_least_squares *info, ad_error *error)
{
    if (p->model->motion) {
        return problem_motion_least_squares(p, info, error);
    }
    *info = (problem_least_squares){0};
    for (int i = 0; i < p->set_count; i++) {
        ad_status status = problem_set_prepare_normal(p, &p->sets[i], error);
        if (status != AD_OK) {
            return status;
        }
        size_t points = p->sets[i].trained.count;
        ad_normal_info normal = ad_normal_inspect(p->sets[i].normal, points);
        info->rows += normal.rows * points;
        info->inner = info->rows;
        info->bytes += normal.bytes;
        info->bytes += (size_t)p->sets[i].normal_fixed.rows * points * sizeof(double);
        info->slab_bytes += normal.slab_bytes;
    }
    return AD_OK;
}

static ad_status check(double loss, double entries, const double *jtr, size_t count,
                       ad_error *error)
{
    if (!isfinite(loss) || !isfinite(entries) || !vector_is_finite(count, jtr)) {
        return ad_fail(error, AD_NOT_FINITE, "the loss or its Jacobian is not finite");
    }
    return AD_OK;
}

ad_status problem_normal_equations(problem *p, const double *x, double *loss, double *jtj,
                                   double *jtr, ad_error *error)
{
    const size_t count = p->parameters;
    problem_least_squares info;
    ad_status status = problem_prepare_least_squares(p, &info, error);
    *loss = 0;
    memset(jtj, 0, count * count * sizeof *jtj);
    memset(jtr, 0, count * sizeof *jtr);
    for (int i = 0; status == AD_OK && i < p->set_count; i++) {
        if (p->model->motion) {
            status = problem_motion_normal(p, x, loss, jtj, jtr, error);
        } else if (!problem_is_held(p, &p->sets[i])) {
            status = problem_set_normal(&p->sets[i], x, loss, jtj, jtr, error);
        }
    }
    for (size_t k = problem_first_held(p); k < count; k++) {
        for (size_t i = 0; i <= k; i++) {
            jtj[i * count + k] = 0;
        }
        jtr[k] = 0;
    }
    double diagonal = 0; /* a column of J that is not finite shows here */
    for (size_t i = 0; i < count; i++) {
        diagonal += 0 * jtj[i * count + i];
    }
    return status == AD_OK ? check(*loss, diagonal, jtr, count, error) : status;
}

ad_status problem_noise_of(problem *p, const double *x, double *by_noise, problem_noise *noise,
                           ad_error *error)
{
    const size_t count = p->parameters;
    double *one = malloc((count + 1) * count * sizeof *one);
    ad_status status =
        one ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu parameters", count);
    *noise = (problem_noise){.numbers = 0};
    memset(by_noise, 0, count * count * sizeof *by_noise);
    for (int i = 0; i < p->set_count && status == AD_OK; i++) {
        problem_set *set = &p->sets[i];
        if (set->about->points != MODEL_GIVEN) {
            continue;
        }
        double loss = 0;
        memset(one, 0, (count + 1) * count * sizeof *one);
        status = problem_set_prepare_normal(p, set, error);
        status = status == AD_OK
                     ? problem_set_normal(set, x, &loss, one, one + count * count, error)
                     : status;
        const double points = (double)set->trained.count;
        const double variance = p->terms[set->terms[0]]->weight / points;
        if (status == AD_OK && variance > 0) {
            noise->variance = fmax(noise->variance, variance);
            noise->chi_squared += loss / variance;
            noise->numbers +=
                ad_normal_inspect(set->normal, set->trained.count).rows * set->trained.count;
            for (size_t k = 0; k < count * count; k++) {
                by_noise[k] += one[k] / variance;
            }
        }
    }
    free(one);
    return status;
}

ad_status problem_jacobian(problem *p, const double *x, double *loss, double *jt, double *r,
                           double *jtr, double *diagonal, ad_error *error)
{
    problem_least_squares info;
    ad_status status = problem_prepare_least_squares(p, &info, error);
    size_t first = 0;
    if (p->model->motion) {
        return ad_fail(error, AD_BAD_ARGUMENT, "the rows of a motion's Jacobian are not kept");
    }
    for (int i = 0; status == AD_OK && i < p->set_count; i++) {
        problem_set *set = &p->sets[i];
        status = problem_set_jacobian(set, x, first, info.rows, jt, r, error);
        const size_t rows =
            ad_normal_inspect(set->normal, set->trained.count).rows * set->trained.count;
        for (size_t k = first; status == AD_OK && problem_is_held(p, set) && k < first + rows;
             k++) {
            r[k] = 0;
            for (size_t column = 0; column < p->parameters; column++) {
                jt[column * info.rows + k] = 0;
            }
        }
        first += rows;
    }
    if (status != AD_OK) {
        return status;
    }
    double entries = 0;
    *loss = 0;
    for (size_t k = 0; k < info.rows; k++) {
        *loss += r[k] * r[k];
    }
    for (size_t i = problem_first_held(p); i < p->parameters; i++) {
        memset(jt + i * info.rows, 0, info.rows * sizeof *jt);
    }
    for (size_t i = 0; i < p->parameters; i++) {
        const double *column = jt + i * info.rows;
        jtr[i] = diagonal[i] = 0;
        for (size_t k = 0; k < info.rows; k++) {
            jtr[i] += column[k] * r[k];
            diagonal[i] += column[k] * column[k];
        }
        entries += 0 * diagonal[i];
    }
    return check(*loss, entries, jtr, p->parameters, error);
}

/* ---- outputs that separate ----------------------------------------------------------------- */

bool problem_separates(const problem *p, size_t *size, double *factors)
{
    const physics_model *m = p->model;
    if (!m->separate || m->term_count != 1 || p->set_count != 1 || p->sets[0].point_weights ||
        p->sets[0].balance) {
        return false;
    }
    const double count = (double)p->sets[0].trained.count;
    for (int i = 0; factors && i < m->outputs; i++) {
        factors[i] = m->separate[i] * sqrt(p->terms[0]->weight / count);
    }
    *size = (size_t)nn_mlp_features(p->mlp) + 1;
    return *size * (size_t)m->outputs == p->parameters;
}

ad_status problem_separate_matrix(problem *p, double *matrix, ad_error *error)
{
    const physics_model *m = p->model;
    const domain_uniforms none = {0};
    const problem_cloud *cloud = &p->sets[0].trained;
    const size_t size = (size_t)nn_mlp_features(p->mlp) + 1;
    const double *inputs[DOMAIN_COORDINATES_MAX];
    double *zeros = calloc(2 * size, sizeof *zeros), rtr = 0;
    ad_normal *normal = NULL;
    ad_tape *tape = ad_tape_create();
    ad_status status =
        tape && zeros ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for J^T J");
    if (status == AD_OK) {
        ad_value wrt[2];
        domain_place at = domain_record(&m->domain, &none, tape);
        ad_value y = nn_mlp_record_single(p->mlp, m->call.input(m, &at), wrt);
        status = ad_normal_compile(1, &y, 2, wrt, size, p->pool, &normal, error);
    }
    status = status == AD_OK ? problem_set_hold_all(&p->sets[0], error) : status;
    for (int i = 0; i < m->domain.count; i++) {
        inputs[i] = cloud->x + (size_t)i * cloud->count;
    }
    if (status == AD_OK) {
        const ad_run run = {.points = cloud->count, .inputs = inputs, .parameters = zeros};
        memset(matrix, 0, size * size * sizeof *matrix);
        status = ad_normal_add(normal, &run, matrix, zeros + size, &rtr, error);
    }
    double diagonal = 0;
    for (size_t i = 0; status == AD_OK && i < size; i++) {
        diagonal += matrix[i * size + i];
    }
    ad_normal_free(normal);
    ad_tape_free(tape);
    free(zeros);
    return status == AD_OK ? check(0, diagonal, NULL, 0, error) : status;
}

/* ---- products ------------------------------------------------------------------------------ */

ad_status problem_prepare_product(problem *p, problem_least_squares *info, ad_error *error)
{
    *info = (problem_least_squares){0};
    if (p->model->motion) {
        return ad_fail(error, AD_BAD_ARGUMENT, "matrix_free has no products of a motion's rows");
    }
    if (!p->pair) {
        p->pair = calloc(2 * p->parameters, sizeof *p->pair);
    }
    if (!p->pair) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for products with J^T J");
    }
    info->bytes = 2 * p->parameters * sizeof *p->pair;
    for (int i = 0; i < p->set_count; i++) {
        problem_set *set = &p->sets[i];
        ad_status status = problem_set_prepare_product(p, set, error);
        if (status != AD_OK) {
            return status;
        }
        info->rows += (size_t)set->product_rows * set->trained.count;
        info->bytes +=
            (size_t)ad_pool_threads(p->pool) * ad_program_inspect(set->product).workspace_bytes;
        info->bytes += (size_t)set->product_fixed.rows * set->trained.count * sizeof(double);
    }
    return AD_OK;
}

ad_status problem_normal_product(problem *p, const double *x, const double *v, double *product,
                                 ad_error *error)
{
    const size_t count = p->parameters;
    problem_least_squares info;
    ad_status status = problem_prepare_product(p, &info, error);
    if (status != AD_OK) {
        return status;
    }
    memcpy(p->pair, x, count * sizeof *x);
    memcpy(p->pair + count, v, count * sizeof *v);
    memset(product, 0, count * sizeof *product);
    memset(p->scratch, 0, count * sizeof *p->scratch);
    for (size_t k = problem_first_held(p); k < count; k++) {
        p->pair[count + k] = 0;
    }
    for (int i = 0; status == AD_OK && i < p->set_count; i++) {
        if (problem_is_held(p, &p->sets[i])) {
            continue;
        }
        status = problem_set_product(&p->sets[i], p->pair, p->scratch, error);
        for (size_t k = 0; k < problem_first_held(p); k++) {
            product[k] += p->scratch[k];
        }
    }
    if (status == AD_OK && !vector_is_finite(count, product)) {
        return ad_fail(error, AD_NOT_FINITE, "a product with the Jacobian is not finite");
    }
    return status;
}
