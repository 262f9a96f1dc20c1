/* Nodes of formulas, their names, and what is asked of them. */
#include "physics/quantity/quantity_internal.h"
#include "physics/quantity/quantity_within.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BUCKETS = 256, NAMES_MAX = 256 };

struct quantities {
    pthread_mutex_t lock; /* of the buckets, and of what is kept */
    quantity_node *buckets[BUCKETS];
    int count, open;
    quantity_name names[NAMES_MAX];
    quantity_table *tables;
    const quantities *outer;
    quantity_plays memory;
    quantity_kept kept;
};

static const quantity_node no_memory = {
    .kind = QUANTITY_ERROR, .status = AD_NO_MEMORY, .text = "out of memory for a formula"};

static bool is_plain(quantity q)
{
    return !q.node || (q.node->uses == 0 && q.node->kind == QUANTITY_WRITTEN);
}

static bool is_faulty(quantity q)
{
    return q.node && (q.node->kind == QUANTITY_ERROR || q.node->kind == QUANTITY_UNPARSED);
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static uint64_t mix(uint64_t hash, uint64_t more)
{
    hash = (hash ^ more) * 0x9e3779b97f4a7c15U;
    return hash ^ hash >> 29;
}

static uint64_t hash_of(const quantity_node *node)
{
    uint64_t hash = mix((uint64_t)node->kind, (uint64_t)node->index);
    hash = mix(hash, (uint64_t)(uintptr_t)node->operation);
    for (const char *p = node->text; p && *p; p++) {
        hash = mix(hash, (unsigned char)*p);
    }
    for (int i = 0; i < QUANTITY_ARGUMENTS_MAX; i++) {
        uint64_t bits = 0;
        memcpy(&bits, &node->x[i].number, sizeof bits);
        hash = mix(mix(hash, bits), (uint64_t)(uintptr_t)node->x[i].node);
    }
    return hash;
}

static bool is_same(const quantity_node *a, const quantity_node *b)
{
    bool same = a->hash == b->hash && a->kind == b->kind && a->operation == b->operation &&
                a->index == b->index && !a->text == !b->text && a->status == b->status &&
                (!a->text || strcmp(a->text, b->text) == 0);
    for (int i = 0; i < QUANTITY_ARGUMENTS_MAX && same; i++) {
        same = a->x[i].node == b->x[i].node &&
               memcmp(&a->x[i].number, &b->x[i].number, sizeof(double)) == 0;
    }
    return same;
}

static quantity_node *copy_of(const quantity_node *node)
{
    size_t length = node->text ? strlen(node->text) + 1 : 0;
    quantity_node *copy = malloc(sizeof *copy + length);
    if (copy) {
        *copy = *node;
        copy->text = node->text ? memcpy(copy + 1, node->text, length) : NULL;
    }
    return copy;
}

/* The node like this one, made where there is none yet. */
static const quantity_node *node_like(quantities *owner, quantity_node wanted)
{
    wanted.owner = owner;
    wanted.hash = hash_of(&wanted);
    pthread_mutex_lock(&owner->lock);
    quantity_node **bucket = &owner->buckets[wanted.hash % BUCKETS], *node = *bucket;
    while (node && !is_same(node, &wanted)) {
        node = node->next;
    }
    if (!node) {
        node = copy_of(&wanted);
        if (node) {
            node->still = quantity_enclose_still(node);
            node->next = *bucket;
            *bucket = node;
        }
    }
    pthread_mutex_unlock(&owner->lock);
    return node ? node : &no_memory;
}

static quantity of_node(const quantity_node *node, double number)
{
    return (quantity){.number = number, .node = node, .is_given = true};
}

quantity quantity_error(quantities *owner, ad_status status, const char *message)
{
    const quantity_node wanted = {.kind = QUANTITY_ERROR, .status = status, .text = message};
    return of_node(node_like(owner, wanted), NAN);
}

/* `value` as its author wrote it. */
static quantity written(quantities *owner, const char *text, quantity value)
{
    if (is_faulty(value)) {
        return value;
    }
    quantity_node wanted = {.kind = QUANTITY_WRITTEN, .text = text, .x = {value}};
    if (value.node) {
        wanted.uses = value.node->uses;
        wanted.size = value.node->size;
    }
    const quantity_node *node = node_like(owner, wanted);
    return of_node(node, node->kind == QUANTITY_ERROR ? NAN : value.number);
}

quantity quantity_written(quantity as, quantity value)
{
    const bool known = as.node && as.node->kind == QUANTITY_WRITTEN;
    return known ? written(as.node->owner, as.node->text, value) : value;
}

/* A formula of arguments of which one at least is no number. */
static quantity operate_on_nodes(const quantity_operation *operation, const quantity *x)
{
    quantity_node wanted = {.kind = QUANTITY_OPERATION, .operation = operation, .size = 1};
    quantities *owner = NULL;
    for (int i = 0; i < operation->arity; i++) {
        wanted.x[i] = is_plain(x[i]) ? quantity_number(x[i].number) : x[i];
        if (wanted.x[i].node) {
            owner = x[i].node->owner;
            wanted.uses |= x[i].node->uses;
            wanted.size += x[i].node->size;
        }
    }
    wanted.size = wanted.size < QUANTITY_SIZE_MAX ? wanted.size : QUANTITY_SIZE_MAX + 1;
    return of_node(node_like(owner, wanted), NAN);
}

quantity quantity_operate(const quantity_operation *operation, const quantity *x)
{
    double numbers[QUANTITY_ARGUMENTS_MAX];
    bool plain = true;
    for (int i = 0; i < operation->arity; i++) {
        if (!x[i].is_given || is_faulty(x[i])) {
            return x[i];
        }
        plain = plain && is_plain(x[i]);
        numbers[i] = x[i].number;
    }
    return plain ? quantity_number(operation->number(numbers)) : operate_on_nodes(operation, x);
}

/* ---- names ----------------------------------------------------------------------------------- */

quantities *quantities_create_open(void)
{
    quantities *names = calloc(1, sizeof *names);
    if (names && pthread_mutex_init(&names->lock, NULL) != 0) {
        free(names);
        names = NULL;
    }
    return names;
}

quantities *quantities_create_within(const quantities *outer)
{
    quantities *names = quantities_create_open();
    if (names) {
        names->outer = outer;
    }
    return names;
}

quantities *quantities_create(void)
{
    quantities *names = quantities_create_open();
    if (names && (quantities_coordinate(names, "s", NULL) != AD_OK ||
                  quantities_coordinate(names, "t", NULL) != AD_OK)) {
        quantities_free(names);
        names = NULL;
    }
    return names;
}

void quantities_free(quantities *names)
{
    if (!names) {
        return;
    }
    for (int i = 0; i < BUCKETS; i++) {
        while (names->buckets[i]) {
            quantity_node *next = names->buckets[i]->next;
            free(names->buckets[i]);
            names->buckets[i] = next;
        }
    }
    quantity_tables_free(names->tables);
    for (int i = 0; i < QUANTITY_KEPT_MAX; i++) {
        free(names->kept.findings[i].bytes);
    }
    pthread_mutex_destroy(&names->lock);
    free(names);
}

/* Of the names themselves. */
static quantity find_own(const quantities *names, const char *name, size_t length)
{
    for (int i = 0; i < names->count; i++) {
        if (strlen(names->names[i].text) == length &&
            strncmp(names->names[i].text, name, length) == 0) {
            return names->names[i].value;
        }
    }
    return (quantity){.is_given = false};
}

quantity quantities_find(const quantities *names, const char *name, size_t length)
{
    const quantity own = find_own(names, name, length);
    if (own.is_given || !names->outer) {
        return own;
    }
    double number;
    return quantity_is_number(quantities_find(names->outer, name, length), &number)
               ? quantity_number(number)
               : own;
}

void quantities_use(quantities *names, const char *name, size_t length)
{
    for (int i = 0; i < names->count; i++) {
        names->names[i].used |= strlen(names->names[i].text) == length &&
                                strncmp(names->names[i].text, name, length) == 0;
    }
}

bool quantities_used(const quantities *names, const char *name)
{
    for (int i = 0; i < names->count; i++) {
        if (strcmp(names->names[i].text, name) == 0) {
            return names->names[i].used;
        }
    }
    return false;
}

int quantities_count(const quantities *names)
{
    return names->count;
}

const char *quantities_name(const quantities *names, int i)
{
    return names->names[i].text;
}

/* Coordinates may be those of something, "tip.x". */
static ad_status check_name(const quantities *names, const char *name, bool dotted, ad_error *error)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
    static const char digits[] = "0123456789";
    size_t length = 0;
    while (name[length] &&
           (strchr(letters, name[length]) || (length > 0 && strchr(digits, name[length])) ||
            (dotted && length > 0 && quantity_name_goes_on(name + length)))) {
        length++;
    }
    if (name[length] || length == 0 || length > QUANTITY_NAME_MAX) {
        return ad_fail(error, AD_BAD_INPUT,
                       "'%.60s' is no name; allowed: up to 40 letters, digits and _, beginning "
                       "with a letter",
                       name);
    }
    if (find_own(names, name, length).is_given || strcmp(name, "pi") == 0 ||
        quantity_operation_find(name, length) || quantity_table_find(names->tables, name, length)) {
        return ad_fail(error, AD_BAD_INPUT, "formulas know '%s' already; choose another name",
                       name);
    }
    if (names->count == NAMES_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "too many names; allowed: %d", NAMES_MAX);
    }
    return AD_OK;
}

