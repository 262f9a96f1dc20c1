#include "physics/law/law.h"

/* ---- vectors ------------------------------------------------------------------------------- */

static ad_value dot(const ad_value a[3], const ad_value b[3])
{
    return ad_add(ad_add(ad_mul(a[0], b[0]), ad_mul(a[1], b[1])), ad_mul(a[2], b[2]));
}

static void cross(const ad_value a[3], const ad_value b[3], ad_value result[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        result[i] = ad_sub(ad_mul(a[j], b[k]), ad_mul(a[k], b[j]));
    }
}

static ad_value length(const ad_value x[3])
{
    return ad_sqrt(dot(x, x));
}

/* R x = x + 2 (w p x x + p x (p x x)) of q = (w, p) */
static void rotate(const ad_value q[4], const ad_value x[3], ad_value result[3])
{
    ad_value once[3], twice[3];
    cross(q + 1, x, once);
    cross(q + 1, once, twice);
    for (int i = 0; i < 3; i++) {
        result[i] = ad_add(x[i], ad_scale(ad_add(ad_mul(q[0], once[i]), twice[i]), 2));
    }
}

/* ---- within the rod ------------------------------------------------------------------------ */

/* p' = v + u x r + r' of a line at r = (x, y, 0) in the section; a: x, y, x', y'. */
static void record_path(const ad_value *v, const ad_value *u, const ad_value *a, ad_value path[3])
{
    path[0] = ad_add(ad_sub(v[0], ad_mul(u[2], a[1])), a[2]);
    path[1] = ad_add(ad_add(v[1], ad_mul(u[2], a[0])), a[3]);
    path[2] = ad_sub(ad_add(v[2], ad_mul(u[0], a[1])), ad_mul(u[1], a[0]));
}

static void record_tendon(const ad_value *given, ad_value *energy)
{
    ad_value path[3];
    record_path(given, given + 3, given + 6, path);
    *energy = ad_mul(given[10], length(path));
}

static void record_chamber(const ad_value *given, ad_value *energy)
{
    ad_value path[3];
    record_path(given, given + 3, given + 6, path);
    *energy = ad_mul(given[10], path[2]);
}

/* a log(1 + exp(z)), z = b + w . f; w, b, a */
static ad_value unit(int features, const ad_value *f, const ad_value *w)
{
    const ad_value *b = w + features, *a = b + 1;
    ad_value z = *b;
    for (int k = 0; k < features; k++) {
        z = ad_add(z, ad_mul(w[k], f[k]));
    }
    return ad_mul(*a, ad_log(ad_add(ad_scalar(z.tape, 1), ad_exp(z))));
}

static void record_unit(const ad_value *given, ad_value *energy)
{
    *energy = unit(LAW_WRENCH, given, given + LAW_WRENCH);
}

static void record_round_unit(const ad_value *given, ad_value *energy)
{
    const ad_value *v = given, *u = given + 3;
    const ad_value on[2] = {ad_sub(v[0], u[1]), ad_add(v[1], u[0])};
    const ad_value back[2] = {ad_add(v[0], u[1]), ad_sub(v[1], u[0])};
    const ad_value *const squared[4] = {v, u, on, back};
    ad_value f[7] = {[0] = v[2], [3] = ad_square(u[2])};
    for (int k = 0; k < 4; k++) {
        const ad_value *x = squared[k];
        f[k < 2 ? 1 + k : 2 + k] = ad_add(ad_square(x[0]), ad_square(x[1]));
    }
    f[6] = ad_mul(u[2], ad_add(ad_mul(v[0], u[0]), ad_mul(v[1], u[1])));
    *energy = unit(7, f, given + LAW_WRENCH);
}

