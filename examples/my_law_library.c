/* The law of my_law.c as a shared library, which timegap calls in its own process. A crash here is timegap's.
 *
 *     timegap layouts --law --c > timegap_law.h
 *     cc -O2 -shared -fPIC -o my_law.so my_law_library.c -lm
 *     timegap compare following cut-in --law mine=library:./my_law.so
 */
#include <math.h>

#include "timegap_law.h"

static int law;

const char *timegap_law_layout_version(void) {
    return TIMEGAP_LAYOUT_VERSION;
}

/* A law with a memory allocates it here. */
void *timegap_law_create(void) {
    return &law;
}

void timegap_law_step(void *law, const TimegapLawInput *question, TimegapLawAnswer *answer) {
    (void)law;
    double speed = question->speed_mps;
    double request = 0.4 * (fmin(question->set_speed_mps, question->speed_limit_mps) - speed);
    if (question->has_target)
        request = fmin(request, 0.2 * (question->gap_m - 5.0 - 2.0 * speed) + 0.7 * question->relative_speed_mps);
    answer->request_mps2 = fmax(-4.0, fmin(2.0, request));
}

void timegap_law_destroy(void *law) {
    (void)law;
}
