/* Elimination of the strain form, element by element from s = 1 back. What a rod is beyond an edge
 * acts on the rod before it by N and M there, which are linear in the turn phi of that edge,
 *
 *   dN = p_N + P_N phi,   dM = p_M + P_M phi
 *
 * so that the curvatures of an element have a matrix of their own, du = d - D phi for the turn of
 * its beginning, and give p, P there. These matrices are the diagonal blocks of elimination of the
 * full matrix in this order: their pivots are its own, and the work grows with the number of
 * elements, not with its cube. Then phi is known from s = 0 on. */
#include "physics/chain/strain_form.h"

#include "physics/chain/strain_inline.h"
#include "physics/local/strain_algebra.h"

#include <stdlib.h>

/* ---- elimination in a block ---------------------------------------------------------------- */

/* A diagonal entry that is this much smaller than one below it makes way, in its lane. Where none
 * is, as under moderate loads, lanes need not be looked at one by one. */
static const double PIVOT_LEAST = 0.01;

/* A block of the matrix [n][n], column-major, and right sides [columns][n]. */
typedef struct block {
    int n, columns;
    bool keeps_order;             /* no row makes way */
    lanes *matrix, *right, *more; /* the first right side, the others */
    int (*swapped)[LANES];        /* [n] */
} block;

PROCESSOR_INLINE lanes *column_of(const block *b, int c)
{
    return c < b->n    ? b->matrix + (size_t)c * (size_t)b->n
           : c == b->n ? b->right
                       : b->more + (size_t)(c - b->n - 1) * (size_t)b->n;
}

PROCESSOR_INLINE void swap(lanes *column, int lane, int a, int b)
{
    double *numbers = (double *)column, held = numbers[a * LANES + lane];
    numbers[a * LANES + lane] = numbers[b * LANES + lane];
    numbers[b * LANES + lane] = held;
}

static void choose_pivots(strain_form *form, const block *b, int k)
{
    const double *column = (const double *)column_of(b, k);
    for (int lane = 0; lane < LANES; lane++) {
        int best = k;
        for (int i = k + 1; i < b->n; i++) {
            best = fabs(column[i * LANES + lane]) > fabs(column[best * LANES + lane]) ? i : best;
        }
        if (fabs(column[k * LANES + lane]) < PIVOT_LEAST * fabs(column[best * LANES + lane])) {
            for (int c = k; c < b->n + b->columns; c++) {
                swap(column_of(b, c), lane, k, best);
            }
            b->swapped[k][lane] = best;
            form->negative[lane]++;
        }
    }
}

/* Whether in any lane an entry below the diagonal is much larger. */
PROCESSOR_INLINE bool needs_pivot(const lanes *column, int k, int n)
{
    const integer_lanes size = {0x7fffffffffffffffLL, 0x7fffffffffffffffLL, 0x7fffffffffffffffLL,
                                0x7fffffffffffffffLL, 0x7fffffffffffffffLL, 0x7fffffffffffffffLL,
                                0x7fffffffffffffffLL, 0x7fffffffffffffffLL};
    lanes limit = (lanes)((integer_lanes)column[k] & size) * (1 / PIVOT_LEAST);
    integer_lanes any = {0};
    for (int i = k + 1; i < n; i++) {
        any |= (lanes)((integer_lanes)column[i] & size) > limit;
    }
    long long sum = 0;
    for (int lane = 0; lane < LANES; lane++) {
        sum |= any[lane];
    }
    return sum != 0;
}

PROCESSOR_INLINE void substitute_back(const block *b, lanes *right)
{
    for (int k = b->n - 1; k >= 0; k--) {
        const lanes *from = column_of(b, k), found = right[k] / from[k];
        right[k] = found;
        for (int i = 0; i < k; i++) {
            right[i] -= found * from[i];
        }
    }
}

/* Subtracts multiples of column k, below row k, from others and from the right sides. */
PROCESSOR_INLINE void eliminate(strain_form *form, const block *b)
{
    const int n = b->n;
    integer_lanes negative = {0};
    for (int k = 0; k < n; k++) {
        lanes *from = column_of(b, k);
        for (int lane = 0; lane < LANES; lane++) {
            b->swapped[k][lane] = k;
        }
        if (!b->keeps_order && needs_pivot(from, k, n)) {
            choose_pivots(form, b, k);
        }
        const lanes by = 1 / from[k];
        negative -= by < 0;
        for (int i = k + 1; i < n; i++) {
            from[i] *= by;
        }
        for (int c = k + 1; c < n + b->columns; c++) {
            lanes *to = column_of(b, c);
            const lanes factor = to[k];
            for (int i = k + 1; i < n; i++) {
                to[i] -= factor * from[i];
            }
        }
    }
    for (int lane = 0; lane < LANES; lane++) {
        form->negative[lane] += (int)negative[lane];
    }
    for (int c = n; c < n + b->columns; c++) {
        substitute_back(b, column_of(b, c));
    }
}

