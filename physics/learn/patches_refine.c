/* Degrees and patches: what the last coefficients of a solution say of them. */
#include "physics/learn/patches_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FUNCTIONS_MAX = 400, CELLS_MAX = 2048 };

/* Degrees that suit a tolerance, a little more along coordinates of derivatives of higher order. */
static void choose_degrees(patch_run *r)
{
    const patch_problem *p = &r->problem;
    const double digits = fmin(14, fmax(1, -log10(r->local)));
    double functions = 1;
    for (int d = 0; d < p->dims; d++) {
        int order = 0;
        for (int f = 0; f < p->outputs; f++) {
            order = p->order[f][d] > order ? p->order[f][d] : order;
        }
        const double degree =
            p->marches && d == patch_time(r) ? 2 + digits + order : 3 + 1.4 * digits + order - 2;
        r->degree[d] = (int)fmin(PATCH_DEGREE - PATCH_RICHER, fmax(4, round(degree)));
        functions *= r->degree[d] + 1;
    }
    while (functions * p->outputs > FUNCTIONS_MAX) { /* the highest first */
        int most = 0;
        for (int d = 1; d < p->dims; d++) {
            most = r->degree[d] > r->degree[most] ? d : most;
        }
        if (r->degree[most] <= 4) {
            break;
        }
        functions *= (double)r->degree[most] / (r->degree[most] + 1);
        r->degree[most]--;
    }
}

/* Even cells, and the edges of panels that are not at theirs. */
static bool begin_edges(patch_run *r, int d, int even, int panels)
{
    const domain_coordinate *c = &r->problem.model->domain.coordinates[d];
    const double apart = 1e-9 * (c->high - c->low);
    double *edges = malloc(((size_t)even + (size_t)panels + 1) * sizeof *edges);
    int count = 0, next = 0;
    for (int i = 0; i <= even && edges; i++) {
        const double edge = i == even ? c->high : c->low + (c->high - c->low) * i / even;
        while (next < panels && r->panels.edge[d][next] < edge + apart) {
            const double panel = r->panels.edge[d][next++];
            if (count > 0 && panel - edges[count - 1] > apart && edge - panel > apart) {
                edges[count++] = panel;
            }
        }
        edges[count++] = edge;
    }
    free(r->edges[d]);
    r->edges[d] = edges;
    r->cells[d] = count - 1;
    return edges != NULL;
}

bool patch_begin(patch_run *r)
{
    const patch_problem *p = &r->problem;
    choose_degrees(r);
    int coordinates = p->dims - (p->marches ? 1 : 0);
    for (int d = 0; d < p->dims; d++) {
        const bool is_time = p->marches && d == patch_time(r);
        const int even = !is_time && coordinates == 1 ? 4 : 1;
        if (!begin_edges(r, d, even, is_time ? 0 : r->panels.count[d])) {
            return false;
        }
    }
    return true;
}

double patch_panel_end(const patch_run *r, double begin, double end)
{
    const int time = patch_time(r);
    for (int i = 0; i < r->panels.count[time]; i++) {
        const double edge = r->panels.edge[time][i];
        if (edge > begin + 1e-10 * (end - begin) && edge < end) {
            return edge;
        }
    }
    return end;
}

static bool is_panel(const patch_run *r, int coordinate, double edge)
{
    for (int i = 0; i < r->panels.count[coordinate]; i++) {
        if (r->panels.edge[coordinate][i] == edge) {
            return true;
        }
    }
    return false;
}

/* ---- how well a grid resolves ---------------------------------------------------------------- */

/* Root mean square in a patch of the functions of the last two degrees along a coordinate, relative
 * to the size of the outputs, the worst of these. */
static double tail_of(const patch_run *r, const patch_grid *grid, int patch, int coordinate)
{
    double worst = 0;
    for (int f = 0; f < grid->outputs; f++) {
        const double *c = grid->c + patch_first(grid, patch, f);
        double sum = 0;
        for (int j = 0; j < grid->functions; j++) {
            if (patch_degree(grid, j, coordinate) >= grid->degree[coordinate] - 1) {
                sum += c[j] * c[j];
            }
        }
        worst = fmax(worst, sqrt(sum) / r->problem.scale[f]);
    }
    return worst;
}

