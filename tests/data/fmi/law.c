// A law as a unit of FMI 2.0: a time headway of two seconds. -DAT=20 with -DSEGV and others: how it fails at step 20.
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct {
    double in[4], request, gain;
    int steps;
} Law;

void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const void *f, int v, int l) {
    Law *law = calloc(1, sizeof(Law));
    law->gain = 0.4;
    // A unit may print: it must not stand among the answers.
    printf("a unit speaks\n");
    fflush(stdout);
    return law;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2SetReal(void *c, const unsigned *v, size_t n, const double *x) {
    Law *law = c;
    for (size_t i = 0; i < n; i++) {
        if (v[i] == 5) law->gain = x[i];
        else if (v[i] < 4) law->in[v[i]] = x[i];
        else return 3;
    }
    return 0;
}
int fmi2GetReal(void *c, const unsigned *v, size_t n, double *x) {
    Law *law = c;
    for (size_t i = 0; i < n; i++) x[i] = law->request;
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int q) {
    Law *law = c;
    if (++law->steps == AT) {
#ifdef SEGV
        *(volatile int *)0 = 1;
#elif defined(HANG)
        for (;;);
#elif defined(ERROR)
        return 3;
#elif defined(EXIT)
        exit(0);
#endif
    }
    double speed = law->in[0], free = law->gain * (law->in[3] - speed);
    double follow = 0.2 * (law->in[1] - 5 - 2 * speed) + 0.7 * law->in[2];
    double request = follow < free ? follow : free;
    law->request = request < -4 ? -4 : request > 2 ? 2 : request;
#ifdef NANS
    if (law->steps >= AT) law->request = NAN;
#endif
    return 0;
}
