/* Puts a template into the shape that markers tell, with a progress line; Ctrl-C keeps the best
 * shape so far.
 *
 *   reshape_c TEMPLATE.obj MARKERS.csv OUT.obj [TOLERANCE]
 */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "moulage.h"

static volatile sig_atomic_t interrupted = 0;

static void on_interrupt(int signal_number) {
    (void)signal_number;
    interrupted = 1;
}

static void require(MlgStatus status, const MlgError *error) {
    if (status != MLG_STATUS_OK) {
        fprintf(stderr, "%s\n", error->message);
        exit(1);
    }
}

static void show_until_ended(const MlgRun *run) {
    const struct timespec pause = {0, 100000000};
    MlgProgress progress;
    progress.struct_size = sizeof progress;
    for (;;) {
        MlgError error;
        require(mlg_run_poll(run, &progress, &error), &error);
        fprintf(stderr, "\r%3.0f %% %-30s mean %.3f max %.3f ", 100 * progress.fraction,
                progress.stage, progress.mean_error, progress.max_error);
        if (progress.state == MLG_RUN_ENDED) break;
        if (interrupted) mlg_run_cancel(run);
        nanosleep(&pause, NULL);
    }
    fputc('\n', stderr);
}

int main(int argc, char **argv) {
    MlgError error;
    MlgTriMesh *surface = NULL;
    MlgMarkers *markers = NULL;
    MlgTetrahedralization *tets = NULL;
    MlgReshaping *problem = NULL;
    MlgRun *run = NULL;
    MlgReshapingResult *result = NULL;
    MlgReshapingOptions options;
    MlgReshapingSummary summary;
    size_t i, count = 0;

    if (argc < 4 || mlg_abi_version() != MLG_ABI_VERSION) {
        fprintf(stderr, "usage: %s TEMPLATE MARKERS OUT [TOLERANCE]\n", argv[0]);
        return 1;
    }
    signal(SIGINT, on_interrupt);
    require(mlg_tri_mesh_load(argv[1], &surface, &error), &error);
    require(mlg_markers_load(argv[2], &markers, &error), &error);
    require(mlg_tetrahedralization_run(surface, NULL, &tets, &error), &error);
    for (i = 0; i < mlg_tetrahedralization_warning_count(tets); i++)
        fprintf(stderr, "note: %s\n", mlg_tetrahedralization_warning(tets, i));

    require(mlg_reshaping_new(tets, &problem, &error), &error);
    {
        const double *points = mlg_markers_points(markers, &count);
        require(mlg_reshaping_set_markers(problem, points, mlg_markers_weights(markers, NULL), count,
                                          &error),
                &error);
    }
    mlg_reshaping_options_init(&options, sizeof options);
    if (argc > 4) options.tolerance = atof(argv[4]);
    require(mlg_reshaping_start(problem, &options, &run, &error), &error);
    show_until_ended(run);
    require(mlg_run_wait_reshaping(run, &result, &error), &error);

    summary.struct_size = sizeof summary;
    require(mlg_reshaping_result_summary(result, &summary, &error), &error);
    printf("%s, %u iterations, markers mean %.3f max %.3f, %u inverted tets\n",
           summary.stop == MLG_STOP_CANCELLED ? "stopped" : "done", (unsigned)summary.iterations,
           summary.mean_marker_distance, summary.max_marker_distance,
           (unsigned)summary.inverted_tets);
    {
        const double *points = mlg_reshaping_result_points(result, &count);
        require(mlg_tri_mesh_save(surface, points, count, argv[3], &error), &error);
    }
    mlg_reshaping_result_free(result);
    mlg_run_free(run);
    mlg_reshaping_free(problem);
    mlg_tetrahedralization_free(tets);
    mlg_markers_free(markers);
    mlg_tri_mesh_free(surface);
    return 0;
}