/* K_1, K_2, k, c */
static void record_tube(const ad_value *given, ad_value *energy)
{
    const ad_value *u = given, c = given[3], s = given[4], m = given[5], *K = given + 6, *k = K + 2;
    const ad_value strained[2] = {ad_sub(ad_add(ad_mul(c, u[0]), ad_mul(s, u[1])), k[0]),
                                  ad_sub(ad_sub(ad_mul(c, u[1]), ad_mul(s, u[0])), k[1])};
    ad_value twice = ad_neg(ad_mul(k[3], ad_square(m)));
    for (int i = 0; i < 2; i++) {
        twice = ad_add(twice, ad_mul(K[i], ad_square(strained[i])));
    }
    *energy = ad_add(ad_scale(twice, 0.5), ad_mul(m, ad_sub(u[2], k[2])));
}

static void record_squares(const ad_value *given, ad_value *energy)
{
    ad_value twice = ad_mul(given[LAW_WRENCH], ad_square(given[0]));
    for (int i = 1; i < LAW_WRENCH; i++) {
        twice = ad_add(twice, ad_mul(given[LAW_WRENCH + i], ad_square(given[i])));
    }
    *energy = ad_scale(twice, 0.5);
}

/* mu, c */
static void record_friction(const ad_value *given, ad_value *energy)
{
    const ad_value *w = given + 3, *numbers = given + LAW_WRENCH;
    const ad_value speed = ad_sqrt(ad_add(ad_square(w[0]), ad_square(numbers[1])));
    *energy = ad_mul(numbers[0], ad_mul(length(given), speed));
}

/* ---- outside ------------------------------------------------------------------------------- */

enum { ROTATION = 3, VELOCITY = 7, NUMBERS = LAW_STATE };

/* sum_i k_i x_i^2/2 */
static ad_value elastic(const ad_value k[3], const ad_value x[3])
{
    const ad_value square[3] = {ad_square(x[0]), ad_square(x[1]), ad_square(x[2])};
    return ad_scale(dot(k, square), 0.5);
}

/* shift, k, place */
static void record_spring(const ad_value *given, ad_value *energy)
{
    const ad_value *shift = given + NUMBERS, *k = shift + 3, *place = k + 3;
    ad_value off[3];
    for (int i = 0; i < 3; i++) {
        off[i] = ad_sub(ad_sub(given[i], place[i]), shift[i]);
    }
    *energy = elastic(k, off);
}

/* p* q */
static void quotient(const ad_value p[4], const ad_value q[4], ad_value result[4])
{
    ad_value between[3];
    cross(p + 1, q + 1, between);
    result[0] = ad_add(ad_mul(p[0], q[0]), dot(p + 1, q + 1));
    for (int i = 0; i < 3; i++) {
        result[1 + i] = ad_sub(ad_mul(p[0], q[1 + i]), ad_mul(p[1 + i], q[0]));
        result[1 + i] = ad_sub(result[1 + i], between[i]);
    }
}

/* The rotation vector of a unit quaternion, on from 0 to a whole turn. The angle is halved four
 * times, and there the series of asin(y)/y is short; nothing is divided by the angle. */
static void rotation_vector(const ad_value p[4], ad_value phi[3])
{
    enum { HALVINGS = 4, TERMS = 13 };
    double coefficient[TERMS] = {1}; /* in y^2 */
    ad_tape *tape = p[0].tape;
    ad_value w = p[0], by = ad_scalar(tape, 1);
    for (int n = 1; n < TERMS; n++) {
        const double odd = 2 * n - 1;
        coefficient[n] = coefficient[n - 1] * odd * odd / (2 * n * (2 * n + 1));
    }
    for (int i = 0; i < HALVINGS; i++) { /* y = sin b of half the angle, w = cos b */
        w = ad_sqrt(ad_scale(ad_add(ad_scalar(tape, 1), w), 0.5));
        by = ad_mul(by, ad_reciprocal(ad_scale(w, 2)));
    }
    const ad_value square = ad_mul(dot(p + 1, p + 1), ad_square(by));
    ad_value sum = ad_scalar(tape, coefficient[TERMS - 1]);
    for (int n = TERMS - 2; n >= 0; n--) {
        sum = ad_add(ad_scalar(tape, coefficient[n]), ad_mul(square, sum));
    }
    by = ad_scale(ad_mul(by, sum), 2 << HALVINGS);
    for (int i = 0; i < 3; i++) {
        phi[i] = ad_mul(by, p[1 + i]);
    }
}

