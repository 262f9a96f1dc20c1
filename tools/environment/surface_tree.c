#include "tools/environment/surface_tree.h"

#include "tools/environment/environment.h"

#include <math.h>
#include <stdlib.h>

/* Of a leaf at most: more take longer, fewer have more boxes. */
enum { IN_LEAF = 8 };

typedef struct builder {
    const surface *of;
    surface_tree *to;
    struct placed {
        double middle[3];
        int triangle, axis; /* by which it is sorted */
    } * placed;
} builder;

static int compare(const void *one, const void *other)
{
    const struct placed *const a = one, *const b = other;
    const double x = a->middle[a->axis], y = b->middle[a->axis];
    return x < y ? -1 : x > y ? 1 : (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

/* Where triangles of a node begin: 2^depth is the first one of its level. */
static size_t first_of(const builder *b, size_t node, int depth)
{
    return ((node - ((size_t)1 << depth)) * b->of->triangles) >> depth;
}

/* Half of its triangles to each side along the axis on which they are longest. */
static void divide(builder *b, size_t node, int depth)
{
    const size_t first = first_of(b, node, depth), end = first_of(b, node + 1, depth);
    double longest = -1;
    int axis = 0;
    if (depth == b->to->tree.levels) {
        return;
    }
    for (int i = 0; i < 3; i++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t t = first; t < end; t++) {
            low = fmin(low, b->placed[t].middle[i]);
            high = fmax(high, b->placed[t].middle[i]);
        }
        axis = high - low > longest ? i : axis;
        longest = fmax(longest, high - low);
    }
    for (size_t t = first; t < end; t++) {
        b->placed[t].axis = axis;
    }
    qsort(b->placed + first, end - first, sizeof *b->placed, compare);
    divide(b, 2 * node, depth + 1);
    divide(b, 2 * node + 1, depth + 1);
}

static void find_box(builder *b, size_t node, int depth)
{
    float *const box = b->to->box + 6 * node;
    for (int i = 0; i < 3; i++) {
        box[i] = INFINITY;
        box[3 + i] = -INFINITY;
    }
    if (depth < b->to->tree.levels) {
        for (size_t child = 2 * node; child <= 2 * node + 1; child++) {
            find_box(b, child, depth + 1);
            for (size_t i = 0; i < 3; i++) {
                box[i] = fminf(box[i], b->to->box[6 * child + i]);
                box[3 + i] = fmaxf(box[3 + i], b->to->box[6 * child + 3 + i]);
            }
        }
        return;
    }
    for (size_t k = 3 * first_of(b, node, depth); k < 3 * first_of(b, node + 1, depth); k++) {
        const float *const corner = b->to->corner + 3 * (size_t)b->to->triangle[k];
        for (int i = 0; i < 3; i++) {
            box[i] = fminf(box[i], corner[i]);
            box[3 + i] = fmaxf(box[3 + i], corner[i]);
        }
    }
}

static void build(builder *b)
{
    const surface *const of = b->of;
    surface_tree *const to = b->to;
    double largest = 0, moved = 0;
    for (size_t k = 0; k < of->corners; k++) {
        double square = 0;
        for (size_t i = 3 * k; i < 3 * k + 3; i++) {
            b->to->corner[i] = (float)of->corner[i];
            square += (b->to->corner[i] - of->corner[i]) * (b->to->corner[i] - of->corner[i]);
            largest = fmax(largest, fabs(of->corner[i]));
        }
        moved = fmax(moved, sqrt(square));
    }
    to->error = moved + 1e-12 * largest; /* and rounding of doubles, as tested */
    for (size_t t = 0; t < of->triangles; t++) {
        b->placed[t] = (struct placed){.triangle = (int)t};
        for (size_t k = 0; k < 9; k++) {
            b->placed[t].middle[k % 3] +=
                of->corner[3 * (size_t)of->triangle[3 * t + k / 3] + k % 3];
        }
    }
    divide(b, 1, 0);
    for (size_t k = 0; k < 3 * of->triangles; k++) {
        b->to->triangle[k] = (int)of->triangle[3 * (size_t)b->placed[k / 3].triangle + k % 3];
    }
    find_box(b, 1, 0);
}

static int sign_of(environment_side side)
{
    return side == ENVIRONMENT_ANY ? 0 : side == ENVIRONMENT_OUTSIDE ? 1 : -1;
}

ad_status surface_tree_create(const surface *of, environment_side side, surface_tree **result,
                              ad_error *error)
{
    int levels = 0;
    while (levels < TRIANGLE_TREE_LEVELS_MAX && of->triangles >> levels > IN_LEAF) {
        levels++;
    }
    surface_tree *const to = calloc(1, sizeof *to);
    builder b = {of, to, malloc(of->triangles * sizeof *b.placed)};
    if (to) {
        to->tree = (triangle_tree){.corners = (int)of->corners,
                                   .triangles = (int)of->triangles,
                                   .levels = levels,
                                   .side = sign_of(side)};
        to->tree.corner = to->corner = malloc(3 * of->corners * sizeof *to->corner);
        to->tree.triangle = to->triangle = malloc(3 * of->triangles * sizeof *to->triangle);
        to->tree.box = to->box = calloc(6 * TRIANGLE_TREE_BOXES(&to->tree), sizeof *to->box);
    }
    const bool has_room = to && b.placed && to->corner && to->triangle && to->box;
    *result = has_room ? to : NULL;
    if (has_room) {
        build(&b);
    } else {
        surface_tree_free(to);
    }
    free(b.placed);
    return has_room ? AD_OK
                    : ad_fail(error, AD_NO_MEMORY, "out of memory for a tree of %zu triangles",
                              of->triangles);
}

ad_status surface_tree_open(const environment_settings *settings, double length,
                            surface_tree **result, ad_error *error)
{
    surface *of = NULL;
    *result = NULL;
    ad_status status = surface_open(settings, &of, error);
    status = status == AD_OK ? surface_check_size(of, length, error) : status;
    if (status == AD_OK && settings->side != ENVIRONMENT_ANY) {
        status = surface_check_closed(of, error);
    }
    status = status == AD_OK ? surface_tree_create(of, settings->side, result, error) : status;
    surface_free(of);
    return status;
}

void surface_tree_free(surface_tree *of)
{
    if (of) {
        free(of->corner);
        free(of->triangle);
        free(of->box);
        free(of);
    }
}
