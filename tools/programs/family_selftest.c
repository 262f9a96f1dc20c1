static double distance(int count, const double *is, const double *wanted)
{
    double most = 0;
    int i;
    for (i = 0; i < count; i++) {
        const double off = fabs(is[i] - wanted[i]);
        most = off <= most || most != most ? most : off; /* not a number where one is none */
    }
    return most;
}

int main(void)
{
    static double memory[model_MEMORY];
    double off[2] = {0, 0}, curvature[N], tip[model_COLUMNS], again[model_COLUMNS], beyond[P];
    int i, k;
    for (i = 0; i < MEMBERS; i++) {
        double one[2];
        model_answer answer;
        model_network(parameters[i], curvature, memory);
        one[0] = model_polish(parameters[i], 1, curvature, &answer, memory);
        one[0] += distance(N, curvature, polished[i]) / SCALE;
        one[1] = model_tip(parameters[i], 1, tip, NULL, memory);
        if (answer.trusted) { /* else it may be bent beyond what steps along the rod resolve */
            one[1] += distance(3, tip, tips[i]) / model_places[model_POINTS - 1];
        }
        for (k = 0; k < 2; k++) {
            off[k] = one[k] <= off[k] || off[k] != off[k] ? off[k] : one[k];
        }
        for (k = 0; k < P; k++) {
            beyond[k] = 2 * model_upper[k] - model_lower[k];
        }
        if (model_tip(beyond, 1, tip, NULL, memory) != model_OUT_OF_RANGE ||
            model_tip(model_upper, 1, again, NULL, memory) != 0 || distance(3, tip, again) > 0) {
            printf("beyond its range: not the end of it\n");
            return 1;
        }
    }
    if (!(off[0] <= 1e-9 && off[1] <= 1e-5)) {
        printf("curvature after a step is off by %.1e, the tip by %.1e of the length\n", off[0],
               off[1]);
        return 1;
    }
    printf("difference from cpinn, of curvature after a step by its scale, of the tip by the "
           "length\n");
    printf("step %.1e %.1e\n", off[0], off[1]);
    return 0;
}
