/* Members side by side, made: the meshes on which they are solved. */
#include "physics/chain/strain_group.h"

#include <stdlib.h>

/* Points in an element, and parts of each element between places where something jumps. */
typedef struct mesh_kind {
    int stages, parts;
} mesh_kind;
static const mesh_kind MESHES[] = {{3, 1},  {4, 1},  {6, 1},  {8, 1},  {10, 1},
                                   {12, 1}, {12, 2}, {12, 4}, {12, 8}, {12, 16}};

enum { MESH_COUNT = sizeof MESHES / sizeof *MESHES };

/* The first two where strains are the same all along an element: one point has them, and two
 * confirm it. Positions, along arcs of circles, need as many points as elsewhere. */
static const mesh_kind UNIFORM[] = {{1, 1}, {2, 1}};

enum { UNIFORM_COUNT = sizeof UNIFORM / sizeof *UNIFORM, UNIFORM_SKIPS = 2 };
_Static_assert((int)MESH_COUNT <= (int)STRAIN_LEVELS_MAX, "a level for each");

/* Where the coarsest mesh has so many points in an element, the longest is at most that long: a
 * rod of one piece begins with 6. */
static const double LONGEST[] = {0.35, 0.65};

/* Most nodes of a mesh with equations, and where the matrix is a full one. */
enum { NODES_MAX = 400, FULL_NODES_MAX = 100 };

static int coarsest(const strain_group *group, int elements, const double *edges)
{
    if (group->is_uniform) {
        return 0;
    }
    double longest = 0;
    for (int e = 0; e < elements; e++) {
        longest = fmax(longest, edges[e + 1] - edges[e]);
    }
    return longest <= LONGEST[0] ? 0 : longest <= LONGEST[1] ? 1 : 2;
}

static mesh_kind kind_of(const strain_group *group, int mesh)
{
    if (group->is_uniform) {
        return mesh < UNIFORM_COUNT ? UNIFORM[mesh] : MESHES[mesh + UNIFORM_SKIPS];
    }
    return MESHES[mesh];
}

/* On how many meshes equations are solved; 0: not even on two. */
static int count_solved(const strain_group *group, int first, int elements, int most)
{
    int end = first;
    const int count = MESH_COUNT - (group->is_uniform ? UNIFORM_SKIPS : 0);
    while (end < count - STRAIN_BEYOND &&
           elements * kind_of(group, end).parts * kind_of(group, end).stages <= most) {
        end++;
    }
    return end - first < 2 ? 0 : end - first;
}

static ad_status add_level(strain_group *group, int elements, const double *edges, int outputs,
                           const double *s, ad_error *error)
{
    const mesh_kind kind = kind_of(group, coarsest(group, elements, edges) + group->levels);
    const int parts = kind.parts, stages = kind.stages;
    double *divided = malloc(((size_t)(elements * parts) + 1) * sizeof *divided);
    if (!divided) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a mesh");
    }
    for (int i = 0; i < elements * parts; i++) {
        const double *edge = edges + i / parts;
        divided[i] = edge[0] + (edge[1] - edge[0]) * (i % parts) / parts;
    }
    divided[elements * parts] = edges[elements];
    ad_status status = strain_level_create(group->rod, stages, elements * parts, divided,
                                           group->levels >= group->solved, outputs, s,
                                           &group->level[group->levels], error);
    if (status == AD_OK && group->levels > 0) {
        status = strain_link_create(&group->level[group->levels - 1], &group->level[group->levels],
                                    &group->link[group->levels], error);
    }
    group->levels++;
    free(divided);
    return status;
}

/* Whether strains are the same all along each element, of members that are spread over their
 * ranges: nothing but what pulls along the rod acts, and what is given is the same. Others may
 * differ, and need a finer mesh then. */
static ad_status find_uniform(strain_group *group, int elements, const double *edges,
                              ad_error *error)
{
    const solve_rod *rod = group->rod;
    const size_t count = (size_t)group->count;
    strain_level probe;
    if (rod->along.count > 0 || rod->jumps.numbers > 0 || rod->tubes > 0) {
        return AD_OK;
    }
    ad_status status = strain_level_create(rod, 3, elements, edges, false, 0, edges, &probe, error);
    double *room = NULL, *parameters = malloc((LANES * count + 1) * sizeof *parameters);
    if (status == AD_OK) {
        room = malloc((strain_level_room(&probe, rod) + 1) * sizeof *room);
        status = room && parameters ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    }
    for (size_t k = 0; k < LANES * count && status == AD_OK; k++) {
        const int i = (int)(k % count);
        const double fraction = scene_spread_fraction((int)(k / count), i);
        parameters[k] = scene_parameter_at(&rod->scene.parameters[i], fraction);
    }
    if (status == AD_OK) {
        status = strain_level_give(&probe, rod, group->count, parameters, room, error);
        group->is_uniform = status == AD_OK && strain_level_is_uniform(&probe);
    }
    strain_level_free(&probe);
    free(room);
    free(parameters);
    return status;
}

