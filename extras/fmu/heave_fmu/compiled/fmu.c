/* The fixed controller as a slave of FMI 2.0: messages in and out as held values, a tick at each whole tick period. */
#include <math.h>
#include <string.h>

#include "controller.h"
#include "fmi2Functions.h"
#include "last_step.h"

enum { MRU_PORT, DEPTH_PORT, WINCH_PORT, PORTS };

static const int COUNTS[PORTS] = {mru_count, unit_pressure_count, winch_state_count};

typedef struct {
    Controller controller;
    double values[VARIABLES], depth_zero, envelope[ENVELOPE_NUMBERS];
    int done, seen[PORTS];
    fmi2CallbackFreeMemory free_memory;
} Instance;

/* Tell whether a message came since the last tick; a counter of -1 says that one comes with each. */
static bool has_news(Instance *instance, int port)
{
    const int count = (int)instance->values[COUNTS[port]];
    const bool is_new = count == -1 || count > instance->seen[port];
    instance->seen[port] = count == -1 ? instance->seen[port] : count;
    return is_new;
}

/* Add a reading of the message at a port, which is of the tick where it has no stamp. */
static int add(Instance *instance, Reading *readings, int count, int port, int which, double value)
{
    const double stamp = instance->values[COUNTS[port] + 1];
    const double ticks = stamp < 0.0 ? instance->done : stamp / TICK_PERIOD, whole = rint(ticks);
    if (!isfinite(value) || !(fabs(ticks) < 1e9)) return count;
    readings[count] = (Reading){(int)whole, which, fabs(ticks - whole) > ON_TICK ? ticks - whole : 0.0, value};
    return count + 1;
}

static void do_tick(Instance *instance)
{
    double *values = instance->values;
    Reading readings[MEASUREMENTS];
    Seen seen = {NAN, NAN, NAN};
    int count = 0;
    instance->done++;
    if (has_news(instance, MRU_PORT) && values[mru_status] == 0.0) {
        count = add(instance, readings, count, MRU_PORT, MRU_HEAVE, values[mru_heave]);
        count = add(instance, readings, count, MRU_PORT, MRU_HEAVE_RATE, values[mru_heave_rate]);
        seen.heave = values[mru_heave], seen.heave_rate = values[mru_heave_rate];
    }
    if (has_news(instance, WINCH_PORT)) {
        count = add(instance, readings, count, WINCH_PORT, PAYOUT, values[winch_state_encoder_payout]);
        seen.count = values[winch_state_encoder_payout];
    }
    if (has_news(instance, DEPTH_PORT)) {
        const double depth = (values[unit_pressure_fluid_pressure] - ATMOSPHERE) / PRESSURE_PER_METRE;
        if (isnan(instance->depth_zero)) instance->depth_zero = depth;
        count = add(instance, readings, count, DEPTH_PORT, UNIT_HEAVE, instance->depth_zero - depth);
    }
    const Order ordered = controller_step(&instance->controller, instance->done, readings, count);
    const Within asked = {ordered.payout, ordered.payout_rate, ordered.brake};
    const Within within = last_step(instance->envelope, &seen, &asked);
    const Order sent = {within.payout, within.payout_rate, within.brake != 0.0};
    controller_sent(&instance->controller, &ordered, &sent);
    const Order order = controller_placed(&instance->controller, &sent);
    values[winch_command_payout] = order.payout;
    values[winch_command_payout_rate] = order.payout_rate;
    values[winch_command_brake] = order.brake;
    values[winch_command_sequence] = instance->done;
    values[controller_state_authority] = instance->controller.authority;
    values[winch_command_header_stamp] = values[controller_state_header_stamp] = instance->done * TICK_PERIOD;
    values[winch_command_count]++;
    values[controller_state_count]++;
}

/* Start values: nobody counts, and there are no stamps, at the inputs. */
static void set_start(Instance *instance)
{
    memset(instance->values, 0, sizeof instance->values);
    for (int port = 0; port < PORTS; port++) instance->values[COUNTS[port]] = instance->values[COUNTS[port] + 1] = -1.0;
}

