/* What the library's functions answer, beside what the test wants. */
#ifndef ANSWERS_H
#define ANSWERS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "moulage.h"

static MlgError error;

static inline void expect(MlgStatus got, MlgStatus wanted, const char *words) {
    if (got != wanted || error.status != wanted || strstr(error.message, words) == NULL) {
        fprintf(stderr, "got %s (%s), wanted %s with '%s'\n", mlg_status_name((uint32_t)got),
                error.message, mlg_status_name((uint32_t)wanted), words);
        exit(1);
    }
}

static inline void check(MlgStatus status) {
    if (status == MLG_STATUS_OK) return;
    fprintf(stderr, "%s: %s\n", mlg_status_name((uint32_t)status), error.message);
    exit(1);
}

#endif
