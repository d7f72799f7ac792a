// Authority by the residual that is predicted. Under an authority A the unit keeps (1 - A) of its motion with the winch
// locked, of variance F^2, and of the part A that is compensated errors leave a variance V F^2: those of the drum (its
// error over a second moves the unit by no more, but for its resonance), and all that is not known.
// They are independent of the sea, so that
//
//     J(A) = (1 - A)^2 + A^2 V,    least at A = 1 / (1 + V), where it is V / (1 + V).
//
// An error by a share d of the boom tip's motion leaves d^2: of a scale by d, of a delay by d / omega, of noise by d of the
// motion with the winch locked. Below d = 0.276 no less authority is worth 1 % of that motion, and what is identified is known
// better than that: 0.35 s at 8 s. So these have no term. Nor has the cable: a payout that is the boom tip's heave holds a
// unit still on any. What they leave all the same is seen by the unit, and by the waves that are compared.
#include "look.h"

namespace heave {

namespace {

double residual(double authority, double left) {
    return std::sqrt(square(1.0 - authority) + square(authority) * left);
}

// Mean square of a motion over that of its reference.
double square_of(const AmplitudeCheck &check) { return square(amplitude_of(check)) / std::max(reference_of(check), 1e-12); }

// Variance of the heave with the winch locked [m^2].
double free_variance(const GuardDesign &design, const GuardState &state) {
    return std::max(reference_of(state.locked), square(design.floor));
}

}  // namespace

// The largest error of late, over the motion with the winch locked of that time, stands for the next waves: authority does
// not follow them up and down.
void note_drum(const GuardDesign &design, GuardState &state, const Seen &seen) {
    const double kept = 1.0 - design.tick_period / design.window;
    state.drum_share = std::max(kept * state.drum_share, std::abs(seen.drum_error) / std::sqrt(free_variance(design, state)));
}

// What unit and depth sensor show to be left, V = (z^2 / z_off^2 - (1 - A)^2) / A^2, followed over the time in which authority
// may change. Without authority, or a depth sensor, nothing is shown.
void note_left(const GuardDesign &design, GuardState &state, const Seen &seen) {
    const double authority = seen.authority, share = std::min(design.tick_period / design.fade_time, 1.0);
    const bool is_read = state.measured.ticks * design.tick_period < design.detrend_time;
    const double kept = std::max(square_of(state.swing), square_of(state.depth)) - square(1.0 - authority);
    const double left = authority > 0.0 && is_read ? clip(kept / square(authority), 0.0, design.unshown) : design.unshown;
    const double before = authority > 0.0 ? std::min(state.shown_left, design.unshown) : design.unshown;
    state.shown_left = before + share * (left - before);
}

// Less than what the winch's limits allow is taken only where it is worth it. What is not known leaves no more than the unit
// shows: a sea that is predicted badly, under which it hardly moves, is compensated.
void predict_residual(const GuardDesign &design, const GuardState &state, const Seen &seen, Verdict &verdict) {
    const double allowed = verdict.allowed = design.keeps_limits != 0.0 ? verdict.authority : verdict.usual_authority;
    verdict.by_drum = 0.5 * square(state.drum_share);
    const double left = verdict.by_drum + std::min(seen.unknown, state.shown_left);
    const double best = std::min(allowed, 1.0 / (1.0 + left));
    const bool is_worth_it = residual(allowed, left) - residual(best, left) > design.worth;
    verdict.best_authority = is_worth_it ? best : allowed;
    verdict.residual = residual(verdict.best_authority, left);
}

// Under an authority A the unit moves as (1 - A) free, and the drum as A tip: the A that unit and drum are nearest to, by the
// energy of a swing, <x, y> = x y + a x' y'. Of a unit that rests in a resonance it is 1, below a locked winch 0.
void show_authority(const GuardDesign &design, const Seen &seen, Verdict &verdict) {
    const auto product = [&](const Motion &one, const Motion &other) {
        return one.heave * other.heave + design.inertia * one.rate * other.rate;
    };
    const Motion free{seen.free, seen.free_rate}, tip{seen.tip, seen.tip_rate}, drum{seen.payout, seen.payout_rate};
    const Motion compensated{seen.free - seen.unit, seen.free_rate - seen.unit_rate};
    const double whole = product(free, free) + product(tip, tip);
    verdict.shown = whole > 0.0 ? clip((product(compensated, free) + product(drum, tip)) / whole, 0.0, 1.0) : 0.0;
}

// V by the waves that were compared.
double measured_residual(const Seen &seen, const Verdict &verdict) {
    const double kept = square(verdict.unit_sigma / verdict.free_sigma) - square(1.0 - seen.authority);
    return std::max(kept, 0.0) / square(seen.authority);
}

}  // namespace heave
