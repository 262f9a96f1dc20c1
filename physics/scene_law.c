#include "physics/scene_law.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N = SCENE_LAW_STRAINS, FEATURES = SCENE_LAW_FEATURES, HEAD = 2 + 4 * N };
_Static_assert(SCENE_LAW_NUMBERS_MAX == HEAD + SCENE_LAW_UNITS_MAX * (2 + FEATURES) + 1, "numbers");

const char *const *scene_symmetry_names(void)
{
    static const char *const names[] = {
#define TEXT(name, text) text,
        SCENE_SYMMETRY_LIST(TEXT)
#undef TEXT
            NULL};
    return names;
}

int scene_law_features(scene_symmetry symmetry)
{
    return symmetry == SCENE_SYMMETRY_ROUND ? FEATURES : N;
}

/* ---- symmetry ------------------------------------------------------------------------------ */

/* Signs of the strains under the identity, half a turn about d3, and mirrors across d1 and d2: a
 * mirror across d1 changes the sign of v_1 and, curvatures being axial vectors, of u_2 and u_3. */
static const double SIGNS[4][N] = {
    {1, 1, 1, 1, 1, 1}, {-1, -1, 1, -1, -1, 1}, {-1, 1, 1, 1, -1, -1}, {1, -1, 1, -1, 1, -1}};

static int images(scene_symmetry symmetry)
{
    return symmetry == SCENE_SYMMETRY_POINT ? 2 : symmetry == SCENE_SYMMETRY_MIRRORS ? 4 : 1;
}

/* Of the round features but the last x.M x/2 + (x_3 of the first). */
static void invariant_matrix(int feature, double M[N][N])
{
    memset(M, 0, N * sizeof *M);
    const double turned = feature == 4 ? 1 : feature == 5 ? -1 : 0;
    for (int i = 0; i < 2; i++) {
        M[i][i] = feature == 1 || turned != 0 ? 2 : 0;
        M[3 + i][3 + i] = feature == 2 || turned != 0 ? 2 : 0;
    }
    M[5][5] = feature == 3 ? 2 : 0;
    M[0][4] = M[4][0] = -2 * turned; /* J u = (-u_2, u_1) */
    M[1][3] = M[3][1] = 2 * turned;
}

/* And of the last, u_3 v.u. */
static void last_matrix(const double *x, double M[N][N])
{
    memset(M, 0, N * sizeof *M);
    for (int i = 0; i < 2; i++) {
        M[i][3 + i] = M[3 + i][i] = x[5];
        M[i][5] = M[5][i] = x[3 + i];
        M[3 + i][5] = M[5][3 + i] = x[i];
    }
}

/* The round features and their gradients. */
static void invariants(const double *x, double f[FEATURES], double slope[FEATURES][N])
{
    const double on[2] = {x[0] - x[4], x[1] + x[3]}, back[2] = {x[0] + x[4], x[1] - x[3]};
    const double along = x[0] * x[3] + x[1] * x[4];
    const double all[FEATURES] = {
        x[2],        x[0] * x[0] + x[1] * x[1],     x[3] * x[3] + x[4] * x[4],
        x[5] * x[5], on[0] * on[0] + on[1] * on[1], back[0] * back[0] + back[1] * back[1],
        x[5] * along};
    const double by[FEATURES][N] = {{0, 0, 1, 0, 0, 0},
                                    {2 * x[0], 2 * x[1], 0, 0, 0, 0},
                                    {0, 0, 0, 2 * x[3], 2 * x[4], 0},
                                    {0, 0, 0, 0, 0, 2 * x[5]},
                                    {2 * on[0], 2 * on[1], 0, 2 * on[1], -2 * on[0], 0},
                                    {2 * back[0], 2 * back[1], 0, -2 * back[1], 2 * back[0], 0},
                                    {x[5] * x[3], x[5] * x[4], 0, x[5] * x[0], x[5] * x[1], along}};
    memcpy(f, all, sizeof all);
    memcpy(slope, by, sizeof by);
}

