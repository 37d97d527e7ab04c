/* Where a processor may have wider vectors than every one of its family; -DHAS_WIDE_FORMS=0 does without (valgrind
   does not know all instructions of the wide forms). */
#ifndef PROCESSOR_H
#define PROCESSOR_H

#ifndef HAS_WIDE_FORMS
#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#define HAS_WIDE_FORMS 1
#else
#define HAS_WIDE_FORMS 0
#endif
#endif

/* processor.c: numbers in the widest vector that is worth its while, 2, 4 or 8 */
int processor_lanes(void);

#endif
