/* What tools read about an FMU before they run it. Names of elements and attributes: FMI 3.0,
 * sections 2.4, 3.4 and 4.4. */
#include "tools/fmu/fmu_parts.h"

#include <string.h>

/* ---- words of FMI ---------------------------------------------------------------------------- */

/* Units of columns, their names in FMI (the grammar of Modelica) and exponents of SI units. */
static const struct {
    const char *unit, *name, *exponents;
} units[] = {{"", "1", ""},
             {"m", "m", " m=\"1\""},
             {"s", "s", " s=\"1\""},
             {"1/m", "1/m", " m=\"-1\""},
             {"1/s", "1/s", " s=\"-1\""},
             {"m/s", "m/s", " m=\"1\" s=\"-1\""},
             {"N", "N", " kg=\"1\" m=\"1\" s=\"-2\""},
             {"N m", "N.m", " kg=\"1\" m=\"2\" s=\"-2\""},
             {"rad", "rad", " rad=\"1\""},
             {"rad/s", "rad/s", " s=\"-1\" rad=\"1\""}};

enum { UNITS = sizeof units / sizeof *units };

/* What columns are, by the beginning of their names; the first that fits. */
static const struct {
    const char *begin, *text;
} meanings[] = {{"theta", "angle of the tube about the backbone"},
                {"mt", "twisting moment of the tube"},
                {"slope_t", "angular velocity of the beam"},
                {"slope", "slope of the beam"},
                {"w_t", "velocity of the beam"},
                {"vx", "velocity, world frame"},
                {"vy", "velocity, world frame"},
                {"vz", "velocity, world frame"},
                {"x", "position, world frame"},
                {"y", "position, world frame"},
                {"z", "position, world frame"},
                {"q", "orientation, quaternion from body to world"},
                {"v", "strain, stretch and shear, body frame"},
                {"u", "strain, curvature and twist, body frame"},
                {"n", "internal force, body frame"},
                {"m", "internal moment, body frame"},
                {"w1", "angular velocity, body frame"},
                {"w2", "angular velocity, body frame"},
                {"w3", "angular velocity, body frame"},
                {"w", "deflection of the beam"},
                {"V", "shear force"},
                {"M", "bending moment"}};

static int unit_index(const char *unit)
{
    int i = 0;
    while (i < UNITS && strcmp(unit, units[i].unit) != 0) {
        i++;
    }
    return i;
}

static const char *meaning(const char *name)
{
    for (size_t i = 0; i < sizeof meanings / sizeof *meanings; i++) {
        if (strncmp(name, meanings[i].begin, strlen(meanings[i].begin)) == 0) {
            return meanings[i].text;
        }
    }
    return name;
}

