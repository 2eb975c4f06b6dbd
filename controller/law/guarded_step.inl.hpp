// Included inside a namespace; see numeric/sine_cosine.inl.hpp. The guarded law's integration step, written once for a
// single arm and for batches: the same operations in the same order, so that results are bit-identical.
// docs/guarantees.md explains the purpose of each part.

/// The integration step of the arms that `Arms` gives access to: one arm (law/guarded_step.cpp) or the lanes of a block
/// (batch/guarded_batch.cpp).
///
/// Numbers of an arm are `Scalar`s (double, or Lanes), booleans are `Mask`s. Values needed at both theta and theta_T
/// are in `kRegisters` registers of type `Register`: for one arm, both share one register; for several arms, theta and
/// theta_T have one register each. now() extracts the value at theta, goal() the value at theta_T.
template <class Arms>
class GuardedStep {
  using Tuning = GuardedTuning;
  using Scalar = typename Arms::Scalar;
  using Mask = typename Arms::Mask;
  using Register = typename Arms::Register;
  static constexpr int kRows = Arms::kRows, kRegisters = Arms::kRegisters;
  static constexpr int kGoal = kRegisters - 1;  // index of theta_T's register
  static constexpr size_t kCapacity = Arms::kCapacity;
  using Task = std::array<Scalar, kRows>;
  using Joints = std::array<Scalar, kCapacity>;
  /// The rows of the task's Jacobian, for each register.
  using Rows = typename Arms::Rows;
  using RegisterJoints = std::array<std::array<Register, kCapacity>, kRegisters>;
  using RegisterTasks = std::array<std::array<Register, kRows>, kRegisters>;
  using Solve = SmallSolve<kRows, Scalar>;

 public:
  explicit GuardedStep(const Arms& arms) : arms_(arms), settings_(arms.settings()) {}

  /// One integration step. Returns the number of linear systems solved for the joint bounds.
  [[gnu::always_inline]] int step() {
    Rows J;
    Task error, residual;
    arms_.task(J, error, residual);
    const Scalar residual2 = dot(residual, residual), gamma = arms_.gamma();
    const Scalar damping = target_damping(residual2);
    const Wanted wanted = attractors(J, error, self_motion());
    const auto y = multipliers(J, wanted, residual, gamma, damping);
    Unbounded free = unbounded(J, wanted, y, gamma);
    int systems = 0;
    if (arms_.obstructs(free.velocity)) {
      systems = arms_.avoid(J, gamma, wanted.joints, wanted.hand, free.lower, free.upper, free.velocity);
    } else if (any(free.bounded)) {
      const auto& rows = Arms::now_rows(J, n());
      const auto& joints = Arms::now_joints(wanted.joints, n());
      const BoxQp<kRows, kCapacity, Scalar> program{n(),         gamma,      rows,       joints,
                                                    wanted.hand, free.lower, free.upper, settings_.mobility};
      Task multiplier;
      for (int m = 0; m < kRows; ++m) multiplier[m] = Arms::now(y[0][m]);
      systems = program.solve(multiplier, free.bounded, free.velocity);
    }
    if (arms_.target_fixed()) {
      free.target_step.fill(0);
    } else if (any(free.blocked)) {
      unblock(arms_, free.blocked, J, residual, damping, self_motion(), free.target_step, free.largest);
    }
    const Scalar speed2 = integrate(J, free);
    const Mask slow = speed2 < Tuning::kStalledBelow * Tuning::kStalledBelow * free.pull2;
    arms_.set_slow(slow);
    schedule_gamma(slow, square_root(wanted.distance2), square_root(dot(error, error)), gamma);
    check_target_progress(square_root(residual2));
    arms_.update_kinematics();
    return systems;
  }

