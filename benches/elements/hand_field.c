/* Fields as an expert writes them in C, h = 0.05: phi^4 on a torus of side^2 sites, and a ring of N coupled pendulums.
   usage: hand_field N steps     prints: what, ns per site and step (best of 25), 0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define NOINLINE __attribute__((noinline))
static const double h = 0.05;

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline double force(double own, double left, double right, double up, double down) {
  return (left - own) + (right - own) + (up - own) + (down - own) - own * (own * own - 1);
}

static NOINLINE void torus(int side, double *restrict q, double *restrict p, long steps) {
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < side; i++) {
      const double *up = q + (i + side - 1) % side * side, *own = q + i * side, *down = q + (i + 1) % side * side;
      double *to = p + i * side;
      const int last = side - 1;
      to[0] += h * force(own[0], own[last], own[1], up[0], down[0]);
      for (int j = 1; j < last; j++) to[j] += h * force(own[j], own[j - 1], own[j + 1], up[j], down[j]);
      to[last] += h * force(own[last], own[last - 1], own[0], up[last], down[last]);
    }
    for (int i = 0; i < side * side; i++) q[i] += h * p[i];
  }
}

static NOINLINE void pendulums(int n, double *restrict q, double *restrict p, long steps) {
  for (long k = 0; k < steps; k++) {
    const int last = n - 1;
    p[0] += h * ((q[1] - q[0]) - (q[0] - q[last]) - sin(q[0]));
    for (int i = 1; i < last; i++) p[i] += h * ((q[i + 1] - q[i]) - (q[i] - q[i - 1]) - sin(q[i]));
    p[last] += h * ((q[0] - q[last]) - (q[last] - q[last - 1]) - sin(q[last]));
    for (int i = 0; i < n; i++) q[i] += h * p[i];
  }
}

/* Kick, drift, kick; the force at the end is that of the next step. */
static double *force_of;

static NOINLINE void torus_force(int side, const double *restrict q, double *restrict w) {
  for (int i = 0; i < side; i++) {
    const double *up = q + (i + side - 1) % side * side, *own = q + i * side, *down = q + (i + 1) % side * side;
    double *to = w + i * side;
    const int last = side - 1;
    to[0] = force(own[0], own[last], own[1], up[0], down[0]);
    for (int j = 1; j < last; j++) to[j] = force(own[j], own[j - 1], own[j + 1], up[j], down[j]);
    to[last] = force(own[last], own[last - 1], own[0], up[last], down[last]);
  }
}

static NOINLINE void pendulum_force(int n, const double *restrict q, double *restrict w) {
  const int last = n - 1;
  w[0] = (q[1] - q[0]) - (q[0] - q[last]) - sin(q[0]);
  for (int i = 1; i < last; i++) w[i] = (q[i + 1] - q[i]) - (q[i] - q[i - 1]) - sin(q[i]);
  w[last] = (q[0] - q[last]) - (q[last] - q[last - 1]) - sin(q[last]);
}

static NOINLINE void verlet(int n, double *restrict q, double *restrict p, long steps, int side) {
  double *restrict w = force_of;
  const double half = 0.5 * h;
  if (side) torus_force(side, q, w); else pendulum_force(n, q, w);
  for (long k = 0; k < steps; k++) {
    for (int i = 0; i < n; i++) {
      p[i] += half * w[i];
      q[i] += h * p[i];
    }
    if (side) torus_force(side, q, w); else pendulum_force(n, q, w);
    for (int i = 0; i < n; i++) p[i] += half * w[i];
  }
}

int main(int count, char **arguments) {
  if (count < 3) return 2;
  int n = atoi(arguments[1]), side = (int)(sqrt(n) + 0.5);
  long steps = atol(arguments[2]);
  double *q = calloc(n, 8), *p = calloc(n, 8);
  force_of = calloc(n, 8);
  if (!q || !p || !force_of) return 1;
  const char *names[4] = {"lattice, DeltaPlus", "ring, DeltaPlus", "lattice, Verlet", "ring, Verlet"};
  for (int s = 0; s < 4; s++) {
    if (s % 2 == 0 && side * side != n) continue;
    double best = 1e300;
    for (int r = 0; r < 25; r++) {
      memset(p, 0, n * sizeof *p);
      for (int i = 0; i < n; i++) q[i] = 1 + 0.3 * sin(6.283185307179586 * i / n);
      double from = seconds();
      if (s < 2) (s == 0 ? torus : pendulums)(s == 0 ? side : n, q, p, steps);
      else verlet(n, q, p, steps, s == 2 ? side : 0);
      double took = 1e9 * (seconds() - from) / ((double)n * (double)steps);
      best = took < best ? took : best;
    }
    printf("%s;%.3f;0\n", names[s], best);
  }
  return 0;
}
