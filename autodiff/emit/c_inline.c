/* A formula of scalars as straight C for numbers of any type, from the tape itself. */
#include "autodiff/emit/c_code.h"

#include <stdlib.h>

enum { OPERAND = C_OPERAND };

typedef struct inline_writer {
    ad_tape *tape;
    char (*text)[OPERAND]; /* [nodes] what a node is called; "": not yet */
    FILE *file;
    ad_error *error;
} inline_writer;

static bool mark_needed(const ad_tape *tape, int outputs, const ad_inline_argument *output,
                        bool *needed)
{
    for (int i = 0; i < outputs; i++) {
        for (int k = 0; k < output[i].count; k++) {
            if (!ad_is_valid(output[i].values[k]) || output[i].values[k].tape != tape) {
                return false;
            }
            needed[output[i].values[k].id] = true;
        }
    }
    for (int id = tape->count - 1; id >= 0; id--) {
        for (int i = 0; needed[id] && i < tape->nodes[id].count; i++) {
            needed[tape->arguments[tape->nodes[id].first + i]] = true;
        }
    }
    return true;
}

/* 1/sqrt(x), or 0, is one function: vectors have it quicker than both. */
static int root_below(const ad_tape *tape, int id)
{
    const node *n = &tape->nodes[id];
    if (n->op != OP_RECIPROCAL_OR_ZERO) {
        return -1;
    }
    const node *below = &tape->nodes[tape->arguments[n->first]];
    return below->op == OP_SQRT ? tape->arguments[below->first] : -1;
}

/* As everywhere in written C: exact, and in no locale. */
static void put_number(double number, char *text)
{
    const c_writer plain = {.suffix = ""};
    ad_c_number(&plain, number, text);
}

static int argument(const inline_writer *w, int id, int i)
{
    return w->tape->arguments[w->tape->nodes[id].first + i];
}

/* A function of numbers by their addresses: vectors are not handed over by value. */
static void put_call(const inline_writer *w, int id, const char *name, int count,
                     const int *arguments)
{
    const node *n = &w->tape->nodes[id];
    char exponent[OPERAND];
    for (int i = 0; i < count; i++) {
        if (w->tape->nodes[arguments[i]].op == OP_CONSTANT) {
            fprintf(w->file, "    NUMBER x%d_%d = {0};\n    x%d_%d += %s;\n", id, i, id, i,
                    w->text[arguments[i]]);
        }
    }
    fprintf(w->file, "    NUMBER x%d;\n    ALGEBRA(%s)(", id, name);
    for (int i = 0; i < count; i++) {
        if (w->tape->nodes[arguments[i]].op == OP_CONSTANT) {
            fprintf(w->file, "&x%d_%d, ", id, i);
        } else {
            fprintf(w->file, "&%s, ", w->text[arguments[i]]);
        }
    }
    if (n->op == OP_POWER) {
        put_number(n->number, exponent);
        fprintf(w->file, "%s, ", exponent);
    }
    fprintf(w->file, "&x%d);\n", id);
}

/* A product with -1. */
static bool is_negative(const inline_writer *w, int id)
{
    return w->tape->nodes[id].op == OP_MUL &&
           ad_is_constant(value_of(w->tape, argument(w, id, 0)), -1);
}

static void put_operation(const inline_writer *w, int id)
{
    const node *n = &w->tape->nodes[id];
    const int root = root_below(w->tape, id);
    if (is_negative(w, id)) {
        fprintf(w->file, "    const NUMBER x%d = -%s;\n", id, w->text[argument(w, id, 1)]);
    } else if (n->op == OP_ADD || n->op == OP_SUB || n->op == OP_MUL) {
        fprintf(w->file, "    const NUMBER x%d = %s %c %s;\n", id, w->text[argument(w, id, 0)],
                n->op == OP_ADD   ? '+'
                : n->op == OP_SUB ? '-'
                                  : '*',
                w->text[argument(w, id, 1)]);
    } else if (n->op == OP_RECIPROCAL) {
        fprintf(w->file, "    const NUMBER x%d = 1 / %s;\n", id, w->text[argument(w, id, 0)]);
    } else if (root >= 0) {
        put_call(w, id, "inverse_root", 1, &root);
    } else {
        put_call(w, id, ad_op_table[n->op].name, n->count, w->tape->arguments + n->first);
    }
}

static ad_status put_node(const inline_writer *w, int id)
{
    const node *n = &w->tape->nodes[id];
    if (*w->text[id]) {
        return AD_OK; /* an input */
    }
    if (n->rows != 1 ||
        (n->op != OP_CONSTANT && (!op_is_elementwise(n->op) || n->op == OP_STUMPFF))) {
        return ad_fail(w->error, AD_BAD_ARGUMENT,
                       "%s of %d rows cannot be written as C of one number; allowed: elementwise "
                       "operations of the inputs",
                       ad_op_table[n->op].name, n->rows);
    }
    if (n->op == OP_CONSTANT) {
        put_number(n->splat ? n->number : w->tape->numbers[n->offset], w->text[id]);
        return AD_OK;
    }
    snprintf(w->text[id], OPERAND, "x%d", id);
    put_operation(w, id);
    return AD_OK;
}

