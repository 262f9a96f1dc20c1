/* A recursive descent parser of formulas. */
#include "physics/numerics/constants.h"
#include "physics/quantity/quantity_internal.h"
#include "physics/quantity/spelling.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DEPTH_MAX = 64, NUMBER_MAX = 63 };

typedef struct quantity_parser {
    quantities *names;
    const char *text;
    size_t at;
    int depth;
    ad_status status;
    ad_error error;
} quantity_parser;

/* Letters and digits of any locale, and no others. */
static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool quantity_name_goes_on(const char *at)
{
    return at[0] == '.' && is_letter(at[1]);
}

/* The first error is kept; its column counts from 1. */
static quantity parser_fail(quantity_parser *parser, size_t at, const char *what)
{
    if (parser->status == AD_OK) {
        parser->status = ad_fail(&parser->error, AD_BAD_INPUT, "column %zu of '%.120s': %s", at + 1,
                                 parser->text, what);
    }
    return quantity_number(0);
}

static quantity parser_checked(quantity_parser *parser, size_t at, quantity result)
{
    ad_error error;
    if (quantity_check(result, &error) != AD_OK && parser->status == AD_OK) {
        parser->status = error.status;
        parser->error = error;
    }
    if (result.node && result.node->size > QUANTITY_SIZE_MAX) {
        return parser_fail(parser, at, "too long, with all its names put in; use fewer operations");
    }
    return result;
}

static quantity parser_operate(quantity_parser *parser, size_t at,
                               const quantity_operation *operation, const quantity *x)
{
    return parser_checked(parser, at, quantity_operate(operation, x));
}

static quantity parser_binary(quantity_parser *parser, int operator, quantity a, quantity b)
{
    const quantity x[2] = {a, b};
    return parser_operate(parser, parser->at, &quantity_operations[operator], x);
}

/* ---- grammar --------------------------------------------------------------------------------- */

static quantity parse_sum(quantity_parser *parser);

static char parser_peek(quantity_parser *parser)
{
    while (parser->text[parser->at] && strchr(" \t\n\v\f\r", parser->text[parser->at])) {
        parser->at++;
    }
    return parser->text[parser->at];
}

static bool parser_accept(quantity_parser *parser, char expected)
{
    if (parser_peek(parser) != expected) {
        return false;
    }
    parser->at++;
    return true;
}

/* strtod with a point, whatever the locale; only for digits, point and exponent. */
static quantity parser_decimal(quantity_parser *parser, const char *digits)
{
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!c_locale) {
        parser->status = ad_fail(&parser->error, AD_NO_MEMORY, "out of memory for a formula");
        return quantity_number(0);
    }
    locale_t before = uselocale(c_locale);
    double number = strtod(digits, NULL);
    uselocale(before);
    freelocale(c_locale);
    return quantity_number(number);
}

/* Digits, point, exponent; copied first, because strtod would also take 0x10, inf and nan. */
static quantity parse_number(quantity_parser *parser)
{
    const char *begin = parser->text + parser->at, *p = begin;
    while (is_digit(*p)) {
        p++;
    }
    if (*p == '.') {
        p++;
    }
    while (is_digit(*p)) {
        p++;
    }
    size_t exponent = (p[0] == 'e' || p[0] == 'E') ? 1 : 0;
    if (exponent && (p[1] == '+' || p[1] == '-')) {
        exponent = 2;
    }
    if (exponent && is_digit(p[exponent])) {
        p += exponent;
        while (is_digit(*p)) {
            p++;
        }
    }
    size_t length = (size_t)(p - begin);
    if (length > NUMBER_MAX || (length == 1 && *begin == '.')) {
        return parser_fail(parser, parser->at, "not a number; write 1, 0.5 or 2.5e-3");
    }
    char copy[NUMBER_MAX + 1];
    memcpy(copy, begin, length);
    copy[length] = '\0';
    parser->at += length;
    return parser_decimal(parser, copy);
}