/* Another right side. */
PROCESSOR_INLINE void eliminate_again(const block *b)
{
    lanes *right = b->right;
    for (int k = 0; k < b->n; k++) {
        const lanes *from = column_of(b, k);
        for (int lane = 0; lane < LANES; lane++) {
            swap(right, lane, k, b->swapped[k][lane]);
        }
        for (int i = k + 1; i < b->n; i++) {
            right[i] -= right[k] * from[i];
        }
    }
    substitute_back(b, right);
}

/* ---- an element ---------------------------------------------------------------------------- */

/* What elements of all rods of a form have in common. */
typedef struct sweep {
    strain_form *form;
    bool moves; /* N changes with the turn of something */
} sweep;

/* The changes of rows [stages][3] of element e, and of N and M at its beginning, by a change of its
 * curvatures (NULL: none), a turn of its beginning (NULL: none), and where `given` p beyond it. */
PROCESSOR_CALLED void respond(const sweep *w, int e, const lanes *change, const lanes *turn,
                              bool given, lanes *rows, lanes (*start)[3])
{
    strain_form *form = w->form;
    const int n = form->kind.stages;
    strain_edge *edge = &form->edges[e + 1];
    strain_node *at = form->at + e * n;
    lanes rate[GAUSS_STAGES_MAX][3], turns[GAUSS_STAGES_MAX][3], moments[GAUSS_STAGES_MAX][3];
    lanes forces[GAUSS_STAGES_MAX][3], end[3], far[2][3], first[3] = {NO_LANES, NO_LANES, NO_LANES};
    memset(rate, 0, sizeof rate);
    memcpy(first, turn ? turn : first, sizeof first);
    for (int j = 0; j < n && change; j++) {
        apply(at[j].R, change + 3 * j, rate[j]);
    }
    integrate_on(form, e, rate, first, turns, end);
    memset(far, 0, sizeof far);
    memcpy(far, given ? edge->beyond : far, sizeof far);
    add_applied(edge->back[1], end, far[1]);
    if (w->moves) {
        add_applied(edge->back[0], end, far[0]);
        for (int j = 0; j < n; j++) {
            apply(at[j].load_by_turn[0], turns[j], rate[j]);
        }
        integrate_back(form, e, rate, far[0], forces, start[0]);
    }
    for (int j = 0; j < n; j++) {
        apply(at[j].G, turns[j], rate[j]);
        if (w->moves) {
            add_applied(at[j].H, forces[j], rate[j]);
        }
        if (form->kind.shears && change) {
            add_applied(at[j].K, change + 3 * j, rate[j]);
        }
    }
    integrate_back(form, e, rate, far[1], moments, start[1]);
    for (int i = 0; i < n && rows; i++) {
        lanes moved[3];
        apply(at[i].Y, turns[i], rows + 3 * i);
        apply(at[i].T, moments[i], moved);
        if (w->moves) {
            add_applied(at[i].Z, forces[i], rows + 3 * i);
        }
        for (int k = 0; k < 3; k++) {
            rows[3 * i + k] -= moved[k];
        }
    }
}

/* The same by component c of u at one of its points, of rows alone. */
PROCESSOR_CALLED void respond_to_one(const sweep *w, int e, int own, int c, lanes *rows)
{
    strain_form *form = w->form;
    const int n = form->kind.stages;
    strain_edge *edge = &form->edges[e + 1];
    strain_node *at = form->at + e * n;
    const double h = form->width[e], whole = h * form->rule.weights[own];
    const lanes a[3] = {at[own].R[0][c], at[own].R[1][c], at[own].R[2][c]};
    const lanes end[3] = {whole * a[0], whole * a[1], whole * a[2]};
    lanes rate[GAUSS_STAGES_MAX][3], force[GAUSS_STAGES_MAX][3], far[2][3], moved[3];
    double turned[GAUSS_STAGES_MAX];
    apply(edge->back[1], end, far[1]);
    if (w->moves) {
        apply(edge->back[0], end, far[0]);
        for (int j = 0; j < n; j++) {
            apply(at[j].load_by_turn[0], a, rate[j]);
            for (int k = 0; k < 3; k++) {
                rate[j][k] *= h * form->rule.matrix[j][own];
            }
        }
        integrate_back(form, e, rate, far[0], force, moved);
    }
    for (int j = 0; j < n; j++) {
        turned[j] = h * form->rule.matrix[j][own];
        apply(at[j].G, a, rate[j]);
        for (int k = 0; k < 3; k++) {
            rate[j][k] *= turned[j];
        }
        if (w->moves) {
            add_applied(at[j].H, force[j], rate[j]);
        }
    }
    for (int k = 0; k < 3 && form->kind.shears; k++) {
        rate[own][k] += at[own].K[k][c];
    }
    for (int i = 0; i < n; i++) {
        lanes sum[3], *row = rows + 3 * i;
        memcpy(sum, far[1], sizeof sum);
        for (int j = 0; j < n; j++) {
            const double weight = h * form->tail[i][j];
            for (int k = 0; k < 3; k++) {
                sum[k] += weight * rate[j][k];
            }
        }
        apply(at[i].T, sum, moved);
        apply(at[i].Y, a, row);
        for (int k = 0; k < 3; k++) {
            row[k] = turned[i] * row[k] - moved[k];
        }
        if (w->moves) {
            add_applied(at[i].Z, force[i], row);
        }
    }
    for (int k = 0; k < 3; k++) {
        rows[3 * own + k] += at[own].L[k][c];
    }
}

