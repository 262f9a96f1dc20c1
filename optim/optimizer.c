#include "internal.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct optim_optimizer {
    const optim_kind *kind;
    int part_count;
    optim_part part[OPTIM_PARTS_MAX];
    void *own;
};

static const optim_kind *const kinds[OPTIM_METHOD_COUNT] = {
#define KIND(code, name) [code] = &optim_##name##_kind,
    OPTIM_METHOD_LIST(KIND)
#undef KIND
};

static const char *const names[OPTIM_METHOD_COUNT + 1] = {
#define NAME(code, name) [code] = #name,
    OPTIM_METHOD_LIST(NAME)
#undef NAME
};

/* ---- the table ---- */

#define ROW(field, group, type, least, most, ends, words)                                          \
    {.name = #field,                                                                               \
     .refusal = #field " must be " words,                                                          \
     .kind = OPTIM_##type,                                                                         \
     .reads = (group),                                                                             \
     .open = (ends),                                                                               \
     .low = (least),                                                                               \
     .high = (most),                                                                               \
     .offset = offsetof(optim_settings, field)},
#define LIMITED(field, group, type, ...) ROW(field, group, type, __VA_ARGS__)
#define SETTING(type, name, kind, reads, otherwise, words, names, unit, help, ...)                 \
    LIMITED(name, reads, kind, __VA_ARGS__)
const optim_setting optim_setting_rows[] = {OPTIM_SETTING_LIST(SETTING)};
const int optim_setting_count = (int)(sizeof optim_setting_rows / sizeof *optim_setting_rows);

optim_settings optim_settings_defaults(optim_method method)
{
#define DEFAULT(type, name, kind, reads, otherwise, words, names, unit, help, ...)                 \
    .name = (otherwise),
    optim_settings settings = {.method = method, OPTIM_SETTING_LIST(DEFAULT).basis_every = 10};
#undef DEFAULT
    if (method < OPTIM_METHOD_COUNT && kinds[method]->defaults) {
        kinds[method]->defaults(&settings);
    }
    return settings;
}

static size_t size_of(const optim_setting *row)
{
    return row->kind == OPTIM_NUMBER ? sizeof(double)
           : row->kind == OPTIM_LONG ? sizeof(int64_t)
                                     : sizeof(int);
}

optim_settings optim_settings_own(const optim_settings *settings)
{
    optim_settings own = *settings;
    const optim_settings otherwise = optim_settings_defaults(settings->method);
    for (int i = 0; i < optim_setting_count; i++) {
        const optim_setting *row = &optim_setting_rows[i];
        if (!(row->reads & optim_method_reads(settings->method))) {
            memcpy((char *)&own + row->offset, (const char *)&otherwise + row->offset,
                   size_of(row));
        }
    }
    return own;
}

double optim_setting_value(const optim_setting *row, const optim_settings *settings)
{
    const void *at = (const char *)settings + row->offset;
    return row->kind == OPTIM_NUMBER ? *(const double *)at
           : row->kind == OPTIM_LONG ? (double)*(const int64_t *)at
                                     : *(const int *)at;
}

bool optim_setting_is_own(const optim_setting *row, optim_method method)
{
    if (row->kind != OPTIM_NUMBER || !(row->reads & optim_method_reads(method))) {
        return false;
    }
    const optim_settings common = optim_settings_defaults(OPTIM_METHOD_COUNT);
    const optim_settings own = optim_settings_defaults(method);
    return optim_setting_value(row, &own) != optim_setting_value(row, &common);
}

/* Conditions are written so that a NaN fails them. */
static bool within(const optim_setting *row, double value)
{
    const bool above = row->open & OPTIM_LOW_OPEN ? value > row->low : value >= row->low;
    const bool below = row->open & OPTIM_HIGH_OPEN ? value < row->high : value <= row->high;
    return above && below && isfinite(value);
}

const char *optim_settings_check(const optim_settings *settings)
{
    if ((unsigned)settings->method >= OPTIM_METHOD_COUNT) {
        return "method must be one of the table";
    }
    for (int i = 0; i < optim_setting_count; i++) {
        const optim_setting *row = &optim_setting_rows[i];
        if (!within(row, optim_setting_value(row, settings))) {
            return row->refusal;
        }
    }
    const optim_kind *kind = kinds[settings->method];
    return kind->check ? kind->check(settings) : NULL;
}

const char *const *optim_method_names(void)
{
    return names;
}

const char *optim_method_name(optim_method method)
{
    return (unsigned)method < OPTIM_METHOD_COUNT ? names[method] : "unknown";
}