/* k, upright */
static void record_turning_spring(const ad_value *given, ad_value *energy)
{
    const ad_value *k = given + NUMBERS;
    ad_value turned[4], phi[3];
    quotient(k + 3, given + ROTATION, turned);
    rotation_vector(turned, phi);
    *energy = elastic(k, phi);
}

/* c_1, c_2 */
static void record_resistance(const ad_value *given, ad_value *wrench)
{
    const ad_value *V = given + VELOCITY, *c = given + NUMBERS;
    const ad_value by = ad_neg(ad_add(c[0], ad_mul(c[1], length(V))));
    for (int i = 0; i < 3; i++) {
        wrench[i] = ad_mul(by, V[i]);
    }
}

/* f */
static void record_force(const ad_value *given, ad_value *energy)
{
    *energy = ad_neg(dot(given + NUMBERS, given));
}

/* l */
static void record_moment(const ad_value *given, ad_value *wrench)
{
    for (int i = 0; i < 3; i++) {
        wrench[3 + i] = given[NUMBERS + i];
    }
}

static void record_follower_force(const ad_value *given, ad_value *wrench)
{
    rotate(given + ROTATION, given + NUMBERS, wrench);
}

static void record_follower_moment(const ad_value *given, ad_value *wrench)
{
    rotate(given + ROTATION, given + NUMBERS, wrench + 3);
}

/* along, across: c_1, c_2, c_3 of each */
static void record_slender_drag(const ad_value *given, ad_value *wrench)
{
    const ad_value *q = given + ROTATION, *V = given + VELOCITY, *c = given + NUMBERS;
    const ad_value zero = ad_scalar(V[0].tape, 0), axis[3] = {zero, zero, ad_scalar(V[0].tape, 1)};
    ad_value d3[3], part[2][3];
    rotate(q, axis, d3);
    const ad_value along = dot(d3, V);
    for (int i = 0; i < 3; i++) {
        part[0][i] = ad_mul(along, d3[i]);
        part[1][i] = ad_sub(V[i], part[0][i]);
    }
    for (int k = 0; k < 2; k++, c += 3) {
        const ad_value speed = length(part[k]);
        ad_value by = ad_add(c[0], ad_mul(c[1], ad_sqrt(speed)));
        by = ad_add(by, ad_mul(c[2], speed));
        for (int i = 0; i < 3; i++) {
            wrench[i] = ad_sub(wrench[i], ad_mul(by, part[k][i]));
        }
    }
}

/* B, m */
static void record_magnet(const ad_value *given, ad_value *energy)
{
    ad_value m[3];
    rotate(given + ROTATION, given + NUMBERS + 3, m);
    *energy = ad_neg(dot(m, given + NUMBERS));
}

/* G as xx, yy, xy, xz, yz, for a field without curl and divergence; m */
static void record_magnet_gradient(const ad_value *given, ad_value *energy)
{
    const ad_value *G = given + NUMBERS, zz = ad_neg(ad_add(G[0], G[1]));
    const ad_value rows[3][3] = {{G[0], G[2], G[3]}, {G[2], G[1], G[4]}, {G[3], G[4], zz}};
    const ad_value B[3] = {dot(rows[0], given), dot(rows[1], given), dot(rows[2], given)};
    ad_value m[3];
    rotate(given + ROTATION, G + 5, m);
    *energy = ad_neg(dot(m, B));
}

/* ---- of motion ----------------------------------------------------------------------------- */

/* J */
static void record_rotary_inertia(const ad_value *given, ad_value *energy)
{
    *energy = elastic(given + LAW_MOVING, given + 3);
}

