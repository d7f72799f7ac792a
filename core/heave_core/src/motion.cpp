// The mean payout: where compensation works about, and how it goes to another depth. The loop's own answer to it is known
// exactly, as it is our command: by linearity x' = A x + B u_mean, which estimator and laws need not deal with.
#include "laws.h"

namespace heave {

// A halt takes its deceleration, without the ease of a move; where a move has arrived the last fraction of a millimetre is
// not worth a motion. Returns whether a halt has ended.
bool advance_mean(MeanPayout &mean) {
    Move &move = mean.move;
    const double before = move.rate, dt = mean.tick_period;
    const bool halts = int(move.kind) == HALT;
    advance_move(move, dt, mean.jerk_time);
    if (halts) {
        move.slope = move.rate == 0.0 ? 0.0 : (move.rate - before) / dt;
        if (move.rate == 0.0) move.kind = STAND;
    } else if (int(move.kind) == NONE) return false;
    mean.payout += 0.5 * (before + move.rate) * dt;
    return halts && int(move.kind) == STAND;
}

// Ticks of a move until it has arrived, `longest` at most: it is played ahead.
int ticks_to_go(MeanPayout mean, int longest) {
    int ticks = 0;
    for (; ticks < longest && is_moving(mean.move); ticks++) advance_mean(mean);
    return ticks;
}

void advance_state(const double *A, const double *B, int states, double command, double *state) {
    double x[STATES];
    for (int i = 0; i < states; i++) x[i] = dot(states, A + i * states, state) + B[i] * command;
    std::copy(x, x + states, state);
}

// A tick in which `command` was the mean payout's share; a brake holds the payouts. Returns what of them moved.
int advance_motion(const double *A, const double *B, int states, double command, bool is_braked, MeanMotion &motion) {
    advance_state(A, B, states, command, motion.state);
    if (is_braked) return 0;
    const auto moves = [](const MeanPayout &mean) { return int(mean.move.kind) != NONE && int(mean.move.kind) != STAND; };
    int moved = moves(motion.mean) ? MEAN_MOVED : 0;
    if (moves(motion.left_over)) moved += LEFT_OVER_MOVED;
    if (moves(motion.carried)) moved += CARRIED_MOVED;
    if (advance_mean(motion.mean)) moved += HALT_ENDED;
    advance_mean(motion.left_over);
    advance_mean(motion.carried);
    return moved;
}

}  // namespace heave
