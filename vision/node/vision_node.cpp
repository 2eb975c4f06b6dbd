#include "vision/node/vision_node.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>
#include <multireach/debug_request_t.hpp>
#include <utility>

#include "runtime/channels.hpp"
#include "runtime/time_line.hpp"
#include "vision/reported_covariance.hpp"

namespace multireach {
namespace {

using vision::StereoMatch;
using Status = vision::TargetTrack::Status;

constexpr std::array kSides{Side::kLeft, Side::kRight};
constexpr int64_t kPicturesFor = 2000000;  // us, how long one request sends debug pictures
/// At most about ten debug pictures a second, microseconds: people look at them, and each delays the next pair.
constexpr int64_t kPicturePeriod = 95000;
constexpr int64_t kMovesFor = 2000000;  // us after a camera's last motion that its state says so
constexpr double kMovedPx = 2;          // least shift of an image that is said afterwards

/// `calibrated`: whether the camera pose is known. Without it, nothing may be done with a position that is only
/// expected.
int8_t wire_status(const vision::TargetReport& report, bool calibrated) {
  if (report.ambiguous) return target_t::STATUS_AMBIGUOUS;
  switch (report.status) {
    case Status::kTracked:
      return calibrated ? target_t::STATUS_TRACKED : target_t::STATUS_UNCALIBRATED;
    case Status::kCoasting:
      return calibrated ? target_t::STATUS_COASTING : target_t::STATUS_LOST;
    case Status::kLost:
      break;
  }
  return target_t::STATUS_LOST;
}

const char* word_for(int8_t status) {
  switch (status) {
    case target_t::STATUS_TRACKED:
      return "tracked";
    case target_t::STATUS_COASTING:
      return "coasting";
    case target_t::STATUS_UNCALIBRATED:
      return "uncalibrated";
    case target_t::STATUS_AMBIGUOUS:
      return "ambiguous";
    default:
      return "lost";
  }
}

void put(double (&field)[3], const Eigen::Vector3d& vector) {
  std::copy_n(vector.data(), 3, field);
}

void put(double (&field)[3][3], const Eigen::Matrix3d& matrix) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rows(&field[0][0]);
  rows = matrix;
}

std::optional<vision::StereoVision> coloured_targets(const VisionConfig& config) {
  std::vector<vision::TrackerOptions> options;
  for (const VisionConfig::Target& target : config.targets) options.push_back(target.options);
  return options.empty() ? std::nullopt : std::optional(vision::StereoVision(options));
}

std::vector<vision::TagOptions> tags_of(const VisionConfig& config) {
  std::vector<vision::TagOptions> options;
  for (const VisionConfig::Tag& tag : config.tags) options.push_back(tag.options);
  return options;
}

/// The images of a message, for the stage: decoded with the node's codecs, concurrently where it has two threads.
class MessageImages final : public vision::StereoImages {
 public:
  MessageImages(StereoFrames& frames, std::array<ImageCodec, 2>& codecs, bool side_by_side)
      : frames_(frames), codecs_(codecs), side_by_side_(side_by_side) {}
  vision::PairTimes times() const override {
    return {frames_.utime(), frames_.frame_utime(Side::kLeft), frames_.frame_utime(Side::kRight)};
  }
  bool has(Side side, const cv::Size& size) const override { return frames_.has(side, size.width, size.height); }
  int64_t fingerprint(Side side) const override { return frames_.fingerprint(side); }
  const cv::Mat* pixels(Side side, const cv::Rect& part) override {
    return frames_.pixels(side, part, codecs_[index(side)]);
  }
  bool chroma_subsampled(Side side) const override { return frames_.chroma_subsampled(side); }
  void for_both_sides(const std::function<void(Side)>& work) override {
    const auto policy = side_by_side_ ? std::launch::async : std::launch::deferred;
    auto right = std::async(policy, [&] { work(Side::kRight); });
    work(Side::kLeft);
    right.get();
  }

 private:
  StereoFrames& frames_;
  std::array<ImageCodec, 2>& codecs_;
  bool side_by_side_;
};

}  // namespace

VisionNode::VisionNode(const VisionConfig& config, int threads)
    : config_(config),
      vision_(coloured_targets(config)),
      tags_(tags_of(config)),
      last_(config.targets.size() + config.tags.size()),
      side_by_side_(threads > 1) {}

std::vector<std::string_view> VisionNode::inputs() const {
  return {channel::kStereoImages, channel::kVisionDebugRequest};
}

std::optional<int64_t> VisionNode::newest_utime() const {
  return vision_ ? vision_->newest_utime() : tags_.newest_utime();
}