int fmu_input(const fmu_model *model, const char *name)
{
    for (int i = 0; i < model->input_count; i++) {
        if (strcmp(model->inputs[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

/* ---- elements -------------------------------------------------------------------------------- */

/* NAME="TEXT" */
static void put_attribute(FILE *file, const char *name, const char *text)
{
    fprintf(file, " %s=\"", name);
    for (; *text; text++) {
        const char *escape = *text == '&'   ? "&amp;"
                             : *text == '<' ? "&lt;"
                             : *text == '>' ? "&gt;"
                             : *text == '"' ? "&quot;"
                                            : NULL;
        if (escape) {
            fputs(escape, file);
        } else {
            fputc((unsigned char)*text < ' ' ? ' ' : *text, file);
        }
    }
    fputc('"', file);
}

static ad_status put_units(const fmu_model *m, FILE *file, ad_error *error)
{
    bool used[UNITS + 1] = {false};
    used[unit_index("")] = used[unit_index("s")] = true;
    for (int i = 0; i < m->input_count + m->output_count; i++) {
        const fmu_variable *v =
            i < m->input_count ? &m->inputs[i] : &m->outputs[i - m->input_count];
        used[unit_index(v->unit)] = true;
        if (unit_index(v->unit) == UNITS) {
            return ad_fail(error, AD_BAD_ARGUMENT, "%s: no unit of FMI is known for '%s'", v->name,
                           v->unit);
        }
    }
    fprintf(file, "  <UnitDefinitions>\n");
    for (int i = 0; i < UNITS; i++) {
        if (used[i]) {
            fprintf(file, "    <Unit name=\"%s\"><BaseUnit%s/></Unit>\n", units[i].name,
                    units[i].exponents);
        }
    }
    fprintf(file, "  </UnitDefinitions>\n");
    return AD_OK;
}

/* Begins <Float64 name="x[2]" valueReference="7" description="..." unit="m" */
static void put_variable(const fmu_model *m, FILE *file, const char *name, int place, int reference,
                         const char *description, const char *unit)
{
    char of_place[16] = "";
    if (place >= 0 && m->place_count > 1) {
        snprintf(of_place, sizeof of_place, "[%d]", place + 1);
    }
    fprintf(file, "    <Float64 name=\"%s%s\" valueReference=\"%d\" unit=\"%s\"", name, of_place,
            reference, units[unit_index(unit)].name);
    put_attribute(file, "description", description);
}

static void put_variables(const fmu_model *m, FILE *file)
{
    const fmu_variable *s = &m->inputs[fmu_input(m, "s")];
    bool motion = fmu_input(m, "t") >= 0;
    int reference = 0;
    fprintf(file, "  <ModelVariables>\n");
    put_variable(m, file, "time", -1, reference++, "time", "s");
    fprintf(file, " causality=\"independent\" variability=\"continuous\"/>\n");
    for (int k = 0; k < m->place_count; k++) {
        put_variable(m, file, "s", k, reference++, "arc length of the place", s->unit);
        fprintf(file, " causality=\"%s\" variability=\"%s\"%s min=\"%.17g\" max=\"%.17g\" ",
                motion ? "parameter" : "input", motion ? "tunable" : "continuous",
                motion ? " initial=\"exact\"" : "", s->lower, s->upper);
        fprintf(file, "start=\"%.17g\"/>\n", m->places[k]);
    }
    for (int k = 0; k < m->place_count; k++) {
        for (int i = 0; i < m->output_count; i++) {
            const fmu_variable *v = &m->outputs[i];
            put_variable(m, file, v->name, k, reference++, meaning(v->name), v->unit);
            fprintf(file, " causality=\"output\" variability=\"continuous\"/>\n");
        }
    }
    put_variable(
        m, file, "out_of_range", -1, reference,
        "0 within the ranges that the model was trained for; beyond them, by how much of a "
        "range",
        "");
    fprintf(file, " causality=\"output\" variability=\"continuous\"/>\n  </ModelVariables>\n");
}

/* What the outputs depend on, as Output and as InitialUnknown: the time, in motion, and s of their
 * place; out_of_range on s of all. */
static void put_structure(const fmu_model *m, FILE *file)
{
    const char *time = fmu_input(m, "t") >= 0 ? "0 " : "";
    int first = 1 + m->place_count, outputs = m->place_count * m->output_count;
    fprintf(file, "  <ModelStructure>\n");
    for (int initial = 0; initial < 2; initial++) {
        const char *element = initial ? "InitialUnknown" : "Output";
        for (int i = 0; i < outputs; i++) {
            fprintf(file, "    <%s valueReference=\"%d\" dependencies=\"%s%d\"/>\n", element,
                    first + i, time, 1 + i / m->output_count);
        }
        fprintf(file, "    <%s valueReference=\"%d\" dependencies=\"%s1", element, first + outputs,
                time);
        for (int k = 2; k <= m->place_count; k++) {
            fprintf(file, " %d", k);
        }
        fprintf(file, "\"/>\n");
    }
    fprintf(file, "  </ModelStructure>\n");
}

ad_status fmu_put_description(const fmu_model *m, const char *token, FILE *file, ad_error *error)
{
    static const char abilities[] = "canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\" "
                                    "providesDirectionalDerivatives=\"true\" "
                                    "providesAdjointDerivatives=\"true\"";
    int t = fmu_input(m, "t");
    fprintf(file,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<fmiModelDescription fmiVersion=\"3.0\" variableNamingConvention=\"structured\"");
    put_attribute(file, "modelName", m->title);
    put_attribute(file, "instantiationToken", token);
    put_attribute(file, "description", m->description);
    put_attribute(file, "generationTool", m->tool);
    fprintf(file, ">\n  <ModelExchange modelIdentifier=\"%s\" %s/>\n", m->name, abilities);
    fprintf(
        file,
        "  <CoSimulation modelIdentifier=\"%s\" canHandleVariableCommunicationStepSize=\"true\" "
        "%s/>\n",
        m->name, abilities);
    ad_status status = put_units(m, file, error);
    fprintf(
        file,
        "  <LogCategories>\n"
        "    <Category name=\"logStatusWarning\" description=\"outside of the ranges\"/>\n"
        "    <Category name=\"logStatusError\" description=\"calls that cannot be answered\"/>\n"
        "  </LogCategories>\n");
    fprintf(file, "  <DefaultExperiment startTime=\"%.17g\" stopTime=\"%.17g\"/>\n",
            t >= 0 ? m->inputs[t].lower : 0, t >= 0 ? m->inputs[t].upper : 1);
    put_variables(m, file);
    put_structure(m, file);
    fprintf(file, "</fmiModelDescription>\n");
    return status;
}

void fmu_put_build_description(const fmu_model *m, FILE *file)
{
    fprintf(file,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<fmiBuildDescription fmiVersion=\"3.0\">\n"
            "  <BuildConfiguration modelIdentifier=\"%s\">\n"
            "    <SourceFileSet language=\"C99\">\n"
            "      <SourceFile name=\"%s.c\"/>\n"
            "      <SourceFile name=\"%s_fmi3.c\"/>\n"
            "    </SourceFileSet>\n"
            "  </BuildConfiguration>\n"
            "</fmiBuildDescription>\n",
            m->name, m->name, m->name);
}
