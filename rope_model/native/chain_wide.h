/* Where a processor may have wider vectors than every one of its family. */
#ifndef CHAIN_WIDE_H
#define CHAIN_WIDE_H

#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#define HAS_WIDE_FORM 1
#else
#define HAS_WIDE_FORM 0
#endif

#endif
