/* Vectors of this processor, by the instruction cpuid: __builtin_cpu_supports always returns 0 in zig 0.17, and
   __get_cpuid_count is missing before GCC 7. */

#include "processor.h"

#if HAS_WIDE_FORMS
#include <cpuid.h>
#include <stdbool.h>

/* Registers that the operating system must save: those of SSE and AVX, and with the masks of AVX-512. */
enum { WIDE_REGISTERS = 0x6, WIDEST_REGISTERS = 0xe6 };
enum { AVX2 = 1 << 5, AVX512F = 1 << 16, VL_BIT = 31, AVX512VBMI = 1 << 1 };

int processor_lanes(void) {
    unsigned eax;
    unsigned ebx;
    unsigned ecx;
    unsigned edx;
    unsigned saved; /* registers that the operating system saves */
    if (__get_cpuid_max(0, 0) < 7) return 2;
    __cpuid(1, eax, ebx, ecx, edx);
    if (!(ecx & bit_OSXSAVE)) return 2;
    __asm__("xgetbv" : "=a"(saved), "=d"(edx) : "c"(0));
    __cpuid_count(7, 0, eax, ebx, ecx, edx);
    if ((saved & WIDE_REGISTERS) != WIDE_REGISTERS || !(ebx & AVX2)) return 2;
    const bool saves_widest = (saved & WIDEST_REGISTERS) == WIDEST_REGISTERS;
    const bool computes_widest = ebx & AVX512F && ebx >> VL_BIT;
    const bool keeps_clock = ecx & AVX512VBMI; /* processors without it lower their clock for eight lanes */
    return saves_widest && computes_widest && keeps_clock ? 8 : 4;
}
#else
int processor_lanes(void) {
    return 2;
}
#endif
