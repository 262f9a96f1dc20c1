/* What tools read about an FMU before they run it. Names of elements and attributes: FMI 3.0,
 * sections 2.4, 3.4 and 4.4. */
#include "tools/emit/fmu_parts.h"

#include <stdlib.h>
#include <string.h>

/* ---- words of FMI ---------------------------------------------------------------------------- */

/* What units are put together from, and the exponents of kg, m, s and rad in each. */
enum { BASES = 4, SYMBOLS = 4 };
static const char *const bases[BASES] = {"kg", "m", "s", "rad"};
static const struct {
    const char *symbol;
    int exponents[BASES];
} symbols[SYMBOLS] = {{"N", {1, 1, -2, 0}}, {"m", {0, 1}}, {"rad", {0, 0, 0, 1}}, {"s", {0, 0, 1}}};

/* Powers of the symbols. */
typedef struct unit {
    int powers[SYMBOLS];
} unit;

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

/* Of "N m s^-1", "1/m", "" and their like; false: something in it is not known. */
static bool read_unit(const char *text, unit *u)
{
    int sign = 1;
    memset(u, 0, sizeof *u);
    while (*text) {
        size_t length = strcspn(text, " /^");
        int k = 0, power = 1;
        while (k < SYMBOLS && (strlen(symbols[k].symbol) != length ||
                               strncmp(text, symbols[k].symbol, length) != 0)) {
            k++;
        }
        if (k == SYMBOLS && (length != 1 || *text != '1')) {
            return false;
        }
        text += length;
        if (*text == '^') {
            char *end;
            power = (int)strtol(text + 1, &end, 10);
            text = end;
        }
        if (k < SYMBOLS) {
            u->powers[k] += sign * power;
        }
        sign = *text == '/' ? -1 : 1; /* of the next symbol alone */
        text += *text != 0;
    }
    return true;
}

/* Those above or below the line, "N.m" or "(m.s2)"; the grammar is that of Modelica. */
static int put_symbols(FILE *file, const unit *u, int sign)
{
    int count = 0, done = 0;
    for (int k = 0; k < SYMBOLS; k++) {
        count += sign * u->powers[k] > 0;
    }
    fprintf(file, "%s", sign > 0 ? (count ? "" : "1") : count > 1 ? "/(" : count ? "/" : "");
    for (int k = 0; k < SYMBOLS; k++) {
        if (sign * u->powers[k] > 0) {
            fprintf(file, "%s%s", done++ ? "." : "", symbols[k].symbol);
            if (sign * u->powers[k] > 1) {
                fprintf(file, "%d", sign * u->powers[k]);
            }
        }
    }
    return count;
}

static void put_unit_name(FILE *file, const unit *u)
{
    put_symbols(file, u, 1);
    if (put_symbols(file, u, -1) > 1) {
        fputc(')', file);
    }
}

/* "position, world frame", "derivative by tt of: position, world frame" */
static void describe(const char *name, char *text, size_t size)
{
    const char *orders = strchr(name, '_'), *found = name;
    for (size_t i = 0; i < sizeof meanings / sizeof *meanings && found == name; i++) {
        size_t length = strlen(meanings[i].begin);
        if (strncmp(name, meanings[i].begin, length) == 0) {
            found = meanings[i].text;
            orders = strchr(name + length, '_');
        }
    }
    snprintf(text, size, "%s%s%s%s", orders ? "derivative by " : "", orders ? orders + 1 : "",
             orders ? " of: " : "", found);
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

static void put_unit(FILE *file, const unit *u)
{
    fprintf(file, "    <Unit name=\"");
    put_unit_name(file, u);
    fprintf(file, "\"><BaseUnit");
    for (int b = 0; b < BASES; b++) {
        int exponent = 0;
        for (int k = 0; k < SYMBOLS; k++) {
            exponent += u->powers[k] * symbols[k].exponents[b];
        }
        if (exponent) {
            fprintf(file, " %s=\"%d\"", bases[b], exponent);
        }
    }
    fprintf(file, "/></Unit>\n");
}

/* Each unit once: those of the variables, unless one before has it. */
static ad_status put_units(const fmu_model *m, FILE *file, ad_error *error)
{
    static const fmu_variable own[] = {{"out_of_range", "", 0, 0}, {"time", "s", 0, 0}};
    enum { OWN = sizeof own / sizeof *own };
    int count = OWN + m->input_count + m->output_count, used = 0;
    unit *list = calloc((size_t)count, sizeof *list);
    ad_status status = list ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for units");
    fprintf(file, "  <UnitDefinitions>\n");
    for (int i = 0; i < count && status == AD_OK; i++) {
        const fmu_variable *v = i < OWN                    ? &own[i]
                                : i < OWN + m->input_count ? &m->inputs[i - OWN]
                                                           : &m->outputs[i - OWN - m->input_count];
        unit *u = &list[used];
        int same = 0;
        if (!read_unit(v->unit, u)) {
            status = ad_fail(error, AD_BAD_ARGUMENT, "%s: no unit of FMI is known for '%s'",
                             v->name, v->unit);
            break;
        }
        while (memcmp(&list[same], u, sizeof *u) != 0) {
            same++;
        }
        if (same == used) {
            put_unit(file, &list[used++]);
        }
    }
    free(list);
    fprintf(file, "  </UnitDefinitions>\n");
    return status;
}

/* NAME="VALUE", by as few digits as give the same number again. */
static void put_number(FILE *file, const char *name, double value)
{
    char text[32];
    ad_number_text(value, text);
    put_attribute(file, name, text);
}

/* Begins <Float64 name="x[2]" valueReference="7" description="..." unit="m" */
static void put_variable(const fmu_model *m, FILE *file, const char *name, int place, int reference,
                         const char *description, const char *unit_text)
{
    unit u;
    char of_place[16] = "";
    if (place >= 0 && m->place_count > 1) {
        snprintf(of_place, sizeof of_place, "[%d]", place + 1);
    }
    read_unit(unit_text, &u);
    fprintf(file, "    <Float64 name=\"%s%s\" valueReference=\"%d\" unit=\"", name, of_place,
            reference);
    put_unit_name(file, &u);
    fputc('"', file);
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
        fprintf(file, " causality=\"%s\" variability=\"%s\"%s", motion ? "parameter" : "input",
                motion ? "tunable" : "continuous", motion ? " initial=\"exact\"" : "");
        put_number(file, "min", s->lower);
        put_number(file, "max", s->upper);
        put_number(file, "start", m->places[k]);
        fprintf(file, "/>\n");
    }
    for (int k = 0; k < m->place_count; k++) {
        for (int i = 0; i < m->output_count; i++) {
            const fmu_variable *v = &m->outputs[i];
            char text[128];
            describe(v->name, text, sizeof text);
            put_variable(m, file, v->name, k, reference++, text, v->unit);
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
    fprintf(file, "  <DefaultExperiment");
    put_number(file, "startTime", t >= 0 ? m->inputs[t].lower : 0);
    put_number(file, "stopTime", t >= 0 ? m->inputs[t].upper : 1);
    fprintf(file, "/>\n");
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
