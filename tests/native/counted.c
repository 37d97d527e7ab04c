/* The blocks of memory that a program and its libraries take and give back, to be preloaded. */
#include <stddef.h>

void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
void __libc_free(void *);
size_t asked_of_libc;

#define COUNTED(call) (asked_of_libc++, call)

void *malloc(size_t size) {
    return COUNTED(__libc_malloc(size));
}

void *calloc(size_t number, size_t size) {
    return COUNTED(__libc_calloc(number, size));
}

void *realloc(void *block, size_t size) {
    return COUNTED(__libc_realloc(block, size));
}

void free(void *block) {
    COUNTED(__libc_free(block));
}
