/* V: one number each of LANES elements, so that one evaluation of the element's code serves LANES of them.  P2: one
   number each of the two ends of the rope, from which the elimination goes inwards.  Compilers without vectors take
   one at a time; results agree to rounding. */
#ifndef LANES_H
#define LANES_H

#include <math.h>

/* before a short loop: what it works on stays in registers */
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
#define LANE(x, i) ((x)[i])
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
/* all lanes of x but the first, and y */
#if defined(__clang__)
#define NEXT(x, y) __builtin_shufflevector(x, (V){y}, MOVED)
#else
typedef long long Place __attribute__((vector_size(8 * LANES)));
#define NEXT(x, y) __builtin_shuffle(x, (V){y}, (Place){MOVED})
#endif
#define SPLAT2(x) ((P2){(x), (x)})
#define SIDE(x, i) ((x)[i])
static inline V SQRT_V(V x) {
    int i;
    for (i = 0; i < LANES; ++i) x[i] = sqrt(x[i]);
    return x;
}
static inline V FABS_V(V x) {
    int i;
    for (i = 0; i < LANES; ++i) x[i] = fabs(x[i]);
    return x;
}
#else
#undef LANES
#define LANES 1
#define PAIR 1
typedef double V;
typedef double P2;
#define SPLAT(x) (x)
#define LANE(x, i) (x)
#define EACH(p, s) (*(p))
#define NEXT(x, y) (y)
#define SPLAT2(x) (x)
#define SIDE(x, i) (x)
#define SQRT_V(x) sqrt(x)
#define FABS_V(x) fabs(x)
#endif

#endif
