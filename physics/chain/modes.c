#include "physics/chain/modes_internal.h"

#include "physics/local/mesh.h"
#include "physics/scene/support.h"

#include <stdlib.h>
#include <string.h>

/* ---- counts --------------------------------------------------------------------------------- */

modes_counts modes_counts_in(const scene *rod_scene, const int of[4])
{
    modes_counts counts = modes_counts_of(of[0], of[1], of[2], of[3]);
    const rod_plane plane = rod_plane_of(rod_scene);
    if (plane.is_planar) {
        counts.of[MODES_U + 1 - plane.director] = counts.of[MODES_U + 2] = 0;
        counts.of[MODES_V + plane.director] = 0;
    }
    return counts;
}

/* ---- pieces and elements ------------------------------------------------------------------- */

/* Points of each piece: so many more than modes of a strain, of which shapes are no polynomials. */
enum { MORE_POINTS = 4, STAGES = 10, DIVISIONS = 64 };

typedef struct mesh {
    solve_quadrature *places;
    double *edges; /* [elements + 1] */
    int elements, stages;
} mesh;

static int largest_count(const modes_counts *counts)
{
    int most = 0;
    for (int c = 0; c < MODES_STRAINS; c++) {
        most = counts->of[c] > most ? counts->of[c] : most;
    }
    return most;
}

/* Elements that end at places, each piece with enough points. */
static ad_status divide(const solve_rod *rod, const modes_counts *counts, int finer, mesh *mesh,
                        ad_error *error)
{
    const int points = largest_count(counts) + MORE_POINTS + finer;
    const int each = (points + STAGES - 1) / STAGES;
    const solve_given given = motion_given(rod);
    ad_status status = motion_places_of(rod, &mesh->places, error);
    if (status != AD_OK) {
        return status;
    }
    const int places = mesh->places->place_count, room = (places + 1) * each + DIVISIONS;
    double *coarse = malloc((size_t)(places + 2) * sizeof *coarse);
    mesh->edges = malloc((size_t)(room + 1) * sizeof *mesh->edges);
    if (!coarse || !mesh->edges) {
        free(coarse);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d elements", room);
    }
    const int pieces = solve_mesh_edges(1, places, mesh->places->places, coarse);
    mesh->stages = (points + each - 1) / each;
    mesh->elements = pieces * each;
    for (int i = 0; i <= mesh->elements; i++) {
        const int piece = i / each < pieces ? i / each : pieces - 1;
        mesh->edges[i] =
            coarse[piece] + (coarse[piece + 1] - coarse[piece]) * (i - piece * each) / (double)each;
    }
    free(coarse);
    bool done;
    return solve_quadrature_divide(mesh->places, &given, mesh->stages, 1e-6, room, &mesh->elements,
                                   mesh->edges, &done, error);
}

/* The mesh of the rod as it is with its parameters' usual values. */
static ad_status find_mesh(const solve_rod *rod, int inputs, const modes_counts *counts, int finer,
                           mesh *mesh, ad_error *error)
{
    solve_rod *closed = NULL;
    if (inputs == 0) {
        return divide(rod, counts, finer, mesh, error);
    }
    ad_status status = solve_rod_create(&rod->scene, &closed, error);
    status = status == AD_OK ? divide(closed, counts, finer, mesh, error) : status;
    solve_rod_free(closed);
    return status;
}

static bool begins_piece(const mesh *mesh, int element)
{
    bool begins = element == 0;
    for (int i = 0; i < mesh->places->place_count; i++) {
        begins |= fabs(mesh->places->places[i] - mesh->edges[element]) <= SOLVE_SAME_PLACE;
    }
    return begins;
}

/* A start that turns is three hinges in turn, as if the rod were bent and twisted over no length.
 * Twist is the one between: beyond a quarter of a turn the other two are one. */
enum { HINGES = 3 };
static const int HINGE_AXIS[HINGES] = {0, 2, 1};

/* ---- making -------------------------------------------------------------------------------- */

