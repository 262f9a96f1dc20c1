#include "physics/solve/static_newton.h"

#include "physics/solve/solve_vector.h"
#include "physics/solve/static_friction.h"
#include "physics/solve/static_tension.h"
#include "physics/solve/strain_newton.h"

#include <kinsol/kinsol.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>
#include <string.h>

/* KINSOL stops here, relative to the largest unknown; one plain step then reaches rounding. */
static const double RESIDUAL = 1e-9;
enum { STEPS_MAX = 40 };

struct static_newton {
    static_system *system;
    size_t unknowns;
    SUNContext context;
    SUNMatrix matrix; /* without content: the derivatives are the system's */
    SUNLinearSolver solver;
    void *kinsol;
    N_Vector y, ones;
    double *right, *step, *moved;
    static_friction *friction; /* NULL: no tendon has any */
    strain_newton *strain;     /* of the method that is asked for; NULL: KINSOL */
};

/* ---- what KINSOL calls --------------------------------------------------------------------- */

static int residual(N_Vector y, N_Vector to, void *context)
{
    const static_newton *x = context;
    double *rows = N_VGetArrayPointer(to), sum = 0;
    static_system_residual(x->system, N_VGetArrayPointer(y), rows);
    for (size_t i = 0; i < x->unknowns; i++) {
        sum += fabs(rows[i]);
    }
    return isfinite(sum) ? 0 : 1; /* 1: try a smaller step */
}

static int linearise(N_Vector y, N_Vector rows, SUNMatrix matrix, void *context, N_Vector first,
                     N_Vector second)
{
    const static_newton *x = context;
    (void)rows, (void)matrix, (void)first, (void)second;
    static_system_linearise(x->system, N_VGetArrayPointer(y));
    return 0;
}

static int factor(SUNLinearSolver solver, SUNMatrix matrix)
{
    const static_newton *x = solver->content;
    (void)matrix;
    return static_system_factor(x->system) == 0 ? 0 : 1;
}

static int solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector step, N_Vector right,
                 realtype tolerance)
{
    const static_newton *x = solver->content;
    (void)matrix, (void)tolerance;
    static_system_solve(x->system, N_VGetArrayPointer(right), N_VGetArrayPointer(step));
    return 0;
}

static SUNLinearSolver_Type is_direct(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_DIRECT;
}

static SUNMatrix_ID is_custom(SUNMatrix matrix)
{
    (void)matrix;
    return SUNMATRIX_CUSTOM;
}

static int do_nothing(SUNMatrix matrix)
{
    (void)matrix;
    return 0;
}

/* ---- making -------------------------------------------------------------------------------- */

static bool allocate(static_newton *x)
{
    sunindextype count = (sunindextype)x->unknowns;
    x->right = malloc(x->unknowns * sizeof *x->right);
    x->step = malloc(x->unknowns * sizeof *x->step);
    x->moved = malloc(x->unknowns * sizeof *x->moved);
    if (!x->right || !x->step || !x->moved || SUNContext_Create(NULL, &x->context) != 0) {
        return false;
    }
    x->y = N_VNewEmpty_Serial(count, x->context);
    x->ones = N_VNew_Serial(count, x->context);
    x->matrix = SUNMatNewEmpty(x->context);
    x->solver = SUNLinSolNewEmpty(x->context);
    x->kinsol = KINCreate(x->context);
    return x->y && x->ones && x->matrix && x->solver && x->kinsol && solve_vectors_fit(x->unknowns);
}

static bool set_up(static_newton *x)
{
    x->matrix->ops->getid = is_custom;
    x->matrix->ops->zero = do_nothing;
    x->solver->content = x;
    x->solver->ops->gettype = is_direct;
    x->solver->ops->setup = factor;
    x->solver->ops->solve = solve;
    N_VConst(1, x->ones);
    N_VSetArrayPointer(x->step, x->y); /* a vector to copy the kind from */
    return KINSetErrHandlerFn(x->kinsol, static_kinsol_say_nothing, NULL) == 0 &&
           KINInit(x->kinsol, residual, x->y) == 0 && KINSetUserData(x->kinsol, x) == 0 &&
           KINSetLinearSolver(x->kinsol, x->solver, x->matrix) == 0 &&
           KINSetJacFn(x->kinsol, linearise) == 0 && KINSetMaxSetupCalls(x->kinsol, 1) == 0 &&
           KINSetNumMaxIters(x->kinsol, STEPS_MAX) == 0;
}

