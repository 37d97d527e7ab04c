/* Vectors.  Vec has one number of each of LANES elements, so that the element's code runs for all of them at once. Vec2
   has one number for each end of the rope; the elimination runs inwards from both, in SWEEPS sweeps at once.  Compilers
   without vectors use scalars; results agree to rounding.  SPLAT: all lanes x; STRIDED: LANES numbers, `s` apart;
   SHIFT_IN: all lanes of x except the first, followed by y; LANE: one lane. */
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
#define SWEEPS 2
typedef double Vec __attribute__((vector_size(8 * LANES)));
typedef double Vec2 __attribute__((vector_size(16)));
#define SPLAT(x) ((Vec){0} + (x))
#define STRIDED2(p, s, i) (p)[(i) * (s)], (p)[((i) + 1) * (s)]
#if LANES == 8
#define STRIDED(p, s) ((Vec){STRIDED2(p, s, 0), STRIDED2(p, s, 2), STRIDED2(p, s, 4), STRIDED2(p, s, 6)})
#define SHIFTED 1, 2, 3, 4, 5, 6, 7, 8
#elif LANES == 4
#define STRIDED(p, s) ((Vec){STRIDED2(p, s, 0), STRIDED2(p, s, 2)})
#define SHIFTED 1, 2, 3, 4
#else
#define STRIDED(p, s) ((Vec){STRIDED2(p, s, 0)})
#define SHIFTED 1, 2
#endif
#if defined(__clang__)
#define SHIFT_IN(x, y) __builtin_shufflevector(x, (Vec){y}, SHIFTED)
#else
typedef long long Indices __attribute__((vector_size(8 * LANES)));
#define SHIFT_IN(x, y) __builtin_shuffle(x, (Vec){y}, (Indices){SHIFTED})
#endif
#define SPLAT2(x) ((Vec2){(x), (x)})
#define VEC2(x, y) ((Vec2){(x), (y)})
#define LANE(x, i) ((x)[i])
static inline Vec SQRT_Vec(Vec x) {
    for (int i = 0; i < LANES; ++i) x[i] = sqrt(x[i]);
    return x;
}
static inline Vec FABS_Vec(Vec x) {
    for (int i = 0; i < LANES; ++i) x[i] = fabs(x[i]);
    return x;
}
#else
#undef LANES
#define LANES 1
#define SWEEPS 1
typedef double Vec;
typedef double Vec2;
#define SPLAT(x) (x)
#define STRIDED(p, s) (*(p))
#define SHIFT_IN(x, y) (y)
#define SPLAT2(x) (x)
#define VEC2(x, y) ((void)(y), (x))
#define LANE(x, i) (x)
#define SQRT_Vec(x) sqrt(x)
#define FABS_Vec(x) fabs(x)
#endif

#endif