optim_method optim_method_of(const char *name)
{
    int method = 0;
    while (method < OPTIM_METHOD_COUNT && strcmp(names[method], name) != 0) {
        method++;
    }
    return (optim_method)method;
}

const char *optim_method_about(optim_method method)
{
    return kinds[method]->about;
}

optim_needs optim_method_needs(optim_method method)
{
    return (unsigned)method < OPTIM_METHOD_COUNT ? kinds[method]->needs : OPTIM_NEEDS_GRADIENTS;
}

unsigned optim_method_reads(optim_method method)
{
    return kinds[method]->reads;
}

void optim_method_list(unsigned needs, unsigned reads, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < OPTIM_METHOD_COUNT && used < size; i++) {
        if ((!needs || needs & 1u << kinds[i]->needs) && (!reads || reads & kinds[i]->reads)) {
            used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", names[i]);
        }
    }
}

const char *optim_advice(optim_method method)
{
    return kinds[method]->advice;
}

double optim_bytes(const optim_settings *settings, size_t count)
{
    const optim_kind *kind = kinds[settings->method];
    return kind->bytes ? kind->bytes(settings, count) : 8.0 * 6 * (double)count;
}

size_t optim_count_max(optim_method method)
{
    return kinds[method]->count_max ? kinds[method]->count_max : SIZE_MAX;
}

const char *const *optim_scaling_names(void)
{
#define NAME(code, name) name,
    static const char *const scalings[] = {OPTIM_SCALING_LIST(NAME) NULL};
#undef NAME
    return scalings;
}

/* ---- a method at work ---- */

optim_optimizer *optim_create(size_t count, const double *x, const optim_settings *settings,
                              const char **why)
{
    const char *problem = optim_settings_check(settings);
    problem = problem                       ? problem
              : count == 0                  ? "count must be at least 1"
              : !optim_all_finite(count, x) ? "the starting point x must be finite"
                                            : NULL;
    if (!problem && count > optim_count_max(settings->method)) {
        problem = "count must be in [1, 10000]: the matrix has count^2 / 2 numbers";
    }
    optim_optimizer *o = problem ? NULL : calloc(1, sizeof *o);
    if (o) {
        o->kind = kinds[settings->method];
        o->part_count = o->kind->parts(count, settings, o->part);
        o->own = optim_room_create(o->kind->size, o->part_count, o->part);
    }
    if (o && !o->own) {
        free(o);
        o = NULL;
    }
    if (o) {
        o->kind->begin(o->own, count, x, settings);
    }
    if (why) {
        *why = problem || o ? problem : "out of memory";
    }
    return o;
}

void optim_free(optim_optimizer *o)
{
    if (o) {
        free(o->own);
        free(o);
    }
}

optim_status optim_step(optim_optimizer *o, const optim_target *target)
{
    return o->kind->step(o->own, target);
}

void optim_objective_changed(optim_optimizer *o)
{
    o->kind->objective_changed(o->own);
}

const double *optim_x(const optim_optimizer *o)
{
    return o->kind->x(o->own);
}

const double *optim_best_x(const optim_optimizer *o)
{
    return o->kind->best_x ? o->kind->best_x(o->own) : o->kind->x(o->own);
}

optim_info optim_inspect(const optim_optimizer *o)
{
    return o->kind->inspect(o->own);
}

/* The numbers of a part. */
static double *numbers_of(const optim_optimizer *o, const optim_part *part)
{
    char *at = (char *)o->own + part->offset;
    double *numbers = (double *)(void *)at;
    if (part->rows > 0) {
        memcpy(&numbers, at, sizeof numbers);
    }
    return numbers;
}

static size_t size_of_part(const optim_part *part)
{
    return part->rows > 0 ? part->rows * part->count : part->count;
}

int optim_state(optim_optimizer *o, optim_array *arrays)
{
    int count = 0;
    for (int i = 0; i < o->part_count; i++) {
        const optim_part *part = &o->part[i];
        if (part->name) {
            arrays[count++] = (optim_array){part->name, numbers_of(o, part), size_of_part(part)};
        }
    }
    return count;
}

const char *optim_state_check(const optim_optimizer *o)
{
    for (int i = 0; i < o->part_count; i++) {
        const optim_part *part = &o->part[i];
        if (part->wrong && !optim_all_finite(size_of_part(part), numbers_of(o, part))) {
            return part->wrong;
        }
    }
    return o->kind->state_check(o->own);
}