static void put_arguments(int count, const ad_inline_argument *arguments, const char *kind,
                          const char *before, FILE *file)
{
    for (int i = 0; i < count; i++) {
        fprintf(file, "%s%sNUMBER %s[%d]", i > 0 ? ", " : before, kind, arguments[i].name,
                arguments[i].count);
    }
}

/* Adds a value to the outputs that it is, as soon as it is known: less is held at a time. */
static void put_outputs(const inline_writer *w, int id, int outputs,
                        const ad_inline_argument *output)
{
    const bool negative = is_negative(w, id);
    const char *text = w->text[negative ? argument(w, id, 1) : id];
    for (int i = 0; i < outputs; i++) {
        for (int k = 0; k < output[i].count; k++) {
            if (output[i].values[k].id == id && !ad_is_constant(output[i].values[k], 0)) {
                fprintf(w->file, "    %s[%d] %c= %s;\n", output[i].name, k, negative ? '-' : '+',
                        text);
            }
        }
    }
}

/* Operands that the C reads: not a root of which only the inverse is, nor what is only subtracted
 * from an output. */
static void mark_read(const inline_writer *w, const bool *needed, bool *read, int outputs,
                      const ad_inline_argument *output)
{
    const ad_tape *tape = w->tape;
    for (int i = 0; i < outputs; i++) {
        for (int k = 0; k < output[i].count; k++) {
            const int id = output[i].values[k].id;
            read[is_negative(w, id) ? argument(w, id, 1) : id] = true;
        }
    }
    for (int id = tape->count - 1; id >= 0; id--) {
        const int root = needed[id] ? root_below(tape, id) : -1;
        for (int i = 0; read[id] && i < tape->nodes[id].count; i++) {
            read[root >= 0 ? root : argument(w, id, i)] = true;
        }
    }
}

static ad_status put_body(const inline_writer *w, const bool *needed, int outputs,
                          const ad_inline_argument *output)
{
    ad_status status = AD_OK;
    bool *read = calloc((size_t)w->tape->count, sizeof *read);
    if (!read) {
        return ad_fail(w->error, AD_NO_MEMORY, "out of memory for the C of a formula");
    }
    mark_read(w, needed, read, outputs, output);
    for (int i = 0; i < outputs; i++) {
        bool written = false;
        for (int k = 0; k < output[i].count; k++) {
            written |= !ad_is_constant(output[i].values[k], 0);
        }
        if (!written) {
            fprintf(w->file, "    (void)%s;\n", output[i].name);
        }
    }
    for (int id = 0; id < w->tape->count && status == AD_OK; id++) {
        status = read[id] ? put_node(w, id) : AD_OK;
        if (status == AD_OK && needed[id]) {
            put_outputs(w, id, outputs, output);
        }
    }
    free(read);
    return status;
}

ad_status ad_write_inline(const char *function, int inputs, const ad_inline_argument *input,
                          int outputs, const ad_inline_argument *output, FILE *file,
                          ad_error *error)
{
    ad_tape *tape = output[0].values[0].tape;
    ad_status status = ad_tape_status(tape, error);
    if (status != AD_OK) {
        return status;
    }
    bool *needed = calloc((size_t)tape->count, sizeof *needed);
    inline_writer w = {tape, calloc((size_t)tape->count, OPERAND), file, error};
    if (!needed || !w.text) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for the C of a formula");
    } else if (!mark_needed(tape, outputs, output, needed)) {
        status = ad_fail(error, AD_BAD_ARGUMENT, "outputs of the C of a formula are of two tapes");
    } else {
        fprintf(file, "ALGEBRA_INLINE void ALGEBRA(%s)(", function);
        put_arguments(inputs, input, "const ", "", file);
        put_arguments(outputs, output, "", inputs > 0 ? ", " : "", file);
        fputs(")\n{\n", file);
        for (int i = 0; i < inputs; i++) {
            bool used = false;
            for (int k = 0; k < input[i].count; k++) {
                const int id = input[i].values[k].id;
                snprintf(w.text[id], OPERAND, "%s[%d]", input[i].name, k);
                used |= needed[id];
            }
            if (!used) {
                fprintf(file, "    (void)%s;\n", input[i].name);
            }
        }
        status = put_body(&w, needed, outputs, output);
        fputs("}\n\n", file);
    }
    free(needed);
    free(w.text);
    return status;
}