static void set_elements(modes *m, const mesh *mesh)
{
    m->pieces = 0;
    for (int e = 0; e < m->elements; e++) {
        modes_element *to = &m->element[e];
        const int n = m->stages, own = e - m->hinges; /* of the mesh */
        m->pieces += own >= 0 && begins_piece(mesh, own);
        to->length = own >= 0 ? mesh->edges[own + 1] - mesh->edges[own] : 1;
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < n; i++) {
                to->matrix[i][j] = to->length * m->rule.matrix[i][j];
            }
            to->matrix[n][j] = to->length * m->rule.weights[j];
        }
        for (int i = 0; i <= n; i++) {
            const int p = e * (n + 1) + i;
            if (own >= 0) {
                m->s[p] =
                    i < n ? mesh->edges[own] + to->length * m->rule.nodes[i] : mesh->edges[own + 1];
                m->point[p].weight = i < n ? to->length * m->rule.weights[i] : 0;
            }
            m->point[p].s = m->s[p];
        }
    }
    for (int i = 0; i <= m->stages; i++) {
        double terms[3][GAUSS_STAGES_MAX];
        gauss_magnus(&m->rule, i > 0 ? m->rule.nodes[i - 1] : 0,
                     i < m->stages ? m->rule.nodes[i] : 1, terms);
        for (int j = 0; j < 3 * m->stages; j++) {
            m->magnus[j % 3][j / 3][i] = terms[j % 3][j / 3];
        }
    }
}

/* The section at the first point of an element; a strain without compliance is locked. */
static ad_status section_of(const modes *m, int element, const solve_parameters *open,
                            solve_section *made, ad_error *error)
{
    return solve_rod_part(m->rod, SOLVE_SECTIONS, 1, &m->s[element * (m->stages + 1)], 0,
                          open ? open->values : NULL, (double *)made, error);
}

/* Modes piece by piece, so that those that move a point are the first so many; of a locked strain
 * none. */
static ad_status set_modes(modes *m, const mesh *mesh, const solve_parameters *open,
                           ad_error *error)
{
    ad_status status = AD_OK;
    solve_section made;
    const int per_piece = MODES_STRAINS * largest_count(&m->counts) + 1, hinges = m->hinges;
    const scene_feed *feed = &m->rod->scene.feed;
    const bool fed = feed->to > 0 && (feed->by == SCENE_FED_IN_TIME || open);
    const size_t most = (size_t)per_piece * (size_t)m->pieces + (size_t)hinges;
    AD_TAKE(m, mode, most);
    AD_TAKE(m, branch.mode, most);
    if (m->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for modes");
    }
    for (int e = 0; e < hinges; e++) {
        const int axis = m->turn.mode >= 0 ? 2 : HINGE_AXIS[e];
        m->mode[m->size++] = (modes_mode){MODES_U + axis, 0, e, e};
        m->element[e].own = e;
        m->element[e].end = m->size;
        m->element[e].width = QUAD;
    }
    for (int e = hinges, last; e < m->elements && status == AD_OK; e = last + 1) {
        const int first = m->size;
        for (last = e; last + 1 < m->elements && !begins_piece(mesh, last + 1 - hinges); last++) {
        }
        status = section_of(m, e, open, &made, error);
        for (int c = 0; c < MODES_STRAINS && status == AD_OK; c++) {
            m->is_locked |= made.compliance[c] == 0;
            for (int k = 0; k < m->counts.of[c] && made.compliance[c] > 0; k++) {
                if (modes_branch_any(&made)) {
                    m->branch.mode[m->branch.count++] = m->size;
                }
                m->mode[m->size++] = (modes_mode){c, k, e, last};
            }
        }
        if (e == hinges && fed) {
            const double end = m->s[(last + 1) * (m->stages + 1) - 1];
            m->feed.mode = m->size;
            m->mode[m->size++] = (modes_mode){MODES_V + 2, 0, e, last};
            if (fabs(end - feed->to / m->rod->scales.length) > SOLVE_SAME_PLACE) {
                return ad_fail(error, AD_BAD_ARGUMENT,
                               "s = %g, up to which a rod is fed, is no edge", feed->to);
            }
        }
        for (int i = e; i <= last; i++) {
            m->element[i].own = first;
            m->element[i].end = m->size;
            m->element[i].width = (m->size + QUAD - 1) / QUAD * QUAD;
        }
    }
    m->end.first = m->size;
    m->end.directions = modes_end_directions(m->rod);
    m->size += m->end.directions;
    m->width = (m->size + QUAD - 1) / QUAD * QUAD;
    if (status == AD_OK && m->is_locked && m->rod->rest_moves && !fed) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "method modes: the rest shape of a rod with locked strains moves; "
                         "allowed: one that stays");
    }
    return status;
}

