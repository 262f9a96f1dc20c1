/* The tape: storage of nodes, sharing of equal ones, leaves, shape checks. */
#include "autodiff/tape/tape.h"

#include <limits.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* In place of a tape for which there is no memory: it has failed, so that nothing is written to it.
 */
static ad_tape without_memory = {.error = {AD_NO_MEMORY, "out of memory for a tape"}};

ad_tape *ad_tape_create(void)
{
    ad_tape *tape = calloc(1, sizeof *tape);
    return tape ? tape : &without_memory;
}

void ad_tape_free(ad_tape *tape)
{
    if (!tape || tape == &without_memory) {
        return;
    }
    free(tape->nodes);
    free(tape->arguments);
    free(tape->numbers);
    free(tape->names);
    free(tape->text);
    free(tape->table);
    free(tape->input_rows);
    free(tape->input_extent);
    free(tape->uniform_rows);
    free(tape);
}

ad_status ad_tape_status(const ad_tape *tape, ad_error *error)
{
    if (error && tape->error.status != AD_OK) {
        *error = tape->error;
    }
    return tape->error.status;
}

void ad_tape_fail(ad_tape *tape, ad_status status, const char *format, ...)
{
    if (tape->error.status != AD_OK) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    ad_fail_list(&tape->error, status, format, arguments);
    va_end(arguments);
}

ad_tape_counts ad_tape_count(const ad_tape *tape)
{
    ad_tape_counts counts = tape->counts;
    counts.stored = (size_t)tape->count;
    return counts;
}

ad_value ad_tape_failed(ad_tape *tape)
{
    return value_of(tape, -1);
}

bool ad_is_valid(ad_value x)
{
    return x.tape && x.id >= 0 && x.id < x.tape->count;
}

int ad_rows(ad_value x)
{
    return ad_is_valid(x) ? node_of(x)->rows : 0;
}

ad_extent ad_extent_of(ad_value x)
{
    return ad_is_valid(x) ? (ad_extent)node_of(x)->extent : AD_UNIFORM;
}

bool ad_is_constant(ad_value x, double value)
{
    return ad_is_valid(x) && is_constant(x) && node_of(x)->splat && node_of(x)->number == value;
}

double ad_constant_row(ad_value x, int row)
{
    const node *n = node_of(x);
    return n->splat ? n->number : x.tape->numbers[n->offset + (size_t)row];
}

bool ad_tape_grow(void **array, int *capacity, int needed, size_t item)
{
    if (needed <= *capacity) {
        return true;
    }
    int larger = *capacity ? *capacity : 32;
    do {
        larger = larger > INT_MAX / 2 ? INT_MAX : 2 * larger;
    } while (larger < needed);
    void *moved = realloc(*array, (size_t)larger * item);
    if (!moved) {
        return false;
    }
    *array = moved;
    *capacity = larger;
    return true;
}

/* ---- sharing ------------------------------------------------------------------------------- */

