#include "physics/local/mesh.h"

#include "physics/numerics/sort.h"

#include <math.h>

int solve_mesh_places(int count, double *s)
{
    int kept = 0;
    sort_ascending((size_t)count, s);
    for (int i = 0; i < count; i++) {
        if (kept == 0 || s[i] > s[kept - 1] + SOLVE_SAME_PLACE) {
            s[kept++] = s[i] < SOLVE_SAME_PLACE ? 0 : s[i] > 1 - SOLVE_SAME_PLACE ? 1 : s[i];
        }
    }
    return kept;
}

int solve_mesh_edges(int elements, int places, const double *place, double *edges)
{
    static const double rounding = 1e-9; /* of an element: no more elements for it */
    int count = 0;
    double from = 0;
    for (int i = 0; i <= places; i++) {
        double to = i < places ? place[i] : 1;
        if (to > from) {
            int parts = (int)fmax(1, ceil((to - from) * elements - rounding));
            for (int k = 0; k < parts; k++) {
                edges[count++] = from + (to - from) * k / parts;
            }
            from = to;
        }
    }
    edges[count] = 1;
    return count;
}