/* S; J_23, J_13, J_12 */
static void record_eccentricity(const ad_value *given, ad_value *energy)
{
    const ad_value *V = given, *w = given + 3, *S = given + LAW_MOVING, *J = S + 3;
    ad_value of_centre[3], sum = ad_zeros(given->tape, 1);
    cross(w, S, of_centre);
    for (int i = 0; i < 3; i++) {
        const ad_value turns = ad_mul(J[i], ad_mul(w[(i + 1) % 3], w[(i + 2) % 3]));
        sum = ad_add(sum, ad_add(ad_mul(V[i], of_centre[i]), turns));
    }
    *energy = sum;
}

/* c */
static void record_added_mass(const ad_value *given, ad_value *energy)
{
    const ad_value across = ad_add(ad_square(given[0]), ad_square(given[1]));
    *energy = ad_scale(ad_mul(given[LAW_MOVING], across), 0.5);
}

/* ---- the laws ------------------------------------------------------------------------------ */

const law law_table[LAW_COUNT] = {
    [LAW_TENDON] = {.name = "tendon",
                    .about = "A tendon: pull |p'|, p' = v + u x r + r'; x, y, x', y', pull.",
                    .state = LAW_WITHIN,
                    .kind = LAW_LOADS,
                    .numbers = 5,
                    .has_energy = true,
                    .couples = true,
                    .record = record_tendon},
    [LAW_CHAMBER] = {.name = "chamber",
                     .about = "A fluid chamber: pull p'_3; x, y, x', y', pull.",
                     .state = LAW_WITHIN,
                     .kind = LAW_LOADS,
                     .numbers = 5,
                     .has_energy = true,
                     .record = record_chamber},
    [LAW_UNIT] = {.name = "unit",
                  .about = "A unit of a learned law: a log(1 + exp(b + w . (v, u))); w, b, a.",
                  .state = LAW_WITHIN,
                  .kind = LAW_STORES,
                  .numbers = 8,
                  .has_energy = true,
                  .couples = true,
                  .record = record_unit},
    [LAW_ROUND_UNIT] = {.name = "round_unit",
                        .about =
                            "A unit of a law that is round: a log(1 + exp(b + w . f)), f seven "
                            "invariants of v, u; w, b, a.",
                        .state = LAW_WITHIN,
                        .kind = LAW_STORES,
                        .numbers = 9,
                        .has_energy = true,
                        .couples = true,
                        .record = record_round_unit},
    [LAW_TUBE] = {.name = "tube",
                  .about = "A tube around the rod: K (w - k)^2/2 + m (u_3 - k_3) - c m^2/2, w of u "
                           "turned back by theta; u, cos, sin, m; K_1, K_2, k, c.",
                  .state = LAW_TURNED,
                  .kind = LAW_STORES,
                  .numbers = 6,
                  .has_energy = true,
                  .couples = true,
                  .record = record_tube},
    [LAW_ELASTIC] = {.name = "elastic",
                     .about = "A section: k x^2/2 of strains beyond those at rest; k.",
                     .state = LAW_WITHIN,
                     .kind = LAW_STORES,
                     .numbers = 6,
                     .has_energy = true,
                     .record = record_squares},
    [LAW_DAMPING] = {.name = "damping",
                     .about = "Damping of the material: b x^2/2 of rates of strain; b.",
                     .state = LAW_WITHIN,
                     .kind = LAW_DISSIPATES,
                     .numbers = 6,
                     .has_energy = true,
                     .record = record_squares},
    [LAW_FRICTION] = {.name = "friction",
                      .about =
                          "A tendon in its guides, per tension: mu |t_s| sqrt(w^2 + c^2), t_s in "
                          "place of v, w of u_1; mu, c.",
                      .state = LAW_WITHIN,
                      .kind = LAW_DISSIPATES,
                      .numbers = 2,
                      .has_energy = true,
                      .couples = true,
                      .record = record_friction},
    [LAW_SPRING] = {.name = "spring",
                    .about = "A spring, or a foundation: k (r - place - shift)^2/2; "
                             "shift, k, place.",
                    .kind = LAW_STORES,
                    .numbers = 9,
                    .shares = 3,
                    .has_energy = true,
                    .along_axes = true,
                    .by_position = true,
                    .has_force = true,
                    .record = record_spring},
    [LAW_TURNING_SPRING] = {.name = "turning_spring",
                            .about = "A spring that turns: k phi^2/2 from upright on; k, upright.",
                            .kind = LAW_STORES,
                            .numbers = 7,
                            .has_energy = true,
                            .by_rotation = true,
                            .has_moment = true,
                            .record = record_turning_spring},
    [LAW_RESISTANCE] = {.name = "resistance",
                        .about = "What surrounds the rod: -(c_1 + c_2 |V|) V; c_1, c_2.",
                        .kind = LAW_DISSIPATES,
                        .numbers = 2,
                        .by_velocity = true,
                        .has_force = true,
                        .record = record_resistance},
    [LAW_FORCE] = {.name = "force",
                   .about = "A dead force: -f . r; f.",
                   .kind = LAW_LOADS,
                   .numbers = 3,
                   .shares = 3,
                   .has_energy = true,
                   .has_force = true,
                   .record = record_force},
    [LAW_MOMENT] = {.name = "moment",
                    .about = "A dead moment; l.",
                    .kind = LAW_LOADS,
                    .numbers = 3,
                    .shares = 3,
                    .has_moment = true,
                    .record = record_moment},
    [LAW_FOLLOWER_FORCE] = {.name = "follower_force",
                            .about = "A force that turns with the rod: R f; f.",
                            .kind = LAW_LOADS,
                            .numbers = 3,
                            .shares = 3,
                            .by_rotation = true,
                            .has_force = true,
                            .record = record_follower_force},
    [LAW_FOLLOWER_MOMENT] = {.name = "follower_moment",
                             .about = "A moment that turns with the rod: R l; l.",
                             .kind = LAW_LOADS,
                             .numbers = 3,
                             .shares = 3,
                             .by_rotation = true,
                             .has_moment = true,
                             .record = record_follower_moment},
    [LAW_SLENDER_DRAG] = {.name = "slender_drag",
                          .about =
                              "A fluid around a slender rod: -(c_1 + c_2 |w|^(1/2) + c_3 |w|) w "
                              "along d3 and across; c_1, c_2, c_3 of both.",
                          .kind = LAW_DISSIPATES,
                          .numbers = 6,
                          .by_rotation = true,
                          .by_velocity = true,
                          .has_force = true,
                          .record = record_slender_drag},
    [LAW_MAGNET] = {.name = "magnet",
                    .about = "A magnetic moment in a field: -(R m) . B; B, m.",
                    .kind = LAW_LOADS,
                    .numbers = 6,
                    .shares = 3,
                    .has_energy = true,
                    .along_axes = true,
                    .by_rotation = true,
                    .has_moment = true,
                    .record = record_magnet},
    [LAW_MAGNET_GRADIENT] = {.name = "magnet_gradient",
                             .about = "The same in the field G r: -(R m) . G r; "
                                      "G as xx, yy, xy, xz, yz, m.",
                             .kind = LAW_LOADS,
                             .numbers = 8,
                             .shares = 5,
                             .has_energy = true,
                             .along_axes = true,
                             .by_position = true,
                             .by_rotation = true,
                             .has_force = true,
                             .steady_force = true,
                             .has_moment = true,
                             .record = record_magnet_gradient},
    [LAW_ROTARY_INERTIA] = {.name = "rotary_inertia",
                            .about = "A section that turns: 1/2 sum J_i w_i^2; J.",
                            .state = LAW_OF_MOTION,
                            .kind = LAW_MOVES,
                            .numbers = 3,
                            .has_energy = true,
                            .record = record_rotary_inertia},
    [LAW_ECCENTRICITY] = {.name = "eccentricity",
                          .about = "A mass beside the axis, less its mass and J_i: V . (w x S) + "
                                   "J_23 w_2 w_3 + J_13 w_1 w_3 + J_12 w_1 w_2; S, J.",
                          .state = LAW_OF_MOTION,
                          .kind = LAW_MOVES,
                          .numbers = 6,
                          .has_energy = true,
                          .record = record_eccentricity},
    [LAW_ADDED_MASS] = {.name = "added_mass",
                        .about = "Fluid that moves with a rod across d3: 1/2 c (V_1^2 + V_2^2); c.",
                        .state = LAW_OF_MOTION,
                        .kind = LAW_MOVES,
                        .numbers = 1,
                        .has_energy = true,
                        .record = record_added_mass}};

