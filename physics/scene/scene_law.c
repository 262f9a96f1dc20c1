#include "physics/scene/scene_law.h"

#include "physics/law/law.h"
#include "physics/law/laws_lanes.h"

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

/* ---- the potential ------------------------------------------------------------------------- */

static law_name unit_of(scene_symmetry symmetry)
{
    return symmetry == SCENE_SYMMETRY_ROUND ? LAW_ROUND_UNIT : LAW_UNIT;
}

/* What it has by the features of one image: a unit there is one of other signs. */
static double sign_of(scene_symmetry symmetry, int image, int feature)
{
    return symmetry == SCENE_SYMMETRY_ROUND ? 1 : SIGNS[image][feature];
}

/* What the law of a unit under an image is given, [features + 2]; how many there are. */
static int unit_numbers(const scene_law *law, int unit, int image, double *numbers)
{
    const int features = scene_law_features(law->symmetry);
    for (int k = 0; k < features; k++) {
        numbers[k] = sign_of(law->symmetry, image, k) * law->by[unit][k];
    }
    numbers[features] = law->offset[unit];
    numbers[features + 1] = law->weight[unit] / images(law->symmetry);
    return features + 2;
}

/* What the units add up to: energy, gradient [N], second derivatives [LAW_STIFFNESS]. */
enum { UNIT_ROWS = 1 + N + LAW_STIFFNESS };

/* LANES units side by side, of which those that are missing weigh nothing. */
FOR_EACH_PROCESSOR static void add_units(const scene_law *law, const double *x,
                                         double sum[UNIT_ROWS])
{
    const int count = images(law->symmetry), all = law->units * count;
    lanes strains[N], rows[UNIT_ROWS] = {{0}};
    for (int i = 0; i < N; i++) {
        strains[i] = (lanes){0} + x[i];
    }
    for (int first = 0; first < all; first += LANES) {
        lanes given[LAW_NUMBERS_MAX] = {{0}};
        for (int i = first; i < all && i < first + LANES; i++) {
            double numbers[LAW_NUMBERS_MAX];
            const int numbered = unit_numbers(law, i / count, i % count, numbers);
            for (int k = 0; k < numbered; k++) {
                given[k][i - first] = numbers[k];
            }
        }
        if (unit_of(law->symmetry) == LAW_ROUND_UNIT) {
            lanes_law_round_unit_with_energy(strains, strains + 3, given, rows, rows + 1,
                                             rows + 1 + N);
        } else {
            lanes_law_unit_with_energy(strains, strains + 3, given, rows, rows + 1, rows + 1 + N);
        }
    }
    for (int row = 0; row < UNIT_ROWS; row++) {
        sum[row] = 0;
        for (int lane = 0; lane < LANES; lane++) {
            sum[row] += rows[row][lane];
        }
    }
}

