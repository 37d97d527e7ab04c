/* C++'s delete, to be preloaded: blocks that are given back stay allocated and are filled with ones.

Who uses a block after giving it back finds a count of one and a table of methods at an address that does not exist, so
that the process ends by SIGSEGV in each run, and not by a spoilt free list in one of twenty. */

#include <malloc.h>
#include <stddef.h>

void _ZdlPv(void *block) {
    const size_t size = malloc_usable_size(block); /* 0 of NULL */
    int *word = block;
    for (size_t i = 0; i < size / sizeof *word; ++i) word[i] = 1;
}

void _ZdlPvm(void *block, size_t size) {
    (void)size;
    _ZdlPv(block);
}
