/* Order the nodes of a pass and give each a place in the workspace.
 *
 * Order: by level, the number of matrix products on the longest way from the inputs, so that the
 * Taylor coefficients of one layer meet at one matrix product. Within a level products come first,
 * then elementwise work, then sums. What is not needed in its own level moves to the level of its
 * first use, so that it does not occupy memory in between.
 *
 * Place: the parts of a stack are computed inside the stack; values multiplied by the same matrix
 * are columns of one panel. What remains are buffers with a life from first to last position, put
 * at the lowest free address, first come first served. */
#include "autodiff/compile/program.h"

#include <stdlib.h>
#include <string.h>

enum { PANEL_COLUMNS_MAX = 32 };

static bool in_pass(const pass_plan *plan, int id)
{
    return plan->nodes[id].op != OP_COUNT;
}

int ad_plan_argument(const pass_plan *plan, int id, int i)
{
    const node *n = &plan->nodes[id];
    return n->count <= AD_ARITY_MAX ? plan->arguments[id][i] : plan->tape->arguments[n->first + i];
}

bool ad_plan_is_product(const pass_plan *plan, int id)
{
    return op_is_matvec(plan->nodes[id].op) &&
           plan->tape->nodes[ad_plan_argument(plan, id, 0)].extent == AD_UNIFORM;
}

/* ---- order --------------------------------------------------------------------------------- */

/* A product with a matrix of each member: with products, but by itself. */
static bool is_member_product(const pass_plan *plan, int id)
{
    return op_is_matvec(plan->nodes[id].op) &&
           spread_of(plan->tape, ad_plan_argument(plan, id, 0)) >= 0;
}

static int phase_of(const pass_plan *plan, int id)
{
    int op = plan->nodes[id].op;
    bool first = op == OP_SPREAD || ad_plan_is_product(plan, id) || is_member_product(plan, id);
    return first ? 0 : op_is_reduction(op) ? 2 : 1;
}

/* Does its level come after those of its operands? */
static bool is_step(const pass_plan *plan, int id)
{
    return phase_of(plan, id) == 0 && plan->nodes[id].op != OP_SPREAD;
}

static void assign_levels(pass_plan *plan, int *latest)
{
    for (int id = 0; id < plan->count; id++) {
        latest[id] = 1 << 30;
        plan->level[id] = 0;
        for (int i = 0; in_pass(plan, id) && i < plan->nodes[id].count; i++) {
            int argument = ad_plan_argument(plan, id, i);
            int level = in_pass(plan, argument) ? plan->level[argument] : 0;
            level += is_step(plan, id);
            plan->level[id] = level > plan->level[id] ? level : plan->level[id];
        }
    }
    for (int id = plan->count - 1; id >= 0; id--) { /* users come later: their level is final */
        if (!in_pass(plan, id)) {
            continue;
        }
        if ((phase_of(plan, id) == 1 || plan->nodes[id].op == OP_SPREAD) && latest[id] < 1 << 30 &&
            latest[id] > plan->level[id]) {
            plan->level[id] = latest[id];
        }
        int limit = plan->level[id] - is_step(plan, id);
        for (int i = 0; i < plan->nodes[id].count; i++) {
            int *l = &latest[ad_plan_argument(plan, id, i)];
            *l = limit < *l ? limit : *l;
        }
    }
}

/* Counting sort by (level, phase), stable in the order of the tape. */
static void assign_order(pass_plan *plan, int *starts, int buckets)
{
    memset(starts, 0, ((size_t)buckets + 1) * sizeof *starts);
    for (int id = 0; id < plan->count; id++) {
        if (in_pass(plan, id)) {
            starts[3 * plan->level[id] + phase_of(plan, id) + 1]++;
            plan->ordered++;
        }
    }
    for (int i = 0; i < buckets; i++) {
        starts[i + 1] += starts[i];
    }
    for (int id = 0; id < plan->count; id++) {
        if (in_pass(plan, id)) {
            int at = starts[3 * plan->level[id] + phase_of(plan, id)]++;
            plan->order[at] = id;
            plan->position[id] = at;
        }
    }
}

/* ---- parts of stacks ------------------------------------------------------------------------ */

static void place_parts(pass_plan *plan)
{
    for (int id = 0; id < plan->count; id++) {
        plan->parent[id] = -1;
        plan->panel[id] = -1;
    }
    for (int id = 0; id < plan->count; id++) {
        const node *n = &plan->nodes[id];
        if (n->op == OP_SLICE) {
            plan->parent[id] = ad_plan_argument(plan, id, 0);
            plan->row[id] = n->whole;
        }
        int row = 0;
        for (int i = 0; n->op == OP_STACK && i < n->count; i++) {
            int part = ad_plan_argument(plan, id, i);
            if (in_pass(plan, part) && plan->parent[part] < 0 &&
                op_is_elementwise(plan->nodes[part].op)) {
                plan->parent[part] = id;
                plan->row[part] = row;
            }
            row += plan->tape->nodes[part].rows;
        }
    }
}

