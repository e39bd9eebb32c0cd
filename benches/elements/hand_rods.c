/* A chain of rods in the plane by RATTLE, as an expert writes it in C, h = 0.002: a tridiagonal Newton iteration from the
   impulses of the last two steps, one tridiagonal solve for the momenta, compensated sums of the state.
   usage: hand_rods N steps     prints: what, ns per rod and step (best of 25), iterations per step */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const double h = 0.002;

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void solve(long n, const double *lower, const double *diagonal, const double *upper, double *b, double *c) {
  double inverse = 1 / diagonal[0];
  c[0] = upper[0] * inverse;
  b[0] *= inverse;
  for (long k = 1; k < n; k++) {
    inverse = 1 / (diagonal[k] - lower[k] * c[k - 1]);
    c[k] = upper[k] * inverse;
    b[k] = (b[k] - lower[k] * b[k - 1]) * inverse;
  }
  for (long k = n - 2; k >= 0; k--) b[k] -= c[k] * b[k + 1];
}

static inline void add(double *x, double d, double *lost) {
  const double y = d + *lost, s = *x + y;
  *lost = y - (s - *x);
  *x = s;
}

/* Coordinates and momenta with what their sums lost, the end of a drift, impulses, rods at the start and the end of a drift,
   multipliers of this step and the last two, residuals, and a matrix of three diagonals with its scratch. */
struct chain {
  long n, known, iterations;
  double *q, *p, *lost_q, *lost_p, *end, *lost_end, *impulse, *rod, *next, *nu, *last, *before, *g, *lower, *diagonal, *upper, *c;
};

static void matrix(const struct chain *s, const double *at, const double *rod) {
  for (long k = 0; k < s->n; k++) {
    s->diagonal[k] = (at[2 * k] * rod[2 * k] + at[2 * k + 1] * rod[2 * k + 1]) * (k ? 2 : 1);
    s->lower[k] = k ? -(at[2 * k] * rod[2 * k - 2] + at[2 * k + 1] * rod[2 * k - 1]) : 0;
    s->upper[k] = k + 1 < s->n ? -(at[2 * k] * rod[2 * k + 2] + at[2 * k + 1] * rod[2 * k + 3]) : 0;
  }
}

static void step(struct chain *s) {
  const long n = s->n;
  for (long i = 0; i < n; i++) add(&s->p[2 * i + 1], -h / 2, &s->lost_p[2 * i + 1]);
  for (long k = 0; k < n; k++) s->nu[k] = s->known > 1 ? 2 * s->last[k] - s->before[k] : s->known ? s->last[k] : 0;
  for (int iteration = 0; iteration < 20; iteration++) {
    for (long i = 0; i < n; i++)
      for (long x = 2 * i; x < 2 * i + 2; x++) {
        s->impulse[x] = -s->rod[x] * s->nu[i] + (i + 1 < n ? s->rod[x + 2] * s->nu[i + 1] : 0);
        s->end[x] = s->q[x];
        s->lost_end[x] = s->lost_q[x];
        add(&s->end[x], h * (s->p[x] + s->impulse[x]), &s->lost_end[x]);
      }
    double worst = 0;
    for (long k = 0; k < n; k++) {
      double square = 0, size = 0;
      for (long x = 2 * k; x < 2 * k + 2; x++) {
        const double d = s->end[x] - (k ? s->end[x - 2] : 0);
        s->next[x] = d;
        square += d * d;
        size += fabs(d) * (fabs(s->q[x]) + fabs(s->end[x]) + (k ? fabs(s->q[x - 2]) + fabs(s->end[x - 2]) : 0));
      }
      s->g[k] = 0.5 * (square - 1);
      const double relative = fabs(s->g[k]) / size;
      worst = relative > worst ? relative : worst;
    }
    if (worst <= 8.9e-16) break;
    s->iterations++;
    matrix(s, s->next, s->rod);
    for (long k = 0; k < n; k++) s->g[k] /= h;
    solve(n, s->lower, s->diagonal, s->upper, s->g, s->c);
    for (long k = 0; k < n; k++) s->nu[k] += s->g[k];
  }
  double *t = s->before;
  s->before = s->last;
  s->last = s->nu;
  s->nu = t;
  s->known++;
  t = s->q, s->q = s->end, s->end = t;
  t = s->lost_q, s->lost_q = s->lost_end, s->lost_end = t;
  t = s->rod, s->rod = s->next, s->next = t;
  for (long x = 0; x < 2 * n; x++) add(&s->p[x], s->impulse[x], &s->lost_p[x]);
  for (long i = 0; i < n; i++) add(&s->p[2 * i + 1], -h / 2, &s->lost_p[2 * i + 1]);
  for (long k = 0; k < n; k++)
    s->g[k] = s->rod[2 * k] * (s->p[2 * k] - (k ? s->p[2 * k - 2] : 0)) +
              s->rod[2 * k + 1] * (s->p[2 * k + 1] - (k ? s->p[2 * k - 1] : 0));
  matrix(s, s->rod, s->rod);
  solve(n, s->lower, s->diagonal, s->upper, s->g, s->c);
  for (long i = 0; i < n; i++)
    for (long x = 2 * i; x < 2 * i + 2; x++)
      add(&s->p[x], -s->rod[x] * s->g[i] + (i + 1 < n ? s->rod[x + 2] * s->g[i + 1] : 0), &s->lost_p[x]);
}

int main(int count, char **arguments) {
  if (count < 3) return 2;
  const long n = atol(arguments[1]), steps = atol(arguments[2]);
  struct chain s = {.n = n};
  double **lists[] = {&s.q, &s.p, &s.lost_q, &s.lost_p, &s.end, &s.lost_end, &s.impulse, &s.rod, &s.next,
                      &s.nu, &s.last, &s.before, &s.g, &s.lower, &s.diagonal, &s.upper, &s.c};
  for (size_t k = 0; k < sizeof lists / sizeof *lists; k++)
    if (!(*lists[k] = calloc(2 * n, 8))) return 1;
  for (long i = 0; i < n; i++) s.q[2 * i] = i + 1, s.rod[2 * i] = 1;
  double best = 1e300;
  for (int r = 0; r < 25; r++) {
    const double from = seconds();
    for (long k = 0; k < steps; k++) step(&s);
    const double took = 1e9 * (seconds() - from) / ((double)n * (double)steps);
    best = took < best ? took : best;
  }
  printf("rods, Rattle;%.3f;%.2f\n", best, (double)s.iterations / (25.0 * (double)steps));
  return 0;
}
