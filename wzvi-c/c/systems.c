/* Runs the systems of the example `systems`. `bits` prints every number that the Rust program examples/bits.rs
 * prints, as hexadecimal words; without it, a path of Kubo's oscillator and the mean of an ensemble.
 *
 *     cc -std=c11 -Wall -Wextra -Werror -I.. systems.c -o systems -L$LIBRARY -lsystems -lm */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "wzvi.h"

static const wzvi_table_t *w;

static void fail(const wzvi_task *task) {
    fprintf(stderr, "%s\n", w->error(task));
    exit(1);
}

static wzvi_task *begin(const char *system, const char *kind, const char *scheme) {
    wzvi_task *task = w->begin(w, system, kind);
    if (w->set_text(task, "scheme", scheme) != WZVI_DONE) fail(task);
    return task;
}

static void start(wzvi_task *task, double q, double p) {
    const size_t one[] = {1};
    if (w->set_reals(task, "q", &q, 1, one) != WZVI_DONE) fail(task);
    if (w->set_reals(task, "p", &p, 1, one) != WZVI_DONE) fail(task);
}

static const double *array(const wzvi_task *task, const char *wanted, size_t *count) {
    const char *name;
    const double *values;
    size_t shape[WZVI_AXES];
    for (size_t i = 0; i < w->results(task); i++) {
        size_t axes = w->result(task, i, &name, &values, shape);
        if (strcmp(name, wanted) != 0) continue;
        *count = 1;
        for (size_t axis = 0; axis < axes; axis++) *count *= shape[axis];
        return values;
    }
    fprintf(stderr, "there is no array %s\n", wanted);
    exit(1);
}

static void print_bits(const wzvi_task *task, const char *name) {
    size_t count;
    const double *values = array(task, name, &count);
    for (size_t i = 0; i < count; i++) {
        uint64_t word;
        memcpy(&word, &values[i], sizeof word);
        printf("%016" PRIx64 "\n", word);
    }
}

static void run(wzvi_task *task) {
    if (w->run(task) != WZVI_DONE) fail(task);
}

static wzvi_task *kubo(const char *kind) {
    wzvi_task *task = begin("Kubo", kind, "Midpoint");
    w->set_real(task, "parameter.a", 1.5);
    w->set_real(task, "parameter.sigma", 1.0);
    w->set_real(task, "h", 0.02);
    start(task, 0.0, 1.0);
    w->set_integer(task, "seed", 7);
    return task;
}

static wzvi_task *network(void) {
    const int64_t springs[] = {0, 1, 1, 2, 2, 3, 3, 0};
    const size_t table[] = {4, 2}, sites[] = {4};
    const double q[] = {1.0, 0.0, 0.0, 0.0}, p[] = {0.0, 0.0, 0.0, 0.5};
    wzvi_task *task = begin("Network", "path", "Verlet");
    w->set_real(task, "parameter.k", 2.0);
    w->set_integers(task, "parameter.springs", springs, 2, table);
    w->set_reals(task, "q", q, 1, sites);
    w->set_reals(task, "p", p, 1, sites);
    w->set_real(task, "h", 0.05);
    w->set_real(task, "until", 5.0);
    return task;
}

static void bits(void) {
    wzvi_task *task = kubo("path");
    w->set_text(task, "noise", "wiener");
    w->set_real(task, "until", 2.0);
    run(task);
    print_bits(task, "q");
    print_bits(task, "p");
    w->end(task);

    for (int64_t threads = 1; threads <= 3; threads++) {
        task = kubo("ensemble");
        w->set_real(task, "until", 2.0);
        w->set_integer(task, "paths", 3000);
        w->set_integer(task, "threads", threads);
        w->set_text(task, "observe", "q\nradius");
        run(task);
        print_bits(task, "mean");
        print_bits(task, "error");
        w->end(task);
    }

    task = begin("Pendulum", "path", "Midpoint");
    w->set_real(task, "parameter.g", 9.81);
    w->set_real(task, "h", 0.01);
    start(task, 2.0, 0.0);
    w->set_real(task, "until", 10.0);
    run(task);
    print_bits(task, "q");
    print_bits(task, "p");
    w->end(task);

    task = network();
    run(task);
    print_bits(task, "q");
    print_bits(task, "p");
    w->end(task);
}

static void show(void) {
    size_t count;
    wzvi_task *task = kubo("path");
    w->set_text(task, "noise", "wong-zakai");
    w->set_real(task, "width", 0.02);
    w->set_real(task, "until", 20.0);
    run(task);
    const double *q = array(task, "q", &count), *p = array(task, "p", &count);
    printf("Kubo at t = 20: q = %.17g, p = %.17g\n", q[count - 1], p[count - 1]);
    w->end(task);

    task = kubo("ensemble");
    w->set_real(task, "until", 2.0);
    w->set_integer(task, "paths", 10000);
    w->set_text(task, "observe", "q");
    run(task);
    const double *mean = array(task, "mean", &count), *error = array(task, "error", &count);
    printf("mean of q at t = 2: %.4f +- %.4f, exactly %.4f\n", mean[count - 1], error[count - 1], exp(-1.0) * sin(3.0));
    w->end(task);

    task = kubo("path");
    w->set_real(task, "untill", 20.0);
    int32_t status = w->run(task);
    printf("an error, status %d, kind %s:\n", status, w->code(task));
    printf("%s\n", w->error(task));
    w->end(task);
    /* Nothing but an error. */
    w->end(NULL);
    w->stop(NULL);
    if (w->run(NULL) != WZVI_FAILED || w->results(NULL) != 0) exit(1);
}

int main(int arguments, char **argument) {
    w = wzvi_table();
    if (w->abi != WZVI_ABI || w->size < sizeof *w) return 1;
    if (arguments > 1 && strcmp(argument[1], "bits") == 0) bits();
    else show();
    return 0;
}