  /// Which arms need another theta_T: those that have moved away from theta_T, and those whose theta_T is stuck short
  /// of the target. The latter are excluded when the last search found the target unreachable and the target has not
  /// changed since (`target_unchanged`). Call this after step().
  Mask needs_search(Mask target_unchanged) {
    auto& progress = arms_.progress();
    const Scalar steps = get(progress.steps);
    const Mask due = steps >= get(progress.no_search_before);
    if (!any(due)) return due;
    Scalar distance2 = 0;
    for (int i = 0; i < n(); ++i) {
      const Scalar apart = arms_.theta_target(i) - arms_.theta(i);
      distance2 += apart * apart;
    }
    const Scalar distance = square_root(distance2), before = get(progress.distance_at_choice);
    const Scalar least = where(due, lesser(before, distance), before);
    put(least, progress.distance_at_choice);
    const Mask unreachable = flag(progress.unreachable);
    const Mask strayed = distance > Tuning::kStrayed * least + Tuning::kStrayedBy;
    const Mask known = unreachable & target_unchanged;
    const Mask needed = due & (strayed | (flag(progress.stuck) & !known));
    const Mask rest = due & !needed;
    put(where(rest, steps + settings_.pace.look_again, get(progress.no_search_before)), progress.no_search_before);
    const Mask reached = rest & (get(progress.residual) < Tuning::kReached);
    put_flag(unreachable & !reached, progress.unreachable);
    return needed;
  }

 private:
  /// The velocities that the attractors request, before coherence.
  struct Wanted {
    /// Joint velocity from the joints' attractor, Eqs. (19), (20); step of theta_T towards theta.
    RegisterJoints joints;
    Task hand;         ///< hand velocity from the hand's attractor, Eqs. (21), (22)
    Scalar distance2;  ///< |theta_T - theta|^2
  };

  /// The coherent step without bounds, and the bounds.
  struct Unbounded {
    Joints velocity, target_step;  ///< velocity of theta; step of theta_T
    Joints lower, upper;           ///< bounds of the velocity
    Mask bounded, blocked;  ///< whether the velocity violates its bounds; whether theta_T would leave the joint limits
    Scalar largest;         ///< largest absolute element of target_step
    Scalar pull2;           ///< squared equilibrium speed of the joints' attractor alone, within the bounds
  };

  int n() const { return arms_.size(); }
  template <class Number>
  Scalar get(const Number& number) const {
    return arms_.get(number);
  }
  template <class Number>
  void put(Scalar value, Number& number) const {
    arms_.put(value, number);
  }
  template <class Number>
  void put_flag(Mask value, Number& number) const {
    arms_.put(where(value, Scalar(1), Scalar(0)), number);
  }
  template <class Number>
  Mask flag(const Number& number) const {
    return get(number) > 0;
  }
  static Scalar goal(const Rows& J, int m, int i) { return Arms::goal(J[kGoal][m][i]); }
  static Scalar now(const Rows& J, int m, int i) { return Arms::now(J[0][m][i]); }

  static Scalar dot(const Task& a, const Task& b) {
    Scalar sum = 0;
    for (int m = 0; m < kRows; ++m) sum += a[m] * b[m];
    return sum;
  }

  /// Levenberg-Marquardt damping of theta_T's step, m^2. It is large compared with small singular values while the
  /// target is far, and decreases with the square of the error, so that stretched configurations are reached exactly.
  /// It grows while the error does not decrease, so that theta_T converges for an unreachable target.
  [[gnu::always_inline]] Scalar target_damping(Scalar residual2) {
    auto& progress = arms_.progress();
    const double reach2 = settings_.reach * settings_.reach;
    const Scalar before = get(progress.residual), factor = get(progress.damping_factor);
    const Mask worse = arms_.target_rests() & (residual2 > before * before) &
                       (residual2 > Scalar(Tuning::kReached * Tuning::kReached));
    const Scalar next = where(worse, lesser(factor * settings_.pace.damping_rise, Tuning::kMaxDampingFactor),
                              greater(1, factor * settings_.pace.damping_fall));
    put(next, progress.damping_factor);
    return next *
           (Tuning::kFarDamping * lesser(reach2, Tuning::kNearDamping * residual2) + Tuning::kMinDamping * reach2);
  }

  /// The share of theta - theta_T that theta_T makes up in a step, where that does not move its end effector. None
  /// while something is in the arm's way: the two would drive each other along it.
  Scalar self_motion() {
    if (arms_.obstructed()) return 0;
    return settings_.pace.self_motion / get(arms_.progress().damping_factor);
  }

