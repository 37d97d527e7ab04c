/* Vectors of this processor, by the instruction cpuid: __builtin_cpu_supports always returns 0 in zig 0.17, and
   __get_cpuid_count is missing before GCC 7. */

#include "processor.h"

#if HAS_WIDE_FORMS
#include <cpuid.h>

/* Registers that the operating system must save: those of SSE and AVX, and with the masks of AVX-512. */
enum { WIDE_REGISTERS = 0x6, WIDEST_REGISTERS = 0xe6 };
enum { AVX2 = 1 << 5, AVX512F = 1 << 16, VL_BIT = 31, AVX512VBMI = 1 << 1 };

int processor_lanes(void) {
    unsigned a, b, c, d, kept, unused;
    if (__get_cpuid_max(0, 0) < 7) return 2;
    __cpuid(1, a, b, c, d);
    if (!(c & bit_OSXSAVE)) return 2;
    __asm__("xgetbv" : "=a"(kept), "=d"(unused) : "c"(0));
    __cpuid_count(7, 0, a, b, c, d);
    if ((kept & WIDE_REGISTERS) != WIDE_REGISTERS || !(b & AVX2)) return 2;
    /* Processors without VBMI lower their clock for eight lanes. */
    return (kept & WIDEST_REGISTERS) == WIDEST_REGISTERS && (b & AVX512F) && b >> VL_BIT && (c & AVX512VBMI) ? 8 : 4;
}
#else
int processor_lanes(void) {
    return 2;
}
#endif
