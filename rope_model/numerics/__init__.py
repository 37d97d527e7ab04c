"""Numerical methods: time integration, Newton's method, linear solvers, polynomials, compiled kernels."""
