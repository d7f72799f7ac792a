// What the sea that is seen now asks of the winch, and so what share of it a law may be given: speed and acceleration of
// the boom tip over the last waves and within the present group of waves.
#include "look.h"

namespace heave {

namespace {

// A sea seen for the first time grows: the later half of it has several times the energy of the earlier half.
bool grows(const GuardDesign &design, const WinchDemand &demand) {
    if (demand.ticks + 1.0 > design.first_look) return false;
    const int half = (int(demand.ticks) + 1) / 2;
    const double early = demand.energies[half / int(design.knot_ticks)];
    return demand.energy - early > design.growing * early;
}

void note_energy(const GuardDesign &design, WinchDemand &demand, double tip_rate) {
    if (demand.ticks >= design.first_look) return;
    demand.ticks += 1.0;
    demand.energy += square(tip_rate);
    const int ticks = int(demand.ticks), knot = int(design.knot_ticks);
    if (ticks % knot == 0) demand.energies[ticks / knot] = demand.energy;
}

double sigma_of(const RunningSigma &sigma) { return std::sqrt(sigma.variance); }

// Significant amplitude over the limits, the larger of speed and acceleration; that of waves which are all of one height
// is no more than the highest of them.
double over(const GuardDesign &design, const WinchDemand &demand, double rate, double acceleration) {
    const double speed = std::min(design.significant * rate, demand.highest_rate);
    const double most = std::min(design.significant * acceleration, demand.highest_acceleration);
    return std::max(speed / design.usual_speed, most / design.acceleration);
}

}  // namespace

void observe_sea(const GuardDesign &design, WinchDemand &demand, double tip_rate) {
    const double dt = design.tick_period, waves = dt / design.window, group = dt / design.group_time;
    const double decay = std::exp(-dt / design.highest_time);
    note_energy(design, demand, tip_rate);
    add(demand.rate, tip_rate, waves, design.slow_mean);
    add(demand.group_rate, tip_rate, group, design.slow_mean);
    demand.highest_rate = std::max(std::abs(tip_rate), decay * demand.highest_rate);
    if (!std::isnan(demand.last_rate)) {
        const double acceleration = (tip_rate - demand.last_rate) / dt;
        add(demand.acceleration, acceleration, waves, design.slow_mean);
        add(demand.group_acceleration, acceleration, group, design.slow_mean);
        demand.highest_acceleration = std::max(std::abs(acceleration), decay * demand.highest_acceleration);
    }
    demand.last_rate = tip_rate;
}

void judge_demand(const GuardDesign &design, const WinchDemand &demand, Verdict &verdict) {
    const double rate = sigma_of(demand.rate), acceleration = sigma_of(demand.acceleration);
    const double group_rate = sigma_of(demand.group_rate), group_acceleration = sigma_of(demand.group_acceleration);
    const bool is_growing = grows(design, demand);
    verdict.demand = verdict.coming = over(design, demand, rate, acceleration);
    // as high as its last waves
    if (is_growing)
        verdict.coming = over(design, demand, std::max(rate, group_rate), std::max(acceleration, group_acceleration));
    verdict.authority = verdict.coming > 0.0 ? std::min(1.0, design.largest_demand / verdict.coming) : 1.0;

    // peaks take up no more than a share of the limits
    const double group_peak = is_growing ? design.growing_peak : design.group_peak;
    const double speed = std::max(design.peak * rate, group_peak * group_rate);
    const double most = std::max(design.peak * acceleration, group_peak * group_acceleration);
    const double peak =
        std::max(design.effort_speed * speed / design.usual_speed, design.effort_acceleration * most / design.acceleration);
    verdict.usual_authority = peak > 0.0 ? std::min(1.0, design.limit_use / peak) : 1.0;
}

}  // namespace heave