PROCESSOR_INLINE block block_of(strain_form *form, int e)
{
    const int n = 3 * form->kind.stages;
    const size_t first = (size_t)e * n;
    return (block){.n = n,
                   .columns = e > 0 ? 4 : 1, /* the beginning of the first does not turn */
                   .matrix = form->matrix + first * (size_t)n,
                   .right = form->right + first,
                   .more = form->coupled + 3 * first,
                   .swapped = form->swapped + first};
}

/* ---- the rod ------------------------------------------------------------------------------- */

/* What p at the end of element e does to its rows is taken from their right side. */
PROCESSOR_INLINE void bring(const sweep *w, int e, lanes *right)
{
    lanes rows[3 * GAUSS_STAGES_MAX], start[2][3];
    if (e + 1 < w->form->kind.elements) {
        respond(w, e, NULL, NULL, true, rows, start);
        for (int i = 0; i < 3 * w->form->kind.stages; i++) {
            right[i] -= rows[i];
        }
    }
}

/* p at the beginning of element e. */
PROCESSOR_INLINE void hand_on(const sweep *w, int e, const lanes *found)
{
    if (e > 0) {
        strain_edge *edge = &w->form->edges[e];
        memset(edge->beyond, 0, sizeof edge->beyond);
        respond(w, e, found, NULL, e + 1 < w->form->kind.elements, NULL, edge->beyond);
    }
}

/* P at the beginning of element e, beyond what acts there, by its D. */
PROCESSOR_INLINE void hand_on_turns(const sweep *w, int e, const lanes *coupled)
{
    strain_form *form = w->form;
    const int n = 3 * form->kind.stages;
    strain_edge *edge = &form->edges[e];
    memcpy(edge->back, edge->by_turn, sizeof edge->back);
    for (int c = 0; c < 3; c++) {
        lanes turn[3] = {NO_LANES, NO_LANES, NO_LANES}, back[3 * GAUSS_STAGES_MAX], start[2][3];
        turn[c] += 1;
        for (int i = 0; i < n; i++) {
            back[i] = -coupled[c * n + i];
        }
        memset(start, 0, sizeof start);
        respond(w, e, back, turn, false, NULL, start);
        for (int k = 0; k < 3; k++) {
            edge->back[0][k][c] += start[0][k];
            edge->back[1][k][c] += start[1][k];
        }
    }
}

/* The turns of edges from s = 0 on, and with them the steps. */
PROCESSOR_INLINE void turn_on(strain_form *form)
{
    const int n = form->kind.stages;
    lanes turn[3] = {NO_LANES, NO_LANES, NO_LANES};
    for (int e = 0; e < form->kind.elements; e++) {
        const block b = block_of(form, e);
        for (int c = 0; c < 3 && e > 0; c++) {
            for (int i = 0; i < b.n; i++) {
                b.right[i] -= b.more[c * b.n + i] * turn[c];
            }
        }
        for (int j = 0; j < n; j++) {
            lanes rate[3];
            apply(form->at[e * n + j].R, b.right + 3 * j, rate);
            for (int k = 0; k < 3; k++) {
                turn[k] += form->width[e] * form->rule.weights[j] * rate[k];
            }
        }
    }
}

PROCESSOR_INLINE void solve_all(strain_form *form, bool moves)
{
    const sweep w = {form, moves};
    const int last = form->kind.elements;
    memset(form->negative, 0, sizeof form->negative);
    memcpy(form->edges[last].back, form->edges[last].by_turn, sizeof form->edges[last].back);
    for (int i = 0; i < 9; i++) {
        form->edges[last].back[1][i / 3][i % 3] += form->by_end[i / 3][i % 3];
    }
    for (int e = last - 1; e >= 0; e--) {
        const block b = block_of(form, e);
        for (int k = 0; k < b.n; k++) {
            respond_to_one(&w, e, k / 3, k % 3, column_of(&b, k));
        }
        bring(&w, e, b.right);
        for (int c = 0; c < 3 && e > 0; c++) {
            lanes turn[3] = {NO_LANES, NO_LANES, NO_LANES}, start[2][3];
            turn[c] += 1;
            respond(&w, e, NULL, turn, false, b.more + c * b.n, start);
        }
        eliminate(form, &b);
        if (e > 0) {
            hand_on(&w, e, b.right);
            hand_on_turns(&w, e, b.more);
        }
    }
    turn_on(form);
}

