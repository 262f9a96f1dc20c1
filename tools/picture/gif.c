/* Animated GIF 89a with one table of 256 colours, by cuts through the middle of what there is, and
 * Lempel, Ziv and Welch's compression. */
#include "tools/picture/images.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BINS = 1 << 15, COLOURS = 255, CODES = 4096 }; /* colour 255: what was there */

struct image_gif {
    int width, height;
    size_t images;
    unsigned count[BINS];
    unsigned char nearest[BINS]; /* colour of each bin */
    unsigned char table[COLOURS + 1][3];
    unsigned char *last, *now, *kept; /* [height][width] */
    uint16_t next[CODES][256];        /* codes of longer strings; 0: none */
    FILE *file;
    char *bytes;
    size_t size;
};

/* ---- colours ------------------------------------------------------------------------------- */

static int bin_of(const unsigned char *rgb)
{
    return (rgb[0] >> 3) << 10 | (rgb[1] >> 3) << 5 | rgb[2] >> 3;
}

static int channel(int bin, int k)
{
    return bin >> (10 - 5 * k) & 31;
}

typedef struct box {
    int low[3], high[3]; /* of bins, ends included */
    unsigned long count;
} box;

static bool holds(const box *b, int bin)
{
    for (int k = 0; k < 3; k++) {
        if (channel(bin, k) < b->low[k] || channel(bin, k) > b->high[k]) {
            return false;
        }
    }
    return true;
}

/* To what is in it. */
static void shrink(box *b, const unsigned *count)
{
    box tight = {{31, 31, 31}, {0, 0, 0}, 0};
    for (int r = b->low[0]; r <= b->high[0]; r++) {
        for (int g = b->low[1]; g <= b->high[1]; g++) {
            for (int l = b->low[2]; l <= b->high[2]; l++) {
                const int bin = r << 10 | g << 5 | l;
                for (int k = 0; k < 3 && count[bin] > 0; k++) {
                    const int at = channel(bin, k);
                    tight.low[k] = at < tight.low[k] ? at : tight.low[k];
                    tight.high[k] = at > tight.high[k] ? at : tight.high[k];
                }
                tight.count += count[bin];
            }
        }
    }
    *b = tight;
}

/* Across the longest side, half of what is in it on each; false: it is one colour. */
static bool cut(box *b, box *other, const unsigned *count)
{
    int longest = 0, at;
    unsigned long sums[32] = {0}, sum = 0;
    for (int k = 1; k < 3; k++) {
        longest = b->high[k] - b->low[k] > b->high[longest] - b->low[longest] ? k : longest;
    }
    if (b->high[longest] == b->low[longest]) {
        return false;
    }
    for (int bin = 0; bin < BINS; bin++) {
        sums[channel(bin, longest)] += holds(b, bin) ? count[bin] : 0;
    }
    for (at = b->low[longest]; at + 1 < b->high[longest] && 2 * (sum + sums[at]) < b->count; at++) {
        sum += sums[at];
    }
    *other = *b;
    b->high[longest] = at;
    other->low[longest] = at + 1;
    shrink(b, count);
    shrink(other, count);
    return true;
}

static void make_table(image_gif *x)
{
    box boxes[COLOURS] = {{{0, 0, 0}, {31, 31, 31}, 0}};
    int used = 1;
    shrink(&boxes[0], x->count);
    for (int tries = 0; used < COLOURS && tries < 2 * COLOURS; tries++) {
        int best = 0;
        double most = -1;
        for (int i = 0; i < used; i++) { /* many, or far apart */
            double size = 0;
            for (int k = 0; k < 3; k++) {
                size += boxes[i].high[k] - boxes[i].low[k];
            }
            if (size * (1000.0 + (double)boxes[i].count) > most && size > 0) {
                most = size * (1000.0 + (double)boxes[i].count);
                best = i;
            }
        }
        if (most < 0 || !cut(&boxes[best], &boxes[used], x->count)) {
            break;
        }
        used++;
    }
    for (int i = 0; i < used; i++) {
        double sum[3] = {0, 0, 0}, count = 1e-9;
        for (int bin = 0; bin < BINS; bin++) {
            for (int k = 0; k < 3 && x->count[bin] > 0 && holds(&boxes[i], bin); k++) {
                sum[k] += (double)x->count[bin] * channel(bin, k) * 255 / 31;
                count += k == 0 ? (double)x->count[bin] : 0;
            }
        }
        for (int k = 0; k < 3; k++) {
            x->table[i][k] = (unsigned char)(sum[k] / count + 0.5);
        }
    }
    for (int bin = 0; bin < BINS; bin++) {
        long least = -1;
        for (int i = 0; i < used; i++) {
            long off = 0;
            for (int k = 0; k < 3; k++) {
                const long d = channel(bin, k) * 255 / 31 - x->table[i][k];
                off += d * d;
            }
            if (least < 0 || off < least) {
                least = off;
                x->nearest[bin] = (unsigned char)i;
            }
        }
    }
}

void image_gif_sample(image_gif *x, const unsigned char *rgb)
{
    for (size_t i = 0; i < (size_t)x->width * (size_t)x->height; i++) {
        x->count[bin_of(rgb + 3 * i)]++;
    }
}

/* ---- codes --------------------------------------------------------------------------------- */

typedef struct bits {
    FILE *file;
    uint32_t waiting;
    int count, block_size;
    unsigned char block[255];
} bits;

static void end_block(bits *b)
{
    fputc(b->block_size, b->file);
    fwrite(b->block, 1, (size_t)b->block_size, b->file);
    b->block_size = 0;
}

