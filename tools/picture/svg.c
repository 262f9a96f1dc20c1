/* A picture as areas of one colour, from far to near. */
#include "tools/picture/picture_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void put_colour(FILE *file, picture_colour colour)
{
    fprintf(file, "#%02x%02x%02x", (unsigned)lrintf(255 * colour.red),
            (unsigned)lrintf(255 * colour.green), (unsigned)lrintf(255 * colour.blue));
}

/* A path through corners, relative to one another, in so many parts of a pixel. */
static void put_area(FILE *file, const double (*corners)[2], int count, int parts)
{
    long last[2] = {0, 0};
    for (int j = 0; j < count; j++) {
        long at[2];
        for (int k = 0; k < 2; k++) {
            at[k] = lrint(parts * corners[j][k]);
        }
        const long dx = at[0] - last[0], dy = at[1] - last[1];
        fprintf(file,
                j == 0   ? "M%ld%s%ld"
                : j == 1 ? "l%ld%s%ld"
                : dx < 0 ? "%ld%s%ld"
                         : " %ld%s%ld",
                dx, dy < 0 ? "" : " ", dy);
        last[0] = at[0];
        last[1] = at[1];
    }
    fputc('z', file);
}

/* ---- the floor ----------------------------------------------------------------------------- */

static void put_grid(FILE *file, const picture *p)
{
    double centre[2], radii[2], from[2], to[2];
    picture_floor_seen(p, centre, radii);
    fprintf(
        file,
        "<radialGradient id=\"fade\" gradientUnits=\"userSpaceOnUse\" cx=\"0\" cy=\"0\" r=\"1\" "
        "gradientTransform=\"translate(%.1f %.1f) scale(%.1f %.1f)\">"
        "<stop stop-color=\"#8f9bab\"/><stop offset=\"1\" stop-color=\"#8f9bab\" "
        "stop-opacity=\"0\"/></radialGradient>\n<path fill=\"none\" stroke=\"url(#fade)\" d=\"",
        centre[0], centre[1], radii[0], radii[1]);
    for (int k = 0; picture_grid_line(p, k, from, to); k++) {
        fprintf(file, "M%.1f %.1fL%.1f %.1f", from[0], from[1], to[0], to[1]);
    }
    fprintf(file, "\"/>\n");
}

/* One path of all shadows, so that none is darker where they meet. */
static void put_shadows(FILE *file, const picture *p)
{
    fprintf(file,
            "<filter id=\"soft\"><feGaussianBlur stdDeviation=\"%d\"/></filter>\n"
            "<g opacity=\".3\" filter=\"url(#soft)\"><path fill=\"#26303d\" "
            "transform=\"scale(.5)\" d=\"",
            p->width / 240 + 1);
    for (size_t i = 0; i < p->face_count; i++) {
        const picture_face *face = &p->faces[i];
        double corners[32][2], area = 0;
        if (!face->paint.shadow || face->count > 32) {
            continue;
        }
        for (int j = 0; j < face->count; j++) {
            picture_shadow(p, p->corners[face->first + (uint32_t)j].place, corners[j]);
        }
        for (int j = 0; j < face->count; j++) {
            const double *a = corners[j], *b = corners[(j + 1) % face->count];
            area += a[0] * b[1] - b[0] * a[1];
        }
        for (int j = 0; area < 0 && face->count > 4 && j < face->count / 2; j++) {
            for (int k = 0; k < 2; k++) { /* all the same way round, so that none cancels another */
                const double swap = corners[j][k];
                corners[j][k] = corners[face->count - 1 - j][k];
                corners[face->count - 1 - j][k] = swap;
            }
        }
        if (area > 0.2 || (face->count > 4 && area < -0.2)) { /* one side of each tube, ends */
            put_area(file, (const double(*)[2])corners, face->count, 2);
        }
    }
    fprintf(file, "\"/></g>\n");
}

/* ---- solids -------------------------------------------------------------------------------- */

typedef struct depth {
    double far;
    size_t face;
} depth;

static int by_depth(const void *a, const void *b)
{
    const depth *depth = a, *y = b;
    return depth->far != y->far ? (depth->far < y->far ? 1 : -1) : depth->face < y->face ? -1 : 1;
}

