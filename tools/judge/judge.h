/* What an answer is called and measured by: the form of its equations, names that fit files, errors
 * against a reference. */
#ifndef TOOLS_JUDGE_JUDGE_H
#define TOOLS_JUDGE_JUDGE_H

#include "tools/train/experiment.h"
#include "tools/train/reference.h"

enum { JUDGE_NAME = 64, JUDGE_FORM = 40 }; /* bytes of a name and of a form, the end included */

/* Errors against the reference of the scene. */
typedef enum judge_measure {
    JUDGE_POSITION, /* relative L2 error over all points; a beam's deflection */
    JUDGE_TIP,      /* largest error at s = length, over the length */
    JUDGE_ROTATION, /* root mean square of the angle, rad */
    JUDGE_MEASURES
} judge_measure;

const char *judge_measure_name(judge_measure measure); /* "tip", as on the command line */
const char *judge_measure_text(judge_measure measure); /* in words */
void judge_measures(const reference_errors *from, double errors[JUDGE_MEASURES]);

/* `text` as a name that fits a file of words (tools/files/table_file.h): other bytes become '_'.
 * And that of a file, without folders and ending. */
void judge_name(char name[JUDGE_NAME], const char *text);
void judge_name_of_file(char name[JUDGE_NAME], const char *path);

/* Form of the equations and functions by which a network answers: "strain modes by polynomials",
 * "mixed form by random waves", "mixed form by a network" (with hidden layers). */
void judge_form(const experiment *e, char text[JUDGE_FORM]);

/* And the solver, by its method: "spectral elements", "collocation", "strain modes". */
const char *judge_solver_form(const scene *rod_scene, solve_method method);

/* Outputs of the network and equations at a point inside. */
int judge_unknowns(const experiment *e);
int judge_equations(const experiment *e);

#endif
