/* Where a processor may have wider vectors than every one of its family; -DHAS_WIDE_FORMS=0 does without (valgrind
   does not know all instructions of the wide forms).  GCC knows AVX-512 from version 5 on, and does not align wide
   vectors on the stack of Windows (its fault 54412). */
#ifndef PROCESSOR_H
#define PROCESSOR_H

#ifndef HAS_WIDE_FORMS
#if defined(__x86_64__) && (defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 5 && !defined(_WIN32)))
#define HAS_WIDE_FORMS 1
#else
#define HAS_WIDE_FORMS 0
#endif
#endif

/* processor.c: numbers in the widest vector that is worth its while, 2, 4 or 8 */
int processor_lanes(void);

#endif
