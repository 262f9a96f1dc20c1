/* Markers that cameras saw, as C3D: https://www.c3d.org/HTML/Documents/ ("The C3D File Format User
 * Guide"). Blocks of 512 bytes: a header; parameters in groups, of which POINT's rule, as the guide
 * has it, where the header says else; frames. The numbers are those of one of three processors. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "tools/files/file_bytes.h"
#include "tools/files/table_parts.h"

enum { BLOCK = 512, INTEL = 84, DEC = 85, MIPS = 86, KEY = 80, WORDS = 4, NAME = 127 };
enum { TEXT = -1, BYTE = 1, INTEGER = 2, REAL = 4 }; /* types of parameters; sizes in bytes */

typedef struct c3d_file {
    const table_wanted *wanted;
    const unsigned char *bytes;
    size_t size;
    int processor;
    bool is_short; /* something was looked for behind the end */
} c3d_file;

typedef struct c3d_parameter {
    int type; /* 0: there is none */
    size_t count, width, at;
} c3d_parameter;

/* What is in the frames. */
typedef struct c3d_frames {
    size_t points, rows, start, stride; /* the last two in bytes */
    int type;
    double scale, rate;
} c3d_frames;

/* ---- numbers ---- */

/* An integer without sign of so many bytes, the lowest first or last. */
static uint32_t bits_at(c3d_file *file, size_t at, int bytes, bool last)
{
    uint32_t bits = 0;
    if (file->size < (size_t)bytes || at > file->size - (size_t)bytes) {
        file->is_short = true;
        return 0;
    }
    for (int i = 0; i < bytes; i++) {
        bits |= (uint32_t)file->bytes[at + (size_t)i] << 8 * (last ? bytes - 1 - i : i);
    }
    return bits;
}

static int byte_at(c3d_file *file, size_t at)
{
    const int byte = (int)bits_at(file, at, BYTE, false);
    return byte < 128 ? byte : byte - 256;
}

static unsigned word_at(c3d_file *file, size_t at)
{
    return bits_at(file, at, INTEGER, file->processor == MIPS);
}

/* Reals of DEC have the high word first, no infinities, and an exponent that is two larger. */
static double real_at(c3d_file *file, size_t at)
{
    float real;
    if (file->processor == DEC) {
        const uint32_t bits = word_at(file, at) << 16 | word_at(file, at + 2);
        const int exponent = bits >> 23 & 255;
        const double size = ldexp(0x800000 | (bits & 0x7fffff), exponent - 129 - 23);
        return exponent == 0 ? 0 : bits >> 31 ? -size : size;
    }
    const uint32_t bits = bits_at(file, at, REAL, file->processor == MIPS);
    memcpy(&real, &bits, sizeof real);
    return real;
}

static double number_at(c3d_file *file, int type, size_t at)
{
    return type == REAL ? real_at(file, at) : (int16_t)word_at(file, at);
}

/* ---- parameters ---- */

static c3d_parameter parameter_at(c3d_file *file, size_t at)
{
    const size_t dimensions = bits_at(file, at + 1, BYTE, false);
    c3d_parameter found = {byte_at(file, at), 1, 1, at + 2 + dimensions};
    for (size_t i = 0; i < dimensions && found.count <= file->size; i++) {
        const size_t extent = bits_at(file, at + 2 + i, BYTE, false);
        found.width = i == 0 ? extent : found.width;
        found.count *= extent;
    }
    const size_t bytes = found.count * (size_t)abs(found.type);
    const bool is_known =
        found.type == TEXT || found.type == BYTE || found.type == INTEGER || found.type == REAL;
    file->is_short = file->is_short || found.at > file->size || bytes > file->size - found.at;
    return is_known && !file->is_short ? found : (c3d_parameter){0};
}

/* The entry of that name, of that group, or of which group is < 0: a group, of any number, which
 * is then told. Entries follow one another, each with the way to the next. */
static c3d_parameter find_entry(c3d_file *file, const char *name, int *group)
{
    size_t at = (size_t)(bits_at(file, 0, BYTE, false) - 1) * BLOCK + 4;
    while (!file->is_short) {
        const size_t length = (size_t)abs(byte_at(file, at));
        const int number = byte_at(file, at + 1);
        const size_t behind = at + 2 + length, next = word_at(file, behind);
        if (length == 0 || number == 0 || file->is_short) {
            break;
        }
        const bool named = length == strlen(name) &&
                           strncasecmp((const char *)file->bytes + at + 2, name, length) == 0;
        if (named && *group < 0 && number < 0) {
            *group = -number;
            return (c3d_parameter){0};
        }
        if (named && number == *group) {
            return parameter_at(file, behind + 2);
        }
        if (next == 0) {
            break;
        }
        at = behind + next;
    }
    return (c3d_parameter){0};
}

