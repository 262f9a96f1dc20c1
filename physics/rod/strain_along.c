/* Vectors, rotations and integrals of fields along a rod. */
#include "physics/rod/strain_internal.h"

#include <math.h>

/* ---- algebra ------------------------------------------------------------------------------- */

along strain_add(along a, along b)
{
    return (along){{ad_add(a.x[0], b.x[0]), ad_add(a.x[1], b.x[1]), ad_add(a.x[2], b.x[2])}};
}

along strain_sub(along a, along b)
{
    return (along){{ad_sub(a.x[0], b.x[0]), ad_sub(a.x[1], b.x[1]), ad_sub(a.x[2], b.x[2])}};
}

along strain_mul(along a, along b)
{
    return (along){{ad_mul(a.x[0], b.x[0]), ad_mul(a.x[1], b.x[1]), ad_mul(a.x[2], b.x[2])}};
}

along strain_by(ad_value a, along b)
{
    return (along){{ad_mul(a, b.x[0]), ad_mul(a, b.x[1]), ad_mul(a, b.x[2])}};
}

along strain_cross(along a, along b)
{
    along c;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        c.x[i] = ad_sub(ad_mul(a.x[j], b.x[k]), ad_mul(a.x[k], b.x[j]));
    }
    return c;
}

ad_value strain_dot(along a, along b)
{
    along c = strain_mul(a, b);
    return ad_add(ad_add(c.x[0], c.x[1]), c.x[2]);
}

along strain_to_world(const along_matrix *R, along a)
{
    along b;
    for (int i = 0; i < 3; i++) {
        b.x[i] = strain_dot((along){{R->x[i][0], R->x[i][1], R->x[i][2]}}, a);
    }
    return b;
}

along strain_to_body(const along_matrix *R, along a)
{
    along b;
    for (int i = 0; i < 3; i++) {
        b.x[i] = strain_dot((along){{R->x[0][i], R->x[1][i], R->x[2][i]}}, a);
    }
    return b;
}

along strain_zeros(ad_tape *tape)
{
    ad_value zero = ad_scalar(tape, 0);
    return (along){{zero, zero, zero}};
}

along strain_rows(ad_value vector)
{
    return (along){{ad_row(vector, 0), ad_row(vector, 1), ad_row(vector, 2)}};
}

ad_value strain_points(int nodes, along a)
{
    for (int c = 0; c < 3; c++) {
        a.x[c] = ad_rows(a.x[c]) == 1 ? ad_repeat(a.x[c], nodes) : a.x[c];
    }
    return ad_stack(3, a.x);
}

along strain_of_points(int nodes, ad_value x)
{
    return (along){
        {ad_slice(x, 0, nodes), ad_slice(x, nodes, nodes), ad_slice(x, 2 * nodes, nodes)}};
}

/* ---- rotations ----------------------------------------------------------------------------- */

along_turn strain_turn_product(along_turn p, along_turn q)
{
    static const int of[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};
    static const double sign[4][4] = {{1, -1, -1, -1}, {1, 1, 1, -1}, {1, -1, 1, 1}, {1, 1, -1, 1}};
    along_turn r;
    for (int i = 0; i < 4; i++) { /* entry i: sum of sign p_k q_of */
        r.x[i] = ad_mul(p.x[0], q.x[of[i][0]]);
        for (int k = 1; k < 4; k++) {
            r.x[i] = ad_add(r.x[i], ad_scale(ad_mul(p.x[k], q.x[of[i][k]]), sign[i][k]));
        }
    }
    return r;
}

along_turn strain_turn_by(along w)
{
    ad_value square = ad_scale(strain_dot(w, w), 0.25);
    ad_value cosine = ad_stumpff(0, square), sine = ad_stumpff(1, square);
    along half = strain_by(ad_scale(sine, 0.5), w);
    return (along_turn){{cosine, half.x[0], half.x[1], half.x[2]}};
}

