/* The scene of a random scene, and what it is in words. */
#include "random_scenes.h"

#include <math.h>
#include <string.h>

/* ---- the scene ------------------------------------------------------------------------------- */

static void numbers(int count, const double *from, quantity *to)
{
    for (int i = 0; i < count; i++) {
        to[i] = quantity_number(from[i]);
    }
}

/* Of several of which one is given the others are 0. */
static void profiles(int count, const profile *from, quantity *to, quantities *names)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        any = any || from[i].count > 0;
    }
    for (int i = 0; i < count && any; i++) {
        to[i] = from[i].count > 0 ? profile_quantity(&from[i], names) : quantity_number(0);
    }
}

static void fill_pieces(random_scene *x)
{
    for (int i = 0; i < x->piece_count; i++) {
        random_piece *piece = &x->pieces[i];
        bool is_whole = x->piece_count == 1;
        scene_rod *to = is_whole ? &x->scene.rod : &x->scene.segments[i].rod;
        profiles(2, piece->bending, to->bending_stiffness, x->names);
        if (x->is_beam) {
            to->bending_stiffness[1] = to->bending_stiffness[0];
            continue;
        }
        profiles(1, &piece->torsion, &to->torsional_stiffness, x->names);
        profiles(3, piece->curvature, to->rest_curvature, x->names);
        if (!is_whole) {
            numbers(3, piece->turn, x->scene.segments[i].turn);
        }
    }
}

static void fill_load(random_scene *x, const random_load *load)
{
    scene *to = &x->scene;
    if (load->kind == RANDOM_BODY) {
        to->bodies[to->body_count++] =
            (scene_body){.at = quantity_number(load->at), .mass = quantity_number(load->mass)};
        return;
    }
    if (x->is_beam) {
        scene_beam_load *at = load->kind == RANDOM_TIP ? &to->beam.tip
                              : load->kind == RANDOM_BASE
                                  ? &to->beam.base
                                  : &to->beam.points[to->beam.point_count].load;
        if (load->kind == RANDOM_POINT) {
            to->beam.points[to->beam.point_count++].at = quantity_number(load->at);
        }
        at->force = quantity_number(load->force[0]);
        at->moment = quantity_number(load->moment[0]);
        return;
    }
    scene_load *at = load->kind == RANDOM_TIP    ? &to->loads.tip
                     : load->kind == RANDOM_BASE ? &to->loads.base
                                                 : &to->points[to->point_count].load;
    if (load->kind == RANDOM_POINT) {
        to->points[to->point_count++].at = quantity_number(load->at);
    }
    numbers(3, load->force, at->force);
    numbers(3, load->moment, at->moment);
    at->frame = load->follows ? SCENE_FOLLOWER : SCENE_DEAD;
}

static void fill_pull(random_scene *x, const random_pull *pull)
{
    char text[2][96];
    scene *to = &x->scene;
    quantity offset[2], from = quantity_number(pull->from), until = quantity_number(pull->to);
    for (int i = 0; i < 2; i++) {
        snprintf(text[i], sizeof text[i], "%.17g*%s(%.17g*s+%.17g)", pull->radius,
                 i ? "sin" : "cos", pull->winding, pull->phase);
        offset[i] = pull->winding != 0
                        ? quantity_formula(x->names, text[i])
                        : quantity_number(pull->radius * (i ? sin : cos)(pull->phase));
    }
    if (!pull->is_chamber) {
        to->tendons[to->tendon_count++] = (scene_tendon){.offset = {offset[0], offset[1]},
                                                         .start = from,
                                                         .end = until,
                                                         .tension = quantity_number(pull->tension)};
        return;
    }
    snprintf(text[0], sizeof text[0], "%.17g*(1+%.17g*s)", pull->area, pull->taper / x->length);
    to->chambers[to->chamber_count++] =
        (scene_chamber){.offset = {offset[0], offset[1]},
                        .start = from,
                        .end = until,
                        .pressure = quantity_number(pull->tension / pull->area),
                        .area = quantity_formula(x->names, text[0])};
}