/* ---- the potential ------------------------------------------------------------------------- */

/* log(1 + exp(z)), its derivative and the next. */
static double softplus(double z, double *first, double *second)
{
    const double e = exp(-fabs(z));
    *first = z > 0 ? 1 / (1 + e) : e / (1 + e);
    *second = e / ((1 + e) * (1 + e));
    return fmax(z, 0) + log1p(e);
}

/* Adds a log(1 + exp(z)) of all units, z = b + w.f, and the derivatives by f. */
static double add_units(const scene_law *law, double share, int features, const double *f,
                        double *by_f, double (*second)[FEATURES])
{
    double sum = 0;
    for (int u = 0; u < law->units; u++) {
        const double a = share * law->weight[u], *w = law->by[u];
        double z = law->offset[u], rise, bend;
        for (int k = 0; k < features; k++) {
            z += w[k] * f[k];
        }
        sum += a * softplus(z, &rise, &bend);
        for (int k = 0; k < features; k++) {
            by_f[k] += a * rise * w[k];
            for (int l = 0; l < features && second; l++) {
                second[k][l] += a * bend * w[k] * w[l];
            }
        }
    }
    return sum;
}

static double round_units(const scene_law *law, const double *x, double gradient[N],
                          double (*second)[N])
{
    double f[FEATURES], slope[FEATURES][N], M[N][N];
    double by_f[FEATURES] = {0}, bend[FEATURES][FEATURES] = {{0}};
    invariants(x, f, slope);
    const double sum = add_units(law, 1, FEATURES, f, by_f, second ? bend : NULL);
    for (int k = 0; k < FEATURES; k++) {
        for (int i = 0; i < N; i++) {
            gradient[i] += by_f[k] * slope[k][i];
        }
    }
    for (int k = 0; k < FEATURES && second; k++) {
        double along[N] = {0}; /* bend_k slope */
        for (int l = 0; l < FEATURES; l++) {
            for (int i = 0; i < N; i++) {
                along[i] += bend[k][l] * slope[l][i];
            }
        }
        if (k + 1 < FEATURES) {
            invariant_matrix(k, M);
        } else {
            last_matrix(x, M);
        }
        for (int i = 0; i < N; i++) {
            for (int j = 0; j < N; j++) {
                second[i][j] += slope[k][i] * along[j] + by_f[k] * M[i][j];
            }
        }
    }
    return sum;
}

static double linear_units(const scene_law *law, const double *x, double gradient[N],
                           double (*second)[N])
{
    const int count = images(law->symmetry);
    double sum = 0;
    for (int g = 0; g < count; g++) {
        double f[N], by_f[N] = {0}, bend[FEATURES][FEATURES] = {{0}};
        for (int i = 0; i < N; i++) {
            f[i] = SIGNS[g][i] * x[i];
        }
        sum += add_units(law, 1.0 / count, N, f, by_f, second ? bend : NULL);
        for (int i = 0; i < N; i++) {
            gradient[i] += SIGNS[g][i] * by_f[i];
            for (int j = 0; j < N && second; j++) {
                second[i][j] += SIGNS[g][i] * SIGNS[g][j] * bend[i][j];
            }
        }
    }
    return sum;
}

/* N and its derivatives. */
static double network(const scene_law *law, const double *x, double gradient[N],
                      double (*second)[N])
{
    double sum = 0;
    memset(gradient, 0, N * sizeof *gradient);
    if (second) {
        memset(second, 0, N * sizeof *second);
    }
    for (int i = 0; i < N; i++) {
        sum += 0.5 * law->quadratic[i] * x[i] * x[i];
        gradient[i] += law->quadratic[i] * x[i];
        if (second) {
            second[i][i] += law->quadratic[i];
        }
    }
    return sum + (law->symmetry == SCENE_SYMMETRY_ROUND ? round_units
                                                        : linear_units)(law, x, gradient, second);
}

