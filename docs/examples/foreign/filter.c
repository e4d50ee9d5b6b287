#include "filter.h"

#include <stdlib.h>

struct filter {
  double pole, first, second;
};

filter* filter_create(double cutoff_rad_per_s, double period_s) {
  filter* f = (filter*)malloc(sizeof(filter));
  if (f != NULL) {
    f->pole = 1 / (1 + cutoff_rad_per_s * period_s);
    f->first = f->second = 0;
  }
  return f;
}

double filter_step(filter* f, double u) {
  f->first = f->pole * f->first + (1 - f->pole) * u;
  f->second = f->pole * f->second + (1 - f->pole) * f->first;
  return f->second;
}

void filter_destroy(filter* f) {
  free(f);
}

void filter_get_state(const filter* f, double* state) {
  state[0] = f->first;
  state[1] = f->second;
}

void filter_set_state(filter* f, const double* state) {
  f->first = state[0];
  f->second = state[1];
}
