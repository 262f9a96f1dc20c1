/* Tables as CSV; the grammar is in table_file.h. */
#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/file_bytes.h"
#include "tools/files/table_parts.h"

#define MAX_NUMBER 127 /* bytes of one number */
#define MAX_QUOTED 40  /* bytes of the file repeated in a message */

/* Numbers have a decimal point while the guard is held, in this thread, whatever the locale. */
typedef struct number_guard {
    locale_t plain, previous;
} number_guard;

static bool hold_plain_numbers(number_guard *guard)
{
    guard->plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    if (guard->plain == (locale_t)0) {
        return false;
    }
    guard->previous = uselocale(guard->plain);
    return true;
}

static void release_plain_numbers(const number_guard *guard)
{
    uselocale(guard->previous);
    freelocale(guard->plain);
}

/* ---- reading ---- */

typedef struct csv_reader {
    const table_wanted *wanted;
    const char *next, *end; /* bytes not yet read */
    size_t line;            /* number of the current line, from 1 */
    size_t header_line;
    const char *start, *stop; /* the current line without its end */
    const char *field;        /* next field of it, NULL behind the last */
    table_file *table;
    ad_error *error; /* not NULL */
} csv_reader;

typedef struct csv_field {
    const char *start;
    size_t length;
} csv_field;

/* AD_BAD_INPUT at a place of the current line; `text` [length] is quoted if it is not NULL. */
static ad_status refuse(const csv_reader *reader, const char *place, const char *text,
                        size_t length, const char *problem)
{
    char quoted[MAX_QUOTED + 8] = "";
    if (text) {
        size_t shown = length < MAX_QUOTED ? length : MAX_QUOTED;
        char *out = quoted;
        *out++ = '\'';
        for (size_t k = 0; k < shown; k++) {
            *out++ = (unsigned char)text[k] < ' ' || text[k] == 0x7f ? '?' : text[k];
        }
        strcpy(out, length > shown ? "...': " : "': ");
    }
    return ad_fail(reader->error, AD_BAD_INPUT, "%s:%zu:%zu: %s%s",
                   file_bytes_shown(reader->wanted->path), reader->line,
                   (size_t)(place - reader->start) + 1, quoted, problem);
}

/* A spreadsheet runs what begins so as a formula; behind an apostrophe it is text. */
static bool starts_formula(const char *text)
{
    return *text == '=' || *text == '+' || *text == '-' || *text == '@';
}

static bool is_blank(char byte)
{
    return byte == ' ' || byte == '\t';
}

/* Move to the next line that is neither empty nor a comment; AD_OK with `start` NULL: none left. */
static ad_status next_line(csv_reader *reader)
{
    while (reader->next < reader->end) {
        const char *newline = memchr(reader->next, '\n', (size_t)(reader->end - reader->next));
        const char *stop = newline ? newline : reader->end;
        reader->start = reader->next;
        reader->next = newline ? newline + 1 : reader->end;
        reader->line++;
        if (stop - reader->start > TABLE_MAX_LINE) {
            return refuse(reader, reader->start + TABLE_MAX_LINE, NULL, 0,
                          "the line is too long; allowed: 65536 bytes");
        }
        if (stop > reader->start && stop[-1] == '\r') {
            stop--;
        }
        const char *first = reader->start;
        while (first < stop && is_blank(*first)) {
            first++;
        }
        if (first < stop && *first != '#') {
            reader->stop = stop;
            reader->field = reader->start;
            return AD_OK;
        }
    }
    reader->start = NULL;
    return AD_OK;
}

/* The next field of the current line, trimmed, without the apostrophe before what a spreadsheet
 * would run; false behind the last. */
static bool next_field(csv_reader *reader, csv_field *field)
{
    if (!reader->field) {
        return false;
    }
    const char *start = reader->field;
    while (start < reader->stop && is_blank(*start)) {
        start++;
    }
    const char *text = start < reader->stop && *start == '"'
                           ? memchr(start + 1, '"', (size_t)(reader->stop - start - 1))
                           : NULL;
    text = text ? text : start;
    const char *comma = memchr(text, ',', (size_t)(reader->stop - text));
    const char *stop = comma ? comma : reader->stop;
    reader->field = comma ? comma + 1 : NULL;
    while (stop > start && is_blank(stop[-1])) {
        stop--;
    }
    if (stop - start > 1 && *start == '\'' && starts_formula(start + 1)) {
        start++;
    }
    field->start = start;
    field->length = (size_t)(stop - start);
    return true;
}

/* Rows that there may be, at most; the shortest has a separator or line end for each column. */
static size_t count_rows(const csv_reader *reader, size_t columns)
{
    const size_t most = (size_t)(reader->end - reader->next) / columns + 1;
    size_t lines = 1;
    for (const char *byte = reader->next; byte < reader->end; byte++) {
        lines += *byte == '\n';
    }
    return lines < most ? lines : most;
}