  [[gnu::always_inline]] Wanted attractors(const Rows& J, const Task& error, Scalar self_motion) const {
    const double alpha = settings_.gains.alpha, beta = settings_.gains.beta;
    Wanted wanted;
    Joints drift;
    const bool moves = arms_.target_moves();
    if (moves) feed_forward(arms_, J, drift);
    wanted.distance2 = 0;
    for (int i = 0; i < n(); ++i) {
      const Scalar before = arms_.velocity(i), apart = arms_.theta_target(i) - arms_.theta(i);
      wanted.distance2 += apart * apart;
      Scalar change = beta * apart - before;
      if constexpr (Arms::kDisturbed) {
        change = (moves ? drift[i] : Scalar(0)) - before + beta * apart + arms_.disturbance(i);
      }
      const Scalar velocity = before + alpha * change;
      wanted.joints[0][i] = Arms::template in_register<0>(velocity, -self_motion * apart);
      wanted.joints[kGoal][i] = Arms::template in_register<kGoal>(velocity, -self_motion * apart);
    }
    for (int m = 0; m < kRows; ++m) {
      Scalar ahead = 0;
      if (moves) {
        for (int i = 0; i < n(); ++i) ahead += now(J, m, i) * drift[i];
      }
      const Scalar before = arms_.hand_velocity(m);
      wanted.hand[m] = before + alpha * (ahead - before + beta * error[m]);
    }
    return wanted;
  }

  /// Feed-forward: the joint velocity with which theta_T follows a moving target, damped at singularities.
  [[gnu::noinline]] static void feed_forward(Arms arms, const Rows& J, Joints& drift) {
    const int n = arms.size();
    const double reach = arms.settings().reach;
    const auto& mobility = arms.settings().mobility;
    typename Solve::Matrix A;
    Task b;
    for (int r = 0; r < kRows; ++r) {
      b[r] = r < 3 ? arms.target_velocity(r) : Scalar(0);
      for (int c = 0; c <= r; ++c) {
        A[r][c] = r == c ? Scalar(Tuning::kFarDamping * reach * reach) : Scalar(0);
        for (int i = 0; i < n; ++i) A[r][c] += goal(J, r, i) * mobility[i] * goal(J, c, i);
      }
    }
    const Task y = Solve(A).solve(b);
    Scalar largest = 0;
    for (int i = 0; i < n; ++i) {
      drift[i] = 0;
      for (int m = 0; m < kRows; ++m) drift[i] += goal(J, m, i) * y[m];
      drift[i] *= mobility[i];
      largest = greater(largest, absolute(drift[i]));
    }
    const double most = arms.settings().pace.max_target_step;
    const Mask fast = largest > most;
    for (int i = 0; i < n; ++i) {
      drift[i] = where(fast, drift[i] * (most / largest), drift[i]);
    }
  }

  /// Solves both M x M systems: at theta, the coherence of both attractors, Eq. (23) with W_x = I; at theta_T, its step
  /// towards the target, Eq. (27) with damping.
  [[gnu::always_inline]] RegisterTasks multipliers(const Rows& J, const Wanted& wanted, const Task& residual,
                                                   Scalar gamma, Scalar damping) const {
    RegisterTasks y;
    y[0] = multiplier<0>(J, wanted, residual, gamma, damping);
    if constexpr (kGoal != 0) y[kGoal] = multiplier<kGoal>(J, wanted, residual, gamma, damping);
    return y;
  }

  template <int c>
  [[gnu::always_inline]] std::array<Register, kRows> multiplier(const Rows& J, const Wanted& wanted,
                                                                const Task& residual, Scalar gamma,
                                                                Scalar damping) const {
    const Register diagonal = Arms::template in_register<c>(1, damping);
    typename SmallSolve<kRows, Register>::Matrix A;
    std::array<Register, kRows> b;
    for (int m = 0; m < kRows; ++m) {
      Register covered{};
      for (int i = 0; i < n(); ++i) covered += J[c][m][i] * wanted.joints[c][i];
      b[m] = Arms::template in_register<c>(wanted.hand[m], residual[m]) - covered;
    }
    for (int r = 0; r < kRows; ++r) {
      for (int k = 0; k <= r; ++k) {
        Register sum{};
        for (int i = 0; i < n(); ++i) sum += J[c][r][i] * settings_.mobility[i] * J[c][k][i];
        A[r][k] = Arms::template weighted<c>(gamma, sum);
        if (r == k) A[r][k] += diagonal;
      }
    }
    return SmallSolve<kRows, Register>(A).solve(b);
  }

  /// The coherent velocity or step of joint i, from the solution of one register's system.
  template <int c>
  [[gnu::always_inline]] Register coherent(const Rows& J, const Wanted& wanted, const RegisterTasks& y, Scalar gamma,
                                           int i) const {
    Register sum{};
    for (int m = 0; m < kRows; ++m) sum += J[c][m][i] * y[c][m];
    return wanted.joints[c][i] + Arms::template weighted<c>(gamma, sum * settings_.mobility[i]);
  }

