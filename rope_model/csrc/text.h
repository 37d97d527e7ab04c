/* Numbers in messages, written as Python writes them whatever the host's locale. */
#ifndef TEXT_H
#define TEXT_H

enum { NUMBER = 40 };

/* f"{x:.{digits}g}" and f"{x!r}"; both return room */
const char *text_number(char room[NUMBER], double x, int digits);
const char *text_exact(char room[NUMBER], double x);

/* a text that lasts to the end of the block */
#define ROUNDED(x, digits) text_number((char[NUMBER]){0}, x, digits)
#define EXACT(x) text_exact((char[NUMBER]){0}, x)

#endif