/* True if text is one of the words for a number that is not finite. */
static bool parse_word(const char *text, double *value)
{
    static const struct {
        const char *word;
        double value;
    } words[] = {{"nan", NAN}, {"inf", INFINITY}, {"infinity", INFINITY}};
    bool negative = *text == '-';
    text += negative || *text == '+';
    for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
        const char *word = words[k].word;
        size_t at = 0;
        /* Bit 5 makes an ASCII capital small. */
        while (word[at] && (text[at] | 0x20) == word[at]) {
            at++;
        }
        if (word[at] == 0 && text[at] == 0) {
            *value = negative ? -words[k].value : words[k].value;
            return true;
        }
    }
    return false;
}

/* NULL, or what is wrong with the field as a number. */
static const char *number_problem(const table_wanted *wanted, csv_field field, double *value)
{
    const table_numbers numbers = wanted->numbers;
    char text[MAX_NUMBER + 1];
    char *behind = text;
    *value = NAN;
    if (field.length == 0) {
        return numbers != TABLE_MEASURED ? "is empty" : NULL;
    }
    if (field.length > MAX_NUMBER) {
        return "is longer than 127 bytes";
    }
    memcpy(text, field.start, field.length);
    text[field.length] = 0;
    if (parse_word(text, value)) {
        return numbers == TABLE_FINITE || (numbers == TABLE_MEASURED && isinf(*value))
                   ? "is not finite"
                   : NULL;
    }
    /* strtod alone would also take hexadecimal numbers and leading blanks. */
    const bool plain = strspn(text, "0123456789+-.eE") == field.length;
    *value = plain ? strtod(text, &behind) : 0.0;
    if (!plain || *behind || behind == text) {
        return "is not a number";
    }
    return isinf(*value) ? "is too large for a double" : NULL;
}

static ad_status parse_number(const csv_reader *reader, csv_field field, double *value)
{
    const table_numbers numbers = reader->wanted->numbers;
    char problem[160];
    const char *wrong = number_problem(reader->wanted, field, value);
    if (!wrong) {
        return AD_OK;
    }
    snprintf(problem, sizeof problem, "the field %s; allowed: a decimal number such as -1.5e-3%s",
             wrong, numbers == TABLE_MEASURED ? ", or nan or nothing where it is missing" : "");
    return refuse(reader, field.start, field.start, field.length, problem);
}

static ad_status take_word(const csv_reader *reader, csv_field field, char *word)
{
    char problem[128];
    const char *wrong = table_word_problem(field.start, field.length);
    if (wrong) {
        snprintf(problem, sizeof problem, "%s; allowed: 1 to %d bytes without quotes", wrong,
                 TABLE_MAX_NAME);
        return refuse(reader, field.start, field.start, field.length, problem);
    }
    memcpy(word, field.start, field.length); /* zero bytes follow */
    return AD_OK;
}

static ad_status read_row(csv_reader *reader)
{
    table_file *table = reader->table;
    csv_field field = {reader->start, 0};
    size_t count = 0;
    while (next_field(reader, &field)) {
        if (count < table->columns) {
            /* Room for every row that fits the file was made with the header. */
            ad_status status =
                table->problems[count].status != AD_OK ? AD_OK
                : table->words[count]
                    ? take_word(reader, field, table->words[count][table->rows])
                    : parse_number(reader, field, &table->values[count][table->rows]);
            if (status != AD_OK && !table_postpones(reader->wanted, table, count, reader->error)) {
                return status;
            }
        }
        count++;
    }
    if (count != table->columns) {
        char problem[128];
        snprintf(problem, sizeof problem,
                 "the row has %zu fields; allowed: %zu, one for each name in line %zu", count,
                 table->columns, reader->header_line);
        return refuse(reader, field.start + field.length, NULL, 0, problem);
    }
    table->lines[table->rows++] = reader->line;
    return AD_OK;
}

/* The name of a column. Of measured files columns whose name cannot be one are c1, c2, ... */
static ad_status name_column(csv_reader *reader, csv_field field, size_t column)
{
    char(*names)[TABLE_MAX_NAME + 1] = reader->table->names, problem[160];
    const char *wrong = table_name_problem(field.start, field.length);
    if (wrong && reader->wanted->numbers == TABLE_MEASURED) {
        sprintf(names[column], "c%zu", column + 1);
    } else if (wrong) {
        snprintf(problem, sizeof problem, "%s; the first line must name the columns", wrong);
        return refuse(reader, field.start, field.start, field.length, problem);
    } else {
        memcpy(names[column], field.start, field.length);
    }
    for (size_t k = 0; k < column; k++) {
        if (strcmp(names[k], names[column]) == 0) {
            return refuse(reader, field.start, field.start, field.length,
                          "a column of this name is there already; names must differ");
        }
    }
    return AD_OK;
}