  [[gnu::always_inline]] Unbounded unbounded(const Rows& J, const Wanted& wanted, const RegisterTasks& y,
                                             Scalar gamma) const {
    const double beta = settings_.gains.beta;
    Unbounded free;
    free.bounded = free.blocked = Arms::none();
    free.largest = free.pull2 = 0;
    for (int i = 0; i < n(); ++i) {
      const Register result = coherent<0>(J, wanted, y, gamma, i);
      const Scalar velocity = Arms::now(result);
      const Scalar target_step = Arms::goal(kGoal == 0 ? result : coherent<kGoal>(J, wanted, y, gamma, i));
      const Scalar theta = arms_.theta(i), theta_target = arms_.theta_target(i), next = theta_target + target_step;
      const auto bounds = velocity_bounds(theta, arms_.velocity(i), settings_.lower[i], settings_.upper[i],
                                          settings_.speed[i], settings_.acceleration[i], settings_.barrier_rate);
      free.lower[i] = bounds.lower;
      free.upper[i] = bounds.upper;
      free.velocity[i] = velocity;
      free.target_step[i] = target_step;
      free.bounded = free.bounded | (velocity < free.lower[i]) | (velocity > free.upper[i]);
      free.blocked = free.blocked | (next < settings_.lower[i]) | (next > settings_.upper[i]);
      free.largest = greater(free.largest, absolute(target_step));
      const Scalar pull = clamped(beta * (theta_target - theta), free.lower[i], free.upper[i]);
      free.pull2 += pull * pull;
    }
    return free;
  }

  /// Computes the step of theta_T again, for the arms in `blocked`, without the joints that would leave their limits.
  /// Writes the step and its largest element.
  [[gnu::noinline]] static void unblock(Arms arms, Mask blocked, const Rows& J, const Task& residual, Scalar damping,
                                        Scalar self_motion, Joints& step, Scalar& largest) {
    const int n = arms.size();
    const GuardedSettings& settings = arms.settings();
    std::array<Mask, kCapacity> frozen;
    for (int i = 0; i < n; ++i) frozen[i] = Arms::none();
    Mask active = blocked;
    for (int round = 0; round < n; ++round) {
      Mask changed = Arms::none();
      for (int i = 0; i < n; ++i) {
        const Scalar at = arms.theta_target(i);
        const Mask outward = leads_out(at, Scalar(settings.lower[i]), Scalar(settings.upper[i]), step[i]);
        const Mask more = active & outward & !frozen[i];
        frozen[i] = frozen[i] | more;
        changed = changed | more;
      }
      active = changed;
      if (!any(active)) break;
      typename Solve::Matrix A;
      Task b = residual;
      for (int r = 0; r < kRows; ++r) {
        for (int c = 0; c <= r; ++c) A[r][c] = r == c ? damping : Scalar(0);
      }
      for (int i = 0; i < n; ++i) {
        const Scalar apart = arms.theta_target(i) - arms.theta(i);
        for (int r = 0; r < kRows; ++r) {
          for (int c = 0; c <= r; ++c)
            A[r][c] += where(frozen[i], 0, goal(J, r, i) * settings.mobility[i] * goal(J, c, i));
          b[r] = where(frozen[i], b[r], b[r] + goal(J, r, i) * self_motion * apart);
        }
      }
      const Task y = Solve(A).solve(b);
      for (int i = 0; i < n; ++i) {
        Scalar next = -self_motion * (arms.theta_target(i) - arms.theta(i));
        for (int m = 0; m < kRows; ++m) next += goal(J, m, i) * settings.mobility[i] * y[m];
        step[i] = where(active, where(frozen[i], 0, next), step[i]);
      }
    }
    largest = 0;
    for (int i = 0; i < n; ++i) largest = greater(largest, absolute(step[i]));
  }

