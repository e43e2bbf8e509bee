/* A plugin by the binary interface of release 0.1 (1.11), written down here as it was then: nothing of today's sources is
 * in it. It doubles a number. It names no release, as plugins of other authors do. */
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct { const char *ptr; size_t len; } Str;
typedef struct { const void *const *ptr; size_t len; } List;
typedef int32_t Status;
typedef struct { _Atomic int32_t target; uint32_t reserved; _Atomic uint64_t own; } Slot;
typedef struct { const Slot *slot; uint64_t token; uint32_t access; } Use;
typedef struct {
    uint32_t size, flags;
    Str name, doc, old_name;
    uint64_t initial;
    void *storage;
    uint8_t ty, dir;
} ItemSpec;
typedef struct {
    uint32_t size, flags;
    Str name, doc;
    Status (*run)(void *state, int64_t period_ns);
    void *state;
    void (*release)(void *state);
    const Use *uses;
    size_t n_uses;
} FunctSpec;
typedef struct {
    uint32_t size, abi_minor, flags, index;
    int64_t personality;
    Str prefix;
    void *ctx;
    const void *calls;
    void (*fail)(void *ctx, Str text);
    Status (*arg)(void *ctx, Str name, void *out);
    Status (*item)(void *ctx, const ItemSpec *spec, const Slot **out);
    Status (*funct)(void *ctx, const FunctSpec *spec);
} Host; /* what a plugin of 0.1 reads of it; the record is longer */
typedef struct {
    uint32_t size, flags;
    Str name, doc;
    List args, items;
    Status (*create)(const Host *host);
} ComponentType;
typedef struct { uint32_t size, abi_major, abi_minor, panic; List components, loaders; } Library;

typedef struct { const Slot *in, *out; } State;
#define STR(text) { text, sizeof text - 1 }

static _Atomic uint64_t *cell(const Slot *slot) {
    int32_t distance = atomic_load_explicit(&((Slot *)slot)->target, memory_order_acquire);
    return (_Atomic uint64_t *)((char *)slot + distance);
}

static Status run(void *state, int64_t period_ns) {
    State *s = state;
    union { uint64_t bits; double x; } value;
    (void)period_ns;
    value.bits = atomic_load_explicit(cell(s->in), memory_order_acquire);
    value.x *= 2;
    atomic_store_explicit(cell(s->out), value.bits, memory_order_release);
    return 0;
}

static Status create(const Host *host) {
    /* The names begin with that of the instance, which is made once: "release0". */
    ItemSpec in = { sizeof in, 0, STR("release0.in"), STR("A number."), { 0, 0 }, 0, NULL, 2, 16 };
    ItemSpec out = { sizeof out, 0, STR("release0.out"), STR("Twice the number."), { 0, 0 }, 0, NULL, 2, 32 };
    State *s = calloc(1, sizeof *s);
    if (s == NULL) return -12;
    Status status = host->item(host->ctx, &in, &s->in);
    if (status == 0) status = host->item(host->ctx, &out, &s->out);
    if (status != 0) { free(s); return status; }
    Use uses[2] = { { s->in, 0, 1 }, { s->out, 0, 2 } };
    FunctSpec funct = { sizeof funct, 0, STR("release0"), STR("Doubles."), run, s, free, uses, 2 };
    return host->funct(host->ctx, &funct);
}

static const ComponentType type = { sizeof type, 1, STR("release0"), STR("Doubles a number."), { 0, 0 }, { 0, 0 }, create };
static const void *const types[] = { &type };
__attribute__((visibility("default"))) const Library hal_library_release0 = { sizeof(Library), 1, 11, 1, { types, 1 }, { 0, 0 } };
__attribute__((visibility("default"))) const char hal_names_release0[] = "hal-names 1\0crelease0";
