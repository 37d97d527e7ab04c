/* Numbers in messages, as Python prints them, in any locale. */
#ifndef TEXT_H
#define TEXT_H

enum { NUMBER = 40 };

/* Print f"{x:.{digits}g}" into the buffer, as Python does; return the buffer. */
const char *text_number(char buffer[NUMBER], double x, int digits);
/* The same for f"{x!r}". */
const char *text_exact(char buffer[NUMBER], double x);

/* texts that last to the end of the block */
#define ROUNDED(x, digits) text_number((char[NUMBER]){0}, x, digits)
#define EXACT(x) text_exact((char[NUMBER]){0}, x)

#endif