/* ---- formulas ------------------------------------------------------------------------------ */

static void derive_within(law_formula *formula)
{
    ad_reverse(formula->energy, LAW_WRENCH, formula->given, AD_PER_POINT, formula->wrench);
    for (int i = 0, k = 0; i < LAW_WRENCH; i++) {
        for (int j = i; j < LAW_WRENCH; j++) {
            formula->by[k++] = ad_derivative(formula->wrench[i], formula->given[j], 1);
        }
    }
}

static void derive_tube(law_formula *formula)
{
    const ad_value *at = formula->given, turn[2] = {ad_neg(at[4]), at[3]};
    ad_value by_state[LAW_WRENCH], by_turn[LAW_WRENCH];
    ad_reverse(formula->energy, LAW_WRENCH, at, AD_PER_POINT, by_state);
    for (int i = 0; i < 3; i++) {
        formula->wrench[i] = by_state[i];
    }
    formula->wrench[3] = ad_add(ad_mul(turn[0], by_state[3]), ad_mul(turn[1], by_state[4]));
    formula->wrench[4] = by_state[5];
    ad_directional(LAW_WRENCH, formula->wrench, 2, at + 3, turn, by_turn);
    for (int i = 0, k = 0; i < LAW_WRENCH; i++) {
        for (int j = i; j < LAW_WRENCH; j++, k++) {
            formula->by[k] = j == 3   ? by_turn[i]
                             : j == 5 ? formula->wrench[5]
                                      : ad_derivative(formula->wrench[i], at[j < 3 ? j : 5], 1);
        }
    }
}

