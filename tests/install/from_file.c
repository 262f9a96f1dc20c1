/* A program outside the project, in C and in C++: trains a scene file, keeps the run in a folder,
 * opens it again and evaluates it.
 *   from_file CONFIG.yaml FOLDER */
#include <cpinn/cpinn.h>

#include <stdio.h>

int main(int count, char **arguments)
{
    ad_error error;
    cpinn_options options = {0, NULL, false, NULL, NULL};
    cpinn_model *trained = NULL, *model = NULL;
    evaluator *tip = NULL;
    const double s = 1, t = 1;
    double values[3];
    options.folder = count > 2 ? arguments[2] : NULL;
    if (count < 3 || cpinn_train_file(arguments[1], 0, NULL, &options, &trained, &error) != AD_OK ||
        cpinn_open(options.folder, &model, &error) != AD_OK ||
        cpinn_evaluator(model, "x z z_tt", &tip, &error) != AD_OK ||
        evaluator_evaluate(tip, 1, &s, &t, values, &error) != AD_OK) {
        fprintf(stderr, "%s\n", count < 3 ? "from_file CONFIG.yaml FOLDER" : error.message);
        return 2;
    }
    size_t rows = cpinn_history_rows(model);
    printf("from a file: %s; error %.1e, tip at %.6f, %.6f m, accelerates by %.4f m/s^2\n",
           verdict_outcome_name(verdict_outcome_of(cpinn_verdict(model))),
           cpinn_history_value(model, rows - 1, "error"), values[0], values[1], values[2]);
    int result = verdict_exit_status(cpinn_verdict(model));
    evaluator_free(tip);
    cpinn_free(model);
    cpinn_free(trained);
    return result;
}