static void add_name(quantities *names, const char *name, quantity value)
{
    quantity_name *added = &names->names[names->count++];
    snprintf(added->text, sizeof added->text, "%s", name);
    added->value = value;
}

ad_status quantities_define(quantities *names, const char *name, quantity value, ad_error *error)
{
    ad_status status = check_name(names, name, false, error);
    if (status == AD_OK) {
        status = quantity_check(value, error);
    }
    if (status == AD_OK && !value.is_given) {
        status =
            ad_fail(error, AD_BAD_INPUT, "'%s' has no value; give a number or a formula", name);
    }
    if (status == AD_OK) {
        add_name(names, name, value);
    }
    return status;
}

quantity_kept *quantities_lock_kept(quantities *names)
{
    pthread_mutex_lock(&names->lock);
    return &names->kept;
}

void quantities_unlock_kept(quantities *names)
{
    pthread_mutex_unlock(&names->lock);
}

const quantity_table *quantities_table(const quantities *names, const char *name, size_t length)
{
    const quantity_table *table = NULL;
    for (; names && !table; names = names->outer) {
        table = quantity_table_find(names->tables, name, length);
    }
    return table;
}

quantity_plays *quantities_memory(quantities *names)
{
    return &names->memory;
}

ad_status quantities_define_table(quantities *names, const char *name, int count, const double *x,
                                  const double *y, ad_error *error)
{
    ad_status status = check_name(names, name, false, error);
    if (status == AD_OK && (count < 2 || count > QUANTITY_TABLE_MAX)) {
        status = ad_fail(error, AD_BAD_INPUT, "the table has %d rows; allowed: 2 to %d", count,
                         QUANTITY_TABLE_MAX);
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        if (!isfinite(x[i]) || !isfinite(y[i]) || (i > 0 && x[i] <= x[i - 1])) {
            status = ad_fail(error, AD_BAD_INPUT,
                             "row %d of the table is %g, %g; allowed: numbers, the first larger "
                             "in every row",
                             i + 1, x[i], y[i]);
        }
    }
    if (status != AD_OK) {
        return status;
    }
    quantity_table *made = quantity_table_create(name, count, x, y, names->tables);
    names->tables = made ? made : names->tables;
    return made ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a table");
}