/// What the messages of all kinds of targets have in common.
target_t VisionNode::target_message(size_t k, const StereoFrames& frames, const vision::TargetReport& report) {
  target_t message{};
  message.utime = frames.utime();
  message.sequence = sequence_++;
  message.run = run();
  message.left_frame_utime = frames.frame_utime(Side::kLeft);
  message.right_frame_utime = frames.frame_utime(Side::kRight);
  message.pair_sequence = frames.pair_sequence();
  message.last_seen_utime = report.last_seen_utime.value_or(-1);
  message.status = wire_status(report, config_.calibrated);
  const size_t coloured = config_.targets.size();
  message.name = k < coloured ? config_.targets[k].name : config_.tags[k - coloured].name;
  const bool uncalibrated = message.status == target_t::STATUS_UNCALIBRATED;
  message.reason = uncalibrated ? "seen; the camera pose is unknown" : report.reason;
  put(message.position_m, report.estimate.position);
  put(message.covariance_m2, report.estimate.covariance);
  if (message.status != target_t::STATUS_LOST && !report.ambiguous) {
    put(message.velocity_m_s, report.velocity);
    put(message.velocity_covariance_m2_s2, report.velocity_covariance);
  }
  return message;
}

target_t VisionNode::coloured_target_message(size_t k, const StereoFrames& frames, const char* fault) {
  const vision::StereoVision::Target& target = vision_->targets()[k];
  target_t message = target_message(k, frames, target.report);
  if (!fault) {
    Eigen::Map<Eigen::Vector2d>(message.left_px) = target.match.left_px;
    Eigen::Map<Eigen::Vector2d>(message.right_px) = target.match.right_px;
    message.epipolar_error_px = target.match.point.epipolar_error_px;
    message.occlusion = target.match.occlusion;
  }
  return message;
}

target_t VisionNode::tag_message(size_t k, const StereoFrames& frames, const char* fault) {
  const vision::TagVision::Target& tag = tags_.targets()[k];
  target_t message = target_message(config_.targets.size() + k, frames, tag.report);
  if (tag.report.R_WT) {
    const Eigen::Quaterniond& q = *tag.report.R_WT;
    message.has_orientation = true;
    std::ranges::copy(std::array{q.w(), q.x(), q.y(), q.z()}, message.orientation_wxyz);
  }
  if (!fault) {
    Eigen::Map<Eigen::Vector2d>(message.left_px) = tag.match.centre_px[0];
    Eigen::Map<Eigen::Vector2d>(message.right_px) = tag.match.centre_px[1];
    message.epipolar_error_px = tag.match.epipolar_error_px;
  }
  return message;
}

/// The candidates of a target; nothing where there is no more than the one that was chosen.
std::optional<target_candidates_t> VisionNode::candidates_message(size_t k) const {
  const std::vector<vision::Candidate>& candidates = vision_->targets()[k].candidates;
  if (candidates.empty() || (candidates.size() == 1 && candidates.front().chosen)) return std::nullopt;
  target_candidates_t message{};
  message.utime = last_[k].utime;
  message.sequence = last_[k].sequence;
  message.run = last_[k].run;
  message.name = last_[k].name;
  for (const vision::Candidate& candidate : candidates) {
    using Evidence = vision::Evidence;
    target_candidate_t& sent = message.candidates.emplace_back();
    const vision::PositionEstimate estimate{candidate.match.point.p_W, candidate.match.covariance()};
    put(sent.position_m, estimate.position);
    put(sent.covariance_m2, vision::reported_covariance(config_.rig, estimate));
    Eigen::Map<Eigen::Vector2d>(sent.left_px) = candidate.match.left_px;
    Eigen::Map<Eigen::Vector2d>(sent.right_px) = candidate.match.right_px;
    sent.score = candidate.evidence.sum();
    sent.still_score = candidate.evidence.term[Evidence::kStill];
    sent.round_score = candidate.evidence.term[Evidence::kRound];
    sent.colour_score = candidate.evidence.term[Evidence::kColour];
    sent.stereo_score = candidate.evidence.term[Evidence::kStereo];
    sent.size_score = candidate.evidence.term[Evidence::kSize];
    sent.history_score = candidate.evidence.term[Evidence::kHistory];
    sent.chosen = candidate.chosen;
    sent.reason = candidate.reason;
  }
  message.num_candidates = static_cast<int32_t>(message.candidates.size());
  return message;
}

tracker_state_t VisionNode::tracker_state_message(size_t k) const {
  const size_t coloured = config_.targets.size();
  tracker_state_t state{};
  state.utime = last_[k].utime;
  state.sequence = last_[k].sequence;
  state.value = k < coloured ? vision_->serialize(k, last_[k].utime) : tags_.serialize(k - coloured, last_[k].utime);
  state.num_values = static_cast<int32_t>(state.value.size());
  return state;
}