static c3d_parameter find(c3d_file *file, const char *group, const char *name)
{
    int number = -1;
    find_entry(file, group, &number);
    return number < 0 ? (c3d_parameter){0} : find_entry(file, name, &number);
}

/* The number of that index, NaN: there is none. Integers have no sign. */
static double parameter_number(c3d_file *file, const c3d_parameter *of, size_t index)
{
    if (of->type < INTEGER || index >= of->count) {
        return NAN;
    }
    const size_t at = of->at + index * (size_t)of->type;
    return of->type == REAL ? real_at(file, at) : word_at(file, at);
}

static double point_number(c3d_file *file, const char *name)
{
    const c3d_parameter found = find(file, "POINT", name);
    return parameter_number(file, &found, 0);
}

/* Integers end at 65535 frames; who has more writes them as a real, or as two integers. */
static double count_frames(c3d_file *file)
{
    const c3d_parameter first = find(file, "TRIAL", "ACTUAL_START_FIELD"),
                        last = find(file, "TRIAL", "ACTUAL_END_FIELD");
    const double frames = point_number(file, "LONG_FRAMES"),
                 trial =
                     parameter_number(file, &last, 0) - parameter_number(file, &first, 0) + 1 +
                     65536 * (parameter_number(file, &last, 1) - parameter_number(file, &first, 1));
    return !isnan(frames) ? frames : !isnan(trial) ? trial : point_number(file, "FRAMES");
}

/* ---- names ---- */

/* A marker's label as the name of a column that formulas can have: what is neither letter nor
 * digit, of any locale, is one underscore. */
static void clean_label(const char *label, size_t length, char name[NAME + 1])
{
    size_t to = 0;
    for (size_t i = 0; i < length && label[i] && to < NAME; i++) {
        const char c = label[i];
        const bool digit = c >= '0' && c <= '9';
        const bool fine = digit || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        if (to == 0 && digit) {
            name[to++] = '_';
        }
        if (fine || (to > 0 && name[to - 1] != '_')) {
            name[to++] = fine ? c : '_';
        }
    }
    while (to > 0 && name[to - 1] == '_') {
        to--;
    }
    name[to] = 0;
}

static bool is_taken(const table_file *table, const char *name, size_t column)
{
    for (size_t k = 0; k < column; k++) {
        if (strcmp(table->names[k], name) == 0) {
            return true;
        }
    }
    return false;
}

/* Markers without a label, or with that of another, have their number. */
static void name_columns(c3d_file *file, table_file *table, size_t points)
{
    const c3d_parameter labels = find(file, "POINT", "LABELS");
    const int room = TABLE_MAX_NAME - 2;
    strcpy(table->names[0], "t");
    for (size_t k = 0; k < points; k++) {
        char name[NAME + 1] = "", column[NAME + 8];
        if (labels.type == TEXT && (k + 1) * labels.width <= labels.count) {
            clean_label((const char *)file->bytes + labels.at + k * labels.width, labels.width,
                        name);
        }
        snprintf(column, sizeof column, "%.*s.x", room, name);
        if (!name[0] || is_taken(table, column, 1 + 3 * k)) {
            snprintf(name, sizeof name, "marker_%zu", k + 1);
        }
        for (size_t c = 0; c < 3; c++) {
            snprintf(table->names[1 + 3 * k + c], TABLE_MAX_NAME + 1, "%.*s.%c", room, name,
                     "xyz"[c]);
        }
    }
}

/* ---- frames ---- */

static ad_status refuse(const c3d_file *file, const char *what, ad_error *error)
{
    return ad_fail(error, AD_BAD_INPUT, "%s: %s", file_bytes_shown(file->wanted->path), what);
}

/* Metres of the unit of the file; 1 where it says none, NaN of another than is allowed. */
static double find_unit(c3d_file *file)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}};
    const c3d_parameter found = find(file, "POINT", "UNITS");
    char name[NAME + 1] = "";
    if (found.type != TEXT || found.count == 0) {
        return 1;
    }
    clean_label((const char *)file->bytes + found.at, found.width, name);
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        if (strcasecmp(name, units[i].name) == 0) {
            return units[i].metres;
        }
    }
    return NAN;
}

