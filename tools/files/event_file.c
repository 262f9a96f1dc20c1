#include "tools/files/event_file.h"

#include <math.h>
#include <string.h>

enum { RECORD_MAX = 4096, HEAD = 12, TAIL = 4 };

typedef struct message {
    unsigned char bytes[RECORD_MAX];
    size_t size;
} message;

/* ---- protocol buffers ---------------------------------------------------------------------- */

/* "Protocol Buffers: Encoding": the key of a field is number << 3 | type. */
enum { VARINT = 0, FIXED64 = 1, BYTES = 2, FIXED32 = 5 };

static void put_varint(message *m, uint64_t value)
{
    for (; value >= 0x80; value >>= 7) {
        m->bytes[m->size++] = (unsigned char)(value | 0x80);
    }
    m->bytes[m->size++] = (unsigned char)value;
}

static void put_key(message *m, unsigned number, unsigned type)
{
    put_varint(m, number << 3 | type);
}

static void put_little(unsigned char *to, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        to[i] = (unsigned char)(value >> 8 * i);
    }
}

static void put_bytes(message *m, unsigned number, const void *bytes, size_t size)
{
    put_key(m, number, BYTES);
    put_varint(m, size);
    memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
}

static void put_double(message *m, unsigned number, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_key(m, number, FIXED64);
    put_little(m->bytes + m->size, bits, sizeof bits);
    m->size += sizeof bits;
}

static void put_float(message *m, unsigned number, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_key(m, number, FIXED32);
    put_little(m->bytes + m->size, bits, sizeof bits);
    m->size += sizeof bits;
}

/* ---- records ------------------------------------------------------------------------------- */

uint32_t events_crc(const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    uint32_t crc = 0xffffffff;
    for (size_t i = 0; i < size; i++) {
        crc ^= at[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (crc & 1 ? 0x82f63b78 : 0);
        }
    }
    return ~crc;
}

static uint32_t masked(const void *bytes, size_t size)
{
    const uint32_t crc = events_crc(bytes, size);
    return (crc >> 15 | crc << 17) + 0xa282ead8;
}

static void write_record(FILE *file, const message *m)
{
    unsigned char head[HEAD], tail[TAIL];
    put_little(head, m->size, 8);
    put_little(head + 8, masked(head, 8), 4);
    put_little(tail, masked(m->bytes, m->size), TAIL);
    fwrite(head, 1, HEAD, file);
    fwrite(m->bytes, 1, m->size, file);
    fwrite(tail, 1, TAIL, file);
}

void events_begin(FILE *file, double wall, int64_t step)
{
    static const char version[] = "brain.Event:2";
    static const unsigned char started[] = {1 << 3 | VARINT, 1};
    message m = {.size = 0};
    put_double(&m, 1, wall);
    put_bytes(&m, 3, version, sizeof version - 1);
    write_record(file, &m);
    m.size = 0;
    put_double(&m, 1, wall);
    put_key(&m, 2, VARINT);
    put_varint(&m, (uint64_t)step);
    put_bytes(&m, 7, started, sizeof started);
    write_record(file, &m);
}

void events_scalars(FILE *file, double wall, int64_t step, int count, const char *const *names,
                    const double *values)
{
    enum { VALUE = 16, EVENT = 32 }; /* bytes around a name, and around all of them, at most */
    message all = {.size = 0}, m = {.size = 0};
    for (int i = 0; i < count; i++) {
        const size_t length = strlen(names[i]);
        message one = {.size = 0};
        if (isnan(values[i]) || length + VALUE + EVENT > sizeof all.bytes - all.size) {
            continue;
        }
        put_bytes(&one, 1, names[i], length);
        put_float(&one, 2, (float)values[i]);
        put_bytes(&all, 1, one.bytes, one.size);
    }
    put_double(&m, 1, wall);
    put_key(&m, 2, VARINT);
    put_varint(&m, (uint64_t)step);
    put_bytes(&m, 5, all.bytes, all.size);
    write_record(file, &m);
}

static uint64_t get_little(const unsigned char *from, size_t size)
{
    uint64_t value = 0;
    for (size_t i = 0; i < size; i++) {
        value |= (uint64_t)from[i] << 8 * i;
    }
    return value;
}

size_t events_records(const unsigned char *bytes, size_t size, size_t limit, size_t *end)
{
    size_t count = 0;
    *end = 0;
    while (count < limit && size - *end >= HEAD + TAIL) {
        const unsigned char *head = bytes + *end, *data = head + HEAD;
        const uint64_t length = get_little(head, 8);
        if (get_little(head + 8, 4) != masked(head, 8) || length > size - *end - HEAD - TAIL ||
            get_little(data + length, TAIL) != masked(data, (size_t)length)) {
            break;
        }
        *end += HEAD + (size_t)length + TAIL;
        count++;
    }
    return count;
}
