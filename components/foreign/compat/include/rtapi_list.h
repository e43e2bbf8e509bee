/* Rings of things that carry their own links. */
#ifndef RTAPI_LIST_H
#define RTAPI_LIST_H
#include <stddef.h>

struct rtapi_list_head {
    struct rtapi_list_head *next, *prev;
};

#define RTAPI_LIST_HEAD_INIT(name) { &(name), &(name) }
#define RTAPI_LIST_HEAD(name) struct rtapi_list_head name = RTAPI_LIST_HEAD_INIT(name)

static inline void RTAPI_INIT_LIST_HEAD(struct rtapi_list_head *ring)
{
    ring->next = ring;
    ring->prev = ring;
}

static inline void rtapi_list_join(struct rtapi_list_head *before, struct rtapi_list_head *after)
{
    before->next = after;
    after->prev = before;
}

static inline void rtapi_list_add(struct rtapi_list_head *one, struct rtapi_list_head *ring)
{
    rtapi_list_join(one, ring->next);
    rtapi_list_join(ring, one);
}

static inline void rtapi_list_add_tail(struct rtapi_list_head *one, struct rtapi_list_head *ring)
{
    rtapi_list_join(ring->prev, one);
    rtapi_list_join(one, ring);
}

static inline void rtapi_list_del(struct rtapi_list_head *one)
{
    rtapi_list_join(one->prev, one->next);
    RTAPI_INIT_LIST_HEAD(one);
}

static inline int rtapi_list_empty(const struct rtapi_list_head *ring)
{
    return ring->next == ring;
}

#define rtapi_list_entry(place, type, member) \
    ((type *)(void *)((char *)(place) - offsetof(type, member)))
#define rtapi_list_for_each(place, ring) \
    for ((place) = (ring)->next; (place) != (ring); (place) = (place)->next)
#define rtapi_list_for_each_safe(place, after, ring)                                    \
    for ((place) = (ring)->next, (after) = (place)->next; (place) != (ring);            \
         (place) = (after), (after) = (place)->next)
#endif