/* W and its derivatives by x'. */
static double potential(const scene_law *law, const double *x, double gradient[N],
                        double (*second)[N])
{
    double value = network(law, x, gradient, second) - law->energy;
    for (int i = 0; i < N; i++) {
        value -= law->slope[i] * x[i];
        gradient[i] -= law->slope[i];
    }
    return value;
}

double scene_law_potential(const scene_law *law, const double *x, double stress[N],
                           double (*tangent)[N])
{
    double scaled[N];
    for (int i = 0; i < N; i++) {
        scaled[i] = x[i] / law->scale[i]; /* 0 of what is locked */
    }
    const double value = potential(law, scaled, stress, tangent);
    for (int i = 0; i < N; i++) {
        stress[i] /= law->scale[i];
        for (int j = 0; j < N && tangent; j++) {
            tangent[i][j] /= law->scale[i] * law->scale[j];
        }
    }
    return value;
}

/* What is left of a stiffness where the law knows it. */
static double known_stiffness(const scene_law *law, int i)
{
    return isfinite(law->scale[i]) ? law->stiffness[i] : 0;
}

double scene_law_beyond(const scene_law *law, double length, double force, const double *x,
                        double stress[N], double (*tangent)[N])
{
    double own[N], unit[N];
    for (int i = 0; i < N; i++) {
        unit[i] = i < 3 ? 1 : 1 / length;
        own[i] = x[i] * unit[i];
    }
    double value = scene_law_potential(law, own, stress, tangent);
    for (int i = 0; i < N; i++) {
        const double stiffness = known_stiffness(law, i);
        value -= 0.5 * stiffness * own[i] * own[i];
        stress[i] = (stress[i] - stiffness * own[i]) * unit[i] / force;
        for (int j = 0; j < N && tangent; j++) {
            tangent[i][j] = (tangent[i][j] - (i == j) * stiffness) * unit[i] * unit[j] / force;
        }
    }
    return value / force;
}

double scene_law_excess(const scene_law *law, const double *x, int *which)
{
    const bool round = law->symmetry == SCENE_SYMMETRY_ROUND;
    const bool signless = law->symmetry >= SCENE_SYMMETRY_MIRRORS;
    double worst = 0;
    for (int i = 0; i < N; i++) {
        double low = law->low[i], high = law->high[i], at = x[i];
        if (i != 2 && signless) {
            high = fmax(-low, high);
            low = -high;
        }
        if (i % 3 < 2 && round) {
            const int other = i % 3 == 0 ? i + 1 : i - 1;
            high = fmax(high, fmax(-law->low[other], law->high[other]));
            low = -high;
        }
        const double beyond = 2 * fmax(at - high, low - at) / (high - low);
        if (isfinite(law->scale[i]) && beyond > worst) {
            worst = beyond;
            *which = i;
        }
    }
    return worst;
}

/* ---- numbers ------------------------------------------------------------------------------- */

/* Without the misfit. */
static int count_needed(const scene_law *law)
{
    return HEAD + law->units * (2 + scene_law_features(law->symmetry));
}

int scene_law_count(const scene_law *law)
{
    return count_needed(law) + !isnan(law->misfit);
}

/* Where number `index` is; NULL: symmetry and units. */
static double *number_at(scene_law *law, int index)
{
    double *const rows[4] = {law->scale, law->quadratic, law->low, law->high};
    const int each = 2 + scene_law_features(law->symmetry);
    if (index < HEAD) {
        return index < 2 ? NULL : rows[(index - 2) / N] + (index - 2) % N;
    }
    const int unit = (index - HEAD) / each, entry = (index - HEAD) % each;
    return unit == law->units ? &law->misfit
           : entry == 0       ? &law->weight[unit]
           : entry == 1       ? &law->offset[unit]
                              : &law->by[unit][entry - 2];
}

void scene_law_numbers(const scene_law *law, double *numbers)
{
    scene_law copy = *law;
    numbers[0] = law->symmetry;
    numbers[1] = law->units;
    for (int i = 2; i < scene_law_count(law); i++) {
        numbers[i] = *number_at(&copy, i);
    }
}

