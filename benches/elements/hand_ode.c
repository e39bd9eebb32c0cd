/* FPUT-beta as an expert writes it in C: beta = 1/4, fixed ends, first mode, amplitude 1, h = 0.05.
   usage: hand_ode N steps     prints: scheme, ns per particle and step (best of 25), iterations per step */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define BETA 0.25
#define NOINLINE __attribute__((noinline))

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline double pull(double d) { return d * (1 + BETA * d * d); }

static void start(int n, double *q, double *p) {
  for (int i = 0; i < n; i++) {
    q[i] = sin(3.14159265358979323846 * (i + 1) / (n + 1));
    p[i] = 0;
  }
}

/* q has a zero at [-1] and at [n]. */
static NOINLINE long explicit_steps(int n, double *restrict q, double *restrict p, double h, long steps, double *w) {
  (void)w;
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < n; i++) p[i] += h * (pull(q[i + 1] - q[i]) - pull(q[i] - q[i - 1]));
    for (int i = 0; i < n; i++) q[i] += h * p[i];
  }
  return 0;
}

/* Kick, drift, kick; the force at the end is that of the next step. */
static NOINLINE long kick_drift_kick(int n, double *restrict q, double *restrict p, double h, long steps, double *restrict w) {
  const double half = 0.5 * h;
  for (int i = 0; i < n; i++) w[i] = pull(q[i + 1] - q[i]) - pull(q[i] - q[i - 1]);
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < n; i++) {
      p[i] += half * w[i];
      q[i] += h * p[i];
    }
    for (int i = 0; i < n; i++) {
      w[i] = pull(q[i + 1] - q[i]) - pull(q[i] - q[i - 1]);
      p[i] += half * w[i];
    }
  }
  return 0;
}

/* The mid-point rule by fixed point, from the free motion. */
static NOINLINE long fixed_point(int n, double *q, double *p, double h, long steps, double *w) {
  double *Q = w + 1, *Z = w + n + 4, *b = Z + n + 3;
  long iterations = 0;
  const double a = 0.25 * h * h;
  Q[-1] = Q[n] = Z[-1] = Z[n] = 0;
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < n; i++) Q[i] = b[i] = q[i] + 0.5 * h * p[i];
    double largest;
    int count = 0;
    do {
      largest = 0;
      for (int i = 0; i < n; i++) Z[i] = b[i] + a * (pull(Q[i + 1] - Q[i]) - pull(Q[i] - Q[i - 1]));
      for (int i = 0; i < n; i++) {
        double e = fabs(Z[i] - Q[i]);
        largest = e > largest ? e : largest;
      }
      double *swap = Q;
      Q = Z;
      Z = swap;
      count++;
    } while (largest > 1e-15 && count < 100);
    iterations += count;
    for (int i = 0; i < n; i++) {
      double end = 2 * Q[i] - q[i];
      p[i] = 2 * (end - q[i]) / h - p[i];
      q[i] = end;
    }
  }
  return iterations;
}

/* The mid-point rule by Newton's method with a tridiagonal solution. */
static NOINLINE long newton(int n, double *q, double *p, double h, long steps, double *w) {
  double *Q = w, *b = w + n + 2, *rhs = b + n, *dg = rhs + n, *of = dg + n;
  long iterations = 0;
  const double a = 0.25 * h * h;
  Q++;
  Q[-1] = 0;
  Q[n] = 0;
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < n; i++) Q[i] = b[i] = q[i] + 0.5 * h * p[i];
    double largest;
    int count = 0;
    do {
      for (int i = 0; i < n; i++) {
        double r = Q[i + 1] - Q[i], l = Q[i] - Q[i - 1];
        rhs[i] = -(Q[i] - b[i] - a * (pull(r) - pull(l)));
        double kr = 1 + 3 * BETA * r * r, kl = 1 + 3 * BETA * l * l;
        dg[i] = 1 + a * (kr + kl);
        of[i] = -a * kr;
      }
      double inverse = 1 / dg[0];
      for (int i = 1; i < n; i++) {
        double m = of[i - 1] * inverse;
        dg[i] -= m * of[i - 1];
        rhs[i] -= m * rhs[i - 1];
        of[i - 1] *= inverse;
        rhs[i - 1] *= inverse;
        inverse = 1 / dg[i];
      }
      rhs[n - 1] *= inverse;
      largest = fabs(rhs[n - 1]);
      Q[n - 1] += rhs[n - 1];
      for (int i = n - 2; i >= 0; i--) {
        rhs[i] -= of[i] * rhs[i + 1];
        Q[i] += rhs[i];
        double e = fabs(rhs[i]);
        largest = e > largest ? e : largest;
      }
      count++;
    } while (largest > 1e-8 && count < 50);
    iterations += count;
    for (int i = 0; i < n; i++) {
      double end = 2 * Q[i] - q[i];
      p[i] = 2 * (end - q[i]) / h - p[i];
      q[i] = end;
    }
  }
  return iterations;
}

int main(int count, char **arguments) {
  if (count < 3) return 2;
  int n = atoi(arguments[1]);
  long steps = atol(arguments[2]);
  double *memory = calloc(n + 16, 8), *q = memory + 8, *p = calloc(n + 16, 8), *w = calloc(8 * (size_t)(n + 16), 8);
  if (!memory || !p || !w) return 1;
  long (*schemes[4])(int, double *, double *, double, long, double *) = {explicit_steps, kick_drift_kick, fixed_point, newton};
  const char *names[4] = {"DeltaPlus", "Verlet", "Midpoint, fixed point", "Midpoint, Newton"};
  for (int s = 0; s < 4; s++) {
    double best = 1e300;
    long iterations = 0;
    for (int r = 0; r < 25; r++) {
      memset(memory, 0, (n + 16) * 8);
      start(n, q, p);
      double from = seconds();
      iterations = schemes[s](n, q, p, 0.05, steps, w);
      double took = 1e9 * (seconds() - from) / ((double)n * (double)steps);
      best = took < best ? took : best;
    }
    printf("%s;%.3f;%.2f\n", names[s], best, (double)iterations / (double)steps);
  }
  return 0;
}