/* Grown by a third of a pixel, so that nothing shines through between neighbours. */
static void put_face(FILE *file, const picture *p, const picture_face *face)
{
    double seen[32][2], centre[2] = {0, 0};
    float place[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
    const int count = face->count < 32 ? face->count : 32;
    for (int j = 0; j < count; j++) {
        const picture_corner *c = &p->corners[face->first + (uint32_t)j];
        const double at[3] = {c->place[0], c->place[1], c->place[2]};
        double full[3];
        picture_project(p, at, full);
        for (int k = 0; k < 3; k++) {
            place[k] += c->place[k] / (float)count;
            normal[k] += c->normal[k];
        }
        for (int k = 0; k < 2; k++) {
            seen[j][k] = full[k];
            centre[k] += full[k] / count;
        }
    }
    for (int j = 0; j < count; j++) {
        const double off = hypot(seen[j][0] - centre[0], seen[j][1] - centre[1]);
        for (int k = 0; k < 2 && face->paint.opacity >= 1 && off > 0; k++) {
            seen[j][k] += 0.35 * (seen[j][k] - centre[k]) / off;
        }
    }
    fprintf(file, "<path fill=\"");
    put_colour(file, picture_light(p, place, normal, face->paint.colour));
    if (face->paint.opacity < 1) {
        fprintf(file, "\" fill-opacity=\"%.2g",
                (double)picture_hides(p, place, normal, face->paint.opacity));
    }
    fprintf(file, "\" d=\"");
    put_area(file, (const double(*)[2])seen, count, 10);
    fprintf(file, "\"/>\n");
}

static void put_faces(FILE *file, const picture *p, depth *list)
{
    size_t count = 0;
    for (size_t i = 0; i < p->face_count; i++) {
        const picture_face *face = &p->faces[i];
        if (!picture_faces_eye(p, face)) {
            continue;
        }
        list[count] = (depth){0, i};
        for (int j = 0; j < face->count; j++) {
            const float *place = p->corners[face->first + (uint32_t)j].place;
            for (int k = 0; k < 3; k++) {
                list[count].far -= (double)place[k] * p->axis[2][k] / face->count;
            }
        }
        count++;
    }
    qsort(list, count, sizeof *list, by_depth);
    fprintf(file, "<g transform=\"scale(.1)\">\n");
    for (size_t i = 0; i < count; i++) {
        put_face(file, p, &p->faces[list[i].face]);
    }
    fprintf(file, "</g>\n");
}

/* ---- lines and words ----------------------------------------------------------------------- */

static void put_stroke(FILE *file, const picture *p, const picture_stroke *s)
{
    fprintf(file, "<path stroke-width=\"%.3g\" stroke=\"", s->width);
    put_colour(file, s->colour);
    fprintf(file, "\" d=\"");
    for (size_t i = s->first; i < s->first + s->count; i++) {
        fprintf(file, "%c%.1f %.1f", i == s->first ? 'M' : 'L', p->points[i][0], p->points[i][1]);
    }
    fprintf(file, "\"/>\n");
}

static void put_word(FILE *file, const picture_word *word)
{
    static const char *const anchors[] = {"start", "middle", "end"};
    fprintf(file, "<text x=\"%.1f\" y=\"%.1f\" font-size=\"%g\" text-anchor=\"%s\" fill=\"",
            word->x, word->y, word->size, anchors[word->align]);
    put_colour(file, word->colour);
    fprintf(file, "\">");
    for (const char *c = word->text; *c; c++) {
        if (*c == '<' || *c == '&' || *c == '>') {
            fprintf(file, "&#%d;", *c);
        } else {
            fputc((unsigned char)*c < ' ' ? ' ' : *c, file);
        }
    }
    fprintf(file, "</text>\n");
}

ad_status picture_svg(const picture *p, char **text, size_t *size, ad_error *error)
{
    depth *list = malloc((p->face_count + 1) * sizeof *list);
    FILE *file = list && !p->failed ? open_memstream(text, size) : NULL;
    if (!file) {
        free(list);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    fprintf(file,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
            "height=\"%d\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
            p->width, p->height, p->width, p->height);
    if (p->has_floor) {
        put_grid(file, p);
        put_shadows(file, p);
    }
    put_faces(file, p, list);
    fprintf(file, "<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n");
    for (size_t i = 0; i < p->stroke_count; i++) {
        put_stroke(file, p, &p->strokes[i]);
    }
    fprintf(file, "</g>\n<g font-family=\"Helvetica,Arial,sans-serif\" stroke=\"#fff\" "
                  "stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\">\n");
    for (size_t i = 0; i < p->word_count; i++) {
        put_word(file, &p->words[i]);
    }
    fprintf(file, "</g>\n</svg>\n");
    free(list);
    if (fclose(file) != 0) {
        free(*text);
        *text = NULL;
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    return AD_OK;
}
