/* Chains in the form that every processor runs. */

#define FORM(name) name##_plain
#include "chains_of_form.inc"
