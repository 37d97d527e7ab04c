"""Methods: time integration, Newton's method, chains of elements, kernels."""
