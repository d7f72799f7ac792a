/* The controller as a slave of FMI 2.0: messages in and out as held values, a tick at each whole tick period. */
#include <math.h>
#include <string.h>

#include "controller.h"
#include "fmi2Functions.h"
#include "interface.h"

/* Messages of a topic: reference of their counter, most that come in a tick, numbers of each after its stamp, the sensor that
   they are of, and, of a scalar one, the field that counts, what it reads at 0, and its unit over that of the controller. */
typedef struct {
    int counter, slots, width, sensor, field;
    double zero, scale;
} Port;

static const Port PORTS[] = INPUT_PORTS;
enum { COUNT = sizeof PORTS / sizeof *PORTS, MOST = 64 };
static const char *const MODES[] = MODE_NAMES;

typedef struct {
    double values[VARIABLES];
    int done, seen[COUNT];
    HeaveOrder order;
    void *controller;
    fmi2CallbackFreeMemory free_memory;
} Instance;

/* Messages that came since the last tick; a counter of -1 says that one comes with each. */
static int news(Instance *instance, int port)
{
    const int count = (int)instance->values[PORTS[port].counter], before = instance->seen[port];
    if (count == -1) return 1;
    instance->seen[port] = count;
    return count > before ? count - before : 0;
}

/* Time of a message [s], whose stamps are whole nanoseconds; one without a stamp is of the tick. */
static double time_of(const Instance *instance, double stamp)
{
    return (stamp < 0.0 ? instance->done * TICK_NANOSECONDS : rint(1e9 * stamp)) * 1e-9;
}

static HeaveReading reading_of(const Instance *instance, const Port *port, const double *message)
{
    const double *fields = message + 1;
    HeaveReading reading = {port->sensor, time_of(instance, message[0]), 0.0, 0.0, 0.0, 0.0, 0.0, NAN, NAN};
    if (port->sensor != HEAVE_MRU) {
        reading.value = (fields[port->field] - port->zero) / port->scale;
        return reading;
    }
    reading.value = fields[MRU_HEAVE], reading.rate = fields[MRU_HEAVE_RATE];
    reading.roll = fields[MRU_ROLL], reading.pitch = fields[MRU_PITCH], reading.status = fields[MRU_STATUS];
    reading.sigma = fields[MRU_HEAVE_SIGMA], reading.rate_sigma = fields[MRU_HEAVE_RATE_SIGMA];
    return reading;
}

static HeaveWinch winch_of(const Instance *instance, const double *message)
{
    const double *fields = message + 1;
    const HeaveWinch winch = {1, time_of(instance, message[0]), fields[WINCH_ENCODER_PAYOUT], fields[WINCH_ENCODER_PAYOUT_RATE],
                              fields[WINCH_BRAKE] != 0.0, (int)fields[WINCH_FAULT], (int)fields[WINCH_LIMITS_HIT],
                              (int)fields[WINCH_COMMAND_SEQUENCE]};
    return winch;
}

static void put_out(Instance *instance)
{
    double *values = instance->values;
    const HeaveOrder *order = &instance->order;
    values[winch_command_sequence] = order->sequence;
    values[winch_command_payout] = order->payout;
    values[winch_command_payout_rate] = order->rate;
    values[winch_command_brake] = order->brake;
    values[winch_command_mean_payout] = order->mean_payout;
    values[controller_state_authority] = order->authority;
    values[controller_state_depth_set_point] = order->depth_set_point;
    values[winch_command_header_stamp] = values[controller_state_header_stamp] = time_of(instance, -1.0);
    values[winch_command_count]++;
    values[controller_state_count]++;
}

/* Do a tick; return 0 where more messages came than have variables. */
static int do_tick(Instance *instance)
{
    HeaveReading readings[MOST];
    HeaveWinch winch = {0};
    int count = 0;
    instance->done++;
    for (int port = 0; port < COUNT; port++) {
        const Port *of = &PORTS[port];
        const double *first = instance->values + of->counter + 1;
        const int came = news(instance, port);
        if (of->sensor == HEAVE_ENCODER) {
            if (came) winch = winch_of(instance, first);
            continue;
        }
        if (came > of->slots || count + came > MOST) return 0;
        for (int slot = 0; slot < came; slot++) readings[count++] = reading_of(instance, of, first + slot * (1 + of->width));
    }
    heave_controller_step(instance->controller, readings, count, &winch, &instance->order);
    put_out(instance);
    return 1;
}

/* Start values: nobody counts, and there are no stamps, at the inputs. */
static void set_start(Instance *instance)
{
    memset(instance->values, 0, sizeof instance->values);
    for (int port = 0; port < COUNT; port++) {
        double *message = instance->values + PORTS[port].counter;
        *message++ = -1.0;
        for (int slot = 0; slot < PORTS[port].slots; slot++, message += 1 + PORTS[port].width) *message = -1.0;
    }
}

static void begin(Instance *instance)
{
    heave_controller_begin(instance->controller);
    instance->done = 0;
    for (int port = 0; port < COUNT; port++) {
        double *counter = instance->values + PORTS[port].counter;
        instance->seen[port] = 0;
        if (*counter > 0.0) *counter = 0.0;
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
    instance->controller = functions->allocateMemory(1, heave_controller_size());
    if (!instance->controller) {
        functions->freeMemory(instance);
        return NULL;
    }
    set_start(instance);
    begin(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component c)
{
    Instance *instance = c;
    if (!instance) return;
    instance->free_memory(instance->controller);
    instance->free_memory(instance);
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
    while (instance->done < end)
        if (!do_tick(instance)) return fmi2Error;
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
        value[i] = instance->done == 0 ? "" : MODES[instance->order.mode];
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