ad_status strain_group_create(solve_rod *rod, int count, double tolerance, bool own_curvature,
                              int elements, const double *edges, int outputs, const double *s,
                              strain_group **result, ad_error *error)
{
    strain_group *group = calloc(1, sizeof *group);
    *result = NULL;
    if (!group) {
        solve_rod_free(rod);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for members");
    }
    *group = (strain_group){.rod = rod, .count = count, .tolerance = tolerance};
    size_t room = 0, nodes = 0, unknowns = 0;
    ad_status status = own_curvature ? find_uniform(group, elements, edges, error) : AD_OK;
    const int first = coarsest(group, elements, edges);
    const solve_end *end = &rod->ends[1];
    bool is_full = rod->along.by_position || rod->frictions > 0 || rod->tubes > 0 ||
                   end->hold.directions > 0 || end->holds_rotation;
    for (int i = 0; i < rod->jumps.count; i++) {
        is_full = is_full || rod->jumps.at[i].acting.by_position;
    }
    const int most = is_full ? FULL_NODES_MAX : NODES_MAX;
    group->solved = count_solved(group, first, elements, most);
    if (status == AD_OK && group->solved == 0) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "members: something jumps in %d places; allowed: up to %d", elements - 1,
                         most / kind_of(group, first + 1).stages - 1);
    }
    for (int k = 0; k < group->solved + STRAIN_BEYOND && status == AD_OK; k++) {
        status = add_level(group, elements, edges, outputs, s, error);
    }
    for (int k = 0; k < group->levels && status == AD_OK; k++) {
        size_t more = strain_level_room(&group->level[k], rod);
        room = more > room ? more : room;
        nodes = (size_t)group->level[k].form->nodes;
        unknowns = (size_t)fmax((double)unknowns, group->level[k].form->unknowns);
    }
    if (status == AD_OK) {
        AD_TAKE(group, parameters, LANES * (size_t)count + 1);
        AD_TAKE(group, room, room);
        AD_TAKE(group, start, unknowns);
        AD_TAKE(group, before, unknowns);
        AD_TAKE(group, placed, 3 * nodes + 3);
        AD_TAKE(group, other, 3 * nodes + 3);
        AD_TAKE(group, values, (size_t)outputs * SOLVE_MEMBERS_COLUMNS + 1);
        const size_t along = LANES * (size_t)outputs;
        AD_TAKE(group, outputs, along + 1);
        AD_TAKE(group, growth, along + 1);
        AD_TAKE(group, each, along * (size_t)count + 1);
        if (group->memory.is_short) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for members");
        }
        for (size_t i = 0; i < along && status == AD_OK; i++) {
            group->outputs[i] = s[i % (size_t)outputs];
            group->growth[i] = 1;
        }
    }
    if (status == AD_OK) { /* formulas have their memory then */
        const double none[SCENE_PARAMETERS_MAX] = {0};
        status = strain_group_parameters(group, 1, none, error);
    }
    for (int k = 0; k < group->levels && status == AD_OK; k++) {
        status =
            strain_level_give(&group->level[k], rod, count, group->parameters, group->room, error);
    }
    status = status == AD_OK ? strain_group_choose(group, 1, error) : status;
    if (status != AD_OK) {
        strain_group_free(group);
        return status;
    }
    *result = group;
    return AD_OK;
}

static void free_links(strain_group *group)
{
    for (int k = 0; k < group->solved; k++) {
        strain_link_free(&group->sample[k]);
    }
    strain_link_free(&group->beyond);
    strain_link_free(&group->back);
}

ad_status strain_group_choose(strain_group *group, int modes, ad_error *error)
{
    ad_status status = AD_OK;
    free_links(group);
    group->modes = modes;
    for (int k = 0; k < group->solved && status == AD_OK; k++) {
        status =
            strain_link_create(&group->level[k], &group->level[modes], &group->sample[k], error);
    }
    const strain_level *of = &group->level[modes], *fine = of + STRAIN_BEYOND;
    status = status == AD_OK ? strain_link_create(of, fine, &group->beyond, error) : status;
    return status == AD_OK ? strain_link_create(fine, of, &group->back, error) : status;
}

void strain_group_free(strain_group *group)
{
    if (group) {
        free_links(group);
        for (int k = 0; k < group->levels; k++) {
            strain_link_free(&group->link[k]);
            strain_level_free(&group->level[k]);
        }
        solve_rod_free(group->rod);
        ad_memory_free(&group->memory);
        free(group);
    }
}