bool VisionNode::restore_from_outputs(const std::vector<std::span<const uint8_t>>& outputs) {
  std::vector<tracker_state_t> messages;
  std::vector<std::span<const double>> coloured, tags;
  if (outputs.size() != last_.size()) return false;
  for (const std::span<const uint8_t> bytes : outputs) {
    auto message = decode<tracker_state_t>(bytes);
    if (!message || message->sequence != sequence_ + static_cast<int64_t>(messages.size())) return false;
    messages.push_back(std::move(*message));
    if (messages.back().utime != messages.front().utime || !plausible_utime(messages.back().utime)) return false;
  }
  for (const tracker_state_t& message : messages)
    (coloured.size() < config_.targets.size() ? coloured : tags).emplace_back(message.value);
  const int64_t utime = messages.front().utime;
  std::optional<vision::StereoVision> restored = vision_;
  if (restored && !restored->deserialize(utime, coloured)) return false;
  if (!tags_.deserialize(utime, tags)) return false;
  vision_ = std::move(restored);
  sequence_ += sent_per_input();
  return true;
}

Receipt VisionNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel == channel::kVisionDebugRequest) {
    // Not counted as received: it tells nothing about the cameras.
    const auto request = decode<debug_request_t>(bytes);
    if (request) picture_of_ = request->name;
    counters_.refused += request ? 0 : 1;
    return {};
  }
  if (channel != channel::kStereoImages) throw unknown_input(channel);
  StereoFrames frames(bytes);
  for (const Side side : kSides) frames.set_buffer(side, buffers_[index(side)]);
  const Receipt receipt = process(frames, out);
  for (const Side side : kSides) buffers_[index(side)] = frames.buffer(side);
  return receipt;
}

/// A vision that is slower than its cameras sees what is now, not what was before a queue.
bool VisionNode::takes_newest(std::string_view channel) const {
  return channel == channel::kStereoImages;
}

void VisionNode::leave_out(std::string_view channel, std::span<const uint8_t> bytes) {
  Node::leave_out(channel, bytes);
  const StereoFrames frames(bytes);  // it has not been lost on its way
  if (frames.is_valid() && frames.pair_sequence() >= 0) counters_.dropped += pairs_.newly_lost(frames.pair_sequence());
}

Receipt VisionNode::process(StereoFrames& frames, Outbox& out) {
  ++(frames.is_valid() ? counters_.received : counters_.refused);
  if (!frames.is_valid()) return {};
  if (!plausible_utime(frames.utime())) {
    ++counters_.refused;
    return {};
  }
  MessageImages images(frames, codecs_, side_by_side_);
  const auto newest = newest_utime();
  if (newest && starts_again(frames.utime(), *newest)) {
    if (vision_) vision_->restart();
    tags_.restart();
  }
  const char* fault = vision_ ? vision_->update(images) : nullptr;
  const char* tag_fault = tags_.update(images);
  if (fault || tag_fault) ++counters_.refused;
  const size_t coloured = config_.targets.size();
  for (size_t k = 0; k < last_.size(); ++k) {
    last_[k] = k < coloured ? coloured_target_message(k, frames, fault) : tag_message(k - coloured, frames, tag_fault);
    send(out, channel::kTarget, last_[k]);
    send(out, channel::kTrackerState, tracker_state_message(k));
    if (k >= coloured || fault) continue;
    if (const auto candidates = candidates_message(k)) send(out, channel::kTargetCandidates, *candidates);
  }
  if (frames.pair_sequence() >= 0) counters_.dropped += pairs_.newly_lost(frames.pair_sequence());
  send_debug_picture(frames, out);
  return {Receipt::Effect::kConsumed, frames.utime(), frames.pair_sequence()};
}

/// What the debug picture shows of a target, apart from its colour.
vision::DebugMarks VisionNode::marks_of(size_t k) const {
  const target_t& last = last_[k];
  vision::DebugMarks marks{fmt::format("{} {}: {}", last.name, word_for(last.status), last.reason), {}, {}};
  const size_t coloured = config_.targets.size();
  for (size_t side = 0; side < 2; ++side) {
    vision::DebugMarks::OneSide& shown = marks.sides[side];
    if (k < coloured) {
      const vision::StereoVision::Target& target = vision_->targets()[k];
      shown.window = target.views[side].window;
      const int chosen = side == 0 ? target.match.left : target.match.right;
      for (size_t at = 0; at < target.views[side].contours.size(); ++at) {
        const vision::SphereContour& contour = target.views[side].contours[at];
        shown.contours.push_back({contour.centre_px, contour.radius_px, static_cast<int>(at) == chosen});
      }
    } else {
      const vision::TagVision::Target& tag = tags_.targets()[k - coloured];
      shown.window = tag.views[side].window;
      for (const vision::FoundTag& found : tag.views[side].matches) shown.outlines.push_back(found.corners);
    }
  }
  return marks;
}

