#include "camera/node/practice_node.hpp"

#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "camera/pairing/stereo_message.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

PracticeNode::PracticeNode(const Chain& chain, const Options& options, int64_t utime)
    : chain_(chain), options_(options), next_us_(utime) {
  const StereoRig& rig = options_.rig;
  const Card board = chessboard_card(options_.board_columns, options_.board_rows, options_.square_m);
  for (const bool right : {false, true}) {
    const CameraModel& camera = right ? rig.right : rig.left;
    const Eigen::Isometry3d X_WC = right ? rig.X_WL * rig.X_RL.inverse() : rig.X_WL;
    balls_.emplace_back(options_.scene, camera, X_WC, rig.X_WL);
    boards_.emplace_back(options_.scene, board, camera, X_WC, rig.X_WL);
  }
}

std::vector<std::string_view> PracticeNode::inputs() const {
  return {channel::kPracticeScene, channel::kRobotState};
}

Receipt PracticeNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kRobotState) {
    const auto state = decode_and_count<robot_state_t>(bytes);
    const auto theta = state ? from_fields(chain_, state->joint_name, state->joint_position) : std::nullopt;
    if (theta && theta->allFinite()) X_WH_ = chain_.pose(*theta);
    return {};
  }
  if (channel != channel::kPracticeScene) throw unknown_input(channel);
  const auto scene = decode_and_count<practice_scene_t>(bytes);
  const auto finite = [](const auto& values) {
    return std::ranges::all_of(values, [](double value) { return std::abs(value) < 100; });
  };
  if (!scene || !finite(scene->position_m) || !finite(scene->orientation_wxyz)) return {};
  scene_ = *scene;
  for (cv::Mat& image : exposed_) image.release();
  return {};
}

std::optional<Eigen::Vector3d> PracticeNode::ball() const {
  const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(scene_.position_m);
  if (scene_.kind == practice_scene_t::BALL) return position;
  if (scene_.kind == practice_scene_t::HELD && X_WH_) return *X_WH_ * position;
  return std::nullopt;
}

cv::Mat PracticeNode::image(Side side, const std::optional<Eigen::Vector3d>& p_WB) {
  const auto stream = static_cast<uint64_t>(2 * sequence_) + index(side);
  if (scene_.kind != practice_scene_t::BOARD) return balls_[index(side)].render(p_WB, stream);
  cv::Mat& exposed = exposed_[index(side)];
  const double* wxyz = scene_.orientation_wxyz;
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (exposed.empty() && q.norm() > 1e-6) {
    Eigen::Isometry3d X_LB = Eigen::Isometry3d::Identity();
    X_LB.linear() = q.normalized().toRotationMatrix();
    X_LB.translation() = Eigen::Map<const Eigen::Vector3d>(scene_.position_m);
    exposed = boards_[index(side)].exposed(options_.rig.X_WL * X_LB);
  }
  return exposed.empty() ? balls_[index(side)].render(std::nullopt, stream)
                         : boards_[index(side)].developed(exposed, stream);
}

void PracticeNode::tick(Outbox& out) {
  constexpr int kQuality = 90;
  const std::optional<Eigen::Vector3d> p_WB = ball();
  target_t truth{};
  truth.utime = truth.left_frame_utime = truth.right_frame_utime = next_us_;
  truth.sequence = truth.pair_sequence = sequence_;
  truth.name = "ball";
  truth.status = p_WB ? target_t::STATUS_TRACKED : target_t::STATUS_LOST;
  if (p_WB) Eigen::Map<Eigen::Vector3d>(truth.position_m) = *p_WB;
  send(out, channel::kTargetTruth, truth);
  std::array<Frame, 2> frames;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const cv::Mat pixels = image(side, p_WB);
    frames[index(side)] = {.utime = next_us_,
                           .width = pixels.cols,
                           .height = pixels.rows,
                           .row_stride = 0,
                           .pixelformat = image_t::PIXEL_FORMAT_MJPEG,
                           .data = codec_.encode_jpeg(pixels, kQuality)};
  }
  send(out, channel::kStereoImages, stereo_message(next_us_, std::move(frames[0]), std::move(frames[1]), sequence_++));
  next_us_ += tick_period_us();
}

std::string PracticeNode::state() const {
  switch (scene_.kind) {
    case practice_scene_t::BOARD:
      return "shows the chessboard";
    case practice_scene_t::BALL:
      return "shows the ball";
    case practice_scene_t::HELD:
      return X_WH_ ? "shows the ball in the hand" : "waiting for the robot, whose hand holds the ball";
    default:
      return "shows nothing";
  }
}

}  // namespace multireach