/* ---- panels --------------------------------------------------------------------------------- */

/* May become a column: has a buffer of its own that a panel can replace. */
static bool is_free(const pass_plan *plan, int id)
{
    return in_pass(plan, id) && plan->parent[id] < 0 && plan->panel[id] < 0 &&
           plan->nodes[id].op != OP_INPUT;
}

static void make_panel(pass_plan *plan, int count, const int *ids)
{
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < i; k++) {
            if (ids[k] == ids[i]) {
                return;
            }
        }
        if (!is_free(plan, ids[i]) || plan->nodes[ids[i]].rows != plan->nodes[ids[0]].rows) {
            return;
        }
    }
    for (int i = 0; i < count; i++) {
        plan->panel[ids[i]] = plan->panels;
        plan->column[ids[i]] = i;
    }
    /* Rows a large power of two apart would share few sets of the cache: an unused column helps. */
    plan->panel_columns[plan->panels++] = count + (count % 4 == 0);
}

/* Bring members into the order of the columns that one of their arguments already has. */
static void sort_by_column(const pass_plan *plan, int count, int *ids, int argument)
{
    for (int i = 1; i < count; i++) {
        for (int k = i; k > 0; k--) {
            int a = ad_plan_argument(plan, ids[k - 1], argument);
            int b = ad_plan_argument(plan, ids[k], argument);
            if (plan->panel[a] < 0 || plan->panel[a] != plan->panel[b] ||
                plan->column[a] <= plan->column[b]) {
                break;
            }
            int swap = ids[k];
            ids[k] = ids[k - 1];
            ids[k - 1] = swap;
        }
    }
}

/* The nodes after `at` that do the same with the same matrix, or add to the same sum. */
static int gather(const pass_plan *plan, int at, bool *seen, int *ids)
{
    int first = plan->order[at], op = plan->nodes[first].op, count = 0;
    bool sum = op == OP_OUTER_SUM;
    for (int i = at; i < plan->ordered && count < PANEL_COLUMNS_MAX; i++) {
        int id = plan->order[i];
        bool alike = plan->nodes[id].op == op &&
                     (sum ? plan->sum_of[id] == plan->sum_of[first]
                          : plan->level[id] == plan->level[first] &&
                                plan->arguments[id][0] == plan->arguments[first][0]);
        if (alike && !seen[id]) {
            seen[id] = true;
            ids[count++] = id;
        }
    }
    return count;
}

/* Are some second arguments columns side by side, so that one product serves them? */
static bool has_columns(const pass_plan *plan, int count, const int *ids)
{
    bool found = false;
    for (int i = 1; i < count; i++) {
        const int a = ad_plan_argument(plan, ids[i - 1], 1), b = ad_plan_argument(plan, ids[i], 1);
        found = found || (plan->panel[a] >= 0 && plan->panel[a] == plan->panel[b] &&
                          plan->column[b] == plan->column[a] + 1);
    }
    return found;
}

/* Products see their second argument and themselves as panels; sums their two arguments. */
static void panels_of(pass_plan *plan, int op, bool *seen)
{
    for (int at = 0; at < plan->ordered; at++) {
        int first = plan->order[at], ids[PANEL_COLUMNS_MAX], values[PANEL_COLUMNS_MAX];
        if (plan->nodes[first].op != op || seen[first] ||
            (op != OP_OUTER_SUM && !ad_plan_is_product(plan, first))) {
            continue;
        }
        int count = gather(plan, at, seen, ids);
        if (count < 2) {
            continue;
        }
        sort_by_column(plan, count, ids, 1);
        for (int i = 0; i < count; i++) {
            values[i] = ad_plan_argument(plan, ids[i], op == OP_OUTER_SUM ? 0 : 1);
        }
        make_panel(plan, count, values);
        sort_by_column(plan, count, ids, 1);
        if (op != OP_OUTER_SUM && has_columns(plan, count, ids)) {
            make_panel(plan, count, ids);
        }
    }
}

/* ---- addresses ------------------------------------------------------------------------------ */

typedef struct buffer {
    int rows, columns;
    int born, dies; /* positions */
    int lingers;    /* last position of the elementwise run in which it dies */
    int offset;
    int owner;  /* value, or -1 - panel */
    bool local; /* as in place */
} buffer;

/* The value whose buffer holds `id`, with the row of `id` in it. */
static int root_of(const pass_plan *plan, int id, int *row)
{
    *row = 0;
    while (plan->parent[id] >= 0) {
        *row += plan->row[id];
        id = plan->parent[id];
    }
    return id;
}