static quantity parse_call(quantity_parser *parser, size_t at, const quantity_operation *function)
{
    char what[96];
    snprintf(what, sizeof what, "%s takes %d argument%s in parentheses", function->name,
             function->arity, function->arity == 1 ? "" : "s");
    if (!parser_accept(parser, '(')) {
        return parser_fail(parser, at, what);
    }
    quantity arguments[QUANTITY_ARGUMENTS_MAX];
    for (int i = 0; i < function->arity; i++) {
        arguments[i] = parse_sum(parser);
        if (parser->status != AD_OK) {
            return quantity_number(0);
        }
        if (!parser_accept(parser, i + 1 < function->arity ? ',' : ')')) {
            return parser_fail(parser, parser->at, what);
        }
    }
    return parser_operate(parser, at, function, arguments);
}

/* The name or function that was meant, or "". */
static const char *nearest_name(const quantities *names, const char *name, size_t length)
{
    const char *nearest = "";
    int best = 2 + ((int)length - 1) / 3, count = quantities_count(names);
    for (int i = 0; i < count + quantity_operation_count; i++) {
        bool named = i < count;
        const char *other = named ? quantities_name(names, i) : quantity_operations[i - count].name;
        int far = spelling_distance(name, length, other, strlen(other));
        if (far < best && length > 1 && (named || !quantity_operations[i - count].precedence)) {
            best = far;
            nearest = other;
        }
    }
    return nearest;
}

static quantity unknown_name(quantity_parser *parser, size_t at, const char *name, size_t length)
{
    char what[400];
    const char *nearest = nearest_name(parser->names, name, length);
    int used = snprintf(what, sizeof what, "unknown name '%.*s'; %s%s%sallowed are ",
                        (int)(length < QUANTITY_NAME_MAX ? length : QUANTITY_NAME_MAX), name,
                        *nearest ? "did you mean " : "", nearest, *nearest ? "? " : "");
    for (int i = 0; i < quantities_count(parser->names) && used < (int)sizeof what; i++) {
        used += snprintf(what + used, sizeof what - (size_t)used, "%s, ",
                         quantities_name(parser->names, i));
    }
    used += used < (int)sizeof what ? snprintf(what + used, sizeof what - (size_t)used, "pi") : 0;
    for (int i = 0; i < quantity_operation_count && used < (int)sizeof what; i++) {
        if (!quantity_operations[i].precedence) {
            used += snprintf(what + used, sizeof what - (size_t)used, ", %s",
                             quantity_operations[i].name);
        }
    }
    return parser_fail(parser, at, what);
}

/* name(x) of a table. */
static quantity parse_table(quantity_parser *parser, size_t at, const quantity_table *table)
{
    static const char what[] = "a table takes 1 argument in parentheses";
    if (!parser_accept(parser, '(')) {
        return parser_fail(parser, at, what);
    }
    quantity x = parse_sum(parser);
    if (parser->status == AD_OK && !parser_accept(parser, ')')) {
        return parser_fail(parser, parser->at, what);
    }
    return parser->status == AD_OK ? parser_checked(parser, at, quantity_table_call(table, x)) : x;
}

/* play(x, r), lag(x, tau): a state. */
static quantity parse_memory(quantity_parser *parser, size_t at, bool lags)
{
    const char *what = lags ? "lag takes 2 arguments in parentheses, the input and the time"
                            : "play takes 2 arguments in parentheses, the input and the threshold";
    quantity arguments[2];
    for (int i = 0; i < 2; i++) {
        if (!parser_accept(parser, i ? ',' : '(')) {
            return parser_fail(parser, parser->at, what);
        }
        arguments[i] = parse_sum(parser);
        if (parser->status != AD_OK) {
            return quantity_number(0);
        }
    }
    if (!parser_accept(parser, ')')) {
        return parser_fail(parser, parser->at, what);
    }
    return parser_checked(parser, at,
                          quantity_memory_call(parser->names, lags, arguments[0], arguments[1]));
}

static quantity parse_name(quantity_parser *parser)
{
    size_t at = parser->at, length = 0;
    const char *name = parser->text + at;
    while (is_letter(name[length]) || is_digit(name[length]) ||
           quantity_name_goes_on(name + length)) {
        length++;
    }
    parser->at += length;
    if (length == 2 && strncmp(name, "pi", 2) == 0) {
        return quantity_number(PI);
    }
    const quantity_operation *function = quantity_operation_find(name, length);
    if (function) {
        return parse_call(parser, at, function);
    }
    const quantity_table *table = quantities_table(parser->names, name, length);
    if (table) {
        return parse_table(parser, at, table);
    }
    const bool lags = length == 3 && strncmp(name, "lag", 3) == 0,
               plays = length == 4 && strncmp(name, "play", 4) == 0;
    if ((lags || plays) && quantities_memory(parser->names)->known) {
        return parse_memory(parser, at, lags);
    }
    quantities_use(parser->names, name, length);
    quantity known = quantities_find(parser->names, name, length);
    return known.is_given ? known : unknown_name(parser, at, name, length);
}

