/* HAS_WIDE_FORMS: compile forms for wider vectors than all processors have.  Set it to 0 for valgrind, which lacks some
   of their instructions.  GCC has AVX-512 from version 5 on, and misaligns wide vectors on Windows (GCC bug 54412). */
#ifndef PROCESSOR_H
#define PROCESSOR_H

#ifndef HAS_WIDE_FORMS
#if defined(__x86_64__) && (defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 5 && !defined(_WIN32)))
#define HAS_WIDE_FORMS 1
#else
#define HAS_WIDE_FORMS 0
#endif
#endif

/* Return the number of lanes of the fastest vectors: 2, 4 or 8. */
int processor_lanes(void);

#endif
