/* Atomic values, by the same names in C and in C++. */
#ifndef RTAPI_ATOMIC_H
#define RTAPI_ATOMIC_H
#ifdef __cplusplus
#include <atomic>
#define RTAPI_ATOMIC(type) std::atomic<type>
#define rtapi_atomic_load_explicit std::atomic_load_explicit
#define rtapi_atomic_store_explicit std::atomic_store_explicit
using std::atomic_bool;
using std::atomic_exchange;
using std::atomic_fetch_add;
using std::atomic_fetch_sub;
using std::atomic_int;
using std::atomic_load;
using std::atomic_load_explicit;
using std::atomic_store;
using std::atomic_store_explicit;
using std::atomic_uint;
using std::memory_order_acquire;
using std::memory_order_relaxed;
using std::memory_order_release;
using std::memory_order_seq_cst;
#else
#include <stdatomic.h>
#define RTAPI_ATOMIC(type) _Atomic(type)
#define rtapi_atomic_load_explicit atomic_load_explicit
#define rtapi_atomic_store_explicit atomic_store_explicit
#endif
#endif
