#include "message.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "text.h"

enum { DIGITS = 6 }; /* of %g without a precision */

void write_message(char message[MESSAGE_BYTES], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    write_message_of(message, format, arguments);
    va_end(arguments);
}

void write_message_of(char message[MESSAGE_BYTES], const char *format, va_list arguments) {
    enum { WHOLE = 2 * MESSAGE_BYTES }; /* the arguments may point into the message */
    char whole[WHOLE];
    char *end = whole;
    char *const stop = whole + WHOLE - 1;
    while (*format && end < stop) {
        if (*format != '%') {
            *end++ = *format++;
            continue;
        }
        char number[NUMBER];
        const char *text = number;
        const size_t length = strcspn(format, "sdg");
        const char kind = format[length];
        const int digits = format[1] == '.' ? atoi(format + 2) : DIGITS;
        if (kind == 's') text = va_arg(arguments, const char *);
        if (kind == 'd') snprintf(number, sizeof number, "%d", va_arg(arguments, int));
        if (kind == 'g') text_number(number, va_arg(arguments, double), digits);
        copy_text(end, (size_t)(stop - end) + 1, text);
        end += strlen(end);
        format += length + 1;
    }
    *end = '\0';
    copy_text(message, MESSAGE_BYTES, whole);
}
