/* Drive the controller through the interface of the FMI, for the sanitizers: late, wild and missing numbers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "interface.h"

static void set(fmi2Component c, fmi2ValueReference index, double value)
{
    const fmi2Integer whole = (fmi2Integer)(KINDS[index] == 'I' ? value : 0.0);
    if (KINDS[index] == 'I' ? fmi2SetInteger(c, &index, 1, &whole) : fmi2SetReal(c, &index, 1, &value)) exit(1);
}

int main(void)
{
    const fmi2CallbackFunctions calls = {NULL, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate("it", fmi2CoSimulation, GUID, "", &calls, 0, 0);
    const fmi2ValueReference rate = winch_command_payout_rate, beyond = VARIABLES;
    fmi2Real found = 0.0, rates[2401] = {0.0}, largest = 0.0, payout = 0.0;
    if (!c || fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0) || fmi2EnterInitializationMode(c)) return 1;
    if (fmi2ExitInitializationMode(c) || fmi2GetReal(c, &beyond, 1, &found) == fmi2OK) return 1;
    for (int tick = 1; tick <= 2400; tick++) {
        const double time = tick * TICK_PERIOD, height = tick < 1400 ? 0.5 : 6.0, heave = height * sin(0.8 * time);
        set(c, mru_count, tick - tick / 7);
        set(c, mru_heave, tick % 90 ? heave : NAN);
        set(c, mru_heave_rate, tick % 91 ? 0.8 * height * cos(0.8 * time) : INFINITY);
        set(c, mru_header_stamp, tick % 92 ? time - 0.02 : 1e300);
        set(c, winch_state_count, -1.0);
        set(c, winch_state_command_sequence, tick > 3 ? tick - 3 : 0);
        payout += tick > 6 ? TICK_PERIOD * rates[tick - 6] : 0.0; /* a drum that follows late */
        set(c, winch_state_encoder_payout, payout + (tick > 2200 ? 0.02 * (tick - 2200) : 0.0));
        set(c, winch_state_header_stamp, tick % 93 ? -1.0 : NAN);
        set(c, unit_pressure_count, tick < 600 ? 0 : tick - 600);
        set(c, winch_load_cell_count, 0);
        set(c, unit_pressure_fluid_pressure, 3e6 - 1e4 * heave);
        set(c, unit_pressure_header_stamp, tick < 1400 ? time : time - 0.05 * (tick % 40));
        if (fmi2DoStep(c, time - TICK_PERIOD, TICK_PERIOD, 1) || fmi2GetReal(c, &rate, 1, &found)) return 1;
        rates[tick] = found;
        largest = fmax(largest, fabs(found));
    }
    fmi2FreeInstance(c);
    printf("%.9g\n", largest);
    return isfinite(found) ? 0 : 1;
}
