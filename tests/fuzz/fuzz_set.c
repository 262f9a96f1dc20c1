/* Lines of key=value, as --set has them, over one of some scenes, which the first byte chooses:
 * what is taken is written with every default, and read back to the same text. */
#include "tests/fuzz/fuzz_config.h"

static const char *const scenes[] = {
    "rod: {model: kirchhoff, length: 0.3, section: {shape: circle, radius: 0.005},\n"
    "      material: {youngs_modulus: 1.0e6, poissons_ratio: 0.45}}\n"
    "loads: {units: EI, tip: {force: [0, 0, -1]}}\n",
    "parameters: {tension: {range: [0, 2]}, stiffness: 2.0e9}\n"
    "rod: {model: cosserat, length: 0.2, section: {shape: tube, radius: 1e-3, inner_radius: "
    "5e-4},\n"
    "      material: {youngs_modulus: stiffness, poissons_ratio: 0.3, density: 1500}}\n"
    "tendons: [{offset: [0.008, 0], tension: tension*(1-exp(-t))}, {offset: [0, 0.008],\n"
    "          tension: 0.1}]\n"
    "loads: {gravity: [0, 0, -9.81]}\n"
    "time: {duration: 0.5}\n"
    "training: {stages: [{optimizer: adam, steps: 10}, {optimizer: gauss_newton, steps: 5}]}\n",
    "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}}\n"
    "beam: {force: -1}\n"
    "reference: {deflection: -(6*s^2 - 4*s^3 + s^4)/24}\n",
};

enum { SCENES = sizeof scenes / sizeof *scenes, OVERRIDES_MAX = 16 };

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    const char *overrides[OVERRIDES_MAX];
    int count = 0;
    if (size == 0) {
        return 0;
    }
    char *text = fuzz_text(bytes + 1, size - 1), *rest = NULL;
    for (char *line = strtok_r(text, "\n", &rest); line && count < OVERRIDES_MAX;
         line = strtok_r(NULL, "\n", &rest)) {
        overrides[count++] = line;
    }
    fuzz_config(scenes[bytes[0] % SCENES], count, overrides);
    free(text);
    return 0;
}
