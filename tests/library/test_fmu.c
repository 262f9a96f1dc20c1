/* FMUs of models written by hand, of which all values and derivatives are known: the archive, the
 * sources by strict compilers and as C++, and every function as an importer calls it. Skipped (77)
 * where there is no compiler. */
#include "fmi_importer.h"
#include "temporary_folder.h"

#include "physics/learn/model.h"
#include "tools/emit/fmu_parts.h"

static const char header[] = "#ifndef HAND_H\n#define HAND_H\n"
                             "#ifdef __cplusplus\nextern \"C\" {\n#endif\n"
                             "#define hand_MEMORY 3\n"
                             "int hand_eval(const double *in, double *out, double *memory);\n"
                             "int hand_jacobian(const double *in, double *out, double *jacobian,\n"
                             "                  double *memory);\n"
                             "#ifdef __cplusplus\n}\n#endif\n#endif\n";
/* x = s^2 t, z = s - t^2 */
static const char motion_source[] =
    "#include \"hand.h\"\n"
    "int hand_eval(const double *in, double *out, double *memory)\n{\n"
    "    memory[0] = in[0] * in[0];\n    out[0] = memory[0] * in[1];\n"
    "    out[1] = in[0] - in[1] * in[1];\n"
    "    return in[0] < 0 || in[0] > 2 || in[1] < 0 || in[1] > 3;\n}\n"
    "int hand_jacobian(const double *in, double *out, double *jacobian, double *memory)\n{\n"
    "    jacobian[0] = 2 * in[0] * in[1];\n    jacobian[1] = in[0] * in[0];\n"
    "    jacobian[2] = 1;\n    jacobian[3] = -2 * in[1];\n"
    "    return hand_eval(in, out, memory);\n}\n";
/* m1 = s^3 */
static const char rest_source[] =
    "#include \"hand.h\"\n"
    "int hand_eval(const double *in, double *out, double *memory)\n{\n"
    "    memory[2] = in[0] * in[0];\n    out[0] = memory[2] * in[0];\n"
    "    return in[0] < 0 || in[0] > 2;\n}\n"
    "int hand_jacobian(const double *in, double *out, double *jacobian, double *memory)\n{\n"
    "    jacobian[0] = 3 * in[0] * in[0];\n"
    "    return hand_eval(in, out, memory);\n}\n";

static const fmu_variable inputs[] = {{"s", "m", 0, 2}, {"t", "s", 0, 3}};
static const fmu_variable motion_outputs[] = {{"x", "m", 0, 0}, {"vz_ss", "m/s m^-2", 0, 0}};
static const fmu_variable rest_outputs[] = {{"m1", "N m", 0, 0}};
static const double places[] = {1.5, 2};

static const fmu_model motion = {.name = "hand",
                                 .title = "by hand",
                                 .description = "x < s^2 t & \"z\"",
                                 .tool = "a test",
                                 .header = header,
                                 .source = motion_source,
                                 .inputs = inputs,
                                 .outputs = motion_outputs,
                                 .input_count = 2,
                                 .output_count = 2,
                                 .places = places,
                                 .place_count = 2};

static fmu_model rest_model(void)
{
    fmu_model m = motion;
    m.source = rest_source;
    m.outputs = rest_outputs;
    m.input_count = m.output_count = m.place_count = 1;
    return m;
}

/* ---- archives -------------------------------------------------------------------------------- */

static size_t number(const unsigned char *at, int count)
{
    size_t value = 0;
    while (count-- > 0) {
        value = value << 8 | at[count];
    }
    return value;
}

