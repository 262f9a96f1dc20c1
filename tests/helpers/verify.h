/* Inside of the verifier (verify.c, verify_uniform.c). */
#ifndef AD_VERIFY_H
#define AD_VERIFY_H

#include "formulas.h"

typedef struct verifier {
    const ad_program *program;
    const ad_tape *tape;
    formulas formulas;
    bool *ready, *owned; /* [uniform_count] numbers of the uniform memory */
    bool *constant;      /* [uniform_count] */
    uint64_t *sums;      /* [uniform_count] what is expected, then minus what was added */
    int *member;         /* [member_rows] formula held in the memory of the members; 0: none yet */
    int *outputs;        /* [outputs] how often each was written */
    int *unit, *reader;  /* [units] of the pass: formula held; last instruction that read it */
    int pass, instruction;
    bool again; /* the pass is replayed a second time */
    ad_status status;
    ad_error *error;
} verifier;

/* AD_BAD_PROGRAM with the first thing that is wrong. */
ad_status ad_program_verify(const ad_program *program, ad_error *error);

/* Notes the first thing that is wrong; returns false. */
bool ad_verify_wrong(verifier *v, const char *format, ...) __attribute__((format(printf, 2, 3)));

static inline int argument(const verifier *v, const node *n, int i)
{
    return v->tape->arguments[n->first + i];
}

/* Places and constants of uniform values; those that are computed before a pass; one that is read.
 */
bool ad_verify_uniforms(verifier *v);
bool ad_verify_evaluated(verifier *v, const pass *p);
bool ad_verify_ready(verifier *v, int id);

#endif
