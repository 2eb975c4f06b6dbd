#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multireach::vision {

/// A position with its uncertainty.
struct PositionEstimate {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, in W
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
  /// m^2, of errors that are the same from image to image, as those of a blob's centroid: a mean over many images does
  /// not make them smaller. Part of `covariance` in a measurement, not in a track's estimate. Taken as zero for
  /// contours and corners.
  Eigen::Matrix3d bias_covariance = Eigen::Matrix3d::Zero();

  /// Whether the measurement is taken to have no bias.
  bool unbiased() const { return bias_covariance.isZero(0); }
};

/// Tracks one target over time: a Kalman filter of position and velocity on the capture times, with white-noise
/// acceleration (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001,
/// Sect. 6.2). The process noise is that of a target at rest unless the innovation is too large for it; then it is
/// raised, for that step, until the innovation fits. Where the target is measured poorly (Jump::kNever), it is at least
/// that of a target that is not seen, for such measurements do not tell that it rests. The bias of measurements is
/// considered, not estimated (Schmidt, Application of state-space methods to navigation problems, Advances in Control
/// Systems 3, 1966), and taken as the same throughout a track. A biased measurement is weighted as if its whole error
/// were white, for the bias does not repeat exactly; only the covariance of the result accounts for it. An unbiased one
/// has the weight that the bias leaves it. A match that is too far away even for the largest process noise is a jump,
/// accepted only when later matches confirm it: one less than `confirmations`, but at least two, where the target can
/// have got there at its speed, or at 3 m/s, from where it was seen last. Jump::kAtOnce accepts it without
/// confirmation.
class TargetTrack {
 public:
  struct Options {
    double min_process_noise_m2_s3 = 1e-4;      ///< spectral density of the acceleration, target at rest
    double max_process_noise_m2_s3 = 10;        ///< the same for a thrown target
    double coasting_process_noise_m2_s3 = 0.1;  ///< the same for a target that is not seen
    double gate = 4;        ///< largest innovation of this target, standard deviations; StereoTracker
                            ///< sets it to MatchOptions::max_prediction_sigmas
    int confirmations = 3;  ///< consecutive matches that confirm a jump
    double coast_s = 0.5;   ///< longest time without a match before the target is lost
    /// Largest standard deviation of the position before it is lost: root of the trace of the covariance without bias.
    double coast_sigma_m = 0.1;
  };
  enum class Status { kLost, kTracked, kCoasting };
  /// Whether a measurement outside the gate may be the target, that has jumped there: never, as where the target is
  /// measured poorly, if further ones confirm it, or at once.
  enum class Jump { kNever, kIfConfirmed, kAtOnce };
  /// Whether a match began a new motion: no; the target was lost before; it jumped, which further matches confirmed; or
  /// it jumped with Jump::kAtOnce.
  enum class Start { kNone, kFirst, kJump, kJumpAtOnce };

  /// Throws std::invalid_argument unless all options are positive (`coast_s` may be 0) and min_process_noise_m2_s3 <=
  /// coasting_process_noise_m2_s3 <= max_process_noise_m2_s3.
  explicit TargetTrack(const Options& options);

  /// Updates the track with the position measured at `utime` (microseconds), or with none. Returns false when the
  /// measurement was rejected: there was none, it was too far from the prediction, or `utime` is not after the last
  /// one. `elsewhere`: it was found not to be where the target is expected, and counts as outside the gate.
  bool update(int64_t utime, const std::optional<PositionEstimate>& seen, Jump jump = Jump::kIfConfirmed,
              bool elsewhere = false);
  /// The target is lost: the next match begins a new track.
  void lose();
  /// Ends the track if a pair at `utime` comes more than `coast_s`, and half a second, after the last match, as after a
  /// camera has stalled. To be called before a pair is searched.
  void expire(int64_t utime);
  /// Position predicted at `utime` with the largest process noise; nothing when the target is lost or `utime` is not
  /// after the last pair.
  std::optional<PositionEstimate> predicted(int64_t utime) const;
  /// The same for a target that keeps its motion, with the process noise of one that is not seen.
  std::optional<PositionEstimate> predicted_steady(int64_t utime) const;