static void fill_springs(random_scene *x)
{
    for (int i = 0; i < x->spring_count; i++) {
        const random_spring *from = &x->springs[i];
        scene_spring *to = &x->scene.springs[x->scene.spring_count++];
        to->at = quantity_number(from->at);
        numbers(3, from->stiffness, to->stiffness);
        numbers(3, from->turning, to->turning);
        if (from->is_anchored) {
            numbers(3, from->anchor, to->anchor);
        }
    }
}

static void fill_end(random_scene *x, int end, bool is_loaded)
{
    const random_end *from = &x->ends[end];
    scene_end *to = end ? &x->scene.end : &x->scene.start;
    to->type = from->holds_rotation   ? SCENE_CLAMPED
               : from->holds_position ? SCENE_PINNED
               : is_loaded            ? SCENE_LOADED
                                      : SCENE_FREE;
    for (int i = 0; i < 4; i++) {
        to->position[i % 3].is_given = to->rotation[i].is_given = false;
    }
    if (x->is_beam) {
        return;
    }
    if (from->holds_position) {
        numbers(3, from->position, to->position);
    }
    if (from->holds_rotation) {
        numbers(4, from->rotation, to->rotation);
    }
}

void random_scene_fill(random_scene *x)
{
    scene *to = &x->scene;
    bool loaded[2] = {false, false};
    fill_pieces(x);
    fill_springs(x);
    for (int i = 0; i < x->load_count; i++) {
        fill_load(x, &x->loads[i]);
        loaded[0] = loaded[0] || x->loads[i].kind == RANDOM_BASE;
        loaded[1] = loaded[1] || x->loads[i].kind == RANDOM_TIP;
    }
    fill_end(x, 0, loaded[0]);
    fill_end(x, 1, loaded[1]);
    if (isfinite(x->shear[0])) {
        numbers(2, x->shear, to->rod.shear_stiffness);
    }
    if (x->is_beam) {
        to->rod.shear_stiffness[1] = to->rod.shear_stiffness[0];
        profiles(1, x->force, &to->beam.force, x->names);
        profiles(1, x->moment, &to->beam.moment, x->names);
        profiles(1, &x->foundation, &to->beam.foundation, x->names);
        return;
    }
    if (isfinite(x->axial)) {
        to->rod.axial_stiffness = quantity_number(x->axial);
    }
    if (x->mass > 0) {
        to->rod.mass_per_length = quantity_number(x->mass);
        numbers(3, x->gravity, to->loads.gravity);
    }
    if (x->stretch.count > 0) {
        to->rod.rest_strain[0] = to->rod.rest_strain[1] = quantity_number(0);
        profiles(1, &x->stretch, &to->rod.rest_strain[2], x->names);
    }
    profiles(3, x->force, to->loads.force, x->names);
    profiles(3, x->moment, to->loads.moment, x->names);
    to->loads.frame = x->follows ? SCENE_FOLLOWER : SCENE_DEAD;
    for (int i = 0; i < x->pull_count; i++) {
        fill_pull(x, &x->pulls[i]);
    }
}

/* ---- in words -------------------------------------------------------------------------------- */

static void describe(const char *name, int count, const profile *from, FILE *to)
{
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < from[k].count; i++) {
            fprintf(to, "%s %s[%d] ", i ? " +" : ";", name, k);
            profile_write(&from[k].parts[i], "table", to);
        }
    }
}

void random_scene_describe(const random_scene *x, FILE *to)
{
    char entry[400];
    fprintf(to, "%s of length %.17g%s%s, from %s to %s", scene_model_names()[x->scene.rod.model],
            x->length, x->is_planar ? ", planar" : "", x->follows ? ", loads follow" : "",
            scene_end_names()[x->scene.start.type], scene_end_names()[x->scene.end.type]);
    describe("force", 3, x->force, to);
    describe("moment", 3, x->moment, to);
    describe("stretch", 1, &x->stretch, to);
    describe("foundation", 1, &x->foundation, to);
    for (int i = 0; i < x->piece_count; i++) {
        const random_piece *piece = &x->pieces[i];
        fprintf(to, "; to %.17g", piece->to);
        describe("bending", 2, piece->bending, to);
        describe("torsion", 1, &piece->torsion, to);
        describe("curvature", 3, piece->curvature, to);
    }
    for (int i = 0; scene_entry_text(&x->scene, i, entry, sizeof entry); i++) {
        fprintf(to, "; %s", entry);
    }
    fputc('\n', to);
}