along_matrix strain_turn_matrix(along_turn q)
{
    ad_value x[4][4]; /* of two times q */
    along_matrix R;
    for (int i = 0; i < 4; i++) {
        for (int j = i; j < 4; j++) {
            x[i][j] = ad_mul(ad_scale(q.x[i], 2), q.x[j]);
        }
    }
    const ad_value one = ad_scalar(q.x[0].tape, 1);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3, low = j < k ? j : k, high = j < k ? k : j;
        R.x[i][i] = ad_sub(one, ad_add(x[j + 1][j + 1], x[k + 1][k + 1]));
        R.x[j][k] = ad_sub(x[low + 1][high + 1], x[0][i + 1]);
        R.x[k][j] = ad_add(x[low + 1][high + 1], x[0][i + 1]);
    }
    return R;
}

along_turn strain_turn_rows(ad_value q)
{
    return (along_turn){{ad_row(q, 0), ad_row(q, 1), ad_row(q, 2), ad_row(q, 3)}};
}

static along_twist twist_add(along_twist a, double factor, along_twist b)
{
    const ad_value by = ad_scalar(b.turn.x[0].tape, factor);
    return (along_twist){strain_add(a.turn, strain_by(by, b.turn)),
                         strain_add(a.shift, strain_by(by, b.shift))};
}

/* [b, a] */
static along_twist bracket(along_twist b, along_twist a)
{
    return (along_twist){strain_cross(b.turn, a.turn),
                         strain_sub(strain_cross(b.turn, a.shift), strain_cross(a.turn, b.shift))};
}

along_twist strain_magnus(const along_twist a[3])
{
    const along_twist c1 = bracket(a[1], a[0]);
    const along_twist c2 = bracket(a[0], twist_add(c1, 2, a[2]));
    const along_twist on = twist_add(twist_add(c1, -20, a[0]), -1, a[2]);
    const along_twist last = bracket(twist_add(a[1], 1.0 / 60, c2), on);
    return twist_add(twist_add(a[0], 1.0 / 12, a[2]), 1.0 / 240, last);
}

along strain_twist_shift(along_twist a)
{
    const ad_value square = strain_dot(a.turn, a.turn);
    const along once = strain_cross(a.turn, a.shift), twice = strain_cross(a.turn, once);
    const ad_value second = ad_stumpff(2, square), third = ad_stumpff(3, square);
    return strain_add(a.shift, strain_add(strain_by(second, once), strain_by(third, twice)));
}

/* ---- points -------------------------------------------------------------------------------- */

ad_value strain_weigh(int rows, int points, const double *weights, ad_value x)
{
    if (ad_rows(x) == points && points > 1) {
        return ad_matvec(ad_constant(x.tape, rows * points, weights), x);
    }
    double sums[3 * STRAIN_STEPS_MAX];
    for (int i = 0; i < rows; i++) {
        double size = sums[i] = 0;
        for (int j = 0; j < points; j++) {
            sums[i] += weights[i * points + j];
            size += fabs(weights[i * points + j]);
        }
        sums[i] = fabs(sums[i]) < 1e-14 * size ? 0 : sums[i]; /* weights of a derivative */
    }
    return ad_mul(ad_constant(x.tape, rows, sums), x);
}

static ad_value element_of(const strain_rod *rod, ad_value x, int element)
{
    const int n = rod->mesh.stages;
    return ad_rows(x) == 1 ? x : ad_slice(x, element * n, n);
}

along strain_element(const strain_rod *rod, along a, int e)
{
    return (along){
        {element_of(rod, a.x[0], e), element_of(rod, a.x[1], e), element_of(rod, a.x[2], e)}};
}

along strain_join(int elements, const int *counts, const along *parts)
{
    ad_value all[STRAIN_ELEMENTS_MAX];
    along a;
    for (int c = 0; c < 3; c++) {
        bool same = true;
        int count = 0;
        for (int e = 0; e < elements; e++) {
            ad_value part = parts[e].x[c];
            same = same && ad_rows(part) == 1 && part.id == parts[0].x[c].id;
            if (counts[e] > 0) {
                all[count++] = ad_rows(part) < counts[e] ? ad_repeat(part, counts[e]) : part;
            }
        }
        a.x[c] = same ? parts[0].x[c] : ad_stack(count, all);
    }
    return a;
}