/* Every entry as a file of the folder, without the folders of its name. */
static int unpack(const char *path)
{
    unsigned char *bytes = NULL;
    size_t size = 0, whole = 0, at_entry = 0;
    ad_error error;
    int count = 0;
    assert_int_equal(file_bytes_read(path, 0, &bytes, &size, &whole, &error), AD_OK);
    while (number(bytes + at_entry, 4) == 0x04034b50) {
        unsigned char *entry = bytes + at_entry;
        size_t length = number(entry + 26, 2), data = number(entry + 18, 4);
        char name[256];
        snprintf(name, sizeof name, "%.*s", (int)length, (char *)entry + 30);
        const char *slash = strrchr(name, '/');
        FILE *file = fopen(at(slash ? slash + 1 : name), "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(entry + 30 + length, 1, data, file), data);
        fclose(file);
        at_entry += 30 + length + data;
        count++;
    }
    assert_int_equal(number(bytes + at_entry, 4), 0x02014b50);
    free(bytes);
    return count;
}

static void write_model(const fmu_model *m)
{
    ad_error error = {.message = ""};
    char note[FMU_NOTE];
    bool compiled;
    entries(1);
    if (fmu_write(m, at("hand.fmu"), &compiled, note, &error) != AD_OK || !compiled) {
        fail_msg("%s%s", error.message, note);
    }
    assert_int_equal(unpack(at("hand.fmu")), 6);
}

static void test_archive(void **state)
{
    (void)state;
    write_model(&motion);
    char *token = between(at("modelDescription.xml"), "instantiationToken=\"", "\"");
    char *description = between(at("modelDescription.xml"), " description=\"", "\" generation");
    assert_string_equal(description, "x &lt; s^2 t &amp; &quot;z&quot;");
    fmu_model other = motion;
    const double elsewhere[] = {1.5, 1};
    other.places = elsewhere;
    write_model(&other); /* another FMU: another token */
    char *other_token = between(at("modelDescription.xml"), "instantiationToken=\"", "\"");
    assert_string_not_equal(token, other_token);
    char *strange =
        between(at("modelDescription.xml"), "<Unit name=\"1/(m.s)\"><BaseUnit", "/></U");
    assert_string_equal(strange, " m=\"-1\" s=\"-1\"");
    free(strange);
    strange = between(at("modelDescription.xml"), "<Float64 name=\"vz_ss[2]\"", "causality");
    assert_string_equal(strange, " valueReference=\"6\" unit=\"1/(m.s)\" description=\"derivative "
                                 "by ss of: velocity, world frame\" ");
    free(strange);
    free(token);
    free(other_token);
    free(description);
}

static void test_refusals(void **state)
{
    (void)state;
    const double outside[] = {0.1, 2.5};
    const fmu_variable strange[] = {{"x", "furlong", 0, 0}, {"z", "m", 0, 0}};
    const fmu_variable family[] = {{"s", "m", 0, 2}, {"tension", "N", 0, 1}};
    fmu_model wrong[3] = {motion, motion, motion};
    wrong[0].places = outside;
    wrong[1].outputs = strange;
    wrong[2].inputs = family;
    const char *said[] = {"place 2.5 m is outside the model; allowed: 0 to 2 m",
                          "x: no unit of FMI is known for 'furlong'",
                          "this model has other inputs than s and t"};
    entries(1);
    for (int i = 0; i < 3; i++) {
        ad_error error;
        char note[FMU_NOTE];
        bool compiled;
        assert_int_equal(fmu_write(&wrong[i], at("hand.fmu"), &compiled, note, &error),
                         AD_BAD_ARGUMENT);
        assert_non_null(strstr(error.message, said[i]));
    }
    assert_int_equal(entries(0), 0);
}

static void test_no_compiler(void **state)
{
    (void)state;
    ad_error error;
    char note[FMU_NOTE], *path = strdup(getenv("PATH"));
    bool compiled = true;
    entries(1);
    setenv("PATH", directory, 1);
    assert_int_equal(fmu_write(&motion, at("hand.fmu"), &compiled, note, &error), AD_OK);
    setenv("PATH", path, 1);
    assert_false(compiled);
    assert_non_null(strstr(note, "there is no compiler, cc"));
    assert_int_equal(unpack(at("hand.fmu")), 5);
    free(path);
}

/* Every column of cpinn-eval has a unit in FMI and is described. */
static void test_columns(void **state)
{
    (void)state;
    scene scenes[3];
    for (int i = 0; i < 3; i++) {
        scene_defaults(&scenes[i]);
    }
    scenes[1].rod.model = SCENE_TIMOSHENKO;
    scenes[2].tube_count = 4;
    for (int i = 0; i < 3; i++) {
        const scene_physics *physics = scene_physics_of(&scenes[i]);
        fmu_variable outputs[MODEL_COLUMNS_MAX];
        fmu_model m = motion;
        for (int k = 0; k < physics->column_count; k++) {
            outputs[k] = (fmu_variable){physics->columns[k].name, physics->columns[k].unit, 0, 0};
        }
        m.outputs = outputs;
        m.output_count = physics->column_count;
        char *text = NULL;
        size_t size = 0;
        ad_error error;
        FILE *file = open_memstream(&text, &size);
        assert_int_equal(fmu_put_description(&m, "0", file, &error), AD_OK);
        fclose(file);
        for (int k = 0; k < m.output_count; k++) {
            char undescribed[64];
            snprintf(undescribed, sizeof undescribed, "description=\"%s\"", outputs[k].name);
            assert_null(strstr(text, undescribed));
        }
        free(text);
    }
}

static void test_compilers(void **state)
{
    (void)state;
    static const char *const compilers[] = {"gcc -std=c99", "clang -std=c99", "g++ -x c++",
                                            "clang++ -x c++ -Wno-deprecated"};
    fmu_model models[2] = {motion, rest_model()};
    for (int i = 0; i < 2; i++) {
        write_model(&models[i]);
        for (size_t k = 0; k < sizeof compilers / sizeof *compilers; k++) {
            char command[1024];
            snprintf(command, sizeof command, "command -v %.*s >/dev/null",
                     (int)strcspn(compilers[k], " "), compilers[k]);
            if (system(command) != 0) {
                continue;
            }
            snprintf(command, sizeof command,
                     "cd %s && %s -Wall -Wextra -Wpedantic -Wshadow -Werror -fPIC -shared -o "
                     "made.so hand.c hand_fmi3.c -lm",
                     directory, compilers[k]);
            if (system(command) != 0) {
                fail_msg("fails: %s", command);
            }
        }
    }
}

/* ---- as an importer ------------------------------------------------------------------------- */

static fmi3Instance instantiate(const fmu_model *m, bool by_steps)
{
    write_model(m);
    warnings = errors = 0;
    char *token = between(at("modelDescription.xml"), "instantiationToken=\"", "\"");
    assert_null(importer_open(at("hand.so"), "0", by_steps, false));
    dlclose(library);
    fmi3Instance result = importer_open(at("hand.so"), token, by_steps, false);
    assert_non_null(result);
    assert_int_equal(errors, 1);
    free(token);
    warnings = errors = 0;
    return result;
}

/* References of the model in motion at two places. */
enum { TIME, S1, S2, X1, Z1, X2, Z2, OUT };

static void assert_motion(fmi3Instance instance, double s, double t, int place)
{
    double x, z;
    assert_int_equal(get(instance, place == 1 ? X1 : X2, &x), fmi3OK);
    assert_int_equal(get(instance, place == 1 ? Z1 : Z2, &z), fmi3OK);
    assert_true(x == s * s * t && z == s - t * t); /* the same operations in the same order */
}

static void test_steps(void **state)
{
    (void)state;
    double value, reached;
    fmi3Instance instance = instantiate(&motion, true);
    assert_int_equal(initialize(instance, 0.25), fmi3OK);
    assert_motion(instance, 1.5, 0.25, 1);
    assert_motion(instance, 2, 0.25, 2);
    assert_int_equal(step(instance, 0.25, 0.5, &reached), fmi3OK);
    assert_true(reached == 0.75);
    assert_motion(instance, 1.5, 0.75, 1);
    assert_int_equal(set(instance, S1, 0.5), fmi3OK);
    assert_int_equal(step(instance, 0.75, 0.125, &reached), fmi3OK);
    assert_motion(instance, 0.5, 0.875, 1);
    assert_motion(instance, 2, 0.875, 2);

    /* rounding beyond the end of the range, then outside of it: told once */
    assert_int_equal(step(instance, 3, 4e-16, &reached), fmi3OK);
    assert_int_equal(get(instance, OUT, &value), fmi3OK);
    assert_true(value == 0 && warnings == 0);
    assert_int_equal(step(instance, 3, 1.5, &reached), fmi3Warning);
    assert_int_equal(get(instance, OUT, &value), fmi3OK);
    assert_near(value, 0.5, 1e-15);
    assert_int_equal(step(instance, 4.5, 1.5, &reached), fmi3OK);
    assert_int_equal(get(instance, OUT, &value), fmi3OK);
    assert_near(value, 1, 1e-15);
    assert_int_equal(warnings, 1);
    assert_int_equal(call(instance, "fmi3Terminate"), fmi3OK);
    assert_motion(instance, 0.5, 3, 1); /* still readable; as at the end of the range */
    assert_int_equal(step(instance, 6, 1, &reached), fmi3Error);

    assert_int_equal(call(instance, "fmi3Reset"), fmi3OK);
    assert_int_equal(initialize(instance, 0), fmi3OK);
    assert_motion(instance, 1.5, 0, 1); /* s is where it was at first */
    end(instance);
}

static void test_states(void **state)
{
    (void)state;
    typedef fmi3Status state_function(fmi3Instance, fmi3FMUState *);
    typedef fmi3Status to_state(fmi3Instance, fmi3FMUState);
    typedef fmi3Status size_function(fmi3Instance, fmi3FMUState, size_t *);
    typedef fmi3Status to_bytes(fmi3Instance, fmi3FMUState, fmi3Byte *, size_t);
    typedef fmi3Status from_bytes(fmi3Instance, const fmi3Byte *, size_t, fmi3FMUState *);
    fmi3FMUState kept = NULL, again = NULL;
    fmi3Byte bytes[256];
    size_t size;
    double reached;
    fmi3Instance instance = instantiate(&motion, true);
    assert_int_equal(initialize(instance, 0), fmi3OK);
    assert_int_equal(step(instance, 0, 1, &reached), fmi3OK);
    assert_int_equal(FIND(state_function, "fmi3GetFMUState")(instance, &kept), fmi3OK);
    assert_int_equal(set(instance, S2, 1), fmi3OK);
    assert_int_equal(step(instance, 1, 1, &reached), fmi3OK);
    assert_motion(instance, 1, 2, 2);
    assert_int_equal(FIND(to_state, "fmi3SetFMUState")(instance, kept), fmi3OK);
    assert_motion(instance, 2, 1, 2);
    assert_int_equal(FIND(size_function, "fmi3SerializedFMUStateSize")(instance, kept, &size),
                     fmi3OK);
    assert_true(size <= sizeof bytes);
    assert_int_equal(FIND(to_bytes, "fmi3SerializeFMUState")(instance, kept, bytes, size), fmi3OK);
    assert_int_equal(FIND(state_function, "fmi3FreeFMUState")(instance, &kept), fmi3OK);
    assert_null(kept);
    assert_int_equal(step(instance, 1, 1, &reached), fmi3OK);
    assert_int_equal(FIND(from_bytes, "fmi3DeserializeFMUState")(instance, bytes, size, &again),
                     fmi3OK);
    assert_int_equal(FIND(to_state, "fmi3SetFMUState")(instance, again), fmi3OK);
    assert_motion(instance, 2, 1, 2);
    assert_int_equal(FIND(from_bytes, "fmi3DeserializeFMUState")(instance, bytes, size - 1, &again),
                     fmi3Error);
    FIND(state_function, "fmi3FreeFMUState")(instance, &again);
    end(instance);
}

static void test_exchange(void **state)
{
    (void)state;
    typedef fmi3Status time_function(fmi3Instance, fmi3Float64);
    typedef fmi3Status count_function(fmi3Instance, size_t *);
    fmi3Boolean flags[5];
    double event_time;
    size_t count = 1;
    fmi3Instance instance = instantiate(&motion, false);
    assert_int_equal(initialize(instance, 0), fmi3OK);
    assert_int_equal(
        FIND(flags_function, "fmi3UpdateDiscreteStates")(instance, &flags[0], &flags[1], &flags[2],
                                                         &flags[3], &flags[4], &event_time),
        fmi3OK);
    assert_false(flags[0] || flags[1] || flags[2] || flags[3] || flags[4]);
    assert_int_equal(call(instance, "fmi3EnterContinuousTimeMode"), fmi3OK);
    assert_int_equal(FIND(time_function, "fmi3SetTime")(instance, 1.25), fmi3OK);
    assert_motion(instance, 1.5, 1.25, 1);
    assert_int_equal(FIND(count_function, "fmi3GetNumberOfContinuousStates")(instance, &count),
                     fmi3OK);
    assert_int_equal(count, 0);
    assert_int_equal(call(instance, "fmi3EnterEventMode"), fmi3OK);
    assert_int_equal(set(instance, S1, 1), fmi3OK); /* a parameter: in event mode */
    assert_int_equal(call(instance, "fmi3EnterContinuousTimeMode"), fmi3OK);
    assert_motion(instance, 1, 1.25, 1);
    assert_int_equal(set(instance, S1, 1), fmi3Error); /* and nowhere else */
    assert_int_equal(errors, 1);
    end(instance);
}

static void test_wrong_calls(void **state)
{
    (void)state;
    double value;
    typedef fmi3Status get_integer(fmi3Instance, const fmi3ValueReference *, size_t, int32_t *,
                                   size_t);
    fmi3Instance instance = instantiate(&motion, true);
    const struct {
        fmi3ValueReference reference;
        double value;
    } wrong[] = {{TIME, 1}, {X1, 1}, {S1, NAN}, {99, 1}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(set(instance, wrong[i].reference, wrong[i].value), fmi3Error);
        assert_int_equal(initialize(instance, 0), fmi3Error); /* an error ends it */
        assert_int_equal(call(instance, "fmi3Reset"), fmi3OK);
    }
    assert_int_equal(call(instance, "fmi3Terminate"), fmi3Error); /* not initialised */
    assert_int_equal(call(instance, "fmi3Reset"), fmi3OK);
    assert_int_equal(initialize(instance, INFINITY), fmi3Error);
    assert_int_equal(call(instance, "fmi3Reset"), fmi3OK);
    assert_int_equal(FIND(get_integer, "fmi3GetInt32")(instance, NULL, 0, NULL, 0), fmi3OK);
    assert_int_equal(get(instance, OUT + 1, &value), fmi3Error);
    assert_int_equal(errors, 4 + 4 + 1 + 1 + 1);
    end(instance);
}

static void test_derivatives(void **state)
{
    (void)state;
    const fmi3ValueReference unknowns[] = {X1, Z2, OUT}, knowns[] = {TIME, S1, S2};
    const double seed[] = {2, 3, 5}, t = 0.75;
    double forward[3], adjoint[3], value;
    fmi3Instance instance = instantiate(&motion, true);
    assert_int_equal(initialize(instance, t), fmi3OK);
    assert_int_equal(FIND(product_function, "fmi3GetDirectionalDerivative")(
                         instance, unknowns, 3, knowns, 3, seed, 3, forward, 3),
                     fmi3OK);
    assert_near(forward[0], 1.5 * 1.5 * 2 + 2 * 1.5 * t * 3, 1e-14);
    assert_near(forward[1], -2 * t * 2 + 5, 1e-14);
    assert_near(forward[2], 0, 0);
    assert_int_equal(FIND(product_function, "fmi3GetAdjointDerivative")(
                         instance, unknowns, 3, knowns, 3, seed, 3, adjoint, 3),
                     fmi3OK);
    assert_near(adjoint[0], 2 * 1.5 * 1.5 + 3 * -2 * t, 1e-14);
    assert_near(adjoint[1], 2 * 2 * 1.5 * t, 1e-14);
    assert_near(adjoint[2], 3, 1e-14);

    /* out of range, by s of the second place */
    assert_int_equal(set(instance, S2, 2.5), fmi3OK);
    assert_int_equal(get(instance, OUT, &value), fmi3Warning);
    assert_near(value, 0.25, 1e-15);
    assert_int_equal(FIND(product_function, "fmi3GetDirectionalDerivative")(
                         instance, unknowns, 3, knowns, 3, seed, 3, forward, 3),
                     fmi3OK);
    assert_near(forward[2], 5 / 2., 1e-15);
    assert_near(forward[1], -2 * t * 2, 1e-14); /* s of that place is out: no derivative by it */
    end(instance);
}

static void test_no_event_mode(void **state)
{
    (void)state;
    end(instantiate(&motion, true));
    char *token = between(at("modelDescription.xml"), "instantiationToken=\"", "\"");
    assert_null(importer_open(at("hand.so"), token, true, true));
    assert_int_equal(errors, 1);
    dlclose(library);
    free(token);
}

/* At rest s is an input, which may change in continuous time. */
static void test_rest(void **state)
{
    (void)state;
    const fmi3ValueReference unknown = 2, knowns[] = {0, 1};
    const double seed[] = {1, 1};
    fmu_model m = rest_model();
    double value, slope;
    fmi3Instance instance = instantiate(&m, false);
    assert_int_equal(initialize(instance, 0), fmi3OK);
    assert_int_equal(call(instance, "fmi3EnterContinuousTimeMode"), fmi3OK);
    assert_int_equal(set(instance, 1, 0.5), fmi3OK);
    assert_int_equal(get(instance, 2, &value), fmi3OK);
    assert_true(value == 0.125);
    assert_int_equal(FIND(product_function, "fmi3GetDirectionalDerivative")(
                         instance, &unknown, 1, knowns, 2, seed, 2, &slope, 1),
                     fmi3OK);
    assert_true(slope == 0.75);
    assert_int_equal(get(instance, 3, &value), fmi3OK);
    assert_true(value == 0);
    end(instance);
}

int main(void)
{
    if (system("command -v cc >/dev/null") != 0) {
        return 77;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_archive),       cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_no_compiler),   cmocka_unit_test(test_columns),
        cmocka_unit_test(test_compilers),     cmocka_unit_test(test_steps),
        cmocka_unit_test(test_states),        cmocka_unit_test(test_exchange),
        cmocka_unit_test(test_wrong_calls),   cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_no_event_mode), cmocka_unit_test(test_rest)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