void scene_law_name(const scene_law *law, int index, char name[32])
{
    static const char *const rows[] = {"scale", "quadratic", "low", "high"};
    static const char *const strains[] = {"v1", "v2", "v3", "u1", "u2", "u3"};
    const int each = 2 + scene_law_features(law->symmetry);
    const int unit = (index - HEAD) / each, entry = (index - HEAD) % each;
    if (index < HEAD) {
        snprintf(name, 32, "%s%s%s",
                 index == 0   ? "symmetry"
                 : index == 1 ? "units"
                              : rows[(index - 2) / N],
                 index < 2 ? "" : " ", index < 2 ? "" : strains[(index - 2) % N]);
    } else if (unit == law->units) {
        snprintf(name, 32, "misfit");
    } else if (entry < 2) {
        snprintf(name, 32, "unit %d %s", unit, entry == 0 ? "weight" : "offset");
    } else {
        snprintf(name, 32, "unit %d by %d", unit, entry - 2);
    }
}

static bool is_whole(double x, double low, double high)
{
    return x >= low && x <= high && x == floor(x);
}

ad_status scene_law_create(int count, const double *numbers, scene_law *law, ad_error *error)
{
    *law = (scene_law){.symmetry = SCENE_SYMMETRY_NONE, .misfit = NAN};
    if (count < HEAD || !is_whole(numbers[0], 0, SCENE_SYMMETRY_ROUND) ||
        !is_whole(numbers[1], 0, SCENE_LAW_UNITS_MAX)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "is no law; allowed: the numbers that cpinn-law writes, a symmetry of 0 to "
                       "%d and 0 to %d units first",
                       SCENE_SYMMETRY_ROUND, SCENE_LAW_UNITS_MAX);
    }
    law->symmetry = (scene_symmetry)numbers[0];
    law->units = (int)numbers[1];
    const int needed = count_needed(law);
    if (count != needed && count != needed + 1) {
        return ad_fail(error, AD_BAD_INPUT,
                       "has %d numbers; allowed: %d for %d units of this law, or its misfit beside",
                       count, needed, law->units);
    }
    for (int i = 2; i < count; i++) {
        const bool is_scale = i < 2 + N;
        *number_at(law, i) = numbers[i];
        if (isnan(numbers[i]) || (isinf(numbers[i]) && !is_scale) ||
            (is_scale && !(numbers[i] > 0)) || (i == needed && numbers[i] < 0)) {
            char name[32];
            scene_law_name(law, i, name);
            return ad_fail(error, AD_BAD_INPUT, "number '%s' is %g; allowed: a %s", name,
                           numbers[i],
                           is_scale      ? "positive number"
                           : i == needed ? "number from 0 on"
                                         : "finite number");
        }
    }
    return scene_law_finish(law, error);
}

void scene_law_stiffen(scene_law *law, double by)
{
    double *const all[] = {law->quadratic, law->slope, law->stiffness};
    for (int i = 0; i < N; i++) {
        for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
            all[k][i] *= by;
        }
    }
    for (int u = 0; u < law->units; u++) {
        law->weight[u] *= by;
    }
    law->energy *= by;
    law->misfit = 0;
}

ad_status scene_law_finish(scene_law *law, ad_error *error)
{
    static const double rest[N] = {0};
    double second[N][N];
    const bool round = law->symmetry == SCENE_SYMMETRY_ROUND;
    if (round &&
        (law->scale[0] != law->scale[1] || law->scale[3] != law->scale[4] ||
         law->quadratic[0] != law->quadratic[1] || law->quadratic[3] != law->quadratic[4])) {
        return ad_fail(error, AD_BAD_INPUT,
                       "is round, but differs along d1 and d2; allowed: scale and quadratic alike");
    }
    law->energy = network(law, rest, law->slope, second);
    for (int i = 0; i < N; i++) {
        const bool locked = isinf(law->scale[i]);
        law->stiffness[i] = locked ? INFINITY : second[i][i] / law->scale[i] / law->scale[i];
        if (!(law->stiffness[i] > 0)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "has the stiffness %g of strain %d of 6 at rest; allowed: > 0",
                           law->stiffness[i], i + 1);
        }
    }
    return AD_OK;
}