static ad_status describe(c3d_file *file, c3d_frames *frames, ad_error *error)
{
    const double points = point_number(file, "USED"), scale = point_number(file, "SCALE"),
                 start = point_number(file, "DATA_START"), rows = count_frames(file);
    frames->rate = point_number(file, "RATE");
    frames->scale = find_unit(file) * (scale < 0 ? 1 : scale);
    frames->type = scale < 0 ? REAL : INTEGER;
    if (file->is_short) {
        return refuse(file, "ends within its parameters, or is no C3D", error);
    }
    if (!(points >= 1 && points <= (TABLE_MAX_COLUMNS - 1) / 3)) {
        return refuse(file, "POINT:USED, the number of markers, is not among 1 to 341", error);
    }
    if (!(frames->rate > 0) || !isfinite(frames->rate) || !isfinite(scale) || scale == 0 ||
        !(start >= 2 && start <= 65535) || !(rows >= 0)) {
        return refuse(file,
                      "POINT lacks one of RATE (> 0), SCALE (not 0), DATA_START (a block from 2), "
                      "FRAMES or LONG_FRAMES",
                      error);
    }
    if (isnan(frames->scale)) {
        return refuse(file, "POINT:UNITS is not known; allowed: m, cm, mm", error);
    }
    const size_t analog = word_at(file, 4);
    frames->points = (size_t)points;
    frames->stride = (WORDS * frames->points + analog) * (size_t)frames->type;
    frames->start = (size_t)(start - 1) * BLOCK;
    if (frames->start > file->size ||
        rows * (double)frames->stride > (double)(file->size - frames->start)) {
        return refuse(file, "ends before its last frame", error);
    }
    frames->rows = (size_t)rows;
    return AD_OK;
}

/* The place of a marker, NaN where the cameras lost it: the fourth number is then negative. */
static bool read_marker(c3d_file *file, const c3d_frames *frames, size_t row, size_t k,
                        double *const *columns)
{
    const size_t size = (size_t)frames->type,
                 at = frames->start + row * frames->stride + k * WORDS * size;
    bool seen = number_at(file, frames->type, at + 3 * size) >= 0;
    for (size_t c = 0; c < 3; c++) {
        const double number = frames->scale * number_at(file, frames->type, at + c * size);
        seen = seen && isfinite(number);
        columns[c][row] = number;
    }
    for (size_t c = 0; c < 3 && !seen; c++) {
        columns[c][row] = NAN;
    }
    return seen;
}

static ad_status read_frames(c3d_file *file, const c3d_frames *frames, table_file *table,
                             ad_error *error)
{
    for (size_t row = 0; row < frames->rows; row++) {
        table->values[0][row] = (double)row / frames->rate;
        for (size_t k = 0; k < frames->points; k++) {
            const bool seen = read_marker(file, frames, row, k, table->values + 1 + 3 * k);
            if (!seen && file->wanted->numbers == TABLE_FINITE) {
                return ad_fail(error, AD_BAD_INPUT,
                               "%s: column '%s' row %zu: the marker was lost; allowed: numbers",
                               file_bytes_shown(file->wanted->path), table->names[1 + 3 * k],
                               row + 1);
            }
        }
    }
    return AD_OK;
}

ad_status table_from_c3d(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error)
{
    c3d_file file = {.wanted = wanted, .bytes = bytes, .size = size};
    c3d_frames frames = {.rows = 0};
    const unsigned parameters = bits_at(&file, 0, BYTE, false);
    if (bits_at(&file, 1, BYTE, false) != KEY || parameters < 2) {
        return refuse(&file, "is no C3D: its first bytes are others", error);
    }
    file.processor = (int)bits_at(&file, (size_t)(parameters - 1) * BLOCK + 3, BYTE, false);
    if (file.processor < INTEL || file.processor > MIPS) {
        return refuse(&file, "has numbers of an unknown processor; allowed: 84, 85, 86", error);
    }
    ad_status status = describe(&file, &frames, error);
    if (status != AD_OK) {
        return status;
    }
    table_file *made = table_create(wanted, 1 + 3 * frames.points, frames.rows);
    if (!made) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory for %zu frames",
                       file_bytes_shown(wanted->path), frames.rows);
    }
    made->rows = frames.rows;
    name_columns(&file, made, frames.points);
    status = read_frames(&file, &frames, made, error);
    if (status != AD_OK) {
        table_free(made);
        return status;
    }
    *table = made;
    return AD_OK;
}
