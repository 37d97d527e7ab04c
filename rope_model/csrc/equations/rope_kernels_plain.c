/* Chains in the form that every processor runs. */

#define FORM(name) name##_plain
#include "rope_kernels_form.inc"