  /// Eqs. (24), (25), and the step of theta_T, at most max_target_step. Returns the squared joint speed.
  [[gnu::always_inline]] Scalar integrate(const Rows& J, const Unbounded& free) {
    const Scalar shrink =
        where(free.largest > settings_.pace.max_target_step, settings_.pace.max_target_step / free.largest, 1);
    for (int m = 0; m < kRows; ++m) {
      Scalar sum = 0;
      for (int i = 0; i < n(); ++i) sum += now(J, m, i) * free.velocity[i];
      arms_.set_hand_velocity(m, sum);
    }
    Scalar speed2 = 0;
    for (int i = 0; i < n(); ++i) {
      const Scalar lower = settings_.lower[i], upper = settings_.upper[i], theta = arms_.theta(i);
      speed2 += free.velocity[i] * free.velocity[i];
      const Scalar next = theta + free.velocity[i];
      // The bounds exclude positions beyond the limit, except by rounding or when the arm was outside already.
      const Mask inside = (theta >= lower) & (theta <= upper);
      arms_.set_joint(i, free.velocity[i], where(inside, clamped(next, lower, upper), next),
                      clamped(arms_.theta_target(i) + shrink * free.target_step[i], lower, upper));
    }
    return speed2;
  }

  /// Decreases gamma while the arm stalls or has not approached theta_T for long. gamma increases again only when the
  /// arm is clearly nearer to theta_T than where it stalled, up to a ceiling that decreases when the reach takes long.
  /// So either the arm arrives, or gamma goes to 0 and the joints' attractor alone brings the arm to theta_T.
  [[gnu::always_inline]] void schedule_gamma(Mask slow, Scalar distance, Scalar hand_error, Scalar gamma) {
    auto& progress = arms_.progress();
    const Scalar never = std::numeric_limits<double>::infinity(), most = get(progress.gamma_max);
    // Far from theta_T the hand may stand beside the target for ever: the joints' pull holds it there against gamma.
    const Mask there = (hand_error < Tuning::kAtTarget * settings_.reach) & (distance < Tuning::kAtPosture);
    const Mask moved = arms_.target_moved_away();  // counts as a new target: restart the waiting time
    Scalar best = where(there, never, get(progress.best_distance));
    Scalar stalled = where(there, never, get(progress.stalled_distance));
    Scalar idle = where(there, 0, get(progress.idle_steps));
    Scalar waited = where(there | moved, 0, get(progress.waited_steps));
    Scalar ceiling = where(there | moved, most, get(progress.gamma_ceiling));

    const Mask nearer = distance < Tuning::kNearer * best;
    best = where(nearer, distance, best);
    idle = where(nearer, 0, where(idle <= settings_.pace.idle, idle + 1, idle));
    const Mask waits = waited < settings_.pace.wait;
    waited = where(waits, waited + 1, waited);
    ceiling = where((!waits) & (ceiling > Tuning::kMinGamma), ceiling * settings_.pace.ceiling_decay, ceiling);
    const Mask stalls = slow | (idle > settings_.pace.idle);
    const Mask falls = stalls & (gamma > Tuning::kMinGamma);
    const Mask rises = (!stalls) & (distance < Tuning::kPassed * stalled);
    gamma = where(falls, gamma * settings_.pace.gamma_decay, where(rises, gamma * settings_.pace.gamma_rise, gamma));
    stalled = where(stalls, lesser(stalled, distance), stalled);
    arms_.set_gamma(lesser(gamma, ceiling));
    put(best, progress.best_distance);
    put(stalled, progress.stalled_distance);
    put(idle, progress.idle_steps);
    put(waited, progress.waited_steps);
    put(ceiling, progress.gamma_ceiling);
  }

  /// Every check_every steps: theta_T is stuck when its distance to the target does not decrease, and exceeds the lag
  /// that a moving target explains.
  [[gnu::always_inline]] void check_target_progress(Scalar residual) {
    auto& progress = arms_.progress();
    put(get(progress.steps) + 1, progress.steps);
    put(residual, progress.residual);
    const Scalar left = get(progress.steps_to_check) - 1;
    const Mask due = left <= 0;
    put(where(due, Scalar(settings_.pace.check_every), left), progress.steps_to_check);
    if (!any(due)) return;
    const Scalar checked = get(progress.checked_residual);
    const Mask stuck = (residual > greater(Tuning::kReached, arms_.target_moved_since_check())) &
                       (residual > Tuning::kNoProgress * checked);
    put_flag((due & stuck) | ((!due) & flag(progress.stuck)), progress.stuck);
    put(where(due, residual, checked), progress.checked_residual);
  }

  Arms arms_;  // an accessor; it does not own the state
  const GuardedSettings& settings_;
};
