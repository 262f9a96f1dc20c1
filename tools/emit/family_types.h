/* A member is a point of the parameters, in SI units. Its curvature u at model_NODES points of the
 * rod, three numbers each, times the length, and of concentric tubes the torsion of each, over
 * EI/length, is what a network says; steps of Newton's method
 * for the rod's equation polish it, 0, 1 or 2 of them; positions, rotations and all else follow
 * from it. The functions work in the caller's memory alone, model_MEMORY numbers, and keep nothing:
 * several may run at once, each with memory of its own. They return 0, or what is wrong, added up:
 *   model_OUT_OF_RANGE  a parameter is beyond its range by more than rounding, or not a number: the
 *                       result is that at the nearer end of the range (of what is not a number: at
 *                       its lower end)
 *   model_SINGULAR      a step has no finite answer: the curvature stays as the one before left it,
 *                       with that the result goes on; the answer is neither stable nor trusted, its
 *                       distances are infinite; derivatives of an equilibrium are not a number */

/* What is known of an answer. Distances are the largest over the rod, in m, to where one more
 * step, linearised, leads, and what the mesh leaves when steps have settled: by the highest modes
 * of the curvature, of which 256 members say what they are worth. trusted: the equilibrium is
 * stable or may be by its pivots, `predicted` is at most a twentieth of the length, and the last
 * step is at most a quarter of that before, or rounding. */
typedef struct model_answer {
    double predicted; /* of the network */
    double left;      /* of what is returned */
    double ratio;     /* of the last two steps; -1: none was taken */
    int stable, trusted;
    int why; /* it is not trusted: model_NOT_FINITE, model_UNSTABLE, model_TOO_FAR (predicted) or
              * model_NOT_SETTLING; 0: it is */
} model_answer;

extern const double model_lower[model_PARAMETERS], model_upper[model_PARAMETERS];
extern const char *const model_parameter_names[model_PARAMETERS],
    *const model_column_names[model_COLUMNS];
extern const double model_places[model_POINTS]; /* of the shape, m; of the middle */

/* shape [POINTS][COLUMNS], or tip [COLUMNS], of a member with 0, 1 or 2 steps. answer may be
 * NULL: that is quicker, without steps much so. */
int model_shape(const double *parameters, int steps, double *shape, model_answer *answer,
                double *memory);
int model_tip(const double *parameters, int steps, double *tip, model_answer *answer,
              double *memory);

/* The same and derivatives by the parameters, jacobian [COLUMNS][PARAMETERS]: of the network
 * where no steps are taken, else of the equilibrium. */
int model_tip_jacobian(const double *parameters, int steps, double *tip, double *jacobian,
                       model_answer *answer, double *memory);

/* In parts: the network's curvature [NODES][WIDTH], with torsions; steps from any curvature; the
 * shape of a curvature. */
int model_network(const double *parameters, double *curvature, double *memory);
int model_polish(const double *parameters, int steps, double *curvature, model_answer *answer,
                 double *memory);
int model_shape_of(const double *parameters, const double *curvature, double *shape,
                   double *memory);