/* What an error of a patch counts: all of the patches together may have the tolerance. */
static double share_of(const patch_grid *grid, int patch, double volume)
{
    return sqrt(patch_volume(grid, patch) / volume * grid->patches);
}

void patch_find_scale(patch_run *r, const patch_grid *grid, bool *changed)
{
    patch_problem *p = &r->problem;
    const double volume = patch_grid_volume(grid);
    double size[PATCH_OUTPUTS] = {0}, most = 0;
    for (int k = 0; k < grid->patches; k++) {
        const double part = patch_volume(grid, k);
        for (size_t i = 0; i < patch_grid_size(grid); i++) {
            const double c = grid->c[(size_t)k * patch_grid_size(grid) + i];
            size[i / (size_t)grid->functions] += part * c * c;
        }
    }
    *changed = false;
    for (int f = 0; f < p->outputs; f++) {
        size[f] = sqrt((r->squares[f] + size[f]) / (r->volume + volume));
        most = fmax(most, size[f]);
    }
    for (int f = 0; f < p->outputs; f++) {
        const double now = size[f] > 1e-8 * most ? size[f] : most > 0 ? most : 1;
        *changed = *changed || now > 10 * p->scale[f] || p->scale[f] > 10 * now;
        p->scale[f] = now;
    }
}

int patch_refine(patch_run *r, const patch_grid *grid, int coordinate, bool merge)
{
    enum { KEEP, HALVE, JOIN };
    const int cells = grid->cells[coordinate];
    const double *edge = grid->edge[coordinate];
    char *what = calloc((size_t)cells, 1);
    double *tail = calloc((size_t)cells, sizeof *tail);
    double *edges = malloc((2 * (size_t)cells + 1) * sizeof *edges);
    int halved = 0, next = 0;
    if (!what || !tail || !edges) {
        free(what);
        free(tail);
        free(edges);
        return 0;
    }
    const double volume = patch_grid_volume(grid);
    for (int k = 0; k < grid->patches; k++) {
        const int cell = patch_cell(grid, k, coordinate);
        const double share = share_of(grid, k, volume);
        double *worst = &tail[cell];
        *worst = fmax(*worst, share * tail_of(r, grid, k, coordinate));
        /* a layer that is not seen is there, if anywhere; in time it would be any corner */
        if (!r->problem.marches && (cell == 0 || cell == cells - 1)) {
            *worst = fmax(*worst, share * grid->missed[k]);
        }
    }
    for (int i = 0; i < cells; i++) {
        const bool can = edge[i + 1] - edge[i] > 1e-9 * (edge[cells] - edge[0]);
        if (tail[i] > r->local && can && cells + halved < CELLS_MAX) {
            what[i] = HALVE;
            halved++;
        }
    }
    const double longer = pow(2, grid->degree[coordinate] + 1);
    for (int i = 0; i + 1 < cells && merge; i++) {
        const double ratio = (edge[i + 2] - edge[i + 1]) / (edge[i + 1] - edge[i]);
        if (what[i] == KEEP && what[i + 1] == KEEP && ratio > 0.49 && ratio < 2.1 && cells > 2 &&
            !is_panel(r, coordinate, edge[i + 1]) &&
            fmax(tail[i], tail[i + 1]) * longer * 10 < r->local) {
            what[i] = JOIN;
            i++;
        }
    }
    edges[next++] = edge[0];
    for (int i = 0; i < cells; i++) {
        if (what[i] == HALVE) {
            edges[next++] = (edge[i] + edge[i + 1]) / 2;
        }
        if (what[i] != JOIN) {
            edges[next++] = edge[i + 1];
        }
    }
    free(what);
    free(tail);
    free(r->edges[coordinate]);
    r->edges[coordinate] = edges;
    r->cells[coordinate] = next - 1;
    return halved;
}

double patch_length_factor(const patch_run *r, const patch_grid *grid)
{
    const int time = patch_time(r);
    const double volume = patch_grid_volume(grid);
    double tail = 0;
    if (!r->problem.marches) {
        return 1;
    }
    for (int k = 0; k < grid->patches; k++) {
        tail = fmax(tail, share_of(grid, k, volume) * tail_of(r, grid, k, time));
    }
    return fmin(2, 0.9 * pow(r->local / fmax(tail, 1e-300), 1.0 / grid->degree[time]));
}
