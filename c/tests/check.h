// CHECK ends a test with the place and text of a condition that is false, and the library's last error.
#include <stdio.h>
#include <stdlib.h>

#define CHECK(what) \
    do { \
        if (!(what)) { \
            fprintf(stderr, "%s:%d: %s is false: %s\n", __FILE__, __LINE__, #what, nm_last_error()); \
            exit(1); \
        } \
    } while (0)
