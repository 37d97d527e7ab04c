/* Where a processor may have wider vectors than every one of its family; -DHAS_WIDE_FORM=0 does without (valgrind
   does not know all instructions of the wide form). */
#ifndef PROCESSOR_H
#define PROCESSOR_H

#ifndef HAS_WIDE_FORM
#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#define HAS_WIDE_FORM 1
#else
#define HAS_WIDE_FORM 0
#endif
#endif

/* processor.c */
int processor_has_avx2(void);

#endif
