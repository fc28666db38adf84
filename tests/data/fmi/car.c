// A car as a unit of FMI 2.0: a lag of 0.3 s. -DPEDALS has throttle and brake in place of an acceleration.
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

typedef struct {
    double in[2], v0, x, v, a;
    int steps;
} Car;

void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const void *f, int v, int l) {
    return calloc(1, sizeof(Car));
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) {
    Car *car = c;
    car->v = car->v0;
    return 0;
}
int fmi2Terminate(void *c) { return 0; }
int fmi2SetReal(void *c, const unsigned *v, size_t n, const double *x) {
    Car *car = c;
    for (size_t i = 0; i < n; i++) {
        if (v[i] > 2) return 3;
        if (v[i] == 2) car->v0 = x[i];
        else car->in[v[i]] = x[i];
    }
    return 0;
}
int fmi2GetReal(void *c, const unsigned *v, size_t n, double *x) {
    Car *car = c;
    for (size_t i = 0; i < n; i++) x[i] = v[i] == 3 ? car->x : v[i] == 4 ? car->v * 3.6 : car->a;
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int q) {
    Car *car = c;
    if (++car->steps == AT) {
#ifdef SEGV
        *(volatile int *)0 = 1;
#endif
#ifdef NANS
        car->v = NAN;
        return 0;
#endif
    }
#ifdef PEDALS
    double drag = car->v > 0 ? 0.1 + 0.0004 * car->v * car->v : 0;
    double wanted = 4.0 * car->in[0] - 8.0 * car->in[1] - drag;
#else
    double wanted = car->in[0];
#endif
    car->a += h / 0.3 * (wanted - car->a);
    double next = car->v + h * car->a;
    if (next < 0) next = 0, car->a = 0;
    car->x += 0.5 * h * (car->v + next);
    car->v = next;
    return 0;
}
