/* A recursive descent parser. Constants are folded while parsing, so the same parser checks a text
 * (no tape: s and t are unknown), evaluates it (s and t are numbers) and records it (s and t are
 * values of a tape). */
#include "physics/expression.h"
#include "physics/constants.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXPRESSION_DEPTH_MAX = 64, EXPRESSION_NUMBER_MAX = 63, EXPRESSION_POWER_MAX = 8 };

/* A known number, or else a value of the tape (when there is one). */
typedef struct expression_node {
    bool known;
    double number;
    ad_value value;
} expression_node;

typedef struct expression_parser {
    const char *text;
    size_t at;
    int depth;
    ad_tape *tape; /* NULL: nothing is recorded */
    expression_node s, t;
    expression_use use;
    ad_status status;
    ad_error error;
} expression_parser;

typedef struct expression_function {
    const char *name;
    int arity;
    double (*number)(const double *x);
    ad_value (*record)(const ad_value *x);
} expression_function;

/* ---- functions: one row each, below ---------------------------------------------------------- */

#define EXPRESSION_UNARY(name, formula, recorded)                                                  \
    static double name##_number(const double *x)                                                   \
    {                                                                                              \
        return formula;                                                                            \
    }                                                                                              \
    static ad_value name##_record(const ad_value *x)                                               \
    {                                                                                              \
        return recorded;                                                                           \
    }

static ad_value record_cosh(ad_value x)
{
    return ad_scale(ad_add(ad_exp(x), ad_exp(ad_neg(x))), 0.5);
}

static ad_value record_one(ad_value x)
{
    return ad_scalar(x.tape, 1);
}

EXPRESSION_UNARY(f_sin, sin(x[0]), ad_sin(x[0]))
EXPRESSION_UNARY(f_cos, cos(x[0]), ad_cos(x[0]))
EXPRESSION_UNARY(f_tan, tan(x[0]), ad_div(ad_sin(x[0]), ad_cos(x[0])))
EXPRESSION_UNARY(f_asin, asin(x[0]), ad_asin(x[0]))
EXPRESSION_UNARY(f_acos, acos(x[0]), ad_acos(x[0]))
EXPRESSION_UNARY(f_atan, atan(x[0]), ad_atan2(x[0], record_one(x[0])))
EXPRESSION_UNARY(f_atan2, atan2(x[0], x[1]), ad_atan2(x[0], x[1]))
/* tanh cosh rather than a difference of exponentials, which loses digits near 0 */
EXPRESSION_UNARY(f_sinh, sinh(x[0]), ad_mul(ad_tanh(x[0]), record_cosh(x[0])))
EXPRESSION_UNARY(f_cosh, cosh(x[0]), record_cosh(x[0]))
EXPRESSION_UNARY(f_tanh, tanh(x[0]), ad_tanh(x[0]))
EXPRESSION_UNARY(f_exp, exp(x[0]), ad_exp(x[0]))
EXPRESSION_UNARY(f_log, log(x[0]), ad_log(x[0]))
EXPRESSION_UNARY(f_sqrt, sqrt(x[0]), ad_sqrt(x[0]))
EXPRESSION_UNARY(f_abs, fabs(x[0]), ad_abs(x[0]))
EXPRESSION_UNARY(f_min, x[0] < x[1] ? x[0] : x[1], ad_min(x[0], x[1]))
EXPRESSION_UNARY(f_max, x[0] > x[1] ? x[0] : x[1], ad_max(x[0], x[1]))
EXPRESSION_UNARY(f_step, x[0] > 0 ? 1 : 0,
                 ad_select(x[0], record_one(x[0]), ad_scalar(x[0].tape, 0)))
EXPRESSION_UNARY(f_where, x[0] > 0 ? x[1] : x[2], ad_select(x[0], x[1], x[2]))

#define EXPRESSION_ROW(text, arity, name)                                                          \
    {                                                                                              \
        text, arity, name##_number, name##_record                                                  \
    }