static void put_code(bits *b, unsigned code, int width)
{
    b->waiting |= (uint32_t)code << b->count;
    for (b->count += width; b->count >= 8; b->count -= 8, b->waiting >>= 8) {
        b->block[b->block_size++] = (unsigned char)b->waiting;
        if (b->block_size == 255) {
            end_block(b);
        }
    }
}

static void put_codes(image_gif *x, const unsigned char *pixels, size_t count)
{
    enum { CLEAR = 256, END = 257 };
    bits b = {.file = x->file};
    unsigned free_code = END + 1, string = pixels[0];
    int width = 9;
    memset(x->next, 0, sizeof x->next);
    fputc(8, x->file);
    put_code(&b, CLEAR, width);
    for (size_t i = 1; i < count; i++) {
        const unsigned char pixel = pixels[i];
        if (x->next[string][pixel]) {
            string = x->next[string][pixel];
            continue;
        }
        put_code(&b, string, width);
        if (free_code < CODES) {
            width += free_code == (1U << width);
            x->next[string][pixel] = (uint16_t)free_code++;
        } else {
            put_code(&b, CLEAR, width);
            memset(x->next, 0, sizeof x->next);
            free_code = END + 1;
            width = 9;
        }
        string = pixel;
    }
    put_code(&b, string, width);
    width += free_code < CODES && free_code == (1U << width);
    put_code(&b, END, width);
    put_code(&b, 0, 7);
    if (b.block_size > 0) {
        end_block(&b);
    }
    fputc(0, x->file);
}

/* ---- images -------------------------------------------------------------------------------- */

image_gif *image_gif_create(int width, int height)
{
    image_gif *x = calloc(1, sizeof *x);
    const size_t size = (size_t)width * (size_t)height;
    if (x) {
        x->width = width;
        x->height = height;
        x->last = calloc(3 * size, 1);
        x->now = x->last ? x->last + size : NULL;
        x->kept = x->last ? x->now + size : NULL;
        x->file = open_memstream(&x->bytes, &x->size);
        if (!x->last || !x->file) {
            image_gif_free(x);
            return NULL;
        }
    }
    return x;
}

void image_gif_free(image_gif *x)
{
    if (x) {
        if (x->file) {
            fclose(x->file);
        }
        free(x->bytes);
        free(x->last);
        free(x);
    }
}

static void put_short(FILE *file, int value)
{
    fputc(value & 255, file);
    fputc(value >> 8 & 255, file);
}

static void put_head(image_gif *x)
{
    make_table(x);
    fwrite("GIF89a", 1, 6, x->file);
    put_short(x->file, x->width);
    put_short(x->file, x->height);
    fwrite("\xF7\0\0", 1, 3, x->file); /* a table of 256 colours of 8 bits */
    fwrite(x->table, 1, sizeof x->table, x->file);
    fwrite("!\xFF\x0BNETSCAPE2.0\3\1\0\0\0", 1, 19, x->file); /* for ever */
}

/* The rectangle in which two images differ: left, top, and what follows the last; false: nowhere.
 */
static bool changed(const image_gif *x, int from[2], int to[2])
{
    from[0] = x->width;
    from[1] = x->height;
    to[0] = to[1] = 0;
    for (int i = 0; i < x->width * x->height; i++) {
        const int at[2] = {i % x->width, i / x->width};
        for (int k = 0; k < 2 && (x->images == 0 || x->now[i] != x->last[i]); k++) {
            from[k] = at[k] < from[k] ? at[k] : from[k];
            to[k] = at[k] >= to[k] ? at[k] + 1 : to[k];
        }
    }
    return to[0] > 0;
}

ad_status image_gif_add(image_gif *x, const unsigned char *rgb, int hundredths, ad_error *error)
{
    int from[2], to[2];
    size_t count = 0;
    if (x->images == 0) {
        put_head(x);
    }
    for (size_t i = 0; i < (size_t)x->width * (size_t)x->height; i++) {
        x->now[i] = x->nearest[bin_of(rgb + 3 * i)];
    }
    if (!changed(x, from, to)) {
        from[0] = from[1] = 0;
        to[0] = to[1] = 1;
    }
    for (int row = from[1]; row < to[1]; row++) {
        for (int column = from[0]; column < to[0]; column++) {
            const size_t i = (size_t)row * (size_t)x->width + (size_t)column;
            x->kept[count++] = x->images > 0 && x->now[i] == x->last[i] ? COLOURS : x->now[i];
        }
    }
    fwrite("!\xF9\4\5", 1, 4, x->file); /* what was there stays, one colour is clear */
    put_short(x->file, hundredths);
    fputc(COLOURS, x->file);
    fputc(0, x->file);
    fputc(',', x->file);
    put_short(x->file, from[0]);
    put_short(x->file, from[1]);
    put_short(x->file, to[0] - from[0]);
    put_short(x->file, to[1] - from[1]);
    fputc(0, x->file);
    put_codes(x, x->kept, count);
    memcpy(x->last, x->now, (size_t)x->width * (size_t)x->height);
    x->images++;
    return ferror(x->file) ? ad_fail(error, AD_NO_MEMORY, "out of memory for a picture") : AD_OK;
}

ad_status image_gif_end(image_gif *x, const unsigned char **bytes, size_t *size, ad_error *error)
{
    fputc(';', x->file);
    if (fflush(x->file) != 0 || !x->bytes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    *bytes = (const unsigned char *)x->bytes;
    *size = x->size;
    return AD_OK;
}
