/* RESTRICT: arrays that a pointer reaches are reached by no other. */
#ifndef RESTRICT_H
#define RESTRICT_H

#if defined(_MSC_VER)
#define RESTRICT __restrict
#else
#define RESTRICT restrict
#endif

#endif