static void set_values(modes *m, const mesh *mesh)
{
    for (int a = 0; a < m->end.first; a++) {
        const modes_mode *mode = &m->mode[a];
        const bool turns = a < m->hinges;
        const double from = turns ? 0 : mesh->edges[mode->first_element - m->hinges];
        const double to = turns ? 1 : mesh->edges[mode->last_element + 1 - m->hinges];
        for (int e = mode->first_element; e <= mode->last_element; e++) {
            for (int i = 0; i < m->stages; i++) {
                const int p = e * (m->stages + 1) + i;
                const double y = 2 * (m->s[p] - from) / (to - from) - 1;
                double of[SOLVE_MODES_MAX + 1], slope = 0;
                gauss_legendre(mode->degree, y, of);
                m->value[p * m->width + a] = of[mode->degree];
                for (int k = mode->degree; k > 0; k -= 2) { /* P_k' = P_(k-2)' + (2k - 1) P_(k-1) */
                    slope += (2 * k - 1) * of[k - 1];
                }
                m->feed.slope[p * m->width + a] = 2 / (to - from) * slope;
            }
        }
    }
}

static ad_status allocate(modes *m, ad_error *error)
{
    const size_t points = (size_t)m->points, width = (size_t)m->width;
    AD_TAKE(m, value, points * width);
    AD_TAKE(m, feed.slope, points * width);
    AD_TAKE(m, feed.trial, 4 * (size_t)m->size);
    AD_TAKE(m, feed.q, (size_t)m->size);
    AD_TAKE(m, actuators, points * (size_t)m->rod->actuators);
    AD_TAKE(m, guides, points * (size_t)m->rod->actuators);
    AD_TAKE(m, longer, (size_t)m->rod->actuators * width);
    AD_TAKE(m, pull_by, points);
    AD_TAKE(m, inputs_at, points * (size_t)m->inputs);
    AD_TAKE(m, input, (size_t)m->inputs);
    AD_TAKE(m, center, (size_t)m->inputs);
    AD_TAKE(m, input_step, (size_t)m->inputs);
    AD_TAKE(m, rate, 2 * (size_t)m->inputs);
    AD_TAKE(m, jump_at, (size_t)m->rod->jumps.count);
    AD_TAKE(m, along, points * (size_t)m->rod->along.numbers);
    AD_TAKE(m, turn_at, (size_t)m->elements);
    AD_TAKE(m, theta, points * 3 * width);
    AD_TAKE(m, rho, points * 3 * width);
    AD_TAKE(m, mass, (width + QUAD) * width);
    AD_TAKE(m, end.free, (size_t)m->size);
    AD_TAKE(m, end.faster, 6 * width);
    AD_TAKE(m, end.room, 12 * (size_t)m->size);
    AD_TAKE(m, branch.stretch, width);
    AD_TAKE(m, branch.rate, width);
    AD_TAKE(m, branch.rest_rate, width);
    if (m->rod->frictions > 0) {
        const size_t all = points * (size_t)m->rod->actuators;
        AD_TAKE(m, friction.rub, (size_t)m->rod->frictions * points);
        AD_TAKE(m, friction.left, all);
        for (size_t i = 0; i < all && m->friction.left; i++) {
            m->friction.left[i] = 1;
        }
        gauss_slope(&m->rule, m->friction.slope);
        for (int side = 0; side < 2; side++) {
            gauss_lagrange(&m->rule, side, m->friction.edge[side]);
        }
    }
    AD_TAKE(m, branch.by, m->branch.count > 0 ? (width + QUAD) * width : 0);
    AD_TAKE(m, room, (points * MODES_ROWS + MODES_ROOM) * width);
    return ad_memory_status(&m->memory, error, "out of memory for %d modes", m->size);
}

