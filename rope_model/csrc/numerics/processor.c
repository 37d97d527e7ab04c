/* What this processor can do, asked of itself: of some compilers __builtin_cpu_supports always says no (zig 0.17), and
   __get_cpuid_count is not in those before GCC 7. */

#include "processor.h"

#if HAS_WIDE_FORM
#include <cpuid.h>

enum { WIDE_REGISTERS = 6 }; /* those of SSE and AVX, which the system must keep for each thread */

int processor_has_avx2(void) {
    unsigned a, b, c, d, kept, unused;
    if (__get_cpuid_max(0, 0) < 7) return 0;
    __cpuid(1, a, b, c, d);
    if (!(c & bit_OSXSAVE)) return 0;
    __asm__("xgetbv" : "=a"(kept), "=d"(unused) : "c"(0));
    if ((kept & WIDE_REGISTERS) != WIDE_REGISTERS) return 0;
    __cpuid_count(7, 0, a, b, c, d);
    return (b & bit_AVX2) != 0;
}
#else
typedef int nothing_to_do_here;
#endif