static const expression_function expression_functions[] = {
    EXPRESSION_ROW("sin", 1, f_sin),     EXPRESSION_ROW("cos", 1, f_cos),
    EXPRESSION_ROW("tan", 1, f_tan),     EXPRESSION_ROW("asin", 1, f_asin),
    EXPRESSION_ROW("acos", 1, f_acos),   EXPRESSION_ROW("atan", 1, f_atan),
    EXPRESSION_ROW("atan2", 2, f_atan2), EXPRESSION_ROW("sinh", 1, f_sinh),
    EXPRESSION_ROW("cosh", 1, f_cosh),   EXPRESSION_ROW("tanh", 1, f_tanh),
    EXPRESSION_ROW("exp", 1, f_exp),     EXPRESSION_ROW("log", 1, f_log),
    EXPRESSION_ROW("sqrt", 1, f_sqrt),   EXPRESSION_ROW("abs", 1, f_abs),
    EXPRESSION_ROW("min", 2, f_min),     EXPRESSION_ROW("max", 2, f_max),
    EXPRESSION_ROW("step", 1, f_step),   EXPRESSION_ROW("where", 3, f_where),
};
enum { EXPRESSION_FUNCTIONS = sizeof expression_functions / sizeof expression_functions[0] };

/* ---- nodes ----------------------------------------------------------------------------------- */

static expression_node node_number(double number)
{
    return (expression_node){.known = true, .number = number};
}

/* The first error is kept; its column counts from 1. */
static expression_node parser_fail(expression_parser *parser, size_t at, const char *what)
{
    if (parser->status == AD_OK) {
        parser->status = ad_fail(&parser->error, AD_BAD_INPUT, "column %zu of '%.120s': %s", at + 1,
                                 parser->text, what);
    }
    return node_number(0);
}

static ad_value node_value(const expression_parser *parser, expression_node node)
{
    return node.known ? ad_scalar(parser->tape, node.number) : node.value;
}

static bool parser_records(const expression_parser *parser)
{
    return parser->tape && parser->status == AD_OK;
}

static expression_node node_binary(const expression_parser *parser, char operation,
                                   expression_node a, expression_node b)
{
    if (a.known && b.known) {
        switch (operation) {
        case '+':
            return node_number(a.number + b.number);
        case '-':
            return node_number(a.number - b.number);
        case '*':
            return node_number(a.number * b.number);
        default:
            return node_number(a.number / b.number);
        }
    }
    expression_node result = {.known = false};
    if (!parser_records(parser)) {
        return result;
    }
    ad_value x = node_value(parser, a), y = node_value(parser, b);
    if (operation == '+') {
        result.value = ad_add(x, y);
    } else if (operation == '-') {
        result.value = ad_sub(x, y);
    } else if (operation == '*') {
        result.value = ad_mul(x, y);
    } else if (b.known) {
        result.value = ad_scale(x, 1 / b.number);
    } else {
        result.value = ad_div(x, y);
    }
    return result;
}

/* Small integer powers by multiplication: exact derivatives at 0 and for negative bases. */
static ad_value record_power(ad_value x, double exponent)
{
    if (exponent != floor(exponent) || fabs(exponent) > EXPRESSION_POWER_MAX) {
        return ad_power(x, exponent);
    }
    ad_value product = ad_scalar(x.tape, 1);
    for (int i = 0; i < (int)fabs(exponent); i++) {
        product = ad_mul(product, x);
    }
    return exponent < 0 ? ad_reciprocal(product) : product;
}

static expression_node node_power(expression_parser *parser, size_t at, expression_node base,
                                  expression_node exponent)
{
    if (!exponent.known) {
        return parser_fail(parser, at, "the exponent of ^ must be constant; write exp(b*log(a))");
    }
    if (base.known) {
        return node_number(pow(base.number, exponent.number));
    }
    expression_node result = {.known = false};
    if (parser_records(parser)) {
        result.value = record_power(base.value, exponent.number);
    }
    return result;
}

