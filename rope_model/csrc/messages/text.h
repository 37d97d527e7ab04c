/* Texts and numbers in messages; numbers as Python prints them, in any locale. */
#ifndef TEXT_H
#define TEXT_H

#include <stddef.h>

enum { NUMBER = 40 };

/* Print f"{x:.{digits}g}" into the buffer, as Python does; return the buffer. */
const char *text_number(char buffer[NUMBER], double x, int digits);
/* The same for f"{x!r}". */
const char *text_exact(char buffer[NUMBER], double x);
const char *text_short(char buffer[NUMBER], double x); /* as text_exact, and whole numbers without ".0" */

/* Copy a text of UTF-8 as far as there is room, and no part of a character. */
void copy_text(char *to, size_t room, const char *from);

/* texts that last to the end of the block */
#define ROUNDED(x, digits) text_number((char[NUMBER]){0}, x, digits)
#define EXACT(x) text_exact((char[NUMBER]){0}, x)
#define SHORT(x) text_short((char[NUMBER]){0}, x)

#endif
