/* A library in C, as a tool generates it or a colleague hands it over: a second-order low-pass filter behind
 * a handle. */
#ifndef FILTER_H
#define FILTER_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct filter filter; /* its members are the library's own */

filter* filter_create(double cutoff_rad_per_s, double period_s);
double filter_step(filter* f, double u); /* changes the state, which is memory of the library */
void filter_destroy(filter* f);
/* The state as numbers, like fmi2GetFMUstate and fmi2SerializeFMUstate. */
enum { FILTER_STATES = 2 };
void filter_get_state(const filter* f, double* state);
void filter_set_state(filter* f, const double* state);

#ifdef __cplusplus
}
#endif

#endif
