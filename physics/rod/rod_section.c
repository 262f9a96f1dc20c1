#include "physics/rod/rod_section.h"

#include "physics/rod/rod_internal.h"

#include <math.h>

const char *rod_section_name(rod_section which)
{
    static const char *const names[] = {
#define NAME(value, name) name,
        ROD_SECTION_LIST(NAME)
#undef NAME
    };
    return names[which];
}

/* Smaller than what squares of strains can be told from 0: a slope there is 0, and a number. */
static const double NOTHING = 1e-200;

static ad_value size_of(ad_value a, ad_value b)
{
    const ad_value squares = ad_add(ad_square(a), ad_square(b));
    return ad_sqrt(ad_add(squares, ad_scalar(a.tape, NOTHING)));
}

/* ---- strain of fibres ---------------------------------------------------------------------- */

/* Of a piece: along d3 by so much, and what bending adds in fibres the furthest off. */
static ad_value fibre_of(const rod_context *rod, const scene_rod *piece, ad_value along,
                         ad_value bending)
{
    ad_value most;
    if (piece->section == SCENE_RECTANGLE) {
        const quantity sides[2] = {piece->height, piece->width}; /* of bending about d1, d2 */
        most = ad_scalar(rod->tape, 0);
        for (int i = 0; i < 2; i++) {
            const ad_value half = ad_scale(rod_quantity(rod, sides[i], rod->s, rod->t), 0.5);
            most = ad_add(most, ad_mul(half, ad_abs(ad_row(bending, i))));
        }
    } else {
        most = ad_mul(rod_quantity(rod, piece->radius, rod->s, rod->t),
                      size_of(ad_row(bending, 0), ad_row(bending, 1)));
    }
    return ad_add(ad_abs(along), most);
}

static ad_value fibre_strain(const rod_context *rod, const ad_value off[2])
{
    const double length = rod->scales.length;
    const ad_value over = ad_reciprocal(rod_growth(rod));
    const ad_value along = ad_mul(over, ad_row(off[0], 2));
    const ad_value bending = ad_scale(ad_mul(over, ad_slice(off[1], 0, 2)), 1 / length);
    ad_value value = ad_scalar(rod->tape, 0);
    for (int i = 0; i < scene_pieces(rod->scene); i++) {
        const scene_piece piece = scene_piece_of(rod->scene, i);
        if (piece.rod.section == SCENE_SECTION_NONE) {
            ad_tape_fail(rod->tape, AD_BAD_INPUT,
                         "has the strain of fibres, for which rod.section must be given");
            return value;
        }
        const ad_value here = fibre_of(rod, &piece.rod, along, bending);
        const ad_value beyond = ad_sub(rod->s, ad_scalar(rod->tape, piece.from / length));
        value = i == 0 ? here : ad_select(beyond, here, value);
    }
    return value;
}

/* ---- energy, force, moment ----------------------------------------------------------------- */

static ad_value energy_of(const rod_context *rod, const rod_coefficients *c, const ad_value off[2])
{
    const scene_law *law = rod->scene->rod.law;
    const double length = rod->scales.length, force = rod->scales.force;
    ad_value given[LAW_GIVEN_MAX], energy;
    for (int i = 0; i < LAW_WRENCH; i++) {
        given[i] = ad_row(off[i / 3], i % 3);
        given[LAW_WRENCH + i] = ad_row(i < 3 ? c->strain_stiffness : c->curvature_stiffness, i % 3);
    }
    if (law) {
        energy = scene_law_record_energy(law, length, force, ad_stack(LAW_WRENCH, given));
    } else {
        law_record(LAW_ELASTIC, rod->tape, given, &energy, NULL, NULL);
    }
    return ad_scale(energy, force);
}

/* Of a scene of numbers: whether the stiffness is infinite in any piece. */
static bool is_reaction(const scene *one, rod_section which)
{
    const scene_properties all = scene_properties_of(one);
    const quantity *const stiffness =
        which < ROD_SECTION_M1 ? all.strain_stiffness : all.curvature_stiffness;
    return isinf(scene_range_of(one, stiffness[which % 3]).high);
}

static ad_value wrench_of(const rod_context *rod, const scene *one, const rod_kinematics *k,
                          rod_section which)
{
    const bool is_force = which < ROD_SECTION_M1;
    if (is_reaction(one, which)) {
        ad_tape_fail(rod->tape, AD_BAD_INPUT,
                     "has %s, which is a reaction: that strain is locked and says nothing of it",
                     rod_section_name(which));
        return k->strain;
    }
    if (scene_has_displaced_tendons(rod->scene) || scene_has_rubbing_tendons(rod->scene)) {
        ad_tape_fail(rod->tape, AD_BAD_INPUT,
                     "has %s, which tendons of given length or with friction add to by tensions "
                     "that strains do not say",
                     rod_section_name(which));
        return k->strain;
    }
    const rod_wrench wrench = rod_constitutive(rod, k);
    return ad_scale(ad_row(is_force ? wrench.force : wrench.moment, which % 3),
                    is_force ? rod->scales.force : rod->scales.moment);
}

ad_value rod_section_record(const scene *family, rod_section which, ad_value s,
                            const ad_value *parameters, ad_value strains)
{
    const char *names[SCENE_PARAMETERS_MAX];
    scene open = *family, one;
    if (which == ROD_SECTION_CURVATURE || which == ROD_SECTION_SHEAR) {
        const int first = which == ROD_SECTION_CURVATURE ? 3 : 0;
        return size_of(ad_row(strains, first), ad_row(strains, first + 1));
    }
    if (family->tube_count > 0) {
        ad_tape_fail(s.tape, AD_BAD_INPUT,
                     "has %s, to which tubes add what strains of the rod do not say",
                     rod_section_name(which));
        return ad_scalar(s.tape, 0);
    }
    open.motion = SCENE_SPATIAL; /* everything in the frame of the world */
    scene_middle(&open, &one);
    for (int i = 0; i < open.parameter_count; i++) {
        names[i] = open.parameters[i].name;
    }
    const domain_place at = rod_place(&one, s, ad_scalar(s.tape, 0));
    const rod_context rod =
        rod_context_open(&open, &one, &at, open.parameter_count, names, parameters);
    const rod_coefficients c = rod_coefficients_of(&rod);
    const ad_value growth = rod_growth(&rod), none = ad_zeros(s.tape, 3);
    const rod_kinematics k = {
        .strain = ad_mul(growth, ad_slice(strains, 0, 3)),
        .curvature = ad_scale(ad_mul(growth, ad_slice(strains, 3, 3)), rod.scales.length),
        .strain_rate = none,
        .curvature_rate = none};
    const ad_value off[2] = {ad_sub(k.strain, c.rest_strain),
                             ad_sub(k.curvature, c.rest_curvature)};
    return which == ROD_SECTION_ENERGY   ? energy_of(&rod, &c, off)
           : which == ROD_SECTION_STRAIN ? fibre_strain(&rod, off)
                                         : wrench_of(&rod, &one, &k, which);
}