/* What q changes by with a turn about axis k. */
static void turn_about(const ad_value q[4], int k, ad_value by[4])
{
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    by[0] = ad_scale(q[1 + k], -0.5);
    by[1 + k] = ad_scale(q[0], 0.5);
    by[1 + i] = ad_scale(q[1 + j], -0.5);
    by[1 + j] = ad_scale(q[1 + i], 0.5);
}

static void derive_outside(law_formula *formula)
{
    const ad_value *q = formula->given + ROTATION;
    ad_value turn[3][4], by_state[7];
    for (int k = 0; k < 3; k++) {
        turn_about(q, k, turn[k]);
    }
    ad_reverse(formula->energy, 7, formula->given, AD_PER_POINT, by_state); /* zeros without one */
    for (int k = 0; k < 3; k++) {
        formula->wrench[k] = ad_sub(formula->wrench[k], by_state[k]);
        for (int i = 0; i < 4; i++) {
            const ad_value part = ad_mul(by_state[ROTATION + i], turn[k][i]);
            formula->wrench[3 + k] = ad_sub(formula->wrench[3 + k], part);
        }
    }
    for (int k = 0; k < 3; k++) {
        ad_value by_turn[LAW_WRENCH];
        ad_directional(LAW_WRENCH, formula->wrench, 4, q, turn[k], by_turn);
        for (int i = 0; i < LAW_WRENCH; i++) {
            formula->by[3 * i + k] = ad_derivative(formula->wrench[i], formula->given[k], 1);
            formula->by[3 * (LAW_WRENCH + i) + k] = by_turn[i];
            formula->by[3 * (2 * LAW_WRENCH + i) + k] =
                ad_derivative(formula->wrench[i], formula->given[VELOCITY + k], 1);
        }
    }
}