void VisionNode::send_debug_picture(StereoFrames& frames, Outbox& out) {
  if (picture_of_) {
    pictures_until_ = frames.utime() + kPicturesFor;
    shown_ = *std::exchange(picture_of_, std::nullopt);
  }
  // The time may also jump back, when a log is played again.
  if (frames.utime() > pictures_until_ || frames.utime() < pictures_until_ - kPicturesFor) return;
  if (frames.utime() >= pictured_ && frames.utime() < pictured_ + kPicturePeriod) return;
  pictured_ = frames.utime();
  std::array<cv::Mat, 2> images;
  for (const Side side : kSides) {
    const auto at = index(side);
    const CameraModel& camera = config_.rig.camera(side);
    const cv::Rect whole(0, 0, camera.width, camera.height);
    const bool fits = frames.has(side, whole.width, whole.height);
    const cv::Mat* bgr = fits ? frames.pixels(side, whole, codecs_[at]) : nullptr;
    images[at] = bgr ? *bgr : cv::Mat(whole.size(), CV_8UC3, cv::Scalar(0, 0, 0));
  }
  static const std::array kColours{cv::Scalar(0, 255, 0), cv::Scalar(255, 255, 0), cv::Scalar(0, 200, 255),
                                   cv::Scalar(255, 120, 255)};
  std::vector<vision::DebugMarks> marks;
  for (size_t at = 0; at < last_.size(); ++at) {
    if (!shown_.empty() && last_[at].name != shown_) continue;
    vision::DebugMarks mark = marks_of(at);
    mark.colour = kColours[marks.size() % kColours.size()];
    marks.push_back(std::move(mark));
  }
  const cv::Mat picture = vision::debug_picture(images[0], images[1], marks);
  constexpr int kQuality = 80;
  images_t message;
  message.utime = frames.utime();
  message.n_images = 1;
  message.image_types = {images_t::LEFT};
  image_t& image = message.images.emplace_back();
  image.utime = frames.utime();
  image.width = picture.cols;
  image.height = picture.rows;
  image.row_stride = 0;
  image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
  image.data = codecs_[0].encode_jpeg(picture, kQuality);
  image.size = static_cast<int32_t>(image.data.size());
  image.nmetadata = 0;
  send(out, channel::kVisionDebug, message);
}

/// What the images of many pairs say of the cameras, each after a semicolon.
std::string VisionNode::remarks() const {
  std::string text;
  if (tags_.both_images_repeat() || (vision_ && vision_->both_images_repeat()))
    text += "; both cameras repeat the same images: a still picture, or both are frozen";
  if (!vision_) return text;
  for (const Side side : kSides) {
    // The target for which the largest part of the image is searched sees most of the scene.
    const auto area = [&](const auto& target) { return target.tracker.search_area(side).area(); };
    const auto widest = std::ranges::max_element(vision_->targets(), {}, area);
    const auto& [last, total_px] = widest->tracker.camera_shift(side);
    const char* name = side == Side::kLeft ? "left" : "right";
    if (last && last_.front().utime - *last < kMovesFor) {
      text += fmt::format("; the {} camera moves", name);
    } else if (last && vision::CameraMotion::size_px(total_px) > kMovedPx) {
      text += fmt::format("; the {} camera has moved by about {:.0f} px: find the cameras' pose again", name,
                          vision::CameraMotion::size_px(total_px));
    }
  }
  for (const vision::StereoVision::Target& target : vision_->targets()) {
    const auto [rows_px, size_share] = target.tracker.calibration_disagreement();
    const std::string& of = last_[static_cast<size_t>(&target - vision_->targets().data())].name;
    if (rows_px)
      text += fmt::format("; the rows of {} differ by {:.1f} px between the images: calibrate again", of,
                          std::abs(*rows_px));
    if (size_share)
      text += fmt::format("; {} looks {:.0f} % {} than its ball_radius_m: check it, or calibrate again", of,
                          100 * std::abs(*size_share), *size_share > 0 ? "larger" : "smaller");
  }
  return text;
}

std::string VisionNode::state() const {
  if (last_.front().utime == 0) return "waiting";
  std::string text;
  for (const target_t& last : last_) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{} {}", last.name, word_for(last.status));
    if (last.status != target_t::STATUS_TRACKED) text += ": " + last.reason;
  }
  return text + remarks();
}

}  // namespace multireach