/* Where something acts at single places. What acts at s = 0 the support takes. */
static ad_status set_jumps(modes *m, ad_error *error)
{
    const solve_jumps *jumps = &m->rod->jumps;
    for (int e = 0; e < m->elements; e++) {
        m->turn_at[e] = -1;
    }
    for (int k = 0; k < jumps->count; k++) {
        const solve_jump *jump = &jumps->at[k];
        m->jump_at[k] = -1;
        for (int e = 0; e < m->elements && jump->s > SOLVE_SAME_PLACE; e++) {
            const int p = (e + 1) * (m->stages + 1) - 1;
            if (fabs(m->s[p] - jump->s) <= SOLVE_SAME_PLACE) {
                m->jump_at[k] = p;
                m->turn_at[e] = jump->turns ? k : -1;
            }
        }
        if (m->jump_at[k] < 0 && jump->s > SOLVE_SAME_PLACE) {
            return ad_fail(error, AD_BAD_ARGUMENT, "s = %g, where something acts, is no edge",
                           jump->s);
        }
    }
    return AD_OK;
}

static ad_status fill(modes *m, const solve_parameters *open, int finer, ad_error *error)
{
    mesh x = {0};
    ad_status status = find_mesh(m->rod, m->inputs, &m->counts, finer, &x, error);
    if (status == AD_OK) {
        status = modes_turn_find(m, open, error);
    }
    if (status == AD_OK) {
        m->hinges = !m->rod->ends[0].holds_rotation ? HINGES : m->turn.mode >= 0;
        m->elements = x.elements + m->hinges;
        m->stages = x.stages;
        m->points = m->elements * (m->stages + 1);
        m->rule = solve_gauss_rule_of(m->stages);
        AD_TAKE(m, element, (size_t)m->elements);
        AD_TAKE(m, point, (size_t)m->points);
        AD_TAKE(m, s, (size_t)m->points);
        status = ad_memory_status(&m->memory, error, "out of memory for modes");
    }
    if (status == AD_OK) {
        set_elements(m, &x);
        status = set_modes(m, &x, open, error);
    }
    status = status == AD_OK ? allocate(m, error) : status;
    if (status == AD_OK) {
        set_values(m, &x);
        status = set_jumps(m, error);
    }
    if (status == AD_OK) {
        m->is_pulled = m->rod->actuators > 0;
        m->is_coupled = m->rod->scene.rod.law || law_table[LAW_ELASTIC].couples ||
                        law_table[LAW_DAMPING].couples;
        for (int i = 0; i < m->rod->actuators; i++) {
            m->is_coupled = m->is_coupled || law_table[m->rod->extents[i].law].couples;
        }
        m->inertia_couples = scene_couples_inertia(&m->rod->scene);
        m->feed.input = m->feed.mode >= 0 ? m->rod->scene.feed.by : -1;
        if (m->feed.input >= 0) {
            m->feed.from = m->feed.out = open->values[m->feed.input];
        }
        status = modes_feed_create(m, error);
    }
    if (status == AD_OK) {
        status = modes_at(m, 0, open ? open->values : NULL, error);
    }
    status = status == AD_OK ? modes_end_find(m, error) : status;
    solve_quadrature_free(x.places);
    free(x.edges);
    return status;
}

ad_status modes_create(solve_rod *rod, const solve_parameters *open, const modes_counts *counts,
                       int finer, modes **result, ad_error *error)
{
    ad_status status = support_check(&rod->scene, SUPPORT_MODES, NULL, error);
    *result = NULL;
    if (status != AD_OK) {
        return status;
    }
    modes *m = calloc(1, sizeof *m);
    if (!m) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for modes");
    }
    m->rod = rod;
    m->rest_moves = rod->rest_moves;
    m->feed.mode = m->turn.mode = m->turn.input = -1;
    m->inputs = open ? open->count : 0;
    m->counts = *counts;
    status = fill(m, open, finer, error);
    if (status != AD_OK) {
        modes_free(m);
        return status;
    }
    *result = m;
    return AD_OK;
}

void modes_free(modes *m)
{
    if (m) {
        ad_memory_free(&m->memory);
        for (int i = 0; i < SOLVE_PARTS; i++) {
            free(m->affine[i].base);
            free(m->affine[i].of);
        }
        free(m);
    }
}

int modes_size(const modes *m)
{
    return m->size;
}
