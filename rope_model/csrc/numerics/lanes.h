/* Vectors.  V has one number of each of LANES elements, so that the element's code runs for all of them at once.  P2
   has one number for each end of the rope; the elimination runs inwards from both.  Compilers without vectors use
   scalars; results agree to rounding. */
#ifndef LANES_H
#define LANES_H

#include <math.h>

/* Unroll the short loop that follows, so that its arrays stay in registers. */
#if defined(__clang__)
#define UNROLL _Pragma("clang loop unroll(full)")
#elif defined(__GNUC__) && __GNUC__ >= 8
#define UNROLL _Pragma("GCC unroll 8")
#else
#define UNROLL
#endif

#if defined(__GNUC__) || defined(__clang__)
#ifndef LANES
#define LANES 2
#endif
#define PAIR 2
typedef double V __attribute__((vector_size(8 * LANES)));
typedef double P2 __attribute__((vector_size(16)));
#define SPLAT(x) ((V){0} + (x))
#define TWO(p, s, i) (p)[(i) * (s)], (p)[((i) + 1) * (s)]
#if LANES == 8
#define EACH(p, s) ((V){TWO(p, s, 0), TWO(p, s, 2), TWO(p, s, 4), TWO(p, s, 6)})
#define MOVED 1, 2, 3, 4, 5, 6, 7, 8
#elif LANES == 4
#define EACH(p, s) ((V){TWO(p, s, 0), TWO(p, s, 2)})
#define MOVED 1, 2, 3, 4
#else
#define EACH(p, s) ((V){TWO(p, s, 0)})
#define MOVED 1, 2
#endif
/* NEXT: all lanes of x except the first, followed by y */
#if defined(__clang__)
#define NEXT(x, y) __builtin_shufflevector(x, (V){y}, MOVED)
#else
typedef long long Place __attribute__((vector_size(8 * LANES)));
#define NEXT(x, y) __builtin_shuffle(x, (V){y}, (Place){MOVED})
#endif
#define SPLAT2(x) ((P2){(x), (x)})
#define PAIR_OF(x, y) ((P2){(x), (y)})
#define SIDE(x, i) ((x)[i])
static inline V SQRT_V(V x) {
    for (int i = 0; i < LANES; ++i) x[i] = sqrt(x[i]);
    return x;
}
static inline V FABS_V(V x) {
    for (int i = 0; i < LANES; ++i) x[i] = fabs(x[i]);
    return x;
}
#else
#undef LANES
#define LANES 1
#define PAIR 1
typedef double V;
typedef double P2;
#define SPLAT(x) (x)
#define EACH(p, s) (*(p))
#define NEXT(x, y) (y)
#define SPLAT2(x) (x)
#define PAIR_OF(x, y) (x)
#define SIDE(x, i) (x)
#define SQRT_V(x) sqrt(x)
#define FABS_V(x) fabs(x)
#endif

#endif
