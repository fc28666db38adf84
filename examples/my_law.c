/* A law of your own in C: a time headway of two seconds.
 *
 *     timegap layouts --law --c > timegap_law.h
 *     cc -O2 -o my_law my_law.c -lm
 *     timegap run following --controller external --set 'controller.command=["./my_law"]'
 */
#include <math.h>
#include <stdio.h>

#include "timegap_law.h"

int main(void) {
    TimegapLawInput input;
    while (fread(&input, sizeof input, 1, stdin) == 1) {
        double speed = input.speed_mps;
        double request = 0.4 * (fmin(input.set_speed_mps, input.speed_limit_mps) - speed);
        if (input.has_target)
            request = fmin(request, 0.2 * (input.gap_m - 5.0 - 2.0 * speed) + 0.7 * input.relative_speed_mps);
        TimegapLawAnswer answer = {.sequence = input.sequence, .request_mps2 = fmax(-4.0, fmin(2.0, request))};
        if (fwrite(&answer, sizeof answer, 1, stdout) != 1 || fflush(stdout) != 0)
            return 1;
    }
    return 0;
}
