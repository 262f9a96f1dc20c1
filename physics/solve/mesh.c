#include "physics/solve/mesh.h"

#include <math.h>

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
