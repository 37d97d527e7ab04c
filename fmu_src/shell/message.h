/* Messages of an FMU. */
#ifndef MESSAGE_H
#define MESSAGE_H

#include <stdarg.h>

enum { MESSAGE_BYTES = 640 }; /* bytes for a message, with its terminating zero */

/* Write a message as snprintf does, with a decimal point in every locale, and cut between characters of UTF-8.
   Conversions: %s, %d, and %g with a precision of digits. */
void write_message(char message[MESSAGE_BYTES], const char *format, ...);
void write_message_of(char message[MESSAGE_BYTES], const char *format, va_list arguments);

#endif
