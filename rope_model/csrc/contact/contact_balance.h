/* Sums that contact gives: energy, powers, load and forces by kind of body. */
#ifndef CONTACT_BALANCE_H
#define CONTACT_BALANCE_H

#include "state_structures.h"

/* Entries of physics.contact_element.CONTACT_BALANCE, and the pressure of the rope on itself. */
enum { CONTACT_ENERGY, CONTACT_DISSIPATED, CONTACT_MOVED, CONTACT_LOAD, CONTACT_FORCES = CONTACT_LOAD + 6 };
enum { CONTACT_ROPE = CONTACT_FORCES + KINDS, CONTACT_BALANCE };

#endif