static quantity parse_primary(quantity_parser *parser)
{
    char next = parser_peek(parser);
    if (is_digit(next) || next == '.') {
        return parse_number(parser);
    }
    if (is_letter(next)) {
        return parse_name(parser);
    }
    if (next == '(') {
        parser->at++;
        quantity inside = parse_sum(parser);
        if (parser->status == AD_OK && !parser_accept(parser, ')')) {
            return parser_fail(parser, parser->at, "expected ) or an operator + - * / ^");
        }
        return inside;
    }
    if (next == '\0') {
        return parser_fail(parser, parser->at,
                           "the formula ends where a number, a name or ( is expected");
    }
    bool doubled = next == '*' && parser->at > 0 && parser->text[parser->at - 1] == '*';
    return parser_fail(parser, parser->at,
                       doubled ? "expected a number, a name or (; use ^ for powers"
                               : "expected a number, a name or (");
}

static quantity parse_power(quantity_parser *parser, quantity base);

/* Sign, or a primary with an exponent: -s^2 is -(s^2), 2^-1 is one half, 2^3^2 is 2^9. */
static quantity parse_signed(quantity_parser *parser)
{
    quantity result;
    if (++parser->depth > DEPTH_MAX) {
        parser->depth--;
        return parser_fail(parser, parser->at, "nested more than 64 deep");
    }
    if (parser_accept(parser, '-')) {
        result =
            parser_binary(parser, QUANTITY_MULTIPLY, quantity_number(-1), parse_signed(parser));
    } else if (parser_accept(parser, '+')) {
        result = parse_signed(parser);
    } else {
        result = parse_primary(parser);
        if (parser->status == AD_OK && parser_accept(parser, '^')) {
            result = parse_power(parser, result);
        }
    }
    parser->depth--;
    return result;
}

static quantity parse_power(quantity_parser *parser, quantity base)
{
    size_t at = parser->at;
    quantity exponent = parse_signed(parser);
    if (parser->status == AD_OK && !quantity_is_number(exponent, NULL)) {
        return parser_fail(parser, at, "the exponent of ^ must be constant; write exp(b*log(a))");
    }
    return parser->status == AD_OK ? parser_binary(parser, QUANTITY_POWER, base, exponent) : base;
}

static quantity parse_product(quantity_parser *parser)
{
    quantity result = parse_signed(parser);
    while (parser->status == AD_OK) {
        char operation = parser_peek(parser);
        if (operation != '*' && operation != '/') {
            break;
        }
        parser->at++;
        quantity factor = parse_signed(parser);
        result = parser_binary(parser, operation == '*' ? QUANTITY_MULTIPLY : QUANTITY_DIVIDE,
                               result, factor);
    }
    return result;
}

static quantity parse_sum(quantity_parser *parser)
{
    quantity result = parse_product(parser);
    while (parser->status == AD_OK) {
        char operation = parser_peek(parser);
        if (operation != '+' && operation != '-') {
            break;
        }
        parser->at++;
        quantity term = parse_product(parser);
        result = parser_binary(parser, operation == '+' ? QUANTITY_ADD : QUANTITY_SUBTRACT, result,
                               term);
    }
    return result;
}

quantity quantity_parse(quantities *names, const char *text)
{
    quantity_parser parser = {.names = names, .text = text, .status = AD_OK};
    quantity result = parse_sum(&parser);
    if (parser.status == AD_OK && parser_peek(&parser) != '\0') {
        parser_fail(&parser, parser.at, "expected an operator + - * / ^ or the end of the formula");
    }
    double number = 0;
    if (parser.status == AD_OK && quantity_is_number(result, &number) && !isfinite(number)) {
        parser_fail(&parser, 0, "the value is not a finite number");
    }
    return parser.status == AD_OK ? result
                                  : quantity_error(names, parser.status, parser.error.message);
}