/* ---- on the tape --------------------------------------------------------------------------- */

static ad_value record_linear(scene_symmetry symmetry, const scene_law_values *values, ad_value x)
{
    const int count = images(symmetry);
    ad_value sum = ad_zeros(x.tape, N);
    for (int g = 0; g < count; g++) {
        ad_value signs = ad_constant(x.tape, N, SIGNS[g]);
        ad_value z = ad_add(ad_matvec(values->by, ad_mul(signs, x)), values->offset);
        ad_value rise = ad_mul(values->weight, ad_sigmoid(z));
        sum = ad_add(sum, ad_mul(signs, ad_matvec_transposed(values->by, rise)));
    }
    return ad_scale(sum, 1.0 / count);
}

static ad_value record_round(const scene_law_values *values, ad_value x)
{
    ad_value f[FEATURES], slope[FEATURES], zero = ad_zeros(x.tape, N);
    f[0] = ad_row(x, 2);
    slope[0] = ad_pad(ad_scalar(x.tape, 1), 2, N);
    for (int k = 1; k + 1 < FEATURES; k++) {
        double M[N][N];
        invariant_matrix(k, M);
        slope[k] = ad_matvec(ad_constant(x.tape, N * N, M[0]), x);
        f[k] = ad_scale(ad_dot(x, slope[k]), 0.5);
    }
    ad_value v = ad_slice(x, 0, 2), u = ad_slice(x, 3, 2), twist = ad_row(x, 5);
    ad_value along = ad_dot(v, u);
    f[FEATURES - 1] = ad_mul(twist, along);
    slope[FEATURES - 1] = ad_stack(
        4, (const ad_value[]){ad_mul(twist, u), ad_scalar(x.tape, 0), ad_mul(twist, v), along});
    ad_value z = ad_add(ad_matvec(values->by, ad_stack(FEATURES, f)), values->offset);
    ad_value all = ad_matvec_transposed(values->by, ad_mul(values->weight, ad_sigmoid(z))),
             sum = zero;
    for (int k = 0; k < FEATURES; k++) {
        sum = ad_add(sum, ad_mul(ad_row(all, k), slope[k]));
    }
    return sum;
}

ad_value scene_law_record(scene_symmetry symmetry, const scene_law_values *values, ad_value x)
{
    ad_value units = symmetry == SCENE_SYMMETRY_ROUND ? record_round(values, x)
                                                      : record_linear(symmetry, values, x);
    return ad_add(ad_mul(values->quadratic, x), units);
}

ad_value scene_law_record_beyond(const scene_law *law, double length, double force, ad_value x)
{
    const int features = scene_law_features(law->symmetry);
    double by[SCENE_LAW_UNITS_MAX * FEATURES], unit[N], back[N], stiffness[N];
    for (int u = 0; u < law->units; u++) {
        memcpy(by + u * features, law->by[u], (size_t)features * sizeof *by);
    }
    for (int i = 0; i < N; i++) {
        const double own = i < 3 ? 1 : 1 / length;
        unit[i] = own / law->scale[i];
        back[i] = unit[i] / force;
        stiffness[i] = known_stiffness(law, i) * own * own / force;
    }
    const scene_law_values values = {ad_constant(x.tape, N, law->quadratic),
                                     ad_constant(x.tape, law->units, law->weight),
                                     ad_constant(x.tape, law->units, law->offset),
                                     ad_constant(x.tape, law->units * features, by)};
    ad_value scaled = ad_mul(ad_constant(x.tape, N, unit), x);
    ad_value stress = ad_sub(scene_law_record(law->symmetry, &values, scaled),
                             ad_constant(x.tape, N, law->slope));
    return ad_sub(ad_mul(ad_constant(x.tape, N, back), stress),
                  ad_mul(ad_constant(x.tape, N, stiffness), x));
}
