/* Turn and displacement of a reduced rod by each of its modes, side by side, and its mass. */
#include "physics/chain/modes_rows.h"

PROCESSOR_INLINE void move_rows(modes *m, int e)
{
    const int n = m->stages, width = m->width, used = m->element[e].width, first = e * (n + 1);
    double *rate = m->room, *own = rate + n * 3 * width, *none = own + n * 6 * width;
    const double *before = e > 0 ? m->theta + (first - 1) * 3 * width : none;
    const double *moved = e > 0 ? m->rho + (first - 1) * 3 * width : none;
    memset(none, 0, (size_t)(3 * width) * sizeof *none);
    for (int i = 0; i < n; i++) {
        own_rows(m, e, first + i, width, own + i * 6 * width);
    }
    for (int k = 0; k < 3; k++) {
        integrate_rows(m, e, used, before + k * width, own + (3 + k) * width, 6 * width,
                       m->theta + (first * 3 + k) * width, 3 * width);
    }
    for (int i = 0; i < n; i++) {
        const modes_point *at = &m->point[first + i];
        for (int c = 0; c < used; c += QUAD) {
            quad theta[3], by_v[3];
            load_rows(m->theta + (first + i) * 3 * width + c, width, theta);
            load_rows(own + i * 6 * width + c, width, by_v);
            add_crossed(theta, at->along, by_v);
            store_rows(by_v, width, rate + i * 3 * width + c);
        }
    }
    for (int k = 0; k < 3; k++) {
        integrate_rows(m, e, used, moved + k * width, rate + k * width, 3 * width,
                       m->rho + (first * 3 + k) * width, 3 * width);
    }
}

/* Four rows and four columns of x^T y, rows [count] of `width`. */
PROCESSOR_INLINE void product_block(int count, int width, const double *x, const double *y,
                                    double *to)
{
    quad sum[QUAD] = {{0}}, right;
    for (int r = 0; r < count; r++) {
        memcpy(&right, y + r * width, sizeof right);
        for (int i = 0; i < QUAD; i++) {
            sum[i] += x[r * width + i] * right;
        }
    }
    for (int i = 0; i < QUAD; i++) {
        memcpy(to + i * width, &sum[i], sizeof sum[i]);
    }
}

/* The sum over points of rho^T mass rho + theta^T J theta. */
FOR_EACH_PROCESSOR static void find_mass(modes *m)
{
    const int width = m->width;
    double *x = m->room, *y = x + m->points * 6 * width;
    int count = 0;
    for (int e = 0; e < m->elements; e++) {
        move_rows(m, e);
    }
    for (int p = 0; p < m->points; p++) {
        const modes_point *at = &m->point[p];
        if (!inertia_any(&at->inertia)) {
            continue;
        }
        const bool couples = inertia_couples(&at->inertia);
        inertia_matrix by = inertia_matrix_of(&at->inertia, (const double(*)[3])at->R), across;
        for (int i = 0; i < 3 && couples; i++) {
            for (int k = 0; k < 3; k++) {
                across.coupling[k][i] = by.coupling[i][k];
            }
        }
        for (int c = 0; c < width; c += QUAD) {
            quad theta[3], rho[3], turned[3] = {{0}}, moved[3] = {{0}};
            load_rows(m->theta + p * 3 * width + c, width, theta);
            load_rows(m->rho + p * 3 * width + c, width, rho);
            add_applied(by.rotary, 1, theta, turned);
            if (couples) {
                add_applied(by.mass, 1, rho, moved);
                add_applied(by.coupling, 1, theta, moved);
                add_applied(across.coupling, 1, rho, turned);
            } else {
                add_scaled(at->inertia.mass, rho, moved);
            }
            store_rows(theta, width, x + count * width + c);
            store_rows(rho, width, x + (count + 3) * width + c);
            store_rows(turned, width, y + count * width + c);
            store_rows(moved, width, y + (count + 3) * width + c);
        }
        count += 6;
    }
    int e = 0, still = 0; /* a mode does not move the elements before its own: their rows are 0 */
    for (int a = 0; a < width; a += QUAD) {
        for (; e + 1 < m->elements && m->element[e].width <= a; e++) {
            for (int p = e * (m->stages + 1); p < (e + 1) * (m->stages + 1); p++) {
                still += inertia_any(&m->point[p].inertia) ? 6 : 0;
            }
        }
        for (int b = 0; b <= a; b += QUAD) {
            product_block(count - still, width, x + still * width + a, y + still * width + b,
                          m->mass + a * width + b);
        }
    }
    for (int a = 0; a < m->size; a++) {
        for (int b = 0; b < a; b++) {
            m->mass[b * width + a] = m->mass[a * width + b];
        }
    }
}

void modes_mass(modes *m)
{
    find_mass(m);
}
