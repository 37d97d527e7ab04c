/* Chains with four elements at a time, for AVX2.  Without fused multiplication they equal the plain form to the bit. */

#include "processor.h"

#if HAS_WIDE_FORMS
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#endif
#define LANES 4
#define FORM(name) name##_wide
#include "chains_of_form.inc"
#if defined(__clang__)
#pragma clang attribute pop
#endif
#else
typedef int nothing_to_do_here;
#endif