ad_status quantities_coordinate(quantities *names, const char *name, ad_error *error)
{
    return quantities_parameter(names, name, -INFINITY, INFINITY, NAN, error);
}

ad_status quantities_parameter(quantities *names, const char *name, double low, double high,
                               double usual, ad_error *error)
{
    ad_status status = check_name(names, name, true, error);
    if (status == AD_OK && names->open == QUANTITY_OPEN_MAX) {
        status =
            ad_fail(error, AD_BAD_INPUT, "too many coordinates; allowed: %d", QUANTITY_OPEN_MAX);
    }
    if (status != AD_OK) {
        return status;
    }
    const quantity_node wanted = {.kind = QUANTITY_OPEN,
                                  .index = names->open,
                                  .uses = UINT64_C(1) << names->open,
                                  .size = 1,
                                  .text = name,
                                  .x = {{.number = usual}, {.number = low}, {.number = high}}};
    quantity value = of_node(node_like(names, wanted), NAN);
    if (is_faulty(value)) {
        return quantity_check(value, error);
    }
    names->open++;
    add_name(names, name, value);
    return AD_OK;
}

/* ---- making ---------------------------------------------------------------------------------- */

quantity quantity_formula(quantities *names, const char *text)
{
    if (!text) {
        return (quantity){.is_given = false};
    }
    return written(names, text, quantity_parse(names, text));
}