static uint64_t bits_of(double number)
{
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static uint64_t node_hash(const ad_tape *tape, const node *n, const int *arguments)
{
    uint64_t hash = ad_hash_mix(n->op, (uint64_t)n->rows);
    hash = ad_hash_mix(hash, (uint64_t)n->whole);
    hash = ad_hash_mix(hash, bits_of(n->number));
    for (int i = 0; i < n->count; i++) {
        hash = ad_hash_mix(hash, (uint64_t)arguments[i]);
    }
    if (n->op == OP_CONSTANT && !n->splat) {
        for (int i = 0; i < n->rows; i++) {
            hash = ad_hash_mix(hash, bits_of(tape->numbers[n->offset + (size_t)i]));
        }
    }
    if (n->op == OP_PARAMETER) {
        hash = ad_hash_mix(hash, n->offset);
    }
    return hash;
}

static bool node_equal(const ad_tape *tape, const node *a, const int *a_arguments, const node *b)
{
    if (a->op != b->op || a->rows != b->rows || a->whole != b->whole || a->count != b->count ||
        a->extent != b->extent || a->splat != b->splat ||
        bits_of(a->number) != bits_of(b->number)) {
        return false;
    }
    if (a->op == OP_CONSTANT && !a->splat) {
        return memcmp(tape->numbers + a->offset, tape->numbers + b->offset,
                      (size_t)a->rows * sizeof(double)) == 0;
    }
    if (a->op == OP_PARAMETER && a->offset != b->offset) {
        return false;
    }
    return a->count == 0 ||
           memcmp(a_arguments, tape->arguments + b->first, (size_t)a->count * sizeof(int)) == 0;
}

static bool table_enlarge(ad_tape *tape)
{
    int capacity = tape->table_capacity ? 2 * tape->table_capacity : 256;
    int *table = malloc((size_t)capacity * sizeof *table);
    if (!table) {
        return false;
    }
    memset(table, -1, (size_t)capacity * sizeof *table);
    for (int id = 0; id < tape->count; id++) {
        const node *n = &tape->nodes[id];
        uint64_t slot = node_hash(tape, n, tape->arguments + n->first);
        while (table[slot & (uint64_t)(capacity - 1)] >= 0) {
            slot++;
        }
        table[slot & (uint64_t)(capacity - 1)] = id;
    }
    free(tape->table);
    tape->table = table;
    tape->table_capacity = capacity;
    return true;
}

static ad_value no_memory(ad_tape *tape)
{
    ad_tape_fail(tape, AD_NO_MEMORY, "out of memory after %d operations", tape->count);
    return ad_tape_failed(tape);
}

static bool make_room(ad_tape *tape, int arguments)
{
    if (2 * (tape->count + 1) > tape->table_capacity && !table_enlarge(tape)) {
        return false;
    }
    return ad_tape_grow((void **)&tape->nodes, &tape->capacity, tape->count + 1,
                        sizeof *tape->nodes) &&
           ad_tape_grow((void **)&tape->arguments, &tape->argument_capacity,
                        tape->argument_count + arguments + 1, sizeof *tape->arguments);
}

ad_value ad_tape_append(ad_tape *tape, node prototype, const ad_value *arguments)
{
    if (!make_room(tape, prototype.count)) {
        return no_memory(tape);
    }
    int *ids = tape->arguments + tape->argument_count; /* kept only if the node is new */
    for (int i = 0; i < prototype.count; i++) {
        ids[i] = arguments[i].id;
    }
    uint64_t mask = (uint64_t)(tape->table_capacity - 1);
    uint64_t slot = node_hash(tape, &prototype, ids) & mask;
    for (; tape->table[slot] >= 0; slot = (slot + 1) & mask) {
        if (node_equal(tape, &prototype, ids, &tape->nodes[tape->table[slot]])) {
            return value_of(tape, tape->table[slot]);
        }
    }
    prototype.first = tape->argument_count;
    tape->argument_count += prototype.count;
    tape->nodes[tape->count] = prototype;
    tape->table[slot] = tape->count;
    return value_of(tape, tape->count++);
}

/* ---- leaves -------------------------------------------------------------------------------- */

static ad_value too_many_rows(ad_tape *tape, const char *name, const char *where)
{
    ad_tape_fail(tape, AD_BAD_SHAPE, "%s: more than %d rows %s", name, INT_MAX, where);
    return ad_tape_failed(tape);
}

/* Note the name of a leaf that is new. */
static ad_value named(ad_value leaf, int before, const char *name)
{
    ad_tape *tape = leaf.tape;
    int length = (int)strlen(name) + 1;
    if (leaf.id < before) {
        return leaf;
    }
    if (!ad_tape_grow((void **)&tape->names, &tape->name_capacity, tape->name_count + 1,
                      sizeof *tape->names) ||
        !ad_tape_grow((void **)&tape->text, &tape->text_capacity, tape->text_count + length, 1)) {
        return no_memory(tape);
    }
    tape->names[tape->name_count++] = (leaf_name){leaf.id, tape->text_count};
    memcpy(tape->text + tape->text_count, name, (size_t)length);
    tape->text_count += length;
    return leaf;
}

const char *ad_tape_name(const ad_tape *tape, int id)
{
    for (int i = 0; i < tape->name_count; i++) {
        if (tape->names[i].id == id) {
            return tape->text + tape->names[i].text;
        }
    }
    return "";
}

static bool good_rows(ad_tape *tape, const char *name, int rows)
{
    if (tape->error.status == AD_OK && rows < 1) {
        ad_tape_fail(tape, AD_BAD_SHAPE, "%s: %d rows; at least 1 is needed", name, rows);
    }
    return tape->error.status == AD_OK;
}

/* An input of any extent: numbered, so that equal names or shapes are never shared. */
static ad_value leaf_numbered(ad_tape *tape, int op, ad_extent extent, const char *name, int rows,
                              int **all, int *count)
{
    if (!good_rows(tape, name, rows)) {
        return ad_tape_failed(tape);
    }
    int *larger = realloc(*all, (size_t)(*count + 1) * sizeof **all);
    if (!larger) {
        return no_memory(tape);
    }
    *all = larger;
    larger[*count] = rows;
    node n = {.op = (uint16_t)op, .rows = rows, .whole = (*count)++};
    n.extent = (uint8_t)extent;
    int before = tape->count;
    return named(ad_tape_append(tape, n, NULL), before, name);
}

static ad_value input_of(ad_tape *tape, const char *name, int rows, ad_extent extent)
{
    uint8_t *larger = realloc(tape->input_extent, (size_t)tape->inputs + 1);
    if (!larger) {
        return no_memory(tape);
    }
    tape->input_extent = larger;
    larger[tape->inputs] = (uint8_t)extent;
    tape->members = tape->members || extent == AD_MEMBER;
    return leaf_numbered(tape, OP_INPUT, extent, name, rows, &tape->input_rows, &tape->inputs);
}

ad_value ad_input(ad_tape *tape, const char *name, int rows)
{
    return input_of(tape, name, rows, AD_BATCH);
}

ad_value ad_input_member(ad_tape *tape, const char *name, int rows)
{
    return input_of(tape, name, rows, AD_MEMBER);
}

ad_value ad_uniform(ad_tape *tape, const char *name, int rows)
{
    return leaf_numbered(tape, OP_UNIFORM, AD_UNIFORM, name, rows, &tape->uniform_rows,
                         &tape->uniforms);
}

ad_value ad_parameter(ad_tape *tape, const char *name, int rows, size_t offset)
{
    if (!good_rows(tape, name, rows)) {
        return ad_tape_failed(tape);
    }
    if (offset > (size_t)(INT_MAX - rows)) {
        ad_tape_fail(tape, AD_BAD_ARGUMENT,
                     "%s: %d rows from %zu on; a vector of at most %d parameters is served", name,
                     rows, offset, INT_MAX);
        return ad_tape_failed(tape);
    }
    node n = {.op = OP_PARAMETER, .rows = rows, .offset = offset};
    int before = tape->count;
    return named(ad_tape_append(tape, n, NULL), before, name);
}

static ad_value number_of(ad_tape *tape, sum_over what)
{
    node n = {.op = OP_POINTS, .rows = 1, .whole = (int)what};
    return tape->error.status == AD_OK ? ad_tape_append(tape, n, NULL) : ad_tape_failed(tape);
}

ad_value ad_points(ad_tape *tape)
{
    return number_of(tape, OVER_POINTS);
}

ad_value ad_members(ad_tape *tape)
{
    return number_of(tape, OVER_MEMBERS);
}

ad_value ad_points_of_member(ad_tape *tape)
{
    return number_of(tape, OF_MEMBER);
}

static ad_value constant_splat(ad_tape *tape, int rows, double value)
{
    node n = {.op = OP_CONSTANT, .rows = rows, .splat = true, .number = value};
    return ad_tape_append(tape, n, NULL);
}

ad_value ad_constant(ad_tape *tape, int rows, const double *values)
{
    if (!good_rows(tape, "constant", rows)) {
        return ad_tape_failed(tape);
    }
    bool splat = true;
    for (int i = 1; i < rows; i++) {
        splat = splat && bits_of(values[i]) == bits_of(values[0]);
    }
    if (splat) {
        return constant_splat(tape, rows, values[0]);
    }
    if (rows > INT_MAX - tape->number_count) {
        return too_many_rows(tape, "constant", "in all constants together");
    }
    if (!ad_tape_grow((void **)&tape->numbers, &tape->number_capacity, tape->number_count + rows,
                      sizeof(double))) {
        return no_memory(tape);
    }
    memcpy(tape->numbers + tape->number_count, values, (size_t)rows * sizeof(double));
    node n = {.op = OP_CONSTANT, .rows = rows, .offset = (size_t)tape->number_count};
    int before = tape->count;
    ad_value result = ad_tape_append(tape, n, NULL);
    if (tape->count > before) {
        tape->number_count += rows;
    }
    return result;
}

ad_value ad_scalar(ad_tape *tape, double value)
{
    return ad_constant(tape, 1, &value);
}

ad_value ad_zeros(ad_tape *tape, int rows)
{
    return good_rows(tape, "zeros", rows) ? constant_splat(tape, rows, 0) : ad_tape_failed(tape);
}

/* ---- operations ---------------------------------------------------------------------------- */

static ad_value bad_shape(ad_tape *tape, int op, int count, const ad_value *arguments)
{
    ad_tape_fail(tape, AD_BAD_SHAPE, "%s: arguments of %d and %d rows do not fit",
                 ad_op_table[op].name, ad_rows(arguments[0]),
                 count > 1 ? ad_rows(arguments[1]) : 0);
    return ad_tape_failed(tape);
}

/* Rows of the result, 0 when the arguments do not fit; in 64 bits, since they may be too many. */
static int64_t result_rows(int op, int count, const ad_value *x, int whole, int rows)
{
    int first = ad_rows(x[0]);
    int second = count > 1 ? ad_rows(x[1]) : 0;
    switch (ad_op_table[op].form) {
    case FORM_SLICE:
        return whole >= 0 && rows >= 1 && rows <= first && whole <= first - rows ? rows : 0;
    case FORM_JOIN: {
        int64_t sum = 0;
        if (op == OP_PAD) {
            return whole >= 0 && first <= rows && whole <= rows - first ? rows : 0;
        }
        for (int i = 0; i < count; i++) {
            sum += ad_rows(x[i]);
        }
        return sum;
    }
    case FORM_SUM_ROWS:
        return 1;
    case FORM_SUM_POINTS:
        return first;
    case FORM_PRODUCT:
        return first % second == 0 ? first / second : 0;
    case FORM_OUTER:
    case FORM_OUTER_SUM:
        return (int64_t)first * second;
    default:
        break;
    }
    if (op == OP_REPEAT) {
        return first == 1 ? rows : 0;
    }
    int most = first;
    for (int i = 1; i < count; i++) {
        int r = ad_rows(x[i]);
        if (r != most && r != 1 && most != 1) {
            return 0;
        }
        most = r > most ? r : most;
    }
    return most;
}

/* The extent of a result whose arguments vary like `widest`; fails where they vary too much. */
static ad_extent result_extent(ad_tape *tape, int op, int whole, ad_extent widest)
{
    if (!op_is_reduction(op)) {
        return widest;
    }
    if (whole == OVER_MEMBERS && widest == AD_BATCH) {
        ad_tape_fail(tape, AD_BAD_SHAPE,
                     "a sum over members of a value that varies within a member; sum the points of "
                     "each member first");
    }
    return whole == OF_MEMBER && widest != AD_UNIFORM ? AD_MEMBER : AD_UNIFORM;
}

/* An operation on valid arguments. */
static ad_value record(ad_tape *tape, node n, const ad_value *arguments, int rows)
{
    int64_t height = result_rows(n.op, n.count, arguments, n.whole, rows);
    if (height < 1) {
        return bad_shape(tape, n.op, n.count, arguments);
    }
    if (height > INT_MAX) {
        return too_many_rows(tape, ad_op_table[n.op].name, "in the result");
    }
    n.rows = (int)height;
    int before = tape->count;
    ad_value result;
    tape->depth++; /* what simplification records on its way is not asked for */
    bool simplified = ad_simplify(tape, &n, arguments, &result);
    if (!simplified) {
        result = ad_tape_append(tape, n, arguments);
    }
    if (--tape->depth == 0) {
        bool old = result.id < before;
        tape->counts.recorded++;
        tape->counts.folded += old && simplified;
        tape->counts.shared += old && !simplified;
    }
    return result;
}

/* The same on a tape with values of members. */
static ad_value record_members(ad_tape *tape, node n, const ad_value *arguments, int rows)
{
    ad_value few[AD_ARITY_MAX];
    ad_value *own = n.count <= AD_ARITY_MAX ? few : malloc((size_t)n.count * sizeof *own);
    ad_value result = ad_tape_failed(tape);
    if (!own) {
        return no_memory(tape);
    }
    memcpy(own, arguments, (size_t)n.count * sizeof *own);
    ad_extent widest = ad_members_gather(n.count, own);
    n.extent = (uint8_t)result_extent(tape, n.op, n.whole, widest);
    if (tape->error.status == AD_OK &&
        (widest != AD_BATCH || ad_members_spread(n.op, n.count, own))) {
        result = record(tape, n, own, rows);
    }
    if (ad_is_valid(result)) {
        ad_members_gather(1, &result);
    }
    if (own != few) {
        free(own);
    }
    return result;
}

ad_value ad_tape_record(ad_tape *tape, int op, int count, const ad_value *arguments, int whole,
                        double number, int rows)
{
    if (!tape || tape->error.status != AD_OK) {
        return (ad_value){tape, -1};
    }
    ad_extent widest = AD_UNIFORM;
    for (int i = 0; i < count; i++) {
        if (!ad_is_valid(arguments[i]) || arguments[i].tape != tape) {
            ad_tape_fail(tape, AD_BAD_ARGUMENT, "%s: argument %d is not a value of this tape",
                         ad_op_table[op].name, i + 1);
            return ad_tape_failed(tape);
        }
        tape->nodes[arguments[i].id].used = true;
        ad_extent extent = (ad_extent)node_of(arguments[i])->extent;
        widest = extent > widest ? extent : widest;
    }
    if (op == OP_SPREAD) { /* again by itself, where it meets others */
        return arguments[0];
    }
    node n = {.op = (uint16_t)op, .count = count, .whole = op == OP_STACK ? 0 : whole};
    n.number = number;
    tape->members = tape->members || (op_is_reduction(op) && whole != OVER_POINTS);
    if (tape->members) {
        return record_members(tape, n, arguments, rows);
    }
    n.extent = (uint8_t)result_extent(tape, op, whole, widest);
    return record(tape, n, arguments, rows);
}