static ad_status read_header(csv_reader *reader)
{
    csv_field field;
    size_t columns = 0, count = 0;
    bool numbers = reader->wanted->numbers == TABLE_MEASURED;
    while (next_field(reader, &field)) {
        double value;
        numbers = numbers && number_problem(reader->wanted, field, &value) == NULL;
        count++;
    }
    reader->field = reader->start;
    if (count > TABLE_MAX_COLUMNS) {
        return refuse(reader, reader->start, NULL, 0, "too many columns; allowed: 1024");
    }
    const size_t capacity = count_rows(reader, count) + numbers;
    reader->table = table_create(reader->wanted, count, capacity);
    if (reader->table) {
        reader->table->lines = calloc(capacity, sizeof *reader->table->lines);
    }
    if (!reader->table || !reader->table->lines) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory for %zu columns of %zu rows",
                       file_bytes_shown(reader->wanted->path), count, capacity);
    }
    while (next_field(reader, &field)) {
        const ad_status status = name_column(reader, field, columns);
        if (status != AD_OK) {
            return status;
        }
        if (table_wants_words(reader->wanted, reader->table->names[columns]) &&
            !table_hold_words(reader->table, columns, capacity)) {
            return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory for %zu words",
                           file_bytes_shown(reader->wanted->path), capacity);
        }
        columns++;
    }
    reader->header_line = reader->line;
    reader->field = reader->start;
    return numbers ? read_row(reader) : AD_OK; /* there is no header */
}

static ad_status read_lines(csv_reader *reader)
{
    ad_status status = next_line(reader);
    if (status == AD_OK && !reader->start) {
        return ad_fail(reader->error, AD_BAD_INPUT,
                       "%s:1:1: the file has no line but blanks and comments; the first must name "
                       "the columns",
                       file_bytes_shown(reader->wanted->path));
    }
    if (status == AD_OK) {
        status = read_header(reader);
    }
    while (status == AD_OK) {
        status = next_line(reader);
        if (!reader->start) {
            break;
        }
        if (status == AD_OK) {
            status = read_row(reader);
        }
    }
    return status;
}

ad_status table_from_csv(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error)
{
    const char *text = (const char *)bytes;
    size_t mark = size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
    ad_error reason = {.message = ""};
    csv_reader reader = {
        .wanted = wanted, .next = text + mark, .end = text + size, .error = &reason};
    number_guard guard;
    if (!hold_plain_numbers(&guard)) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory", file_bytes_shown(wanted->path));
    }
    ad_status status = read_lines(&reader);
    release_plain_numbers(&guard);
    if (status != AD_OK) {
        table_free(reader.table);
        return ad_fail(error, status, "%s", reason.message);
    }
    *table = reader.table;
    return AD_OK;
}

/* ---- writing ---- */

#define WRITTEN_FIELD (TABLE_MAX_NAME + 2) /* an apostrophe, a word or a number, a separator */

/* Shortest text that reads back to the same bits; returns its length. */
static size_t print_number(char *text, double value)
{
    return (size_t)(isnan(value) ? sprintf(text, "nan") : ad_number_text(value, text));
}

/* A name or a word; returns its length. */
static size_t print_text(char *text, const char *word)
{
    return (size_t)sprintf(text, "%s%s", starts_formula(word) ? "'" : "", word);
}

ad_status table_to_csv(const table_source *source, unsigned char **bytes, size_t *size)
{
    number_guard guard;
    size_t columns = source->ncols, rows = source->nrows;
    if (rows > SIZE_MAX / WRITTEN_FIELD / columns - 2) {
        return AD_NO_MEMORY;
    }
    char *text = malloc(columns * (rows + 1) * WRITTEN_FIELD + 1);
    if (!text || !hold_plain_numbers(&guard)) {
        free(text);
        return AD_NO_MEMORY;
    }
    char *out = text;
    for (size_t k = 0; k < columns; k++) {
        out += print_text(out, source->names[k]);
        *out++ = k + 1 < columns ? ',' : '\n';
    }
    for (size_t row = 0; row < rows; row++) {
        for (size_t k = 0; k < columns; k++) {
            out += source->words && source->words[k] ? print_text(out, source->words[k][row])
                                                     : print_number(out, source->columns[k][row]);
            *out++ = k + 1 < columns ? ',' : '\n';
        }
    }
    release_plain_numbers(&guard);
    *bytes = (unsigned char *)text;
    *size = (size_t)(out - text);
    return AD_OK;
}