static void derive_motion(law_formula *formula)
{
    const ad_value *V = formula->given, *w = V + 3, *A = V + 6;
    ad_value momentum[LAW_WRENCH], rate[LAW_WRENCH], along[LAW_WRENCH], turned[3][3];
    cross(w, V, turned[0]);
    for (int i = 0; i < 3; i++) {
        along[i] = ad_sub(A[i], turned[0][i]);
        along[3 + i] = A[3 + i];
    }
    ad_reverse(formula->energy, LAW_WRENCH, V, AD_PER_POINT, momentum);
    ad_directional(LAW_WRENCH, momentum, LAW_WRENCH, V, along, rate);
    cross(w, momentum, turned[0]);
    cross(w, momentum + 3, turned[1]);
    cross(V, momentum, turned[2]);
    for (int i = 0; i < 3; i++) {
        formula->wrench[i] = ad_neg(ad_add(rate[i], turned[0][i]));
        formula->wrench[3 + i] = ad_neg(ad_add(rate[3 + i], ad_add(turned[1][i], turned[2][i])));
    }
    for (int k = 0; k < LAW_BY_MOTION; k++) {
        const int group = k / 18, i = k % 18 / 3;
        formula->by[k] = ad_derivative(formula->wrench[i], formula->given[3 * group + k % 3], 1);
    }
}

/* By law_state: the state, how many derivatives, and how they are taken. */
static const struct {
    law_group state[LAW_GROUPS_MAX - 1];
    int derivatives;
    void (*derive)(law_formula *x);
} states[] = {
    [LAW_WITHIN] = {{{"v", 3}, {"u", 3}}, LAW_STIFFNESS, derive_within},
    [LAW_TURNED] = {{{"u", 3}, {"turn", 3}}, LAW_STIFFNESS, derive_tube},
    [LAW_OUTSIDE] = {{{"position", 3}, {"rotation", 4}, {"velocity", 3}}, LAW_BY, derive_outside},
    [LAW_OF_MOTION] = {{{"velocity", 3}, {"spin", 3}, {"acceleration", 3}, {"spin_rate", 3}},
                       LAW_BY_MOTION,
                       derive_motion}};

int law_groups(law_name name, law_group groups[LAW_GROUPS_MAX])
{
    const law *of = &law_table[name];
    int count = 0;
    while (count < LAW_GROUPS_MAX - 1 && states[of->state].state[count].count > 0) {
        groups[count] = states[of->state].state[count];
        count++;
    }
    groups[count++] = (law_group){"numbers", of->numbers};
    return count;
}

int law_given(law_name name)
{
    law_group groups[LAW_GROUPS_MAX];
    int sum = 0;
    for (int i = law_groups(name, groups) - 1; i >= 0; i--) {
        sum += groups[i].count;
    }
    return sum;
}

int law_derivatives(law_name name)
{
    return states[law_table[name].state].derivatives;
}

law_formula law_formula_create(law_name name)
{
    const law *of = &law_table[name];
    law_group groups[LAW_GROUPS_MAX];
    const int count = law_groups(name, groups);
    law_formula x = {.tape = ad_tape_create()};
    for (int g = 0, i = 0; g < count; g++) {
        for (int k = 0; k < groups[g].count; k++) {
            x.given[i++] = ad_input(x.tape, groups[g].name, 1);
        }
    }
    x.energy = ad_scalar(x.tape, 0);
    for (int i = 0; i < LAW_WRENCH; i++) {
        x.wrench[i] = x.energy;
    }
    of->record(x.given, of->has_energy ? &x.energy : x.wrench);
    states[of->state].derive(&x);
    return x;
}

void law_formula_free(law_formula *formula)
{
    ad_tape_free(formula->tape);
    formula->tape = NULL;
}

void law_record(law_name name, ad_tape *tape, const ad_value *given, ad_value *energy,
                ad_value *wrench, ad_value *by)
{
    law_formula x = law_formula_create(name);
    const struct {
        const ad_value *formula;
        ad_value *to;
        int count;
    } all[] = {
        {&x.energy, energy, 1}, {x.wrench, wrench, LAW_WRENCH}, {x.by, by, law_derivatives(name)}};
    for (int i = 0; i < 3; i++) {
        if (all[i].to) {
            ad_call(all[i].count, all[i].formula, law_given(name), x.given, tape, given, all[i].to);
        }
    }
    law_formula_free(&x);
}