quantity quantity_unparsed(quantities *names, const char *text)
{
    const quantity_node wanted = {
        .kind = QUANTITY_UNPARSED, .status = AD_BAD_ARGUMENT, .text = text};
    return of_node(node_like(names, wanted), NAN);
}

quantity quantity_parsed(quantity q)
{
    bool waits = q.node && q.node->kind == QUANTITY_UNPARSED;
    return waits ? quantity_formula(q.node->owner, q.node->text) : q;
}

static quantity binary(int operator, quantity a, quantity b)
{
    const quantity x[2] = {a, b};
    return quantity_operate(&quantity_operations[operator], x);
}

quantity quantity_add(quantity a, quantity b)
{
    return binary(QUANTITY_ADD, a, b);
}

quantity quantity_subtract(quantity a, quantity b)
{
    return binary(QUANTITY_SUBTRACT, a, b);
}

quantity quantity_multiply(quantity a, quantity b)
{
    return binary(QUANTITY_MULTIPLY, a, b);
}

quantity quantity_divide(quantity a, quantity b)
{
    return binary(QUANTITY_DIVIDE, a, b);
}

quantity quantity_power(quantity a, double exponent)
{
    return binary(QUANTITY_POWER, a, quantity_number(exponent));
}

quantity quantity_call(const char *function, const quantity *arguments)
{
    const quantity_operation *operation = quantity_operation_find(function, strlen(function));
    return operation ? quantity_operate(operation, arguments) : (quantity){.is_given = false};
}

/* ---- asking ---------------------------------------------------------------------------------- */

ad_status quantity_check(quantity q, ad_error *error)
{
    if (!is_faulty(q)) {
        return AD_OK;
    }
    bool waits = q.node->kind == QUANTITY_UNPARSED;
    return ad_fail(error, q.node->status, waits ? "the formula '%s' is not parsed yet" : "%s",
                   q.node->text);
}

bool quantity_is_number(quantity q, double *value)
{
    bool known = q.is_given && is_plain(q);
    if (known && value) {
        *value = q.number;
    }
    return known;
}

bool quantity_is(quantity q, double number)
{
    return quantity_is_number(q, NULL) && q.number == number;
}

bool quantity_is_something(quantity q)
{
    return q.is_given && !quantity_is(q, 0);
}

bool quantity_any_given(int count, const quantity *q)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        any = any || q[i].is_given;
    }
    return any;
}

bool quantity_any_something(int count, const quantity *q)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        any = any || quantity_is_something(q[i]);
    }
    return any;
}

bool quantity_depends_on(quantity q, const char *coordinate)
{
    quantity name = {.is_given = false};
    if (q.node && q.node->owner && q.node->uses) {
        name = quantities_find(q.node->owner, coordinate, strlen(coordinate));
    }
    return name.node && name.node->kind == QUANTITY_OPEN && (q.node->uses & name.node->uses);
}

bool quantity_any_depends_on(int count, const quantity *q, const char *coordinate)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        any = any || quantity_depends_on(q[i], coordinate);
    }
    return any;
}

static bool calls(const quantity_node *node, const quantity_operation *operation)
{
    int count = !node || node->uses == 0           ? 0
                : node->kind == QUANTITY_OPERATION ? node->operation->arity
                : node->kind == QUANTITY_WRITTEN   ? 1
                                                   : 0;
    bool found = count > 0 && node->kind == QUANTITY_OPERATION && node->operation == operation;
    for (int i = 0; i < count && !found; i++) {
        found = calls(node->x[i].node, operation);
    }
    return found;
}

