/* Runs: a known answer, the same bits on any thread count, cancel at any time, two at once, and a
 * thousand that are started, cancelled and freed. */
#include "shapes.h"

static int quick; /* every call, with little to compute: for the sanitizers and valgrind */

static MlgReshapingOptions default_options(void) {
    MlgReshapingOptions options;
    CHECK(mlg_reshaping_options_init(&options, sizeof options) == MLG_STATUS_OK);
    if (quick) options.max_iterations = 3;
    return options;
}

static MlgProgress poll_run(const MlgRun *run) {
    MlgProgress progress;
    progress.struct_size = sizeof progress;
    CHECK(mlg_run_poll(run, &progress, NULL) == MLG_STATUS_OK);
    CHECK(progress.fraction >= 0 && progress.fraction <= 1 && progress.stage[0] != '\0');
    return progress;
}

static MlgReshapingSummary summary_of(const MlgReshapingResult *result) {
    MlgReshapingSummary summary;
    summary.struct_size = sizeof summary;
    CHECK(mlg_reshaping_result_summary(result, &summary, NULL) == MLG_STATUS_OK);
    return summary;
}

/* Plausible shapes of two results that are the same. */
static void how_sure(const MlgReshapingResult *one, const MlgReshapingResult *two) {
    MlgUncertainty *few = NULL, *more = NULL;
    MlgUncertaintySummary size;
    MlgError error;
    size_t count = 0;
    double shape[2][3 * POINTS];
    const double *sd;
    CHECK(mlg_uncertainty_new(one, 1, &few, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "1 plausible shapes do not tell") != NULL);
    CHECK(mlg_uncertainty_new(one, 5, &few, NULL) == MLG_STATUS_OK);
    CHECK(mlg_uncertainty_new(two, 40, &more, NULL) == MLG_STATUS_OK);
    CHECK(mlg_uncertainty_shape(few, 4, shape[0], POINTS, NULL) == MLG_STATUS_OK);
    CHECK(mlg_uncertainty_shape(more, 4, shape[1], POINTS, NULL) == MLG_STATUS_OK);
    CHECK(memcmp(shape[0], shape[1], sizeof shape[0]) == 0);
    CHECK(mlg_uncertainty_shape(few, 5, shape[0], POINTS, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "there is no shape 5: there are 5") != NULL);
    CHECK(mlg_uncertainty_shape(few, 4, shape[0], 1, &error) == MLG_STATUS_INVALID_ARGUMENT);
    sd = mlg_uncertainty_sd(more, &count);
    CHECK(count == POINTS && sd[0] >= mlg_uncertainty_sd_normal(more, NULL)[0]);
    size.struct_size = sizeof size;
    CHECK(mlg_uncertainty_summary(more, &size, NULL) == MLG_STATUS_OK && size.shapes == 40);
    CHECK(size.volume_sd > 0 && size.volume_sd < 0.1 * size.volume);
    mlg_uncertainty_free(few);
    mlg_uncertainty_free(more);
    CHECK(mlg_uncertainty_sd(more, NULL) == NULL);
}

static void known_answer(uint32_t tet_count) {
    double points[3 * POINTS], inside[] = {0.1, 0.2, 0.3};
    MlgReshaping *problem = sphere_problem(points, tet_count);
    MlgReshapingResult *one = NULL, *two = NULL;
    MlgReshapingOptions options = default_options();
    MlgReshapingSummary summary;
    size_t i, count = 0, more = 0;
    const double *x;
    double worst = 0;

    options.thread_count = 1;
    CHECK(mlg_reshaping_run(problem, &options, &one, NULL) == MLG_STATUS_OK);
    options.thread_count = 2;
    CHECK(mlg_reshaping_run(problem, &options, &two, NULL) == MLG_STATUS_OK);
    x = mlg_reshaping_result_points(one, &count);
    CHECK(count == POINTS);
    CHECK(memcmp(x, mlg_reshaping_result_points(two, NULL), 3 * count * sizeof *x) == 0);
    for (i = 0; i < count; i++) {
        const double a = x[3 * i] / 1.5, b = x[3 * i + 1], c = x[3 * i + 2] / 0.8;
        worst = fmax(worst, fabs(sqrt(a * a + b * b + c * c) - 1));
    }
    summary = summary_of(one);
    printf("worst distance %.4f, markers %.4f, %u iterations, %.2f s\n", worst,
           summary.mean_marker_distance, (unsigned)summary.iterations, summary.seconds);
    CHECK(worst < 0.06 && summary.mean_marker_distance < 0.01 && summary.inverted_tets == 0);
    CHECK(mlg_reshaping_result_marker_distances(one, &more) != NULL && more == (POINTS + 2) / 3);
    CHECK(mlg_reshaping_result_plastic_strains(one, &count) && mlg_reshaping_result_tet_points(one, &more));
    CHECK(count > more); /* more tets than points */
    CHECK(mlg_reshaping_result_carry(one, inside, 1, inside, NULL) == MLG_STATUS_OK);
    CHECK(fabs(inside[0]) < 0.5 && inside[0] == inside[0]);
    how_sure(one, two);
    mlg_reshaping_result_free(one);
    mlg_reshaping_result_free(two);
    CHECK(mlg_reshaping_result_points(one, NULL) == NULL);
    mlg_reshaping_free(problem);
}