static void begin(Instance *instance)
{
    controller_begin(&instance->controller);
    last_step_begin(instance->envelope);
    instance->done = 0;
    instance->depth_zero = NAN;
    for (int port = 0; port < PORTS; port++) {
        instance->seen[port] = 0;
        if (instance->values[COUNTS[port]] > 0.0) instance->values[COUNTS[port]] = 0.0;
    }
    for (int index = FIRST_OUTPUT; index < VARIABLES; index++) instance->values[index] = 0.0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || !guid || strcmp(guid, GUID) != 0 || !functions) return NULL;
    Instance *instance = functions->allocateMemory(1, sizeof *instance);
    if (!instance) return NULL;
    instance->free_memory = functions->freeMemory;
    set_start(instance);
    begin(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c) ((Instance *)c)->free_memory(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop)
{
    (void)c, (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    return start == 0.0 ? fmi2OK : fmi2Error; /* time 0 is the first tick */
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    begin(c);
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    set_start(c);
    begin(c);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state)
{
    Instance *instance = c;
    const double end = ceil((time + step) / TICK_PERIOD - INSTANT);
    (void)no_set_state;
    if (!(end < 2e9) || !(step >= 0.0)) return fmi2Error;
    while (instance->done < end) do_tick(instance);
    return fmi2OK;
}

#define ACCESS(Kind, letter)                                                                                  \
    fmi2Status fmi2Get##Kind(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2##Kind value[])    \
    {                                                                                                         \
        for (size_t i = 0; i < n; i++) {                                                                      \
            if (vr[i] >= VARIABLES || KINDS[vr[i]] != letter) return fmi2Error;                               \
            value[i] = (fmi2##Kind)((Instance *)c)->values[vr[i]];                                            \
        }                                                                                                     \
        return fmi2OK;                                                                                        \
    }                                                                                                         \
    fmi2Status fmi2Set##Kind(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2##Kind value[]) \
    {                                                                                                         \
        for (size_t i = 0; i < n; i++) {                                                                      \
            if (vr[i] >= FIRST_OUTPUT || KINDS[vr[i]] != letter) return fmi2Error;                            \
            ((Instance *)c)->values[vr[i]] = value[i];                                                        \
        }                                                                                                     \
        return fmi2OK;                                                                                        \
    }

ACCESS(Real, 'R')
ACCESS(Integer, 'I')
ACCESS(Boolean, 'B')

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[])
{
    const Instance *instance = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] != controller_state_mode) return fmi2Error;
        value[i] = instance->done == 0 ? "" : instance->values[winch_command_brake] != 0.0 ? "standby" : "compensating";
    }
    return fmi2OK;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

/* What needs nothing done, and what an FMU without strings, states and derivatives does not have. */
#define ANSWER(function, status, ...) \
    fmi2Status function(__VA_ARGS__) { return status; }

#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
ANSWER(fmi2ExitInitializationMode, fmi2OK, fmi2Component c)
ANSWER(fmi2Terminate, fmi2OK, fmi2Component c)
ANSWER(fmi2SetDebugLogging, fmi2OK, fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
ANSWER(fmi2SetString, n ? fmi2Error : fmi2OK, fmi2Component c, const fmi2ValueReference vr[], size_t n,
       const fmi2String v[])
ANSWER(fmi2GetFMUstate, fmi2Error, fmi2Component c, fmi2FMUstate *state)
ANSWER(fmi2SetFMUstate, fmi2Error, fmi2Component c, fmi2FMUstate state)
ANSWER(fmi2FreeFMUstate, fmi2Error, fmi2Component c, fmi2FMUstate *state)
ANSWER(fmi2SerializedFMUstateSize, fmi2Error, fmi2Component c, fmi2FMUstate state, size_t *size)
ANSWER(fmi2SerializeFMUstate, fmi2Error, fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
ANSWER(fmi2DeSerializeFMUstate, fmi2Error, fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
ANSWER(fmi2GetDirectionalDerivative, fmi2Error, fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
       const fmi2ValueReference known[], size_t knowns, const fmi2Real in[], fmi2Real out[])
ANSWER(fmi2SetRealInputDerivatives, fmi2Error, fmi2Component c, const fmi2ValueReference vr[], size_t n,
       const fmi2Integer order[], const fmi2Real value[])
ANSWER(fmi2GetRealOutputDerivatives, fmi2Error, fmi2Component c, const fmi2ValueReference vr[], size_t n,
       const fmi2Integer order[], fmi2Real value[])
ANSWER(fmi2CancelStep, fmi2Error, fmi2Component c)
ANSWER(fmi2GetStatus, fmi2Discard, fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
ANSWER(fmi2GetRealStatus, fmi2Discard, fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
ANSWER(fmi2GetIntegerStatus, fmi2Discard, fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
ANSWER(fmi2GetBooleanStatus, fmi2Discard, fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
ANSWER(fmi2GetStringStatus, fmi2Discard, fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
