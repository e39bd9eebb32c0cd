/* Gravity between all pairs as an expert writes it in C: coordinates in columns, each pair once, partners beside each other
   (`omp simd`). G = 0.1, softened by 0.01, spirals of the golden angle, h = 0.01.
   usage: hand_bodies N steps     prints: scheme, ns per body and step (best of 25), iterations per step */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define G 0.1
#define SOFTENING 0.01
#define H 0.01
/* Columns begin at different places of pages: processors tell apart what is read and written by these first. */
#define COLUMN(n) ((n) + 24)
#define COLUMNS(n) (3 * (size_t)COLUMN(n))
#define NOINLINE __attribute__((noinline))

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void start(int n, double *q, double *p) {
  for (int i = 0; i < n; i++) {
    double part = (i + 0.5) / n, height = 1 - 2 * part, angle = 2.399963 * i;
    double radius = 2 + sin(7.1 * i), across = sqrt(1 - height * height);
    q[i] = radius * across * cos(angle);
    q[COLUMN(n) + i] = radius * across * sin(angle);
    q[2 * COLUMN(n) + i] = radius * height;
  }
  memset(p, 0, COLUMNS(n) * 8);
}

/* One body and those before it. */
static NOINLINE void row(int i, const double *restrict x, const double *restrict y, const double *restrict z, double *restrict a,
                         double *restrict b, double *restrict c) {
  const double own_x = x[i], own_y = y[i], own_z = z[i];
  double sum_a = 0, sum_b = 0, sum_c = 0;
#pragma omp simd reduction(+ : sum_a, sum_b, sum_c)
  for (int j = 0; j < i; j++) {
    double dx = own_x - x[j], dy = own_y - y[j], dz = own_z - z[j];
    double square = dx * dx + dy * dy + dz * dz + SOFTENING;
    double pull = G / (square * sqrt(square));
    sum_a += pull * dx;
    sum_b += pull * dy;
    sum_c += pull * dz;
    a[j] += pull * dx;
    b[j] += pull * dy;
    c[j] += pull * dz;
  }
  a[i] -= sum_a;
  b[i] -= sum_b;
  c[i] -= sum_c;
}

static void forces(int n, const double *q, double *force) {
  const int m = COLUMN(n);
  memset(force, 0, COLUMNS(n) * 8);
  for (int i = 0; i < n; i++) row(i, q, q + m, q + 2 * m, force, force + m, force + 2 * m);
}

static long explicit_steps(int n, double *q, double *p, long steps, double *w) {
  for (long k = 0; k < steps; k++) {
    forces(n, q, w);
    for (size_t i = 0; i < COLUMNS(n); i++) {
      p[i] += H * w[i];
      q[i] += H * p[i];
    }
  }
  return 0;
}

/* The mid-point rule by fixed point, from the parabola through the last three forces. */
static long fixed_point(int n, double *q, double *p, long steps, double *w) {
  const int m = (int)COLUMNS(n);
  const double a = 0.25 * H * H;
  double *middle = w + m, *base = w + 2 * m, *past[3] = {w + 3 * m, w + 4 * m, w + 5 * m};
  long iterations = 0;
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < m; i++) {
      double guess = k == 0   ? 0
                     : k == 1 ? past[0][i]
                     : k == 2 ? 2 * past[0][i] - past[1][i]
                              : 3 * (past[0][i] - past[1][i]) + past[2][i];
      base[i] = q[i] + 0.5 * H * p[i];
      middle[i] = base[i] + a * guess;
    }
    double change = INFINITY, last;
    do {
      last = change;
      change = 0;
      forces(n, middle, w);
      for (int i = 0; i < m; i++) {
        double next = base[i] + a * w[i], own = fabs(next - middle[i]);
        change = own > change ? own : change;
        middle[i] = next;
      }
      iterations++;
    } while (change > 1e-15 && change < last);
    for (int i = 0; i < m; i++) {
      double end = 2 * middle[i] - q[i];
      p[i] = 2 * (end - q[i]) / H - p[i];
      q[i] = end;
    }
    double *oldest = past[2];
    past[2] = past[1];
    past[1] = past[0];
    past[0] = oldest;
    memcpy(oldest, w, (size_t)m * 8);
  }
  return iterations;
}

int main(int count, char **arguments) {
  if (count < 3) return 2;
  int n = atoi(arguments[1]);
  long steps = atol(arguments[2]);
  double *q = calloc(COLUMNS(n), 8), *p = calloc(COLUMNS(n), 8), *w = calloc(6 * COLUMNS(n), 8);
  if (!q || !p || !w) return 1;
  long (*schemes[2])(int, double *, double *, long, double *) = {explicit_steps, fixed_point};
  const char *names[2] = {"DeltaPlus", "Midpoint, fixed point"};
  for (int s = 0; s < 2; s++) {
    double best = 1e300;
    long iterations = 0;
    for (int r = 0; r < 25; r++) {
      start(n, q, p);
      double from = seconds();
      iterations = schemes[s](n, q, p, steps, w);
      double took = 1e9 * (seconds() - from) / ((double)n * (double)steps);
      best = took < best ? took : best;
    }
    printf("%s;%.3f;%.2f\n", names[s], best, (double)iterations / (double)steps);
  }
  return 0;
}