  /// Whether the target can have got to a measured position by `utime`, at its speed or at 3 m/s, from where it was
  /// seen last, within the errors of the measurement, and the track's bias if it has none, along this way.
  bool is_near(int64_t utime, const PositionEstimate& seen) const;
  /// Whether a measured position is no jump, as update() would find. True where nothing is predicted.
  bool expects(int64_t utime, const PositionEstimate& seen) const;
  /// Whether the target was seen at most 0.12 s before.
  bool was_just_seen(int64_t utime) const;
  /// Whether a measured position may be that of the target after it has bounced off something at rest: it was tracked
  /// in the pair before, at most 0.12 s ago, and can have got there at 1.5 times its estimated speed plus two standard
  /// deviations, but at most at the larger of 3 m/s and its estimated speed. To be asked before update().
  bool may_bounce_to(int64_t utime, const PositionEstimate& seen) const;

  Status status() const { return status_; }
  /// Whether the last update began a new motion.
  Start start() const { return start_; }
  /// Whether there was a pair.
  bool begun() const { return begun_; }
  /// Time of the newest pair, microseconds.
  int64_t utime() const { return utime_; }
  /// Time of the last accepted match, microseconds; nothing before the first.
  std::optional<int64_t> last_seen_utime() const { return last_seen_utime_; }
  /// Where the target was at `utime`, by its motion since. Meaningless when lost.
  Eigen::Vector3d position_at(int64_t utime) const;
  /// Estimated position at utime(). Meaningless when lost.
  PositionEstimate estimate() const;
  /// The same at an earlier time, for the fastest changes of motion since.
  PositionEstimate estimate_before(int64_t utime) const;
  /// Status to report for a pair without a match. A pair that is older than utime() by more than `coast_s` is reported
  /// as lost.
  Status unseen_status(int64_t utime) const;
  Eigen::Vector3d velocity() const { return filter_.state.tail<3>(); }  ///< m/s, in W
  Eigen::Matrix3d velocity_covariance() const;                          ///< (m/s)^2

  /// The complete state. Times are relative to utime().
  std::vector<double> serialize() const;
  /// Restores a state that serialize() returned at `utime`. Returns false, and changes nothing, when `state` is not
  /// valid.
  [[nodiscard]] bool deserialize(int64_t utime, std::span<const double> state);

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Matrix63 = Eigen::Matrix<double, 6, 3>;

  /// Position and velocity (m, m/s) at one time, and the covariance of their noise. The bias of a measurement is the
  /// square root of its bias covariance times a vector u of three standard normal numbers, the same u throughout a
  /// track. The state is off by `bias_factor` * u (m, m/s), so bias adds `bias_factor` * `bias_factor`^T.
  struct Filter {
    Vector6 state = Vector6::Zero();
    Matrix6 covariance = Matrix6::Zero();
    Matrix63 bias_factor = Matrix63::Zero();

    PositionEstimate position() const;
  };

  std::optional<PositionEstimate> predicted_with(int64_t utime, double noise) const;
  Filter predict(double seconds, double noise) const;
  bool correct(double seconds, const PositionEstimate& seen, double least_noise);
  bool confirm(int64_t utime, const PositionEstimate& seen, bool at_once);
  double top_speed() const;
  bool can_reach(int64_t utime, const PositionEstimate& seen, double speed) const;
  void begin_at(const PositionEstimate& seen, const Eigen::Vector3d& velocity, double velocity_variance, Start start);

  Options options_;
  Status status_ = Status::kLost;
  int64_t utime_ = 0;
  bool begun_ = false;
  Start start_ = Start::kNone;  // a result of update(); no state
  std::optional<int64_t> last_seen_utime_;
  Filter filter_;
  // Number, time, position and its variance (trace of the covariance, m^2) of the latest matches outside the gate.
  int outliers_ = 0;
  int64_t outlier_utime_ = 0;
  Eigen::Vector3d outlier_ = Eigen::Vector3d::Zero();
  double outlier_variance_ = 0;
};

}  // namespace multireach::vision
