/* Values that are the same at every point: evaluated once per run, in the order of the tape. */
#include "autodiff/compile/program.h"

#include <string.h>

const double *ad_uniform_at(const ad_program *program, int id, const ad_run *run)
{
    place p = program->places[id];
    return (p.kind == PLACE_PARAMETER ? run->parameters : program->uniform) + p.offset;
}

static const double *argument_at(const ad_program *program, const node *n, int i, const ad_run *run)
{
    return ad_uniform_at(program, program->tape->arguments[n->first + i], run);
}

static int argument_rows(const ad_program *program, const node *n, int i)
{
    return program->tape->nodes[program->tape->arguments[n->first + i]].rows;
}

static void elementwise(const ad_program *program, const node *n, const ad_run *run, double *out)
{
    const double *from[AD_ARITY_MAX];
    int step[AD_ARITY_MAX];
    for (int i = 0; i < n->count; i++) {
        from[i] = argument_at(program, n, i, run);
        step[i] = argument_rows(program, n, i) > 1;
    }
    for (int row = 0; row < n->rows; row++) {
        double x[AD_ARITY_MAX] = {0};
        for (int i = 0; i < n->count; i++) {
            x[i] = from[i][row * step[i]];
        }
        out[row] = ad_op_evaluate(n->op, n->whole, n->number, x);
    }
}

/* y = W x, or y = W^T x; W is [m][k]. */
static void product(const double *w, const double *x, int m, int k, bool transposed, double *y)
{
    memset(y, 0, (size_t)(transposed ? k : m) * sizeof *y);
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < k; j++) {
            if (transposed) {
                y[j] += w[i * k + j] * x[i];
            } else {
                y[i] += w[i * k + j] * x[j];
            }
        }
    }
}

static void join(const ad_program *program, const node *n, const ad_run *run, double *out)
{
    int row = n->op == OP_PAD ? n->whole : 0;
    memset(out, 0, (size_t)n->rows * sizeof *out);
    for (int i = 0; i < n->count; i++) {
        int rows = argument_rows(program, n, i);
        memcpy(out + row, argument_at(program, n, i, run), (size_t)rows * sizeof *out);
        row += rows;
    }
}

static void evaluate(const ad_program *program, const node *n, const ad_run *run, double *out)
{
    const double *a = n->count > 0 ? argument_at(program, n, 0, run) : NULL;
    const double *b = n->count > 1 ? argument_at(program, n, 1, run) : NULL;
    int b_rows = n->count > 1 ? argument_rows(program, n, 1) : 0;
    size_t members = run->members > 0 ? run->members : 1;
    switch (ad_op_table[n->op].form) {
    case FORM_LEAF:
        if (n->op == OP_UNIFORM) {
            memcpy(out, run->uniforms[n->whole], (size_t)n->rows * sizeof *out);
        } else { /* OP_POINTS */
            out[0] = n->whole == OVER_POINTS    ? (double)run->points
                     : n->whole == OVER_MEMBERS ? (double)members
                                                : (double)run->points / (double)members;
        }
        break;
    case FORM_JOIN:
        join(program, n, run, out);
        break;
    case FORM_SUM_ROWS:
        out[0] = 0;
        for (int i = 0; i < argument_rows(program, n, 0); i++) {
            out[0] += a[i];
        }
        break;
    case FORM_PRODUCT: {
        bool transposed = n->op == OP_MATVEC_TRANSPOSED;
        product(a, b, transposed ? b_rows : n->rows, transposed ? n->rows : b_rows, transposed,
                out);
        break;
    }
    case FORM_OUTER:
        for (int i = 0; i < n->rows; i++) {
            out[i] = a[i / b_rows] * b[i % b_rows];
        }
        break;
    default:
        elementwise(program, n, run, out);
    }
}

void ad_uniform_evaluate(ad_program *program, const pass *p, const ad_run *run)
{
    for (int i = 0; i < p->uniform_count; i++) {
        int id = p->uniforms[i];
        evaluate(program, &program->tape->nodes[id], run,
                 program->uniform + program->places[id].offset);
    }
}