static expression_node node_call(const expression_parser *parser,
                                 const expression_function *function, const expression_node *nodes)
{
    double numbers[3] = {0, 0, 0};
    bool known = true;
    for (int i = 0; i < function->arity; i++) {
        known = known && nodes[i].known;
        numbers[i] = nodes[i].number;
    }
    if (known) {
        return node_number(function->number(numbers));
    }
    expression_node result = {.known = false};
    if (!parser_records(parser)) {
        return result;
    }
    ad_value values[3];
    for (int i = 0; i < function->arity; i++) {
        values[i] = node_value(parser, nodes[i]);
    }
    result.value = function->record(values);
    return result;
}

/* ---- grammar --------------------------------------------------------------------------------- */

static expression_node parse_sum(expression_parser *parser);

static char parser_peek(expression_parser *parser)
{
    while (isspace((unsigned char)parser->text[parser->at])) {
        parser->at++;
    }
    return parser->text[parser->at];
}

static bool parser_accept(expression_parser *parser, char expected)
{
    if (parser_peek(parser) != expected) {
        return false;
    }
    parser->at++;
    return true;
}

/* Digits, point, exponent; copied first, because strtod would also take 0x10, inf and nan. */
static expression_node parse_number(expression_parser *parser)
{
    const char *begin = parser->text + parser->at, *p = begin;
    while (isdigit((unsigned char)*p)) {
        p++;
    }
    if (*p == '.') {
        p++;
    }
    while (isdigit((unsigned char)*p)) {
        p++;
    }
    size_t exponent = (p[0] == 'e' || p[0] == 'E') ? 1 : 0;
    if (exponent && (p[1] == '+' || p[1] == '-')) {
        exponent = 2;
    }
    if (exponent && isdigit((unsigned char)p[exponent])) {
        p += exponent;
        while (isdigit((unsigned char)*p)) {
            p++;
        }
    }
    size_t length = (size_t)(p - begin);
    if (length > EXPRESSION_NUMBER_MAX || (length == 1 && *begin == '.')) {
        return parser_fail(parser, parser->at, "not a number; write 1, 0.5 or 2.5e-3");
    }
    char copy[EXPRESSION_NUMBER_MAX + 1];
    memcpy(copy, begin, length);
    copy[length] = '\0';
    parser->at += length;
    return node_number(strtod(copy, NULL));
}

static expression_node parse_call(expression_parser *parser, size_t at,
                                  const expression_function *function)
{
    char what[96];
    snprintf(what, sizeof what, "%s takes %d argument%s in parentheses", function->name,
             function->arity, function->arity == 1 ? "" : "s");
    if (!parser_accept(parser, '(')) {
        return parser_fail(parser, at, what);
    }
    expression_node arguments[3];
    for (int i = 0; i < function->arity; i++) {
        arguments[i] = parse_sum(parser);
        if (parser->status != AD_OK) {
            return node_number(0);
        }
        if (!parser_accept(parser, i + 1 < function->arity ? ',' : ')')) {
            return parser_fail(parser, parser->at, what);
        }
    }
    return node_call(parser, function, arguments);
}

static expression_node parse_name(expression_parser *parser)
{
    size_t at = parser->at, length = 0;
    const char *name = parser->text + at;
    while (isalnum((unsigned char)name[length]) || name[length] == '_') {
        length++;
    }
    parser->at += length;
    if (length == 1 && (*name == 's' || *name == 't')) {
        bool *used = *name == 's' ? &parser->use.s : &parser->use.t;
        *used = true;
        return *name == 's' ? parser->s : parser->t;
    }
    if (length == 2 && strncmp(name, "pi", 2) == 0) {
        return node_number(PI);
    }
    for (int i = 0; i < EXPRESSION_FUNCTIONS; i++) {
        const expression_function *function = &expression_functions[i];
        if (strlen(function->name) == length && strncmp(name, function->name, length) == 0) {
            return parse_call(parser, at, function);
        }
    }
    char what[320];
    int used = snprintf(what, sizeof what, "unknown name '%.*s'; allowed are s, t, pi",
                        (int)(length < 40 ? length : 40), name);
    for (int i = 0; i < EXPRESSION_FUNCTIONS && used < (int)sizeof what; i++) {
        used +=
            snprintf(what + used, sizeof what - (size_t)used, ", %s", expression_functions[i].name);
    }
    return parser_fail(parser, at, what);
}

