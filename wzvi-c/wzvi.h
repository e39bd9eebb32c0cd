/* wzvi.h: systems of wzvi from C, C++ and anything that calls C.
 *
 * A library of systems has one symbol, wzvi_table(). A task is one run: `begin`, set what it needs by name,
 * `run`, read arrays by name, `end`.
 *
 * Kinds of tasks, and what they result in:
 *   "path"       one path
 *   "ensemble"   statistics of many paths
 *   "indicators" indicators of chaos along one path: MEGNO, SALI, GALI, FLI
 *   "lyapunov"   Lyapunov exponents of one path
 *   "map"        indicators of chaos at the end of many paths
 *   "tangent"    derivatives of the end of one path by its start and by parameters
 * A library has "path", and of the others what it was compiled for; describe() lists them.
 *
 * Settings. Names of quantities are those of the closure of the drift for coordinates and momenta ("q",
 * "x", "q[0]"), "energy", the names of first integrals, those of `observe`, and that of the time. A list of
 * names is one text with a line for each.
 *   all          scheme, parameter.<field>, q, p, t, h (with a clock eps in its place), until or steps,
 *                whole_steps, project_start, threads, unwatched, and of noise: noise ("steps", "wiener",
 *                "wong-zakai"), seed, width (of "wong-zakai"), truncation (0 for none), increments (a row for
 *                each step)
 *   path         path (of the noise), record_every, record_at, observe, sections, end_at, retry, multipliers
 *   ensemble     record_every, record_at, observe, sections, retry, paths, sweep, quantiles, covariances,
 *                histograms with ranges, passages, keep_paths, keep_crossings, until_error with errors,
 *                allow_losses, antithetic, observe_work, observe_temperatures
 *   indicators   path, record_every, deviations
 *   lyapunov     path, record_every, deviations, copies, exponents
 *   map          paths, deviations, allow_losses
 *   tangent      path, by
 * A section is "+x" where x rises through zero, "-x" where it falls, "x" for both.
 * The page "From Python" of the guide has the meaning, the units and the results of each.
 *
 * Memory: what is handed in is copied. Arrays and names of results belong to the task until `end`; the text
 * of `error` and `code` is good until the next call on the task; that of `describe` for ever.
 * Threads: one thread at a time sets, runs, reads and ends a task. Any other may call `stop` and `progress`
 * on it meanwhile; `stop` is safe in a signal handler, too. Tasks do not depend on each other. `run` starts
 * threads of its own, and they have ended when it returns. After fork() a child uses tasks of its own.
 * Nothing unwinds out of a function, and a null task is an error.
 * Later versions of the table append functions: `size` says how far it reaches. `abi` changes with the
 * meaning of anything. */
#ifndef WZVI_H
#define WZVI_H
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { WZVI_ABI = 1 };
/* The largest number of axes of an array. */
enum { WZVI_AXES = 8 };
/* What `run` and the setters return. */
enum {
    WZVI_DONE = 0,
    /* The run ended early: there are results up to there, and an error. */
    WZVI_PARTIAL = 1,
    WZVI_FAILED = 2
};

typedef struct wzvi_task wzvi_task;
typedef struct wzvi_table wzvi_table_t;

struct wzvi_table {
    size_t size;
    uint32_t abi;
    uint32_t reserved;
    const void *inside;
    /* JSON: systems with their fields, closures, quantities, and schemes with plan and equations. */
    const char *(*describe)(const wzvi_table_t *table);
    /* A task; a wrong name is an error of its `run`. Null only without memory. */
    wzvi_task *(*begin)(const wzvi_table_t *table, const char *system, const char *kind);
    int32_t (*set_real)(wzvi_task *task, const char *name, double value);
    int32_t (*set_integer)(wzvi_task *task, const char *name, int64_t value);
    int32_t (*set_text)(wzvi_task *task, const char *name, const char *value);
    /* Arrays with the last index fastest. */
    int32_t (*set_reals)(wzvi_task *task, const char *name, const double *values, size_t axes, const size_t *shape);
    int32_t (*set_integers)(wzvi_task *task, const char *name, const int64_t *values, size_t axes, const size_t *shape);
    int32_t (*run)(wzvi_task *task);
    /* Ends a run early, within about a tenth of a second. */
    void (*stop)(const wzvi_task *task);
    /* Steps of a path, or paths of an ensemble. */
    void (*progress)(const wzvi_task *task, uint64_t *done, uint64_t *all);
    /* The number of arrays. */
    size_t (*results)(const wzvi_task *task);
    /* Array number `index`, and the number of its axes. */
    size_t (*result)(const wzvi_task *task, size_t index, const char **name, const double **values, size_t shape[WZVI_AXES]);
    /* Names, one in a line: of the observables of an ensemble; of other kinds, of time, coordinates and momenta. */
    const char *(*columns)(const wzvi_task *task);
    /* The error of the last call that failed, and its kind: "setting", "step", "noise", "stopped", ... */
    const char *(*error)(const wzvi_task *task);
    const char *(*code)(const wzvi_task *task);
    void (*end)(wzvi_task *task);
};

const wzvi_table_t *wzvi_table(void);

#ifdef __cplusplus
}
#endif
#endif