/* N and its derivatives. */
static double network(const scene_law *law, const double *x, double gradient[N],
                      double (*second)[N])
{
    double of_units[UNIT_ROWS];
    add_units(law, x, of_units);
    for (int i = 0; i < N; i++) {
        const double c = law->quadratic[i];
        of_units[0] += 0.5 * c * x[i] * x[i];
        gradient[i] = of_units[1 + i] + c * x[i];
        for (int j = 0; j < N && second; j++) {
            second[i][j] = of_units[1 + N + law_entry(i, j)] + (i == j ? c : 0);
        }
    }
    return of_units[0];
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

/* The units are rows of each of their numbers. Their energy, too, where that is not NULL. */
static ad_value record_units(scene_symmetry symmetry, const scene_law_values *values, ad_value x,
                             ad_value *energy)
{
    const int features = scene_law_features(symmetry), count = images(symmetry);
    const int units = ad_rows(values->offset);
    ad_value sum = ad_mul(values->quadratic, x), given[LAW_GIVEN_MAX], rows[LAW_WRENCH], stored;
    if (energy) {
        *energy = ad_scale(ad_sum_rows(ad_mul(sum, x)), 0.5);
    }
    for (int i = 0; i < N; i++) {
        given[i] = ad_row(x, i);
    }
    given[N + features] = values->offset;
    given[N + features + 1] = ad_scale(values->weight, 1.0 / count);
    for (int g = 0; g < count; g++) {
        for (int k = 0; k < features; k++) {
            given[N + k] =
                ad_scale(ad_slice(values->by, k * units, units), sign_of(symmetry, g, k));
        }
        law_record(unit_of(symmetry), x.tape, given, energy ? &stored : NULL, rows, NULL);
        if (energy) {
            *energy = ad_add(*energy, ad_sum_rows(stored));
        }
        for (int i = 0; i < N; i++) {
            rows[i] = ad_sum_rows(rows[i]);
        }
        sum = ad_add(sum, ad_stack(N, rows));
    }
    return sum;
}

ad_value scene_law_record(scene_symmetry symmetry, const scene_law_values *values, ad_value x)
{
    return record_units(symmetry, values, x, NULL);
}

/* What takes dimensionless strains to x', dN/dx' back, and the stiffness to take off; by scales of
 * a rod. */
static void find_scales(const scene_law *law, double length, double force, double unit[N],
                        double back[N], double stiffness[N])
{
    for (int i = 0; i < N; i++) {
        const double own = i < 3 ? 1 : 1 / length;
        unit[i] = own / law->scale[i];
        back[i] = unit[i] / force;
        stiffness[i] = known_stiffness(law, i) * own * own / force;
    }
}

/* dN/dx' [6] at dimensionless strains, which are scaled by the way; N as above. */
static ad_value record_network(const scene_law *law, const double unit[N], ad_value x,
                               ad_value *scaled, ad_value *energy)
{
    const int features = scene_law_features(law->symmetry);
    double by[SCENE_LAW_UNITS_MAX * FEATURES];
    for (int u = 0; u < law->units; u++) {
        for (int k = 0; k < features; k++) {
            by[k * law->units + u] = law->by[u][k];
        }
    }
    const scene_law_values values = {ad_constant(x.tape, N, law->quadratic),
                                     ad_constant(x.tape, law->units, law->weight),
                                     ad_constant(x.tape, law->units, law->offset),
                                     ad_constant(x.tape, law->units * features, by)};
    *scaled = ad_mul(ad_constant(x.tape, N, unit), x);
    return record_units(law->symmetry, &values, *scaled, energy);
}

ad_value scene_law_record_beyond(const scene_law *law, double length, double force, ad_value x)
{
    double unit[N], back[N], stiffness[N];
    ad_value scaled;
    find_scales(law, length, force, unit, back, stiffness);
    ad_value stress =
        ad_sub(record_network(law, unit, x, &scaled, NULL), ad_constant(x.tape, N, law->slope));
    return ad_sub(ad_mul(ad_constant(x.tape, N, back), stress),
                  ad_mul(ad_constant(x.tape, N, stiffness), x));
}

ad_value scene_law_record_energy(const scene_law *law, double length, double force, ad_value x)
{
    double unit[N], back[N], stiffness[N];
    ad_value scaled, energy;
    find_scales(law, length, force, unit, back, stiffness);
    record_network(law, unit, x, &scaled, &energy);
    const ad_value along = ad_sum_rows(ad_mul(ad_constant(x.tape, N, law->slope), scaled));
    return ad_scale(ad_sub(ad_sub(energy, along), ad_scalar(x.tape, law->energy)), 1 / force);
}

void scene_law_record_places(const scene_law *law, double length, double force, const ad_value x[N],
                             ad_value stress[N], ad_value *by_strains)
{
    const int count = images(law->symmetry);
    double unit[N], back[N], stiffness[N], numbers[LAW_NUMBERS_MAX];
    ad_tape *tape = x[0].tape;
    ad_value given[LAW_GIVEN_MAX], slope[N], bend[LAW_STIFFNESS];
    find_scales(law, length, force, unit, back, stiffness);
    for (int i = 0; i < N; i++) {
        given[i] = ad_scale(x[i], unit[i]);
        stress[i] = ad_sub(ad_scale(given[i], law->quadratic[i]), ad_scalar(tape, law->slope[i]));
        for (int j = i; j < N; j++) {
            by_strains[law_entry(i, j)] = ad_scalar(tape, i == j ? law->quadratic[i] : 0);
        }
    }
    for (int i = 0; i < law->units * count; i++) {
        const int given_count = unit_numbers(law, i / count, i % count, numbers);
        for (int k = 0; k < given_count; k++) {
            given[N + k] = ad_scalar(tape, numbers[k]);
        }
        law_record(unit_of(law->symmetry), tape, given, NULL, slope, bend);
        for (int k = 0; k < N; k++) {
            stress[k] = ad_add(stress[k], slope[k]);
        }
        for (int k = 0; k < LAW_STIFFNESS; k++) {
            by_strains[k] = ad_add(by_strains[k], bend[k]);
        }
    }
    for (int i = 0; i < N; i++) {
        stress[i] = ad_sub(ad_scale(stress[i], back[i]), ad_scale(x[i], stiffness[i]));
        for (int j = i; j < N; j++) {
            ad_value *to = &by_strains[law_entry(i, j)];
            *to = ad_sub(ad_scale(*to, back[i] * unit[j]),
                         ad_scalar(tape, i == j ? stiffness[i] : 0));
        }
    }
}