bool quantity_calls(quantity q, const char *function)
{
    return calls(q.node, quantity_operation_find(function, strlen(function)));
}

/* x [count]: values of the open names. */
static double value_of(const quantity *q, int count, const double *x)
{
    const quantity_node *node = q->node;
    double numbers[QUANTITY_ARGUMENTS_MAX];
    if (!node || node->uses == 0) {
        return q->number;
    }
    if (node->kind == QUANTITY_OPEN) {
        return node->index < count ? x[node->index] : node->x[0].number;
    }
    if (node->kind == QUANTITY_WRITTEN) {
        return value_of(&node->x[0], count, x);
    }
    if (node->operation == &quantity_operations[QUANTITY_WHERE]) {
        return value_of(&node->x[value_of(&node->x[0], count, x) > 0 ? 1 : 2], count, x);
    }
    for (int i = 0; i < node->operation->arity; i++) {
        numbers[i] = value_of(&node->x[i], count, x);
    }
    return node->operation->number(numbers);
}

double quantity_value(quantity q, double s, double t)
{
    return q.is_given ? value_of(&q, 2, (double[]){s, t}) : NAN;
}

double quantity_value_with(quantity q, double s, double t, int count, const char *const *names,
                           const double *values)
{
    double x[QUANTITY_OPEN_MAX] = {s, t};
    int open = 2;
    for (int i = 0; q.node && i < q.node->owner->count; i++) {
        const quantity_name *name = &q.node->owner->names[i];
        const quantity_node *node = name->value.node;
        if (!node || node->kind != QUANTITY_OPEN || node->index < 2) {
            continue;
        }
        x[node->index] = node->x[0].number;
        open = node->index + 1 > open ? node->index + 1 : open;
        for (int k = 0; k < count; k++) {
            x[node->index] = strcmp(name->text, names[k]) == 0 ? values[k] : x[node->index];
        }
    }
    return q.is_given ? value_of(&q, open, x) : NAN;
}

int quantities_index(const quantities *names, const char *name)
{
    const quantity known = quantities_find(names, name, strlen(name));
    return known.node && known.node->kind == QUANTITY_OPEN ? known.node->index : -1;
}

double quantity_value_at(quantity q, int count, const double *x)
{
    return q.is_given ? value_of(&q, count, x) : NAN;
}

/* Of an operation at a point, by its rules for intervals. */
static double slope_of(const quantity *q, int count, const double *x, const double *direction);

static double slope_of_operation(const quantity_node *node, int count, const double *x,
                                 const double *direction)
{
    quantity_interval at[QUANTITY_ARGUMENTS_MAX], by[QUANTITY_ARGUMENTS_MAX], value;
    double sum = 0;
    for (int i = 0; i < node->operation->arity; i++) {
        const double number = value_of(&node->x[i], count, x);
        at[i] = (quantity_interval){number, number};
    }
    node->operation->range(at, &value, by);
    for (int i = 0; i < node->operation->arity; i++) {
        const double slope = slope_of(&node->x[i], count, x, direction);
        sum += slope != 0 ? slope * quantity_middle(by[i]) : 0;
    }
    return sum;
}

static double slope_of(const quantity *q, int count, const double *x, const double *direction)
{
    const quantity_node *node = q->node;
    if (!node || node->uses == 0) {
        return 0;
    }
    if (node->kind == QUANTITY_OPEN) {
        return node->index < count ? direction[node->index] : 0;
    }
    return node->kind == QUANTITY_WRITTEN ? slope_of(&node->x[0], count, x, direction)
                                          : slope_of_operation(node, count, x, direction);
}

double quantity_slope_at(quantity q, int count, const double *x, const double *direction)
{
    return q.is_given ? slope_of(&q, count, x, direction) : NAN;
}

quantity_interval quantity_span(quantity q, double s, double t)
{
    double value = quantity_value(q, s, t);
    quantity_interval range = {value, value};
    if (q.node && (q.node->uses & ~QUANTITY_COORDINATES)) {
        range = quantity_range(q, (quantity_interval){s, s}, (quantity_interval){t, t});
    }
    return isfinite(range.low) && isfinite(range.high) ? range : (quantity_interval){value, value};
}
