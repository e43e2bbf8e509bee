/* Single bits of an array of longs, changed without being interrupted. */
#ifndef RTAPI_BITOPS_H
#define RTAPI_BITOPS_H
#define RTAPI_BITS_PER_LONG ((int)(8 * sizeof(unsigned long)))
#define RTAPI_BIT(nr) (1UL << (nr))
#define RTAPI_BIT_SET(word, nr) ((word) |= RTAPI_BIT(nr))
#define RTAPI_BIT_CLEAR(word, nr) ((word) &= ~RTAPI_BIT(nr))
#define RTAPI_BIT_TEST(word, nr) (!!((word) & RTAPI_BIT(nr)))

static inline unsigned long rtapi_bit_mask(int nr)
{
    return 1UL << (nr % RTAPI_BITS_PER_LONG);
}

static inline void rtapi_set_bit(int nr, volatile unsigned long *words)
{
    __atomic_fetch_or(words + nr / RTAPI_BITS_PER_LONG, rtapi_bit_mask(nr), __ATOMIC_SEQ_CST);
}

static inline void rtapi_clear_bit(int nr, volatile unsigned long *words)
{
    __atomic_fetch_and(words + nr / RTAPI_BITS_PER_LONG, ~rtapi_bit_mask(nr), __ATOMIC_SEQ_CST);
}

static inline int rtapi_test_bit(int nr, const volatile unsigned long *words)
{
    unsigned long word = __atomic_load_n(words + nr / RTAPI_BITS_PER_LONG, __ATOMIC_SEQ_CST);
    return (word & rtapi_bit_mask(nr)) != 0;
}

static inline int rtapi_test_and_set_bit(int nr, volatile unsigned long *words)
{
    unsigned long mask = rtapi_bit_mask(nr);
    unsigned long was = __atomic_fetch_or(words + nr / RTAPI_BITS_PER_LONG, mask, __ATOMIC_SEQ_CST);
    return (was & mask) != 0;
}

static inline int rtapi_test_and_clear_bit(int nr, volatile unsigned long *words)
{
    unsigned long mask = rtapi_bit_mask(nr);
    unsigned long was = __atomic_fetch_and(words + nr / RTAPI_BITS_PER_LONG, ~mask, __ATOMIC_SEQ_CST);
    return (was & mask) != 0;
}
#endif
