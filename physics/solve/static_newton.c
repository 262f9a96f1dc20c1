#include "physics/solve/static_newton.h"

#include "autodiff/memory.h"
#include "physics/local/solve_vector.h"
#include "physics/solve/static_friction.h"
#include "physics/solve/static_tension.h"

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
    ad_memory memory;
};

/* ---- what KINSOL calls --------------------------------------------------------------------- */

static int residual(N_Vector y, N_Vector to, void *context)
{
    const static_newton *newton = context;
    double *rows = N_VGetArrayPointer(to), sum = 0;
    static_system_residual(newton->system, N_VGetArrayPointer(y), rows);
    for (size_t i = 0; i < newton->unknowns; i++) {
        sum += fabs(rows[i]);
    }
    return isfinite(sum) ? 0 : 1; /* 1: try a smaller step */
}

static int linearise(N_Vector y, N_Vector rows, SUNMatrix matrix, void *context, N_Vector first,
                     N_Vector second)
{
    const static_newton *newton = context;
    (void)rows, (void)matrix, (void)first, (void)second;
    static_system_linearise(newton->system, N_VGetArrayPointer(y));
    return 0;
}

static int factor(SUNLinearSolver solver, SUNMatrix matrix)
{
    const static_newton *newton = solver->content;
    (void)matrix;
    return solve_elements_factor(&newton->system->mesh) == 0 ? 0 : 1;
}

static int solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector step, N_Vector right,
                 realtype tolerance)
{
    const static_newton *newton = solver->content;
    (void)matrix, (void)tolerance;
    solve_elements_solve(&newton->system->mesh, N_VGetArrayPointer(right),
                         N_VGetArrayPointer(step));
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

static bool allocate(static_newton *newton)
{
    sunindextype count = (sunindextype)newton->unknowns;
    AD_TAKE(newton, right, newton->unknowns);
    AD_TAKE(newton, step, newton->unknowns);
    AD_TAKE(newton, moved, newton->unknowns);
    if (newton->memory.is_short || SUNContext_Create(NULL, &newton->context) != 0) {
        return false;
    }
    newton->y = N_VNewEmpty_Serial(count, newton->context);
    newton->ones = N_VNew_Serial(count, newton->context);
    newton->matrix = SUNMatNewEmpty(newton->context);
    newton->solver = SUNLinSolNewEmpty(newton->context);
    newton->kinsol = KINCreate(newton->context);
    return newton->y && newton->ones && newton->matrix && newton->solver && newton->kinsol &&
           solve_vectors_fit(newton->unknowns);
}

static bool set_up(static_newton *newton)
{
    newton->matrix->ops->getid = is_custom;
    newton->matrix->ops->zero = do_nothing;
    newton->solver->content = newton;
    newton->solver->ops->gettype = is_direct;
    newton->solver->ops->setup = factor;
    newton->solver->ops->solve = solve;
    N_VConst(1, newton->ones);
    N_VSetArrayPointer(newton->step, newton->y); /* a vector to copy the kind from */
    return KINSetErrHandlerFn(newton->kinsol, static_kinsol_say_nothing, NULL) == 0 &&
           KINInit(newton->kinsol, residual, newton->y) == 0 &&
           KINSetUserData(newton->kinsol, newton) == 0 &&
           KINSetLinearSolver(newton->kinsol, newton->solver, newton->matrix) == 0 &&
           KINSetJacFn(newton->kinsol, linearise) == 0 &&
           KINSetMaxSetupCalls(newton->kinsol, 1) == 0 &&
           KINSetNumMaxIters(newton->kinsol, STEPS_MAX) == 0;
}

ad_status static_newton_create(static_system *system, static_newton **result, ad_error *error)
{
    *result = NULL;
    static_newton *newton = calloc(1, sizeof *newton);
    if (newton) {
        newton->system = system;
        newton->unknowns = elements_unknowns(&system->mesh);
    }
    if (!newton || !allocate(newton) || !set_up(newton)) {
        static_newton_free(newton);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for Newton's method");
    }
    if (system->rod->frictions > 0 &&
        !(newton->friction = static_friction_create(system, newton->context))) {
        static_newton_free(newton);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the friction of tendons");
    }
    *result = newton;
    return AD_OK;
}

void static_newton_free(static_newton *newton)
{
    if (newton) {
        static_friction_free(newton->friction);
        KINFree(&newton->kinsol);
        if (newton->y) {
            N_VDestroy(newton->y);
        }
        if (newton->ones) {
            N_VDestroy(newton->ones);
        }
        SUNMatFreeEmpty(newton->matrix);
        SUNLinSolFreeEmpty(newton->solver);
        SUNContext_Free(&newton->context);
        ad_memory_free(&newton->memory);
        free(newton);
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
static bool polish(static_newton *newton, double *y)
{
    static_system_residual(newton->system, y, newton->right);
    static_system_linearise(newton->system, y);
    if (solve_elements_factor(&newton->system->mesh) != 0) {
        return false;
    }
    solve_elements_solve(&newton->system->mesh, newton->right, newton->step);
    double size = static_newton_largest(newton->unknowns, y);
    bool small = static_newton_largest(newton->unknowns, newton->step) <= 1e-3 * fmax(1, size);
    for (size_t i = 0; i < newton->unknowns && small; i++) {
        y[i] -= newton->step[i];
    }
    return small;
}

/* Under given tensions. */
static bool solve_pulled(void *context, double *y, long *steps)
{
    static_newton *newton = context;
    double size = fmax(1, static_newton_largest(newton->unknowns, y));
    long taken = 0;
    KINSetFuncNormTol(newton->kinsol, RESIDUAL * size);
    KINSetScaledStepTol(newton->kinsol, 1e-14);
    N_VSetArrayPointer(y, newton->y);
    int status = KINSol(newton->kinsol, newton->y, KIN_LINESEARCH, newton->ones, newton->ones);
    KINGetNumNonlinSolvIters(newton->kinsol, &taken);
    *steps += taken + 1;
    return (status == KIN_SUCCESS || status == KIN_INITIAL_GUESS_OK) && polish(newton, y);
}

static void step_pulled(void *context, const double *y, double *moved)
{
    static_newton *newton = context;
    static_system_residual(newton->system, y, newton->right);
    solve_elements_solve(&newton->system->mesh, newton->right, newton->step);
    for (size_t i = 0; i < newton->unknowns; i++) {
        moved[i] = y[i] - newton->step[i];
    }
}

/* Of given angles of tendons with friction. */
static bool solve_rubbed(void *context, double *y, long *steps)
{
    static_newton *newton = context;
    const static_tension_newton given = {solve_pulled, step_pulled, newton};
    return static_tension_solve(newton->system, &given, y, newton->moved, steps);
}

bool static_newton_solve(static_newton *newton, double *y, long *steps)
{
    return newton->friction
               ? static_friction_solve(newton->friction, solve_rubbed, newton, y, steps)
               : solve_rubbed(newton, y, steps);
}