ad_status static_newton_create(static_system *system, static_newton **result, ad_error *error)
{
    *result = NULL;
    static_newton *x = calloc(1, sizeof *x);
    if (x) {
        x->system = system;
        x->unknowns = static_system_unknowns(system);
    }
    if (!x || !allocate(x) || !set_up(x)) {
        static_newton_free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for Newton's method");
    }
    if (static_system_rod(system)->frictions > 0 &&
        !(x->friction = static_friction_create(system, x->context))) {
        static_newton_free(x);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the friction of tendons");
    }
    if (static_system_rod(system)->method == SOLVE_STRAIN) {
        ad_status status = strain_newton_create(system, &x->strain, error);
        if (status != AD_OK) {
            static_newton_free(x);
            return status;
        }
    }
    *result = x;
    return AD_OK;
}

void static_newton_free(static_newton *x)
{
    if (x) {
        static_friction_free(x->friction);
        strain_newton_free(x->strain);
        KINFree(&x->kinsol);
        if (x->y) {
            N_VDestroy(x->y);
        }
        if (x->ones) {
            N_VDestroy(x->ones);
        }
        SUNMatFreeEmpty(x->matrix);
        SUNLinSolFreeEmpty(x->solver);
        SUNContext_Free(&x->context);
        free(x->right);
        free(x->step);
        free(x->moved);
        free(x);
    }
}

/* ---- solving ------------------------------------------------------------------------------- */

double static_newton_largest(size_t count, const double *x)
{
    double result = 0;
    for (size_t i = 0; i < count && !isnan(result); i++) {
        double size = fabs(x[i]);
        result = size <= result ? result : size;
    }
    return result;
}

/* One plain step. */
static bool polish(static_newton *x, double *y)
{
    static_system_residual(x->system, y, x->right);
    static_system_linearise(x->system, y);
    if (static_system_factor(x->system) != 0) {
        return false;
    }
    static_system_solve(x->system, x->right, x->step);
    double size = static_newton_largest(x->unknowns, y);
    bool small = static_newton_largest(x->unknowns, x->step) <= 1e-3 * fmax(1, size);
    for (size_t i = 0; i < x->unknowns && small; i++) {
        y[i] -= x->step[i];
    }
    return small;
}

/* Under given tensions. */
static bool solve_pulled(void *context, double *y, long *steps)
{
    static_newton *x = context;
    double size = fmax(1, static_newton_largest(x->unknowns, y));
    long taken = 0;
    if (x->strain) {
        return strain_newton_solve(x->strain, y, steps);
    }
    KINSetFuncNormTol(x->kinsol, RESIDUAL * size);
    KINSetScaledStepTol(x->kinsol, 1e-14);
    N_VSetArrayPointer(y, x->y);
    int status = KINSol(x->kinsol, x->y, KIN_LINESEARCH, x->ones, x->ones);
    KINGetNumNonlinSolvIters(x->kinsol, &taken);
    *steps += taken + 1;
    return (status == KIN_SUCCESS || status == KIN_INITIAL_GUESS_OK) && polish(x, y);
}

static void step_pulled(void *context, const double *y, double *moved)
{
    static_newton *x = context;
    if (x->strain) { /* all the way */
        long steps = 0;
        memcpy(moved, y, x->unknowns * sizeof *moved);
        strain_newton_solve(x->strain, moved, &steps);
        return;
    }
    static_system_residual(x->system, y, x->right);
    static_system_solve(x->system, x->right, x->step);
    for (size_t i = 0; i < x->unknowns; i++) {
        moved[i] = y[i] - x->step[i];
    }
}

/* Of given angles of tendons with friction. */
static bool solve_rubbed(void *context, double *y, long *steps)
{
    static_newton *x = context;
    const static_tension_newton given = {solve_pulled, step_pulled, x};
    return static_tension_solve(x->system, &given, y, x->moved, steps);
}

bool static_newton_solve(static_newton *x, double *y, long *steps)
{
    return x->friction ? static_friction_solve(x->friction, solve_rubbed, x, y, steps)
                       : solve_rubbed(x, y, steps);
}
