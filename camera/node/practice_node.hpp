#pragma once

#include <multireach/practice_scene_t.hpp>
#include <optional>
#include <vector>

#include "camera/rendering/ball_renderer.hpp"
#include "camera/rendering/tag_renderer.hpp"
#include "imaging/image_codec.hpp"
#include "imaging/side.hpp"
#include "imaging/stereo_rig.hpp"
#include "kinematics/chain.hpp"
#include "runtime/node.hpp"

namespace multireach {

/// The rendered cameras of a practice: they see what the newest PRACTICE_SCENE says, a ball in the simulated robot's
/// hand where ROBOT_STATE has it. Publishes STEREO_IMAGES, and TARGET_TRUTH for the ball.
class PracticeNode : public Node {
 public:
  struct Options {
    StereoRig rig;  ///< of the cameras that are to be calibrated: the truth
    int64_t rate_hz = 15;
    int board_columns = 9, board_rows = 6;  ///< inner corners
    double square_m = 0.025;
    SceneOptions scene{.seed = 5, .wall_distance_m = 0.8, .distractors = 0, .noise_grey_levels = 1};
  };
  /// `utime`: of the first pair, microseconds.
  PracticeNode(const Chain& chain, const Options& options, int64_t utime);

  std::string name() const override { return "camera"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return next_us_; }
  int64_t tick_period_us() const override { return 1000000 / options_.rate_hz; }
  LateTicks late_ticks() const override { return LateTicks::kSkip; }
  void skip_ticks(int64_t ticks) override { next_us_ += ticks * tick_period_us(); }
  void tick(Outbox& out) override;
  std::string state() const override;

 private:
  /// The ball's position in W; nothing where there is none.
  std::optional<Eigen::Vector3d> ball() const;
  cv::Mat image(Side side, const std::optional<Eigen::Vector3d>& p_WB);

  Chain chain_;
  Options options_;
  int64_t next_us_, sequence_ = 0;
  practice_scene_t scene_{};
  std::optional<Eigen::Isometry3d> X_WH_;
  std::vector<BallRenderer> balls_;   // left, right
  std::vector<TagRenderer> boards_;   // likewise
  std::array<cv::Mat, 2> exposed_{};  // of the board at rest; empty: not rendered yet
  ImageCodec codec_;
};

}  // namespace multireach