static int compare_born(const void *a, const void *b)
{
    const buffer *buffer = a, *y = b;
    return buffer->born != y->born ? (buffer->born < y->born ? -1 : 1)
                                   : (buffer->owner > y->owner) - (buffer->owner < y->owner);
}

static int compare_offset(const void *a, const void *b)
{
    const buffer *const *x = a, *const *y = b;
    return ((*x)->offset > (*y)->offset) - ((*x)->offset < (*y)->offset);
}

/* Memory of the same shape, dead but not yet to be cut up: taken as it is. */
static bool take_over(buffer **live, int alive, buffer *b)
{
    for (int k = 0; k < alive; k++) {
        if (live[k]->dies < b->born && live[k]->rows == b->rows && live[k]->columns == b->columns &&
            live[k]->local == b->local) {
            b->offset = live[k]->offset;
            live[k] = b;
            return true;
        }
    }
    return false;
}

/* First fit; `live` has room for all buffers. Returns the units needed. Instructions of one
 * elementwise run are worked on piece by piece, so within a run memory passes on only as a whole.
 */
static int assign_offsets(buffer *buffers, int count, buffer **live)
{
    int alive = 0, units = 0;
    qsort(buffers, (size_t)count, sizeof *buffers, compare_born);
    for (int i = 0; i < count; i++) {
        int kept = 0, offset = 0, size = buffers[i].rows * buffers[i].columns;
        for (int k = 0; k < alive; k++) {
            if (live[k]->lingers >= buffers[i].born) {
                live[kept++] = live[k];
            }
        }
        alive = kept;
        if (take_over(live, alive, &buffers[i])) {
            continue;
        }
        for (int k = 0; k < alive && live[k]->offset < offset + size; k++) {
            int end = live[k]->offset + live[k]->rows * live[k]->columns;
            offset = end > offset ? end : offset;
        }
        buffers[i].offset = offset;
        units = offset + size > units ? offset + size : units;
        live[alive++] = &buffers[i];
        qsort(live, (size_t)alive, sizeof *live, compare_offset);
    }
    return units;
}

static void extend(buffer *b, int position)
{
    b->born = position < b->born ? position : b->born;
    b->dies = position > b->dies ? position : b->dies;
}

static bool is_output(const pass_plan *plan, int id)
{
    const ad_program *program = plan->program;
    if (plan->stored[id]) {
        return true;
    }
    for (int i = 0; i < program->outputs; i++) {
        if (program->output_ids[i] == id) {
            return true;
        }
    }
    return false;
}

/* ends [ordered]: of each position the last of the same level and phase. */
static void find_ends_of_runs(const pass_plan *plan, int *ends)
{
    for (int at = plan->ordered - 1; at >= 0; at--) {
        const int id = plan->order[at], next = at + 1 < plan->ordered ? plan->order[at + 1] : -1;
        const bool goes_on = next >= 0 && plan->level[next] == plan->level[id] &&
                             phase_of(plan, next) == phase_of(plan, id);
        ends[at] = goes_on ? ends[at + 1] : at;
    }
}

/* First position of the level's phase at which this one stands: merged products run together. */
static int start_of_run(const pass_plan *plan, int position)
{
    int first = plan->order[position], from = position;
    while (from > 0 && plan->level[plan->order[from - 1]] == plan->level[first] &&
           phase_of(plan, plan->order[from - 1]) == phase_of(plan, first)) {
        from--;
    }
    return from;
}

/* One buffer for each value that is part of no other, or for a panel of them. */
static int make_buffers(const pass_plan *plan, buffer *buffers, int *buffer_of,
                        int *buffer_of_panel)
{
    int count = 0;
    for (int id = 0; id < plan->count; id++) {
        buffer_of[id] = -1;
        if (!in_pass(plan, id) || plan->parent[id] >= 0 || op_is_reduction(plan->nodes[id].op)) {
            continue;
        }
        int p = plan->panel[id];
        if (p >= 0 && buffer_of_panel[p] >= 0) {
            buffer_of[id] = buffer_of_panel[p];
            continue;
        }
        buffers[count] = (buffer){.rows = plan->nodes[id].rows, .columns = 1, .born = 1 << 30};
        buffers[count].owner = id;
        buffers[count].dies = -1;
        buffers[count].local = p < 0;
        if (p >= 0) {
            buffers[count].columns = plan->panel_columns[p];
            buffer_of_panel[p] = count;
        }
        buffer_of[id] = count++;
    }
    return count;
}