static expression_node parse_primary(expression_parser *parser)
{
    char next = parser_peek(parser);
    if (isdigit((unsigned char)next) || next == '.') {
        return parse_number(parser);
    }
    if (isalpha((unsigned char)next) || next == '_') {
        return parse_name(parser);
    }
    if (next == '(') {
        parser->at++;
        expression_node inside = parse_sum(parser);
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

/* Sign, or a primary with an exponent: -s^2 is -(s^2), 2^-1 is one half, 2^3^2 is 2^9. */
static expression_node parse_signed(expression_parser *parser)
{
    expression_node result;
    if (++parser->depth > EXPRESSION_DEPTH_MAX) {
        parser->depth--;
        return parser_fail(parser, parser->at, "nested more than 64 deep");
    }
    if (parser_accept(parser, '-')) {
        result = node_binary(parser, '*', node_number(-1), parse_signed(parser));
    } else if (parser_accept(parser, '+')) {
        result = parse_signed(parser);
    } else {
        result = parse_primary(parser);
        if (parser->status == AD_OK && parser_accept(parser, '^')) {
            size_t at = parser->at;
            expression_node exponent = parse_signed(parser);
            if (parser->status == AD_OK) {
                result = node_power(parser, at, result, exponent);
            }
        }
    }
    parser->depth--;
    return result;
}

static expression_node parse_product(expression_parser *parser)
{
    expression_node result = parse_signed(parser);
    while (parser->status == AD_OK) {
        char operation = parser_peek(parser);
        if (operation != '*' && operation != '/') {
            break;
        }
        parser->at++;
        expression_node factor = parse_signed(parser);
        result = node_binary(parser, operation, result, factor);
    }
    return result;
}

static expression_node parse_sum(expression_parser *parser)
{
    expression_node result = parse_product(parser);
    while (parser->status == AD_OK) {
        char operation = parser_peek(parser);
        if (operation != '+' && operation != '-') {
            break;
        }
        parser->at++;
        expression_node term = parse_product(parser);
        result = node_binary(parser, operation, result, term);
    }
    return result;
}

static expression_node parse(expression_parser *parser, const char *text)
{
    parser->text = text;
    expression_node result = parse_sum(parser);
    if (parser->status == AD_OK && parser_peek(parser) != '\0') {
        return parser_fail(parser, parser->at,
                           "expected an operator + - * / ^ or the end of the formula");
    }
    if (parser->status == AD_OK && result.known && !isfinite(result.number)) {
        return parser_fail(parser, 0, "the value is not a finite number");
    }
    return result;
}

/* ---- the face -------------------------------------------------------------------------------- */

ad_status expression_check(const char *text, expression_use *use, ad_error *error)
{
    expression_parser parser = {.status = AD_OK};
    parse(&parser, text);
    if (use) {
        *use = parser.use;
    }
    if (parser.status != AD_OK) {
        return ad_fail(error, parser.status, "%s", parser.error.message);
    }
    return AD_OK;
}

double expression_evaluate(const char *text, double s, double t)
{
    expression_parser parser = {.status = AD_OK, .s = node_number(s), .t = node_number(t)};
    expression_node result = parse(&parser, text);
    return parser.status == AD_OK ? result.number : NAN;
}

bool expression_is_number(const char *text, double *value)
{
    expression_use use = {.s = false, .t = false};
    if (!text || expression_check(text, &use, NULL) != AD_OK || use.s || use.t) {
        return false;
    }
    *value = expression_evaluate(text, 0, 0);
    return true;
}

ad_value expression_record(const char *text, ad_value s, ad_value t)
{
    expression_parser parser = {
        .status = AD_OK, .tape = s.tape, .s = {.value = s}, .t = {.value = t}};
    expression_node result = parse(&parser, text);
    if (parser.status != AD_OK) {
        ad_tape_fail(s.tape, parser.status, "%s", parser.error.message);
        return ad_scalar(s.tape, 0);
    }
    return node_value(&parser, result);
}