static void polling_and_two_at_once(uint32_t tet_count) {
    double points[3 * POINTS], preview[3 * POINTS];
    MlgReshaping *problem = sphere_problem(points, tet_count);
    const MlgReshapingOptions options = default_options();
    MlgRun *first = NULL, *second = NULL;
    MlgReshapingResult *result = NULL;
    size_t count = 0;
    uint32_t state = MLG_RUN_ENDED;
    CHECK(mlg_reshaping_start(problem, &options, &first, NULL) == MLG_STATUS_OK);
    CHECK(mlg_run_wait_for(first, 0, &state, NULL) == MLG_STATUS_OK && state == MLG_RUN_RUNNING);
    CHECK(mlg_reshaping_start(problem, &options, &second, NULL) == MLG_STATUS_OK);
    mlg_reshaping_free(problem); /* the runs have their own copy */
    do {
        CHECK(mlg_run_preview_points(first, preview, POINTS, &count, NULL) == MLG_STATUS_OK);
        CHECK(count == 0 || count == POINTS);
    } while (poll_run(first).state == MLG_RUN_RUNNING);
    CHECK(mlg_run_preview_points(first, NULL, 0, &count, NULL) == MLG_STATUS_OK && count == POINTS);
    CHECK(mlg_run_wait_reshaping(first, &result, NULL) == MLG_STATUS_OK);
    mlg_reshaping_result_free(result);
    CHECK(mlg_run_wait_reshaping(first, &result, NULL) == MLG_STATUS_INVALID_ARGUMENT);
    /* Until it ends, whatever that takes; a time that makes no sense is refused, and NULL has no place for the answer. */
    CHECK(mlg_run_wait_for(second, INFINITY, &state, NULL) == MLG_STATUS_OK && state == MLG_RUN_ENDED);
    CHECK(mlg_run_wait_for(second, 0, &state, NULL) == MLG_STATUS_OK && state == MLG_RUN_ENDED);
    CHECK(mlg_run_wait_for(second, -1, &state, NULL) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_run_wait_for(second, NAN, &state, NULL) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(mlg_run_wait_for(second, 0, NULL, NULL) == MLG_STATUS_NULL_ARGUMENT);
    CHECK(mlg_run_wait_reshaping(second, &result, NULL) == MLG_STATUS_OK);
    CHECK(poll_run(second).state == MLG_RUN_ENDED && poll_run(second).fraction == 1);
    mlg_reshaping_result_free(result);
    mlg_run_free(first);
    mlg_run_free(second);
}

static void again_after_a_landmark_moved(uint32_t tet_count) {
    double points[3 * POINTS], place[3], target[3];
    MlgReshaping *problem = sphere_problem(points, tet_count), *other;
    MlgReshapingResult *first = NULL, *second = NULL;
    MlgReshapingOptions options = default_options();
    MlgRun *run = NULL;
    MlgError error;
    int k;
    CHECK(mlg_reshaping_run(problem, &options, &first, NULL) == MLG_STATUS_OK);
    for (k = 0; k < 3; k++) {
        place[k] = points[k];
        target[k] = 1.1 * mlg_reshaping_result_points(first, NULL)[k];
    }
    CHECK(mlg_reshaping_set_landmarks(problem, place, target, NULL, 1, NULL) == MLG_STATUS_OK);
    CHECK(mlg_reshaping_start_again(first, problem, &options, &run, NULL) == MLG_STATUS_OK);
    CHECK(mlg_run_wait_reshaping(run, &second, NULL) == MLG_STATUS_OK);
    printf("again: %u iterations after %u\n", (unsigned)summary_of(second).iterations,
           (unsigned)summary_of(first).iterations);
    CHECK(summary_of(second).iterations <= summary_of(first).iterations);
    CHECK(summary_of(second).inverted_tets == 0);
    mlg_run_free(run);
    mlg_reshaping_result_free(second);

    options.smoothness *= 2;
    CHECK(mlg_reshaping_start_again(first, problem, &options, &run, NULL) == MLG_STATUS_OK);
    CHECK(mlg_run_wait_reshaping(run, &second, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "other options") != NULL);
    mlg_run_free(run);
    other = sphere_problem(points, 2 * tet_count);
    CHECK(mlg_reshaping_start_again(first, other, NULL, &run, NULL) == MLG_STATUS_OK);
    CHECK(mlg_run_wait_reshaping(run, &second, &error) == MLG_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(error.message, "another template") != NULL);
    mlg_run_free(run);
    mlg_reshaping_free(other);
    mlg_reshaping_result_free(first);
    CHECK(mlg_reshaping_start_again(first, problem, NULL, &run, NULL) == MLG_STATUS_INVALID_ARGUMENT);
    mlg_reshaping_free(problem);
}

/* Cancels after more and more polls, so that every stage is hit. */
static void cancel_at_every_stage(int times, uint32_t tet_count) {
    double points[3 * POINTS];
    MlgReshaping *problem = sphere_problem(points, tet_count);
    const MlgReshapingOptions options = default_options();
    int i, with_result = 0;
    for (i = 0; i < times; i++) {
        MlgRun *run = NULL;
        MlgReshapingResult *result = NULL;
        MlgStatus status;
        long wait;
        CHECK(mlg_reshaping_start(problem, &options, &run, NULL) == MLG_STATUS_OK);
        for (wait = 0; wait < 2000L * i && poll_run(run).state == MLG_RUN_RUNNING; wait++) {
        }
        mlg_run_cancel(run);
        status = mlg_run_wait_reshaping(run, &result, NULL);
        CHECK(status == MLG_STATUS_OK || status == MLG_STATUS_CANCELLED);
        if (status == MLG_STATUS_OK) {
            with_result++;
            CHECK(mlg_reshaping_result_points(result, NULL)[0] < 10);
        }
        mlg_reshaping_result_free(result);
        mlg_run_free(run);
        mlg_run_free(run);
    }
    printf("%d of %d cancelled runs had a shape\n", with_result, times);
    mlg_reshaping_free(problem);
}

/* 0 iterations stand for as many as by default. */
static void default_iterations(uint32_t tet_count) {
    double points[3 * POINTS];
    MlgReshaping *problem = sphere_problem(points, tet_count);
    MlgReshapingOptions options = default_options();
    MlgReshapingResult *result = NULL;
    options.max_iterations = 0;
    CHECK(mlg_reshaping_run(problem, &options, &result, NULL) == MLG_STATUS_OK);
    CHECK(summary_of(result).iterations > 0);
    mlg_reshaping_result_free(result);
    mlg_reshaping_free(problem);
}

static void start_cancel_free(int times, uint32_t tet_count) {
    double points[3 * POINTS];
    MlgReshaping *problem = sphere_problem(points, tet_count);
    MlgReshapingOptions options = default_options();
    int i;
    options.thread_count = 1;
    for (i = 0; i < times; i++) {
        MlgRun *run = NULL;
        CHECK(mlg_reshaping_start(problem, &options, &run, NULL) == MLG_STATUS_OK);
        mlg_run_cancel(run);
        mlg_run_free(run); /* while it runs */
    }
    mlg_reshaping_free(problem);
}

/* runs [quick] */
int main(int argc, char **argv) {
    uint32_t tet_count;
    quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    tet_count = quick ? 60 : 1500;
    known_answer(tet_count);
    polling_and_two_at_once(tet_count);
    again_after_a_landmark_moved(tet_count);
    cancel_at_every_stage(quick ? 2 : 20, quick ? 60 : 800);
    default_iterations(60);
    start_cancel_free(quick ? 5 : 1000, quick ? 60 : 100);
    puts("runs: good");
    return 0;
}
