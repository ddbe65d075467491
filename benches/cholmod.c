/* The factor of a symmetric matrix and 200 right-hand sides by CHOLMOD: two times in seconds, the fastest of five.
 *   cholmod MATRIX.mtx     (Debian: libsuitesparse-dev; benches/solvers.py builds and runs it) */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <suitesparse/cholmod.h>

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int count, char **arguments) {
    cholmod_common common;
    FILE *file = count == 2 ? fopen(arguments[1], "r") : NULL;
    double factoring = 1e9, solving = 1e9;
    if (file == NULL) return 1;
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    cholmod_sparse *matrix = cholmod_read_sparse(file, &common);
    cholmod_factor *factor = cholmod_analyze(matrix, &common);
    cholmod_dense *sides = cholmod_zeros(matrix->nrow, 200, CHOLMOD_REAL, &common);
    for (size_t i = 0; i < sides->nzmax; i++) ((double *)sides->x)[i] = (double)(i * 37 % 101) - 50;
    for (int round = 0; round < 5; round++) {
        const double start = now();
        if (!cholmod_factorize(matrix, factor, &common)) return 1;
        const double middle = now();
        cholmod_dense *solution = cholmod_solve(CHOLMOD_A, factor, sides, &common);
        const double end = now();
        if (middle - start < factoring) factoring = middle - start;
        if (end - middle < solving) solving = end - middle;
        cholmod_free_dense(&solution, &common);
    }
    printf("%g %g\n", factoring, solving);
    cholmod_free_dense(&sides, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
    return 0;
}
