/* Chains with eight elements at a time, for processors with AVX-512, whose fused multiplications are switched off. */

#include "processor.h"

#if HAS_WIDE_FORMS
#if defined(__clang__)
#pragma clang fp contract(off)
#if __clang_major__ >= 18 && __clang_major__ <= 20
/* these take registers of 512 bits for a feature of its own, without which they refuse such an argument */
#pragma clang attribute push(__attribute__((target("avx512f,avx512vl,evex512"))), apply_to = function)
#else
#pragma clang attribute push(__attribute__((target("avx512f,avx512vl"))), apply_to = function)
#endif
#else
#pragma GCC target("avx512f,avx512vl")
#pragma GCC optimize("fp-contract=off")
#endif
#define LANES 8
#define FORM(name) name##_widest
#include "chains_of_form.inc"
#if defined(__clang__)
#pragma clang attribute pop
#endif
#else
typedef int nothing_to_do_here;
#endif
