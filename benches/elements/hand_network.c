/* Oscillators on a random graph with three bonds per site, as an expert writes them in C, h = 0.05.
   usage: hand_network N steps     prints: what, ns per site and step (best of 25), 0 */
#include <math.h>
#include <stdint.h>
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

static uint64_t state = 1;

static long draw(long n) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (long)((state >> 33) % (uint64_t)n);
}

static NOINLINE void step(long n, long bonds, const long (*restrict ends)[2], const double *restrict strength,
                          double *restrict q, double *restrict p, double *restrict w, long steps) {
  for (long k = 0; k < steps; k++) {
    memset(w, 0, n * sizeof *w);
    for (long b = 0; b < bonds; b++) {
      const double pull = strength[b] * sin(q[ends[b][0]] - q[ends[b][1]]);
      w[ends[b][0]] -= pull;
      w[ends[b][1]] += pull;
    }
    for (long i = 0; i < n; i++) {
      p[i] += h * w[i];
      q[i] += h * p[i];
    }
  }
}

int main(int count, char **arguments) {
  if (count < 3) return 2;
  const long n = atol(arguments[1]), steps = atol(arguments[2]), bonds = 3 * n;
  double *q = calloc(n, 8), *p = calloc(n, 8), *w = calloc(n, 8), *strength = calloc(bonds, 8);
  long(*ends)[2] = calloc(bonds, sizeof *ends);
  if (!q || !p || !w || !strength || !ends) return 1;
  for (long b = 0; b < bonds; b++) {
    const long first = draw(n), second = draw(n);
    ends[b][0] = first;
    ends[b][1] = first == second ? (first + 1) % n : second;
    strength[b] = 0.3 + 0.1 * sin(0.7 * (double)b);
  }
  double best = 1e300;
  for (int r = 0; r < 25; r++) {
    memset(p, 0, n * sizeof *p);
    for (long i = 0; i < n; i++) q[i] = 1.5 * sin(1.7 * (double)i);
    const double from = seconds();
    step(n, bonds, (const long(*)[2])ends, strength, q, p, w, steps);
    const double took = 1e9 * (seconds() - from) / ((double)n * (double)steps);
    best = took < best ? took : best;
  }
  printf("network, DeltaPlus;%.3f;0\n", best);
  return 0;
}