PROCESSOR_INLINE void solve_all_again(strain_form *form, bool moves)
{
    const sweep w = {form, moves};
    for (int e = form->kind.elements - 1; e >= 0; e--) {
        const block b = block_of(form, e);
        bring(&w, e, b.right);
        eliminate_again(&b);
        hand_on(&w, e, b.right);
    }
    turn_on(form);
}

/* ---- without loads ----------------------------------------------------------------------------
 */

/* Point by point. */
FOR_EACH_PROCESSOR static void solve_points(strain_form *form, bool again)
{
    memset(form->negative, 0, again ? 0 : sizeof form->negative);
    for (int i = 0; i < form->nodes; i++) {
        const block b = {.n = 3,
                         .columns = 1,
                         .matrix = form->matrix + 9 * i,
                         .right = form->right + 3 * i,
                         .swapped = form->swapped + 3 * i};
        if (again) {
            eliminate_again(&b);
            continue;
        }
        for (int k = 0; k < 9; k++) {
            b.matrix[k] = form->at[i].L[k % 3][k / 3];
        }
        eliminate(form, &b);
    }
}

/* ---- with forces that the shape does not give --------------------------------------------- */

/* The unknowns in the order of elimination: forces that depend on the place first, whose own
 * rows they are, so that what is left for the curvatures is the second variation of all energies;
 * last those that hold an end. */
static int unknown_of(const strain_form *form, int place)
{
    const int others = form->elastic + form->holding, first = form->tension_at - others;
    return place < first ? others + place : place - first;
}

FOR_EACH_PROCESSOR static void eliminate_full(strain_form *form, bool again)
{
    const block b = {.n = form->tension_at,
                     .columns = 1,
                     .keeps_order = true,
                     .matrix = form->matrix,
                     .right = form->coupled,
                     .swapped = form->swapped};
    if (again) {
        eliminate_again(&b);
    } else {
        eliminate(form, &b);
    }
}

/* The negative pivots are those of the second variation in directions that the ends leave: a pivot
 * of what holds an end is negative where it takes away one in which the rod would give way (inertia
 * of a bordered matrix: Haynsworth, Linear Algebra and its Applications 1, 1968). */
static void solve_full(strain_form *form, bool again)
{
    const int n = form->tension_at;
    lanes *right = form->coupled, *column = right + n;
    for (int i = 0; i < n; i++) {
        right[i] = form->right[unknown_of(form, i)];
    }
    for (int c = 0; c < n && !again; c++) {
        const lanes none = NO_LANES;
        const int at = unknown_of(form, c), torsion = at - form->tube_at;
        form->direction[at] = none + 1;
        if (torsion >= 0 && torsion < form->kind.tubes * (form->nodes + 1)) {
            strain_form_apply_torsion(form, torsion % form->kind.tubes, form->direction, column);
        } else {
            strain_form_apply(form, form->direction, column);
        }
        form->direction[at] = none;
        for (int i = 0; i < n; i++) {
            form->matrix[c * n + i] = column[unknown_of(form, i)];
        }
    }
    memset(form->negative, 0, again ? 0 : sizeof form->negative);
    eliminate_full(form, again);
    for (int i = n - form->holding; i < n && !again; i++) {
        for (int lane = 0; lane < LANES; lane++) {
            form->negative[lane] -= 2 * (form->matrix[i * n + i][lane] < 0);
        }
    }
    for (int i = 0; i < n; i++) {
        form->right[unknown_of(form, i)] = right[i];
    }
}

/* ---- all together -------------------------------------------------------------------------- */

/* Whether N changes with the shape. */
static bool forces_move(const strain_form *form)
{
    bool moves = form->follows;
    for (int k = 0; k < form->place_count && !moves; k++) {
        moves = form->places[k].acting->follows;
    }
    return moves;
}

FOR_EACH_PROCESSOR static void solve(strain_form *form, bool moves, bool again)
{
    if (again) {
        if (moves) {
            solve_all_again(form, true);
        } else {
            solve_all_again(form, false);
        }
    } else if (moves) {
        solve_all(form, true);
    } else {
        solve_all(form, false);
    }
}

void strain_form_eliminate(strain_form *form, bool again)
{
    if (form->is_full) {
        solve_full(form, again);
    } else if (form->is_unloaded) {
        solve_points(form, again);
    } else {
        solve(form, forces_move(form), again);
    }
}