/* The positions at which a value is written, and its arguments read. */
static void extend_lives(const pass_plan *plan, int id, const int *ends, buffer *buffers,
                         const int *buffer_of)
{
    int row, start = plan->position[id], until = start;
    if (phase_of(plan, id) == 0) {
        start = start_of_run(plan, start);
    }
    if (!op_is_reduction(plan->nodes[id].op)) {
        int root = root_of(plan, id, &row);
        buffer *own = &buffers[buffer_of[root]];
        own->local = own->local && root == id && op_is_elementwise(plan->nodes[id].op);
        extend(own, plan->nodes[id].op == OP_INPUT ? -1 : start);
        if (is_output(plan, id)) {
            extend(own, plan->ordered);
        }
    }
    if (plan->nodes[id].op == OP_OUTER_SUM || phase_of(plan, id) == 0) {
        until = ends[until];
    }
    for (int i = 0; i < plan->nodes[id].count; i++) {
        int argument = ad_plan_argument(plan, id, i);
        if (in_pass(plan, argument) && !op_is_reduction(plan->nodes[argument].op)) {
            extend(&buffers[buffer_of[root_of(plan, argument, &row)]], until);
        }
    }
}

/* Every buffer lives from the first position that writes into it to the last that reads it; all
 * products with one matrix in one level happen at the position of the first of them. */
static int collect_buffers(const pass_plan *plan, int *ends, buffer *buffers, int *buffer_of,
                           int *buffer_of_panel)
{
    int count = make_buffers(plan, buffers, buffer_of, buffer_of_panel);
    find_ends_of_runs(plan, ends);
    for (int id = 0; id < plan->count; id++) {
        if (in_pass(plan, id)) {
            extend_lives(plan, id, ends, buffers, buffer_of);
        }
    }
    for (int i = 0; i < count; i++) {
        buffers[i].lingers = buffers[i].dies < 0 || buffers[i].dies >= plan->ordered
                                 ? buffers[i].dies
                                 : ends[buffers[i].dies];
        buffers[i].local =
            buffers[i].local && buffers[i].born >= 0 && buffers[i].dies <= ends[buffers[i].born];
    }
    return count;
}

static void write_places(pass_plan *plan, const buffer *buffers, int count, int *buffer_of)
{
    int *sorted = buffer_of; /* owners moved when sorted: find them again by owner */
    for (int i = 0; i < count; i++) {
        sorted[buffers[i].owner] = i;
    }
    for (int id = 0; id < plan->count; id++) {
        if (!in_pass(plan, id) || op_is_reduction(plan->nodes[id].op)) {
            continue;
        }
        int row, root = root_of(plan, id, &row), p = plan->panel[root], owner = root;
        for (int other = 0; p >= 0 && other < plan->count; other++) {
            if (plan->panel[other] == p && plan->column[other] >= 0 && in_pass(plan, other)) {
                owner = other; /* the first member owns the buffer */
                break;
            }
        }
        const buffer *b = &buffers[sorted[owner]];
        place *at = &plan->places[id];
        *at = (place){.kind = PLACE_TILE, .stride = b->columns, .rows = plan->nodes[id].rows};
        at->column = p >= 0 ? plan->column[root] : 0;
        at->local = b->local;
        at->offset = b->offset + row * b->columns + at->column;
    }
}

static bool assign_places(pass_plan *plan, pass *p)
{
    size_t count = (size_t)plan->count + 1;
    buffer *buffers = malloc(count * sizeof *buffers);
    buffer **live = malloc(count * sizeof *live);
    int *buffer_of = malloc(count * sizeof *buffer_of);
    int *buffer_of_panel = malloc(count * sizeof *buffer_of_panel);
    int *ends = malloc(count * sizeof *ends);
    bool ok = buffers && live && buffer_of && buffer_of_panel && ends;
    if (ok) {
        memset(buffer_of_panel, -1, count * sizeof *buffer_of_panel);
        int made = collect_buffers(plan, ends, buffers, buffer_of, buffer_of_panel);
        p->units = assign_offsets(buffers, made, live);
        write_places(plan, buffers, made, buffer_of);
    }
    free(buffers);
    free(live);
    free(buffer_of);
    free(buffer_of_panel);
    free(ends);
    return ok;
}

bool ad_plan_layout(pass_plan *plan, pass *p)
{
    bool fuse = plan->program->settings.fuse;
    if (fuse) {
        ad_plan_contract(plan);
    }
    size_t count = (size_t)plan->count + 1;
    int *scratch = malloc(3 * (count + 1) * sizeof *scratch);
    bool *seen = calloc(count, sizeof *seen);
    bool ok = scratch && seen;
    if (ok) {
        assign_levels(plan, scratch);
        int levels = 0;
        for (int id = 0; id < plan->count; id++) {
            levels = plan->level[id] >= levels ? plan->level[id] + 1 : levels;
        }
        assign_order(plan, scratch, 3 * levels);
        place_parts(plan);
        if (fuse) {
            panels_of(plan, OP_MATVEC, seen);
            panels_of(plan, OP_OUTER_SUM, seen);
            panels_of(plan, OP_MATVEC_TRANSPOSED, seen);
        }
    }
    free(scratch);
    free(seen);
    return ok && assign_places(plan, p);
}
